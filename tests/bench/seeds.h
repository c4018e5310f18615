/* seeds.h: figures that several seeds give of one thing, with what they say about their own error: each seed is
 * left out in turn (the jackknife: Quenouille 1956, Tukey 1958). */
#ifndef TESTS_BENCH_SEEDS_H
#define TESTS_BENCH_SEEDS_H

#include "gain_data.h"

/* Per-pixel standard deviation over the seeds (n - 1), over the mean of all values: its mean over the pixels and
 * its 99th percentile. NaN with fewer than two seeds, errors also with two. values: [seeds][pixels]. */
void seeds_deviation(const float *values, size_t seeds, size_t pixels, gain_figure_t *mean,
                     gain_figure_t *percentile);

/* Logarithm of the mean; NaN where the mean is not positive. */
gain_figure_t seeds_log_mean(const double *values, size_t count);
/* Logarithm of the standard deviation. */
gain_figure_t seeds_log_deviation(const double *values, size_t count);

/* A ratio and an interval around it. */
typedef struct seeds_ratio {
    double value, low, high;
} seeds_ratio_t;

/* Standard errors to either side of an interval: 95 % of it with 10 seeds (Student, 9 degrees of freedom). */
#define SEEDS_WIDTH 2.3

/* exp(a - b), from two independent logarithms. */
seeds_ratio_t seeds_log_ratio(gain_figure_t a, gain_figure_t b);

#endif
