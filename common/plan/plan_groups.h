/* plan_groups.h: units of a render in independent groups, to see how sure the estimate of its error is and how
 * alike the groups' images are.
 *
 * A length's unit number i belongs to group i mod PLAN_GROUPS. Per group are kept, in 16 x 16 blocks of the image,
 * its light by length and its squares (those of plan->squares); by length the squares of all groups. Sums are
 * exact.
 *
 * plan_groups_spread: the estimate of relMSE is a sum over units; groups of them are independent, so what it would
 * be from each group alone tells its standard error. Where a few units hold most of the squares (heavy tails)
 * groups differ by much, and the interval is wide: it says that the estimate is not to be trusted, not how wrong it
 * is.
 *
 * One thread at a time, as all of a plan. */
#ifndef PLAN_PLAN_GROUPS_H
#define PLAN_PLAN_GROUPS_H

#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"
#include "film/film.h"
#include "plan/exact.h"

enum { PLAN_GROUPS = 16, PLAN_GROUP_SIDE = 16, PLAN_GROUP_BLOCKS = PLAN_GROUP_SIDE * PLAN_GROUP_SIDE };

/* All zero: none. [k] is the length, as in plan->lengths. */
typedef struct plan_groups {
    uint32_t lengths;      /* K + 1 */
    exact_uint_t *light;   /* [K + 1][PLAN_GROUPS][PLAN_GROUP_BLOCKS]: luminance on the film, in 2^-28 */
    exact_uint_t *squares; /* [PLAN_GROUPS][PLAN_GROUP_BLOCKS], summed over channels */
    exact_uint_t *own;     /* [K + 1][PLAN_GROUP_BLOCKS]: of one length, over all groups */
    uint64_t *counts;      /* [K + 1][PLAN_GROUPS]: mutations or samples */
} plan_groups_t;

fault_code_t plan_groups_init(plan_groups_t *groups, uint32_t max_path_length, fault_t *fault);
void plan_groups_clear(plan_groups_t *groups);

/* Octets of the arrays, in the order above. */
typedef struct plan_groups_part {
    void *data;
    size_t size;
} plan_groups_part_t;
enum { PLAN_GROUPS_PARTS = 4 };
void plan_groups_parts(const plan_groups_t *groups, plan_groups_part_t parts[PLAN_GROUPS_PARTS]);

/* The block of a row or column `at` of `size`. */
static inline uint32_t plan_groups_block(uint32_t at, uint32_t size)
{
    return (uint32_t)((uint64_t)at * PLAN_GROUP_SIDE / size);
}

/* A unit of length k, the `unit`-th of them, `count` mutations or samples; c and size as for plan->squares. */
void plan_groups_absorb(plan_groups_t *groups, uint32_t k, uint64_t unit, uint64_t count, const film_t *film,
                        double c, double size);

/* Relative standard error of relMSE, its variances weighted by block; NaN while groups are too few. `mutations`:
 * what one of a length's counts is. */
double plan_groups_spread(const plan_groups_t *groups, const double weights[PLAN_GROUP_BLOCKS],
                          const double *mutations);

/* Sum over blocks of weights times the squares of one length, in units of the squares. */
double plan_groups_squares(const plan_groups_t *groups, uint32_t k, const double weights[PLAN_GROUP_BLOCKS]);

/* Light of a group's image in every block. factor[k]: b_k / 2^28, the image's light of length k is that times film
 * over count. Where a group has none of a length that of all groups stands in. */
void plan_groups_image(const plan_groups_t *groups, uint32_t group, const double *factor,
                       double blocks[PLAN_GROUP_BLOCKS]);

#endif
