/* features.c: what the camera sees first, per pixel: albedo, world normal, depth (docs/images.md). The mean over a
 * fixed grid of rays, record->side along each side; a pixel lies in one unit only, so plain floats are exact enough
 * and free of order. */
#include <string.h>

#include "chain/unit.h"

/* `share`: of the ray in its pixel. */
static void feature_ray(work_space_t *space, const double film[2], double share, float *pixel)
{
    const path_scene_t *scene = &space->renderer->scene;
    memcpy(space->camera, film, 2 * sizeof *film);
    if (scene->camera_dimensions == 4)
        space->camera[2] = space->camera[3] = 0; /* the lens's centre */
    if (path_walk_camera(scene, &space->path, space->camera, 2, PATH_ENDS_ANYWHERE) < 2)
        return;
    const path_vertex_t *z = &space->path.camera[1];
    if (z->kind != PATH_SURFACE)
        return;
    if (z->bsdf) {
        const rgb_t albedo = bsdf_albedo(z->bsdf, scene->tables, z->wo);
        pixel[0] += (float)(albedo.r * share);
        pixel[1] += (float)(albedo.g * share);
        pixel[2] += (float)(albedo.b * share);
    }
    const vec3_t d = vec3_sub(z->position, space->path.camera[0].position);
    const double side = vec3_dot(d, z->ng) > 0 ? -share : share; /* towards the camera */
    const vec3_t n = z->bsdf ? z->frame.n : z->ng;
    pixel[3] += (float)(n.x * side);
    pixel[4] += (float)(n.y * side);
    pixel[5] += (float)(n.z * side);
    pixel[6] += (float)(vec3_dot(d, scene->camera.forward) * share);
}

fault_code_t unit_features(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                           work_result_t *result, fault_t *fault)
{
    const renderer_t *renderer = space->renderer;
    const camera_t *camera = &renderer->scene.camera;
    const size_t row = (size_t)WORK_FEATURE_CHANNELS * camera->width;
    const uint32_t side = record->side, rays = side * side;
    memset(space->features, 0, sizeof *space->features * row * record->count);
    for (uint64_t y = 0; y < record->count; y++) {
        if (atomic_load_explicit(cancel, memory_order_relaxed))
            return fault_set(fault, FAULT_CANCELLED, "cancelled");
        for (uint32_t x = 0; x < camera->width; x++)
            for (uint32_t i = 0; i < rays; i++) {
                const double raster_x = x + (i % side + 0.5) / side;
                const double raster_y = (double)(record->first + y) + ((double)(i / side) + 0.5) / side;
                const double film[2] = {(raster_x - camera->raster_x0) / camera->raster_w,
                                        (raster_y - camera->raster_y0) / camera->raster_h};
                feature_ray(space, film, 1.0 / rays, space->features + row * y + (size_t)WORK_FEATURE_CHANNELS * x);
            }
    }
    result->features = space->features;
    result->feature_rows = (uint32_t)record->count;
    result->feature_width = camera->width;
    result->stats.evaluations = record->count * camera->width * rays;
    return FAULT_NONE;
}
