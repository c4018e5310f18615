/* support.h: what the film tests share: cmocka, a folder of their own, random images. */
#ifndef TESTS_FILM_SUPPORT_H
#define TESTS_FILM_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <math.h>

#include "base/fault.h"
#include "base/random.h"
#include "film/image.h"
#include "support/near.h"

#define assert_ok(expr)                                                                                            \
    do {                                                                                                           \
        fault_t ok_fault = {0};                                                                                    \
        fault_t *fault = &ok_fault;                                                                                \
        if ((expr) != FAULT_NONE)                                                                                  \
            fail_msg("%s: %s", #expr, ok_fault.text);                                                              \
    } while (0)

/* The call must fail with this code and a text that holds this piece. */
#define assert_fault(expected, piece, expr)                                                                        \
    do {                                                                                                           \
        fault_t bad_fault = {0};                                                                                   \
        fault_t *fault = &bad_fault;                                                                               \
        const fault_code_t found = (expr);                                                                         \
        if (found != (expected) || bad_fault.code != (expected) || !strstr(bad_fault.text, piece))                 \
            fail_msg("%s: found '%s' (%s), expected '%s' with \"%s\"", #expr, fault_code_text(found),              \
                     bad_fault.text, fault_code_text(expected), piece);                                            \
    } while (0)

typedef struct scratch {
    char folder[64], path[128];
} scratch_t;

static inline void scratch_open(scratch_t *scratch, const char *name)
{
    strcpy(scratch->folder, "/tmp/garland-test-XXXXXX");
    assert_non_null(mkdtemp(scratch->folder));
    snprintf(scratch->path, sizeof scratch->path, "%s/%s", scratch->folder, name);
}

static inline void scratch_close(scratch_t *scratch)
{
    unlink(scratch->path);
    assert_int_equal(rmdir(scratch->folder), 0); /* and nothing else was left there */
}

/* Uniform in [0,1), a function of the test's stream and the index. */
static inline double uniform(uint64_t stream, uint64_t index)
{
    return random_double(random_key(20, RANDOM_PURPOSE_TEST, stream, index), 0);
}

#endif
