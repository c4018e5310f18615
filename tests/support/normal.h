/* normal.h: normal numbers from uniform ones. */
#ifndef TESTS_SUPPORT_NORMAL_H
#define TESTS_SUPPORT_NORMAL_H

#include <math.h>

/* A standard normal number (Box and Muller 1958) from u and v in [0,1). */
static inline double normal_of(double u, double v)
{
    return sqrt(-2 * log(1 - u)) * cos(6.283185307179586477 * v);
}

#endif
