#include "chain/jump.h"

#include <string.h>

#include "path/inverse.h"

uint32_t jump_draw(const double *weights, uint32_t count, uint32_t last, double u)
{
    for (uint32_t j = 0; j < count; j++) {
        if (u < weights[j])
            return j;
        u -= weights[j];
    }
    return last;
}

bool jump_invert(chain_t *chain, uint64_t key, uint32_t s, target_value_t *value)
{
    work_space_t *space = chain->space;
    const target_t *target = chain->target;
    const uint32_t t = target->length + 1 - chain->s;
    path_check_t check;
    memcpy(space->camera, chain->camera, sizeof(double) * target->camera_count);
    memcpy(space->light, chain->light, sizeof(double) * target->light_count);
    const uint64_t from = stamp_enter(&space->inversion);
    const bool inverted = path_invert_jump(target->scene, chain->kept, chain->s, t, s,
                                           random_step(key, UNIT_DRAW_FREE), space->camera, space->light);
    stamp_leave(&space->inversion, from);
    if (!inverted || path_verify(target->scene, chain->kept, chain->s, t, &space->path, s, space->camera,
                                 space->light, &target->techniques, &check) != PATH_INVERSE_AGREES)
        return false;
    return target_value_of(target, &check.value, value);
}

/* To technique s with acceptance probability a, if the inverse exists. The path stays where it is, so its weight is
 * one more whole step whatever becomes of it. */
static void jump_to(chain_t *chain, uint64_t key, uint32_t s, double a)
{
    target_value_t value;
    chain->gathered += 1;
    if (s == chain->s) {
        chain->stats->accepted[WORK_MOVE_JUMP] += 1;
        return;
    }
    if (!(a > 0) || !jump_invert(chain, key, s, &value))
        return;
    chain->stats->accepted[WORK_MOVE_JUMP] += a;
    if (!(random_double(key, UNIT_DRAW_ACCEPT) < a))
        return;
    chain_settle(chain, s, &value);
}

static bool jump_weights(const chain_t *chain, double *weights)
{
    const target_t *target = chain->target;
    return path_technique_weights(chain->kept, chain->s, target->length + 1 - chain->s, NULL, &target->techniques,
                                  weights);
}

void jump_reversible(chain_t *chain, uint64_t key)
{
    double weights[PATH_MAX_VERTICES];
    chain->stats->proposed[WORK_MOVE_JUMP]++;
    if (!jump_weights(chain, weights)) {
        chain->gathered += 1;
        return;
    }
    jump_to(chain, key,
            jump_draw(weights, chain->target->length + 1, chain->s, random_double(key, UNIT_DRAW_TECHNIQUE)), 1);
}

void jump_chart(chain_t *chain, uint64_t key)
{
    double weights[PATH_MAX_VERTICES];
    chain->stats->proposed[WORK_MOVE_JUMP]++;
    if (!jump_weights(chain, weights)) {
        chain->gathered += 1;
        return;
    }
    const double *shares = chain->shares;
    const uint32_t s =
        jump_draw(shares, chain->target->length + 1, chain->s, random_double(key, UNIT_DRAW_TECHNIQUE));
    const double there = weights[s] * shares[chain->s], back = weights[chain->s] * shares[s];
    jump_to(chain, key, s, there < back ? there / back : 1);
}
