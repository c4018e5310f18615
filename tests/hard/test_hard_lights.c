/* Hard cases of lights: tiny ones, bright ones beside dim ones, lights and textures of exactly zero. */
#include "hard.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "chain/target.h"

/* ---- tiny ---- */

/* A light of 1e-8 above a floor, seen at a small patch of the floor: radiance rho / pi L A cos cos' / d^2, to the
 * squares of light's and patch's size over the distance. The light is bright enough to give 1. `slack`: both in
 * single precision. */
static void check_tiny(const char *name, const char *light, double area, double radiance, bool sphere)
{
    FILE *f = hard_begin("LookAt 0.3 1 0.2  0.5 0 0.1  0 1 0", 1e-4, 4);
    fprintf(f, "Material \"diffuse\" \"rgb reflectance\" [ 0.5 0.5 0.5 ]\n");
    hard_quad(f, vec3(-1, 0, -1), vec3(-1, 0, 1), vec3(1, 0, 1), vec3(1, 0, -1));
    fprintf(f,
            "Material \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\nAreaLightSource \"diffuse\" \"rgb L\" [ %.9g %.9g "
            "%.9g ]\n%s",
            radiance, radiance, radiance, light);
    const vec3_t d = vec3_sub(vec3(0.125, 0.75, -0.25), vec3(0.5, 0, 0.1));
    const double d2 = vec3_dot(d, d), cosine = d.y / sqrt(d2);
    /* of a sphere's surface a quarter is seen, in projection; a triangle or disk faces down */
    const double expected = 0.5 / MATH_PI * radiance * (sphere ? area / 4 : area * cosine) * cosine / d2;
    const scene_t *scene = hard_end(name);
    hard_expect_mean(name, scene, (hard_job_t){.side = 4, .length = 2, .work = 400, .seed = 31}, expected, 1e-5);
    /* a place on the light is known to 1e-16 of 0.75: 1e-8 of the radius, over its cosine */
    hard_expect_round_trips(name, scene, &(hard_round_trip_t){2, 2, 3000, 500, 1e-3, 1e-5});
    hard_clear();
}

static void lights_of_a_hundred_millionth(void **state)
{
    (void)state;
    hard_case("tiny lights");
    const double r = 1e-8;
    check_tiny("sphere of radius 1e-8", "Translate 0.125 0.75 -0.25\nShape \"sphere\" \"float radius\" [ 1e-8 ]\n",
               4 * MATH_PI * r * r, 1e16, true);
    check_tiny("disk of radius 1e-8",
               "Translate 0.125 0.75 -0.25\nRotate 90 1 0 0\nShape \"disk\" \"float radius\" [ 1e-8 ]\n",
               MATH_PI * r * r, 1e16, false);
}

/* A triangle that small needs coordinates near zero: the floor lies below the origin. */
static void triangle_of_a_hundred_millionth(void **state)
{
    (void)state;
    hard_case("tiny lights");
    FILE *f = hard_begin("LookAt 0.3 0 0.2  0.5 -1 0.1  0 1 0", 1e-4, 4);
    fprintf(f, "Material \"diffuse\" \"rgb reflectance\" [ 0.5 0.5 0.5 ]\n");
    hard_quad(f, vec3(-1, -1, -1), vec3(-1, -1, 1), vec3(1, -1, 1), vec3(1, -1, -1));
    fprintf(f, "Material \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\nAreaLightSource \"diffuse\" \"rgb L\" [ 1e16 "
               "1e16 1e16 ]\n"
               "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2 ] \"point3 P\" [ 0 0 0  1e-8 0 0  0 0 1e-8 ]\n");
    const double d2 = 0.5 * 0.5 + 1 + 0.1 * 0.1;
    const double expected = 0.5 / MATH_PI * 1e16 * 0.5e-16 / (d2 * d2);
    hard_expect_mean("triangle of side 1e-8", hard_end("triangle of side 1e-8"),
                     (hard_job_t){.side = 4, .length = 2, .work = 400, .seed = 32}, expected, 1e-5);
    hard_clear();
}

/* ---- bright ---- */

/* A furnace of radiance 1 with a sealed case inside, in which a light is brighter by `factor`: next to no light
 * selection goes to what is seen. All of it comes from walks that end on the walls. */
static void check_sealed(const char *name, double factor)
{
    FILE *f = hard_begin("LookAt 0.1 -0.2 0.3  0.7 0.4 -0.6  0 1 0", 60, 8);
    hard_furnace_walls(f, 0.5, 1);
    hard_box(f, vec3(-1, -1, -1), vec3(1, 1, 1), true);
    hard_box(f, vec3(-0.8, -0.8, -0.8), vec3(-0.4, -0.4, -0.4), false);
    fprintf(f, "AreaLightSource \"diffuse\" \"rgb L\" [ %.9g %.9g %.9g ]\n", factor, factor, factor);
    hard_box(f, vec3(-0.79, -0.79, -0.79), vec3(-0.41, -0.41, -0.41), true);
    hard_expect_furnace(name, hard_end(name), (hard_job_t){.side = 8, .length = 8, .work = 100, .seed = 33}, 0.5,
                        1);
    hard_clear();
}

static void sealed_lights_brighter_by_1e9_and_more(void **state)
{
    (void)state;
    hard_case("sealed light");
    check_sealed("sealed light, brighter by 1e9", 1e9);
    check_sealed("sealed light, brighter by 1e18", 1e18);
}

/* In the open: a light brighter by 1e9, of 1e-9 of the other's area, each lights its half of a room. */
static void open_light_brighter_by_1e9(void **state)
{
    (void)state;
    hard_case("bright light");
    FILE *f = hard_begin("LookAt 0 1 3.9  0 0.8 0  0 1 0", 38, 8);
    fprintf(f, "Material \"diffuse\" \"rgb reflectance\" [ 0.6 0.6 0.5 ]\n");
    hard_box(f, vec3(-1, 0, -1), vec3(1, 2, 4), true);
    hard_quad(f, vec3(0, 0, -1), vec3(0, 0, 1), vec3(0, 1.6, 1), vec3(0, 1.6, -1));
    fprintf(f, "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 2 2 2 ]\n");
    hard_quad(f, vec3(-0.8, 1.9, -0.4), vec3(-0.2, 1.9, -0.4), vec3(-0.2, 1.9, 0.4), vec3(-0.8, 1.9, 0.4));
    fprintf(f, "AttributeEnd\nAreaLightSource \"diffuse\" \"rgb L\" [ 2e9 2e9 1e9 ]\nTranslate 0.5 0.6 0\n"
               "Shape \"sphere\" \"float radius\" [ 7e-6 ]\n");
    const scene_t *scene = hard_end("light brighter by 1e9");
    hard_agree("light brighter by 1e9", scene, (hard_job_t){.side = 8, .length = 4, .work = 16});
    hard_expect_invariance("light brighter by 1e9", scene, &(hard_invariance_t){1, 5, 3000, 3000, NULL});
    hard_expect_round_trips("light brighter by 1e9", scene, &(hard_round_trip_t){1, 5, 1000, 1000, 1e-3, 0.1});
    hard_clear();
}

/* ---- huge ---- */

/* A floor of size 2 within a box of half side 1e5 that emits: selection by area goes to what is 1e5 away,
 * and positions on the light say next to nothing about directions. A Lambertian floor of albedo 0.5 under radiance
 * 1 from everywhere has radiance 0.5, all of it of length 2. */
static void light_of_a_hundred_thousand(void **state)
{
    (void)state;
    hard_case("huge light");
    FILE *f = hard_begin("LookAt 0 1 0.2  0 0 0  0 1 0", 40, 8);
    fprintf(f, "Material \"diffuse\" \"rgb reflectance\" [ 0.5 0.5 0.5 ]\n");
    hard_quad(f, vec3(-1, 0, -1), vec3(-1, 0, 1), vec3(1, 0, 1), vec3(1, 0, -1));
    fprintf(
        f, "Material \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\nAreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\n");
    hard_box(f, vec3(-1e5, -1e5, -1e5), vec3(1e5, 1e5, 1e5), true);
    const char *name = "light of 1e5 sizes";
    const scene_t *scene = hard_end(name);
    hard_expect_mean(name, scene, (hard_job_t){.side = 8, .length = 3, .work = 100, .seed = 35}, 0.5, 1e-6);
    hard_expect_invariance(name, scene, &(hard_invariance_t){1, 3, 3000, 1000, NULL});
    hard_expect_round_trips(name, scene, &(hard_round_trip_t){1, 3, 2000, 1000, 1e-3, 0.1});
    hard_agree(name, scene, (hard_job_t){.side = 8, .length = 3, .work = 10});
    hard_clear();
}

/* ---- zero ---- */

/* An environment whose lower half and one octant of the upper are zero. */
static void write_environment(char path[64])
{
    enum { SIDE = 16 };
    snprintf(path, 64, "/tmp/garland-hard-%ld.pfm", (long)getpid());
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    fprintf(f, "PF\n%d %d\n-1.0\n", SIDE, SIDE);
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            const bool lit =
                abs(2 * x + 1 - SIDE) + abs(2 * y + 1 - SIDE) < SIDE && !(x < SIDE / 2 && y < SIDE / 2);
            const float c[3] = {lit ? 1.5f : 0, lit ? 1 : 0, lit && x % 3 ? 1 : 0};
            fwrite(c, sizeof c, 1, f);
        }
    fclose(f);
}

/* Lights of no radiance beside one that has some, black materials, textures with black fields (rough ones too), a
 * half-black environment. */
static void lights_and_textures_of_zero(void **state)
{
    (void)state;
    hard_case("zeros");
    char path[64];
    write_environment(path);
    FILE *f = hard_begin("LookAt 0 1 3.9  0 0.6 0  0 1 0", 38, 8);
    fprintf(f,
            "LightSource \"infinite\" \"string filename\" [ \"%s\" ]\nLightSource \"point\" \"rgb I\" [ 0 0 0 ]\n"
            "LightSource \"distant\" \"rgb L\" [ 0 0 0 ]\n"
            "Texture \"fields\" \"spectrum\" \"checkerboard\" \"float uscale\" [ 7 ] \"float vscale\" [ 5 ] \"rgb "
            "tex1\" [ 0 0 0 ] "
            "\"rgb tex2\" [ 0.8 0.7 0 ]\n"
            "Texture \"rough\" \"float\" \"checkerboard\" \"float uscale\" [ 4 ] \"float vscale\" [ 4 ] \"float "
            "tex1\" [ 0 ] \"float "
            "tex2\" [ 0.4 ]\n"
            "Material \"diffuse\" \"texture reflectance\" \"fields\"\n",
            path);
    hard_quad(f, vec3(-1, 0, -1), vec3(-1, 0, 1), vec3(1, 0, 1), vec3(1, 0, -1));
    hard_quad(f, vec3(-1, 0, -1), vec3(1, 0, -1), vec3(1, 2, -1), vec3(-1, 2, -1));
    fprintf(f, "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 0 0 0 ]\n");
    hard_quad(f, vec3(-1, 0, -1), vec3(-1, 2, -1), vec3(-1, 2, 1), vec3(-1, 0, 1));
    fprintf(f, "AttributeEnd\nAttributeBegin\nMaterial \"conductor\" \"texture roughness\" \"rough\"\nTranslate "
               "-0.4 0.4 0\n"
               "Shape \"sphere\" \"float radius\" [ 0.4 ]\nAttributeEnd\nAttributeBegin\n"
               "Material \"coateddiffuse\" \"texture reflectance\" \"fields\" \"float roughness\" [ 0 ]\n"
               "Translate 0.5 0.4 0.2\nShape \"sphere\" \"float radius\" [ 0.35 ]\nAttributeEnd\n"
               "AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\n"
               "AreaLightSource \"diffuse\" \"rgb L\" [ 3 3 0 ]\n");
    hard_quad(f, vec3(-0.3, 1.9, -0.3), vec3(0.3, 1.9, -0.3), vec3(0.3, 1.9, 0.3), vec3(-0.3, 1.9, 0.3));
    fprintf(f, "AttributeEnd\n");
    const scene_t *scene = hard_end("zeros");
    hard_agree("zeros", scene, (hard_job_t){.side = 8, .length = 4, .work = 10});
    hard_expect_invariance("zeros", scene, &(hard_invariance_t){1, 5, 4000, 500, NULL});
    hard_expect_round_trips("zeros", scene, &(hard_round_trip_t){1, 5, 3000, 1000, 1e-3, 0.1});
    hard_clear();
    unlink(path);
}

/* A scene that carries no light at all says so. */
static void no_light_is_refused(void **state)
{
    (void)state;
    FILE *f = hard_begin("LookAt 0 0 0  0 0 -1  0 1 0", 60, 4);
    hard_furnace_walls(f, 0.5, 0);
    hard_box(f, vec3(-1, -1, -1), vec3(1, 1, 1), true);
    const scene_t *scene = hard_end("dark");
    path_scene_t ps;
    fault_t fault = {0};
    assert_int_equal(path_scene_init(&ps, scene, scene->camera, 0, 0, &fault), FAULT_NO_LIGHT);
    hard_clear();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lights_of_a_hundred_millionth),
        cmocka_unit_test(triangle_of_a_hundred_millionth),
        cmocka_unit_test(sealed_lights_brighter_by_1e9_and_more),
        cmocka_unit_test(open_light_brighter_by_1e9),
        cmocka_unit_test(light_of_a_hundred_thousand),
        cmocka_unit_test(lights_and_textures_of_zero),
        cmocka_unit_test(no_light_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
