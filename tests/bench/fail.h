/* fail.h: how benches end when something went wrong. */
#ifndef TESTS_BENCH_FAIL_H
#define TESTS_BENCH_FAIL_H

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/fault.h"

/* Says the program's name and the fault; ends with status 1. */
__attribute__((noreturn)) static inline void bench_fail(const fault_t *fault)
{
    fprintf(stderr, "%s: %s\n", program_invocation_short_name, fault->text);
    exit(1);
}

#endif
