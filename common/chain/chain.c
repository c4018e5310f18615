#include "chain/chain.h"

#include <string.h>

void chain_splat(chain_t *chain, const target_value_t *value, double weight, uint64_t key, uint64_t draw)
{
    unit_splat(chain->target->scene, &chain->space->film, value->raster, rgb_scale(value->color, weight), key,
               draw);
}

/* Counts of an evaluation in the kept walks go to the space's, which are reported. */
static void chain_move_counts(path_space_t *from, path_space_t *to)
{
    to->rays += from->rays;
    to->shadow_rays += from->shadow_rays;
    from->rays = from->shadow_rays = 0;
    for (int i = 0; i < PATH_REJECTS; i++) {
        to->rejects[i] += from->rejects[i];
        from->rejects[i] = 0;
    }
}

fault_code_t chain_start(chain_t *chain, uint64_t candidate, fault_t *fault)
{
    const target_t *target = chain->target;
    work_space_t *space = chain->space;
    chain->current.c = 0;
    if (unit_seed(space, target, candidate, random_double(chain->key, UNIT_DRAW_SEED), &chain->s)) {
        memcpy(chain->camera, space->camera, sizeof space->camera);
        memcpy(chain->light, space->light, sizeof space->light);
        target_eval(target, chain->kept, chain->s, chain->camera, chain->light, &chain->current);
        chain_move_counts(chain->kept, &space->path);
    }
    if (!(chain->current.c > 0))
        return fault_set(fault, FAULT_RANGE,
                         "seed %llu of length %u carries no light: it is not of this scene's pilot",
                         (unsigned long long)candidate, target->length);
    chain->gathered = 0;
    chain->stay = 0;
    return FAULT_NONE;
}

/* The proposal's numbers and walks become the chain's. */
static void chain_take(chain_t *chain, chain_streams_t streams, uint32_t camera, uint32_t light)
{
    work_space_t *space = chain->space;
    if (streams & CHAIN_CAMERA) {
        for (uint32_t i = 0; i < camera; i++)
            chain->camera[i] = space->camera[i];
        path_space_swap_camera(&space->path, chain->kept);
    }
    if (streams & CHAIN_LIGHT) {
        for (uint32_t i = 0; i < light; i++)
            chain->light[i] = space->light[i];
        path_space_swap_light(&space->path, chain->kept);
    }
    memcpy(chain->kept->end_ratios, space->path.end_ratios, sizeof space->path.end_ratios);
}

void chain_end_stay(chain_t *chain, bool accepted)
{
    const uint64_t stay = chain->stay;
    if (stay > chain->stats->longest_stay)
        chain->stats->longest_stay = stay;
    chain->stay = 0;
    if (!stuck_end_stay(chain->stuck, stay, accepted))
        return;
    stuck_add_light(chain->stuck, chain->gathered * rgb_luminance(chain->current.color));
    stuck_path_t path = {.length = chain->target->length,
                         .technique = chain->s,
                         .stay = stay,
                         .chain = chain->id,
                         .x = chain->current.raster.x,
                         .y = chain->current.raster.y,
                         .c = chain->current.c};
    stuck_encode(chain->kept, path.length, path.technique, path.codes);
    stuck_keep(chain->stuck, &path);
}

void chain_settle(chain_t *chain, uint32_t s, const target_value_t *value)
{
    chain->s = s;
    chain->current = *value;
    chain_take(chain, CHAIN_BOTH, chain->target->camera_count, chain->target->light_count);
}

bool chain_decide(chain_t *chain, uint64_t key, uint64_t draw, double a, uint32_t s, const target_value_t *value,
                  chain_streams_t streams, uint32_t camera, uint32_t light)
{
    chain->gathered += 1 - a;
    if (!(random_double(key, draw) < a)) {
        if (a > 0)
            chain_splat(chain, value, a, key, draw + 1);
        chain->stay++;
        return false;
    }
    chain_splat(chain, &chain->current, chain->gathered, key, draw + 1);
    chain_end_stay(chain, true);
    chain->current = *value;
    chain->gathered = a;
    chain->s = s;
    chain_take(chain, streams, camera, light);
    return true;
}

void chain_finish(chain_t *chain, uint64_t key)
{
    chain_splat(chain, &chain->current, chain->gathered, key, UNIT_DRAW_ACCEPT + 1);
    chain_end_stay(chain, false);
    chain->gathered = 0;
}
