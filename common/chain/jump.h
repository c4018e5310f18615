/* jump.h: the reversible jump between techniques (Bitterli and Jarosz 2017): the path stays, its technique and
 * numbers change.
 *
 * From (s, u) with x = S_s(u): draw s' with the probability w_s'(x), take v = R_s'(x) (path/inverse.h), go to (s',
 * v). Proposal and target cancel (C is a function of x, w_s' / w_s = p_s' / p_s is the Jacobian's inverse):
 * accepted always, when the inverse exists. A jump is checked by making the path again; one that does not come back
 * is refused and counted as not accepted.
 */
#ifndef CHAIN_JUMP_H
#define CHAIN_JUMP_H

#include "chain/unit.h"

/* The state (s; space->camera, space->light) jumps: true with the new technique, the numbers in space->camera_new
 * and space->light_new, and the value. *s_new = s: it stays where it is, which is a jump too. */
bool jump_propose(work_space_t *space, const target_t *target, uint32_t s, uint64_t key, uint32_t *s_new,
                  target_value_t *value);

#endif
