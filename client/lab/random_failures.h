/* random_failures.h: the published test of rectified proposal failures, where every state fails equally often.
 *
 * Rectifying Proposal Failures in Metropolis Light Transport (2019), section 4.1 and table 2: the target is a
 * normal density of mean 3 and standard deviation 2; a proposal is set to zero with probability p, whatever the
 * state. Cost: 1600 proposals. Quality: the root mean square of (share - exact) over the bins of a histogram,
 * averaged over runs. The paper names neither bins nor the proposals' spread; 60 bins on [-3,9] and normal steps of
 * 3 give its figures.
 */
#ifndef LAB_RANDOM_FAILURES_H
#define LAB_RANDOM_FAILURES_H

#include <stdbool.h>
#include <stdint.h>

#include "client/lab/histogram.h"
#include "client/lab/stream.h"

enum { RANDOM_FAILURES_BINS = 60, RANDOM_FAILURES_PROPOSALS = 1600 };

/* One chain of 1600 proposals from a state drawn from the target; `rectified`: failures do not count. */
void random_failures_run(histogram_t *result, double failure, bool rectified, stream_t *stream);
void random_failures_exact(double exact[RANDOM_FAILURES_BINS]);

typedef struct random_failures_error {
    double mean, error; /* of the root mean square; the standard error of its mean */
} random_failures_error_t;
/* Over `runs` >= 2 chains, on the streams first, first + 1, ... of the seed. */
random_failures_error_t random_failures_measure(double failure, bool rectified, int runs, uint64_t seed,
                                                uint64_t first);

#endif
