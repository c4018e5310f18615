/* plan_estimate.h: estimates from the sums as they stand: of b_k, of pixels and their variances, of the image's
 * error, of groups and regions. */
#ifndef PLAN_PLAN_ESTIMATE_H
#define PLAN_PLAN_ESTIMATE_H

#include "plan/plan_state.h"

/* Estimates from all samples and large steps so far, with their standard errors: of b_k (of b for k = 0: that error
 * is the sum of the b_k's, which is the most it can be), of b_{k,s}. */
double plan_length_b(const plan_t *plan, uint32_t k, double *error);
double plan_technique_b(const plan_t *plan, uint32_t k, uint32_t s, double *error);
/* Pixel values and variances: what plan_pixel needs, computed once an image. */
typedef struct plan_pixels {
    const plan_t *plan;
    uint32_t count;                         /* lengths that have been rendered */
    uint32_t lengths[PATH_MAX_VERTICES];    /* which */
    const int64_t *sums[PATH_MAX_VERTICES]; /* their films */
    double factor[PATH_MAX_VERTICES];       /* b_k / (N_k 2^28) */
    double b_variance[PATH_MAX_VERTICES];   /* (sigma_{b_k} / b_k)^2 factor^2 */
    double square[PATH_MAX_VERTICES];       /* of a sum: what the mean takes off the squares, in image units */
    double squares_factor;                  /* of plan->squares, in image units */
    double correction;                      /* U / (U - 1) */
} plan_pixels_t;

void plan_pixels_init(plan_pixels_t *pixels, const plan_t *plan);
/* Value and variance of pixel p, per channel. Variance is infinite while there are too few units. */
void plan_pixel(const plan_pixels_t *pixels, size_t p, double value[3], double variance[3]);
/* The error of the image as it stands. */
typedef struct plan_error {
    double relmse;    /* NaN while there are too few units */
    double spread;    /* its relative standard error, from groups of units; NaN while these are too few */
    double low, high; /* 95 % of relmse; NaN likewise */
    double lengths[PATH_MAX_VERTICES]; /* what each of plan->lengths brings to it */
} plan_error_t;
void plan_estimate_error(const plan_t *plan, plan_error_t *error);
/* How alike the groups' images are: brightness of each over the image's, and the root of the mean squared relative
 * difference over 16 x 16 blocks, in the measure of relMSE. False while there are too few units. */
typedef struct plan_group_figures {
    double brightness[PLAN_GROUPS], deviation[PLAN_GROUPS];
} plan_group_figures_t;
bool plan_estimate_groups(const plan_t *plan, plan_group_figures_t *figures);
/* The mean luminance of a region of blocks, with 95 % between low and high: Student's, from the groups, and the
 * error of b. False before each length that is rendered has a unit in every group. */
typedef struct plan_region {
    double mean, low, high;
} plan_region_t;
bool plan_estimate_region(const plan_t *plan, const bool region[PLAN_GROUP_BLOCKS], plan_region_t *out);
/* Regions that a report tells of: so many across and down. */
enum { PLAN_REGION_SIDE = 4, PLAN_REGIONS = PLAN_REGION_SIDE * PLAN_REGION_SIDE };

#endif
