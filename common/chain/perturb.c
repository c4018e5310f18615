#include "chain/perturb.h"

enum { SECOND_NUMBERS = 6 }; /* two vertices' worth */
static const double SECOND_STEP = 0.25;

/* A proposal in the making: technique, the walks it changes, and how many of their numbers: those that the current
 * or the proposed technique uses. What neither uses stays as it is. */
typedef struct proposal {
    uint64_t key;
    bool large;
    chain_streams_t streams;
    uint32_t s, camera, light;
} proposal_t;

static proposal_t proposal_of(const chain_t *chain, uint64_t key, bool large, uint32_t s)
{
    const target_t *target = chain->target;
    const uint32_t least = s < chain->s ? s : chain->s, most = s < chain->s ? chain->s : s;
    return (proposal_t){.key = key,
                        .large = large,
                        .streams = CHAIN_BOTH,
                        .s = s,
                        .camera = path_camera_dimensions(target->scene, target->length + 1 - least),
                        .light = path_light_dimensions(most)};
}

static bool proposal_walk_camera(chain_t *chain, const proposal_t *to)
{
    work_space_t *space = chain->space;
    if (to->large)
        kernel_draw(to->key, UNIT_DRAW_CAMERA, space->camera, to->camera);
    else
        kernel_perturb(&space->kernel, to->key, UNIT_DRAW_CAMERA, chain->camera, space->camera, to->camera);
    return target_walk_camera(chain->target, &space->path, to->s, space->camera);
}

static bool proposal_walk_light(chain_t *chain, const proposal_t *to)
{
    work_space_t *space = chain->space;
    if (to->large)
        kernel_draw(to->key, UNIT_DRAW_LIGHT, space->light, to->light);
    else
        kernel_perturb(&space->kernel, to->key, UNIT_DRAW_LIGHT, chain->light, space->light, to->light);
    return to->s == 0 || target_walk_light(chain->target, &space->path, to->s, space->light);
}

/* Joins a new walk of one end, which is in the space, to the kept one of the other. */
static void proposal_join_kept(chain_t *chain, chain_streams_t made, target_value_t *value)
{
    path_space_t *path = &chain->space->path;
    void (*const trade)(path_space_t *, path_space_t *) =
        made == CHAIN_CAMERA ? path_space_swap_light : path_space_swap_camera;
    trade(path, chain->kept);
    target_join(chain->target, path, chain->s, value);
    trade(path, chain->kept);
}

/* Numbers are drawn by counting, so those of a walk that is not made need not be made either: what a failed
 * proposal would have held is never looked at. */
static void proposal_evaluate(chain_t *chain, const proposal_t *to, target_value_t *value)
{
    value->c = 0;
    if (to->streams == CHAIN_CAMERA) {
        if (proposal_walk_camera(chain, to))
            proposal_join_kept(chain, CHAIN_CAMERA, value);
        return;
    }
    if (to->streams == CHAIN_LIGHT) {
        if (proposal_walk_light(chain, to))
            proposal_join_kept(chain, CHAIN_LIGHT, value);
        return;
    }
    const bool light_first = target_light_first(chain->target, to->s);
    if (light_first && !proposal_walk_light(chain, to))
        return;
    if (!proposal_walk_camera(chain, to) || (!light_first && !proposal_walk_light(chain, to)))
        return;
    target_join(chain->target, &chain->space->path, to->s, value);
}

/* The walks that technique s has numbers for, among those wanted. */
static chain_streams_t streams_of(const chain_t *chain, uint32_t s)
{
    const uint32_t camera = path_camera_dimensions(chain->target->scene, chain->target->length + 1 - s);
    return s == 0 ? CHAIN_CAMERA : camera == 0 ? CHAIN_LIGHT : CHAIN_BOTH;
}

/* One of the walks, by a fair coin where there are two. */
static chain_streams_t streams_draw(const chain_t *chain, uint64_t key, chain_streams_t among)
{
    const chain_streams_t streams = streams_of(chain, chain->s) & among;
    if (streams != CHAIN_BOTH)
        return streams;
    return random_double(key, UNIT_DRAW_STREAM) < 0.5 ? CHAIN_CAMERA : CHAIN_LIGHT;
}

/* The second proposal after a failed small step of the streams `first`. */
static void perturb_second(chain_t *chain, uint64_t key, chain_streams_t first)
{
    work_space_t *space = chain->space;
    const target_t *target = chain->target;
    const kernel_t *kernel = &space->kernel, shorter = kernel_scaled(kernel, SECOND_STEP);
    const chain_streams_t stream = streams_draw(chain, random_step(key, UNIT_DRAW_SECOND), first);
    const bool camera = stream == CHAIN_CAMERA;
    const uint32_t count = camera ? path_camera_dimensions(target->scene, target->length + 1 - chain->s)
                                  : path_light_dimensions(chain->s);
    const uint32_t width = count < SECOND_NUMBERS ? count : SECOND_NUMBERS;
    const uint32_t begin = (uint32_t)(random_double(key, UNIT_DRAW_WINDOW) * (count - width + 1));
    const double *from = camera ? chain->camera : chain->light;
    double *to = camera ? space->camera : space->light, via[SECOND_NUMBERS];
    kernel_perturb(kernel, key, (camera ? UNIT_DRAW_CAMERA : UNIT_DRAW_LIGHT) + begin, from + begin, via, width);
    for (uint32_t i = 0; i < count; i++)
        to[i] = from[i];
    kernel_perturb(&shorter, key, UNIT_DRAW_SECOND, from + begin, to + begin, width);
    chain->stats->proposed[WORK_MOVE_SECOND]++;
    double a = 0;
    target_value_t value = {0};
    const double ratio = kernel_log_ratio(kernel, from + begin, via, to + begin, width);
    if (ratio > -HUGE_VAL) {
        if (camera ? target_walk_camera(target, &space->path, chain->s, to)
                   : target_walk_light(target, &space->path, chain->s, to))
            proposal_join_kept(chain, stream, &value);
        a = value.c * exp(ratio) / chain->current.c;
        a = a < 1 ? a : 1;
    }
    chain->stats->accepted[WORK_MOVE_SECOND] += a;
    chain_decide(chain, key, UNIT_DRAW_SECOND_ACCEPT, a, chain->s, &value, stream, camera ? count : 0,
                 camera ? 0 : count);
}

static void perturb_failed(chain_t *chain, const proposal_t *to)
{
    chain->stats->zero_proposals++;
    switch (chain->space->renderer->settings.failures) {
    case SETTINGS_FAILURES_PUBLISHED:
        chain->space
            ->failed[unit_block(&chain->space->renderer->settings, chain->current.raster, WORK_FAILED_SIDE)]++;
        return;
    case SETTINGS_FAILURES_DELAYED:
        if (!to->large && to->s == chain->s) {
            perturb_second(chain, to->key, to->streams);
            return;
        }
        break;
    default:
        break;
    }
    chain_repeat(chain);
}

static void perturb_decide(chain_t *chain, const proposal_t *to, work_move_t move, const target_value_t *value)
{
    work_stats_t *stats = chain->stats;
    stats->proposed[move]++;
    if (!(value->c > 0)) {
        perturb_failed(chain, to);
        return;
    }
    const double a = value->c < chain->current.c ? value->c / chain->current.c : 1;
    stats->accepted[move] += a;
    chain_decide(chain, to->key, UNIT_DRAW_ACCEPT, a, to->s, value, to->streams, to->camera, to->light);
}

void perturb_large(chain_t *chain, uint64_t key)
{
    work_space_t *space = chain->space;
    const bool keeps = settings_keeps_technique(space->renderer->settings.algorithm);
    const uint32_t s = keeps ? chain->s : chain_draw_technique(chain, key);
    const proposal_t to = proposal_of(chain, key, true, s);
    target_value_t value;
    proposal_evaluate(chain, &to, &value);
    if (!keeps) {
        const double weight = value.c * chain->target->count;
        unit_moment(&space->moments[0], weight);
        unit_moment(&space->moments[1 + s], weight);
    }
    perturb_decide(chain, &to, WORK_MOVE_LARGE, &value);
}

void perturb_small(chain_t *chain, uint64_t key, bool redraw, bool partial)
{
    const uint32_t s = redraw ? chain_draw_technique(chain, key) : chain->s;
    proposal_t to = proposal_of(chain, key, false, s);
    work_move_t move = redraw ? WORK_MOVE_TECHNIQUE : WORK_MOVE_SMALL;
    if (partial && !redraw) {
        to.streams = streams_draw(chain, key, CHAIN_BOTH);
        move = to.streams == CHAIN_CAMERA ? WORK_MOVE_CAMERA : WORK_MOVE_LIGHT;
    }
    target_value_t value;
    proposal_evaluate(chain, &to, &value);
    perturb_decide(chain, &to, move, &value);
}
