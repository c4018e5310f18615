#include "chain/bundle.h"

#include <string.h>

void bundle_init(bundle_t *bundle, work_space_t *space, importance_t importance, work_stats_t *stats)
{
    const path_scene_t *scene = &space->renderer->scene;
    const uint32_t K = space->renderer->settings.max_path_length;
    bundle->space = space;
    bundle->stats = stats;
    bundle->importance = importance;
    bundle->camera_count = path_camera_dimensions(scene, K + 1);
    bundle->light_count = path_light_dimensions(K);
    bundle->camera = space->rooms[0].camera;
    bundle->light = space->rooms[0].light;
    bundle->current = &bundle->values[0];
    bundle->proposed = &bundle->values[1];
}

static sampler_t bundle_sampler(bundle_t *bundle, double *totals)
{
    return (sampler_t){.space = bundle->space,
                       .renderer = bundle->space->renderer,
                       .totals = totals,
                       .importance = bundle->importance,
                       .longest = bundle->space->renderer->settings.max_path_length,
                       .splats = bundle->proposed->splats};
}

/* The sample that was just made becomes the proposal's value: what a splat of weight 1 adds. */
static void bundle_take_value(bundle_t *bundle, const sampler_t *sampler)
{
    bundle_value_t *value = bundle->proposed;
    value->c = 0;
    value->count = sampler->splat_count;
    for (uint32_t k = 1; k <= sampler->renderer->settings.max_path_length; k++)
        value->c += sampler->totals[k];
    for (uint32_t i = 0; i < value->count && value->c > 0; i++) { /* by division: c may be denormal */
        rgb_t *v = &value->splats[i].value;
        *v = rgb(v->r / value->c, v->g / value->c, v->b / value->c);
    }
}

/* The proposal becomes the chain's state. */
static void bundle_take_state(bundle_t *bundle)
{
    bundle_value_t *left = bundle->current;
    bundle->current = bundle->proposed;
    bundle->proposed = left;
    memcpy(bundle->camera, bundle->space->camera, sizeof(double) * bundle->camera_count);
    memcpy(bundle->light, bundle->space->light, sizeof(double) * bundle->light_count);
}

/* All places of a state share one draw of the pixel filter: each by itself is moved by a sample of it. */
static void bundle_splat(bundle_t *bundle, const bundle_value_t *value, double weight, uint64_t key)
{
    for (uint32_t i = 0; i < value->count; i++)
        unit_splat(&bundle->space->renderer->scene, &bundle->space->film, value->splats[i].raster,
                   rgb_scale(value->splats[i].value, weight), key, UNIT_DRAW_FILTER);
}

static void bundle_note_stay(bundle_t *bundle)
{
    if (bundle->stay > bundle->stats->longest_stay)
        bundle->stats->longest_stay = bundle->stay;
    bundle->stay = 0;
}

fault_code_t bundle_start(bundle_t *bundle, uint64_t key, uint64_t candidate, fault_t *fault)
{
    double totals[PATH_MAX_VERTICES];
    sampler_t sampler = bundle_sampler(bundle, totals);
    bundle->key = key;
    bundle->gathered = 0;
    bundle->stay = 0;
    sampler_run(&sampler, unit_pilot_key(bundle->space->renderer, candidate), -1);
    bundle_take_value(bundle, &sampler);
    bundle_take_state(bundle);
    if (!(bundle->current->c > 0))
        return fault_set(fault, FAULT_RANGE, "seed %llu carries no light: it is not of this scene's pilot",
                         (unsigned long long)candidate);
    return FAULT_NONE;
}

static void bundle_propose(bundle_t *bundle, uint64_t key, bool large)
{
    work_space_t *space = bundle->space;
    double totals[PATH_MAX_VERTICES];
    sampler_t sampler = bundle_sampler(bundle, totals);
    if (large) {
        sampler.moments = space->moments;
        sampler_run(&sampler, key, -1);
    } else {
        const kernel_t *kernel = &space->kernel;
        kernel_perturb(kernel, key, UNIT_DRAW_CAMERA, bundle->camera, space->camera, bundle->camera_count);
        kernel_perturb(kernel, key, UNIT_DRAW_LIGHT, bundle->light, space->light, bundle->light_count);
        sampler_evaluate(&sampler, key);
    }
    bundle_take_value(bundle, &sampler);
}

void bundle_step(bundle_t *bundle, uint64_t step)
{
    const uint64_t key = random_step(bundle->key, step);
    const bool large = random_double(key, UNIT_DRAW_MOVE) < bundle->space->renderer->settings.large_step;
    const work_move_t move = large ? WORK_MOVE_LARGE : WORK_MOVE_SMALL;
    bundle_propose(bundle, key, large);
    bundle->stats->proposed[move]++;
    if (!(bundle->proposed->c > 0)) {
        bundle->stats->zero_proposals++;
        bundle->gathered += 1;
        bundle->stay++;
        return;
    }
    const double ratio = bundle->proposed->c / bundle->current->c, a = ratio < 1 ? ratio : 1;
    bundle->stats->accepted[move] += a;
    bundle->gathered += 1 - a;
    if (!(random_double(key, UNIT_DRAW_ACCEPT) < a)) {
        if (a > 0)
            bundle_splat(bundle, bundle->proposed, a, key);
        bundle->stay++;
        return;
    }
    bundle_splat(bundle, bundle->current, bundle->gathered, key);
    bundle_take_state(bundle);
    bundle->gathered = a;
    bundle_note_stay(bundle);
}

void bundle_finish(bundle_t *bundle, uint64_t step)
{
    bundle_splat(bundle, bundle->current, bundle->gathered, random_step(bundle->key, step));
    bundle->gathered = 0;
    bundle_note_stay(bundle);
}

fault_code_t unit_bundle(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                         work_result_t *result, fault_t *fault)
{
    const settings_t *settings = &space->renderer->settings;
    bundle_t bundle;
    TRY(unit_film(space, fault));
    bundle_init(&bundle, space, unit_importance(space, record), &result->stats);
    for (uint64_t i = 0; i < record->count; i++) {
        const uint64_t begin = i * record->mutations / record->count,
                       end = (i + 1) * record->mutations / record->count;
        TRY(bundle_start(&bundle, random_key(settings->seed, RANDOM_PURPOSE_CHAIN, 0, record->first + i),
                         record->seeds[i], fault));
        for (uint64_t step = 0; step < end - begin; step++) {
            if ((step & 255) == 0 && atomic_load_explicit(cancel, memory_order_relaxed))
                return fault_set(fault, FAULT_CANCELLED, "cancelled");
            bundle_step(&bundle, step);
        }
        bundle_finish(&bundle, end - begin);
    }
    result->moment_count = work_samples_moment(settings->max_path_length + 1);
    for (uint32_t i = 0; i < result->moment_count; i++)
        space->moments[i].n = (double)result->stats.proposed[WORK_MOVE_LARGE];
    result->stats.evaluations = record->mutations;
    result->has_film = true;
    return FAULT_NONE;
}
