#include "chain/sampler.h"

void sampler_next_event(uint64_t key, uint32_t t, double u[3])
{
    kernel_draw(key, UNIT_DRAW_NEXT_EVENT + 3 * (uint64_t)t, u, 3);
}

/* Triples of which the last two numbers belong together: a lobe and a direction, a light and a place on it. */
static void sampler_place_triples(const net_t *net, uint64_t draw, double *u, uint32_t count)
{
    for (uint32_t i = 0; i < 3 * count; i += 3) {
        net_place_one(net, draw + i, u + i);
        net_place_pair(net, draw + i + 1, u + i + 1);
    }
}

/* Of `count` numbers, the first of which are `begin` ones before the first scattering: at how many vertices the net
 * has them. */
static uint32_t sampler_scatterings(uint32_t count, uint32_t begin)
{
    const uint32_t all = count > begin ? (count - begin) / BSDF_DIMENSIONS : 0;
    return all < NET_VERTICES ? all : NET_VERTICES;
}

static void sampler_place_camera(const net_t *net, double *u, uint32_t count, uint32_t begin)
{
    for (uint32_t i = 0; i < begin; i += 2) /* film, lens */
        net_place_pair(net, UNIT_DRAW_CAMERA + i, u + i);
    sampler_place_triples(net, UNIT_DRAW_CAMERA + begin, u + begin, sampler_scatterings(count, begin));
}

static void sampler_place_light(const net_t *net, double *u, uint32_t count)
{
    const uint32_t begin = PATH_LIGHT_DIMENSIONS;
    sampler_place_triples(net, UNIT_DRAW_LIGHT, u, 1);
    if (count < begin)
        return;
    net_place_pair(net, UNIT_DRAW_LIGHT + 3, u + 3); /* direction */
    sampler_place_triples(net, UNIT_DRAW_LIGHT + begin, u + begin, sampler_scatterings(count, begin));
}

/* w'_s / w_s of the path that was joined last (sampler.h). */
static double sampler_favour(const sampler_t *sampler, uint32_t s, uint32_t t, const path_vertex_t *y0)
{
    double weights[PATH_MAX_VERTICES];
    const uint32_t k = s + t - 1;
    if (k > 2 ||
        !path_technique_weights(&sampler->space->path, s, t, y0, &sampler->space->targets[k].techniques, weights))
        return 1;
    return (t == 1 ? SAMPLER_DIRECT : 1) / (1 - (1 - SAMPLER_DIRECT) * weights[k]);
}

/* Adds a joined path's value: to the pixel of the camera walk or, for t = 1, where it is seen. */
static void sampler_add(sampler_t *sampler, uint32_t s, uint32_t t, const path_vertex_t *y0,
                        const path_value_t *value)
{
    const renderer_t *renderer = sampler->renderer;
    const uint32_t k = s + t - 1;
    const vec2_t raster = t > 1 ? sampler->space->path.raster : value->raster;
    const double light = target_scalar(renderer->settings.target, value->value);
    double scalar = sampler->importance.blocks ? light * importance_at(&sampler->importance, raster) : light;
    rgb_t seen = value->value;
    if (sampler->caps && scalar > 0) {
        seen = rgb_scale(seen, split_kept(scalar, sampler->caps[k - 1]));
        const double excess = split_excess(scalar, sampler->caps[k - 1]);
        scalar = excess > 0 ? excess : 0;
    }
    double balanced = scalar;
    if (sampler->of_image) {
        const double favour = sampler_favour(sampler, s, t, y0);
        scalar *= favour;
        seen = rgb_scale(seen, favour);
    }
    if (sampler->weights) {
        scalar *= sampler->weights[k - 1];
        balanced *= sampler->weights[k - 1];
        seen = rgb_scale(seen, sampler->weights[k - 1]);
    }
    sampler->totals[k] += scalar;
    if (sampler->only > 0)
        sampler->by_technique[s] = balanced;
    if (sampler->moments)
        unit_moment(&sampler->moments[work_samples_moment(k) + 1 + s], balanced);
    if (sampler->blocks)
        sampler->blocks[(k - 1) * WORK_BLOCKS + unit_block(&renderer->settings, raster, WORK_BLOCKS_SIDE)] += light;
    if (sampler->by_class)
        sampler->by_class[k * PATH_CLASS_SETS + path_classes(&sampler->space->path, s, t, y0)] += light;
    if (t == 1 && sampler->splats)
        sampler->splats[sampler->splat_count++] = (sampler_splat_t){value->raster, value->value};
    if (t > 1)
        sampler->pixel = rgb_add(sampler->pixel, seen);
    else if (sampler->film)
        unit_splat(&renderer->scene, sampler->film, value->raster, rgb_scale(seen, sampler->scale), sampler->key,
                   UNIT_DRAW_FILTER);
}

static void sampler_join(sampler_t *sampler, uint32_t s, uint32_t t)
{
    const renderer_t *renderer = sampler->renderer;
    const uint32_t k = s + t - 1;
    if (k < 1 || k > sampler->longest || (sampler->only > 0 && k != sampler->only))
        return;
    const path_techniques_t *techniques = &sampler->space->targets[k].techniques;
    if (!techniques->allowed[s])
        return;
    path_vertex_t y0;
    const path_vertex_t *own = NULL;
    if (s == 1 && !settings_joins_all(renderer->settings.algorithm)) {
        double u[3];
        sampler_next_event(sampler->key, t, u);
        if (sampler->net && t <= 1 + NET_VERTICES)
            sampler_place_triples(sampler->net, UNIT_DRAW_NEXT_EVENT + 3 * (uint64_t)t, u, 1);
        if (!path_light_origin(&renderer->scene, u, &y0))
            return;
        own = &y0;
    }
    path_value_t value;
    path_space_t *path = &sampler->space->path;
    const uint64_t before = path->shadow_rays;
    if (path_connect(&renderer->scene, path, s, t, own, techniques, &value))
        sampler_add(sampler, s, t, own, &value);
    if (sampler->rays)
        sampler->rays[k - 1] += (double)(path->shadow_rays - before);
}

/* Ray i of a walk, from 1 on, leads to its vertex i: paths of length i need it, one more on the light's side. */
static void sampler_count_rays(sampler_t *sampler, uint64_t before, uint32_t shortest)
{
    const uint64_t rays = sampler->space->path.rays - before;
    for (uint64_t i = 0; sampler->rays && i < rays; i++)
        sampler->rays[shortest - 1 + i] += 1;
}

/* The light walk of the numbers in the space: how many first vertices of it take part. */
static uint32_t sampler_walk_light(sampler_t *sampler)
{
    work_space_t *space = sampler->space;
    const settings_t *settings = &sampler->renderer->settings;
    const uint32_t most = sampler->longest < space->light_vertices ? sampler->longest : space->light_vertices;
    if (most < 2 && !settings_joins_all(settings->algorithm))
        return 1;
    const uint64_t before = space->path.rays;
    const uint32_t light = path_walk_light(&sampler->renderer->scene, &space->path, space->light,
                                           most > 1 ? most : 1, PATH_ENDS_JOINED);
    sampler_count_rays(sampler, before, 2);
    return light > 1 || settings_joins_all(settings->algorithm) ? light : 1; /* s = 1 has points of its own */
}

void sampler_evaluate(sampler_t *sampler, uint64_t key)
{
    work_space_t *space = sampler->space;
    const renderer_t *renderer = sampler->renderer;
    const uint32_t K = renderer->settings.max_path_length;
    const uint64_t before = space->path.rays;
    sampler->key = key;
    sampler->pixel = rgb_gray(0);
    sampler->splat_count = 0;
    for (uint32_t k = 1; k <= K; k++)
        sampler->totals[k] = 0;
    const uint32_t camera =
        path_walk_camera(&renderer->scene, &space->path, space->camera, sampler->longest + 1, PATH_ENDS_ON_LIGHT);
    sampler_count_rays(sampler, before, 1);
    const uint32_t light = sampler_walk_light(sampler);
    for (uint32_t t = 1; t <= camera; t++)
        for (uint32_t s = t == 1; s <= light; s++)
            sampler_join(sampler, s, t);
    const bool lit = !rgb_black(sampler->pixel);
    if (sampler->film && lit)
        unit_splat(&renderer->scene, sampler->film, space->path.raster, rgb_scale(sampler->pixel, sampler->scale),
                   key, UNIT_DRAW_FILTER + 2);
    if (sampler->splats && lit)
        sampler->splats[sampler->splat_count++] = (sampler_splat_t){space->path.raster, sampler->pixel};
    for (uint32_t k = 1; sampler->moments && k <= K; k++)
        unit_moment(&sampler->moments[work_samples_moment(k)], sampler->totals[k]);
}

void sampler_run(sampler_t *sampler, uint64_t key, int64_t pixel)
{
    work_space_t *space = sampler->space;
    const path_scene_t *scene = &sampler->renderer->scene;
    const settings_t *settings = &sampler->renderer->settings;
    const uint32_t camera = path_camera_dimensions(scene, sampler->longest + 1),
                   light = path_light_dimensions(sampler->longest);
    kernel_draw(key, UNIT_DRAW_CAMERA, space->camera, camera);
    if (sampler->net)
        sampler_place_camera(sampler->net, space->camera, camera, scene->camera_dimensions);
    if (pixel >= 0) {
        space->camera[0] = ((double)(pixel % settings->width) + space->camera[0]) / settings->width;
        space->camera[1] = ((double)(pixel / settings->width) + space->camera[1]) / settings->height;
    }
    if (settings->algorithm != SETTINGS_PT)
        kernel_draw(key, UNIT_DRAW_LIGHT, space->light, light);
    if (settings->algorithm != SETTINGS_PT && sampler->net)
        sampler_place_light(sampler->net, space->light, light);
    sampler_evaluate(sampler, key);
}
