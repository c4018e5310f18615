#include "client/import/pbrt_lights.h"

#include <stdlib.h>
#include <string.h>

#include "client/import/picture.h"
#include "client/import/pbrt_textures.h"

#define LARGEST_RADIANCE 1e30
#define TO_RADIANS (MATH_PI / 180.0)

/* ---- what lights share ---- */

/* The colour under `name` times `scale`. */
static fault_code_t color_and_scale(pbrt_state_t *state, pbrt_params_t *params, const char *name, rgb_t *color,
                                    bool *given)
{
    double scale = 1;
    *color = rgb(1, 1, 1);
    TRY(pbrt_color(state, params, name, SPECTRA_LIGHT, color, given));
    PBRT_TRY(state, params, pbrt_params_float(params, "scale", 0, LARGEST_RADIANCE, &scale, state->fault));
    *color = rgb_scale(*color, scale);
    return FAULT_NONE;
}

/* A target (power, illuminance) below zero is not given, as in pbrt. */
static fault_code_t target(pbrt_state_t *state, pbrt_params_t *params, const char *name, double *value)
{
    *value = -1;
    PBRT_TRY(state, params,
             pbrt_params_float(params, name, -LARGEST_RADIANCE, LARGEST_RADIANCE, value, state->fault));
    if (!(*value > 0))
        *value = -1;
    return FAULT_NONE;
}

/* Scales the colour so that luminance * factor is the target. */
static void reach_target(rgb_t *color, double wanted, double factor)
{
    const double now = rgb_luminance(*color) * factor;
    if (wanted > 0 && now > 0)
        *color = rgb_scale(*color, wanted / now);
}

static fault_code_t add_light(pbrt_state_t *state, scene_light_t *light, rgb_t color)
{
    uint32_t index;
    if (!(rgb_max(color) <= LARGEST_RADIANCE))
        return pbrt_fault(state, FAULT_RANGE, "a light of the brightness %g, expected at most %g", rgb_max(color),
                          LARGEST_RADIANCE);
    light->radiance[0] = (float)color.r;
    light->radiance[1] = (float)color.g;
    light->radiance[2] = (float)color.b;
    return scene_builder_add_light(state->builder, light, &index, state->fault);
}

static fault_code_t set_position(pbrt_state_t *state, scene_light_t *light, vec3_t p)
{
    const vec3_t world = transform_point(&state->now.ctm, p);
    if (!vec3_finite(world) || vec3_max_abs(world) > (double)SCENE_MAX_COORDINATE)
        return pbrt_fault(state, FAULT_RANGE, "a light at (%g, %g, %g): expected coordinates of at most %g",
                          world.x, world.y, world.z, (double)SCENE_MAX_COORDINATE);
    light->position[0] = (float)world.x;
    light->position[1] = (float)world.y;
    light->position[2] = (float)world.z;
    return FAULT_NONE;
}

/* The unit direction from `from` to `to`, in the world. */
static fault_code_t set_direction(pbrt_state_t *state, scene_light_t *light, vec3_t from, vec3_t to)
{
    vec3_t d = transform_vector(&state->now.ctm, vec3_sub(to, from));
    const double size = vec3_max_abs(d);
    if (!(size > 0) || !isfinite(size))
        return pbrt_fault(state, FAULT_RANGE, "a light without direction: \"from\" and \"to\" are the same point");
    d = vec3_unit(vec3_scale(d, 1 / size));
    light->direction[0] = (float)d.x;
    light->direction[1] = (float)d.y;
    light->direction[2] = (float)d.z;
    return FAULT_NONE;
}

static fault_code_t ends(pbrt_state_t *state, pbrt_params_t *params, vec3_t *from, vec3_t *to)
{
    PBRT_TRY(state, params, pbrt_params_point(params, "from", from, state->fault));
    PBRT_TRY(state, params, pbrt_params_point(params, "to", to, state->fault));
    return FAULT_NONE;
}

/* ---- point, spot, distant ---- */

static fault_code_t make_point(pbrt_state_t *state, pbrt_params_t *params)
{
    scene_light_t light = {.kind = SCENE_LIGHT_POINT, .image = SCENE_NONE};
    rgb_t intensity;
    vec3_t from = {0, 0, 0};
    double power;
    bool given;
    TRY(color_and_scale(state, params, "I", &intensity, &given));
    TRY(target(state, params, "power", &power));
    PBRT_TRY(state, params, pbrt_params_point(params, "from", &from, state->fault));
    reach_target(&intensity, power, 4 * MATH_PI);
    TRY(set_position(state, &light, from));
    return add_light(state, &light, intensity);
}

static fault_code_t make_spot(pbrt_state_t *state, pbrt_params_t *params)
{
    scene_light_t light = {.kind = SCENE_LIGHT_SPOT, .image = SCENE_NONE};
    rgb_t intensity;
    vec3_t from = {0, 0, 0}, to = {0, 0, 1};
    double power, cone = 30, delta = 5;
    bool given;
    TRY(color_and_scale(state, params, "I", &intensity, &given));
    TRY(target(state, params, "power", &power));
    TRY(ends(state, params, &from, &to));
    PBRT_TRY(state, params, pbrt_params_float(params, "coneangle", 0, 180, &cone, state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "conedeltaangle", 0, 180, &delta, state->fault));
    const double end = cos(cone * TO_RADIANS), start = cos(fmax(cone - delta, 0) * TO_RADIANS);
    /* The falloff is a smoothstep in the cosine, of which the integral is half its width. */
    reach_target(&intensity, power, 2 * MATH_PI * ((1 - start) + (start - end) / 2));
    light.cos_end = (float)end;
    light.cos_start = (float)fmax(start, end);
    TRY(set_position(state, &light, from));
    TRY(set_direction(state, &light, from, to));
    return add_light(state, &light, intensity);
}

static fault_code_t make_distant(pbrt_state_t *state, pbrt_params_t *params)
{
    scene_light_t light = {.kind = SCENE_LIGHT_DISTANT, .image = SCENE_NONE};
    rgb_t irradiance;
    vec3_t from = {0, 0, 0}, to = {0, 0, 1};
    double illuminance;
    bool given;
    TRY(color_and_scale(state, params, "L", &irradiance, &given));
    TRY(target(state, params, "illuminance", &illuminance));
    TRY(ends(state, params, &from, &to));
    reach_target(&irradiance, illuminance, 1);
    TRY(set_direction(state, &light, from, to));
    return add_light(state, &light, irradiance);
}

static fault_code_t make_image_point(pbrt_state_t *state, pbrt_params_t *params, const char *kind)
{
    pbrt_note(state, "LightSource \"%s\" is not supported: a point light of the same intensity is used", kind);
    pbrt_params_ignore(params, "filename");
    pbrt_params_ignore(params, "fov");
    return make_point(state, params);
}

/* ---- infinite ---- */

/* Rows of the rotation world -> light: the light's axes in the world, made orthonormal (Gram-Schmidt from z). */
static fault_code_t set_axes(pbrt_state_t *state, scene_light_t *light)
{
    const transform_t *m = &state->now.ctm;
    double scale;
    vec3_t x = transform_vector(m, vec3(1, 0, 0)), y = transform_vector(m, vec3(0, 1, 0));
    vec3_t z = transform_vector(m, vec3(0, 0, 1));
    const bool similar = transform_similarity(m, &scale);
    if (!(scale > 0) || !isfinite(scale))
        return pbrt_fault(state, FAULT_RANGE, "the light's transformation is singular");
    if (!similar)
        pbrt_note(state, "an infinite light under a transformation that stretches: only its rotation is used");
    z = vec3_unit(z);
    x = vec3_unit(vec3_mad(x, -vec3_dot(x, z), z));
    y = vec3_mad(vec3_mad(y, -vec3_dot(y, z), z), -vec3_dot(y, x), x);
    y = vec3_unit(y);
    const vec3_t rows[3] = {x, y, z};
    for (int i = 0; i < 3; i++) {
        light->to_light[3 * i] = (float)rows[i].x;
        light->to_light[3 * i + 1] = (float)rows[i].y;
        light->to_light[3 * i + 2] = (float)rows[i].z;
    }
    return FAULT_NONE;
}

/* Height z of the direction that texel (x, y) of an n x n equal-area octahedral map shows (Clarberg 2008: in the
 * inner diamond z = 1 - r^2, with r the distance to the middle in the 1-norm; outside it, the mirrored one below).
 */
static double map_height(uint32_t x, uint32_t y, uint32_t n)
{
    const double u = fabs(2 * (x + 0.5) / n - 1), v = fabs(2 * (y + 0.5) / n - 1);
    const double d = 1 - (u + v), r = 1 - fabs(d);
    return copysign(1 - r * r, d);
}

/* Illuminance of an upward facing surface under the map: integral of luminance * cosine over the upper half. */
static double map_illuminance(const float *texels, uint32_t n)
{
    double sum = 0;
    for (uint32_t y = 0; y < n; y++)
        for (uint32_t x = 0; x < n; x++) {
            const float *t = texels + 3 * ((size_t)y * n + x);
            sum += rgb_luminance(rgb((double)t[0], (double)t[1], (double)t[2])) * fmax(map_height(x, y, n), 0);
        }
    return sum * 4 * MATH_PI / ((double)n * n);
}

/* The image as three floats a texel; the caller frees it. */
static float *linear_texels(const picture_t *image, bool *below_zero)
{
    float *texels = malloc((size_t)image->width * image->height * 3 * sizeof *texels), rgba[4];
    for (uint32_t y = 0; texels && y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++) {
            picture_texel(image, x, y, rgba);
            for (int c = 0; c < 3; c++) {
                *below_zero |= rgba[c] < 0;
                texels[3 * ((size_t)y * image->width + x) + (size_t)c] = rgba[c] > 0 ? rgba[c] : 0;
            }
        }
    return texels;
}

static fault_code_t load_map(pbrt_state_t *state, const char *filename, int32_t *index, double *illuminance)
{
    char path[PBRT_PATH_MAX];
    picture_t image;
    bool below_zero = false;
    uint32_t added;
    TRY(pbrt_resolve(state, filename, path));
    TRY(picture_read(path, (picture_coding_t){PICTURE_CODING_SRGB, 1}, &image, state->fault));
    fault_code_t code;
    float *texels = NULL;
    if (image.width != image.height)
        code =
            pbrt_fault(state, FAULT_FORMAT,
                       "%s has %u x %u texels: expected a square (an equal-area octahedral map, as pbrt-v4 wants)",
                       path, image.width, image.height);
    else if (!(texels = linear_texels(&image, &below_zero)))
        code = pbrt_fault(state, FAULT_MEMORY, "no memory for an environment map");
    else
        code = scene_builder_add_image(state->builder,
                                       &(scene_image_t){0, image.width, image.height, 3, SCENE_TEXEL_FLOAT32},
                                       texels, &added, state->fault);
    if (code == FAULT_NONE) {
        if (below_zero)
            pbrt_note(state, "an image has texels below zero: they are set to zero");
        *index = (int32_t)added;
        *illuminance = map_illuminance(texels, image.width);
    }
    free(texels);
    picture_clear(&image);
    return code;
}

static fault_code_t make_infinite(pbrt_state_t *state, pbrt_params_t *params)
{
    scene_light_t light = {.kind = SCENE_LIGHT_INFINITE, .image = SCENE_NONE};
    rgb_t radiance;
    const char *filename = NULL;
    double wanted, of_map = MATH_PI;
    bool given;
    TRY(color_and_scale(state, params, "L", &radiance, &given));
    TRY(target(state, params, "illuminance", &wanted));
    PBRT_TRY(state, params, pbrt_params_string(params, "filename", &filename, state->fault));
    if (pbrt_params_find(params, "portal"))
        pbrt_note(state, "\"portal\" of infinite lights is not needed and is ignored");
    if (filename && given)
        return pbrt_fault(state, FAULT_FORMAT, "%s has both \"L\" and \"filename\"", params->what);
    TRY(set_axes(state, &light));
    if (filename)
        TRY(load_map(state, filename, &light.image, &of_map));
    /* With a map the light's own colour is grey: its luminance times the map's illuminance. */
    reach_target(&radiance, wanted, of_map);
    return add_light(state, &light, radiance);
}

fault_code_t pbrt_light(pbrt_state_t *state, const char *kind, pbrt_params_t *params)
{
    pbrt_params_ignore(params, "spectrum");
    if (strcmp(kind, "point") == 0)
        return make_point(state, params);
    if (strcmp(kind, "spot") == 0)
        return make_spot(state, params);
    if (strcmp(kind, "distant") == 0)
        return make_distant(state, params);
    if (strcmp(kind, "infinite") == 0)
        return make_infinite(state, params);
    if (strcmp(kind, "goniometric") == 0 || strcmp(kind, "projection") == 0)
        return make_image_point(state, params, kind);
    return pbrt_fault(state, FAULT_UNKNOWN,
                      "LightSource \"%s\": expected point, spot, distant, infinite, goniometric or projection",
                      kind);
}

/* ---- area lights ---- */

/* Average colour of an emission image. */
static fault_code_t average_image(pbrt_state_t *state, const char *filename, rgb_t *average)
{
    char path[PBRT_PATH_MAX];
    picture_t image;
    float rgba[4];
    TRY(pbrt_resolve(state, filename, path));
    TRY(picture_read(path, (picture_coding_t){PICTURE_CODING_SRGB, 1}, &image, state->fault));
    rgb_t sum = {0, 0, 0};
    for (uint32_t y = 0; y < image.height; y++)
        for (uint32_t x = 0; x < image.width; x++) {
            picture_texel(&image, x, y, rgba);
            sum = rgb_add(sum, rgb(fmax((double)rgba[0], 0), fmax((double)rgba[1], 0), fmax((double)rgba[2], 0)));
        }
    *average = rgb_scale(sum, 1.0 / ((double)image.width * image.height));
    picture_clear(&image);
    return FAULT_NONE;
}

fault_code_t pbrt_area_light(pbrt_state_t *state, const char *kind, pbrt_params_t *params)
{
    pbrt_area_t area = {.light = SCENE_NONE};
    const char *filename = NULL;
    bool given;
    if (strcmp(kind, "diffuse") != 0)
        return pbrt_fault(state, FAULT_UNKNOWN, "AreaLightSource \"%s\": expected \"diffuse\"", kind);
    TRY(color_and_scale(state, params, "L", &area.radiance, &given));
    TRY(target(state, params, "power", &area.power));
    PBRT_TRY(state, params, pbrt_params_bool(params, "twosided", &area.two_sided, state->fault));
    PBRT_TRY(state, params, pbrt_params_string(params, "filename", &filename, state->fault));
    pbrt_params_ignore(params, "spectrum");
    if (filename && given)
        return pbrt_fault(state, FAULT_FORMAT, "%s has both \"L\" and \"filename\"", params->what);
    if (filename) {
        rgb_t average;
        pbrt_note(state, "images on area lights are not supported: the image's average is emitted");
        TRY(average_image(state, filename, &average));
        area.radiance = rgb_mul(area.radiance, average);
    }
    pbrt_area_t *areas = pbrt_grown(state->areas, state->area_count, sizeof *areas);
    if (!areas)
        return pbrt_fault(state, FAULT_MEMORY, "no memory for an area light");
    state->areas = areas;
    areas[state->area_count] = area;
    state->now.area = (int32_t)state->area_count++;
    return FAULT_NONE;
}
