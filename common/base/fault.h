/* fault.h: what went wrong, in a word for the program and a sentence for the person.
 *
 * Functions that can fail return a fault_code_t (0 is success) and describe the failure in the caller's fault_t.
 * The sentence names the place (file, line, field path), what was found and what was expected.
 *
 *     fault_t fault = {0};
 *     if (bundle_open(&bundle, path, &fault)) {
 *         fprintf(stderr, "garland: %s\n", fault.text);
 *     }
 *
 * Thread rule: a fault_t belongs to one caller; there is no global state.
 */
#ifndef BASE_FAULT_H
#define BASE_FAULT_H

#define FAULT_CODES(X)                                                                                             \
    X(FAULT_NONE, "no fault")                                                                                      \
    X(FAULT_MEMORY, "out of memory")                                                                               \
    X(FAULT_IO, "input or output failed")                                                                          \
    X(FAULT_NOT_FOUND, "not found")                                                                                \
    X(FAULT_SYNTAX, "syntax error")                                                                                \
    X(FAULT_FORMAT, "malformed data")                                                                              \
    X(FAULT_RANGE, "value out of range")                                                                           \
    X(FAULT_TYPE, "value of the wrong type")                                                                       \
    X(FAULT_UNKNOWN, "unknown name")                                                                               \
    X(FAULT_VERSION, "incompatible version")                                                                       \
    X(FAULT_LIMIT, "limit exceeded")                                                                               \
    X(FAULT_UNSUPPORTED, "not supported")                                                                          \
    X(FAULT_NO_LIGHT, "no light reaches the camera")                                                               \
    X(FAULT_PROTOCOL, "protocol violated")                                                                         \
    X(FAULT_TIMEOUT, "timed out")                                                                                  \
    X(FAULT_CANCELLED, "cancelled")                                                                                \
    X(FAULT_USAGE, "wrong usage")

typedef enum fault_code {
#define FAULT_ENUM(name, text) name,
    FAULT_CODES(FAULT_ENUM)
#undef FAULT_ENUM
        FAULT_COUNT
} fault_code_t;

enum { FAULT_TEXT_SIZE = 1024 };

typedef struct fault {
    fault_code_t code;
    char text[FAULT_TEXT_SIZE];
} fault_t;

/* Fills fault (which may be null) and returns code, so that `return fault_set(...)` reads as a sentence. */
fault_code_t fault_set(fault_t *fault, fault_code_t code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Puts "prefix: " before the text that is there, the outer place before the inner one, if code is a failure and
 * fault is not null. Returns code, so that `return fault_prefix(fault, inner(..., fault), ...)` passes both on. */
fault_code_t fault_prefix(fault_t *fault, fault_code_t code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The code's short text; static storage. */
const char *fault_code_text(fault_code_t code);

/* Returns from the calling function with the code of a failed call. Where something must be released, use a
 * `cleanup:` label instead. */
#define TRY(expr)                                                                                                  \
    do {                                                                                                           \
        const fault_code_t try_code_ = (expr);                                                                     \
        if (try_code_ != FAULT_NONE)                                                                               \
            return try_code_;                                                                                      \
    } while (0)

#endif
