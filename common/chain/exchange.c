#include "chain/exchange.h"

#include "chain/jump.h"

/* w_to / w_from of the chain's path; false if it has none. */
static bool exchange_ratio(const chain_t *chain, uint32_t to, double *ratio)
{
    const target_t *target = chain->target;
    double weights[PATH_MAX_VERTICES];
    if (!path_technique_weights(chain->kept, chain->s, target->length + 1 - chain->s, NULL, &target->techniques,
                                weights) ||
        !(weights[chain->s] > 0))
        return false;
    *ratio = weights[to] / weights[chain->s];
    return true;
}

static void exchange_take(chain_t *chain, uint64_t key, uint32_t s)
{
    target_value_t value;
    if (jump_invert(chain, key, s, &value)) /* as it did a moment ago: it is a function of its arguments */
        chain_settle(chain, s, &value);
}

void exchange_step(chain_t *chain, chain_t *ensemble, uint32_t count, uint64_t key)
{
    work_stats_t *stats = chain->stats;
    stats->proposed[WORK_MOVE_EXCHANGE]++;
    chain->gathered += 1; /* its path stays */
    if (count < 2)
        return;
    const uint32_t self = (uint32_t)(chain - ensemble),
                   drawn = (uint32_t)(random_double(key, UNIT_DRAW_TECHNIQUE) * (count - 1));
    chain_t *other = &ensemble[drawn < self ? drawn : drawn + 1];
    const uint32_t here = chain->s, there = other->s;
    if (here == there) {
        stats->accepted[WORK_MOVE_EXCHANGE] += 1;
        return;
    }
    double x, y;
    if (!exchange_ratio(chain, there, &x) || !exchange_ratio(other, here, &y))
        return;
    const uint64_t key_x = random_step(key, UNIT_DRAW_FREE + 1), key_y = random_step(key, UNIT_DRAW_FREE + 2);
    const double a = x * y < 1 ? x * y : 1;
    target_value_t value;
    if (!(a > 0) || !jump_invert(other, key_y, here, &value) || !jump_invert(chain, key_x, there, &value))
        return;
    stats->accepted[WORK_MOVE_EXCHANGE] += a;
    if (!(random_double(key, UNIT_DRAW_ACCEPT) < a))
        return;
    exchange_take(chain, key_x, there);
    exchange_take(other, key_y, here);
}
