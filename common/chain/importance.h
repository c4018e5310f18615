/* importance.h: how much light counts by where in the image it is seen: the second stage against the dark.
 *
 * Chains that follow C put mutations where light is, and a dark pixel's relative error is as much larger as it has
 * fewer of them. With an importance g they follow C g, and each splat is divided by g again: unbiased for any g > 0
 * that is fixed beforehand. The plan takes g from a first sketch of the image (docs/transport.md).
 *
 * g is given in blocks of the image, at their centres, and bilinear between them, constant beyond the outermost.
 */
#ifndef CHAIN_IMPORTANCE_H
#define CHAIN_IMPORTANCE_H

#include "math/vec.h"

enum { IMPORTANCE_SIDE = 16, IMPORTANCE_BLOCKS = IMPORTANCE_SIDE * IMPORTANCE_SIDE };

typedef struct importance {
    const double *blocks; /* IMPORTANCE_BLOCKS by rows, positive; null: 1 everywhere */
    double width, height; /* of the image */
} importance_t;

static inline double importance_clamp(double x)
{
    return x > 0 ? (x < IMPORTANCE_SIDE - 1 ? x : IMPORTANCE_SIDE - 1) : 0;
}

/* g at a raster position; blocks not null. */
static inline double importance_at(const importance_t *g, vec2_t raster)
{
    const double x = importance_clamp(raster.x / g->width * IMPORTANCE_SIDE - 0.5),
                 y = importance_clamp(raster.y / g->height * IMPORTANCE_SIDE - 0.5);
    const int i = x < IMPORTANCE_SIDE - 1 ? (int)x : IMPORTANCE_SIDE - 2,
              j = y < IMPORTANCE_SIDE - 1 ? (int)y : IMPORTANCE_SIDE - 2;
    const double u = x - i, v = y - j, *row = g->blocks + j * IMPORTANCE_SIDE + i;
    return (1 - v) * ((1 - u) * row[0] + u * row[1]) +
           v * ((1 - u) * row[IMPORTANCE_SIDE] + u * row[IMPORTANCE_SIDE + 1]);
}

#endif
