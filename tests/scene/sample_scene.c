#include "scene/sample_scene.h"

#include <stdio.h>
#include <stdlib.h>

#include "scene/texture.h"

static void require(fault_code_t code, const fault_t *fault)
{
    if (code != FAULT_NONE) {
        fprintf(stderr, "sample scene: %s\n", fault->text);
        abort();
    }
}

static scene_param_t constant(float value)
{
    return (scene_param_t){{value, value, value}, SCENE_NONE};
}

static scene_param_t textured(int32_t texture)
{
    return (scene_param_t){{0.75f, 0.5f, 0.25f}, texture};
}

static void add_images(scene_builder_t *b, fault_t *fault)
{
    static const uint8_t srgb[18] = {0,   10,  20,  40,  60,  80,  100, 120, 140,
                                     160, 180, 200, 210, 220, 230, 240, 250, 255};
    static const uint8_t alpha[16] = {1, 2, 3, 255, 50, 60, 70, 0, 90, 80, 70, 128, 200, 201, 202, 64};
    static const float sky[12] = {0, 1, 2, 3.5f, 0.25f, 0.125f, 10, 20, 40, 0.5f, 0.5f, 0.5f};
    const scene_image_t images[SAMPLE_IMAGES] = {
        {.width = 3, .height = 2, .channels = 3, .texel = SCENE_TEXEL_SRGB8},
        {.width = 2, .height = 2, .channels = 4, .texel = SCENE_TEXEL_LINEAR8},
        {.width = 2, .height = 2, .channels = 3, .texel = SCENE_TEXEL_FLOAT32},
    };
    const void *const texels[SAMPLE_IMAGES] = {srgb, alpha, sky};
    for (int i = 0; i < SAMPLE_IMAGES; i++)
        require(scene_builder_add_image(b, &images[i], texels[i], NULL, fault), fault);
}

static void add_textures(scene_builder_t *b, int32_t unset, fault_t *fault)
{
    for (uint32_t kind = SCENE_TEXTURE_CONSTANT; kind <= SCENE_TEXTURE_MIX; kind++) {
        scene_texture_t t = {
            .kind = kind, .scale_u = 2, .scale_v = 3, .offset_u = 0.25f, .value = {0.5f, 0.6f, 0.7f}};
        t.image = kind == SCENE_TEXTURE_IMAGE ? SAMPLE_IMAGE_ALPHA : unset;
        t.alpha_channel = kind == SCENE_TEXTURE_IMAGE;
        t.a = kind >= SCENE_TEXTURE_SCALE ? textured((int32_t)kind - 1) : (scene_param_t){{0}, unset};
        t.b = kind >= SCENE_TEXTURE_SCALE ? constant(0.5f) : (scene_param_t){{0}, unset};
        t.m = kind == SCENE_TEXTURE_MIX ? textured(0) : (scene_param_t){{0}, unset};
        require(scene_builder_add_texture(b, &t, NULL, fault), fault);
    }
}

static void add_materials(scene_builder_t *b, int32_t unset, fault_t *fault)
{
    for (uint32_t kind = 0; kind < SCENE_MATERIAL_KINDS; kind++) {
        const scene_param_t none = {{0}, unset};
        scene_material_t m = {.kind = kind, .eta = {1.5f, 1.25f, 1.125f}, .k = {2, 3, 4}, .coat_eta = 1.5f};
        m.reflectance = textured((int32_t)(kind % 5));
        m.transmittance = kind == SCENE_MATERIAL_DIFFUSE_TRANSMISSION ? constant(0.25f) : none;
        m.alpha_u = m.alpha_v = constant(0.125f);
        m.coat_alpha_u = m.coat_alpha_v = none;
        m.mix = kind == SCENE_MATERIAL_MIX ? constant(0.5f) : none;
        m.first = kind == SCENE_MATERIAL_MIX ? SCENE_MATERIAL_DIFFUSE : unset;
        m.second = kind == SCENE_MATERIAL_MIX ? SCENE_MATERIAL_COATED_CONDUCTOR : unset;
        require(scene_builder_add_material(b, &m, NULL, fault), fault);
    }
}

static void add_lights(scene_builder_t *b, int32_t unset, fault_t *fault)
{
    for (uint32_t kind = 0; kind < SCENE_LIGHT_KINDS; kind++) {
        scene_light_t l = {.kind = kind, .radiance = {1, 2, 3}, .position = {0, 4, 0}, .direction = {0, -1, 0}};
        l.two_sided = kind == SCENE_LIGHT_AREA;
        l.cos_start = kind == SCENE_LIGHT_SPOT ? 0.9f : 0;
        l.cos_end = kind == SCENE_LIGHT_SPOT ? 0.8f : 0;
        l.image = kind == SCENE_LIGHT_INFINITE ? SAMPLE_IMAGE_SKY : unset;
        l.to_light[1] = l.to_light[5] = l.to_light[6] = 1;
        l.pad[1] = (uint32_t)~unset;
        require(scene_builder_add_light(b, &l, NULL, fault), fault);
    }
}

static void add_shapes(scene_builder_t *b, int dirty, fault_t *fault)
{
    static const float quad[12] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1};
    static const uint32_t quad_indices[6] = {0, 1, 2, 0, 2, 3};
    static const float triangle[9] = {0, 1, 0, 1, 1, 0, 0, 2, 0};
    static const float normals[9] = {0, 0, 1, 0, 0.6f, 0.8f, 0.6f, 0, 0.8f};
    static const float uvs[6] = {0, 0, 1, 0, 0, 1};
    static const uint32_t triangle_indices[3] = {0, 1, 2};
    scene_shape_t s = {.material = SCENE_MATERIAL_DIFFUSE, .area_light = SCENE_NONE, .alpha = constant(1)};
    s.pad0 = s.pad1 = s.radius = dirty ? 77.0f : 0.0f;
    require(scene_builder_add_mesh(b, &s, quad, NULL, NULL, 4, quad_indices, 2, NULL, fault), fault);
    s.flags = SCENE_SHAPE_FLIP;
    s.material = SAMPLE_MATERIAL_MIX;
    require(scene_builder_add_mesh(b, &s, triangle, normals, uvs, 3, triangle_indices, 1, NULL, fault), fault);
    s = (scene_shape_t){.kind = SCENE_SHAPE_SPHERE, .centre = {0, 3, 0}, .radius = 0.5f, .alpha = constant(0.75f)};
    s.normal[2] = s.tangent[0] = 1;
    s.pad0 = dirty ? 78.0f : 0.0f;
    s.area_light = SCENE_LIGHT_AREA;
    require(scene_builder_add_shape(b, &s, NULL, fault), fault);
    s.kind = SCENE_SHAPE_DISK;
    s.area_light = SCENE_NONE;
    s.material = SCENE_MATERIAL_INTERFACE;
    require(scene_builder_add_shape(b, &s, NULL, fault), fault);
}

scene_builder_t *sample_scene_build(int dirty)
{
    scene_builder_t *b = scene_builder_new();
    fault_t fault = {0};
    const int32_t unset = dirty ? 0 : SCENE_NONE;
    if (!b)
        abort();
    add_images(b, &fault);
    add_textures(b, unset, &fault);
    add_materials(b, unset, &fault);
    add_lights(b, unset, &fault);
    add_shapes(b, dirty, &fault);
    const scene_camera_t camera = {
        .to_world = {1, 0, 0, 0.5, 0, 1, 0, 1, 0, 0, -1, 5},
        .screen = {-0.5, 0.5, -0.25, 0.25},
        .lens_radius = 0.01,
        .focal_distance = 5,
        .width = 64,
        .height = 32,
        .crop = {0, 64, 8, 32},
        .filter = SCENE_FILTER_GAUSSIAN,
        .filter_radius = {1.5, 1.5},
        .filter_sigma = 0.5,
        .imaging_scale = 1,
    };
    scene_builder_set_camera(b, &camera);
    return b;
}

static double touch_material(const scene_t *scene, const scene_material_t *m)
{
    const scene_param_t *params[] = {&m->reflectance,  &m->transmittance, &m->alpha_u, &m->alpha_v,
                                     &m->coat_alpha_u, &m->coat_alpha_v,  &m->mix};
    double sum = 0;
    for (size_t i = 0; i < sizeof params / sizeof *params; i++)
        sum += rgb_mean(texture_param_color(scene, params[i], 0.3, 1.7)) +
               texture_param_scalar(scene, params[i], -5, 0.9);
    if (m->kind == SCENE_MATERIAL_MIX)
        sum += touch_material(scene, &scene->materials[m->first]) +
               touch_material(scene, &scene->materials[m->second]);
    return sum;
}

static double touch_mesh(const scene_t *scene, const scene_shape_t *s)
{
    double sum = 0;
    for (uint64_t i = 0; i < 3 * (uint64_t)s->triangles; i++) {
        const uint64_t v = s->first_vertex + scene->indices[3 * (uint64_t)s->first_triangle + i];
        sum += (double)scene->positions[3 * v] + (double)scene->positions[3 * v + 1] +
               (double)scene->positions[3 * v + 2];
        sum += s->flags & SCENE_SHAPE_NORMALS ? (double)scene->normals[3 * v + 2] : 0;
        sum += s->flags & SCENE_SHAPE_UVS ? (double)scene->uvs[2 * v + 1] : 0;
    }
    return sum;
}

double sample_scene_touch(const scene_t *scene)
{
    double sum = (double)scene->camera->width + scene->camera->to_world[3];
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const scene_shape_t *s = &scene->shapes[i];
        sum += touch_material(scene, &scene->materials[s->material]);
        sum += s->area_light >= 0 ? (double)scene->lights[s->area_light].radiance[0] : 0;
        sum += texture_param_scalar(scene, &s->alpha, 0.5, 0.5);
        sum += s->kind == SCENE_SHAPE_MESH ? touch_mesh(scene, s) : (double)s->radius;
    }
    for (uint32_t i = 0; i < scene->material_count; i++)
        sum += touch_material(scene, &scene->materials[i]);
    for (uint32_t i = 0; i < scene->texture_count; i++)
        sum += rgb_mean(texture_color(scene, (int32_t)i, 1e9, -1e-9)) + texture_scalar(scene, (int32_t)i, 0, 1);
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].image >= 0)
            sum += scene->texels[scene->images[scene->lights[i].image].offset];
    return sum;
}
