/* scatter.h: how far a render's own error is from the estimate of it.
 *
 * The error of a render is a random number: the estimate is of its expectation, and the image at hand is one draw.
 * With the groups' images x_g, of which the image is the mean, and signs h_g of which half are negative,
 *
 *     d = 1/G sum_g h_g x_g
 *
 * is free of what all have in common and has the image's own error in all else: the same variances, the same
 * correlations between pixels, about the same tails. For G = 16 groups the fifteen rows of a Hadamard matrix (but
 * for the row of ones) are such signs, and their contrasts are uncorrelated: fifteen draws of the image's error,
 * each with its relMSE (McCarthy, Pseudo-replication: half samples, 1969). The spread of these is how the render's
 * own relMSE scatters, that of their mean how the estimate does. Where a length has units in fewer groups, their
 * contrasts by a cosine transform stand in, and fewer degrees of freedom are counted.
 *
 * Passes of samples are points of nets (plan_nets.h), and what one group has of a sequence goes with what another
 * has: the fifteen contrasts have variances of their own, by how they cut the sequences, and would scatter by that.
 * But errors of samples hang together over few pixels only. So each draw has all fifteen contrasts, in bands of the
 * image one after the other, and they are alike again. */
#ifndef STATS_SCATTER_H
#define STATS_SCATTER_H

#include <stdbool.h>

#include "stats/groups.h"

typedef struct scatter {
    double own;       /* relative standard deviation of a render's relMSE */
    double estimate;  /* and of the estimate */
    double freedom;   /* degrees of freedom of both, by Satterthwaite: 15 where all lengths have all groups */
    double dominance; /* the largest part that a single group has in the squared deviations, of sixteen that are
                         alike */
} scatter_t;

/* The variance of the sum of a length's groups at the spots, as they are weighted: their part in relMSE. 0 while
 * fewer than two groups have units. */
double scatter_part(const groups_t *groups, uint32_t k, double factor, const double *weights);

/* factor[k]: the image's light of length k is that times the film's. weights: of the squared errors at the spots.
 * nets: lengths[0] is of samples.
 * False without memory, or while a length that has units has them in fewer than three groups. */
bool scatter_measure(scatter_t *scatter, const groups_t *groups, const double *factor,
                     const double weights[GROUPS_SPOTS], bool nets);

#endif
