#include "math/warp.h"

void warp_disk_invert(vec2_t p, double *u1, double *u2)
{
    *u1 = warp_clamp_unit(p.x * p.x + p.y * p.y);
    *u2 = warp_turns(p.y, p.x);
}

void warp_cosine_invert(vec3_t w, double *u1, double *u2)
{
    const double r2 = w.x * w.x + w.y * w.y;
    const double z = fmax(w.z, 0.0);
    /* from the smaller of the two, whose relative error is then the result's */
    *u1 = warp_clamp_unit(r2 < 0.5 ? r2 : 1.0 - z * z);
    *u2 = warp_turns(w.y, w.x);
}

vec3_t warp_sphere(double u1, double u2)
{
    const double r = 2.0 * sqrt(u1 * (1.0 - u1)); /* sqrt(1 - z^2) */
    double s, c;
    warp_sincos_turns(u2, &s, &c);
    return vec3(r * c, r * s, 1.0 - 2.0 * u1);
}

/* 1 - w.z of a unit vector without cancellation near +z: r^2 / (1 + z). */
static double one_minus_z(vec3_t w)
{
    return w.z > 0 ? (w.x * w.x + w.y * w.y) / (1.0 + w.z) : 1.0 - w.z;
}

void warp_sphere_invert(vec3_t w, double *u1, double *u2)
{
    const double r2 = w.x * w.x + w.y * w.y;
    /* near -z: 1 + z = r^2 / (1 - z) */
    *u1 = warp_clamp_unit(w.z > 0 ? 0.5 * r2 / (1.0 + w.z) : 1.0 - 0.5 * r2 / (1.0 - w.z));
    *u2 = warp_turns(w.y, w.x);
}

vec3_t warp_cone(double u1, double u2, double one_minus_cos)
{
    const double h = u1 * one_minus_cos; /* 1 - z */
    const double r = sqrt(h * (2.0 - h));
    double s, c;
    warp_sincos_turns(u2, &s, &c);
    return vec3(r * c, r * s, 1.0 - h);
}

void warp_cone_invert(vec3_t w, double one_minus_cos, double *u1, double *u2)
{
    *u1 = warp_clamp_unit(one_minus_z(w) / one_minus_cos);
    *u2 = warp_turns(w.y, w.x);
}

vec2_t warp_triangle(double u1, double u2)
{
    const double r = sqrt(u1);
    return (vec2_t){1.0 - r, u2 * r};
}

void warp_triangle_invert(vec2_t b, double *u1, double *u2)
{
    const double r = fmax(1.0 - b.x, 0.0);
    *u1 = warp_clamp_unit(r * r);
    *u2 = r > 0 ? warp_clamp_unit(b.y / r) : 0.0;
}

/* Clarberg: Fast equal-area mapping of the (hemi)sphere using SIMD, 2008. On the square [-1,1]^2 the diamond |u| +
 * |v| <= 1 is the upper half with r = |u| + |v|; the corners fold over to the lower half with r = 2 - |u| - |v|. In
 * each, z = +-(1 - r^2), and phi of the first quadrant is proportional to the place along the diamond's edge. */
vec3_t warp_octahedral(double x, double y)
{
    const double u = 2.0 * x - 1.0, v = 2.0 * y - 1.0;
    const double au = fabs(u), av = fabs(v);
    const double side = 1.0 - au - av; /* > 0: upper half */
    /* r from the numbers that are small where r is */
    const double r = side > 0 ? au + av : (1.0 - au) + (1.0 - av);
    const double turns = r > 0 ? 0.125 * ((av - au) / r + 1.0) : 0.0;
    double s, c;
    warp_sincos_turns(turns, &s, &c);
    const double height = fabs(side) * (1.0 + r);           /* 1 - r^2 */
    const double radius = r * sqrt(fmax(2.0 - r * r, 0.0)); /* sqrt(1 - z^2) */
    return vec3(copysign(c, u) * radius, copysign(s, v) * radius, copysign(height, side));
}

void warp_octahedral_invert(vec3_t w, double *x, double *y)
{
    const double r = sqrt((w.x * w.x + w.y * w.y) / (1.0 + fabs(w.z)));     /* sqrt(1 - |z|) */
    const double along = fmin(4.0 * warp_turns(fabs(w.y), fabs(w.x)), 1.0); /* phi / (pi/2) */
    double au = r * (1.0 - along), av = r * along;
    if (w.z < 0) {
        const double fold = au;
        au = 1.0 - av;
        av = 1.0 - fold;
    }
    *x = warp_clamp_unit(0.5 + copysign(0.5 * au, w.x));
    *y = warp_clamp_unit(0.5 + copysign(0.5 * av, w.y));
}
