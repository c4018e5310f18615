/* plan_length.h: what a plan knows of one path length: sums over its units, free of their order, and the same as
 * bytes.
 *
 * One thread at a time, as all of a plan. */
#ifndef PLAN_PLAN_LENGTH_H
#define PLAN_PLAN_LENGTH_H

#include "chain/work.h"
#include "path/walk.h"
#include "stats/exact.h"

/* Sums of one estimator over units, free of order: of 1, in units of `unit` and its square. */
typedef struct plan_moments {
    exact_sum_t n, sum, sum2;
} plan_moments_t;

/* How the chains of a length step: powers of two, as in work_record_t. */
typedef struct plan_steps {
    int32_t steps, large;
} plan_steps_t;

/* One path length; [0]: samples or chains of all of them at once. */
typedef struct plan_length {
    /* pilot */
    double *weights; /* of the candidates; after the pilot their running sum, where chains start from them */
    double b;        /* the pilot's estimate of what chains follow */
    double most;     /* it may be, plan_missed.h */
    double light;    /* and of all light of the length, without importance and cap */
    double need; /* mean over the image's blocks of I_k m / (I^2 + 0.01 m^2): how much the error is in its pixels */
    double inefficiency; /* mutations that do what one independent draw would do; guessed, or by trials */
    double cost;         /* rays of a mutation, likewise */
    uint32_t trials, trial_options, option; /* chains that are tried, with so many kinds of steps; the one taken */
    plan_steps_t steps;                     /* what it is */
    double share;                           /* of the mutations; 0: nothing to render */
    double techniques[PATH_MAX_VERTICES];   /* their shares of b by the pilot, for algorithms that want them */
    /* rendering */
    uint64_t budget; /* mutations in all when the rule is mutations_per_pixel; else UINT64_MAX */
    uint64_t unit_mutations;
    uint64_t early_mutations; /* of each of the first PLAN_EARLY units: smaller ones */
    uint64_t units_out, units_in;
    uint64_t handed, merged; /* mutations */
    uint64_t counted;        /* merged by weight (plan_eras.h), rounded for each unit */
    uint64_t rays;           /* of the units that are in */
    uint64_t chains;         /* ids given out */
    film_t film;
    /* Estimators [0] of b_k, [1 + s] of b_{k,s}: by bidirectional samples (pilot, refinement, pt and bdpt), by the
     * large steps of chains. */
    plan_moments_t samples[PATH_MAX_VERTICES + 1], large_steps[PATH_MAX_VERTICES + 1];
    uint64_t proposed[WORK_MOVES];
    exact_sum_t accepted[WORK_MOVES];
    uint64_t zero_proposals, longest_stay;
    uint64_t stuck_light;                /* as of stuck_t */
    uint64_t failed[WORK_FAILED_BLOCKS]; /* failures = published */
    double cpu_seconds;
} plan_length_t;

/* Of lengths[k], what is neither an array nor follows from the list of units. Layout: f64 b, need, light; u64
 * units in, merged, counted, rays, zero proposals, longest stay, stuck light; f64 CPU seconds; by move u64
 * proposed, accepted (exact.h); u64 failed in every block; k + 1 f64 techniques; for k + 2 estimators those of
 * samples and of large steps: n, sum and sum2 (exact.h). */
void plan_length_put(wire_writer_t *out, const plan_length_t *length, uint32_t k);
/* Hostile bytes; faults are the reader's. */
void plan_length_get(wire_reader_t *in, plan_length_t *length, uint32_t k);

#endif
