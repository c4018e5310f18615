/* rate_case.h: one scene and algorithm of bench_rate: a fixed stretch of work that can be run again and again, so
 * that repetitions differ by the machine's noise alone.
 *
 * The work is one unit of each kind and length that the plan hands out (chains of each length, samples that refine
 * b_k; or samples), each cut to its part of the whole. The pilot is not part of it, nor are the feature layers.
 */
#ifndef TESTS_BENCH_RATE_CASE_H
#define TESTS_BENCH_RATE_CASE_H

#include "peer_scene.h"
#include "plan/plan.h"
#include "rays.h"

enum { RATE_MAX_RECORDS = 80 };

typedef struct rate_case {
    const peer_scene_t *entry;
    settings_algorithm_t algorithm;
    renderer_t *renderer;
    work_space_t *space;
    work_record_t records[RATE_MAX_RECORDS]; /* seeds owned */
    uint32_t record_count;
    double mutations;   /* of all records, or samples */
    double rays;        /* of all records, as the renderer counts them */
    double watch_part;  /* of the work: what is recorded, and timed ray by ray */
    rays_log_t log;     /* of that part */
    double merge_share; /* CPU seconds of encoding, decoding, adding units of real size, over those of their run */
    double unit_bytes;  /* that such a unit comes to on the wire */
    size_t renderer_bytes, film_bytes;
} rate_case_t;

/* One repetition. */
typedef struct rate_figures {
    double mutations_per_second; /* of the thread's CPU time, in millions */
    double rays_per_second;
    double raw_rays_per_second; /* of the recorded rays, traced again and nothing else */
    double share;               /* of the time inside Embree: rays x raw time of a ray / CPU time */
    double share_timed;         /* the same by the time stamp counter around each call, on a part of the work */
} rate_figures_t;

/* Plans the work, records rays, measures what is measured once. `work` is in mutations, or samples. The scene is
 * borrowed for the case's life. */
fault_code_t rate_case_init(rate_case_t *rate, const peer_loaded_t *loaded, settings_algorithm_t algorithm,
                            double work, fault_t *fault);
void rate_case_clear(rate_case_t *rate);

fault_code_t rate_case_run(const rate_case_t *rate, rate_figures_t *figures, fault_t *fault);
/* Runs the work on so many threads at once, each its own chains; seconds of wall time and CPU seconds of all. */
fault_code_t rate_case_threads(const rate_case_t *rate, unsigned threads, double *wall, double *cpu,
                               fault_t *fault);

#endif
