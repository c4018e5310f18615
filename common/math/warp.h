/* warp.h: maps from the unit square to directions and surfaces, each with its density and its inverse.
 * u1, u2 in [0,1); an inverse returns numbers in [0,1) (clamped to the largest double below 1) that map back. */
#ifndef MATH_WARP_H
#define MATH_WARP_H

#include "math/vec.h"

static inline double warp_clamp_unit(double u)
{
    return u < 0 ? 0 : u < MATH_ONE_MINUS ? u : MATH_ONE_MINUS;
}

/* An angle in turns, wrapped to [0,1). */
static inline double warp_turns(double y, double x)
{
    const double t = atan2(y, x) * (0.5 * MATH_INV_PI);
    return warp_clamp_unit(t < 0 ? t + 1 : t);
}

/* Sine and cosine of 2 pi u. */
void warp_sincos_turns(double u, double *s, double *c);

/* Unit disk, polar: r = sqrt(u1), phi = 2 pi u2. Density 1/pi per area. */
vec2_t warp_disk(double u1, double u2);
void warp_disk_invert(vec2_t p, double *u1, double *u2);

/* Cosine-weighted hemisphere around +z: the polar disk lifted. Density z/pi per solid angle. */
vec3_t warp_cosine(double u1, double u2);
void warp_cosine_invert(vec3_t w, double *u1, double *u2);

/* Uniform sphere: z = 1 - 2 u1. Density 1/(4 pi). */
vec3_t warp_sphere(double u1, double u2);
void warp_sphere_invert(vec3_t w, double *u1, double *u2);

/* Uniform cone around +z, 1 - cos of its half angle given (exact for tiny cones). Density 1/(2 pi one_minus_cos). */
vec3_t warp_cone(double u1, double u2, double one_minus_cos);
void warp_cone_invert(vec3_t w, double one_minus_cos, double *u1, double *u2);

/* Uniform triangle: barycentric (b1, b2) = (1 - sqrt(u1), u2 sqrt(u1)), b0 = 1 - b1 - b2. */
vec2_t warp_triangle(double u1, double u2);
void warp_triangle_invert(vec2_t b, double *u1, double *u2);

/* Equal-area octahedral map of the sphere onto [0,1]^2 (Clarberg 2008; pbrt-v4's EqualAreaSquareToSphere). Jacobian 4 pi. */
vec3_t warp_octahedral(double x, double y);
void warp_octahedral_invert(vec3_t w, double *x, double *y);

#endif
