#include "scene/fresnel.h"

#include "scene/quadrature.h"

enum { NODES = 16 };

/* eta > 1. With c = b sinh x, b^2 = eta^2 - 1, the refracted part is g = b cosh x: the integrand is smooth in x on
 * a scale of 1 for every eta, also where F(c) has a boundary layer of width b. */
static double diffuse_from_outside(double eta)
{
    double x[NODES], w[NODES];
    quadrature_gauss(NODES, x, w);
    const double b = sqrt((eta - 1) * (eta + 1));
    const double end = asinh(1 / b);
    const int panels = (int)ceil(2 * end) + 1;
    const double width = end / panels;
    double sum = 0;
    for (int panel = 0; panel < panels; panel++) {
        for (int i = 0; i < NODES; i++) {
            const double t = width * (panel + x[i]);
            const double c = b * sinh(t);
            sum += width * w[i] * 2 * c * fresnel_dielectric(c, eta) * b * cosh(t);
        }
    }
    return sum;
}

/* From inside by the conservation of etendue: 1 - F(1/n) = (1 - F(n)) / n^2 (Saunderson 1942). */
double fresnel_diffuse(double eta)
{
    if (eta == 1)
        return 0;
    if (eta > 1)
        return diffuse_from_outside(eta);
    return 1 - eta * eta * (1 - diffuse_from_outside(1 / eta));
}
