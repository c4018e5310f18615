/* scene.c: what paths are made in, put together. */
#include <stdlib.h>

#include "path/recentre.h"
#include "path/walk.h"

static double emitter_reach(const light_emitter_t *e)
{
    switch (e->kind) {
    case LIGHT_TRIANGLE:
        return fmax(vec3_max_abs(e->position), fmax(vec3_max_abs(vec3_add(e->position, e->edge1)),
                                                    vec3_max_abs(vec3_add(e->position, e->edge2))));
    case LIGHT_SPHERE:
    case LIGHT_DISK:
        return vec3_max_abs(e->position) + e->radius;
    default:
        return 0; /* no surface to start off */
    }
}

static bool material_wants_uv(const scene_t *scene, int32_t index)
{
    const scene_material_t *m = &scene->materials[index];
    const scene_param_t *params[] = {&m->reflectance,  &m->transmittance, &m->alpha_u, &m->alpha_v,
                                     &m->coat_alpha_u, &m->coat_alpha_v,  &m->mix};
    for (size_t i = 0; i < sizeof params / sizeof *params; i++)
        if (params[i]->texture >= 0)
            return true;
    if (m->alpha_u.value[0] != m->alpha_v.value[0] || m->coat_alpha_u.value[0] != m->coat_alpha_v.value[0])
        return true;
    if (m->kind == SCENE_MATERIAL_MIX)
        return material_wants_uv(scene, m->first) || material_wants_uv(scene, m->second);
    return false;
}

static uint8_t shape_flags(const path_scene_t *ps, const scene_shape_t *shape)
{
    const bool joins = (bsdf_material_flags(ps->tables, (uint32_t)shape->material) & BSDF_HAS_SMOOTH) &&
                       bsdf_material_visible(ps->scene, shape->material);
    return (uint8_t)((joins ? PATH_SHAPE_JOINS : 0) | (shape->area_light >= 0 ? PATH_SHAPE_EMITS : 0) |
                     (material_wants_uv(ps->scene, shape->material) ? PATH_SHAPE_WANTS_UV : 0));
}

fault_code_t path_scene_init(path_scene_t *out, const scene_t *scene, const scene_camera_t *camera, uint32_t width,
                             uint32_t height, fault_t *fault)
{
    *out = (path_scene_t){.scene = scene};
    fault_code_t code = path_recentre(&out->moved, scene, camera, fault);
    if (out->moved) {
        scene = out->scene = &out->moved->scene;
        camera = scene->camera;
    }
    if (!code)
        code = camera_init(&out->camera, camera, width, height, fault);
    if (!code)
        code = light_set_init(&out->lights, scene, fault);
    if (!code)
        code = bsdf_tables_new(&out->tables, scene, fault);
    if (!code)
        code = accel_new(&out->accel, scene, fault);
    if (code)
        goto cleanup;
    out->emitter_epsilon = malloc(sizeof *out->emitter_epsilon * out->lights.count);
    out->shape_flags = malloc(scene->shape_count + 1);
    if (!out->emitter_epsilon || !out->shape_flags) {
        code = fault_set(fault, FAULT_MEMORY, "no memory for %u emitters", out->lights.count);
        goto cleanup;
    }
    for (uint32_t i = 0; i < out->lights.count; i++)
        out->emitter_epsilon[i] = SURFACE_EPSILON * emitter_reach(&out->lights.emitters[i]);
    for (uint32_t i = 0; i < scene->shape_count; i++)
        out->shape_flags[i] = shape_flags(out, &scene->shapes[i]);
    out->camera_dimensions = out->camera.pinhole ? 2 : 4;
cleanup:
    if (code)
        path_scene_clear(out);
    return code;
}

void path_scene_clear(path_scene_t *scene)
{
    accel_destroy(&scene->accel);
    light_set_clear(&scene->lights);
    bsdf_tables_destroy(&scene->tables);
    free(scene->emitter_epsilon);
    free(scene->shape_flags);
    path_recentred_destroy(&scene->moved);
    *scene = (path_scene_t){0};
}
