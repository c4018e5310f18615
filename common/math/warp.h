/* warp.h: maps from the unit square to directions and surfaces, each with its density and its inverse.
 *
 * u1, u2 in [0,1); an inverse returns numbers in [0,1) (clamped to the largest double below 1) that map back.
 *
 * Accuracy of x -> u -> x. A number u near 1 is known to 1.1e-16, and no better: where a map has a square root that
 * vanishes at u = 1, a point at distance d from there comes back with an error of up to 1.1e-16 / d, at
 * worst 1.1e-8 (d = 0). That concerns the horizon of warp_cosine (d = z) and the pole -z of warp_sphere and of wide
 * cones (d = the radius around it). Every other place comes back to a few 1e-16 of the map's size, and near u1 = 0
 * (the disk's centre, the poles +z) with full relative precision.
 *
 * Pure functions; any thread. Those of the inner loop are inline.
 */
#ifndef MATH_WARP_H
#define MATH_WARP_H

#include "math/vec.h"
#include "math/warp_turns.h"

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

/* Unit disk, polar: r = sqrt(u1), phi = 2 pi u2. Density 1/pi per area. */
static inline vec2_t warp_disk(double u1, double u2)
{
    const double r = sqrt(u1);
    double s, c;
    warp_sincos_turns(u2, &s, &c);
    return (vec2_t){r * c, r * s};
}
/* p in the unit disk (just outside counts as on the rim). */
void warp_disk_invert(vec2_t p, double *u1, double *u2);

/* Cosine-weighted hemisphere around +z: the polar disk lifted (Malley). Density z/pi per solid angle; z > 0 always
 * (at least 1e-8). */
static inline vec3_t warp_cosine(double u1, double u2)
{
    const vec2_t d = warp_disk(u1, u2);
    return (vec3_t){d.x, d.y, sqrt(1.0 - u1)};
}
/* w unit with z > 0; z <= 0 counts as the horizon. */
void warp_cosine_invert(vec3_t w, double *u1, double *u2);

/* Uniform sphere: z = 1 - 2 u1. Density 1/(4 pi). */
vec3_t warp_sphere(double u1, double u2);
void warp_sphere_invert(vec3_t w, double *u1, double *u2);

/* Uniform cone around +z, 1 - cos of its half angle given (exact for tiny cones). Density 1/(2 pi one_minus_cos).
 */
vec3_t warp_cone(double u1, double u2, double one_minus_cos);
/* w unit; outside the cone counts as on its rim. */
void warp_cone_invert(vec3_t w, double one_minus_cos, double *u1, double *u2);

/* Uniform triangle: barycentric (b1, b2) = (1 - sqrt(u1), u2 sqrt(u1)), b0 = 1 - b1 - b2. Density 2 per (b1, b2).
 */
vec2_t warp_triangle(double u1, double u2);
void warp_triangle_invert(vec2_t b, double *u1, double *u2);

/* Equal-area octahedral map of the sphere onto [0,1]^2 (Clarberg 2008; pbrt-v4's EqualAreaSquareToSphere). Jacobian
 * 4 pi. */
vec3_t warp_octahedral(double x, double y);
void warp_octahedral_invert(vec3_t w, double *x, double *y);

#endif
