/* jackknife.h: what noise does to the weights of a render's squared errors, and what they would be without.
 *
 * relMSE weighs the squared error of a pixel by w(R) = 1 / (R^2 + 0.01 m^2), R the reference. A render has its own
 * noisy image x instead, and weights from it are wrong twice, both to second order in the noise: where the pixel
 * itself is too bright its variance is large and its weight small (w(x) is too small); and as w is convex the mean
 * of w over the noise is above w of the mean (too large). A filter over neighbours (plan_estimate.c) trades both
 * for a third: dark pixels between bright ones get too little weight.
 *
 * Groups of units are independent. So the square of the difference of two groups is weighed by the image of the
 * fourteen others: of the two errors the first is gone. The second is, to first order, in proportion to the
 * variance of the weighing image, and with one group less, thirteen, it is 14 / 13 as large:
 *
 *     14 (weights by fourteen) - 13 (mean of the weights by thirteen)
 *
 * has neither (where groups are independent; where they are points of nets, plan_nets.h, the step is another one):
 * the jackknife (Quenouille, Notes on bias in estimation, 1956). All of that at the spots (groups.h), in
 * luminance, and as a ratio to the same squares with the weights at hand, in which the squares' own scatter
 * cancels. */
#ifndef STATS_JACKKNIFE_H
#define STATS_JACKKNIFE_H

#include <stdbool.h>

#include "stats/groups.h"

typedef struct jackknife {
    double ratio; /* relMSE by these weights over that by the weights at hand */
    double error; /* standard error of that: of what the pairs of groups tell, by how unlike they are (what is
                     common to all of them, noise of the weights, is not in it), and of what was known beforehand */
    double room;  /* how much larger the ratio may be, relatively, by higher orders: with the logarithms in place of
                     the values the same points lead to one that is larger by about this */
} jackknife_t;

/* factor[k]: the image's light of length k is that times the film's; errors[k]: its errors are that times what
 * groups differ by. floor: 0.01 m^2. weights: those at hand, at the spots. prior: by what is known beforehand the
 * ratio is 1 within this standard deviation; what the groups tell is weighed against it. False, and a ratio of 1,
 * without memory; while a length that has units does not have them in all groups; and where noise is so strong that
 * by the image itself, or by fourteen groups, it is off by more than a factor of two: such an error is no small
 * one, and nothing is known about the next order. */
bool jackknife_measure(jackknife_t *out, const groups_t *groups, const double *factor, const double *errors,
                       double floor, const double weights[GROUPS_SPOTS], double prior);

#endif
