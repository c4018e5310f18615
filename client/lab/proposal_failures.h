/* proposal_failures.h: what to do with proposals that the target gives zero: the published remedy, and unbiased
 * ones.
 *
 * Target f(x) = 2x on [0,1], zero elsewhere; proposals y = x + sigma z, z standard normal. A proposal outside [0,1]
 * fails. How often depends on the state: p_fail(x) = 1 - (Phi((1-x)/sigma) - Phi(-x/sigma)).
 *
 *   FAILURE_PLAIN      Metropolis and Hastings: after a failure the state counts once more
 *   FAILURE_RECTIFIED  Rectifying Proposal Failures in Metropolis Light Transport (2019), algorithm 1: a failure
 * does not count. Its law is not f: see failures_law FAILURE_EXPECTED   plain, with expected values: x counts 1-a
 * and y counts a, accepted or not (Veach and Guibas 1997, section 5.3) FAILURE_DELAYED    after a failure a second,
 * smaller step from the same state (Tierney and Mira 1999), with the ratio below FAILURE_BOTH       delayed
 * rejection with expected values
 *
 * The law of the rectified chain. Where a failure does not count, the chain is the Metropolis chain with the
 * proposals q'(x,y) = q(x,y) / (1 - p_fail(x)), y in [0,1], and the ratio f(y) / f(x) as if q' were symmetric. Its
 * transitions satisfy, with a = min(1, f(y)/f(x)), f(x) (1 - p_fail(x)) q'(x,y) a(x,y) = f(x) q(x,y) a(x,y), which
 * is symmetric in x and y: detailed balance holds for f (1 - p_fail), and for f only where p_fail is the same in
 * every state, as in the paper's own test (random_failures.h).
 *
 * The ratio of delayed rejection. Tierney and Mira (Some adaptive Monte Carlo methods for Bayesian inference,
 * Statistics in Medicine 18, 1999, the ratio of the second stage): after a rejected y the proposal z from q2(x, y,
 * .) is accepted with f(z) q1(z,y) (1 - a1(z,y)) q2(z,y,x) / (f(x) q1(x,y) (1 - a1(x,y)) q2(x,y,z)). Here the
 * second stage follows only a y with f(y) = 0. Then a1(x,y) = a1(z,y) = 0, and from z the same y would have led to
 * the second stage too, so that the pairs (x,y,z) and (z,y,x) are each other's reverse. q2 is symmetric in x and z
 * and does not know y. What remains is f(z) q1(z,y) / (f(x) q1(x,y)) = f(z)/f(x) exp(((x-y)^2 - (z-y)^2) / (2
 * sigma^2)). Leaving out q1(z,y)/q1(x,y) would be wrong: a failure at y is likelier from a state near y.
 */
#ifndef LAB_PROPOSAL_FAILURES_H
#define LAB_PROPOSAL_FAILURES_H

#include <stdint.h>

#include "client/lab/histogram.h"
#include "client/lab/stream.h"

enum { FAILURE_BINS = 50 };
#define FAILURE_SHRINK 0.25 /* the second step of delayed rejection, relative to the first */

typedef enum failure_method {
    FAILURE_PLAIN = 0,
    FAILURE_RECTIFIED = 1,
    FAILURE_EXPECTED = 2,
    FAILURE_DELAYED = 3,
    FAILURE_BOTH = 4,
    FAILURE_METHODS = 5
} failure_method_t;

extern const char *const failures_names[FAILURE_METHODS];

/* One chain from a state drawn from f, until the target has been evaluated `evaluations` times (a second step of
 * delayed rejection that begins within them is finished). Fills *result: FAILURE_BINS bins on [0,1]. */
void failures_run(histogram_t *result, failure_method_t method, double sigma, uint64_t evaluations,
                  stream_t *stream);
/* Exact probabilities of the bins under f. */
void failures_exact(double exact[FAILURE_BINS]);
/* Probabilities of the bins under f (1 - p_fail), normalised, by quadrature (composite midpoint rule); returns
 * p_fail's mean under f. */
double failures_law(double sigma, double law[FAILURE_BINS]);

/* The mean over `runs` chains of the mean squared error of the histogram, and its standard error. Runs use the
 * streams first, first + 1, ... of the seed. */
typedef struct failure_error {
    double mean, error;
} failure_error_t;
failure_error_t failures_measure(failure_method_t method, double sigma, uint64_t evaluations, int runs,
                                 uint64_t seed, uint64_t first);

#endif
