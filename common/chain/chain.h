/* chain.h: one Markov chain on (s, u) of one path length, and what all its moves share: proposing numbers,
 * evaluating them, deciding. The moves themselves: perturb.h (steps in the numbers), jump.h (the technique changes,
 * the path stays), inverse_step.h (steps in the numbers of another technique), exchange.h (two chains trade their
 * paths), auxiliary.h (a second chain that knows visibility alone).
 *
 * The walks of the current state are kept (`kept`), proposals are made in the space's own. So a proposal that
 * changes one walk only traces that one again, and a jump has the path at hand. Trading walks moves pointers.
 *
 * Expected values (Veach 1997, 11.3.1): each step adds the proposal with weight a and the current state with 1 - a;
 * the current state's weights are gathered until it is left.
 */
#ifndef CHAIN_CHAIN_H
#define CHAIN_CHAIN_H

#include "chain/unit.h"

typedef struct chain {
    work_space_t *space;
    const target_t *target;
    work_stats_t *stats;
    stuck_t *stuck;
    const double *shares; /* of the techniques in b_k, if the algorithm wants them */
    uint64_t id;          /* among those of its length */
    uint64_t key;         /* of this chain's random numbers */
    uint32_t s;
    target_value_t current;
    double gathered; /* weight of the current state not yet splatted */
    double *camera, *light;
    path_space_t *kept; /* the current state's walks, joined */
    uint64_t stay;      /* rejections in a row */
} chain_t;

/* Which walks a proposal changes. */
typedef enum chain_streams {
    CHAIN_CAMERA = 1,
    CHAIN_LIGHT = 2,
    CHAIN_BOTH = CHAIN_CAMERA | CHAIN_LIGHT
} chain_streams_t;

/* A technique of the length, uniformly. */
static inline uint32_t chain_draw_technique(const chain_t *chain, uint64_t key)
{
    return chain->target->list[(uint32_t)(random_double(key, UNIT_DRAW_TECHNIQUE) * chain->target->count)];
}

/* Starts from a pilot's candidate. FAULT_RANGE if it carries nothing. */
fault_code_t chain_start(chain_t *chain, uint64_t candidate, fault_t *fault);

void chain_splat(chain_t *chain, const target_value_t *value, double weight, uint64_t key, uint64_t draw);

/* The proposal (s, value) with acceptance probability a in [0,1], whose numbers are in the space and whose
 * walks in the space: decides by number `draw` of the step, splats by the two after it, counts. True if accepted:
 * the value and the technique are then the chain's, and numbers and walks of `streams` too (so many numbers of
 * each). */
bool chain_decide(chain_t *chain, uint64_t key, uint64_t draw, double a, uint32_t s, const target_value_t *value,
                  chain_streams_t streams, uint32_t camera, uint32_t light);

/* Before the state is left, by an acceptance or with the chain, when its weights have been splatted: looks at its
 * stay, which then begins anew. */
void chain_end_stay(chain_t *chain, bool accepted);

/* (s, value), whose numbers and walks are in the space, becomes the chain's state; what is gathered stays. */
void chain_settle(chain_t *chain, uint32_t s, const target_value_t *value);

/* The state counts once more. */
static inline void chain_repeat(chain_t *chain)
{
    chain->gathered += 1;
    chain->stay++;
}

/* The last state's weights. */
void chain_finish(chain_t *chain, uint64_t key);

#endif
