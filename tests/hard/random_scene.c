#include "random_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/random.h"
#include "math/frame.h"
#include "math/warp.h"

typedef struct maker {
    scene_builder_t *builder;
    uint64_t key, count;
    double size;
    vec3_t centre;
    uint32_t materials, textures, lights;
    int32_t area_lights[4];
} maker_t;

static double next(maker_t *m)
{
    return random_double(m->key, m->count++);
}

static double between(maker_t *m, double a, double b)
{
    return a + (b - a) * next(m);
}

static uint32_t below(maker_t *m, uint32_t n)
{
    return (uint32_t)(next(m) * n);
}

static bool chance(maker_t *m, double p)
{
    return next(m) < p;
}

/* 10^between(a, b) */
static double power(maker_t *m, double a, double b)
{
    return pow(10, between(m, a, b));
}

static void demand(fault_code_t code, const fault_t *fault)
{
    if (code == FAULT_NONE)
        return;
    fprintf(stderr, "a random scene cannot be made: %s\n", fault->text);
    abort();
}

static vec3_t unit(maker_t *m)
{
    const double u = next(m), v = next(m);
    return warp_sphere(u, v);
}

static void put(float *out, vec3_t v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

static vec3_t place(maker_t *m)
{
    const double x = between(m, -1, 1), y = between(m, -1, 1), z = between(m, -1, 1);
    return vec3_mad(m->centre, m->size, vec3(x, y, z));
}

/* ---- textures and materials ---- */

static float fraction(maker_t *m)
{
    switch (below(m, 5)) {
    case 0:
        return 0;
    case 1:
        return 1;
    case 2:
        return (float)power(m, -8, 0);
    default:
        return (float)next(m);
    }
}

static scene_param_t param(maker_t *m)
{
    scene_param_t p = {{fraction(m), fraction(m), fraction(m)}, SCENE_NONE};
    if (m->textures > 0 && chance(m, 0.3))
        p.texture = (int32_t)below(m, m->textures);
    return p;
}

/* Roughness: from a mirror over the threshold to 1. */
static scene_param_t roughness(maker_t *m)
{
    scene_param_t p = {{0, 0, 0}, SCENE_NONE};
    if (!chance(m, 0.3))
        p.value[0] = (float)power(m, -4.2, 0);
    if (m->textures > 0 && chance(m, 0.15))
        p.texture = (int32_t)below(m, m->textures);
    return p;
}

/* Of coats few values: each has its table. */
static scene_param_t coat_roughness(maker_t *m)
{
    static const float some[] = {0, 0, 1e-4f, 0.3f};
    scene_param_t p = {{some[below(m, 4)], 0, 0}, SCENE_NONE};
    if (m->textures > 0 && chance(m, 0.05))
        p.texture = (int32_t)below(m, m->textures);
    return p;
}

static void add_textures(maker_t *m)
{
    fault_t fault = {0};
    uint32_t index, image;
    float texels[4 * 4 * 3];
    for (int i = 0; i < 48; i++)
        texels[i] = chance(m, 0.4) ? 0 : (float)next(m);
    const scene_image_t picture = {.width = 4, .height = 4, .channels = 3, .texel = SCENE_TEXEL_FLOAT32};
    demand(scene_builder_add_image(m->builder, &picture, texels, &image, &fault), &fault);
    const uint32_t count = below(m, 4);
    for (uint32_t i = 0; i < count; i++) {
        scene_texture_t t = {.kind = below(m, 5),
                             .wrap = below(m, 3),
                             .image = SCENE_NONE,
                             .scale_u = (float)power(m, -3, 3),
                             .scale_v = (float)-power(m, -3, 3),
                             .offset_u = (float)between(m, -9, 9),
                             .value = {fraction(m), fraction(m), fraction(m)},
                             .invert = below(m, 2)};
        if (t.kind == SCENE_TEXTURE_IMAGE)
            t.image = (int32_t)image;
        t.a = param(m);
        t.b = param(m);
        t.m = param(m);
        demand(scene_builder_add_texture(m->builder, &t, &index, &fault), &fault);
        m->textures = index + 1;
    }
}

static float index_of_refraction(maker_t *m)
{
    static const float special[] = {1, 1.0001f, 0.9999f, 1.5f, 0.66666f, 1.0000005f, 20, 0.05f};
    return chance(m, 0.6) ? special[below(m, 8)] : (float)power(m, -2.9, 2.9);
}

static void add_material(maker_t *m)
{
    fault_t fault = {0};
    scene_material_t material = {.kind = below(m, SCENE_MATERIAL_KINDS),
                                 .remap_roughness = below(m, 2),
                                 .reflectance = param(m),
                                 .transmittance = param(m),
                                 .alpha_u = roughness(m),
                                 .coat_eta = index_of_refraction(m),
                                 .coat_alpha_u = coat_roughness(m),
                                 .mix = param(m),
                                 .first = SCENE_NONE,
                                 .second = SCENE_NONE};
    for (int i = 0; i < 3; i++) {
        material.eta[i] = index_of_refraction(m);
        material.k[i] = chance(m, 0.3) ? 0 : (float)power(m, -3, 2.9);
    }
    material.alpha_v = chance(m, 0.5) ? material.alpha_u : roughness(m);
    material.coat_alpha_v = chance(m, 0.8) ? material.coat_alpha_u : coat_roughness(m);
    if (material.kind == SCENE_MATERIAL_MIX && m->materials == 0)
        material.kind = SCENE_MATERIAL_DIFFUSE;
    if (material.kind == SCENE_MATERIAL_MIX) {
        material.first = (int32_t)below(m, m->materials);
        material.second = (int32_t)below(m, m->materials);
    }
    uint32_t index;
    demand(scene_builder_add_material(m->builder, &material, &index, &fault), &fault);
    m->materials = index + 1;
}

/* ---- lights ---- */

static void add_light(maker_t *m, uint32_t kind)
{
    fault_t fault = {0};
    const double strength = power(m, -10, 10) * (kind >= SCENE_LIGHT_POINT ? m->size * m->size : 1);
    scene_light_t light = {.kind = kind, .two_sided = below(m, 2), .image = SCENE_NONE};
    for (int i = 0; i < 3; i++)
        light.radiance[i] = chance(m, 0.15) ? 0 : (float)fmin(strength * power(m, -1, 0), 1e37);
    put(light.position, place(m));
    put(light.direction, unit(m));
    light.cos_end = (float)between(m, -1, 1);
    light.cos_start = chance(m, 0.3) ? light.cos_end : (float)between(m, (double)light.cos_end, 1);
    const frame_t frame = frame_of_normal(unit(m));
    put(light.to_light, frame.s);
    put(light.to_light + 3, frame.t);
    put(light.to_light + 6, frame.n);
    if (kind == SCENE_LIGHT_INFINITE && chance(m, 0.5))
        light.image = 0;
    uint32_t index;
    demand(scene_builder_add_light(m->builder, &light, &index, &fault), &fault);
    if (kind == SCENE_LIGHT_AREA)
        m->area_lights[m->lights++] = (int32_t)index;
}

/* ---- shapes ---- */

static scene_shape_t shape_of(maker_t *m, uint32_t kind)
{
    scene_shape_t shape = {.kind = kind,
                           .flags = chance(m, 0.3) ? SCENE_SHAPE_FLIP : 0,
                           .material = (int32_t)below(m, m->materials),
                           .area_light = SCENE_NONE,
                           .alpha = {{1, 1, 1}, SCENE_NONE},
                           .normal = {0, 0, 1},
                           .tangent = {1, 0, 0}};
    if (chance(m, 0.3))
        shape.area_light = m->area_lights[below(m, m->lights)];
    if (chance(m, 0.15))
        shape.alpha = param(m);
    return shape;
}

static void add_round(maker_t *m)
{
    fault_t fault = {0};
    uint32_t index;
    scene_shape_t shape = shape_of(m, chance(m, 0.6) ? SCENE_SHAPE_SPHERE : SCENE_SHAPE_DISK);
    const frame_t frame = frame_of_normal(unit(m));
    put(shape.centre, place(m));
    put(shape.normal, frame.n);
    put(shape.tangent, frame.s);
    shape.radius = (float)fmax(m->size * (chance(m, 0.3) ? power(m, -9, 0) : between(m, 0.05, 1)), 2e-38);
    demand(scene_builder_add_shape(m->builder, &shape, &index, &fault), &fault);
}

/* A soup of triangles, some large, some needles, some of no area. */
static void add_soup(maker_t *m)
{
    enum { MOST = 12 };
    float positions[9 * MOST], normals[9 * MOST], uvs[6 * MOST];
    uint32_t indices[3 * MOST], index;
    fault_t fault = {0};
    const uint32_t count = 1 + below(m, MOST);
    for (uint32_t t = 0; t < count; t++) {
        const vec3_t p = place(m);
        vec3_t corner[3] = {p, place(m), place(m)};
        if (chance(m, 0.3)) /* a needle */
            corner[2] = vec3_mad(corner[1], m->size * power(m, -7, -3), unit(m));
        else if (chance(m, 0.2)) /* small */
            for (int i = 1; i < 3; i++)
                corner[i] = vec3_mad(p, m->size * power(m, -7, -1), unit(m));
        else if (chance(m, 0.1)) /* of no area */
            corner[2] = corner[below(m, 2)];
        for (uint32_t i = 0; i < 3; i++) {
            put(positions + 9 * t + 3 * i, corner[i]);
            put(normals + 9 * t + 3 * i, unit(m));
            uvs[6 * t + 2 * i] = (float)between(m, -3, 3);
            uvs[6 * t + 2 * i + 1] = chance(m, 0.2) ? uvs[6 * t] : (float)between(m, -3, 3);
            indices[3 * t + i] = 3 * t + i;
        }
    }
    const scene_shape_t shape = shape_of(m, SCENE_SHAPE_MESH);
    const bool with_normals = chance(m, 0.5), with_uvs = chance(m, 0.5);
    demand(scene_builder_add_mesh(m->builder, &shape, positions, with_normals ? normals : NULL,
                                  with_uvs ? uvs : NULL, 3 * (uint64_t)count, indices, count, &index, &fault),
           &fault);
}

/* A box around everything, so that light stays. */
static void add_room(maker_t *m)
{
    float positions[24];
    static const uint32_t indices[36] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                         2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    fault_t fault = {0};
    uint32_t index;
    for (int i = 0; i < 8; i++)
        put(positions + 3 * i,
            vec3_mad(m->centre, 1.5 * m->size, vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
    const scene_shape_t shape = shape_of(m, SCENE_SHAPE_MESH);
    demand(scene_builder_add_mesh(m->builder, &shape, positions, NULL, NULL, 8, indices, 12, &index, &fault),
           &fault);
}

/* ---- camera ---- */

static void set_camera(maker_t *m)
{
    const frame_t frame = frame_of_normal(unit(m));
    const vec3_t p = place(m);
    const double half = power(m, -3, 0.5);
    scene_camera_t camera = {.to_world = {frame.s.x, frame.t.x, frame.n.x, p.x, frame.s.y, frame.t.y, frame.n.y,
                                          p.y, frame.s.z, frame.t.z, frame.n.z, p.z},
                             .screen = {-half, half, -half, half},
                             .focal_distance = fmax(m->size, 1e-12),
                             .width = 8,
                             .height = 8,
                             .crop = {0, 8, 0, 8},
                             .filter = below(m, SCENE_FILTER_KINDS),
                             .filter_radius = {0.5, 0.5},
                             .filter_sigma = 0.5,
                             .imaging_scale = power(m, -3, 3)};
    if (chance(m, 0.4))
        camera.lens_radius = m->size * power(m, -4, -0.5);
    if (camera.filter != SCENE_FILTER_BOX)
        camera.filter_radius[0] = camera.filter_radius[1] = between(m, 0.5, 3);
    if (chance(m, 0.2))
        camera.crop[1] = 1 + below(m, 8);
    scene_builder_set_camera(m->builder, &camera);
}

scene_builder_t *random_scene_new(uint64_t key, bool wild)
{
    maker_t m = {.builder = scene_builder_new(), .key = key};
    if (!m.builder)
        abort();
    m.size = wild ? power(&m, -20, 12) : power(&m, -6, 6);
    if (chance(&m, 0.3))
        m.centre = vec3_scale(unit(&m), m.size * power(&m, 0, wild ? 2 : 5));
    add_textures(&m);
    const uint32_t materials = 2 + below(&m, 6), shapes = 2 + below(&m, 9), others = below(&m, 3);
    for (uint32_t i = 0; i < materials; i++)
        add_material(&m);
    for (int i = 0; i < 3; i++)
        add_light(&m, SCENE_LIGHT_AREA);
    for (uint32_t i = 0; i < others; i++)
        add_light(&m, 1 + below(&m, SCENE_LIGHT_KINDS - 1));
    if (chance(&m, 0.6))
        add_room(&m);
    for (uint32_t i = 0; i < shapes; i++)
        (chance(&m, 0.5) ? add_round : add_soup)(&m);
    set_camera(&m);
    const scene_t scene = scene_builder_view(m.builder);
    fault_t fault = {0};
    demand(scene_check(&scene, &fault), &fault);
    return m.builder;
}
