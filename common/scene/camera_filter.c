#include "scene/camera_filter.h"

#include <math.h>

/* pbrt's Gaussian: exp(-x^2 / (2 sigma^2)) minus its value at the radius; its integral over +-radius. */
static double gaussian(double radius, double sigma, double x)
{
    const double s = 0.5 / (sigma * sigma);
    const double rim = exp(-s * radius * radius);
    const double integral = sigma * sqrt(2 * MATH_PI) * erf(radius / (sigma * sqrt(2.0))) - 2 * radius * rim;
    return fmax(exp(-s * x * x) - rim, 0) / integral;
}

double camera_filter_value(uint32_t filter, double radius, double sigma, double x)
{
    x = fabs(x);
    if (!(x < radius))
        return 0;
    switch (filter) {
    case SCENE_FILTER_TRIANGLE:
        return (radius - x) / (radius * radius);
    case SCENE_FILTER_GAUSSIAN:
        return gaussian(radius, sigma, x);
    default:
        return 0.5 / radius;
    }
}

double camera_filter_sum(uint32_t filter, double radius, double sigma, double x)
{
    const double first = ceil(x - radius - 0.5), last = floor(x + radius - 0.5);
    double sum = 0;
    for (double pixel = first; pixel <= last; pixel++)
        sum += camera_filter_value(filter, radius, sigma, x - (pixel + 0.5));
    return sum;
}

/* The offset o must take a splat at x to pixel j with the chance h_j(x) = f(x - c_j) / H(x): P(floor(x + o) <= j) =
 * sum_{i <= j} h_i(x). With y = j + 1 - x that is P(o < y) = sum_{m >= 0} f(y - 1/2 - m) / sum_m f(y - 1/2 - m), a
 * function of y alone; it rises with y where f is log-concave, as all three filters are. */
static double offset_cdf(uint32_t filter, double radius, double sigma, double y)
{
    double below = 0, above = 0;
    for (double a = y - 0.5; a > -radius; a--)
        below += camera_filter_value(filter, radius, sigma, a);
    for (double a = y + 0.5; a < radius; a++)
        above += camera_filter_value(filter, radius, sigma, a);
    if (!(below + above > 0)) /* a Gaussian that underflows between two pixels: the nearer one */
        return y < 0 ? 0 : 1;
    return below / (below + above);
}

void camera_filter_tabulate(uint32_t filter, double radius, double sigma, double *cdf)
{
    const double reach = radius - 0.5;
    cdf[0] = 0;
    for (int i = 1; i < CAMERA_FILTER_STEPS; i++) {
        const double p = offset_cdf(filter, radius, sigma, (2.0 * i / CAMERA_FILTER_STEPS - 1) * reach);
        cdf[i] = fmin(fmax(p, cdf[i - 1]), 1);
    }
    cdf[CAMERA_FILTER_STEPS] = 1;
}

double camera_filter_invert(const double *cdf, double radius, double u)
{
    int low = 0, high = CAMERA_FILTER_STEPS; /* cdf[low] <= u < cdf[high] */
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (cdf[middle] <= u)
            low = middle;
        else
            high = middle;
    }
    const double place = low + (u - cdf[low]) / (cdf[high] - cdf[low]);
    return (2 * place / CAMERA_FILTER_STEPS - 1) * (radius - 0.5);
}
