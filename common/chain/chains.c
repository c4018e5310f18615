/* chains.c: multiplexed Metropolis light transport (Hachisuka, Kaplanyan, Dachsbacher 2014): Markov chains on (s,
 * u) for one path length.
 *
 * Moves. Large step: s and all numbers drawn anew. Small step: every number perturbed, s kept or, with the
 * probability settings.technique_step, drawn anew; both are symmetric, so acceptance is C(v) / C(u). Only the
 * numbers that the current or the proposed technique uses are touched: the set is the same seen from either end, so
 * symmetry holds.
 *
 * With reversible jumps (rjmlt) small steps keep the technique, and jumps change it and leave the path (jump.h).
 *
 * Expected values (Veach 1997, 11.3.1): each step adds the proposal with weight a and the current state with 1 - a;
 * the current state's weights are gathered until it is left. A proposal without contribution never enters a ratio.
 *
 * Large steps are independent samples: their C estimates b_k on the way.
 */
#include <string.h>

#include "chain/jump.h"
#include "chain/unit.h"

typedef struct chain {
    work_space_t *space;
    const target_t *target;
    uint64_t key; /* of this chain's random numbers */
    uint32_t s;
    target_value_t current;
    double gathered; /* weight of the current state not yet splatted */
    double *camera, *light, *camera_new, *light_new;
    uint64_t stay; /* rejections in a row */
} chain_t;

static uint32_t chain_draw_technique(const chain_t *chain, uint64_t key)
{
    return chain->target->list[(uint32_t)(random_double(key, UNIT_DRAW_TECHNIQUE) * chain->target->count)];
}

static uint32_t larger(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

/* The numbers of the proposed state in either stream; what neither technique uses stays as it is. */
static void chain_propose(chain_t *chain, uint64_t key, bool large, uint32_t camera, uint32_t light)
{
    if (large) {
        kernel_draw(key, UNIT_DRAW_CAMERA, chain->camera_new, camera);
        kernel_draw(key, UNIT_DRAW_LIGHT, chain->light_new, light);
    } else {
        const kernel_t *kernel = &chain->space->renderer->kernel;
        kernel_perturb(kernel, key, UNIT_DRAW_CAMERA, chain->camera, chain->camera_new, camera);
        kernel_perturb(kernel, key, UNIT_DRAW_LIGHT, chain->light, chain->light_new, light);
    }
}

static void chain_splat(chain_t *chain, const target_value_t *value, double weight, uint64_t key, uint64_t draw)
{
    unit_splat(chain->target->scene, &chain->space->film, value->raster, rgb_scale(value->color, weight), key,
               draw);
}

/* The path stays where it is, so its weight is one more whole step. */
static void chain_jump(chain_t *chain, uint64_t key, work_stats_t *stats)
{
    uint32_t s;
    target_value_t value;
    chain->gathered += 1;
    stats->proposed[WORK_MOVE_JUMP]++;
    if (!jump_propose(chain->space, chain->target, chain->s, key, &s, &value))
        return;
    stats->accepted[WORK_MOVE_JUMP] += 1;
    if (s == chain->s)
        return;
    chain->s = s;
    chain->current = value;
    memcpy(chain->camera, chain->camera_new, sizeof(double) * chain->target->camera_count);
    memcpy(chain->light, chain->light_new, sizeof(double) * chain->target->light_count);
}

static void chain_step(chain_t *chain, uint64_t step, work_stats_t *stats)
{
    work_space_t *space = chain->space;
    const target_t *target = chain->target;
    const settings_t *settings = &space->renderer->settings;
    const uint64_t key = random_step(chain->key, step);
    const double choice = random_double(key, UNIT_DRAW_MOVE);
    const bool large = choice < settings->large_step, jumps = settings->algorithm == SETTINGS_RJMLT;
    if (jumps && !large && choice < settings->large_step + settings->jump_step) {
        chain_jump(chain, key, stats);
        return;
    }
    const double technique_step = jumps ? 0 : (1 - settings->large_step) * settings->technique_step;
    const bool redraw = large || choice < settings->large_step + technique_step;
    const uint32_t s = redraw ? chain_draw_technique(chain, key) : chain->s;
    const work_move_t move = large ? WORK_MOVE_LARGE : redraw ? WORK_MOVE_TECHNIQUE : WORK_MOVE_SMALL;
    const uint32_t k = target->length;
    const uint32_t camera = path_camera_dimensions(target->scene, k + 1 - (s < chain->s ? s : chain->s));
    const uint32_t light = path_light_dimensions(larger(s, chain->s));
    chain_propose(chain, key, large, camera, light);
    target_value_t proposal;
    target_eval(target, &space->path, s, chain->camera_new, chain->light_new, &proposal);
    if (large) {
        const double weight = proposal.c * target->count;
        unit_moment(&space->moments[0], weight);
        unit_moment(&space->moments[1 + s], weight);
    }
    stats->proposed[move]++;
    if (!(proposal.c > 0)) {
        stats->zero_proposals++;
        chain->gathered += 1;
        chain->stay++;
        return;
    }
    const double a = proposal.c < chain->current.c ? proposal.c / chain->current.c : 1;
    stats->accepted[move] += a;
    chain->gathered += 1 - a;
    if (random_double(key, UNIT_DRAW_ACCEPT) < a) {
        chain_splat(chain, &chain->current, chain->gathered, key, UNIT_DRAW_FILTER);
        chain->current = proposal;
        chain->gathered = a;
        chain->s = s;
        for (uint32_t i = 0; i < camera; i++)
            chain->camera[i] = chain->camera_new[i];
        for (uint32_t i = 0; i < light; i++)
            chain->light[i] = chain->light_new[i];
        if (chain->stay > stats->longest_stay)
            stats->longest_stay = chain->stay;
        chain->stay = 0;
    } else {
        chain_splat(chain, &proposal, a, key, UNIT_DRAW_FILTER);
        chain->stay++;
    }
}

static fault_code_t chain_run(chain_t *chain, uint64_t candidate, uint64_t mutations, const atomic_bool *cancel,
                              work_stats_t *stats, fault_t *fault)
{
    const target_t *target = chain->target;
    const bool found =
        unit_seed(chain->space, target, candidate, random_double(chain->key, UNIT_DRAW_SEED), &chain->s);
    chain->current.c = 0;
    if (found)
        target_eval(target, &chain->space->path, chain->s, chain->camera, chain->light, &chain->current);
    if (!(chain->current.c > 0))
        return fault_set(fault, FAULT_RANGE,
                         "seed %llu of length %u carries no light: it is not of this scene's pilot",
                         (unsigned long long)candidate, target->length);
    chain->gathered = 0;
    chain->stay = 0;
    for (uint64_t step = 0; step < mutations; step++) {
        if ((step & 1023) == 0 && atomic_load_explicit(cancel, memory_order_relaxed))
            return fault_set(fault, FAULT_CANCELLED, "cancelled");
        chain_step(chain, step, stats);
    }
    chain_splat(chain, &chain->current, chain->gathered, random_step(chain->key, mutations), UNIT_DRAW_FILTER);
    if (chain->stay > stats->longest_stay)
        stats->longest_stay = chain->stay;
    return FAULT_NONE;
}

fault_code_t unit_chains(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                         work_result_t *result, fault_t *fault)
{
    const renderer_t *renderer = space->renderer;
    TRY(unit_film(space, fault));
    for (uint64_t i = 0; i < record->count; i++) {
        chain_t chain = {
            .space = space,
            .target = &renderer->targets[record->length],
            .key = random_key(renderer->settings.seed, RANDOM_PURPOSE_CHAIN, record->length, record->first + i),
            .camera = space->camera,
            .light = space->light,
            .camera_new = space->camera_new,
            .light_new = space->light_new};
        const uint64_t begin = i * record->mutations / record->count,
                       end = (i + 1) * record->mutations / record->count;
        TRY(chain_run(&chain, record->seeds[i], end - begin, cancel, &result->stats, fault));
    }
    result->moment_count = record->length + 2;
    for (uint32_t i = 0; i < result->moment_count; i++)
        space->moments[i].n = (double)result->stats.proposed[WORK_MOVE_LARGE];
    result->stats.evaluations = record->mutations;
    result->has_film = true;
    return FAULT_NONE;
}
