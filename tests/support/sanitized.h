/* sanitized.h: whether this program runs under a sanitizer, which makes it several times slower. Statistics over
 * long runs find nothing there that they do not find without: such a test begins with
 *
 *     if (SANITIZED)
 *         skip();
 */
#ifndef TESTS_SUPPORT_SANITIZED_H
#define TESTS_SUPPORT_SANITIZED_H

#ifdef __has_feature /* clang */
#define SANITIZED_BY(name) __has_feature(name)
#else
#define SANITIZED_BY(name) 0
#endif

#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__ || SANITIZED_BY(address_sanitizer) ||              \
    SANITIZED_BY(thread_sanitizer)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

#endif
