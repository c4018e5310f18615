/* The target is a function of the path alone: whatever technique makes a path, w_s f / p_s = f / sum_j p_j. The
 * right side is computed by definition (reference.c), the left by connect.c from ratios along the walks. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <setjmp.h>
#include <cmocka.h>

#include "base/random.h"
#include "chain/target.h"
#include "load.h"
#include "reference.h"

/* Relative. Directions are recomputed from positions, which costs a specular or narrow lobe 1e-16 distance / width:
 * the scenes' narrowest smooth lobe has alpha 0.15. A hit that rounding puts outside its triangle is moved to the
 * edge, by at most the rays' offset of 2^-20: about one path in ten thousand. */
static const double tolerance = 1e-9, tolerance_at_edges = 0x1p-19;
static const double share_at_edges = 1e-3;
enum { PATHS = 4000, LENGTH = 7 };

typedef struct tally {
    uint32_t compared[PATH_MAX_VERTICES], off;
    double worst;
} tally_t;

static double relative(double a, double b)
{
    return fabs(a - b) / fmax(fabs(a), fabs(b));
}

static void compare_path(const path_scene_t *ps, path_space_t *space, const target_t *target, uint32_t s,
                         uint64_t key, tally_t *tally)
{
    double camera[PATH_MAX_DIMENSIONS], light[PATH_MAX_DIMENSIONS];
    for (uint32_t i = 0; i < target->camera_count; i++)
        camera[i] = random_double(key, i);
    for (uint32_t i = 0; i < target->light_count; i++)
        light[i] = random_double(key, 1000 + i);
    const uint32_t t = target->length + 1 - s;
    path_value_t value;
    if (path_walk_camera(ps, space, camera, t, PATH_ENDS_ANYWHERE) < t ||
        (s > 0 && path_walk_light(ps, space, light, s, PATH_ENDS_ANYWHERE) < s) ||
        !path_connect(ps, space, s, t, NULL, &target->techniques, &value))
        return;
    reference_t reference;
    reference_evaluate(ps, space, s, t, &target->techniques, &reference);
    assert_true(reference.valid);
    assert_true(reference.p[s] > 0);
    const double expected[3] = {(double)(reference.f[0] / reference.sum), (double)(reference.f[1] / reference.sum),
                                (double)(reference.f[2] / reference.sum)};
    const double found[3] = {value.value.r, value.value.g, value.value.b};
    for (int c = 0; c < 3; c++) {
        if (expected[c] == 0 && found[c] == 0)
            continue;
        const double error = relative(expected[c], found[c]);
        if (!(error <= tolerance)) {
            tally->off++;
            if (!(error <= tolerance_at_edges))
                print_error("length %u, s = %u: channel %d is %.12g, by definition %.12g\n", target->length, s, c,
                            found[c], expected[c]);
        }
        tally->worst = fmax(tally->worst, error);
    }
    tally->compared[s]++;
}

static void check_scene(const char *name)
{
    const scene_t *scene = load_scene(name);
    fault_t fault = {0};
    path_scene_t ps;
    if (path_scene_init(&ps, scene, scene->camera, 0, 0, &fault))
        fail_msg("%s: %s", name, fault.text);
    path_space_t *space = path_space_new();
    settings_t settings;
    settings_default(&settings);
    tally_t tally = {0};
    for (uint32_t k = 1; k <= LENGTH; k++) {
        target_t target;
        target_init(&target, &ps, &settings, k);
        for (uint32_t i = 0; i < PATHS; i++) {
            const uint64_t key = random_key(7, RANDOM_PURPOSE_TEST, k, i);
            if (target.count > 0)
                compare_path(&ps, space, &target, target.list[i % target.count], key, &tally);
        }
    }
    uint32_t total = 0;
    for (uint32_t s = 0; s <= LENGTH; s++)
        total += tally.compared[s];
    print_message("%s: %u paths, %u channels beyond %g, worst %.2g\n", name, total, tally.off, tolerance,
                  tally.worst);
    assert_true(total > 500);
    assert_true(tally.worst <= tolerance_at_edges);
    assert_true(tally.off <= share_at_edges * 3 * total);
    free(space);
    path_scene_clear(&ps);
    load_clear();
}

#define SCENE_TEST(function, name)                                                                                 \
    static void function(void **state)                                                                             \
    {                                                                                                              \
        (void)state;                                                                                               \
        check_scene(name);                                                                                         \
    }

SCENE_TEST(diffuse_room, "diffuse")
SCENE_TEST(glossy_room, "glossy")
SCENE_TEST(specular_room, "glass")
SCENE_TEST(sky_and_sun, "environment")
SCENE_TEST(point_and_spot, "delta-lights")
SCENE_TEST(tiny_light, "tiny-light")
SCENE_TEST(lens_and_filter, "lens")
SCENE_TEST(transmitting_screens, "transmission")
SCENE_TEST(interpolated_normals, "normals")

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(diffuse_room),         cmocka_unit_test(glossy_room),
        cmocka_unit_test(specular_room),        cmocka_unit_test(sky_and_sun),
        cmocka_unit_test(point_and_spot),       cmocka_unit_test(tiny_light),
        cmocka_unit_test(lens_and_filter),      cmocka_unit_test(transmitting_screens),
        cmocka_unit_test(interpolated_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
