/* charted_reference.h: the picture of charted_scene.h and its integrals, without chains.
 *
 * A pixel's value is the mean radiance of its part of the ground. Along z the lights' (and the hole's) integral is
 * known,
 *
 *     integral of z / (z^2 + s)^2 = 1/2 (1 / (s + z0^2) - 1 / (s + z1^2))
 *
 * and what strip, screen and the lights' borders leave visible is an interval, or two, along y, with known ends.
 * Gauss quadrature does the rest: panels of 8 points along y, after y = y0 + x sinh(q) where light 1 is near, and
 * 4 x 4 points a pixel. Borders of strip and pixels coincide. */
#ifndef LAB_CHARTED_REFERENCE_H
#define LAB_CHARTED_REFERENCE_H

#include <stdint.h>

#include "client/lab/charted_scene.h"

enum { CHARTED_SIDE = 96, CHARTED_PIXELS = CHARTED_SIDE * CHARTED_SIDE };

/* Row r holds y from r / CHARTED_SIDE on, column c likewise x. */
typedef struct charted_picture {
    double rgb[CHARTED_PIXELS][3];
} charted_picture_t;

static inline int charted_pixel(double x, double y)
{
    return (int)(y * CHARTED_SIDE) * CHARTED_SIDE + (int)(x * CHARTED_SIDE);
}

/* Radiance of the ground at (x, y), 0 < x, y < 1, and in *target (may be null) the integral of f* over the lights.
 */
rgb_t charted_ground(double x, double y, double *target);
/* The picture; returns b, the integral of f*. */
double charted_reference(charted_picture_t *picture);
/* Square root of the mean over pixels and channels of (a - b)^2. */
double charted_error(const charted_picture_t *a, const charted_picture_t *b);

/* Normalisation: all = b by quadrature; of_chart[i] = integral of w_i f*, by randomised quasi-Monte Carlo. */
typedef struct charted_constants {
    double all, of_chart[CHARTED_CHARTS], error; /* standard error of of_chart; they sum to b, so it is the same */
} charted_constants_t;

/* The estimate of one chart's integral from its own samples, CHARTED_SHIFTS random shifts of `points` points of the
 * additive recurrence of the root of g^5 = g + 1 (Roberts 2018); *error is its standard error. */
enum { CHARTED_SHIFTS = 16 };
double charted_share(int chart, uint64_t points, uint64_t seed, double *error);
/* b as given. Each chart's estimate tells the other's, b less it; both are weighed by their variances. */
charted_constants_t charted_constants(double b, uint64_t points, uint64_t seed);

#endif
