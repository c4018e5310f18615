/* inverse_step.h: inverse primary space perturbations (Pantaleoni 2017, section 4, eq. 26 and 27; cmlt-ipsm).
 *
 * The chain is on paths, with the target f*: technique and numbers are only how the current path is held. A step
 * draws a technique s' (by chain->shares, which are fixed), takes the numbers u = R_s'(x), perturbs them, y =
 * S_s'(v), and accepts with
 *
 *     [f*(y) / p_s'(y)] / [f*(x) / p_s'(x)] = [C(y) / w_s'(y)] / [C(x) / w_s'(x)].
 *
 * A large step proposes from the mean of all techniques' densities, for which f* / mean p is in proportion to C:
 * its ratio is C(y) / C(x), the same as on (s, u). The way back into the numbers is not checked by making x again,
 * which would double the cost of a step: of 1e4 inverses one or so fails (docs/transport.md).
 */
#ifndef CHAIN_INVERSE_STEP_H
#define CHAIN_INVERSE_STEP_H

#include "chain/chain.h"

void inverse_step(chain_t *chain, uint64_t key);

#endif
