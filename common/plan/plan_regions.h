/* plan_regions.h: the groups' images in 16 x 16 blocks: how alike they are, and how bright regions of the image are
 * with 95 % intervals. */
#ifndef PLAN_PLAN_REGIONS_H
#define PLAN_PLAN_REGIONS_H

#include "plan/plan_state.h"

/* Student's 97.5 % quantile, within 1 % from 3 degrees of freedom on. */
double plan_student(double freedom);
/* The block that pixel p lies in. */
uint32_t plan_block(const plan_t *plan, size_t p);
/* How alike the groups' images are: brightness of each over the image's, and the root of the mean squared relative
 * difference over 16 x 16 blocks, in the measure of relMSE. False while there are too few units. */
typedef struct plan_group_figures {
    double brightness[GROUPS_COUNT], deviation[GROUPS_COUNT];
} plan_group_figures_t;
bool plan_estimate_groups(const plan_t *plan, plan_group_figures_t *figures);
/* The mean luminance of a region of blocks, with 95 % between low and high: Student's, from the groups of each
 * length, and the error of b. False while a length that has units has them in fewer than three groups. */
typedef struct plan_region {
    double mean, low, high;
} plan_region_t;
bool plan_estimate_region(const plan_t *plan, const bool region[GROUPS_BLOCKS], plan_region_t *out);
/* Regions that a report tells of: so many across and down. */
enum { PLAN_REGION_SIDE = 4, PLAN_REGIONS = PLAN_REGION_SIDE * PLAN_REGION_SIDE };

#endif
