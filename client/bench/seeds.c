#include "client/bench/seeds.h"

#include <math.h>
#include <stdlib.h>

void *seeds_allocate(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory)
        abort();
    return memory;
}

/* sqrt((n-1)/n sum (theta_i - mean)^2), theta_i the figure without seed i. */
static double jackknife_error(const double *without, size_t count)
{
    const double n = (double)count;
    double mean = 0, sum = 0;
    for (size_t i = 0; i < count; i++)
        mean += without[i] / n;
    for (size_t i = 0; i < count; i++)
        sum += (without[i] - mean) * (without[i] - mean);
    return sqrt((n - 1) / n * sum);
}

/* ---- images ---- */

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sums over all seeds, and room for the deviations. */
typedef struct pixel_sums {
    size_t seeds, pixels;
    double *first, *second, *deviation; /* of differences from the first seed, so that nothing cancels */
    double total;                       /* of all values */
} pixel_sums_t;

static pixel_sums_t pixel_sums(const float *values, size_t seeds, size_t pixels)
{
    pixel_sums_t s = {seeds,
                      pixels,
                      seeds_allocate(pixels, sizeof(double)),
                      seeds_allocate(pixels, sizeof(double)),
                      seeds_allocate(pixels, sizeof(double)),
                      0};
    for (size_t j = 0; j < seeds; j++)
        for (size_t i = 0; i < pixels; i++) {
            const double value = (double)values[j * pixels + i], d = value - (double)values[i];
            s.first[i] += d;
            s.second[i] += d * d;
            s.total += value;
        }
    return s;
}

/* The two figures without one seed, or with all (without = seeds). */
static void pixel_figures(const pixel_sums_t *s, const float *values, size_t without, double *mean,
                          double *percentile)
{
    const size_t pixels = s->pixels;
    const double n = without < s->seeds ? (double)s->seeds - 1 : (double)s->seeds;
    double total = s->total, sum = 0;
    for (size_t i = 0; i < pixels; i++) {
        double first = s->first[i], second = s->second[i];
        if (without < s->seeds) {
            const double value = (double)values[without * pixels + i], d = value - (double)values[i];
            first -= d;
            second -= d * d;
            total -= value;
        }
        s->deviation[i] = sqrt(fmax(0, (second - first * first / n) / (n - 1)));
        sum += s->deviation[i];
    }
    const double scale = n * (double)pixels / total;
    qsort(s->deviation, pixels, sizeof *s->deviation, ascending);
    *mean = n > 1 ? sum / (double)pixels * scale : NAN;
    *percentile = n > 1 ? s->deviation[(size_t)(0.99 * (double)(pixels - 1))] * scale : NAN;
}

void seeds_deviation(const float *values, size_t seeds, size_t pixels, seeds_figure_t *mean,
                     seeds_figure_t *percentile)
{
    pixel_sums_t s = pixel_sums(values, seeds, pixels);
    double *means = seeds_allocate(seeds, sizeof *means), *percentiles = seeds_allocate(seeds, sizeof *percentiles);
    for (size_t j = 0; j < seeds; j++)
        pixel_figures(&s, values, j, &means[j], &percentiles[j]);
    pixel_figures(&s, values, seeds, &mean->value, &percentile->value);
    mean->error = jackknife_error(means, seeds);
    percentile->error = jackknife_error(percentiles, seeds);
    free(means);
    free(percentiles);
    free(s.first);
    free(s.second);
    free(s.deviation);
}

/* ---- numbers ---- */

typedef double seeds_statistic_t(const double *values, size_t count, size_t without);

/* Values with one left out; without = count: none. */
static double log_mean(const double *values, size_t count, size_t without)
{
    double sum = 0, n = 0;
    for (size_t i = 0; i < count; i++)
        if (i != without) {
            sum += values[i];
            n++;
        }
    return sum > 0 ? log(sum / n) : NAN;
}

static double log_deviation(const double *values, size_t count, size_t without)
{
    double mean = 0, sum = 0, n = 0;
    for (size_t i = 0; i < count; i++)
        if (i != without) {
            mean += values[i];
            n++;
        }
    mean /= n;
    for (size_t i = 0; i < count; i++)
        if (i != without)
            sum += (values[i] - mean) * (values[i] - mean);
    return n > 1 && sum > 0 ? log(sqrt(sum / (n - 1))) : NAN;
}

static seeds_figure_t seeds_figure(seeds_statistic_t *statistic, const double *values, size_t count)
{
    double *without = seeds_allocate(count, sizeof *without);
    for (size_t i = 0; i < count; i++)
        without[i] = statistic(values, count, i);
    const seeds_figure_t figure = {statistic(values, count, count),
                                   count > 1 ? jackknife_error(without, count) : NAN};
    free(without);
    return figure;
}

seeds_figure_t seeds_log_mean(const double *values, size_t count)
{
    return seeds_figure(log_mean, values, count);
}

seeds_figure_t seeds_log_deviation(const double *values, size_t count)
{
    return seeds_figure(log_deviation, values, count);
}

double seeds_width(size_t count)
{
    /* 97.5 % quantiles of Student's t with 1, 2, ... degrees of freedom; from 11 on Cornish and Fisher's expansion
     * (Abramowitz, Stegun 26.7.5) to 1/n^2, within 0.003 */
    static const double exact[] = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228};
    enum { EXACT = sizeof exact / sizeof *exact };
    if (count < 2)
        return NAN;
    if (count - 1 <= EXACT)
        return exact[count - 2];
    const double z = 1.959964, z3 = z * z * z, z5 = z3 * z * z, n = (double)(count - 1);
    return z + (z3 + z) / (4 * n) + (5 * z5 + 16 * z3 + 3 * z) / (96 * n * n);
}

seeds_ratio_t seeds_log_ratio_within(seeds_figure_t a, seeds_figure_t b, double width)
{
    const double log_ratio = a.value - b.value, half = width * hypot(a.error, b.error);
    return (seeds_ratio_t){exp(log_ratio), exp(log_ratio - half), exp(log_ratio + half)};
}

seeds_ratio_t seeds_log_ratio(seeds_figure_t a, seeds_figure_t b)
{
    return seeds_log_ratio_within(a, b, SEEDS_WIDTH);
}
