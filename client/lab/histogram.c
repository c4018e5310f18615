#include "client/lab/histogram.h"

#include <math.h>

#include "math/vec.h"

histogram_t histogram_sum(const histogram_t *parts, int count)
{
    histogram_t sum = histogram_make(parts[0].lo, parts[0].hi, parts[0].bins);
    for (int i = 0; i < count; i++) {
        sum.total += parts[i].total;
        for (int k = 0; k < sum.bins; k++)
            sum.weight[k] += parts[i].weight[k];
    }
    return sum;
}

double histogram_total_variation(const histogram_t *h, const double *exact)
{
    double sum = 0;
    for (int k = 0; k < h->bins; k++)
        sum += fabs(h->weight[k] / h->total - exact[k]);
    return 0.5 * sum;
}

double histogram_mean_square(const histogram_t *h, const double *exact)
{
    double sum = 0;
    for (int k = 0; k < h->bins; k++) {
        const double off = h->weight[k] / h->total - exact[k];
        sum += off * off;
    }
    return sum / h->bins;
}

double histogram_noise(const histogram_t *parts, int count)
{
    double errors = 0;
    for (int k = 0; k < parts[0].bins; k++) {
        double sum = 0, squares = 0;
        for (int i = 0; i < count; i++)
            sum += parts[i].weight[k] / parts[i].total;
        for (int i = 0; i < count; i++) {
            const double off = parts[i].weight[k] / parts[i].total - sum / count;
            squares += off * off;
        }
        errors += sqrt(squares / (count - 1) / count);
    }
    return 0.5 * sqrt(2 / MATH_PI) * errors;
}
