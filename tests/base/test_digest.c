#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <string.h>

#include "base/digest.h"

static void known_digests_come_out(void **state)
{
    (void)state;
    /* BLAKE2b with 32 bytes of output, as Python's hashlib.blake2b(data, digest_size=32) gives it. */
    static const struct {
        const char *data, *digest;
    } known[] = {
        {"", "0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8"},
        {"abc", "bddd813c634239723171ef3fee98579b94964e3bb1cb3e427262c8c068d52319"},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        digest_t digest;
        char text[DIGEST_TEXT_SIZE];
        digest_of(&digest, known[i].data, strlen(known[i].data));
        digest_print(&digest, text);
        assert_string_equal(text, known[i].digest);
    }
}

static void text_reads_back_in_either_case(void **state)
{
    (void)state;
    digest_t digest, back;
    char text[DIGEST_TEXT_SIZE];
    digest_of(&digest, "garland", 7);
    digest_print(&digest, text);
    assert_true(digest_parse(&back, text));
    assert_true(digest_equal(&digest, &back));
    for (char *p = text; *p; p++)
        *p = *p >= 'a' ? (char)(*p - 'a' + 'A') : *p;
    assert_true(digest_parse(&back, text));
    assert_true(digest_equal(&digest, &back));
    back.bytes[31] ^= 1;
    assert_false(digest_equal(&digest, &back));
}

static void other_texts_are_refused(void **state)
{
    (void)state;
    digest_t digest;
    char text[DIGEST_TEXT_SIZE + 1];
    assert_false(digest_parse(&digest, ""));
    for (size_t length = 1; length <= 65; length++) {
        memset(text, 'a', length);
        text[length] = '\0';
        assert_int_equal(digest_parse(&digest, text), length == 64);
    }
    static const char wrong[] = {'g', 'G', '/', ':', '@', '`', ' ', '\x80'};
    for (size_t at = 0; at < 64; at++) {
        for (size_t i = 0; i < sizeof wrong; i++) {
            memset(text, '0', 64);
            text[64] = '\0';
            text[at] = wrong[i];
            assert_false(digest_parse(&digest, text));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_digests_come_out),
        cmocka_unit_test(text_reads_back_in_either_case),
        cmocka_unit_test(other_texts_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
