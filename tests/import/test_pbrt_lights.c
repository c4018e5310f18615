/* Lights, camera, film and filter: brightness, directions, the screen. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/import/picture.h"
#include "film/exr.h"
#include "film/pfm.h"
#include "import/read_text.h"
#include "math/vec.h"

/* Single precision, relative to the larger of the number and one. */
#define CLOSE 3e-7

static void expect(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance * fmax(1, fabs(expected))))
        fail_msg("found %.9g, expected %.9g", found, expected);
}

static void expect3(const float *found, double r, double g, double b)
{
    expect((double)found[0], r, CLOSE);
    expect((double)found[1], g, CLOSE);
    expect((double)found[2], b, CLOSE);
}

static double luminance(const scene_light_t *light)
{
    return rgb_luminance(rgb((double)light->radiance[0], (double)light->radiance[1], (double)light->radiance[2]));
}

/* ---- lights ---- */

static void area_lights_shine_as_they_say(void **state)
{
    (void)state;
    reading_t r = read_world(
        "AreaLightSource \"diffuse\" \"rgb L\" [17 12 4] \"float scale\" 2 \"bool twosided\" true\n"
        "Shape \"sphere\" Shape \"disk\" AreaLightSource \"diffuse\" \"blackbody L\" 3000 Shape \"sphere\"\n"
        "AreaLightSource \"diffuse\" \"spectrum L\" [400 3 700 9] \"float scale\" 5 Shape \"sphere\"\n"
        "AreaLightSource \"diffuse\" Shape \"sphere\"");
    assert_int_equal(r.scene.light_count, 4); /* one for the first two shapes */
    assert_int_equal(r.scene.shapes[1].area_light, 0);
    expect3(r.scene.lights[0].radiance, 34, 24, 8);
    assert_int_equal(r.scene.lights[0].two_sided, 1);
    expect(luminance(&r.scene.lights[1]), 1, CLOSE);
    assert_true(r.scene.lights[1].radiance[0] > r.scene.lights[1].radiance[2]);
    expect(luminance(&r.scene.lights[2]), 5, CLOSE);
    expect3(r.scene.lights[3].radiance, 1, 1, 1);
    assert_int_equal(r.scene.lights[3].two_sided, 0);
    reading_end(&r);
    read_world_fails("AreaLightSource \"projective\"", FAULT_UNKNOWN, WORDS("\"diffuse\""));
    read_world_fails("AreaLightSource \"diffuse\" \"rgb L\" [-1 0 0]", FAULT_RANGE, WORDS(":2:27"));
    read_world_fails("AreaLightSource \"diffuse\" \"blackbody L\" 1", FAULT_RANGE, WORDS("1 K"));
    r = read_world("AreaLightSource \"diffuse\" Material \"interface\" Shape \"sphere\"");
    assert_int_equal(r.scene.shapes[0].area_light, SCENE_NONE);
    assert_true(reading_notes(&r, "interface"));
    reading_end(&r);
}

static void power_is_spread_over_the_surface(void **state)
{
    (void)state;
    reading_t r =
        read_world("Scale 2 2 2 AreaLightSource \"diffuse\" \"rgb L\" [3 2 1] \"float power\" 100\n"
                   "Shape \"sphere\" \"float radius\" .5 Shape \"disk\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 "
                   "3 0 0 0 1 0]\n"
                   "AreaLightSource \"diffuse\" \"float power\" 10 \"bool twosided\" true Shape \"disk\"");
    const double areas[] = {4 * MATH_PI, 4 * MATH_PI, 6, 4 * MATH_PI}, powers[] = {100, 100, 100, 10};
    assert_int_equal(r.scene.light_count, 4);
    for (int i = 0; i < 4; i++) {
        const scene_light_t *light = &r.scene.lights[r.scene.shapes[i].area_light];
        expect(luminance(light) * MATH_PI * areas[i] * (light->two_sided ? 2 : 1), powers[i], 2 * CLOSE);
    }
    expect((double)(r.scene.lights[0].radiance[0] / r.scene.lights[0].radiance[2]), 3, CLOSE);
    reading_end(&r);
}

static void lights_at_points_know_where_they_are(void **state)
{
    (void)state;
    reading_t r =
        read_world("Translate 1 2 3 Rotate 90 0 0 1\n"
                   "LightSource \"point\" \"rgb I\" [1 2 3] \"point3 from\" [4 0 0] \"float scale\" 2\n"
                   "LightSource \"point\" \"rgb I\" [1 1 1] \"float power\" 50\n"
                   "LightSource \"spot\" \"point3 from\" [0 0 1] \"point3 to\" [7 0 1] \"float coneangle\" 60\n"
                   "\"float conedeltaangle\" 20 LightSource \"distant\" \"point3 from\" [1 0 0] \"point3 to\" [0 0 "
                   "0] \"rgb L\" [5 6 7]\n"
                   "LightSource \"distant\" \"float illuminance\" 11 \"rgb L\" [9 9 9]\n"
                   "LightSource \"goniometric\" \"rgb I\" [4 4 4] \"string filename\" \"x.png\"");
    const scene_light_t *l = r.scene.lights;
    assert_int_equal(l[0].kind, SCENE_LIGHT_POINT);
    expect3(l[0].position, 1, 6, 3);
    expect3(l[0].radiance, 2, 4, 6);
    expect(luminance(&l[1]) * 4 * MATH_PI, 50, CLOSE);
    assert_int_equal(l[2].kind, SCENE_LIGHT_SPOT);
    expect3(l[2].position, 1, 2, 4);
    expect3(l[2].direction, 0, 1, 0);
    expect((double)l[2].cos_end, 0.5, CLOSE);
    expect((double)l[2].cos_start, cos(40 * MATH_PI / 180), CLOSE);
    assert_int_equal(l[3].kind, SCENE_LIGHT_DISTANT);
    expect3(l[3].direction, 0, -1, 0);
    expect3(l[3].radiance, 5, 6, 7);
    expect3(l[4].direction, 0, 0, 1);
    expect(luminance(&l[4]), 11, CLOSE);
    assert_int_equal(l[5].kind, SCENE_LIGHT_POINT);
    assert_true(reading_notes(&r, "goniometric"));
    assert_int_equal(import_notes_count(r.notes), 1);
    reading_end(&r);
    read_world_fails("LightSource \"spot\" \"point3 to\" [0 0 0]", FAULT_RANGE, WORDS("direction"));
    read_world_fails("LightSource \"laser\"", FAULT_UNKNOWN, WORDS("laser"));
}

/* The spot's power by summing its falloff (smoothstep in the cosine) over directions. */
static void a_spot_gives_the_power_it_is_asked_for(void **state)
{
    (void)state;
    reading_t r =
        read_world("LightSource \"spot\" \"float power\" 30 \"float coneangle\" 50 \"float conedeltaangle\" 30");
    const scene_light_t *l = &r.scene.lights[0];
    enum { STEPS = 100000 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        const double c = -1 + 2 * (i + 0.5) / STEPS;
        const double t = fmin(fmax((c - (double)l->cos_end) / (double)(l->cos_start - l->cos_end), 0), 1);
        sum += t * t * (3 - 2 * t) * 2.0 / STEPS;
    }
    expect(2 * MATH_PI * luminance(l) * sum, 30, 1e-5); /* the midpoint rule's error is of the order 1e-9 */
    reading_end(&r);
}

static void infinite_lights_turn_with_their_transformation(void **state)
{
    (void)state;
    reading_t r = read_world("LightSource \"infinite\" \"rgb L\" [1 2 3] \"float scale\" 2\n"
                             "LightSource \"infinite\" \"float illuminance\" 7\n"
                             "AttributeBegin Rotate 90 0 0 1 Scale -2 2 2 LightSource \"infinite\" AttributeEnd\n"
                             "Scale 1 2 3 LightSource \"infinite\"");
    const scene_light_t *l = r.scene.lights;
    expect3(l[0].radiance, 2, 4, 6);
    assert_int_equal(l[0].image, SCENE_NONE);
    expect(luminance(&l[1]) * MATH_PI, 7, CLOSE);
    /* The light's x axis is the world's -y, its y axis the world's -x. */
    expect3(l[2].to_light, 0, -1, 0);
    expect3(l[2].to_light + 3, -1, 0, 0);
    expect3(l[2].to_light + 6, 0, 0, 1);
    assert_int_equal(import_notes_count(r.notes), 1);
    assert_true(reading_notes(&r, "stretches"));
    reading_end(&r);
    read_world_fails("Scale 0 1 1 LightSource \"infinite\"", FAULT_RANGE, WORDS("singular"));
}

/* Clarberg's map from the unit square to the sphere, written out from the paper (equal-area, upper half inside). */
static vec3_t map_direction(double s, double t)
{
    const double u = 2 * s - 1, v = 2 * t - 1, up = fabs(u), vp = fabs(v);
    const double d = 1 - (up + vp), r = 1 - fabs(d);
    const double phi = (r == 0 ? 1 : (vp - up) / r + 1) * MATH_PI / 4;
    const double z = copysign(1 - r * r, d), xy = r * sqrt(2 - r * r);
    return vec3(copysign(cos(phi), u) * xy, copysign(sin(phi), v) * xy, z);
}

/* A map whose radiance is 3 above and 1 below the horizon has the illuminance 3 pi on the ground. */
static void maps_are_scaled_to_their_illuminance(void **state)
{
    (void)state;
    enum { N = 64 };
    image_t image;
    fault_t fault = {0};
    uint8_t *data;
    size_t size;
    assert_int_equal(image_init_rgb(&image, N, N, &fault), FAULT_NONE);
    for (uint32_t c = 0; c < 3; c++)
        for (int i = 0; i < N * N; i++) {
            const double z = map_direction((i % N + 0.5) / N, (i / N + 0.5) / N).z;
            image_channel(&image, c)[i] = z > 1e-12 ? 3 : z < -1e-12 ? 1 : 2; /* some texels lie on the horizon */
        }
    assert_int_equal(exr_encode(&image, &data, &size, &fault), FAULT_NONE);
    read_text_write("sky.exr", data, size);
    free(data);
    image_clear(&image);
    reading_t r = read_world("LightSource \"infinite\" \"string filename\" \"sky.exr\" \"float scale\" .5\n"
                             "LightSource \"infinite\" \"string filename\" \"sky.exr\" \"float illuminance\" 6");
    assert_int_equal(r.scene.lights[0].image, 0);
    expect3(r.scene.lights[0].radiance, 0.5, 0.5, 0.5);
    assert_int_equal(r.scene.images[0].width, N);
    assert_int_equal(r.scene.images[0].texel, SCENE_TEXEL_FLOAT32);
    assert_int_equal(r.scene.images[0].channels, 3);
    /* Midpoint rule over N x N texels: the error is of the order 1/N^2 times the second derivative. */
    expect(luminance(&r.scene.lights[1]) * 3 * MATH_PI, 6, 2e-3);
    const float *texels = (const void *)(r.scene.texels + r.scene.images[0].offset);
    expect((double)texels[3 * (N / 2 * N + N / 2)], 3, 0); /* the middle is the zenith */
    expect((double)texels[0], 1, 0);                       /* the corner the nadir */
    reading_end(&r);
    assert_int_equal(image_init_rgb(&image, 4, 2, &fault), FAULT_NONE);
    assert_int_equal(pfm_encode(&image, &data, &size, &fault), FAULT_NONE);
    read_text_write("wide.pfm", data, size);
    free(data);
    image_clear(&image);
    read_world_fails("LightSource \"infinite\" \"string filename\" \"wide.pfm\"", FAULT_FORMAT,
                     WORDS("4 x 2", "square"));
    read_world_fails("LightSource \"infinite\" \"string filename\" \"sky.exr\" \"rgb L\" [1 1 1]", FAULT_FORMAT,
                     WORDS("both"));
    read_world_fails("LightSource \"infinite\" \"string filename\" \"no.exr\"", FAULT_NOT_FOUND, WORDS("no.exr"));
    r = read_world(
        "AreaLightSource \"diffuse\" \"string filename\" \"sky.exr\" \"float scale\" 10 Shape \"sphere\"");
    expect3(r.scene.lights[0].radiance, 20, 20, 20); /* half the texels are 3, half are 1 */
    assert_true(reading_notes(&r, "average"));
    reading_end(&r);
}

/* ---- pictures ---- */

static void pictures_are_decoded(void **state)
{
    (void)state;
    /* TGA, 2 x 1, 24 bits, from the top: (255,128,0) and (0,0,255), stored blue first. */
    static const uint8_t tga[] = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 24, 0x20, 0, 128, 255, 255, 0, 0};
    const picture_coding_t srgb = {PICTURE_CODING_SRGB, 0}, linear = {PICTURE_CODING_LINEAR, 0};
    const picture_coding_t gamma = {PICTURE_CODING_GAMMA, 2};
    picture_t p;
    fault_t fault = {0};
    float rgba[4];
    assert_int_equal(picture_parse(tga, sizeof tga, srgb, &p, &fault), FAULT_NONE);
    assert_int_equal(p.texel, SCENE_TEXEL_SRGB8);
    picture_texel(&p, 0, 0, rgba);
    expect((double)rgba[1], 0.2158605, 1e-6); /* IEC 61966-2-1 of 128/255 */
    expect((double)rgba[3], 1, 0);
    picture_clear(&p);
    assert_int_equal(picture_parse(tga, sizeof tga, linear, &p, &fault), FAULT_NONE);
    picture_texel(&p, 0, 0, rgba);
    expect((double)rgba[1], 128 / 255.0, CLOSE);
    picture_texel(&p, 1, 0, rgba);
    expect((double)rgba[2], 1, 0);
    picture_clear(&p);
    assert_int_equal(picture_parse(tga, sizeof tga, gamma, &p, &fault), FAULT_NONE);
    assert_int_equal(p.texel, SCENE_TEXEL_FLOAT32);
    picture_texel(&p, 0, 0, rgba);
    expect((double)rgba[1], 128 * 128 / 255.0 / 255, CLOSE);
    picture_clear(&p);
    for (size_t cut = 0; cut < sizeof tga; cut++) {
        assert_int_not_equal(picture_parse(tga, cut, srgb, &p, &fault), FAULT_NONE);
        assert_null(p.texels);
    }
    static const char pfm[] = "PF\n1 1\n-1\n\x00\x00\x80\x7f\x00\x00\x00\x00\x00\x00\x00\x00"; /* infinity */
    assert_int_not_equal(picture_parse((const uint8_t *)pfm, sizeof pfm - 1, srgb, &p, &fault), FAULT_NONE);
}

/* ---- camera ---- */

static reading_t read_view(const char *before_world)
{
    char text[1024];
    snprintf(text, sizeof text, "%s WorldBegin", before_world);
    reading_t r = read_text(text);
    if (r.code)
        fail_msg("%s", r.fault.text);
    return r;
}

static void expect_screen(const char *text, double x0, double x1, double y0, double y1)
{
    reading_t r = read_view(text);
    const double expected[4] = {x0, x1, y0, y1};
    for (int i = 0; i < 4; i++)
        expect(r.scene.camera->screen[i], expected[i], 1e-14);
    reading_end(&r);
}

static void the_field_of_view_spans_the_shorter_side(void **state)
{
    (void)state;
    const double t = tan(20 * MATH_PI / 180);
#define FILM                                                                                                       \
    "Film \"rgb\" \"integer xresolution\" %d \"integer yresolution\" %d Camera \"perspective\" \"float fov\" 40 "
    char text[512];
    snprintf(text, sizeof text, FILM, 200, 100);
    expect_screen(text, -2 * t, 2 * t, -t, t);
    snprintf(text, sizeof text, FILM, 100, 250);
    expect_screen(text, -t, t, -2.5 * t, 2.5 * t);
    snprintf(text, sizeof text, FILM "\"float frameaspectratio\" 3", 100, 250);
    expect_screen(text, -3 * t, 3 * t, -t, t);
    snprintf(text, sizeof text, FILM "\"float screenwindow\" [-1 2 -.5 .25]", 100, 250);
    expect_screen(text, -t, 2 * t, -0.5 * t, 0.25 * t);
#undef FILM
    expect_screen("", -1280.0 / 720, 1280.0 / 720, -1, 1); /* pbrt's defaults */
}

static void the_camera_stands_where_it_looks_from(void **state)
{
    (void)state;
    reading_t r = read_view(
        "LookAt 3 4 5  3 4 -7  0 1 0 Camera \"perspective\" \"float lensradius\" .25 \"float focaldistance\" 9");
    const double *m = r.scene.camera->to_world;
    static const double expected[12] = {-1, 0, 0, 3, 0, 1, 0, 4, 0, 0, -1, 5};
    for (int i = 0; i < 12; i++)
        expect(m[i], expected[i], 1e-14);
    expect(r.scene.camera->lens_radius, 0.25, 0);
    expect(r.scene.camera->focal_distance, 9, 0);
    reading_end(&r);
    r = read_view("");
    expect(r.scene.camera->focal_distance, 1e6, 0);
    expect(r.scene.camera->lens_radius, 0, 0);
    assert_true(reading_notes(&r, "no Camera"));
    reading_end(&r);
    r = read_text("Camera \"orthographic\"");
    assert_int_equal(r.code, FAULT_UNSUPPORTED);
    assert_non_null(strstr(r.fault.text, "test.pbrt:1:1: Camera \"orthographic\""));
    reading_end(&r);
    r = read_text("Scale 0 1 1 Camera \"perspective\"");
    assert_int_equal(r.code, FAULT_RANGE);
    reading_end(&r);
}

static void film_and_filter_are_kept(void **state)
{
    (void)state;
    reading_t r = read_view(
        "Film \"rgb\" \"integer xresolution\" 100 \"integer yresolution\" 50 \"float iso\" 200\n"
        "\"float exposuretime\" .25 \"float cropwindow\" [.105 .5 0 .99] \"bool savefp16\" true\n"
        "\"string filename\" \"x.exr\" \"float diagonal\" 35 PixelFilter \"triangle\" \"float xradius\" 1.25\n"
        "Integrator \"volpath\" \"integer maxdepth\" 7 \"bool regularize\" true Camera \"perspective\"");
    const scene_camera_t *c = r.scene.camera;
    static const uint32_t crop[4] = {11, 50, 0, 50};
    assert_memory_equal(c->crop, crop, sizeof crop);
    expect(c->imaging_scale, 0.5, 1e-15);
    assert_int_equal(c->filter, SCENE_FILTER_TRIANGLE);
    expect(c->filter_radius[0], 1.25, 0);
    expect(c->filter_radius[1], 2, 0);
    assert_int_equal(c->max_path_length, 8);
    assert_int_equal(import_notes_count(r.notes), 0);
    reading_end(&r);
    r = read_view(
        "Film \"rgb\" \"integer pixelbounds\" [10 20 -5 3000] Camera \"perspective\" Integrator \"path\"");
    static const uint32_t bounds[4] = {10, 20, 0, 720};
    assert_memory_equal(r.scene.camera->crop, bounds, sizeof bounds);
    assert_int_equal(r.scene.camera->filter, SCENE_FILTER_GAUSSIAN);
    expect(r.scene.camera->filter_radius[0], 1.5, 0);
    expect(r.scene.camera->filter_sigma, 0.5, 0);
    assert_int_equal(r.scene.camera->max_path_length, 0);
    reading_end(&r);
    r = read_view("PixelFilter \"mitchell\" \"float xradius\" 3 Film \"gbuffer\" Film \"rgb\" \"string sensor\" "
                  "\"canon_eos_5d\"\n"
                  "\"float whitebalance\" 5000 Camera \"perspective\" \"float shutteropen\" 0");
    assert_int_equal(import_notes_count(r.notes), 4);
    assert_int_equal(r.scene.camera->filter, SCENE_FILTER_GAUSSIAN);
    expect(r.scene.camera->filter_radius[0], 1.5, 0);
    reading_end(&r);
    static const char *const wrong[] = {"Film \"rgb\" \"integer xresolution\" 0",
                                        "Film \"rgb\" \"integer xresolution\" 99999",
                                        "Film \"rgb\" \"float cropwindow\" [.5 .5 0 1]",
                                        "Film \"rgb\" \"integer pixelbounds\" [5 4 0 1] WorldBegin",
                                        "PixelFilter \"box\" \"float xradius\" 0",
                                        "Camera \"perspective\" \"float fov\" 180"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        r = read_text(wrong[i]);
        if (r.code != FAULT_RANGE)
            fail_msg("%s: code %d, %s", wrong[i], (int)r.code, r.fault.text);
        reading_end(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(area_lights_shine_as_they_say),
        cmocka_unit_test(power_is_spread_over_the_surface),
        cmocka_unit_test(lights_at_points_know_where_they_are),
        cmocka_unit_test(a_spot_gives_the_power_it_is_asked_for),
        cmocka_unit_test(infinite_lights_turn_with_their_transformation),
        cmocka_unit_test(maps_are_scaled_to_their_illuminance),
        cmocka_unit_test(pictures_are_decoded),
        cmocka_unit_test(the_field_of_view_spans_the_shorter_side),
        cmocka_unit_test(the_camera_stands_where_it_looks_from),
        cmocka_unit_test(film_and_filter_are_kept),
    };
    return cmocka_run_group_tests(tests, NULL, read_text_clean);
}
