#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "scene/check.h"

/* ---- images ---- */

static fault_code_t check_float_texels(check_t *c, const scene_image_t *image)
{
    const uint64_t count = (uint64_t)image->width * image->height * image->channels;
    const float *texels = (const void *)(c->scene->texels + image->offset);
    for (uint64_t i = 0; i < count; i++)
        if (!(texels[i] >= 0 && texels[i] <= FLT_MAX))
            return check_refuse(c, FAULT_RANGE, "channel %llu of texel %llu is %g, expected 0 or more and finite",
                                (unsigned long long)(i % image->channels),
                                (unsigned long long)(i / image->channels), (double)texels[i]);
    return FAULT_NONE;
}

/* `end` is the end of the image before, and becomes this one's. */
static fault_code_t check_image(check_t *c, const scene_image_t *image, uint64_t *end)
{
    const uint64_t start = (*end + 15) & ~UINT64_C(15);
    TRY(check_number(c, "width", image->width, 1, SCENE_MAX_IMAGE_SIZE));
    TRY(check_number(c, "height", image->height, 1, SCENE_MAX_IMAGE_SIZE));
    if (image->channels != 1 && image->channels != 3 && image->channels != 4)
        return check_refuse(c, FAULT_RANGE, "%u channels, expected 1, 3 or 4", image->channels);
    TRY(check_word(c, "texel", image->texel, SCENE_TEXEL_FLOAT32 + 1));
    if (image->offset != start)
        return check_refuse(c, FAULT_FORMAT, "begins at byte %llu of the texels, expected %llu",
                            (unsigned long long)image->offset, (unsigned long long)start);
    const uint64_t bytes = (uint64_t)image->width * image->height * image->channels *
                           (image->texel == SCENE_TEXEL_FLOAT32 ? sizeof(float) : 1);
    if (start > c->scene->texel_bytes || bytes > c->scene->texel_bytes - start)
        return check_refuse(c, FAULT_RANGE, "needs %llu bytes from %llu on, the scene has %llu of texels",
                            (unsigned long long)bytes, (unsigned long long)start,
                            (unsigned long long)c->scene->texel_bytes);
    *end = start + bytes;
    return image->texel == SCENE_TEXEL_FLOAT32 ? check_float_texels(c, image) : FAULT_NONE;
}

fault_code_t check_images(check_t *c)
{
    uint64_t end = 0;
    for (uint32_t i = 0; i < c->scene->image_count; i++) {
        check_begin(c, "image", i);
        TRY(check_image(c, &c->scene->images[i], &end));
    }
    if (end != c->scene->texel_bytes)
        return fault_set(c->fault, FAULT_FORMAT, "the images have %llu bytes of texels, the scene has %llu",
                         (unsigned long long)end, (unsigned long long)c->scene->texel_bytes);
    return FAULT_NONE;
}

/* ---- textures ---- */

/* What a look-up of a texture can lead to. */
typedef struct reach {
    uint32_t visits; /* textures visited, all operands counted */
    double bound;    /* of its values */
} reach_t;

/* Largest texel; one for the texels of bytes. */
static double image_bound(const scene_t *scene, const scene_image_t *image)
{
    if (image->texel != SCENE_TEXEL_FLOAT32)
        return 1;
    const uint64_t count = (uint64_t)image->width * image->height * image->channels;
    const float *texels = (const void *)(scene->texels + image->offset);
    float largest = 0;
    for (uint64_t i = 0; i < count; i++)
        largest = texels[i] > largest ? texels[i] : largest;
    return (double)largest;
}

static double largest3(const float v[3])
{
    return fmax((double)v[0], fmax((double)v[1], (double)v[2]));
}

static reach_t param_reach(const scene_param_t *param, const reach_t *reach)
{
    if (param->texture < 0)
        return (reach_t){0, largest3(param->value)};
    const reach_t *r = &reach[param->texture];
    return (reach_t){r->visits, largest3(param->value) * r->bound};
}

/* Operands come before their texture, so that their reach is known and at most the limits allow. */
static reach_t texture_reach(const scene_texture_t *t, const reach_t *reach, const double *bounds)
{
    const double value = largest3(t->value);
    const reach_t a = param_reach(&t->a, reach), b = param_reach(&t->b, reach), m = param_reach(&t->m, reach);
    switch (t->kind) {
    case SCENE_TEXTURE_IMAGE:
        return (reach_t){1, fmax(value * bounds[t->image], 1)}; /* 1: of an inverted one */
    case SCENE_TEXTURE_SCALE:
        return (reach_t){1 + a.visits + b.visits, value * a.bound * b.bound};
    case SCENE_TEXTURE_CHECKERBOARD:
        return (reach_t){1 + a.visits + b.visits, fmax(a.bound, b.bound)};
    case SCENE_TEXTURE_MIX:
        return (reach_t){1 + a.visits + b.visits + m.visits, a.bound * (1 + m.bound) + b.bound * m.bound};
    default:
        return (reach_t){1, value};
    }
}

/* Operands of a texture may exceed 1: they scale. */
static fault_code_t check_operand(check_t *c, const char *field, const scene_param_t *param, uint32_t own)
{
    TRY(check_numbers(c, field, param->value, 3, 0, FLT_MAX));
    if (param->texture < 0 ? param->texture == SCENE_NONE : (uint32_t)param->texture < own)
        return FAULT_NONE;
    return check_refuse(c, FAULT_RANGE, "%s has the texture %d, expected one before %u or -1", field,
                        param->texture, own);
}

static fault_code_t check_texture(check_t *c, const scene_texture_t *t, uint32_t own)
{
    const bool has_image = t->kind == SCENE_TEXTURE_IMAGE;
    TRY(check_word(c, "kind", t->kind, SCENE_TEXTURE_MIX + 1));
    TRY(check_word(c, "wrap", t->wrap, SCENE_WRAP_CLAMP + 1));
    TRY(check_word(c, "invert", t->invert, 2));
    TRY(check_index(c, "image", t->image, has_image ? c->scene->image_count : 0, !has_image));
    TRY(check_word(c, "alpha_channel", (uint32_t)t->alpha_channel, 2));
    if (has_image && t->alpha_channel && c->scene->images[t->image].channels != 4)
        return check_refuse(c, FAULT_FORMAT, "wants the fourth channel of image %d, which has %u", t->image,
                            c->scene->images[t->image].channels);
    const float map[4] = {t->scale_u, t->scale_v, t->offset_u, t->offset_v};
    TRY(check_numbers(c, "scale and offset", map, 4, -FLT_MAX, FLT_MAX));
    TRY(check_numbers(c, "value", t->value, 3, 0, FLT_MAX));
    TRY(check_operand(c, "operand a", &t->a, own));
    TRY(check_operand(c, "operand b", &t->b, own));
    return check_operand(c, "operand m", &t->m, own);
}

static fault_code_t check_texture_list(check_t *c, reach_t *reach, const double *bounds)
{
    for (uint32_t i = 0; i < c->scene->texture_count; i++) {
        const scene_texture_t *t = &c->scene->textures[i];
        check_begin(c, "texture", i);
        TRY(check_texture(c, t, i));
        reach[i] = texture_reach(t, reach, bounds);
        if (reach[i].visits > CHECK_MAX_TEXTURE_VISITS)
            return check_refuse(c, FAULT_LIMIT, "looking it up visits more than %d textures",
                                CHECK_MAX_TEXTURE_VISITS);
        if (!(reach[i].bound <= CHECK_MAX_TEXTURE_VALUE))
            return check_refuse(c, FAULT_RANGE, "its values may reach %g, more than %g", reach[i].bound,
                                CHECK_MAX_TEXTURE_VALUE);
    }
    return FAULT_NONE;
}

fault_code_t check_textures(check_t *c)
{
    const scene_t *scene = c->scene;
    reach_t *reach = malloc(((size_t)scene->texture_count + 1) * sizeof *reach);
    double *bounds = malloc(((size_t)scene->image_count + 1) * sizeof *bounds);
    fault_code_t code = FAULT_NONE;
    if (!reach || !bounds)
        code = fault_set(c->fault, FAULT_MEMORY, "no memory to check %u textures", scene->texture_count);
    for (uint32_t i = 0; code == FAULT_NONE && i < scene->image_count; i++)
        bounds[i] = image_bound(scene, &scene->images[i]);
    if (code == FAULT_NONE)
        code = check_texture_list(c, reach, bounds);
    free(reach);
    free(bounds);
    return code;
}

/* ---- materials ---- */

static bool is_dielectric(const scene_material_t *m)
{
    return m->kind == SCENE_MATERIAL_DIELECTRIC || m->kind == SCENE_MATERIAL_THIN_DIELECTRIC;
}

static bool is_conductor(const scene_material_t *m)
{
    return m->kind == SCENE_MATERIAL_CONDUCTOR || m->kind == SCENE_MATERIAL_COATED_CONDUCTOR;
}

static bool is_coated(const scene_material_t *m)
{
    return m->kind == SCENE_MATERIAL_COATED_DIFFUSE || m->kind == SCENE_MATERIAL_COATED_CONDUCTOR;
}

static fault_code_t check_optics(check_t *c, const scene_material_t *m)
{
    const double most = (double)CHECK_MAX_ETA, least = 1e-3;
    TRY(check_numbers(c, "eta", m->eta, 3, 0, most));
    TRY(check_numbers(c, "k", m->k, 3, 0, most));
    TRY(check_number(c, "coat_eta", (double)m->coat_eta, is_coated(m) ? least : 0, most));
    if (is_dielectric(m))
        TRY(check_number(c, "eta[0]", (double)m->eta[0], least, most));
    if (is_conductor(m))
        TRY(check_numbers(c, "eta", m->eta, 3, least, most));
    return FAULT_NONE;
}

static fault_code_t check_material_params(check_t *c, const scene_material_t *m)
{
    const uint32_t textures = c->scene->texture_count;
    TRY(check_param(c, "reflectance", &m->reflectance, textures));
    TRY(check_param(c, "transmittance", &m->transmittance, textures));
    TRY(check_param(c, "alpha_u", &m->alpha_u, textures));
    TRY(check_param(c, "alpha_v", &m->alpha_v, textures));
    TRY(check_param(c, "coat_alpha_u", &m->coat_alpha_u, textures));
    TRY(check_param(c, "coat_alpha_v", &m->coat_alpha_v, textures));
    return check_param(c, "mix", &m->mix, textures);
}

static fault_code_t check_material(check_t *c, const scene_material_t *m, uint32_t own)
{
    const bool mix = m->kind == SCENE_MATERIAL_MIX;
    TRY(check_word(c, "kind", m->kind, SCENE_MATERIAL_KINDS));
    TRY(check_word(c, "remap_roughness", m->remap_roughness, 2));
    TRY(check_material_params(c, m));
    TRY(check_optics(c, m));
    TRY(check_index(c, "first", m->first, mix ? own : 0, !mix));
    return check_index(c, "second", m->second, mix ? own : 0, !mix);
}

/* Materials that a material is mixed of, with repetition, and in how many levels. */
typedef struct mixture {
    uint16_t materials, levels;
} mixture_t;

static mixture_t mixture_of(const scene_material_t *m, const mixture_t *mixtures)
{
    if (m->kind != SCENE_MATERIAL_MIX)
        return (mixture_t){1, 0};
    const mixture_t a = mixtures[m->first], b = mixtures[m->second];
    const uint16_t levels = a.levels > b.levels ? a.levels : b.levels;
    return (mixture_t){(uint16_t)(a.materials + b.materials), (uint16_t)(levels + 1)};
}

static fault_code_t check_material_list(check_t *c, mixture_t *mixtures)
{
    for (uint32_t i = 0; i < c->scene->material_count; i++) {
        const scene_material_t *m = &c->scene->materials[i];
        check_begin(c, "material", i);
        TRY(check_material(c, m, i));
        mixtures[i] = mixture_of(m, mixtures);
        if (mixtures[i].materials > CHECK_MAX_MIXED || mixtures[i].levels > CHECK_MAX_MIX_LEVELS)
            return check_refuse(c, FAULT_LIMIT, "a mix of %u materials in %u levels, at most %d in %d are allowed",
                                mixtures[i].materials, mixtures[i].levels, CHECK_MAX_MIXED, CHECK_MAX_MIX_LEVELS);
    }
    return FAULT_NONE;
}

fault_code_t check_materials(check_t *c)
{
    mixture_t *mixtures = malloc(((size_t)c->scene->material_count + 1) * sizeof *mixtures);
    if (!mixtures)
        return fault_set(c->fault, FAULT_MEMORY, "no memory to check %u materials", c->scene->material_count);
    const fault_code_t code = check_material_list(c, mixtures);
    free(mixtures);
    return code;
}
