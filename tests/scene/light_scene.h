/* light_scene.h: small scenes of lights, as plain arrays, for the tests of lights. */
#ifndef TESTS_SCENE_LIGHT_SCENE_H
#define TESTS_SCENE_LIGHT_SCENE_H

#include <string.h>

#include "math/sampling.h"
#include "scene/light.h"

enum { LIGHT_SCENE_MAX = 16, LIGHT_SCENE_TEXELS = 4096 };

typedef struct light_scene {
    scene_t scene;
    float positions[9 * LIGHT_SCENE_MAX];
    uint32_t indices[3 * LIGHT_SCENE_MAX];
    scene_shape_t shapes[LIGHT_SCENE_MAX];
    scene_material_t materials[2]; /* 0: diffuse, 1: interface */
    scene_light_t lights[LIGHT_SCENE_MAX];
    scene_image_t image;
    float texels[LIGHT_SCENE_TEXELS];
    scene_camera_t camera;
} light_scene_t;

static inline void light_scene_init(light_scene_t *s)
{
    memset(s, 0, sizeof *s);
    s->materials[1].kind = SCENE_MATERIAL_INTERFACE;
    for (int i = 0; i < 3; i++)
        s->camera.to_world[5 * i] = 1;
    s->scene = (scene_t){.positions = s->positions,
                         .indices = s->indices,
                         .shapes = s->shapes,
                         .materials = s->materials,
                         .images = &s->image,
                         .texels = (const uint8_t *)s->texels,
                         .lights = s->lights,
                         .camera = &s->camera,
                         .material_count = 2};
}

static inline scene_light_t *light_scene_add(light_scene_t *s, uint32_t kind, float r, float g, float b)
{
    scene_light_t *light = &s->lights[s->scene.light_count++];
    *light = (scene_light_t){.kind = kind, .radiance = {r, g, b}, .image = SCENE_NONE};
    light->direction[2] = 1;
    light->to_light[0] = light->to_light[4] = light->to_light[8] = 1;
    return light;
}

static inline scene_shape_t *light_scene_shape(light_scene_t *s, uint32_t kind, int32_t light)
{
    scene_shape_t *shape = &s->shapes[s->scene.shape_count++];
    *shape = (scene_shape_t){.kind = kind, .area_light = light, .alpha = {{1, 1, 1}, SCENE_NONE}};
    return shape;
}

/* A triangle as a mesh of its own; corners in single precision. */
static inline scene_shape_t *light_scene_triangle(light_scene_t *s, int32_t light, vec3_t a, vec3_t b, vec3_t c)
{
    scene_shape_t *shape = light_scene_shape(s, SCENE_SHAPE_MESH, light);
    shape->first_vertex = (uint32_t)s->scene.vertex_count;
    shape->first_triangle = (uint32_t)s->scene.triangle_count;
    shape->vertices = 3;
    shape->triangles = 1;
    const vec3_t corners[3] = {a, b, c};
    for (uint32_t i = 0; i < 3; i++) {
        float *p = s->positions + 3 * (s->scene.vertex_count + i);
        p[0] = (float)corners[i].x;
        p[1] = (float)corners[i].y;
        p[2] = (float)corners[i].z;
        s->indices[3 * s->scene.triangle_count + i] = i;
    }
    s->scene.vertex_count += 3;
    s->scene.triangle_count++;
    return shape;
}

static inline scene_shape_t *light_scene_round(light_scene_t *s, uint32_t kind, int32_t light, vec3_t centre,
                                               double radius, vec3_t normal)
{
    scene_shape_t *shape = light_scene_shape(s, kind, light);
    const float c[3] = {(float)centre.x, (float)centre.y, (float)centre.z};
    const float n[3] = {(float)normal.x, (float)normal.y, (float)normal.z};
    memcpy(shape->centre, c, sizeof c);
    memcpy(shape->normal, n, sizeof n);
    shape->radius = (float)radius;
    return shape;
}

static inline void light_scene_set(light_set_t *set, const light_scene_t *s)
{
    fault_t fault = {0};
    if (light_set_init(set, &s->scene, &fault))
        fail_msg("light_set_init: %s", fault.text);
}

/* A sample of emission with all that the three calls say. */
typedef struct emitted {
    double u[5];
    light_sample_t at;
    light_emission_t out;
} emitted_t;

static inline bool light_scene_emit(const light_set_t *set, const light_scene_t *s, emitted_t *e)
{
    return light_sample_position(set, &s->scene, e->u[0], e->u + 1, &e->at) &&
           light_sample_direction(set, &s->scene, &e->at, e->u + 3, &e->out);
}

#endif
