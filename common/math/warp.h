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

#include <stdint.h>
#include <string.h>

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

/* Sine and cosine of 2 pi u, u in [0,1). The nearest quarter q/4 is subtracted (exactly), the rest r in [-1/8,1/8]
 * goes through polynomials in r^2 that interpolate sin(2 pi r)/r and cos(2 pi r) at Chebyshev nodes (approximation
 * error 1.3e-17 and 1.9e-17 relative); 2 pi is carried in two doubles. Error below 1.1 ulp (measured: 1.04);
 * quarters are exact. No branch, no call. */
static inline void warp_sincos_turns(double u, double *s, double *c)
{
    const int64_t quarter = (int64_t)(4.0 * u + 0.5);
    const double r = u - 0.25 * (double)quarter;
    const double z = r * r;
    double ps = 0x1.e4a9d9166f052p+1, pc = -0x1.b2f3eb054afcdp+0;
    ps = fma(z, ps, -0x1.e3027dea82bd7p+3);
    pc = fma(z, pc, 0x1.f9ce245cada0bp+2);
    ps = fma(z, ps, 0x1.50783208843ebp+5);
    pc = fma(z, pc, -0x1.a6d1eef479be1p+4);
    ps = fma(z, ps, -0x1.32d2cce500387p+6);
    pc = fma(z, pc, 0x1.e1f5068688d5bp+5);
    ps = fma(z, ps, 0x1.466bc6775a476p+6);
    pc = fma(z, pc, -0x1.55d3c7e3cb241p+6);
    ps = fma(z, ps, -0x1.4abbce625be52p+5);
    pc = fma(z, pc, 0x1.03c1f081b5ac0p+6);
    pc = fma(z, pc, -0x1.3bd3cc9be45dep+4);
    /* 2 pi = 0x1.921fb54442d18p+2 + 0x1.1a62633145c07p-52 */
    const double sine = fma(r, 0x1.921fb54442d18p+2, r * fma(z, ps, 0x1.1a62633145c07p-52));
    const double cosine = fma(z, pc, 1.0);
    /* odd quarters swap the two; the signs follow the quarter */
    uint64_t sb, cb;
    memcpy(&sb, &sine, sizeof sb);
    memcpy(&cb, &cosine, sizeof cb);
    const uint64_t q = (uint64_t)quarter;
    const uint64_t swap = (sb ^ cb) & (0 - (q & 1));
    sb ^= swap ^ ((q & 2) << 62);
    cb ^= swap ^ (((q + 1) & 2) << 62);
    memcpy(s, &sb, sizeof sb);
    memcpy(c, &cb, sizeof cb);
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
