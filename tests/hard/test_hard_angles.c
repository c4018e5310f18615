/* Hard cases of directions: grazing, narrow and wide lobes, matched indices, the edge of total reflection. */
#include "hard.h"

#include <math.h>

#include "base/random.h"

typedef long double real_t;

/* ---- grazing ---- */

/* The camera is 1e-6, and 1e-9, above a floor and looks at it 5 of these far down for 1 forwards: cosines of 4 to 6
 * times 1e-6, 1e-9. (From 1e-9 above, a wall's points as near to the floor would lose shadow rays: single precision
 * ends them in the floor. That concerns points within 1e-7 of the coordinates of a corner.) */
static void camera_that_grazes_a_floor(void **state)
{
    (void)state;
    hard_case("grazing");
    static const double heights[] = {1e-6, 1e-9};
    for (int i = 0; i < 2; i++) {
        const double h = heights[i];
        char camera[128], name[64];
        snprintf(name, sizeof name, "floor grazed from a height of %g", h);
        snprintf(camera, sizeof camera, "LookAt 0 %.17g 0  1 %.17g 0  0 1 0", h, -4 * h);
        FILE *f = hard_begin(camera, 2 * h * 180 / MATH_PI, 8);
        hard_furnace_walls(f, 0.5, 1);
        hard_box(f, vec3(-1, 0, -1), vec3(1, 2, 1), true);
        const scene_t *scene = hard_end(name);
        hard_expect_furnace(name, scene, (hard_job_t){.side = 8, .length = 8, .work = 100, .seed = 21}, 0.5, 1);
        hard_expect_round_trips(name, scene, &(hard_round_trip_t){1, 5, 1000, 1000, 1e-3, 0.1});
        if (i == 1)
            hard_agree(name, scene, (hard_job_t){.side = 8, .length = 4, .work = 8});
    }
    hard_clear();
}

/* Numbers near 0 and near 1, down to 1e-16 of them: cosines down to 1e-8, half vectors at the horizon, lobes'
 * tails, edges of lights. */
static void near_the_ends(double *u, uint32_t count, uint64_t key)
{
    for (uint32_t i = 0; i < count; i++) {
        const double choice = random_double(key, 2 * i), small = pow(10, -16 * random_double(key, 2 * i + 1));
        if (choice < 0.15)
            u[i] = fmin(1 - small, MATH_ONE_MINUS);
        else if (choice < 0.25)
            u[i] = fmin(small, MATH_ONE_MINUS);
    }
}

static void numbers_near_their_ends(void **state)
{
    (void)state;
    hard_case("near ends");
    static const char *const names[] = {"furnace",      "diffuse", "glossy",  "glass",        "environment",
                                        "delta-lights", "lens",    "normals", "transmission", "tiny-light"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        hard_expect_invariance(names[i], hard_load(names[i]), &(hard_invariance_t){1, 6, 3000, 300, near_the_ends});
    hard_clear();
}

/* ---- a rough mirror under a light ---- */

/* Seen straight on (wo = n), a perfect rough mirror reflects from microfacets of slope t into angle 2 atan t: of a
 * light L that covers the slopes below T L int_0^T 2 t a^2 / (a^2 + t^2)^2  G(2 atan t) dt,   G(w) = 2 / (1 +
 * sqrt(1 + a^2 tan^2 w)) (density of visible normals, which are all normals here, times Smith's factor of the other
 * side). Substituting t = a tan p: int 2 sin p cos p G dp, by Simpson's rule. */
static real_t reflected(real_t alpha, real_t most)
{
    enum { STEPS = 20000 };
    const real_t end = atanl(most / alpha);
    real_t sum = 0;
    for (int i = 0; i <= STEPS; i++) {
        const real_t p = end * i / STEPS, t = alpha * tanl(p), slope = 2 * t / (1 - t * t); /* tan(2 atan t) */
        const real_t g = t < 1 ? 2 / (1 + sqrtl(1 + alpha * alpha * slope * slope)) : 0;
        sum += sinl(2 * p) * g * (i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2);
    }
    return sum * end / (3 * STEPS);
}

/* A disk of slopes below `slope` above the mirror, the camera on the axis between them. The index 0.001 + 999 i
 * reflects 1 - 4e-9 straight on and loses at most 4e-6 elsewhere. `slack`: a ray to the light's rim is known to
 * single precision, 1e-7 of its distance. */
static void check_mirror(double alpha, double slope)
{
    char name[128];
    snprintf(name, sizeof name, "rough mirror, alpha %g, light over slopes below %.3g", alpha, slope);
    const double radius = 2 * (2 * slope / (1 - slope * slope));
    FILE *f = hard_begin("LookAt 0 0 1  0 0 0  0 1 0", 1e-3 * alpha * 180 / MATH_PI, 4);
    fprintf(f,
            "Material \"conductor\" \"rgb eta\" [ 0.001 0.001 0.001 ] \"rgb k\" [ 999 999 999 ] \"float "
            "roughness\" [ %.9g ] "
            "\"bool remaproughness\" [ false ]\n",
            alpha);
    hard_quad(f, vec3(-1, -1, 0), vec3(1, -1, 0), vec3(1, 1, 0), vec3(-1, 1, 0));
    fprintf(f,
            "Material \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\nAreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\n"
            "Translate 0 0 2\nReverseOrientation\nShape \"disk\" \"float radius\" [ %.9g ]\n",
            radius);
    const double expected = (double)reflected((real_t)(float)alpha, (real_t)slope);
    hard_expect_mean(name, hard_end(name), (hard_job_t){.side = 4, .length = 2, .work = 500, .seed = 22}, expected,
                     1e-5 + 4e-7 / slope);
    hard_clear();
}

static void rough_mirrors_from_1_to_1e_4(void **state)
{
    (void)state;
    hard_case("narrow lobes");
    static const double alphas[] = {1, 0.1, 1e-2, 1e-3, 1e-4};
    for (int i = 0; i < 5; i++) {
        check_mirror(alphas[i], 0.2);
        if (alphas[i] < 0.2)
            check_mirror(alphas[i], alphas[i]); /* half of the normals */
    }
}

/* ---- agreement and invariance where no closed form is known ---- */

/* Two glass or metal spheres and a block under a light in a room. */
static const scene_t *room_with(const char *name, const char *material)
{
    FILE *f = hard_begin("LookAt 0 1 3.9  0 0.8 0  0 1 0", 38, 8);
    fprintf(f, "Material \"diffuse\" \"rgb reflectance\" [ 0.7 0.6 0.5 ]\n");
    hard_box(f, vec3(-1, 0, -1), vec3(1, 2, 4), true);
    fprintf(f, "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 4 4 4 ]\n");
    hard_quad(f, vec3(-0.5, 1.95, -0.5), vec3(0.5, 1.95, -0.5), vec3(0.5, 1.95, 0.5), vec3(-0.5, 1.95, 0.5));
    fprintf(f,
            "AttributeEnd\n%s\nAttributeBegin\nTranslate -0.4 0.5 -0.2\nShape \"sphere\" \"float radius\" [ 0.4 ]\n"
            "AttributeEnd\nTranslate 0.4 0.3 0.3\n",
            material);
    hard_box(f, vec3(-0.25, 0, -0.25), vec3(0.25, 0.6, 0.25), false);
    return hard_end(name);
}

/* `width`: of the lobe in directions, which C is as sensitive to. */
static void check_room(const char *name, const char *material, double width)
{
    const scene_t *scene = room_with(name, material);
    hard_expect_invariance(name, scene, &(hard_invariance_t){1, 6, 3000, 3000, NULL});
    hard_expect_invariance(name, scene, &(hard_invariance_t){1, 6, 3000, 500, near_the_ends});
    hard_expect_round_trips(name, scene, &(hard_round_trip_t){1, 6, 500, 1000, 1e-3, width});
    hard_agree(name, scene, (hard_job_t){.side = 8, .length = 5, .work = 4});
    hard_clear();
}

#define ROUGH(alpha) "\"float roughness\" [ " alpha " ] \"bool remaproughness\" [ false ]"

static void lobes_in_a_room(void **state)
{
    (void)state;
    hard_case("lobes");
    check_room("metal, alpha 1", "Material \"conductor\" " ROUGH("1"), 1);
    check_room("metal, alpha 0.01", "Material \"conductor\" " ROUGH("0.01"), 1e-2);
    check_room("metal, alpha 1e-4", "Material \"conductor\" " ROUGH("1e-4"), 1e-4);
    check_room("glass, alpha 0.5", "Material \"dielectric\" \"float eta\" [ 1.5 ] " ROUGH("0.5"), 0.5);
    check_room("glass, alpha 0.01", "Material \"dielectric\" \"float eta\" [ 1.5 ] " ROUGH("0.01"), 5e-3);
}

static void indices_near_one(void **state)
{
    (void)state;
    hard_case("index");
    check_room("index 1.0001", "Material \"dielectric\" \"float eta\" [ 1.0001 ]", 1);
    check_room("index 1.0001, alpha 0.1", "Material \"dielectric\" \"float eta\" [ 1.0001 ] " ROUGH("0.1"), 1e-2);
    check_room("index 1.0001, alpha 1e-4", "Material \"dielectric\" \"float eta\" [ 1.0001 ] " ROUGH("1e-4"), 1e-4);
}

/* ---- the edge of total reflection ---- */

/* Reflectance from inside a medium of index n at an angle of sine s inside: by amplitudes (Fresnel's sine and
 * tangent forms in cosines). */
static real_t fresnel_inside(real_t n, real_t s)
{
    const real_t t = n * s, ci = sqrtl(1 - s * s), ct = sqrtl(fmaxl(0, (1 - t) * (1 + t)));
    const real_t rs = (n * ci - ct) / (n * ci + ct), rp = (ci - n * ct) / (ci + n * ct);
    return (rs * rs + rp * rp) / 2;
}

/* In a glass sphere of radius 1 within black walls of radiance 1 the camera sees n^2 F^(k-2) (1 - F) over paths of
 * length k: every reflection inside repeats the same angle. At the distance d from the centre, a ray at the angle p
 * to the radius meets the surface at the angle of sine d sin p; d = (1 - 1e-7) / n puts the rays across the radius
 * at the edge of total reflection, to 1e-7. The mean over the film by the midpoint rule. */
static void check_edge(const char *name, double fov, double distance, uint32_t lengths)
{
    enum { FINE = 512, SIDE = 4 };
    const real_t n = 1.5, half = tanl((real_t)fov * acosl(-1) / 360);
    double expected[PATH_MAX_VERTICES] = {0};
    for (int y = 0; y < FINE; y++)
        for (int x = 0; x < FINE; x++) {
            const real_t px = half * (2 * (x + 0.5L) / FINE - 1), py = half * (2 * (y + 0.5L) / FINE - 1);
            const real_t across =
                sqrtl((1 + py * py) / (1 + px * px + py * py)); /* sine to the radius, the x axis */
            const real_t F = fresnel_inside(n, (real_t)distance * across);
            real_t b = n * n * (1 - F) * SIDE * SIDE / ((real_t)FINE * FINE);
            for (uint32_t k = 2; k <= lengths; k++, b *= F)
                expected[k] += (double)b;
        }
    char camera[128];
    snprintf(camera, sizeof camera, "LookAt %.17g 0 0  %.17g 0 1  0 1 0", distance, distance);
    FILE *f = hard_begin(camera, fov, SIDE);
    fprintf(f, "AttributeBegin\n");
    hard_furnace_walls(f, 0, 1);
    hard_box(f, vec3(-2, -2, -2), vec3(2, 2, 2), true);
    fprintf(
        f,
        "AttributeEnd\nMaterial \"dielectric\" \"float eta\" [ 1.5 ]\nShape \"sphere\" \"float radius\" [ 1 ]\n");
    /* the midpoint rule meets a square root's edge: 1 / FINE^1.5; and what is beyond the last length is lost alike
     */
    const scene_t *scene = hard_end(name);
    hard_expect_lengths(name, scene,
                        (hard_job_t){.side = SIDE, .length = lengths, .work = 500, .seed = 23, .pilot = 10000},
                        expected, 2e-4);
    hard_expect_round_trips(name, scene, &(hard_round_trip_t){2, 12, 5000, 5, 1e-3, 0.1});
    hard_clear();
}

static void edge_of_total_reflection(void **state)
{
    (void)state;
    hard_case("total reflection");
    const double edge = (1 - 1e-7) / 1.5;
    check_edge("edge of total reflection, 90 degrees", 90, edge, 12);
    check_edge("edge of total reflection, 2 degrees", 2, edge, 12);
    check_edge("edge of total reflection, 0.02 degrees", 0.02, edge, 12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(camera_that_grazes_a_floor),
        cmocka_unit_test(numbers_near_their_ends),
        cmocka_unit_test(rough_mirrors_from_1_to_1e_4),
        cmocka_unit_test(lobes_in_a_room),
        cmocka_unit_test(indices_near_one),
        cmocka_unit_test(edge_of_total_reflection),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
