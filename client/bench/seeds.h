/* seeds.h: figures that several seeds give of one thing, with what they say about their own error: each seed is
 * left out in turn (the jackknife: Quenouille 1956, Tukey 1958). */
#ifndef CLIENT_BENCH_SEEDS_H
#define CLIENT_BENCH_SEEDS_H

#include <stddef.h>

/* A figure with the standard error that the seeds give it (by leaving out one at a time). */
typedef struct seeds_figure {
    double value, error;
} seeds_figure_t;

/* Zeroed memory; aborts if there is none, as nothing here is large. */
void *seeds_allocate(size_t count, size_t size);

/* Per-pixel standard deviation over the seeds (n - 1), over the mean of all values: its mean over the pixels and
 * its 99th percentile. NaN with fewer than two seeds, errors also with two. values: [seeds][pixels]. */
void seeds_deviation(const float *values, size_t seeds, size_t pixels, seeds_figure_t *mean,
                     seeds_figure_t *percentile);

/* Logarithm of the mean; NaN where the mean is not positive. */
seeds_figure_t seeds_log_mean(const double *values, size_t count);
/* Logarithm of the standard deviation. */
seeds_figure_t seeds_log_deviation(const double *values, size_t count);

/* A ratio and an interval around it. */
typedef struct seeds_ratio {
    double value, low, high;
} seeds_ratio_t;

/* Standard errors to either side of an interval: 95 % of it with 10 seeds (Student, 9 degrees of freedom). */
#define SEEDS_WIDTH 2.3

/* How many of them are 95 % with that many seeds (Student); NaN below two. */
double seeds_width(size_t count);

/* exp(a - b), from two independent logarithms, with SEEDS_WIDTH or another width. */
seeds_ratio_t seeds_log_ratio_within(seeds_figure_t a, seeds_figure_t b, double width);
seeds_ratio_t seeds_log_ratio(seeds_figure_t a, seeds_figure_t b);

#endif
