/* Hard cases of geometry: corners, wedges, needles and slivers, scales, scenes far from the origin, 50 segments at
 * the smallest scale. Closed furnaces know their answer: radiance L / (1 - rho), of which length k carries L
 * rho^(k-1). */
#include "hard.h"

#include <math.h>

static const double albedo = 0.5, emission = 1;
static const char *const inside = "LookAt 0.1 -0.2 0.3  0.7 0.4 -0.6  0 1 0";

/* ---- corners ---- */

/* Strips across the 12 edges of the cube, `size` wide: along axis k, at (sa, sb) of the other two. */
static void add_prisms(FILE *f, double size)
{
    fprintf(f, "AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ] \"bool twosided\" [ true ]\n");
    for (int k = 0; k < 3; k++)
        for (int corner = 0; corner < 4; corner++) {
            const double sa = corner & 1 ? 1 : -1, sb = corner & 2 ? 1 : -1;
            double p[4][3];
            for (int i = 0; i < 4; i++) {
                p[i][k] = i == 0 || i == 3 ? -1 : 1;
                p[i][(k + 1) % 3] = i < 2 ? sa : sa * (1 - size);
                p[i][(k + 2) % 3] = i < 2 ? sb * (1 - size) : sb;
            }
            hard_quad(f, vec3(p[0][0], p[0][1], p[0][2]), vec3(p[1][0], p[1][1], p[1][2]),
                      vec3(p[2][0], p[2][1], p[2][2]), vec3(p[3][0], p[3][1], p[3][2]));
        }
}

/* Rays start 2^-20 off their surface: of the two walls of a corner of angle a, points nearer than that to the edge
 * may start behind the other one if a is acute. The share of walks' segments that leave is the share of such points
 * at most, 2^-20 / tan(a) per edge length; right and wider angles lose nothing. */
static void check_corner(const char *name, double prism, double wedge, double leaks_most)
{
    FILE *f = hard_begin(inside, 60, 8);
    hard_furnace_walls(f, albedo, emission);
    hard_box(f, vec3(-1, -1, -1), vec3(1, 1, 1), true);
    if (prism > 0)
        add_prisms(f, prism);
    if (wedge > 0) { /* a plate that rises from the floor's edge at a small angle */
        fprintf(f, "AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ] \"bool twosided\" [ true ]\n");
        hard_quad(f, vec3(-1, -1, -1), vec3(-1, -1, 1), vec3(0.75, -1 + 1.75 * wedge, 1),
                  vec3(0.75, -1 + 1.75 * wedge, -1));
    }
    const scene_t *scene = hard_end(name);
    const double leaks = hard_leaks(scene, 20000, 20);
    print_message("%s: %.2g of the segments leave the closed scene\n", name, leaks);
    assert_true(leaks <= leaks_most);
    hard_expect_furnace(name, scene, (hard_job_t){.side = 8, .length = 10, .work = 60, .seed = 3}, albedo,
                        emission);
    hard_expect_round_trips(name, scene, &(hard_round_trip_t){1, 5, 1000, 1000, 1e-3, 0.1});
    hard_agree(name, scene, (hard_job_t){.side = 8, .length = 4, .work = 4});
    hard_clear();
}

static void corners_of_thin_prisms(void **state)
{
    (void)state;
    hard_case("corners");
    check_corner("prisms of 1e-2", 1e-2, 0, 1e-5);
    check_corner("prisms of 1e-4", 1e-4, 0, 1e-5);
}

static void corner_of_a_sharp_wedge(void **state)
{
    (void)state;
    hard_case("corners");
    check_corner("wedge of 0.05", 0, 0.05, 1e-4);
}

/* ---- needles ---- */

enum { NEEDLES = 48 };

static void wall_point(FILE *f, int k, double side, double a, double b)
{
    double p[3];
    p[k] = side;
    p[(k + 1) % 3] = a;
    p[(k + 2) % 3] = b;
    fprintf(f, " %.9g %.9g %.9g", p[0], p[1], p[2]);
}

/* A wall of needles 2 long and 2e-5 wide around a = 0.3; the rest two quads, each cut along a diagonal that is bent
 * by 1e-6: slivers. */
static void add_needle_wall(FILE *f, int k, double side)
{
    double cuts[NEEDLES + 3];
    cuts[0] = -1;
    for (int i = 0; i <= NEEDLES; i++)
        cuts[1 + i] = 0.3 + 2e-5 * i;
    cuts[NEEDLES + 2] = 1;
    fprintf(f, "Shape \"trianglemesh\" \"integer indices\" [");
    int base = 0;
    for (int i = 0; i + 1 < NEEDLES + 3; i++, base += 5) {
        static const int wide[12] = {0, 1, 4, 1, 2, 4, 0, 4, 2, 0, 2, 3}, narrow[6] = {0, 1, 2, 0, 2, 3};
        const bool is_wide = i == 0 || i == NEEDLES + 1;
        const int *t = is_wide ? wide : narrow;
        for (int j = 0; j < (is_wide ? 12 : 6); j += 3)
            fprintf(f, " %d %d %d", base + t[j], base + t[j + (side < 0 ? 1 : 2)],
                    base + t[j + (side < 0 ? 2 : 1)]);
    }
    fprintf(f, " ] \"point3 P\" [");
    for (int i = 0; i + 1 < NEEDLES + 3; i++) {
        const double a = cuts[i], b = cuts[i + 1];
        wall_point(f, k, side, a, -1);
        wall_point(f, k, side, b, -1);
        wall_point(f, k, side, b, 1);
        wall_point(f, k, side, a, 1);
        wall_point(f, k, side, (a + b) / 2 + 1e-6, 0);
    }
    fprintf(f, " ]\n");
}

static void needles_and_slivers(void **state)
{
    (void)state;
    hard_case("needles");
    FILE *f = hard_begin(inside, 60, 8);
    hard_furnace_walls(f, albedo, emission);
    for (int k = 0; k < 3; k++) {
        add_needle_wall(f, k, -1);
        add_needle_wall(f, k, 1);
    }
    const scene_t *scene = hard_end("needles");
    assert_int_equal(scene->triangle_count, 6 * (2 * NEEDLES + 8));
    const double leaks = hard_leaks(scene, 20000, 20);
    print_message("needles: %.2g of the segments leave the closed scene\n", leaks);
    assert_true(leaks <= 1e-5);
    hard_expect_furnace("needles of aspect 1e5", scene,
                        (hard_job_t){.side = 8, .length = 10, .work = 60, .seed = 4}, albedo, emission);
    hard_expect_invariance("needles of aspect 1e5", scene,
                           &(hard_invariance_t){.shortest = 1, .longest = 5, .paths = 2000, .least = 6000});
    hard_expect_round_trips("needles of aspect 1e5", scene, &(hard_round_trip_t){1, 5, 1000, 1000, 1e-3, 0.1});
    hard_agree("needles of aspect 1e5", scene, (hard_job_t){.side = 8, .length = 4, .work = 4});
    hard_clear();
}

/* ---- scales and places ---- */

/* A room with a bit of everything, whose coordinates are multiples of 1/64. */
static const scene_t *mixed_room(const char *name, double scale, vec3_t move)
{
    char camera[256];
    snprintf(camera, sizeof camera, "LookAt %.17g %.17g %.17g  %.17g %.17g %.17g  0 1 0", move.x, move.y + scale,
             move.z + 4.25 * scale, move.x, move.y + scale, move.z);
    FILE *f = hard_begin(camera, 38, 8);
    fprintf(f, "Translate %.17g %.17g %.17g\nScale %.17g %.17g %.17g\n", move.x, move.y, move.z, scale, scale,
            scale);
    fprintf(f, "Material \"diffuse\" \"rgb reflectance\" [ 0.7 0.6 0.5 ]\n");
    hard_quad(f, vec3(-1, 0, -1), vec3(-1, 0, 1), vec3(1, 0, 1), vec3(1, 0, -1));
    hard_quad(f, vec3(-1, 2, -1), vec3(1, 2, -1), vec3(1, 2, 1), vec3(-1, 2, 1));
    hard_quad(f, vec3(-1, 0, -1), vec3(1, 0, -1), vec3(1, 2, -1), vec3(-1, 2, -1));
    hard_quad(f, vec3(-1, 0, -1), vec3(-1, 2, -1), vec3(-1, 2, 1), vec3(-1, 0, 1));
    fprintf(f, "Material \"coateddiffuse\" \"rgb reflectance\" [ 0.3 0.5 0.3 ] \"float roughness\" [ 0.2 ]\n");
    hard_quad(f, vec3(1, 0, -1), vec3(1, 0, 1), vec3(1, 2, 1), vec3(1, 2, -1));
    fprintf(
        f, "AttributeBegin\nMaterial \"dielectric\" \"float eta\" [ 1.5 ]\nTranslate 0.40625 0.4375 0.25\n"
           "Shape \"sphere\" \"float radius\" [ 0.375 ]\nAttributeEnd\n"
           "AttributeBegin\nMaterial \"conductor\" \"float roughness\" [ 0.2 ]\nTranslate -0.40625 0.453125 -0.25\n"
           "Shape \"sphere\" \"float radius\" [ 0.4375 ]\nAttributeEnd\n"
           "AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\n"
           "AreaLightSource \"diffuse\" \"rgb L\" [ 12 11 9 ]\n");
    hard_quad(f, vec3(-0.375, 1.953125, -0.375), vec3(0.375, 1.953125, -0.375), vec3(0.375, 1.953125, 0.375),
              vec3(-0.375, 1.953125, 0.375));
    fprintf(f,
            "AttributeEnd\nLightSource \"point\" \"rgb I\" [ %.9g %.9g %.9g ] \"point3 from\" [ 0.5 1.5 0.75 ]\n",
            scale * scale, scale * scale, 0.5 * scale * scale);
    return hard_end(name);
}

enum { LENGTHS = 6, SIDE = 8 };

typedef struct picture {
    render_estimate_t b[LENGTHS + 1];
    double pixels[SIDE * SIDE], errors[SIDE * SIDE], mean;
} picture_t;

static void take(picture_t *out, const char *name, const scene_t *scene, const char *algorithm, double work)
{
    const hard_job_t job = {.algorithm = algorithm, .side = SIDE, .length = LENGTHS, .work = work, .seed = 5};
    render_t render;
    hard_render(&render, name, scene, &job);
    out->mean = 0;
    for (uint32_t k = 1; k <= LENGTHS; k++)
        out->b[k] = render_length(&render, k);
    for (int i = 0; i < SIDE * SIDE; i++) {
        out->pixels[i] = (double)image_channel(&render.image, 1)[i];
        out->errors[i] = (double)image_channel(&render.image, 4)[i];
        out->mean += out->pixels[i] / (SIDE * SIDE);
    }
    render_clear(&render);
}

/* The same seed, so that candidates of the pilot are the same but for rounding: b_k differ by what few candidates
 * see another primitive, far less than their standard error. Chains part once rounding changes a decision: pixels
 * are held to the errors of both. */
static void compare_pictures(const char *name, const picture_t *a, const picture_t *b, double tolerance)
{
    double worst = 0, pixel = 0, z = 0;
    for (uint32_t k = 1; k <= LENGTHS; k++) {
        const double off = fabs(a->b[k].value - b->b[k].value);
        worst = fmax(worst, off / a->b[k].value);
        if (!(off <= tolerance * a->b[k].value))
            fail_msg("%s: b_%u is %.9g, expected %.9g +- %.2g", name, k, b->b[k].value, a->b[k].value,
                     a->b[k].error);
    }
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double off = fabs(a->pixels[i] - b->pixels[i]), error = hypot(a->errors[i], b->errors[i]);
        pixel = fmax(pixel, off / a->pixels[i]);
        z = fmax(z, off / (error + 1e-7 * a->pixels[i]));
        if (!(off <= HARD_Z * 1.3 * error + 1e-6 * a->pixels[i])) /* 16 units or more estimate a pixel's error */
            fail_msg("%s: pixel %d is %g +- %g, expected %g", name, i, b->pixels[i], error, a->pixels[i]);
    }
    print_message("%s: largest difference of b_k %.2g, of pixels %.2g relative, %.2g in standard errors\n", name,
                  worst, pixel, z);
}

/* A factor of 2^20 changes no digit of any ratio: the same image to the last bit of the file. */
static void powers_of_two_change_nothing(void **state)
{
    (void)state;
    hard_case("powers of two");
    picture_t one, other;
    take(&one, "scale 1", mixed_room("scale 1", 1, vec3(0, 0, 0)), "mmlt", 2000);
    static const double scales[] = {0x1p-20, 0x1p20};
    for (int i = 0; i < 2; i++) {
        char name[32];
        snprintf(name, sizeof name, "scale %.3g", scales[i]);
        take(&other, name, mixed_room(name, scales[i], vec3(0, 0, 0)), "mmlt", 2000);
        compare_pictures(name, &one, &other, 1e-12);
        double worst = 0;
        for (int p = 0; p < SIDE * SIDE; p++)
            worst = fmax(worst, fabs(other.pixels[p] / one.pixels[p] - 1));
        assert_true(worst <= 1e-6);
    }
    hard_clear();
}

static void check_mixed_room(const char *name, const scene_t *scene)
{
    hard_expect_round_trips(name, scene, &(hard_round_trip_t){1, 5, 1000, 1000, 1e-3, 0.1});
    hard_agree(name, scene, (hard_job_t){.side = SIDE, .length = 4, .work = 4});
}

/* Vertices are rounded to single precision elsewhere: 1e-7 of the size. */
static void scales_from_millionth_to_million(void **state)
{
    (void)state;
    hard_case("scales");
    picture_t one[2], other;
    static const char *const algorithms[] = {"bdpt", "mmlt"};
    static const double scales[] = {1e-6, 1e6}, work[] = {400, 2000};
    for (int a = 0; a < 2; a++) {
        take(&one[a], "scale 1", mixed_room("scale 1", 1, vec3(0, 0, 0)), algorithms[a], work[a]);
        for (int i = 0; i < 2; i++) {
            char name[32];
            snprintf(name, sizeof name, "scale %g, %s", scales[i], algorithms[a]);
            take(&other, name, mixed_room(name, scales[i], vec3(0, 0, 0)), algorithms[a], work[a]);
            compare_pictures(name, &one[a], &other, 2e-3);
        }
    }
    check_mixed_room("scale 1e-6", mixed_room("scale 1e-6", 1e-6, vec3(0, 0, 0)));
    hard_clear();
}

/* Coordinates of 2e5 are multiples of 1/64 in single precision, and so are the room's. */
static void far_from_the_origin(void **state)
{
    (void)state;
    hard_case("far");
    picture_t one, other;
    static const char *const algorithms[] = {"bdpt", "mmlt"};
    static const double work[] = {400, 2000};
    for (int a = 0; a < 2; a++) {
        take(&one, "at the origin", mixed_room("at the origin", 1, vec3(0, 0, 0)), algorithms[a], work[a]);
        char name[64];
        snprintf(name, sizeof name, "moved by 1e5 sizes, %s", algorithms[a]);
        take(&other, name, mixed_room(name, 1, vec3(200001.5, -150000, 1.75e5)), algorithms[a], work[a]);
        compare_pictures(name, &one, &other, 2e-3);
    }
    const char *name = "moved by 1e5 sizes";
    check_mixed_room(name, mixed_room(name, 1, vec3(200001.5, -150000, 1.75e5)));
    hard_clear();
}

/* 50 densities per area at scale 1e-6 multiply to 1e600, at 1e6 to 1e-600. */
static void fifty_segments_at_extreme_scales(void **state)
{
    (void)state;
    hard_case("fifty");
    static const double scales[] = {1e-6, 1e6};
    for (int i = 0; i < 2; i++) {
        const double s = scales[i];
        char name[64], camera[128];
        snprintf(name, sizeof name, "50 segments at scale %g", s);
        snprintf(camera, sizeof camera, "LookAt 0 0 %.17g  0 0 0  0 1 0", 0.9 * s);
        FILE *f = hard_begin(camera, 60, 8);
        fprintf(f, "Scale %.17g %.17g %.17g\n", s, s, s);
        hard_furnace_walls(f, 0.9, 1);
        hard_box(f, vec3(-1, -1, -1), vec3(1, 1, 1), true);
        fprintf(f, "AttributeBegin\nMaterial \"dielectric\" \"float eta\" [ 1.5 ]\nTranslate 0.4 0.3 -0.2\n"
                   "Shape \"sphere\" \"float radius\" [ 0.3 ]\nAttributeEnd\n"
                   "AttributeBegin\nMaterial \"conductor\" \"float roughness\" [ 0.4 ]\nTranslate -0.4 -0.3 -0.2\n"
                   "Shape \"sphere\" \"float radius\" [ 0.4 ]\nAttributeEnd\n");
        const scene_t *scene = hard_end(name);
        hard_expect_invariance(name, scene,
                               &(hard_invariance_t){.shortest = 50, .longest = 50, .paths = 4000, .least = 500});
        hard_expect_round_trips(name, scene, &(hard_round_trip_t){50, 50, 100, 500, 1e-2, 1e-5});
        if (i == 0)
            hard_agree(name, scene, (hard_job_t){.side = 2, .length = 50, .work = 4, .pilot = 32});
    }
    hard_clear();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(corners_of_thin_prisms),
        cmocka_unit_test(corner_of_a_sharp_wedge),
        cmocka_unit_test(needles_and_slivers),
        cmocka_unit_test(powers_of_two_change_nothing),
        cmocka_unit_test(scales_from_millionth_to_million),
        cmocka_unit_test(far_from_the_origin),
        cmocka_unit_test(fifty_segments_at_extreme_scales),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
