/* pool.h: tasks, each in a process of its own (a fork of this one, so that what is loaded is shared), a few at a
 * time. Children die with this process, have process groups of their own (Ctrl-C goes to the parent alone), end
 * after a time limit, and are signalled by their process ids only.
 *
 * The calling process must have one thread. */
#ifndef CLIENT_BENCH_POOL_H
#define CLIENT_BENCH_POOL_H

#include <stdbool.h>
#include <stddef.h>

#include "base/fault.h"

enum { POOL_MOST = 256 };

/* In the child, which ends afterwards; a fault's text reaches pool_done_t. */
typedef fault_code_t pool_work_t(void *user, size_t task, fault_t *fault);
/* In this process, in the order tasks end. failure: why it did not succeed; null: it did. */
typedef void pool_done_t(void *user, size_t task, const char *failure);

typedef struct pool_options {
    int workers;          /* at a time, 1 to POOL_MOST */
    double limit_seconds; /* of wall time for a task */
    bool (*stop)(void); /* asked all the time: true ends all children and the pool, FAULT_CANCELLED; may be null */
} pool_options_t;

/* Tasks are started in order. */
fault_code_t pool_run(size_t tasks, pool_work_t *work, pool_done_t *done, void *user, const pool_options_t *options,
                      fault_t *fault);

#endif
