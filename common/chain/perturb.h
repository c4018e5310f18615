/* perturb.h: steps in the numbers: large, small, of one walk alone, and the second step after a failed one.
 *
 * Large step: all numbers drawn anew, and the technique too unless the algorithm keeps it. Small step: every number
 * perturbed, the technique kept or (mmlt) with the probability settings.technique_step drawn anew. Partial step: a
 * small one of the camera's or of the light's numbers alone, so that the other walk need not be traced again. All
 * are symmetric: accepted with min(1, C(v) / C(u)). Only the numbers that the current or the proposed technique
 * uses are touched: the set is the same seen from either end, so symmetry holds. Which walks a partial step may
 * take follows from the technique, which it keeps.
 *
 * Large steps are independent samples: their C estimates b_k on the way.
 *
 * A proposal without contribution (a failure) does what settings.failures says:
 * plain      the state counts once more.
 * delayed    delayed rejection (Tierney, Mira 1999; Green, Mira 2001) of small steps that keep the technique: a
 * failed proposal v has C = 0 and is never accepted from anywhere, so a second proposal w is accepted with min(1,
 * C(w) q(w, v) / (C(u) q(u, v))), q the first step's density. w changes a window of a few numbers of one walk by a
 * shorter kernel, so q's ratio is over those alone, and one walk is traced. published  the step is as if it had not
 * been made ("rectified proposal failures", 2019, algorithm 1). Its law is C (1 - p_fail), not C
 * (docs/transport.md).
 */
#ifndef CHAIN_PERTURB_H
#define CHAIN_PERTURB_H

#include "chain/chain.h"

void perturb_large(chain_t *chain, uint64_t key);
/* redraw: the technique too. partial: one walk alone, where the technique has two. */
void perturb_small(chain_t *chain, uint64_t key, bool redraw, bool partial);

#endif
