#include "absent_scene.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { MORE = SCENE_MATERIAL_KINDS + SCENE_LIGHT_KINDS + SCENE_TEXTURE_MIX + 1 }; /* room for what is added */

static const scene_param_t one = {{1, 1, 1}, SCENE_NONE};

static void *copy_of(const void *from, size_t size, size_t count)
{
    void *copy = calloc(count + MORE, size);
    if (copy && count > 0)
        memcpy(copy, from, size * count);
    return copy;
}

/* The same scene in arrays with room for more. */
static fault_code_t absent_scene_copy(absent_scene_t *out, const scene_t *from, fault_t *fault)
{
    *out = (absent_scene_t){.scene = *from};
    out->shapes = copy_of(from->shapes, sizeof *out->shapes, from->shape_count);
    out->materials = copy_of(from->materials, sizeof *out->materials, from->material_count);
    out->textures = copy_of(from->textures, sizeof *out->textures, from->texture_count);
    out->lights = copy_of(from->lights, sizeof *out->lights, from->light_count);
    if (!out->shapes || !out->materials || !out->textures || !out->lights) {
        absent_scene_clear(out);
        return fault_set(fault, FAULT_MEMORY, "no memory for a scene's copy");
    }
    out->scene.shapes = out->shapes;
    out->scene.materials = out->materials;
    out->scene.textures = out->textures;
    out->scene.lights = out->lights;
    return FAULT_NONE;
}

static fault_code_t absent_scene_finish(absent_scene_t *out, fault_t *fault)
{
    const fault_code_t code = scene_check(&out->scene, fault);
    if (code)
        absent_scene_clear(out);
    return code;
}

/* A texture that is 1; its index. */
static int32_t add_texture(absent_scene_t *out, scene_texture_kind_t kind)
{
    out->textures[out->scene.texture_count] = (scene_texture_t){.kind = kind,
                                                                .image = SCENE_NONE,
                                                                .scale_u = 1,
                                                                .scale_v = 1,
                                                                .value = {1, 1, 1},
                                                                .a = one,
                                                                .b = one,
                                                                .m = one};
    return (int32_t)out->scene.texture_count++;
}

fault_code_t absent_scene_unused(absent_scene_t *out, const scene_t *from, fault_t *fault)
{
    TRY(absent_scene_copy(out, from, fault));
    for (int kind = 0; kind <= SCENE_TEXTURE_MIX; kind++)
        if (kind != SCENE_TEXTURE_IMAGE) /* would need an image */
            add_texture(out, (scene_texture_kind_t)kind);
    for (int kind = 0; kind < SCENE_MATERIAL_KINDS; kind++) {
        const int32_t first = (int32_t)from->material_count, texture = (int32_t)from->texture_count;
        const bool mix = kind == SCENE_MATERIAL_MIX;
        out->materials[out->scene.material_count++] = (scene_material_t){.kind = (uint32_t)kind,
                                                                         .reflectance = {{1, 1, 1}, texture},
                                                                         .transmittance = one,
                                                                         .alpha_u = {{0}, SCENE_NONE},
                                                                         .alpha_v = {{0}, SCENE_NONE},
                                                                         .eta = {1.5f, 1.5f, 1.5f},
                                                                         .coat_eta = 1.5f,
                                                                         .coat_alpha_u = one,
                                                                         .coat_alpha_v = one,
                                                                         .mix = {{0.5f}, texture},
                                                                         .first = mix ? first : SCENE_NONE,
                                                                         .second = mix ? first + 1 : SCENE_NONE};
    }
    static const scene_light_kind_t kinds[] = {SCENE_LIGHT_AREA, SCENE_LIGHT_DISTANT, SCENE_LIGHT_POINT,
                                               SCENE_LIGHT_SPOT};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        scene_light_t *light = &out->lights[out->scene.light_count++];
        *light = (scene_light_t){
            .kind = kinds[i], .image = SCENE_NONE, .direction = {0, 0, 1}, .cos_start = 0.9f, .cos_end = 0.8f};
        if (kinds[i] == SCENE_LIGHT_AREA) /* no shape has it */
            light->radiance[0] = light->radiance[1] = light->radiance[2] = 1;
    }
    return absent_scene_finish(out, fault);
}

static void force_param(scene_param_t *param, int32_t texture)
{
    if (param->texture == SCENE_NONE)
        param->texture = texture;
}

/* Roughness that is a constant has been remapped; as a texture it would be once more. */
static void force_material(scene_material_t *m, int32_t texture)
{
    const bool rough = m->alpha_u.texture != SCENE_NONE || m->alpha_v.texture != SCENE_NONE ||
                       m->coat_alpha_u.texture != SCENE_NONE || m->coat_alpha_v.texture != SCENE_NONE;
    force_param(&m->reflectance, texture);
    force_param(&m->transmittance, texture);
    force_param(&m->mix, texture);
    if (rough && m->remap_roughness)
        return;
    m->remap_roughness = 0;
    force_param(&m->alpha_u, texture);
    force_param(&m->alpha_v, texture);
    force_param(&m->coat_alpha_u, texture);
    force_param(&m->coat_alpha_v, texture);
}

fault_code_t absent_scene_forced(absent_scene_t *out, const scene_t *from, fault_t *fault)
{
    TRY(absent_scene_copy(out, from, fault));
    const int32_t texture = add_texture(out, SCENE_TEXTURE_SCALE);
    for (uint32_t i = 0; i < from->material_count; i++)
        if (out->materials[i].kind != SCENE_MATERIAL_INTERFACE)
            force_material(&out->materials[i], texture);
    for (uint32_t i = 0; i < from->shape_count; i++)
        if (out->shapes[i].area_light == SCENE_NONE)
            force_param(&out->shapes[i].alpha, texture);
    return absent_scene_finish(out, fault);
}

void absent_scene_clear(absent_scene_t *scene)
{
    free(scene->shapes);
    free(scene->materials);
    free(scene->textures);
    free(scene->lights);
    *scene = (absent_scene_t){0};
}
