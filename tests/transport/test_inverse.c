/* The inverse path sampler: S_s'(R_s'(x)) = x for paths x of every technique s and every s' that can make them,
 * with the same contribution. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <setjmp.h>
#include <cmocka.h>

#include "base/random.h"
#include "inverse_trip.h"

/* A round trip moves vertices by roundings of 1e-16, times the walk's amplification: some 1e-12 for ten vertices.
 * What fails are rays within Embree's reach of an edge (2^-20 of a coordinate, surface.h): 1e-6 of the surface for
 * each vertex in the rooms, 1e-3 of the light for each hit of the tiny one. */
static const double share_of_all = 1e-3, share_of_scene = 3e-3, share_of_ten = 1e-2;
/* Contributions: relative, over the width of the scene's narrowest lobe (its alpha). The same roundings; next to a
 * corner over its distance, on a sphere's silhouette their square root. Few may be off by more. */
static const double tolerance_of_one = 1e-7, usual_width = 0.1, share_off = 1e-4;

typedef bool invert_fn(const path_scene_t *, const path_space_t *, uint32_t, uint32_t, uint32_t, uint64_t, double *,
                       double *);

typedef struct tally {
    invert_fn *invert;
    bool extreme;
    double tolerance; /* of contributions */
    uint64_t trips, causes[PATH_INVERSE_FAILURES];
    uint64_t one_way; /* the path as made again doesn't lead back to the technique it came from */
    uint64_t off;     /* contributions beyond the tolerance */
    double moved, changed;
} tally_t;

static tally_t all;

static double share(const tally_t *tally)
{
    return (double)(tally->trips - tally->causes[PATH_INVERSE_AGREES]) / (double)tally->trips;
}

static void check_numbers(const double *u, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (!(u[i] >= 0 && u[i] < 1))
            fail_msg("number %u is %.17g", i, u[i]);
}

/* From y, made by technique j, back to s. */
static bool leads_back(trip_t *trip, uint32_t s, uint32_t j, uint64_t key)
{
    const uint32_t t = trip->target.length + 1 - j;
    path_check_t check;
    return path_invert(&trip->ps, trip->y, j, t, s, key, trip->camera_new, trip->light_new) &&
           !path_verify(&trip->ps, trip->y, j, t, trip->z, s, trip->camera_new, trip->light_new,
                        &trip->target.techniques, &check);
}

static void tally_trip(trip_t *trip, uint32_t s, uint32_t j, double c, uint64_t key, tally_t *tally)
{
    const uint32_t t = trip->target.length + 1 - s;
    path_check_t check = {.error = 0};
    path_inverse_failure_t cause = PATH_INVERSE_VOID;
    memcpy(trip->camera_new, trip->camera, sizeof trip->camera);
    memcpy(trip->light_new, trip->light, sizeof trip->light);
    if (tally->invert(&trip->ps, trip->x, s, t, j, key, trip->camera_new, trip->light_new)) {
        check_numbers(trip->camera_new, trip->target.camera_count);
        check_numbers(trip->light_new, trip->target.light_count);
        cause = path_verify(&trip->ps, trip->x, s, t, trip->y, j, trip->camera_new, trip->light_new,
                            &trip->target.techniques, &check);
    }
    tally->trips++;
    tally->causes[cause]++;
    if (cause != PATH_INVERSE_AGREES)
        return;
    tally->one_way += !leads_back(trip, s, j, random_step(key, 1));
    const double again = target_scalar(trip->target.kind, check.value.value);
    assert_true(again > 0 && again < 1e300);
    const double changed = fabs(again - c) / fmax(again, c);
    tally->off += !(changed <= tally->tolerance);
    tally->moved = fmax(tally->moved, check.error);
    tally->changed = fmax(tally->changed, changed);
}

static void tally_length(trip_t *trip, uint32_t k, uint32_t paths, tally_t *tally)
{
    trip_length(trip, k);
    for (uint32_t i = 0; i < paths && trip->target.count > 0; i++) {
        const uint64_t key = random_key(31, RANDOM_PURPOSE_TEST, k, i);
        const uint32_t s = trip->target.list[i % trip->target.count];
        trip_numbers(trip, key, tally->extreme);
        const double c = trip_make(trip, s);
        for (uint32_t j = 0; j < trip->target.count && c > 0; j++)
            if (trip_possible(trip, s, trip->target.list[j]))
                tally_trip(trip, s, trip->target.list[j], c, random_step(key, j), tally);
    }
}

static void tally_print(const char *name, const tally_t *tally)
{
    const uint64_t *c = tally->causes;
    print_message(
        "%s: %llu round trips, share failing %.2g (void %llu, short %llu, kind %llu, moved %llu, dark %llu), "
        "%llu one-way; largest movement %.2g, change of C %.2g, %llu off\n",
        name, (unsigned long long)tally->trips, share(tally), (unsigned long long)c[PATH_INVERSE_VOID],
        (unsigned long long)c[PATH_INVERSE_SHORT], (unsigned long long)c[PATH_INVERSE_KIND],
        (unsigned long long)c[PATH_INVERSE_MOVED], (unsigned long long)c[PATH_INVERSE_CARRIES_NOTHING],
        (unsigned long long)tally->one_way, tally->moved, tally->changed, (unsigned long long)tally->off);
}

static void check_scene(const char *name, double width)
{
    enum { LONGEST = 8, PATHS = 1000 };
    static trip_t trip;
    trip_begin(&trip, name);
    invert_fn *const both[2] = {path_invert, path_invert_jump};
    for (int way = 0; way < 2; way++) {
        tally_t tally = {.invert = both[way], .tolerance = tolerance_of_one / width};
        for (uint32_t k = 1; k <= LONGEST; k++)
            tally_length(&trip, k, PATHS, &tally);
        tally_print(way ? "  (numbers kept)" : name, &tally);
        assert_true(tally.trips > 1000);
        assert_true(share(&tally) <= share_of_scene);
        assert_true((double)tally.one_way <= share_of_scene * (double)tally.trips);
        assert_true((double)tally.off <= share_off * (double)tally.trips);
        all.trips += tally.trips;
        all.causes[PATH_INVERSE_AGREES] += tally.causes[PATH_INVERSE_AGREES];
    }
    trip_end(&trip);
}

#define SCENE_TEST(function, name, width)                                                                          \
    static void function(void **state)                                                                             \
    {                                                                                                              \
        (void)state;                                                                                               \
        check_scene(name, width);                                                                                  \
    }

SCENE_TEST(diffuse_room, "diffuse", usual_width)
SCENE_TEST(glossy_room, "glossy", usual_width)
SCENE_TEST(specular_room, "glass", usual_width)
SCENE_TEST(caustics, "caustics", usual_width)
SCENE_TEST(point_and_spot, "delta-lights", usual_width)
SCENE_TEST(sky_and_sun, "environment", usual_width)
SCENE_TEST(constant_sky, "sky", usual_width)
SCENE_TEST(tiny_light, "tiny-light", usual_width)
SCENE_TEST(lens_and_filter, "lens", usual_width)
SCENE_TEST(transmitting_screens, "transmission", usual_width)
SCENE_TEST(interpolated_normals, "normals", usual_width)
SCENE_TEST(skies_and_textures, "skies", usual_width)
SCENE_TEST(lamps_and_mixtures, "lamps", usual_width)
SCENE_TEST(narrow_lobes, "narrow", 1e-4)
SCENE_TEST(furnace_with_glass, "glass-furnace", usual_width)

static void few_fail_overall(void **state)
{
    (void)state;
    print_message("%llu round trips, share failing %.2g\n", (unsigned long long)all.trips, share(&all));
    assert_true(share(&all) <= share_of_all);
}

/* Spheres amplify what is off by distance over radius, some three- to tenfold each time: by 1e9 over 50 vertices of
 * which half are on spheres. Keeping the numbers of what both techniques share halves the exponent. */
static void long_paths_among_glass(void **state)
{
    (void)state;
    static trip_t trip;
    trip_begin(&trip, "glass-furnace");
    static const struct {
        uint32_t k, paths;
        double most, most_kept;
    } lengths[] = {{10, 1000, 1e-2, 1e-3}, {30, 300, 1e-2, 2e-3}, {50, 200, 3e-2, 2e-3}};
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++)
        for (int way = 0; way < 2; way++) {
            tally_t tally = {.invert = way ? path_invert_jump : path_invert, .tolerance = 1e-3};
            tally_length(&trip, lengths[i].k, lengths[i].paths, &tally);
            char name[32];
            snprintf(name, sizeof name, "length %u%s", lengths[i].k, way ? ", numbers kept" : "");
            tally_print(name, &tally);
            assert_true(tally.trips > 500);
            assert_true((double)tally.off <= 1e-3 * (double)tally.trips);
            assert_true(share(&tally) <= (way ? lengths[i].most_kept : lengths[i].most));
        }
    trip_end(&trip);
}

static void length_ten(void **state)
{
    (void)state;
    static const char *const scenes[] = {"diffuse", "glossy", "glass", "lamps", "lens", "furnace"};
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        static trip_t trip;
        trip_begin(&trip, scenes[i]);
        tally_t tally = {.invert = path_invert, .tolerance = 1e-6};
        tally_length(&trip, 10, 1000, &tally);
        tally_print(scenes[i], &tally);
        assert_true(tally.trips > 300);
        assert_true((double)tally.off <= 1e-3 * (double)tally.trips);
        assert_true(share(&tally) <= share_of_ten);
        trip_end(&trip);
    }
}

/* Numbers 0 and the largest below 1 put vertices on corners and edges, send rays along surfaces (cosine 1e-8) and
 * start them on the rim of lights and lenses. Many such paths don't come back; each is counted, every number stays
 * in [0,1) and every value is finite. On corners the distance of two vertices says nothing, so C may change. */
static void extreme_numbers(void **state)
{
    (void)state;
    static const char *const scenes[] = {"glossy", "glass",        "lens",        "lamps",
                                         "skies",  "delta-lights", "environment", "normals"};
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        static trip_t trip;
        trip_begin(&trip, scenes[i]);
        tally_t tally = {.invert = path_invert, .extreme = true, .tolerance = 1e-6};
        for (uint32_t k = 1; k <= 6; k++)
            tally_length(&trip, k, 1000, &tally);
        tally_print(scenes[i], &tally);
        assert_true(tally.trips > 1000);
        assert_true(share(&tally) <= 0.25);
        assert_true((double)tally.off <= 0.05 * (double)tally.trips);
        trip_end(&trip);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(diffuse_room),         cmocka_unit_test(glossy_room),
        cmocka_unit_test(specular_room),        cmocka_unit_test(caustics),
        cmocka_unit_test(point_and_spot),       cmocka_unit_test(sky_and_sun),
        cmocka_unit_test(constant_sky),         cmocka_unit_test(tiny_light),
        cmocka_unit_test(lens_and_filter),      cmocka_unit_test(transmitting_screens),
        cmocka_unit_test(interpolated_normals), cmocka_unit_test(skies_and_textures),
        cmocka_unit_test(lamps_and_mixtures),   cmocka_unit_test(narrow_lobes),
        cmocka_unit_test(furnace_with_glass),   cmocka_unit_test(few_fail_overall),
        cmocka_unit_test(length_ten),           cmocka_unit_test(long_paths_among_glass),
        cmocka_unit_test(extreme_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
