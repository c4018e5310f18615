/* warp_turns.h of the extended build: the C library's sine and cosine, for common/math/warp_turns.h, whose
 * polynomials and bits are a double's. */
#ifndef MATH_WARP_TURNS_H
#define MATH_WARP_TURNS_H

#include <stdint.h>
#include <string.h>

/* Quarters are subtracted, exactly, so that the sine of a small rest keeps its relative precision. */
static inline void warp_sincos_turns(double u, double *s, double *c)
{
    const int quarter = (int)(4 * u + (double)0.5L) & 3;
    const double rest = u - (double)((int)(4 * u + (double)0.5L)) * (double)0.25L;
    const double angle = 2 * EXTENDED_PI * rest;
    const double turn[4] = {sin(angle), cos(angle), -sin(angle), -cos(angle)};
    *s = turn[quarter];
    *c = turn[(quarter + 1) & 3];
}

#endif
