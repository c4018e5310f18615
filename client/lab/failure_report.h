/* failure_report.h: the experiments on failed proposals as figures: text, JSON, SVG.
 *
 * The paper's table (random_failures.h), the law of the rectified chain by quadrature and by chains, and the mean
 * squared error of each method relative to plain Metropolis-Hastings at FAILURE_REPORT_EVALUATIONS evaluations of
 * the target. The report is a function of (steps, seed).
 */
#ifndef LAB_FAILURE_REPORT_H
#define LAB_FAILURE_REPORT_H

#include <stdint.h>
#include <stdio.h>

#include "base/json.h"
#include "client/lab/proposal_failures.h"
#include "client/lab/random_failures.h"

enum {
    FAILURE_REPORT_RATES = 2,
    FAILURE_REPORT_LAWS = 5,
    FAILURE_REPORT_SIGMAS = 3,
    FAILURE_REPORT_CHAINS = 32,
    FAILURE_REPORT_EVALUATIONS = 10000
};

/* The rectified chain at one sigma. */
typedef struct failure_law {
    double sigma, mean_failure;
    double predicted;            /* total variation of the law from f, by quadrature */
    double measured;             /* total variation of the chains from f */
    double from_law, noise;      /* of the chains from the law; what noise alone would give, by expectation */
    double states[FAILURE_BINS]; /* share of the bin */
} failure_law_t;

typedef struct failure_report {
    uint64_t steps, seed;
    int runs, table_runs;
    double rates[FAILURE_REPORT_RATES];
    random_failures_error_t table[FAILURE_REPORT_RATES][2]; /* plain, rectified */
    failure_law_t laws[FAILURE_REPORT_LAWS];
    double sigmas[FAILURE_REPORT_SIGMAS];
    failure_error_t relative[FAILURE_REPORT_SIGMAS][FAILURE_METHODS]; /* to plain */
} failure_report_t;

/* Chains of `evaluations` evaluations in all; streams first, first + 1, ... of the seed. */
void failure_report_measure_law(failure_law_t *law, double sigma, uint64_t evaluations, uint64_t seed,
                                uint64_t first);
/* a / b of independent estimates, with the standard error to first order. */
failure_error_t failure_report_ratio(failure_error_t a, failure_error_t b);
/* Fills *report; steps (at least 20,000) is the number of evaluations for each figure. */
void failure_report_run(failure_report_t *report, uint64_t steps, uint64_t seed);
void failure_report_print(const failure_report_t *report, FILE *out);
json_t *failure_report_json(const failure_report_t *report);
char *failure_report_svg(const failure_report_t *report); /* the caller frees it */

#endif
