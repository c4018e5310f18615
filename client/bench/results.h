/* results.h: what the runs of a bench say together: medians and spreads over the seeds, bias, gains over the first
 * variant with intervals. */
#ifndef CLIENT_BENCH_RESULTS_H
#define CLIENT_BENCH_RESULTS_H

#include "client/bench/run.h"
#include "client/bench/seeds.h"
#include "client/bench/spread.h"

typedef struct results_scene {
    char reference[96];     /* what runs are compared with, in words; empty: with nothing */
    char failure[256];      /* why there are no runs; empty: there are */
    uint32_t width, height; /* pixels */
} results_scene_t;

typedef struct results {
    const matrix_t *matrix;
    results_scene_t scenes[MATRIX_SCENES];
    run_figures_t *runs; /* [scenes][variants][seeds] */
} results_t;

fault_code_t results_new(results_t **out, const matrix_t *matrix, fault_t *fault);
void results_destroy(results_t **results);
run_figures_t *results_run(const results_t *results, size_t scene, size_t variant, size_t seed);

/* One scene, variant and budget; NaN where not known. */
typedef struct results_cell {
    size_t runs; /* that were made */
    spread_t cpu_seconds, mutations, relmse, trimmed, estimate;
    seeds_figure_t bias; /* mean of the ratio of brightness */
    /* mean(relMSE times CPU seconds) of the first variant over this one's: how many times as fast this one gets to
     * an error; an interval of 95 % from the seeds (jackknife of the logarithms, Student). By the estimates where
     * there is no reference. */
    seeds_ratio_t gain;
} results_cell_t;

results_cell_t results_cell(const results_t *results, size_t scene, size_t variant, size_t budget);
/* Why a variant has no runs, or fewer than seeds; null: it has all. */
const char *results_failure(const results_t *results, size_t scene, size_t variant);

/* The error that gains and pictures go by: against the reference, or the render's own estimate. */
double results_error(const results_t *results, size_t scene, const run_point_t *point);
/* Of the runs that were made. */
spread_t results_error_spread(const results_t *results, size_t scene, size_t variant, size_t budget);

#endif
