/* runner.h: a pool of threads that run units. Units go in, outcomes come out: exactly one for each unit, in the
 * order in which they end.
 *
 *     TRY(runner_new(&runner, &(runner_options_t){.threads = 8}, &engine, fault));
 *     TRY(runner_submit(runner, &unit, fault));
 *     ... when runner_wake_fd is readable:
 *     while (runner_take(runner, &outcome))
 *         ...
 *
 * A thread keeps its workspace from unit to unit of one source, and takes such units first. A source's scene is
 * opened by the first thread that needs it, while the others wait or run other units. Scenes that nobody uses stay
 * open, up to a number; the one longest unused goes first.
 *
 * Thread rule: the functions below are for one thread, the session's.
 */
#ifndef WORKER_RUNNER_H
#define WORKER_RUNNER_H

#include "proto/message.h"
#include "worker/engine.h"

typedef struct runner runner_t;

enum { RUNNER_MAX_THREADS = 1024, RUNNER_OPEN_SCENES = 4 };

typedef struct runner_options {
    unsigned threads;     /* 1 to RUNNER_MAX_THREADS */
    unsigned open_scenes; /* kept open though unused; 0: RUNNER_OPEN_SCENES */
} runner_options_t;

typedef struct runner_unit {
    message_lease_t lease;
    source_t *source;       /* shared by runner_submit */
    message_bytes_t record; /* copied */
} runner_unit_t;

typedef struct runner_outcome {
    message_lease_t lease;
    uint8_t *result; /* the taker's to free(); null after a fault */
    size_t size;
    fault_t fault; /* FAULT_CANCELLED: by runner_cancel */
} runner_outcome_t;

fault_code_t runner_new(runner_t **out, const runner_options_t *options, const engine_t *engine, fault_t *fault);
/* Cancels everything, waits for the threads. */
void runner_destroy(runner_t **runner);

fault_code_t runner_submit(runner_t *runner, const runner_unit_t *unit, fault_t *fault);
/* All units of a job end soon, with FAULT_CANCELLED unless they had ended. */
void runner_cancel(runner_t *runner, uint64_t job);
/* The next outcome; false: none. */
bool runner_take(runner_t *runner, runner_outcome_t *outcome);
/* Readable while there may be outcomes; runner_take clears it. */
int runner_wake_fd(const runner_t *runner);
unsigned runner_threads(const runner_t *runner);
unsigned runner_open_scenes(runner_t *runner); /* open now, used or not */

#endif
