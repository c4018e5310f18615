#include "support/small_scenes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void demand(fault_code_t code, const fault_t *fault)
{
    if (code == FAULT_NONE)
        return;
    fprintf(stderr, "a test's scene cannot be made: %s\n", fault->text);
    abort();
}

/* ---- parts ---- */

void small_scene_begin(small_scene_t *out)
{
    *out = (small_scene_t){.builder = scene_builder_new()};
    if (!out->builder)
        abort();
}

scene_material_t small_material(scene_material_kind_t kind)
{
    const scene_param_t zero = {{0, 0, 0}, SCENE_NONE};
    return (scene_material_t){.kind = (uint32_t)kind,
                              .reflectance = zero,
                              .transmittance = zero,
                              .alpha_u = zero,
                              .alpha_v = zero,
                              .coat_alpha_u = zero,
                              .coat_alpha_v = zero,
                              .mix = zero,
                              .eta = {1.5f, 1.5f, 1.5f},
                              .coat_eta = 1.5f,
                              .first = SCENE_NONE,
                              .second = SCENE_NONE};
}

uint32_t small_add_material(small_scene_t *small, const scene_material_t *material)
{
    fault_t fault = {0};
    uint32_t index = 0;
    demand(scene_builder_add_material(small->builder, material, &index, &fault), &fault);
    return index;
}

uint32_t small_add_diffuse(small_scene_t *small, double r, double g, double b)
{
    scene_material_t material = small_material(SCENE_MATERIAL_DIFFUSE);
    material.reflectance = (scene_param_t){{(float)r, (float)g, (float)b}, SCENE_NONE};
    return small_add_material(small, &material);
}

static scene_shape_t shape_of(uint32_t kind, uint32_t material, int32_t light)
{
    return (scene_shape_t){.kind = kind,
                           .material = (int32_t)material,
                           .area_light = light,
                           .alpha = {{1, 1, 1}, SCENE_NONE},
                           .normal = {0, 0, 1},
                           .tangent = {1, 0, 0}};
}

uint32_t small_add_quads(small_scene_t *small, uint32_t material, int32_t light, const float *corners,
                         uint32_t quads)
{
    enum { MOST = 16 };
    const scene_shape_t shape = shape_of(SCENE_SHAPE_MESH, material, light);
    uint32_t indices[6 * MOST], index = 0;
    fault_t fault = {0};
    if (quads > MOST)
        abort();
    for (uint32_t q = 0; q < quads; q++) {
        static const uint32_t corner[6] = {0, 1, 2, 0, 2, 3};
        for (int i = 0; i < 6; i++)
            indices[6 * q + (uint32_t)i] = 4 * q + corner[i];
    }
    demand(scene_builder_add_mesh(small->builder, &shape, corners, NULL, NULL, 4 * (uint64_t)quads, indices,
                                  2 * (uint64_t)quads, &index, &fault),
           &fault);
    return index;
}

uint32_t small_add_sphere(small_scene_t *small, uint32_t material, const float centre[3], float radius)
{
    scene_shape_t shape = shape_of(SCENE_SHAPE_SPHERE, material, SCENE_NONE);
    uint32_t index = 0;
    fault_t fault = {0};
    for (int i = 0; i < 3; i++)
        shape.centre[i] = centre[i];
    shape.radius = radius;
    demand(scene_builder_add_shape(small->builder, &shape, &index, &fault), &fault);
    return index;
}

uint32_t small_add_disk(small_scene_t *small, uint32_t material, const float centre[3], const float normal[3],
                        float radius)
{
    scene_shape_t shape = shape_of(SCENE_SHAPE_DISK, material, SCENE_NONE);
    const float *n = normal;
    uint32_t index = 0;
    fault_t fault = {0};
    /* any vector across the normal: drop the component that is smallest, swap the other two */
    const int least =
        fabsf(n[0]) < fabsf(n[1]) ? (fabsf(n[0]) < fabsf(n[2]) ? 0 : 2) : (fabsf(n[1]) < fabsf(n[2]) ? 1 : 2);
    const int a = (least + 1) % 3, b = (least + 2) % 3;
    const float length = hypotf(n[a], n[b]);
    shape.tangent[least] = 0;
    shape.tangent[a] = n[b] / length;
    shape.tangent[b] = -n[a] / length;
    for (int i = 0; i < 3; i++) {
        shape.centre[i] = centre[i];
        shape.normal[i] = n[i];
    }
    shape.radius = radius;
    demand(scene_builder_add_shape(small->builder, &shape, &index, &fault), &fault);
    return index;
}

uint32_t small_add_light(small_scene_t *small, const scene_light_t *light)
{
    uint32_t index = 0;
    fault_t fault = {0};
    demand(scene_builder_add_light(small->builder, light, &index, &fault), &fault);
    return index;
}

void small_set_camera(small_scene_t *small, double x, double y, double z, double half)
{
    const scene_camera_t camera = {.to_world = {1, 0, 0, x, 0, 1, 0, y, 0, 0, -1, z},
                                   .screen = {-half, half, -half, half},
                                   .focal_distance = 1,
                                   .width = 24,
                                   .height = 24,
                                   .crop = {0, 24, 0, 24},
                                   .filter = SCENE_FILTER_BOX,
                                   .filter_radius = {0.5, 0.5},
                                   .imaging_scale = 1};
    scene_builder_set_camera(small->builder, &camera);
}

void small_scene_finish(small_scene_t *small)
{
    fault_t fault = {0};
    small->scene = scene_builder_view(small->builder);
    demand(scene_check(&small->scene, &fault), &fault);
}

void small_scene_clear(small_scene_t *small)
{
    scene_builder_destroy(&small->builder);
    *small = (small_scene_t){0};
}

/* ---- scenes ---- */

void small_scene_furnace(small_scene_t *out, double albedo, double emission)
{
    static const float walls[] = {
        -1, -1, -1, -1, -1, 1,  1,  -1, 1,  1,  -1, -1, /* below */
        -1, 1,  -1, 1,  1,  -1, 1,  1,  1,  -1, 1,  1,  /* above */
        -1, -1, -1, 1,  -1, -1, 1,  1,  -1, -1, 1,  -1, /* back */
        -1, -1, 1,  -1, 1,  1,  1,  1,  1,  1,  -1, 1,  /* front */
        -1, -1, -1, -1, 1,  -1, -1, 1,  1,  -1, -1, 1,  /* left */
        1,  -1, -1, 1,  -1, 1,  1,  1,  1,  1,  1,  -1, /* right */
    };
    small_scene_begin(out);
    const float e = (float)emission;
    const uint32_t material = small_add_diffuse(out, albedo, albedo, albedo);
    const uint32_t light = small_add_light(
        out, &(scene_light_t){
                 .kind = SCENE_LIGHT_AREA, .radiance = {e, e, e}, .image = SCENE_NONE, .direction = {0, 0, 1}});
    small_add_quads(out, material, (int32_t)light, walls, 6);
    small_set_camera(out, 0.1, -0.2, 0.7, 0.8);
    small_scene_finish(out);
}

/* The quad hangs at height 1.8 and shines down. */
static void add_lamp(small_scene_t *small)
{
    static const float quad[] = {-0.15f, 1.8f, -0.15f, 0.15f,  1.8f, -0.15f,
                                 0.15f,  1.8f, 0.15f,  -0.15f, 1.8f, 0.15f};
    const scene_light_t light = {
        .kind = SCENE_LIGHT_AREA, .radiance = {40, 34, 22}, .image = SCENE_NONE, .direction = {0, 0, 1}};
    const uint32_t index = small_add_light(small, &light);
    small_add_quads(small, small_add_diffuse(small, 0, 0, 0), (int32_t)index, quad, 1);
}

/* A black box around the lamp. */
static void add_case(small_scene_t *small)
{
    const float a = -0.3f, b = 0.3f, low = 1.7f, high = 1.9f;
    const float faces[] = {
        a, low, a, b, low, a, b, low,  b, a, low,  b, a, high, a, b, high, a, b, high, b, a, high, b,
        a, low, a, b, low, a, b, high, a, a, high, a, a, low,  b, b, low,  b, b, high, b, a, high, b,
        a, low, a, a, low, b, a, high, b, a, high, a, b, low,  a, b, low,  b, b, high, b, b, high, a,
    };
    small_add_quads(small, small_add_diffuse(small, 0, 0, 0), SCENE_NONE, faces, 6);
}

static void add_box_light(small_scene_t *small, small_light_t kind)
{
    static const scene_light_t lights[] = {
        [SMALL_LIGHT_CONSTANT] = {.kind = SCENE_LIGHT_INFINITE,
                                  .radiance = {0.8f, 0.9f, 1.1f},
                                  .image = SCENE_NONE,
                                  .direction = {0, 0, 1},
                                  .to_light = {1, 0, 0, 0, 1, 0, 0, 0, 1}},
        [SMALL_LIGHT_POINT] = {.kind = SCENE_LIGHT_POINT,
                               .radiance = {3, 2.5f, 2},
                               .image = SCENE_NONE,
                               .position = {0.1f, 1.7f, 0.2f},
                               .direction = {0, 0, 1}},
        [SMALL_LIGHT_SPOT] = {.kind = SCENE_LIGHT_SPOT,
                              .radiance = {6, 5, 4},
                              .image = SCENE_NONE,
                              .position = {0.1f, 1.7f, 0.2f},
                              .cos_start = 0.9f,
                              .direction = {0, -1, 0},
                              .cos_end = 0.6f},
        [SMALL_LIGHT_DISTANT] = {.kind = SCENE_LIGHT_DISTANT,
                                 .radiance = {2, 2.2f, 2.5f},
                                 .image = SCENE_NONE,
                                 .direction = {0.36f, -0.8f, -0.48f}},
    };
    if (kind == SMALL_LIGHT_AREA || kind == SMALL_LIGHT_HIDDEN)
        add_lamp(small);
    else if (kind != SMALL_LIGHT_NONE)
        small_add_light(small, &lights[kind]);
    if (kind == SMALL_LIGHT_HIDDEN)
        add_case(small);
}

static void add_box_walls(small_scene_t *small)
{
    static const float floor[] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1};
    static const float back[] = {-1, 0, -1, 1, 0, -1, 1, 2, -1, -1, 2, -1};
    static const float left[] = {-1, 0, 1, -1, 0, -1, -1, 2, -1, -1, 2, 1};
    static const float right[] = {1, 0, -1, 1, 0, 1, 1, 2, 1, 1, 2, -1};
    const uint32_t white = small_add_diffuse(small, 0.72, 0.7, 0.68),
                   red = small_add_diffuse(small, 0.6, 0.1, 0.05), green = small_add_diffuse(small, 0.15, 0.5, 0.1);
    small_add_quads(small, white, SCENE_NONE, floor, 1);
    small_add_quads(small, white, SCENE_NONE, back, 1);
    small_add_quads(small, red, SCENE_NONE, left, 1);
    small_add_quads(small, green, SCENE_NONE, right, 1);
}

static void add_box_block(small_scene_t *small)
{
    const float x0 = -0.75f, x1 = -0.3f, z0 = -0.7f, z1 = -0.25f, h = 0.9f;
    const float faces[] = {
        x0, h,  z0, x0, h,  z1, x1, h,  z1, x1, h,  z0, x0, 0,  z1, x1, 0,  z1, x1, h,
        z1, x0, h,  z1, x1, 0,  z0, x0, 0,  z0, x0, h,  z0, x1, h,  z0, x0, 0,  z0, x0,
        0,  z1, x0, h,  z1, x0, h,  z0, x1, 0,  z1, x1, 0,  z0, x1, h,  z0, x1, h,  z1,
    };
    small_add_quads(small, small_add_diffuse(small, 0.55, 0.55, 0.6), SCENE_NONE, faces, 5);
}

void small_scene_box(small_scene_t *out, small_light_t light)
{
    static const float mirror_quad[] = {0.1f, 0.5f, -0.95f, 0.8f, 0.5f, -0.95f,
                                        0.8f, 1.4f, -0.9f,  0.1f, 1.4f, -0.9f};
    scene_material_t mirror = small_material(SCENE_MATERIAL_CONDUCTOR), rough = mirror,
                     glass = small_material(SCENE_MATERIAL_DIELECTRIC);
    for (int c = 0; c < 3; c++) {
        mirror.eta[c] = 0.2f + 0.4f * (float)c;
        mirror.k[c] = 3.5f - 0.5f * (float)c;
        rough.eta[c] = mirror.eta[c];
        rough.k[c] = mirror.k[c];
    }
    rough.alpha_u.value[0] = rough.alpha_v.value[0] = 0.25f;
    small_scene_begin(out);
    add_box_walls(out);
    add_box_block(out);
    small_add_quads(out, small_add_material(out, &mirror), SCENE_NONE, mirror_quad, 1);
    small_add_sphere(out, small_add_material(out, &glass), (const float[]){0.45f, 0.35f, 0.3f}, 0.3f);
    small_add_sphere(out, small_add_material(out, &rough), (const float[]){-0.4f, 0.25f, 0.45f}, 0.22f);
    add_box_light(out, light);
    small_set_camera(out, 0, 1, 6.8, 0.18);
    small_scene_finish(out);
}

void small_scene_diffuse(small_scene_t *out)
{
    small_scene_begin(out);
    add_box_walls(out);
    add_box_block(out);
    add_lamp(out);
    small_set_camera(out, 0, 1, 6.8, 0.18);
    small_scene_finish(out);
}
