/* probe_scene.c: camera, lights and surfaces. Compiled with either build. */
#include <stdlib.h>

#include "math/warp.h"
#include "probe_list.h"
#include "scene/camera.h"
#include "scene/light.h"
#include "scene/surface.h"

/* ---- camera ---- */

/* At a place, in a frame around a direction, 8 x 8 pixels. */
static bool make_camera(camera_t *camera, const double *place, vec3_t forward, double half, double lens)
{
    const frame_t frame = frame_of_normal(forward);
    const scene_camera_t data = {.to_world = {frame.s.x, frame.t.x, forward.x, place[0], frame.s.y, frame.t.y,
                                              forward.y, place[1], frame.s.z, frame.t.z, forward.z, place[2]},
                                 .screen = {-half, half, -half, half},
                                 .lens_radius = lens,
                                 .focal_distance = 1,
                                 .width = 8,
                                 .height = 8,
                                 .crop = {0, 8, 0, 8},
                                 .filter_radius = {0.5, 0.5},
                                 .imaging_scale = 1};
    return camera_init(camera, &data, 0, 0, NULL) == FAULT_NONE;
}

/* place 0-2, forward 3-5, half 6, lens 7, numbers 8-11 */
static bool run_camera_sample(const double *in, double *out)
{
    camera_t camera;
    if (!make_camera(&camera, in, probe_vec(in + 3), in[6], in[7]))
        return false;
    camera_sample_t s;
    camera_sample(&camera, in + 8, in + 10, &s);
    probe_put(out, s.origin);
    probe_put(out + 3, s.direction);
    out[6] = s.pdf_direction;
    out[7] = s.pdf_position;
    return true;
}

/* place 0-2, forward 3-5, half 6, direction 7-9 */
static bool run_camera_value(const double *in, double *out)
{
    camera_t camera;
    camera_value_t v;
    double lens[2];
    if (!make_camera(&camera, in, probe_vec(in + 3), in[6], 0) ||
        !camera_eval(&camera, camera.origin, probe_vec(in + 7), &v) ||
        !camera_invert(&camera, camera.origin, probe_vec(in + 7), (const double[2]){0.5, 0.5}, out + 4, lens))
        return false;
    out[0] = v.raster.x;
    out[1] = v.raster.y;
    out[2] = v.importance;
    out[3] = v.pdf_direction;
    return true;
}

/* ---- a scene of one shape that emits ---- */

typedef struct single {
    float positions[9];
    uint32_t indices[3];
    scene_shape_t shape;
    scene_light_t light;
    scene_material_t material;
    scene_t scene;
    light_set_t lights;
} single_t;

static bool single_open(single_t *s, uint32_t kind, const double *in)
{
    *s = (single_t){.indices = {0, 1, 2},
                    .shape = {.kind = kind,
                              .area_light = 0,
                              .vertices = 3,
                              .triangles = 1,
                              .normal = {0, 0, 1},
                              .tangent = {1, 0, 0}},
                    .light = {.kind = SCENE_LIGHT_AREA, .radiance = {1, 1, 1}, .image = SCENE_NONE}};
    for (int i = 0; i < 9 && kind == SCENE_SHAPE_MESH; i++)
        s->positions[i] = (float)in[i];
    for (int i = 0; i < 3 && kind != SCENE_SHAPE_MESH; i++)
        s->shape.centre[i] = (float)in[i];
    s->shape.radius = kind == SCENE_SHAPE_MESH ? 0 : (float)in[3];
    s->scene = (scene_t){.positions = s->positions,
                         .indices = s->indices,
                         .shapes = &s->shape,
                         .materials = &s->material,
                         .lights = &s->light,
                         .vertex_count = 3,
                         .triangle_count = 1,
                         .shape_count = 1,
                         .material_count = 1,
                         .light_count = 1};
    return light_set_init(&s->lights, &s->scene, NULL) == FAULT_NONE;
}

/* ---- lights ---- */

/* The shape, then position 1, 2, direction 1, 2: what leaves it. */
static bool emit(single_t *s, const double *u, double *out)
{
    light_sample_t at;
    light_emission_t e;
    const bool made = light_sample_position(&s->lights, &s->scene, 0.5, u, &at) &&
                      light_sample_direction(&s->lights, &s->scene, &at, u + 2, &e);
    if (made) {
        probe_put(out, at.position);
        out[3] = at.pdf;
        probe_put(out + 4, e.direction);
        out[7] = e.pdf_direction;
    }
    light_set_clear(&s->lights);
    return made;
}

/* The shape, then a point of it and a direction: their numbers and densities. */
static bool emit_invert(single_t *s, const double *in, double *out)
{
    const light_sample_t at = {.position = probe_vec(in)};
    const double half[3] = {0.5, 0.5, 0.5};
    const vec3_t w = probe_vec(in + 3);
    double select;
    const bool made = light_invert_position(&s->lights, &s->scene, &at, half, &select, out) &&
                      light_invert_direction(&s->lights, &s->scene, &at, at.position, w, half, out + 2);
    light_set_clear(&s->lights);
    return made;
}

static bool run_emit_triangle(const double *in, double *out)
{
    single_t s;
    return single_open(&s, SCENE_SHAPE_MESH, in) && emit(&s, in + 9, out);
}

static bool run_emit_sphere(const double *in, double *out)
{
    single_t s;
    return single_open(&s, SCENE_SHAPE_SPHERE, in) && emit(&s, in + 4, out);
}

static bool run_emit_disk(const double *in, double *out)
{
    single_t s;
    return single_open(&s, SCENE_SHAPE_DISK, in) && emit(&s, in + 4, out);
}

static bool run_invert_triangle(const double *in, double *out)
{
    single_t s;
    return single_open(&s, SCENE_SHAPE_MESH, in) && emit_invert(&s, in + 9, out);
}

static bool run_invert_sphere(const double *in, double *out)
{
    single_t s;
    return single_open(&s, SCENE_SHAPE_SPHERE, in) && emit_invert(&s, in + 4, out);
}

static bool run_invert_disk(const double *in, double *out)
{
    single_t s;
    return single_open(&s, SCENE_SHAPE_DISK, in) && emit_invert(&s, in + 4, out);
}

/* ---- surfaces ---- */

/* The shape, then a place and the direction from there. */
static bool meet(single_t *s, const double *in, double *out)
{
    surface_t at;
    const accel_hit_t hit = {.t = 1};
    const bool met = surface_at_hit(&s->scene, &hit, probe_vec(in), probe_vec(in + 3), false, &at);
    if (met) {
        probe_put(out, at.position);
        probe_put(out + 3, at.ng);
    }
    light_set_clear(&s->lights);
    return met;
}

static bool run_meet_triangle(const double *in, double *out)
{
    single_t s;
    return single_open(&s, SCENE_SHAPE_MESH, in) && meet(&s, in + 9, out);
}

static bool run_meet_sphere(const double *in, double *out)
{
    single_t s;
    return single_open(&s, SCENE_SHAPE_SPHERE, in) && meet(&s, in + 4, out);
}

static bool run_meet_disk(const double *in, double *out)
{
    single_t s;
    return single_open(&s, SCENE_SHAPE_DISK, in) && meet(&s, in + 4, out);
}

#define EMITS                                                                                                      \
    {                                                                                                              \
        {"place", 3, 0}, {"density", 1, 0}, {"direction", 3, 0}, {"of direction", 1, 0},                           \
    }
#define NUMBERS                                                                                                    \
    {                                                                                                              \
        {"u1", 1, 0}, {"u2", 1, 1}, {"u3", 1, 0}, {"u4", 1, 1},                                                    \
    }

const probe_t probe_places[] = {
    {{"camera, sample",
      "pdfluuuu",
      {{"origin", 3, 0}, {"direction", 3, 0}, {"density", 1, 0}, {"of the place", 1, 0}},
      0},
     run_camera_sample},
    {{"camera, value and inverse",
      "pdfv",
      {{"raster x", 1, 8}, {"raster y", 1, 8}, {"importance", 1, 0}, {"density", 1, 0}, {"film", 2, 1}},
      0},
     run_camera_value},
    {{"triangle that emits", "tuuuu", EMITS, 0}, run_emit_triangle},
    {{"sphere that emits", "suuuu", EMITS, 0}, run_emit_sphere},
    {{"disk that emits", "ouuuu", EMITS, 0}, run_emit_disk},
    {{"triangle that emits, inverse", "tqd", NUMBERS, 0}, run_invert_triangle},
    {{"sphere that emits, inverse", "sqd", NUMBERS, 0}, run_invert_sphere},
    {{"disk that emits, inverse", "oqw", NUMBERS, 0}, run_invert_disk},
    {{"ray meets triangle", "tph", {{"place", 3, 0}, {"normal", 3, 0}}, 0}, run_meet_triangle},
    {{"ray meets sphere", "sph", {{"place", 3, 0}, {"normal", 3, 0}}, 0}, run_meet_sphere},
    {{"ray meets disk", "oph", {{"place", 3, 0}, {"normal", 3, 0}}, 0}, run_meet_disk},
    {{NULL, NULL, {{NULL, 0, 0}}, 0}, NULL},
};
