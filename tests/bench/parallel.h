/* parallel.h: a whole job in this process on several threads that share one plan: what a master and its workers
 * do, without sockets. For benches and tests.
 *
 *     parallel_run_t run;
 *     TRY(parallel_render(&run, &scene, &job, 2, fault));
 *     ... run.image, run.cpu_seconds ...
 *     parallel_clear(&run);
 */
#ifndef TESTS_BENCH_PARALLEL_H
#define TESTS_BENCH_PARALLEL_H

#include "plan/plan.h"

enum { PARALLEL_MAX_THREADS = 64 };

typedef struct parallel_run {
    image_t image;
    json_t *report;
    double wall_seconds;  /* from before the acceleration structure is built to the last unit */
    double cpu_seconds;   /* of all threads, merging included */
    double merge_seconds; /* of them in the plan: handing out, decoding, adding, stop rules */
    double mutations;     /* merged, or samples */
} parallel_run_t;

/* Renders until the job's stop rule is met; what is under way then is given up. */
fault_code_t parallel_render(parallel_run_t *run, const scene_t *scene, const job_t *job, unsigned threads,
                             fault_t *fault);
void parallel_clear(parallel_run_t *run);

/* Renders the job with seeds first .. first + count - 1, each on one thread, `threads` of them at a time. Images
 * come out in the order of the seeds, whatever the threads do; the caller clears each. */
fault_code_t parallel_seeds(image_t *images, const scene_t *scene, const job_t *job, uint64_t first, unsigned count,
                            unsigned threads, fault_t *fault);

#endif
