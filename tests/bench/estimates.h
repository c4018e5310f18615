/* estimates.h: what a render says about its own error, held against a reference over many seeds: docs/accuracy.md.
 *
 *     TRY(estimates_reference(&reference, &scene, &reference_job, threads, fault));
 *     TRY(estimates_measure(&found, &scene, &job, seeds, threads, &reference, fault));
 *     ... found.ratio, found.covered ...
 *     estimates_reference_clear(&reference);
 *
 * Both renders of a reference are independent of each other: the mean over pixels of (I - A) (I - B) knows nothing
 * of their noise (film/compare.h). */
#ifndef TESTS_BENCH_ESTIMATES_H
#define TESTS_BENCH_ESTIMATES_H

#include "plan/plan.h"
#include "plan/plan_estimate.h"
#include "plan/plan_regions.h"
#include "plan/plan_state.h"

enum { ESTIMATES_MAX_SEEDS = 1000 };
#define ESTIMATES_OFF 1.5

typedef struct estimates_reference {
    image_t images[2];
    double luminance[PLAN_REGIONS], standard_error[PLAN_REGIONS];
} estimates_reference_t;

/* A number and its standard error. */
typedef struct estimates_figure {
    double value, error;
} estimates_figure_t;

typedef struct estimates {
    unsigned seeds;
    double relmse;             /* the true one: mean over the seeds */
    double estimate;           /* the renders' own, likewise */
    estimates_figure_t ratio;  /* the one over the other, by the delta method */
    estimates_figure_t inside; /* part of renders whose error.interval holds their own relMSE */
    double interval;           /* half width of error.interval, as a factor: geometric mean */
    /* Renders by what they say of themselves, error.reliable: how many, and how many of those have an estimate that
     * is off by a factor of more than ESTIMATES_OFF from their own relMSE. */
    unsigned reliable, reliable_off, unreliable, unreliable_off;
    /* Part of regions over all renders whose interval holds the reference; by the spread between renders, as one
     * render's regions hang together. */
    estimates_figure_t covered;
    double wide; /* mean half width of these intervals, relative to the region */
    double cpu_seconds;
} estimates_t;

/* Two renders of the job with the seeds that follow on 2^32: no others are near them. */
fault_code_t estimates_reference(estimates_reference_t *reference, const scene_t *scene, const job_t *job,
                                 unsigned threads, fault_t *fault);
void estimates_reference_clear(estimates_reference_t *reference);

/* Renders the job with seeds 1 to `seeds`. */
fault_code_t estimates_measure(estimates_t *found, const scene_t *scene, const job_t *job, unsigned seeds,
                               unsigned threads, const estimates_reference_t *reference, fault_t *fault);

#endif
