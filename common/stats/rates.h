/* rates.h: how often independent samples go to which length (chain/cutoff.h).
 *
 * Let X_k be what a sample brings of length k, T_k = X_k + X_{k+1} + ... its tail, and L the length it goes to.
 * Where the L of a pixel's samples are spread evenly over their law, the variance of sum_{k <= L} X_k / rate_k is
 *
 *     sum_{j,k} Cov(X_j, X_k) / max(rate_j, rate_k) = sum_k (Var T_k - Var T_{k+1}) / rate_k,
 *
 * as rates fall with k, so that the larger of two is that of the shorter length. The cost is sum_k rate_k a_k, a_k
 * what it costs to go from k - 1 to k. Without the order the product is least at rate_k in proportion to
 * sqrt(D_k / a_k), D_k being the difference of variances. With it neighbours that are out of order share one rate,
 * that of their sums (pool adjacent violators; Barlow, Bartholomew, Bremner, Brunk 1972). What the variances are
 * taken from is a small batch: no length is left to less than one sample in RATES_SELDOM.
 *
 * Samples of a pixel are points of nets, which make the noise of short lengths less than that of independent ones,
 * and a sample costs more than its rays. So where rates promise less than RATES_GAIN, as work without them over
 * work with, all are 1: of 1.07 to 1.15 in tests/scenes/glossy.pbrt renders kept .95, of 1.29 in diffuse.pbrt 1.13.
 */
#ifndef STATS_RATES_H
#define STATS_RATES_H

#include <stdint.h>

enum { RATES_SELDOM = 16 };
#define RATES_GAIN 1.2

/* Variance and cost of a sample. */
typedef struct rates_figures {
    double variance, cost;
} rates_figures_t;

/* The rates that make variance x cost least, or 1 where that gains too little: of length k = 1 .. count in [k - 1],
 * as D_k in parts[] (below 0 counts as 0) and a_k in costs[]. rates[0] is 1. count is at most PATH_MAX_LENGTH. */
rates_figures_t rates_best(const double *parts, const double *costs, uint32_t count, double *rates);

#endif
