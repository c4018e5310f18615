/* jump.h: the path stays, its technique and its numbers change.
 *
 * From (s, u) with x = S_s(u): draw s', take v = R_s'(x) (path/inverse.h), go to (s', v). C is a function of x, and
 * the Jacobian of the change of numbers is p_s / p_s' = w_s / w_s', so the acceptance ratio is
 *
 *     w_s'(x) T(s | x) / (w_s(x) T(s' | x)),    T the probability of drawing the technique:
 *
 * rjmlt  T = w(x): 1, always accepted when the inverse exists (Bitterli and Jarosz 2017, section 5)
 * cmlt   T fixed, in proportion to the techniques' energies b_{k,s} (Pantaleoni 2017, eq. 25 and section 6.1)
 *
 * A jump is checked by making the path again; one that does not come back is refused and counted as not accepted.
 */
#ifndef CHAIN_JUMP_H
#define CHAIN_JUMP_H

#include "chain/chain.h"

/* T by the path's weights. */
void jump_reversible(chain_t *chain, uint64_t key);
/* T = chain->shares. */
void jump_chart(chain_t *chain, uint64_t key);

/* The chain's path by technique s: its numbers into the space's, its walks into the space's, its value. False if it
 * does not come back. */
bool jump_invert(chain_t *chain, uint64_t key, uint32_t s, target_value_t *value);

/* An index by weights that sum to one; `last` if rounding leaves none. */
uint32_t jump_draw(const double *weights, uint32_t count, uint32_t last, double u);

#endif
