#include "chain/work.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "chain/unit.h"

/* The scene's camera with the settings' filter in place of its own, and no lens if the settings forbid it. */
static scene_camera_t renderer_camera(const settings_t *settings, const scene_t *scene)
{
    static const double usual[SCENE_FILTER_KINDS] = {0.5, 1, 1.5};
    scene_camera_t camera = *scene->camera;
    if (settings_forbids(settings, SETTINGS_APERTURE))
        camera.lens_radius = 0;
    if (settings->filter < 0)
        return camera;
    camera.filter = (uint32_t)settings->filter;
    camera.filter_radius[0] = settings->filter_radius > 0 ? settings->filter_radius : usual[settings->filter];
    camera.filter_radius[1] = camera.filter_radius[0];
    if (!(camera.filter_sigma > 0))
        camera.filter_sigma = 0.5;
    return camera;
}

fault_code_t renderer_complete_settings(settings_t *settings, const scene_t *scene, fault_t *fault)
{
    const scene_camera_t data = renderer_camera(settings, scene);
    camera_t camera;
    TRY(camera_init(&camera, &data, settings->width, settings->height, fault));
    settings->width = camera.width;
    settings->height = camera.height;
    if (settings->max_path_length == 0)
        settings->max_path_length = scene->camera->max_path_length ? scene->camera->max_path_length : 12;
    if (settings->max_path_length > PATH_MAX_LENGTH)
        settings->max_path_length = PATH_MAX_LENGTH;
    if (settings->whole_path_length == 0)
        settings->whole_path_length = settings->max_path_length;
    if (settings->max_path_length > 2 && settings_forbids(settings, SETTINGS_INDIRECT))
        settings->max_path_length = 2;
    return FAULT_NONE;
}

fault_code_t renderer_new(renderer_t **out, const scene_t *scene, const settings_t *settings, fault_t *fault)
{
    *out = NULL;
    renderer_t *renderer = calloc(1, sizeof *renderer);
    if (!renderer)
        return fault_set(fault, FAULT_MEMORY, "no memory for a renderer");
    settings_t *s = &renderer->settings;
    *s = *settings;
    const scene_camera_t camera = renderer_camera(s, scene);
    fault_code_t code = path_scene_init(&renderer->scene, scene, &camera, s->width, s->height, fault);
    if (!code)
        code = renderer_complete_settings(s, scene, fault);
    renderer->targets = code ? NULL : malloc(sizeof *renderer->targets * (s->max_path_length + 1));
    if (!code && !renderer->targets)
        code = fault_set(fault, FAULT_MEMORY, "no memory for the targets");
    if (code) {
        renderer_destroy(&renderer);
        return code;
    }
    renderer->kernel = kernel_of(s);
    for (uint32_t k = 1; k <= s->max_path_length; k++)
        target_init(&renderer->targets[k], &renderer->scene, s, k);
    *out = renderer;
    return FAULT_NONE;
}

void renderer_destroy(renderer_t **renderer)
{
    if (!*renderer)
        return;
    path_scene_clear(&(*renderer)->scene);
    free((*renderer)->targets);
    free(*renderer);
    *renderer = NULL;
}

void renderer_film_size(const renderer_t *renderer, uint32_t *width, uint32_t *height)
{
    *width = renderer->settings.width;
    *height = renderer->settings.height;
}

const settings_t *renderer_settings(const renderer_t *renderer)
{
    return &renderer->settings;
}

size_t renderer_bytes(const renderer_t *renderer)
{
    return sizeof *renderer + accel_bytes(renderer->scene.accel) +
           (size_t)renderer->scene.lights.count * sizeof(light_emitter_t);
}

/* Rooms for the chains that run together: one, or those of an exchange, and an auxiliary one. */
static fault_code_t work_rooms_new(work_space_t *space, fault_t *fault)
{
    const settings_t *settings = &space->renderer->settings;
    if (!settings_is_chains(settings->algorithm))
        return FAULT_NONE;
    const uint32_t count = work_together(settings->algorithm) + (settings->auxiliary_step > 0);
    space->rooms = calloc(count, sizeof *space->rooms);
    for (uint32_t i = 0; space->rooms && i < count; i++) {
        space->rooms[i].kept = path_space_new();
        if (!space->rooms[i].kept)
            break;
        space->room_count++;
    }
    return space->room_count == count ? FAULT_NONE
                                      : fault_set(fault, FAULT_MEMORY, "no memory for a chain's state");
}

fault_code_t work_space_new(work_space_t **out, const renderer_t *renderer, fault_t *fault)
{
    *out = NULL;
    work_space_t *space = aligned_alloc(64, (sizeof *space + 63) / 64 * 64);
    if (!space)
        return fault_set(fault, FAULT_MEMORY, "no memory for a work space");
    memset(space, 0, sizeof *space);
    path_space_init(&space->path);
    space->renderer = renderer;
    space->moment_room = work_samples_moment(renderer->settings.max_path_length + 1);
    if (space->moment_room < PATH_MAX_VERTICES + 1)
        space->moment_room = PATH_MAX_VERTICES + 1;
    space->moments = calloc(space->moment_room, sizeof *space->moments);
    space->idle = calloc(renderer->settings.max_path_length + 1, sizeof *space->idle);
    if (!space->moments || !space->idle) {
        work_space_destroy(&space);
        return fault_set(fault, FAULT_MEMORY, "no memory for a work space");
    }
    const fault_code_t code = work_rooms_new(space, fault);
    if (code) {
        work_space_destroy(&space);
        return code;
    }
    *out = space;
    return FAULT_NONE;
}

void work_space_destroy(work_space_t **space)
{
    if (!*space)
        return;
    film_clear(&(*space)->film);
    for (uint32_t i = 0; i < (*space)->room_count; i++)
        free((*space)->rooms[i].kept);
    free((*space)->rooms);
    free((*space)->moments);
    free((*space)->idle);
    free((*space)->weights);
    free((*space)->features);
    free((*space)->tally);
    free(*space);
    *space = NULL;
}

fault_code_t unit_film(work_space_t *space, fault_t *fault)
{
    const settings_t *settings = &space->renderer->settings;
    if (!space->film.sums)
        return film_init(&space->film, settings->width, settings->height, fault);
    film_reset(&space->film);
    return FAULT_NONE;
}

static fault_code_t work_check(const work_space_t *space, const work_record_t *record, fault_t *fault)
{
    const settings_t *settings = &space->renderer->settings;
    if (work_runs_chains(record->kind) && !settings_is_chains(settings->algorithm))
        return fault_set(fault, FAULT_RANGE, "a unit of chains, which %s does not make",
                         settings_algorithm_name(settings->algorithm));
    const bool all = settings_joins_all(settings->algorithm);
    if (work_runs_chains(record->kind) && all && record->length != 0)
        return fault_set(fault, FAULT_RANGE, "unit of length %u, expected 0: chains of %s are of all lengths",
                         record->length, settings_algorithm_name(settings->algorithm));
    if (work_runs_chains(record->kind) && !all &&
        (record->length < 1 || record->length > settings->max_path_length))
        return fault_set(fault, FAULT_RANGE, "unit of length %u, expected 1 to %u", record->length,
                         settings->max_path_length);
    if (work_runs_chains(record->kind) && !all && space->renderer->targets[record->length].count == 0)
        return fault_set(fault, FAULT_RANGE, "chains of length %u, which no technique makes", record->length);
    if (work_runs_chains(record->kind) && settings_wants_shares(settings->algorithm) != (record->shares != NULL))
        return fault_set(fault, FAULT_RANGE, "shares of techniques: they do not go with the algorithm");
    const uint32_t caps = work_runs_chains(record->kind) ? 1 : settings->max_path_length;
    if (record->cap_count > 0 && (!(settings->split > 0) || record->cap_count != caps))
        return fault_set(fault, FAULT_RANGE, "a unit with %u caps, expected %s", record->cap_count,
                         settings->split > 0 ? "as many as path lengths, of chains one" : "none");
    if (record->rate_count > 0 && (!(settings->split > 0) || record->rate_count != settings->max_path_length))
        return fault_set(fault, FAULT_RANGE, "a unit with %u rates, expected %s", record->rate_count,
                         settings->split > 0 ? "as many as path lengths" : "none");
    if (record->idle_count > 0 && (!settings_is_chains(settings->algorithm) ||
                                   record->idle_count != (record->length > 0 ? 1 : settings->max_path_length)))
        return fault_set(fault, FAULT_RANGE, "a unit that leaves out techniques of %u lengths, expected %s",
                         record->idle_count, settings_is_chains(settings->algorithm) ? "0, or all" : "none");
    if (record->importance && !(settings->equalize > 0))
        return fault_set(fault, FAULT_RANGE, "a unit with importance, for a job without");
    if (work_runs_chains(record->kind) && settings->equalize > 0 && !record->importance)
        return fault_set(fault, FAULT_RANGE, "a unit of chains without importance, for a job with it");
    if (record->kind == WORK_TRIAL && (all || record->count < 2 * work_together(settings->algorithm)))
        return fault_set(fault, FAULT_RANGE, "a trial of %llu chains, expected %u or more of one length",
                         (unsigned long long)record->count, 2 * work_together(settings->algorithm));
    if (record->kind == WORK_FEATURES && record->side == 0)
        return fault_set(fault, FAULT_RANGE, "features of no rays");
    if (record->kind == WORK_FEATURES &&
        (record->first >= settings->height || record->count > settings->height - record->first))
        return fault_set(fault, FAULT_RANGE, "features of rows %llu to %llu of an image of %u",
                         (unsigned long long)record->first, (unsigned long long)(record->first + record->count),
                         settings->height);
    return FAULT_NONE;
}

/* The targets that the record asks for. */
static fault_code_t work_targets(work_space_t *space, const work_record_t *record, fault_t *fault)
{
    const uint32_t K = space->renderer->settings.max_path_length;
    space->targets = space->renderer->targets;
    if (record->idle_count > 0) {
        memcpy(space->idle, space->renderer->targets, sizeof *space->idle * (K + 1));
        space->targets = space->idle;
    }
    for (uint32_t i = 0; i < record->idle_count; i++) {
        target_t *target = &space->idle[record->length > 0 ? record->length : i + 1];
        const uint32_t before = target->count;
        target_leave(target, &record->idle[i]);
        if (before > 0 && target->count == 0)
            return fault_set(fault, FAULT_RANGE, "a unit without a technique for length %u", target->length);
    }
    space->light_vertices = 0;
    for (uint32_t k = 1; k <= K; k++) {
        const target_t *target = &space->targets[k];
        const uint32_t most = target->count > 0 ? target->list[target->count - 1] : 0;
        space->light_vertices = most > space->light_vertices ? most : space->light_vertices;
    }
    return FAULT_NONE;
}

/* Room for what the record asks for. */
static fault_code_t work_reserve(work_space_t *space, const work_record_t *record, fault_t *fault)
{
    const size_t weights = record->kind == WORK_PILOT
                               ? work_pilot_weights(record->count, space->renderer->settings.max_path_length)
                               : 0;
    if (weights > space->weight_room) {
        double *room = realloc(space->weights, sizeof *room * weights);
        if (!room)
            return fault_set(fault, FAULT_MEMORY, "no memory for %llu candidates",
                             (unsigned long long)record->count);
        space->weights = room;
        space->weight_room = weights;
    }
    const size_t features = record->kind == WORK_FEATURES
                                ? (size_t)WORK_FEATURE_CHANNELS * space->renderer->settings.width * record->count
                                : 0;
    if (features > space->feature_room) {
        float *room = realloc(space->features, sizeof *room * features);
        if (!room)
            return fault_set(fault, FAULT_MEMORY, "no memory for the feature layers");
        space->features = room;
        space->feature_room = features;
    }
    return FAULT_NONE;
}

fault_code_t work_run(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                      work_result_t *result, fault_t *fault)
{
    static fault_code_t (*const units[WORK_KINDS])(work_space_t *, const work_record_t *, const atomic_bool *,
                                                   work_result_t *, fault_t *) = {
        [WORK_PILOT] = unit_pilot,       [WORK_CHAINS] = unit_chains, [WORK_SAMPLES] = unit_samples,
        [WORK_FEATURES] = unit_features, [WORK_REFINE] = unit_refine, [WORK_TRIAL] = unit_trial,
        [WORK_LEFT_OUT] = unit_left_out,
    };
    if (record->kind >= WORK_KINDS || !units[record->kind])
        return fault_set(fault, FAULT_RANGE, "unit of unknown kind %u", record->kind);
    TRY(work_check(space, record, fault));
    TRY(work_targets(space, record, fault));
    TRY(work_reserve(space, record, fault));
    *result = (work_result_t){.kind = record->kind, .length = record->length, .moments = space->moments};
    memset(space->moments, 0, sizeof *space->moments * space->moment_room);
    space->path.rays = space->path.shadow_rays = 0;
    memset(space->path.rejects, 0, sizeof space->path.rejects);
    memset(space->failed, 0, sizeof space->failed);
    space->kernel = kernel_scaled(&space->renderer->kernel, exp2(record->steps));
    stamp_watch_t watch;
    stamp_begin(&space->inversion, &watch);
    stamp_begin(&space->path.tracing, &watch);
    const double begin = clock_thread_cpu();
    TRY(units[record->kind](space, record, cancel, result, fault));
    const double cpu = clock_thread_cpu() - begin, tracing = stamp_seconds(&space->path.tracing, &watch),
                 inversion = stamp_seconds(&space->inversion, &watch);
    result->stats.cpu_seconds = cpu; /* what is estimated from a sample may come out above it */
    result->stats.tracing_seconds = tracing < cpu ? tracing : cpu;
    result->stats.inversion_seconds = inversion < cpu - tracing ? inversion : cpu - result->stats.tracing_seconds;
    result->stats.rays = space->path.rays;
    result->stats.shadow_rays = space->path.shadow_rays;
    static_assert((int)PATH_REJECTS == (int)WORK_REJECTS, "the causes are the same");
    memcpy(result->stats.rejects, space->path.rejects, sizeof result->stats.rejects);
    if (result->has_film)
        result->film = space->film;
    return FAULT_NONE;
}
