#include "chain/bundle.h"

#include <assert.h>
#include <string.h>

void bundle_init(bundle_t *bundle, work_space_t *space, importance_t importance, work_result_t *result)
{
    const path_scene_t *scene = &space->renderer->scene;
    const uint32_t K = space->renderer->settings.max_path_length;
    bundle->space = space;
    bundle->stats = &result->stats;
    bundle->stuck = &result->stuck;
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

/* The brightest of the current state's paths, which stands for it where it was stuck: its walks are made once more.
 */
static stuck_path_t bundle_brightest(bundle_t *bundle)
{
    const renderer_t *renderer = bundle->space->renderer;
    const path_scene_t *scene = &renderer->scene;
    path_space_t *space = &bundle->space->path;
    const uint32_t K = renderer->settings.max_path_length;
    const uint32_t camera = path_walk_camera(scene, space, bundle->camera, K + 1, PATH_ENDS_ON_LIGHT),
                   light = path_walk_light(scene, space, bundle->light, K, PATH_ENDS_JOINED);
    stuck_path_t brightest = {.c = 0};
    for (uint32_t t = 1; t <= camera; t++)
        for (uint32_t s = t == 1; s <= light && s + t <= K + 1; s++) {
            const uint32_t k = s + t - 1;
            path_value_t value;
            if (k < 1 || !path_connect(scene, space, s, t, NULL, &renderer->targets[k].techniques, &value))
                continue;
            const vec2_t raster = t > 1 ? space->raster : value.raster;
            double c = target_scalar(renderer->settings.target, value.value);
            if (bundle->importance.blocks)
                c *= importance_at(&bundle->importance, raster);
            if (c > brightest.c)
                brightest = (stuck_path_t){.length = k, .technique = s, .x = raster.x, .y = raster.y, .c = c};
        }
    assert(brightest.c > 0); /* as their sum is */
    stuck_encode(space, brightest.length, brightest.technique, brightest.codes);
    return brightest;
}

/* Before the state is left, when its weights have been splatted. The proposal's numbers stay, its walks may go. */
static void bundle_end_stay(bundle_t *bundle, bool accepted)
{
    const uint64_t stay = bundle->stay;
    if (stay > bundle->stats->longest_stay)
        bundle->stats->longest_stay = stay;
    bundle->stay = 0;
    if (!stuck_end_stay(bundle->stuck, stay, accepted))
        return;
    double light = 0;
    for (uint32_t i = 0; i < bundle->current->count; i++)
        light += rgb_luminance(bundle->current->splats[i].value);
    stuck_add_light(bundle->stuck, bundle->gathered * light);
    stuck_path_t path = bundle_brightest(bundle);
    path.stay = stay;
    path.chain = bundle->id;
    stuck_keep(bundle->stuck, &path);
}

fault_code_t bundle_start(bundle_t *bundle, uint64_t id, uint64_t candidate, fault_t *fault)
{
    double totals[PATH_MAX_VERTICES];
    sampler_t sampler = bundle_sampler(bundle, totals);
    bundle->id = id;
    bundle->key = random_key(bundle->space->renderer->settings.seed, RANDOM_PURPOSE_CHAIN, 0, id);
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
    bundle_end_stay(bundle, true);
    bundle_take_state(bundle);
    bundle->gathered = a;
}

void bundle_finish(bundle_t *bundle, uint64_t step)
{
    bundle_splat(bundle, bundle->current, bundle->gathered, random_step(bundle->key, step));
    bundle_end_stay(bundle, false);
    bundle->gathered = 0;
}

fault_code_t unit_bundle(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                         work_result_t *result, fault_t *fault)
{
    const settings_t *settings = &space->renderer->settings;
    bundle_t bundle;
    TRY(unit_film(space, fault));
    bundle_init(&bundle, space, unit_importance(space, record), result);
    for (uint64_t i = 0; i < record->count; i++) {
        const uint64_t begin = i * record->mutations / record->count,
                       end = (i + 1) * record->mutations / record->count;
        TRY(bundle_start(&bundle, record->first + i, record->seeds[i], fault));
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
