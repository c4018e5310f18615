#include "client/lab/proposal_failures.h"

#include <math.h>
#include <stdbool.h>

const char *const failures_names[FAILURE_METHODS] = {"plain", "rectified", "expected values", "delayed rejection",
                                                     "both"};

static double target(double x)
{
    return x >= 0 && x < 1 ? 2 * x : 0;
}

/* What a step proposed last, with the probability of accepting it. */
typedef struct proposal {
    double x, accept;
    int evaluations;
    bool failed; /* the target is zero there */
} proposal_t;

/* The second stage, after a failure at y. */
static void propose_again(proposal_t *p, double x, double sigma, stream_t *stream)
{
    const double y = p->x, z = x + FAILURE_SHRINK * sigma * stream_normal(stream);
    const double first_stage = exp(((x - y) * (x - y) - (z - y) * (z - y)) / (2 * sigma * sigma));
    p->x = z;
    p->failed = target(z) <= 0;
    p->accept = p->failed ? 0 : math_min(1, target(z) / target(x) * first_stage);
    p->evaluations++;
}

static proposal_t propose(double x, double sigma, bool delayed, stream_t *stream)
{
    const double y = x + sigma * stream_normal(stream);
    proposal_t p = {y, math_min(1, target(y) / target(x)), 1, target(y) <= 0};
    if (p.failed && delayed)
        propose_again(&p, x, sigma, stream);
    return p;
}

void failures_run(histogram_t *result, failure_method_t method, double sigma, uint64_t evaluations,
                  stream_t *stream)
{
    const bool delayed = method == FAILURE_DELAYED || method == FAILURE_BOTH;
    const bool expected = method == FAILURE_EXPECTED || method == FAILURE_BOTH;
    double x = sqrt(1 - stream_uniform(stream)); /* CDF x^2; never 0 */
    x = math_min(x, MATH_ONE_MINUS);
    *result = histogram_make(0, 1, FAILURE_BINS);
    for (uint64_t done = 0; done < evaluations;) {
        const proposal_t p = propose(x, sigma, delayed, stream);
        done += (uint64_t)p.evaluations;
        if (p.failed && method == FAILURE_RECTIFIED)
            continue;
        if (expected) {
            histogram_add(result, x, 1 - p.accept);
            histogram_add(result, p.x, p.accept);
        }
        if (stream_uniform(stream) < p.accept)
            x = p.x;
        if (!expected)
            histogram_add(result, x, 1);
    }
}

void failures_exact(double exact[FAILURE_BINS])
{
    for (int k = 0; k < FAILURE_BINS; k++)
        exact[k] = (2 * k + 1.0) / (FAILURE_BINS * FAILURE_BINS);
}

static double normal_cdf(double z)
{
    return 0.5 * erfc(-z * sqrt(0.5));
}

double failures_law(double sigma, double law[FAILURE_BINS])
{
    enum { PANELS = 200 }; /* a bin */
    double sum = 0;
    for (int k = 0; k < FAILURE_BINS; k++) {
        law[k] = 0;
        for (int i = 0; i < PANELS; i++) {
            const double x = (k + (i + 0.5) / PANELS) / FAILURE_BINS;
            const double success = normal_cdf((1 - x) / sigma) - normal_cdf(-x / sigma);
            law[k] += 2 * x * success / (PANELS * FAILURE_BINS);
        }
        sum += law[k];
    }
    for (int k = 0; k < FAILURE_BINS; k++)
        law[k] /= sum;
    return 1 - sum;
}

failure_error_t failures_measure(failure_method_t method, double sigma, uint64_t evaluations, int runs,
                                 uint64_t seed, uint64_t first)
{
    double exact[FAILURE_BINS], sum = 0, squares = 0;
    failures_exact(exact);
    for (int r = 0; r < runs; r++) {
        stream_t stream = stream_of(seed, first + (uint64_t)r);
        histogram_t h;
        failures_run(&h, method, sigma, evaluations, &stream);
        if (h.total <= 0)
            continue; /* nothing counted: only where there are a few evaluations */
        const double error = histogram_mean_square(&h, exact);
        sum += error;
        squares += error * error;
    }
    const double mean = sum / runs;
    return (failure_error_t){mean, sqrt(math_max(0, squares / runs - mean * mean) / (runs - 1))};
}
