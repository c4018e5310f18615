/* vec.h: points, vectors and linear RGB colours in double precision, by value. */
#ifndef MATH_VEC_H
#define MATH_VEC_H

#include <math.h>
#include <stdbool.h>

#define MATH_PI 3.14159265358979323846
#define MATH_INV_PI 0.31830988618379067154
/* The largest double below 1. */
#define MATH_ONE_MINUS 0x1.fffffffffffffp-1

/* The larger and the smaller of two numbers, in one instruction each (the library's fmax and fmin are calls). The
 * second if either is NaN. */
static inline double math_max(double a, double b)
{
    return a > b ? a : b;
}
static inline double math_min(double a, double b)
{
    return a < b ? a : b;
}

typedef struct vec2 {
    double x, y;
} vec2_t;

typedef struct vec3 {
    double x, y, z;
} vec3_t;

/* Linear RGB with Rec. 709 primaries: radiance, reflectance or throughput. */
typedef struct rgb {
    double r, g, b;
} rgb_t;

static inline vec3_t vec3(double x, double y, double z)
{
    return (vec3_t){x, y, z};
}
static inline vec3_t vec3_add(vec3_t a, vec3_t b)
{
    return (vec3_t){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline vec3_t vec3_sub(vec3_t a, vec3_t b)
{
    return (vec3_t){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline vec3_t vec3_scale(vec3_t a, double s)
{
    return (vec3_t){a.x * s, a.y * s, a.z * s};
}
static inline vec3_t vec3_neg(vec3_t a)
{
    return (vec3_t){-a.x, -a.y, -a.z};
}
/* a + s b */
static inline vec3_t vec3_mad(vec3_t a, double s, vec3_t b)
{
    return (vec3_t){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
static inline double vec3_dot(vec3_t a, vec3_t b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline vec3_t vec3_cross(vec3_t a, vec3_t b)
{
    return (vec3_t){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/* a b - c d with an error of 1.5 units in the last place, however much it cancels (Kahan; Jeannerod, Louvet and
 * Muller: Further analysis of Kahan's algorithm for the accurate computation of 2x2 determinants, 2013). */
static inline double math_difference_of_products(double a, double b, double c, double d)
{
    const double cd = c * d;
    const double error = fma(-c, d, cd);
    return fma(a, b, -cd) + error;
}
/* The same product where a and b are all but parallel: the normal of a needle. */
static inline vec3_t vec3_cross_exact(vec3_t a, vec3_t b)
{
    return (vec3_t){math_difference_of_products(a.y, b.z, a.z, b.y),
                    math_difference_of_products(a.z, b.x, a.x, b.z),
                    math_difference_of_products(a.x, b.y, a.y, b.x)};
}
static inline double vec3_length(vec3_t a)
{
    return sqrt(vec3_dot(a, a));
}
/* a / |a|; a must not be zero. */
static inline vec3_t vec3_unit(vec3_t a)
{
    return vec3_scale(a, 1.0 / vec3_length(a));
}
static inline double vec3_max_abs(vec3_t a)
{
    return math_max(fabs(a.x), math_max(fabs(a.y), fabs(a.z)));
}
/* Of each component. */
static inline vec3_t vec3_min(vec3_t a, vec3_t b)
{
    return (vec3_t){math_min(a.x, b.x), math_min(a.y, b.y), math_min(a.z, b.z)};
}
static inline vec3_t vec3_max(vec3_t a, vec3_t b)
{
    return (vec3_t){math_max(a.x, b.x), math_max(a.y, b.y), math_max(a.z, b.z)};
}
static inline bool vec3_finite(vec3_t a)
{
    return isfinite(a.x + a.y + a.z);
}

static inline rgb_t rgb(double r, double g, double b)
{
    return (rgb_t){r, g, b};
}
static inline rgb_t rgb_gray(double v)
{
    return (rgb_t){v, v, v};
}
static inline rgb_t rgb_add(rgb_t a, rgb_t b)
{
    return (rgb_t){a.r + b.r, a.g + b.g, a.b + b.b};
}
static inline rgb_t rgb_mul(rgb_t a, rgb_t b)
{
    return (rgb_t){a.r * b.r, a.g * b.g, a.b * b.b};
}
static inline rgb_t rgb_scale(rgb_t a, double s)
{
    return (rgb_t){a.r * s, a.g * s, a.b * s};
}
/* a + s b */
static inline rgb_t rgb_mad(rgb_t a, double s, rgb_t b)
{
    return (rgb_t){a.r + s * b.r, a.g + s * b.g, a.b + s * b.b};
}
/* Rec. 709 luminance. */
static inline double rgb_luminance(rgb_t a)
{
    return 0.212671 * a.r + 0.715160 * a.g + 0.072169 * a.b;
}
static inline double rgb_max(rgb_t a)
{
    return math_max(a.r, math_max(a.g, a.b));
}
static inline double rgb_mean(rgb_t a)
{
    return (a.r + a.g + a.b) * (1.0 / 3.0);
}
static inline bool rgb_black(rgb_t a)
{
    return a.r == 0 && a.g == 0 && a.b == 0;
}

#endif
