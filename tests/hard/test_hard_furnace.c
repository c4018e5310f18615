/* Furnaces with things in them. Where every wall has radiance L and albedo rho, and whatever else is there scatters
 * without loss, the radiance is L / (1 - rho) everywhere, times n^2 inside a medium of index n: for reciprocal
 * scattering without loss the light that uniform radiance sends into a direction is what that direction would
 * scatter to all sides, all of it. That holds for smooth glass (reflected and refracted shares add up to one, and
 * radiance in glass is n^2 times that outside), perfect mirrors, white Lambertian surfaces, white ones under a
 * smooth coat (materials.md: exact), thin panes, transmitting screens of reflectance + transmittance 1, and
 * mixtures of them; within 5e-4 for white ones under a rough coat. It fails where a wrong factor enters a walk from
 * either side: refraction's 1/eta^2, an adjoint, a probability. Rough glass and metal lose what a single scattering
 * loses: they are bounded from above. Lengths are cut at 22: what is left is below 1e-5. */
#include "hard.h"

#include <math.h>

static const double albedo = 0.3, emission = 1, radiance = 1 / 0.7;
static const hard_job_t usual = {.side = 4, .length = 22, .work = 30, .seed = 11};
static const char *const outside = "LookAt 0.1 0.2 0.95  0 0 0  0 1 0";

static const scene_t *furnace_with(const char *name, const char *camera, const char *things)
{
    FILE *f = hard_begin(camera, 70, 4);
    fprintf(f, "AttributeBegin\n");
    hard_furnace_walls(f, albedo, emission);
    hard_box(f, vec3(-1, -1, -1), vec3(1, 1, 1), true);
    fprintf(f, "AttributeEnd\n%s", things);
    return hard_end(name);
}

static void expect_white(const char *name, const char *things, double slack)
{
    hard_expect_mean(name, furnace_with(name, outside, things), usual, radiance, slack);
    hard_clear();
}

#define SPHERE(radius) "Shape \"sphere\" \"float radius\" [ " radius " ]\n"
#define PANE                                                                                                       \
    "Shape \"trianglemesh\" \"point3 P\" [ -0.7 -0.6 0.1  0.6 -0.7 -0.1  0.7 0.6 0.1  -0.6 0.7 0.2 ] \"integer "   \
    "indices\" "                                                                                                   \
    "[ 0 1 2 0 2 3 ]\n"
/* 1 - R = 4 n / ((n + 1)^2 + k^2) = 4e-9 at normal incidence */
#define MIRROR                                                                                                     \
    "Material \"conductor\" \"rgb eta\" [ 0.001 0.001 0.001 ] \"rgb k\" [ 999 999 999 ] \"float roughness\" [ 0 "  \
    "]\n"
#define GLASS "Material \"dielectric\" \"float eta\" [ 1.5 ]\n"

/* The slack is single precision's, 1e-7 for each of some 10 parameters, and what is cut at 22. */
static const double exact = 2e-5;

static void glass(void **state)
{
    (void)state;
    hard_case("furnaces");
    expect_white("glass sphere", GLASS SPHERE("0.7"), exact);
    expect_white("sphere of index 1.0001", "Material \"dielectric\" \"float eta\" [ 1.0001 ]\n" SPHERE("0.7"),
                 exact);
    expect_white("sphere of index 1", "Material \"dielectric\" \"float eta\" [ 1 ]\n" SPHERE("0.7"), exact);
    expect_white("sphere of index 0.6", "Material \"dielectric\" \"float eta\" [ 0.6 ]\n" SPHERE("0.7"), exact);
    expect_white("thin glass pane", "Material \"thindielectric\" \"float eta\" [ 1.5 ]\n" PANE, exact);
}

static void mirrors_and_nested_things(void **state)
{
    (void)state;
    hard_case("furnaces");
    expect_white("mirror sphere", MIRROR SPHERE("0.7"), exact);
    expect_white("mirror in glass", GLASS SPHERE("0.7") MIRROR SPHERE("0.3"), exact);
    expect_white(
        "air bubble in glass, touching",
        GLASS SPHERE("0.7") "AttributeBegin\nTranslate 0.1 0 0.2\n"
                            "Material \"dielectric\" \"float eta\" [ 0.66666666 ]\n" SPHERE("0.3") "AttributeEnd\n",
        exact);
}

static void white_surfaces(void **state)
{
    (void)state;
    hard_case("furnaces");
    expect_white("white sphere", "Material \"diffuse\" \"rgb reflectance\" [ 1 1 1 ]\n" SPHERE("0.7"), exact);
    expect_white(
        "white sphere, smooth coat",
        "Material \"coateddiffuse\" \"rgb reflectance\" [ 1 1 1 ] \"float roughness\" [ 0 ]\n" SPHERE("0.7"),
        exact);
    expect_white(
        "white sphere, rough coat",
        "Material \"coateddiffuse\" \"rgb reflectance\" [ 1 1 1 ] \"float roughness\" [ 0.3 ]\n" SPHERE("0.7"),
        5e-4 + exact);
    expect_white("screen of transmittance 0.6",
                 "Material \"diffusetransmission\" \"rgb reflectance\" [ 0.4 0.4 0.4 ] \"rgb transmittance\" [ 0.6 "
                 "0.6 0.6 ]\n" PANE,
                 exact);
    expect_white("mixture of white and mirror",
                 "MakeNamedMaterial \"a\" \"string type\" [ \"diffuse\" ] \"rgb reflectance\" [ 1 1 1 ]\n"
                 "MakeNamedMaterial \"b\" \"string type\" [ \"conductor\" ] \"rgb eta\" [ 0.001 0.001 0.001 ] "
                 "\"rgb k\" [ 999 "
                 "999 999 ] \"float roughness\" [ 0 ]\n"
                 "Material \"mix\" \"string materials\" [ \"a\" \"b\" ] \"float amount\" [ 0.4 ]\n" SPHERE("0.7"),
                 exact);
}

/* Everywhere within radius / n no direction is totally reflected for ever. */
static void camera_inside_glass(void **state)
{
    (void)state;
    hard_case("inside");
    hard_expect_mean("inside glass",
                     furnace_with("inside glass", "LookAt 0.2 0.1 0.3  0 0.3 0  0 1 0", GLASS SPHERE("0.7")), usual,
                     2.25 * radiance, exact);
    hard_expect_mean("inside a bubble of index 0.6",
                     furnace_with("inside a bubble", "LookAt 0.2 0.1 0.3  0 0.3 0  0 1 0",
                                  "Material \"dielectric\" \"float eta\" [ 0.6 ]\n" SPHERE("0.7")),
                     usual, 0.36 * radiance, exact);
    hard_clear();
}

/* The same with walls of albedo 0.5 and 50 segments: a path meets a wall at every third vertex or oftener, so that
 * 0.5^16 of the light is cut. */
static void fifty_segments_among_glass_mirror_and_white_block(void **state)
{
    (void)state;
    hard_case("fifty");
    FILE *f = hard_begin(outside, 70, 4);
    fprintf(f, "AttributeBegin\n");
    hard_furnace_walls(f, 0.5, 1);
    hard_box(f, vec3(-1, -1, -1), vec3(1, 1, 1), true);
    fprintf(f, "AttributeEnd\nAttributeBegin\nTranslate -0.45 0.1 -0.2\n" GLASS SPHERE(
                   "0.4") "AttributeEnd\n"
                          "AttributeBegin\nTranslate 0.45 0.3 -0.3\n" MIRROR SPHERE(
                              "0.4") "AttributeEnd\n"
                                     "Material \"coateddiffuse\" \"rgb reflectance\" [ 1 1 1 ] \"float roughness\" "
                                     "[ 0 ]\n");
    hard_box(f, vec3(-0.6, -0.9, -0.5), vec3(0.5, -0.5, 0.3), false);
    hard_expect_mean("50 segments among glass, mirror and white block", hard_end("50 segments"),
                     (hard_job_t){.side = 4, .length = 50, .work = 20, .seed = 12}, 2, exact);
    hard_clear();
}

static void expect_no_gain(const char *name, const char *things, double least)
{
    hard_expect_between(name, furnace_with(name, outside, things), usual, least * radiance, radiance);
    hard_clear();
}

/* The lower bounds are rough: they see a lobe that is lost, not how much a single scattering loses. */
static void rough_things_lose_light(void **state)
{
    (void)state;
    hard_case("rough furnaces");
    expect_no_gain(
        "rough glass, alpha 0.5",
        "Material \"dielectric\" \"float eta\" [ 1.5 ] \"float roughness\" [ 0.5 ] \"bool remaproughness\" [ false "
        "]\n" SPHERE("0.7"),
        0.4);
    expect_no_gain("rough glass, alpha 1e-3",
                   "Material \"dielectric\" \"float eta\" [ 1.5 ] \"float roughness\" [ 1e-3 ] \"bool "
                   "remaproughness\" [ false "
                   "]\n" SPHERE("0.7"),
                   0.99);
    expect_no_gain(
        "rough glass of index 1.0001, alpha 0.1",
        "Material \"dielectric\" \"float eta\" [ 1.0001 ] \"float roughness\" [ 0.1 ] \"bool remaproughness\" [ "
        "false ]\n" SPHERE("0.7"),
        0.95);
    expect_no_gain("rough mirror, alpha 1",
                   "Material \"conductor\" \"rgb eta\" [ 0.001 0.001 0.001 ] \"rgb k\" [ 999 999 999 ] \"float "
                   "roughness\" [ 1 "
                   "] \"bool remaproughness\" [ false ]\n" SPHERE("0.7"),
                   0.3);
    expect_no_gain(
        "rough mirror, alpha 1e-4",
        "Material \"conductor\" \"rgb eta\" [ 0.001 0.001 0.001 ] \"rgb k\" [ 999 999 999 ] \"float roughness\" [ "
        "1e-4 ] \"bool remaproughness\" [ false ]\n" SPHERE("0.7"),
        0.999);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(glass),
        cmocka_unit_test(mirrors_and_nested_things),
        cmocka_unit_test(white_surfaces),
        cmocka_unit_test(camera_inside_glass),
        cmocka_unit_test(fifty_segments_among_glass_mirror_and_white_block),
        cmocka_unit_test(rough_things_lose_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
