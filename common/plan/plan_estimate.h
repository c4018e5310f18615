/* plan_estimate.h: estimates from the sums as they stand: of b_k, of pixels and their variances, of the image's
 * error. */
#ifndef PLAN_PLAN_ESTIMATE_H
#define PLAN_PLAN_ESTIMATE_H

#include "plan/plan_state.h"

/* Estimates from all samples and large steps so far, with their standard errors: of b_k (of b for k = 0: that error
 * is the sum of the b_k's, which is the most it can be), of b_{k,s}. */
double plan_length_b(const plan_t *plan, uint32_t k, double *error);
/* What the film of lengths[k] over its mutations is multiplied by, and the error of that. */
double plan_film_b(const plan_t *plan, uint32_t k, double *error);
/* How much of the variance of the estimate of b_k is that of the samples, the rest being the large steps'; 1 where
 * none is known. */
double plan_length_b_by_samples(const plan_t *plan, uint32_t k);
double plan_technique_b(const plan_t *plan, uint32_t k, uint32_t s, double *error);
/* Pixel values and variances: what plan_pixel needs, computed once an image. */
typedef struct plan_pixels {
    const plan_t *plan;
    uint32_t count;                         /* lengths that have been rendered; indices below are less than it */
    uint32_t lengths[PATH_MAX_VERTICES];    /* which */
    const int64_t *sums[PATH_MAX_VERTICES]; /* their films */
    double factor[PATH_MAX_VERTICES];       /* b_k / (N_k 2^28) */
    double excess[PATH_MAX_VERTICES];       /* variance of the image by that of the squares */
    double b_variance[PATH_MAX_VERTICES];   /* (sigma_{b_k} / b_k)^2 factor^2 */
    double square[PATH_MAX_VERTICES];       /* of a sum: what the mean takes off the squares, in image units */
    double squares_factor;                  /* of plan->squares, in image units */
    double squared[PATH_MAX_VERTICES][GROUPS_BLOCKS]; /* squares of the sums, by block of the image */
    const int64_t *single;            /* the film of samples of which there is a single unit, else null */
    double single_factor;             /* of their squared differences, in image units */
    double correction[GROUPS_BLOCKS]; /* excess, as the block's lengths have it in the mean */
} plan_pixels_t;

void plan_pixels_init(plan_pixels_t *pixels, const plan_t *plan);
/* Value and variance of pixel p, per channel. Variance is infinite while there are too few units. */
void plan_pixel(const plan_pixels_t *pixels, size_t p, double value[3], double variance[3]);
/* The error of the image as it stands. */
typedef struct plan_error {
    double relmse;    /* NaN while there are too few units */
    double spread;    /* its relative standard error, from groups of units; NaN while these are too few */
    double low, high; /* hold this render's own relMSE in 95 % of renders; NaN likewise */
    bool reliable;    /* nothing speaks against relmse and its interval */
    char reason[160]; /* else what does */
    bool weighed;     /* by weights without noise (stats/jackknife.h) */
    double lengths[PATH_MAX_VERTICES]; /* what each of plan->lengths brings to it */
    double of_b[PATH_MAX_VERTICES];    /* of that, by the error of b_k */
} plan_error_t;
void plan_estimate_error(const plan_t *plan, plan_error_t *error);

#endif
