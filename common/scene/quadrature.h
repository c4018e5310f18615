/* quadrature.h: nodes and weights of Gauss and Legendre on [0,1], for tables made once per scene. */
#ifndef SCENE_QUADRATURE_H
#define SCENE_QUADRATURE_H

#include <math.h>

#include "math/vec.h"

/* Fills x[n], w[n], n >= 1. Newton's method on P_n from the guess cos(pi (i + 3/4) / (n + 1/2)) (Abramowitz and
 * Stegun, 22.16.6 and 25.4.29); accurate to 1e-15. */
static inline void quadrature_gauss(int n, double *x, double *w)
{
    for (int i = 0; i < n; i++) {
        double z = cos(MATH_PI * (i + 0.75) / (n + 0.5)), derivative = 1;
        for (int step = 0; step < 8; step++) {
            double p0 = 1, p1 = z;
            for (int k = 2; k <= n; k++) {
                const double p2 = ((2 * k - 1) * z * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            derivative = n * (z * p1 - p0) / (z * z - 1);
            z -= p1 / derivative;
        }
        x[i] = 0.5 * (1 - z);
        w[i] = 1 / ((1 - z) * (1 + z) * derivative * derivative);
    }
}

#endif
