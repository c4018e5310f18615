/* gain_measure.h: runs every variant with every seed on one scene, for equal CPU time, and sums up.
 *
 * Runs are interleaved over the variants within each seed, each seed beginning with another variant, so that a busy
 * moment of the machine does not meet one of them alone. Each run has one thread; `threads` runs go on at a time.
 */
#ifndef TESTS_BENCH_GAIN_MEASURE_H
#define TESTS_BENCH_GAIN_MEASURE_H

#include "gain_data.h"
#include "gain_reference.h"

enum { GAIN_MAX_SEEDS = 1000 };

typedef struct gain_options {
    const gain_variants_t *variants;
    uint32_t width;
    double seconds; /* CPU, of a run */
    size_t points;  /* times it is looked at: seconds, seconds / 2, seconds / 4 ... */
    uint64_t first_seed;
    unsigned seeds, threads;
} gain_options_t;

/* Fills *out, which the caller clears. A variant that this build does not know, or a run that fails, is an entry
 * with the reason; a fault is what concerns all of them. */
fault_code_t gain_measure(gain_scene_t *out, const peer_loaded_t *loaded, const gain_reference_t *reference,
                          const gain_options_t *options, fault_t *fault);

#endif
