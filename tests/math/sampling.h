/* sampling.h: what tests of samplers share: a fixed stream of numbers, comparisons that print both values,
 * chi-square and Kolmogorov-Smirnov tests. A statistical test fails at p < SAMPLING_ALARM: the chance that a right
 * sampler fails one, were the seed not fixed. */
#ifndef TESTS_MATH_SAMPLING_H
#define TESTS_MATH_SAMPLING_H

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/random.h"
#include "math/vec.h"
#include "support/near.h"

#define SAMPLING_ALARM 1e-6

#define assert_unit_interval(u)                                                                                    \
    do {                                                                                                           \
        const double u_ = (u);                                                                                     \
        if (!(u_ >= 0 && u_ < 1))                                                                                  \
            fail_msg("%s = %.17g, expected a number in [0,1)", #u, u_);                                            \
    } while (0)

#define assert_vec3_near(found, wanted, tolerance)                                                                 \
    do {                                                                                                           \
        const vec3_t a_ = (found), b_ = (wanted);                                                                  \
        const double off_ = vec3_length(vec3_sub(a_, b_)), limit_ = (tolerance);                                   \
        if (!(off_ <= limit_))                                                                                     \
            fail_msg("%s = (%.17g, %.17g, %.17g), expected %s = (%.17g, %.17g, %.17g): off by %g > %g", #found,    \
                     a_.x, a_.y, a_.z, #wanted, b_.x, b_.y, b_.z, off_, limit_);                                   \
    } while (0)

/* Numbers in [0,1) from a fixed seed. */
typedef struct stream {
    uint64_t key, next;
} stream_t;

static inline stream_t stream_of(uint64_t index)
{
    return (stream_t){random_key(2385, RANDOM_PURPOSE_TEST, 0, index), 0};
}

static inline double stream_number(stream_t *stream)
{
    return random_double(stream->key, stream->next++);
}

static inline vec3_t stream_direction(stream_t *stream)
{
    const double z = 1 - 2 * stream_number(stream), phi = 2 * MATH_PI * stream_number(stream);
    const double r = sqrt(1 - z * z);
    return vec3(r * cos(phi), r * sin(phi), z);
}

/* Chance of counts at least as far from `expected` (which must add up to the number of samples). Bins of fewer than
 * 10 expected are pooled; a count where nothing is expected is impossible. */
static inline double sampling_chi_square(const double *counts, const double *expected, size_t bins)
{
    double statistic = 0, pool_count = 0, pool_expected = 0;
    int degrees = -1;
    for (size_t i = 0; i < bins; i++) {
        if (expected[i] == 0 && counts[i] > 0)
            return 0;
        pool_count += counts[i];
        pool_expected += expected[i];
        if (pool_expected < 10)
            continue;
        statistic += (pool_count - pool_expected) * (pool_count - pool_expected) / pool_expected;
        pool_count = pool_expected = 0;
        degrees++;
    }
    if (pool_expected > 0) {
        statistic += (pool_count - pool_expected) * (pool_count - pool_expected) / pool_expected;
        degrees++;
    }
    return degrees > 0 ? gsl_cdf_chisq_Q(statistic, degrees) : 1;
}

static inline void assert_distribution(const char *what, const double *counts, const double *expected, size_t bins)
{
    const double p = sampling_chi_square(counts, expected, bins);
    if (!(p >= SAMPLING_ALARM))
        fail_msg("%s: chi-square p = %g, alarm at %g", what, p, SAMPLING_ALARM);
}

static inline int sampling_compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Kolmogorov-Smirnov against the uniform law on [0,1); sorts `values`. Asymptotic law, Stephens's correction. */
static inline void assert_uniform(const char *what, double *values, size_t count)
{
    qsort(values, count, sizeof *values, sampling_compare);
    double d = 0;
    for (size_t i = 0; i < count; i++)
        d = fmax(d, fmax(values[i] - (double)i / (double)count, (double)(i + 1) / (double)count - values[i]));
    const double root = sqrt((double)count), lambda = (root + 0.12 + 0.11 / root) * d;
    double p = 0;
    for (int k = 1; k < 100; k++)
        p += (k % 2 ? 2 : -2) * exp(-2.0 * k * k * lambda * lambda);
    if (lambda > 0.3 && !(p >= SAMPLING_ALARM)) /* below 0.3 the series is slow, and p is 1 */
        fail_msg("%s: Kolmogorov-Smirnov D = %g, p = %g, alarm at %g", what, d, p, SAMPLING_ALARM);
}

#endif
