/* law.h: what accuracy costs: a law error(t) = a + c t^-p fitted to a render's history, and the time that it
 * says an error takes, with its uncertainty.
 *
 * t is the workers' CPU time after the pilot: from there on work is all of a kind. Errors of independent samples
 * have p = 1/2 and a = 0; chains that are slow to find something, or tails that have not been met, show as p below
 * it, and a bias would as a. The fit is a sum over a grid of (p, a), each with its best c, weighted by how well it
 * fits and by how far it is from (1/2, 0): with few points it says little else than the law of independent samples.
 * What is fitted is what relMSE is on its way to (history.h: outlook), as samples' points become even.
 * Points of one series are sums of the same units: each counts for the work that it adds to the one before, so that
 * all of them together are as sure as the last. From the weights come median and 95 % of the predicted times. */
#ifndef STATS_LAW_H
#define STATS_LAW_H

#include <stdbool.h>

#include "stats/history.h"

enum { LAW_POWERS = 25, LAW_FLOORS = 9, LAW_FITS = LAW_POWERS * LAW_FLOORS };

typedef struct law_fit {
    double a, c, p, weight; /* weights add up to one */
} law_fit_t;

typedef struct law {
    double pilot;   /* CPU seconds before t = 0 */
    double noise;   /* relative standard error of the series' last error */
    double a, c, p; /* the best fit */
    law_fit_t fits[LAW_FITS];
} law_t;

/* Fits the first `count` points. False if there are none after the pilot. */
bool law_fit(law_t *law, const history_t *history, uint32_t count, double pilot);

/* CPU seconds from the job's beginning until the error is reached. Infinite: never, by this law. */
typedef struct law_time {
    double median, low, high; /* 95 % between low and high */
} law_time_t;
law_time_t law_time(const law_t *law, double error);

#endif
