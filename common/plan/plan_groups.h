/* plan_groups.h: units of a render in independent groups, to see how alike the groups' images are, and by that how
 * far the render's own error may be from its estimate (plan_scatter.h).
 *
 * A length's unit number i belongs to group i mod PLAN_GROUPS. Per length and group are kept its light in 16 x 16
 * blocks of the image, and at some of its pixels, the spots: all of a small image, PLAN_SPOTS of a large one. By
 * length, the squares of all groups in the blocks (those of plan->squares). Sums are exact.
 *
 * One thread at a time, as all of a plan. */
#ifndef PLAN_PLAN_GROUPS_H
#define PLAN_PLAN_GROUPS_H

#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"
#include "film/film.h"
#include "plan/exact.h"

enum {
    PLAN_GROUPS = 16,
    PLAN_GROUP_SIDE = 16,
    PLAN_GROUP_BLOCKS = PLAN_GROUP_SIDE * PLAN_GROUP_SIDE,
    PLAN_SPOTS = 2048
};

/* All zero: none. [k] is the length, as in plan->lengths. */
typedef struct plan_groups {
    uint32_t lengths; /* K + 1 */
    uint32_t spot_count;
    size_t pixels;       /* of the image */
    exact_uint_t *light; /* [K + 1][PLAN_GROUPS][PLAN_GROUP_BLOCKS]: luminance on the film, in 2^-28 */
    exact_uint_t *spots; /* [K + 1][PLAN_GROUPS][spot_count]: the same at single pixels */
    exact_uint_t *own;   /* [K + 1][PLAN_GROUP_BLOCKS]: squares, summed over groups and channels */
    uint64_t *counts;    /* [K + 1][PLAN_GROUPS]: mutations or samples */
} plan_groups_t;

fault_code_t plan_groups_init(plan_groups_t *groups, uint32_t max_path_length, size_t pixels, fault_t *fault);
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

/* The first row or column of block `at`; at = PLAN_GROUP_SIDE: past the last. */
static inline uint32_t plan_groups_begin(uint32_t at, uint32_t size)
{
    return (uint32_t)(((uint64_t)at * size + PLAN_GROUP_SIDE - 1) / PLAN_GROUP_SIDE);
}

/* The pixel of a spot: ascending. */
size_t plan_groups_spot(const plan_groups_t *groups, uint32_t i);

/* A unit of length k, the `unit`-th of them, `count` mutations or samples; c and size as for plan->squares. */
void plan_groups_absorb(plan_groups_t *groups, uint32_t k, uint64_t unit, uint64_t count, const film_t *film,
                        double c, double size);

/* Squares of one length in one block, in units of the squares. */
double plan_groups_squares(const plan_groups_t *groups, uint32_t k, uint32_t block);

/* Luminance on the film of one length in one block, of all groups. */
double plan_groups_light(const plan_groups_t *groups, uint32_t k, uint32_t block);

/* Light of a group's image in every block. factor[k]: b_k / 2^28, the image's light of length k is that times film
 * over count. Where a group has none of a length that of all groups stands in. */
void plan_groups_image(const plan_groups_t *groups, uint32_t group, const double *factor,
                       double blocks[PLAN_GROUP_BLOCKS]);

#endif
