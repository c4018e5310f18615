/* fresnel.h: reflectance of a plane interface for unpolarised light, exact, and its diffuse averages.
 *
 * Cosines are of the angle to the (micro)facet's normal, in (0,1]. `eta` of a dielectric is relative to the walk:
 * the index beyond the interface over the index on the side of the incident direction.
 */
#ifndef SCENE_FRESNEL_H
#define SCENE_FRESNEL_H

#include <stddef.h>

#include "math/vec.h"

/* Dielectric (Born and Wolf, Principles of Optics, 1.5.2, eq. 21). With g = eta cos_t = sqrt(c^2 + eta^2 - 1):
 *     r_s = (c - g) / (c + g)                = -b / (c + g)^2                    b = eta^2 - 1
 *     r_p = (eta^2 c - g) / (eta^2 c + g)    = b (c (c + g) - 1) / ((c + g) (eta^2 c + g))
 * The right-hand forms have b as a factor: no cancellation as eta goes to 1. Total internal reflection gives 1.
 * *g_out (may be null) is g, 0 at total reflection: the refracted cosine is g / eta. */
static inline double fresnel_dielectric_g(double c, double eta, double *g_out)
{
    const double b = (eta - 1) * (eta + 1);
    const double g2 = c * c + b;
    if (!(g2 > 0)) {
        if (g_out)
            *g_out = 0;
        return 1;
    }
    const double g = sqrt(g2);
    const double sum = c + g;
    const double r_s = b / (sum * sum);
    const double r_p = b * (c * sum - 1) / (sum * (eta * eta * c + g));
    if (g_out)
        *g_out = g;
    const double f = 0.5 * (r_s * r_s + r_p * r_p);
    return f < 1 ? f : 1;
}

static inline double fresnel_dielectric(double c, double eta)
{
    return fresnel_dielectric_g(c, eta, NULL);
}

/* The transmittance 1 - F from g as above, 0 where g is (ibid., eq. 22):
 *     T_s = 4 c g / (c + g)^2,   T_p = 4 eta^2 c g / (eta^2 c + g)^2
 * 1 - F itself keeps nothing of T at a cosine of 1e-16. */
static inline double fresnel_dielectric_t(double c, double eta, double g)
{
    const double c2 = eta * eta * c, s = c + g, p = c2 + g;
    const double t = 2 * g * (c / (s * s) + c2 / (p * p));
    return t < 1 ? t : 1;
}

/* Conductor of complex relative index n + i k (ibid., 13.4.1; the real form of Lafortune's notes):
 *     2 a^2 = |q| + q',  2 b^2 = |q| - q',  q = (n + i k)^2 - sin^2 = q' + i q'',  |q| = sqrt(q'^2 + q''^2)
 *     R_s = ((a - c)^2 + b^2) / ((a + c)^2 + b^2)
 *     R_p = R_s (p - 2 a c s^2) / (p + 2 a c s^2),  p = c^2 |q| + s^4,  s^2 = sin^2
 * so that (R_s + R_p) / 2 = R_s p / (p + 2 a c s^2). Of 2 a^2 and 2 b^2 the smaller is q''^2 over the larger: no
 * cancellation for large k or small reflectance. n > 0. Plain loops over four lanes, without branches, of which
 * compilers make vectors.
 */
static inline rgb_t fresnel_conductor(double c, rgb_t n3, rgb_t k3)
{
    const double n[4] = {n3.r, n3.g, n3.b, n3.b}, k[4] = {k3.r, k3.g, k3.b, k3.b};
    const double c2 = c * c, s2 = (1 - c) * (1 + c);
    double re[4], im[4], size[4], a[4], b2[4], f[4];
    for (int i = 0; i < 4; i++) {
        re[i] = (n[i] - k[i]) * (n[i] + k[i]) - s2;
        im[i] = 2 * n[i] * k[i];
        size[i] = sqrt(re[i] * re[i] + im[i] * im[i]);
    }
    for (int i = 0; i < 4; i++) {
        const double more = 0.5 * (size[i] + fabs(re[i])); /* of a^2 and b^2 */
        const double less = more > 0 ? 0.25 * im[i] * im[i] / more : 0;
        a[i] = sqrt(re[i] >= 0 ? more : less);
        b2[i] = re[i] >= 0 ? less : more;
    }
    for (int i = 0; i < 4; i++) {
        const double ac2 = 2 * a[i] * c, p = c2 * size[i] + s2 * s2;
        const double minus = a[i] - c, plus = a[i] + c;
        f[i] = (minus * minus + b2[i]) * p / ((plus * plus + b2[i]) * (p + ac2 * s2));
    }
    return rgb(f[0], f[1], f[2]);
}

static inline double fresnel_conductor1(double c, double n, double k)
{
    return fresnel_conductor(c, rgb_gray(n), rgb_gray(k)).r;
}

/* Mean reflectance of a dielectric for diffuse light, 2 int_0^1 F(c) c dc, where the incident side has index 1 and
 * the other side eta (eta > 0; below 1 it includes total reflection). Error below 1e-13. */
double fresnel_diffuse(double eta);

#endif
