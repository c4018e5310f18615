/* groups.h: units of a render in independent groups, to see how alike the groups' images are, and by that how
 * far the render's own error may be from its estimate (scatter.h).
 *
 * A length's unit number i belongs to group i mod GROUPS_COUNT. Per length and group are kept its light in 16 x 16
 * blocks of the image, and at some of its pixels, the spots: all of a small image, GROUPS_SPOTS of a large one. By
 * length, the squares of all groups in the blocks: sums over units of (c x)^2 / size. Sums are exact.
 *
 * One thread at a time. */
#ifndef STATS_GROUPS_H
#define STATS_GROUPS_H

#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"
#include "film/film.h"
#include "stats/exact.h"

enum { GROUPS_COUNT = 16, GROUPS_SIDE = 16, GROUPS_BLOCKS = GROUPS_SIDE * GROUPS_SIDE, GROUPS_SPOTS = 2048 };

/* All zero: none. [k] is the length; [0]: units of all lengths at once. */
typedef struct groups {
    uint32_t lengths; /* K + 1 */
    uint32_t spot_count;
    size_t pixels;       /* of the image */
    exact_uint_t *light; /* [K + 1][GROUPS_COUNT][GROUPS_BLOCKS]: luminance on the film, in 2^-28 */
    exact_uint_t *spots; /* [K + 1][GROUPS_COUNT][spot_count]: the same at single pixels */
    exact_uint_t *own;   /* [K + 1][GROUPS_BLOCKS]: squares, summed over groups and channels */
    uint64_t *counts;    /* [K + 1][GROUPS_COUNT]: mutations or samples */
} groups_t;

fault_code_t groups_init(groups_t *groups, uint32_t max_path_length, size_t pixels, fault_t *fault);
void groups_clear(groups_t *groups);

/* Octets of the arrays, in the order above. */
typedef struct groups_part {
    void *data;
    size_t size;
} groups_part_t;
enum { GROUPS_PARTS = 4 };
void groups_parts(const groups_t *groups, groups_part_t parts[GROUPS_PARTS]);

/* The block of a row or column `at` of `size`. */
static inline uint32_t groups_block(uint32_t at, uint32_t size)
{
    return (uint32_t)((uint64_t)at * GROUPS_SIDE / size);
}

/* The first row or column of block `at`; at = GROUPS_SIDE: past the last. */
static inline uint32_t groups_begin(uint32_t at, uint32_t size)
{
    return (uint32_t)(((uint64_t)at * size + GROUPS_SIDE - 1) / GROUPS_SIDE);
}

/* The pixel of a spot: ascending. */
size_t groups_spot(const groups_t *groups, uint32_t i);

/* A unit of length k, the `unit`-th of them, `count` mutations or samples: what is on its film counts c, and size
 * is that of the unit over the usual one of its length. */
void groups_absorb(groups_t *groups, uint32_t k, uint64_t unit, uint64_t count, const film_t *film, double c,
                   double size);

/* Squares of one length in one block, in units of the squares. */
double groups_squares(const groups_t *groups, uint32_t k, uint32_t block);

/* Luminance on the film of one length in one block, of all groups. */
double groups_light(const groups_t *groups, uint32_t k, uint32_t block);

/* Light of a group's image in every block. factor[k]: b_k / 2^28, the image's light of length k is that times film
 * over count. Where a group has none of a length that of all groups stands in. */
void groups_image(const groups_t *groups, uint32_t group, const double *factor, double blocks[GROUPS_BLOCKS]);

#endif
