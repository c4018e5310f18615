#include "client/lab/random_failures.h"

#include <math.h>

#define MEAN 3.0
#define DEVIATION 2.0
#define STEP 3.0
#define LO (-3.0)
#define HI 9.0

static double log_target(double x)
{
    const double z = (x - MEAN) / DEVIATION;
    return -0.5 * z * z;
}

void random_failures_run(histogram_t *result, double failure, bool rectified, stream_t *stream)
{
    double x = MEAN + DEVIATION * stream_normal(stream);
    *result = histogram_make(LO, HI, RANDOM_FAILURES_BINS);
    for (int i = 0; i < RANDOM_FAILURES_PROPOSALS; i++) {
        const double y = x + STEP * stream_normal(stream);
        const bool failed = stream_uniform(stream) < failure;
        if (failed && rectified)
            continue;
        if (!failed && stream_uniform(stream) < exp(log_target(y) - log_target(x)))
            x = y;
        histogram_add(result, x, 1);
    }
}

void random_failures_exact(double exact[RANDOM_FAILURES_BINS])
{
    const double width = (HI - LO) / RANDOM_FAILURES_BINS;
    for (int k = 0; k < RANDOM_FAILURES_BINS; k++) {
        const double a = (LO + k * width - MEAN) / DEVIATION, b = (LO + (k + 1) * width - MEAN) / DEVIATION;
        exact[k] = 0.5 * (erf(b * sqrt(0.5)) - erf(a * sqrt(0.5)));
    }
}

random_failures_error_t random_failures_measure(double failure, bool rectified, int runs, uint64_t seed,
                                                uint64_t first)
{
    double exact[RANDOM_FAILURES_BINS], sum = 0, squares = 0;
    random_failures_exact(exact);
    for (int r = 0; r < runs; r++) {
        stream_t stream = stream_of(seed, first + (uint64_t)r);
        histogram_t h;
        random_failures_run(&h, failure, rectified, &stream);
        const double error = sqrt(histogram_mean_square(&h, exact));
        sum += error;
        squares += error * error;
    }
    const double mean = sum / runs;
    return (random_failures_error_t){mean, sqrt(math_max(0, squares / runs - mean * mean) / (runs - 1))};
}
