/* probe_light.c: environments and spot lights. Compiled with either build. */
#include "math/warp.h"
#include "probe_list.h"
#include "scene/light.h"

/* A scene of one light and a sphere, which gives it its size. */
typedef struct lone {
    float texels[9];
    scene_image_t image;
    scene_shape_t shape;
    scene_light_t light;
    scene_material_t material;
    scene_t scene;
    light_set_t lights;
} lone_t;

static bool lone_open(lone_t *s)
{
    s->shape = (scene_shape_t){.kind = SCENE_SHAPE_SPHERE, .area_light = SCENE_NONE, .radius = 1};
    s->scene = (scene_t){.texels = (const uint8_t *)s->texels,
                         .images = &s->image,
                         .shapes = &s->shape,
                         .materials = &s->material,
                         .lights = &s->light,
                         .image_count = 1,
                         .shape_count = 1,
                         .material_count = 1,
                         .light_count = 1};
    return light_set_init(&s->lights, &s->scene, NULL) == FAULT_NONE;
}

/* texels 0-8, rotation 9-17 */
static bool sky_open(lone_t *s, const double *in)
{
    *s = (lone_t){.image = {.width = 3, .height = 3, .channels = 1, .texel = SCENE_TEXEL_FLOAT32},
                  .light = {.kind = SCENE_LIGHT_INFINITE, .radiance = {1, 1, 1}, .image = 0}};
    for (int i = 0; i < 9; i++) {
        s->texels[i] = (float)in[i];
        s->light.to_light[i] = (float)in[9 + i];
    }
    return lone_open(s);
}

/* Then position 1, 2, direction 1, 2. */
static bool run_sky_sample(const double *in, double *out)
{
    lone_t s;
    light_sample_t at;
    light_emission_t e;
    if (!sky_open(&s, in))
        return false;
    /* below 1: a table has no entry there, and the last number may have been moved */
    const double place[2] = {warp_clamp_unit(in[18]), warp_clamp_unit(in[19])};
    const bool made = light_sample_position(&s.lights, &s.scene, 0.5, place, &at) &&
                      light_sample_direction(&s.lights, &s.scene, &at, in + 20, &e);
    if (made) {
        probe_put(out, at.to_light);
        out[3] = at.pdf;
        probe_put(out + 4, e.origin);
        out[7] = e.pdf_direction;
        out[8] = e.radiance.r;
    }
    light_set_clear(&s.lights);
    return made;
}

/* Then a direction. */
static bool run_sky_value(const double *in, double *out)
{
    lone_t s;
    const double half[3] = {0.5, 0.5, 0.5};
    if (!sky_open(&s, in))
        return false;
    const light_sample_t at = {.to_light = probe_vec(in + 18)};
    double select;
    out[0] = light_infinite_radiance(&s.lights, &s.scene, 0, at.to_light, &out[1]).r;
    const bool made = light_invert_position(&s.lights, &s.scene, &at, half, &select, out + 2);
    light_set_clear(&s.lights);
    return made;
}

/* place 0-2, axis 3-5, cosines 6-7 */
static bool spot_open(lone_t *s, const double *in)
{
    *s = (lone_t){.light = {.kind = SCENE_LIGHT_SPOT,
                            .radiance = {1, 1, 1},
                            .image = SCENE_NONE,
                            .cos_start = (float)in[6],
                            .cos_end = (float)in[7]}};
    for (int i = 0; i < 3; i++) {
        s->light.position[i] = (float)in[i];
        s->light.direction[i] = (float)in[3 + i];
    }
    return lone_open(s);
}

/* Then direction 1, 2. */
static bool run_spot_sample(const double *in, double *out)
{
    lone_t s;
    light_sample_t at;
    light_emission_t e;
    const double none[2] = {0, 0};
    if (!spot_open(&s, in))
        return false;
    const bool made = light_sample_position(&s.lights, &s.scene, 0.5, none, &at) &&
                      light_sample_direction(&s.lights, &s.scene, &at, in + 8, &e);
    if (made) {
        probe_put(out, e.direction);
        out[3] = e.pdf_direction;
        out[4] = e.radiance.r;
    }
    light_set_clear(&s.lights);
    return made;
}

/* Then a direction. */
static bool run_spot_value(const double *in, double *out)
{
    lone_t s;
    const double half[2] = {0.5, 0.5};
    if (!spot_open(&s, in))
        return false;
    const light_sample_t at = {.position = probe_vec(in)};
    const vec3_t w = probe_vec(in + 8);
    out[0] = light_eval(&s.lights, &s.scene, 0, vec3(0, 0, 0), w, &out[1]).r;
    const bool made = out[0] > 0 && light_invert_direction(&s.lights, &s.scene, &at, at.position, w, half, out + 2);
    light_set_clear(&s.lights);
    return made;
}

/* A cell's density is a difference of two numbers of its table, and what is drawn by it: good to 2^-53 of a uniform
 * one, however small. Radiance beside a black texel goes to zero with the place: good to 2^-53 of the brightest. */
#define UNIFORM 0.0795774715459477

const probe_t probe_lights[] = {
    {{"environment, sample",
      "xbuuuu",
      {{"direction", 3, 0}, {"density", 1, UNIFORM}, {"origin", 3, 0}, {"of origin", 1, 0}, {"radiance", 1, 1}},
      0},
     run_sky_sample},
    {{"environment, value and inverse",
      "xbd",
      {{"radiance", 1, 1}, {"density", 1, UNIFORM}, {"u1", 1, 1}, {"u2", 1, 1}},
      0},
     run_sky_value},
    {{"spot, sample", "pzyuu", {{"direction", 3, 0}, {"density", 1, 0}, {"intensity", 1, 0}}, 0}, run_spot_sample},
    {{"spot, value and inverse", "pzyj", {{"intensity", 1, 0}, {"density", 1, 0}, {"u1", 1, 0}, {"u2", 1, 1}}, 0},
     run_spot_value},
    {{NULL, NULL, {{NULL, 0, 0}}, 0}, NULL},
};
