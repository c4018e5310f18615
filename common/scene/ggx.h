/* ggx.h: the GGX (Trowbridge-Reitz) microfacet distribution, anisotropic, with Smith's shadowing.
 *
 * Directions are local, w.z > 0. With S = diag(alpha_u, alpha_v, 1) and L(w) = |S w|:
 *     D(m)      = 1 / (pi au av |S^-1 m|^4)                  (Walter et al. 2007, eq. 33, in slopes; Heitz 2014,
 * eq. 85) Lambda(w) = (L / w.z - 1) / 2                          (Heitz 2014, eq. 72 and 86) G1(w)     = 2 w.z /
 * (w.z + L) G2(o,i)   = 1 / (1 + Lambda_o + Lambda_i) = 2 o.z i.z / (L_o i.z + L_i o.z)      (ibid., eq. 99:
 * height-correlated) D_w(m)    = G1 max(0, w.m) D / w.z = 2 D (w.m) / (w.z + L)   (ibid., eq. 2: density of visible
 * normals) All sums have positive terms only: nothing cancels, for alpha from 1 to 1e-4 and w.z down to the
 * smallest.
 *
 * Visible normals are sampled by spherical caps (Dupuy and Benyoub: Sampling visible GGX normals with spherical
 * caps, HPG 2023, listing 3) with w = S wo / L: the reflected direction about a unit hemisphere's visible normal is
 * uniform on the cap z >= -w.z.
 */
#ifndef SCENE_GGX_H
#define SCENE_GGX_H

#include "math/vec.h"

/* L(w) = sqrt(au^2 x^2 + av^2 y^2 + z^2). */
static inline double ggx_stretch(double au, double av, vec3_t w)
{
    const double x = au * w.x, y = av * w.y;
    return sqrt(x * x + y * y + w.z * w.z);
}

/* D of the direction of h, which need not be of unit length; h.z > 0, h2 = |h|^2. Per solid angle. */
static inline double ggx_d(double au, double av, vec3_t h, double h2)
{
    const double a = au * av;
    const double x = av * h.x, y = au * h.y, z = a * h.z;
    const double q = x * x + y * y + z * z;
    const double r = h2 / q;
    return a * a * a * MATH_INV_PI * r * r;
}

static inline double ggx_lambda(double au, double av, vec3_t w)
{
    const double x = au * w.x, y = av * w.y;
    const double slope2 = (x * x + y * y) / (w.z * w.z);
    return 0.5 * slope2 / (1 + sqrt(1 + slope2)); /* (sqrt(1 + s) - 1) / 2 without cancellation */
}

static inline double ggx_g1(double au, double av, vec3_t w)
{
    return 2 * w.z / (w.z + ggx_stretch(au, av, w));
}

static inline double ggx_g2(double au, double av, vec3_t wo, vec3_t wi)
{
    return 2 * wo.z * wi.z / (ggx_stretch(au, av, wo) * wi.z + ggx_stretch(au, av, wi) * wo.z);
}

/* Density of visible normals per solid angle of m, |m| = 1. */
static inline double ggx_visible_pdf(double au, double av, vec3_t wo, vec3_t m)
{
    const double c = vec3_dot(wo, m);
    return c > 0 && m.z > 0 ? 2 * ggx_d(au, av, m, 1) * c / (wo.z + ggx_stretch(au, av, wo)) : 0;
}

/* Reflection of wo into wi, both above: everything but Fresnel. */
typedef struct ggx_reflection {
    double f;           /* D G2 / (4 o.z i.z) */
    double pdf;         /* of wi given wo by visible normals: D_wo(m) / (4 wo.m) */
    double pdf_reverse; /* of wo given wi */
    double cosine;      /* wo.m = wi.m */
} ggx_reflection_t;

static inline ggx_reflection_t ggx_reflect(double au, double av, vec3_t wo, vec3_t wi)
{
    const vec3_t h = vec3_add(wo, wi);
    const double h2 = vec3_dot(h, h);
    const double d = 0.5 * ggx_d(au, av, h, h2);
    const double lo = ggx_stretch(au, av, wo), li = ggx_stretch(au, av, wi);
    const double c = 0.5 * sqrt(h2);
    return (ggx_reflection_t){d / (lo * wi.z + li * wo.z), d / (wo.z + lo), d / (wi.z + li), c < 1 ? c : 1};
}

/* A visible normal (unit) of wo from u1, u2 in [0,1). */
vec3_t ggx_sample(double au, double av, vec3_t wo, double u1, double u2);
/* The numbers that give m, wo.m > 0. */
void ggx_invert(double au, double av, vec3_t wo, vec3_t m, double *u1, double *u2);

#endif
