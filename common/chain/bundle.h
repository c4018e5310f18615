/* bundle.h: chains of all lengths at once: primary sample space Metropolis light transport (Kelemen, Szirmay-Kalos,
 * Antal, Csonka 2002: "A simple and robust mutation strategy for the Metropolis light transport algorithm";
 * pssmlt).
 *
 * The state is the numbers u of one walk from the camera and one from a light, both of full length; the paths are
 * all their joints (s, t), of all lengths 1 .. K (sampler.h). Each has its balance-heuristic weight among the
 * techniques of its length, and the target is the sum of their scalar targets,
 *
 *     C(u) = sum_{s,t} C_s(u),    integral of C over all u = sum_k b_k = b.
 *
 * A state is seen in many places: the joints with t > 1 in the pixel of the camera walk, each joint with t = 1 in a
 * place of its own. Large step: all numbers anew. Small step: all perturbed. Both are symmetric: accepted with
 * min(1, C(v) / C(u)). Large steps are independent samples of all lengths, just as those of the pilot, and add to
 * the estimates of b_k.
 *
 * Different from the paper: chains start in their law, from the pilot's candidates in proportion to C, so nothing
 * is thrown away at the start; a joint with the light itself (s = 1) is with the light walk's first vertex, so that
 * no numbers beside the two walks' are needed; all numbers are perturbed at once, not on demand; large steps are
 * weighted as all others are, and not a second time as independent samples.
 *
 * It is the baseline: a mutation traces two walks and up to K (K + 1) / 2 shadow rays, whatever part of them
 * carries the light, and one dim joint more or less counts as little as it is worth.
 */
#ifndef CHAIN_BUNDLE_H
#define CHAIN_BUNDLE_H

#include "chain/sampler.h"

/* What a state's numbers carry. */
typedef struct bundle_value {
    double c; /* C(u) */
    uint32_t count;
    sampler_splat_t splats[PATH_MAX_VERTICES]; /* the joints with t = 1, and the camera walk's pixel */
} bundle_value_t;

/* Proposals are made in the space's numbers and walks; of the current state the numbers alone are kept. */
typedef struct bundle {
    work_space_t *space;
    work_stats_t *stats;
    stuck_t *stuck;
    importance_t importance;
    uint64_t id;                        /* among the chains */
    uint64_t key;                       /* of this chain's random numbers */
    uint32_t camera_count, light_count; /* numbers of the walks */
    double *camera, *light;             /* the current state's */
    bundle_value_t values[2], *current, *proposed;
    double gathered; /* weight of the current state not yet splatted */
    uint64_t stay;   /* rejections in a row */
} bundle_t;

/* Of a space that has a chain's room. */
void bundle_init(bundle_t *bundle, work_space_t *space, importance_t importance, work_result_t *result);
/* Starts chain `id` from a pilot's candidate. FAULT_RANGE if it carries nothing. */
fault_code_t bundle_start(bundle_t *bundle, uint64_t id, uint64_t candidate, fault_t *fault);
void bundle_step(bundle_t *bundle, uint64_t step);
/* The last state's weights. */
void bundle_finish(bundle_t *bundle, uint64_t step);

#endif
