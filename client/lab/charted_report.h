/* charted_report.h: the experiment on charts as figures: table 1 of the paper, text, JSON, pictures.
 *
 * Root mean square errors of the six algorithms at two numbers of samples, 1 : 8 as in the paper, against the
 * picture by quadrature; mean and standard error over independent runs. The report is a function of (steps, large,
 * seed).
 */
#ifndef LAB_CHARTED_REPORT_H
#define LAB_CHARTED_REPORT_H

#include <stdint.h>
#include <stdio.h>

#include "base/json.h"
#include "client/lab/charted_chains.h"
#include "film/image.h"

enum { CHARTED_REPORT_COUNTS = 2, CHARTED_REPORT_CLAIMS = 7, CHARTED_REPORT_RATIO = 8 };
#define CHARTED_REPORT_LARGE 0.1 /* the customary probability of a large step */
/* Runs at each number of samples. */
extern const int charted_report_runs[CHARTED_REPORT_COUNTS];

typedef struct charted_figures {
    double mean, error;        /* of the root mean square error over the runs; its standard error */
    double accepted;           /* share of the steps */
    double swapped;            /* share of the exchanges; 0 without */
    charted_picture_t picture; /* of the first run */
} charted_figures_t;

/* The paper's table 1, [count][algorithm]; its numbers of samples are 16 and 128 million. */
extern const double charted_report_paper[CHARTED_REPORT_COUNTS][CHARTED_ALGORITHMS];

/* "better has a smaller error than worse", as table 1 has it. */
typedef struct charted_claim {
    charted_algorithm_t better, worse;
} charted_claim_t;
extern const charted_claim_t charted_report_claims[CHARTED_REPORT_CLAIMS];

typedef struct charted_report {
    uint64_t samples[CHARTED_REPORT_COUNTS], seed;
    charted_setup_t setup;
    charted_picture_t reference;
    charted_figures_t figures[CHARTED_REPORT_COUNTS][CHARTED_ALGORITHMS];
} charted_report_t;

/* The error of one algorithm over `runs` >= 2 runs on the streams first, first + 1, ... of the seed. Out of memory
 * aborts, as nothing here is large. */
void charted_report_measure(charted_figures_t *figures, charted_algorithm_t algorithm, const charted_setup_t *setup,
                            const charted_picture_t *reference, uint64_t samples, int runs, uint64_t seed,
                            uint64_t first);
/* The quotient of two independent means, and in *error (may be null) its standard error to first order. */
double charted_report_quotient(const charted_figures_t *a, const charted_figures_t *b, double *error);
/* Fills *report (3 MB: on the heap); `steps` is the larger number of samples, `large` the probability of a large
 * step, in (0,1]. Some 0.12 us for a step of a run. */
void charted_report_run(charted_report_t *report, uint64_t steps, double large, uint64_t seed);
void charted_report_print(const charted_report_t *report, FILE *out);
json_t *charted_report_json(const charted_report_t *report);
/* The reference and the six pictures side by side, a row for each number of samples. The caller clears it. */
fault_code_t charted_report_montage(const charted_report_t *report, image_t *image, fault_t *fault);
/* The exposure with which the reference's mean is a middling grey. */
double charted_report_exposure(const charted_report_t *report);

#endif
