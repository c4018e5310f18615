/* samples.c: independent samples of all path lengths at once: bidirectional path tracing, and path tracing as its
 * special case of the techniques s <= 1.
 *
 * A sample is one walk from the camera and one from a light, all their vertices joined in all allowed ways (Veach
 * 1997, chapter 10); connections to the light itself (s = 1) draw a point of their own for every camera vertex.
 * Sample i belongs to pixel i mod (width height): every pass over the image is stratified.
 */
#include <string.h>

#include "chain/unit.h"

typedef struct sampler {
    work_space_t *space;
    const renderer_t *renderer;
    uint64_t key;
    double scale;
    double *totals;         /* per length: luminance of this sample */
    rgb_t pixel;            /* what the camera walk gathered */
    uint32_t camera, light; /* vertices reached */
} sampler_t;

/* Adds a joined path's value: to the pixel of the camera walk or, for t = 1, where it is seen. */
static void sampler_add(sampler_t *sampler, uint32_t s, uint32_t t, const path_value_t *value)
{
    const renderer_t *renderer = sampler->renderer;
    const uint32_t k = s + t - 1;
    const double scalar = target_scalar(renderer->settings.target, value->value);
    sampler->totals[k] += scalar;
    unit_moment(&sampler->space->moments[work_samples_moment(k) + 1 + s], scalar);
    if (t > 1)
        sampler->pixel = rgb_add(sampler->pixel, value->value);
    else
        unit_splat(&renderer->scene, &sampler->space->film, value->raster, rgb_scale(value->value, sampler->scale),
                   sampler->key, UNIT_DRAW_FILTER);
}

static void sampler_join(sampler_t *sampler, uint32_t s, uint32_t t)
{
    const renderer_t *renderer = sampler->renderer;
    const uint32_t k = s + t - 1;
    if (k < 1 || k > renderer->settings.max_path_length)
        return;
    path_vertex_t y0;
    const path_vertex_t *own = NULL;
    if (s == 1) {
        double u[3];
        kernel_draw(sampler->key, UNIT_DRAW_NEXT_EVENT + 3 * (uint64_t)t, u, 3);
        if (!path_light_origin(&renderer->scene, u, &y0))
            return;
        own = &y0;
    }
    path_value_t value;
    if (path_connect(&renderer->scene, &sampler->space->path, s, t, own, &renderer->targets[k].techniques, &value))
        sampler_add(sampler, s, t, &value);
}

static void sampler_run(sampler_t *sampler, uint64_t index)
{
    work_space_t *space = sampler->space;
    const renderer_t *renderer = sampler->renderer;
    const settings_t *settings = &renderer->settings;
    const uint32_t K = settings->max_path_length;
    const target_t *longest = &renderer->targets[K];
    kernel_draw(sampler->key, UNIT_DRAW_CAMERA, space->camera,
                path_camera_dimensions(&renderer->scene, K + 1) + BSDF_DIMENSIONS);
    const uint64_t pixel = index % ((uint64_t)settings->width * settings->height);
    space->camera[0] = ((double)(pixel % settings->width) + space->camera[0]) / settings->width;
    space->camera[1] = ((double)(pixel / settings->width) + space->camera[1]) / settings->height;
    sampler->camera = path_walk_camera(&renderer->scene, &space->path, space->camera, K + 1);
    sampler->light = 1;
    if (settings->algorithm == SETTINGS_BDPT && K >= 2) {
        kernel_draw(sampler->key, UNIT_DRAW_LIGHT, space->light, longest->light_count);
        sampler->light = path_walk_light(&renderer->scene, &space->path, space->light, K);
    }
    sampler->pixel = rgb_gray(0);
    for (uint32_t t = 1; t <= sampler->camera; t++)
        for (uint32_t s = t == 1; s <= (sampler->light > 1 ? sampler->light : 1); s++)
            sampler_join(sampler, s, t);
    if (!rgb_black(sampler->pixel))
        unit_splat(&renderer->scene, &space->film, space->path.raster, rgb_scale(sampler->pixel, sampler->scale),
                   sampler->key, UNIT_DRAW_FILTER + 2);
    for (uint32_t k = 1; k <= K; k++) {
        unit_moment(&space->moments[work_samples_moment(k)], sampler->totals[k]);
        sampler->totals[k] = 0;
    }
}

fault_code_t unit_samples(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                          work_result_t *result, fault_t *fault)
{
    const renderer_t *renderer = space->renderer;
    double totals[PATH_MAX_VERTICES] = {0};
    TRY(unit_film(space, fault));
    sampler_t sampler = {.space = space, .renderer = renderer, .scale = record->scale, .totals = totals};
    for (uint64_t i = 0; i < record->count; i++) {
        if ((i & 63) == 0 && atomic_load_explicit(cancel, memory_order_relaxed))
            return fault_set(fault, FAULT_CANCELLED, "cancelled");
        sampler.key = random_key(renderer->settings.seed, RANDOM_PURPOSE_SAMPLES, 0, record->first + i);
        sampler_run(&sampler, record->first + i);
    }
    result->moment_count = work_samples_moment(renderer->settings.max_path_length + 1);
    for (uint32_t i = 0; i < result->moment_count; i++)
        space->moments[i].n = (double)record->count;
    result->stats.evaluations = record->count;
    result->has_film = true;
    return FAULT_NONE;
}
