/* Techniques against each other: b_k estimated by one technique alone (its weight is then 1), by every other alone,
 * and by all together with the balance heuristic, agree within their standard errors on scenes that each technique
 * covers. Where there are specular surfaces only s = 0 covers all paths: there each technique is paired with it. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <setjmp.h>
#include <cmocka.h>

#include "base/random.h"
#include "chain/target.h"
#include "load.h"

enum { SAMPLES = 150000, LONGEST = 4, HITS_LEAST = 400 };

/* 9 scenes, at most 12 comparisons each: two-sided false alarm 1e-6 in all is |z| > 5.8 for normal means. Means of
 * these heavy-tailed samples are not normal, and their errors are estimated: a quarter more. */
static const double z_most = 5.8 * 1.25;

/* A sum of which one sample is more than this has not seen its tail. */
static const double largest_most = 0.02;

typedef struct estimate {
    double mean, error;
    double largest; /* share of the largest sample in the sum */
    uint32_t hits;
} estimate_t;

static estimate_t estimate(path_space_t *space, const target_t *target, uint64_t stream)
{
    double sum = 0, sum2 = 0, camera[PATH_MAX_DIMENSIONS], light[PATH_MAX_DIMENSIONS];
    estimate_t out = {0};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        const uint64_t key = random_key(11, RANDOM_PURPOSE_TEST, target->length << 8 | stream, i);
        for (uint32_t d = 0; d < target->camera_count; d++)
            camera[d] = random_double(key, d);
        for (uint32_t d = 0; d < target->light_count; d++)
            light[d] = random_double(key, 1000 + d);
        const uint32_t s = target->list[(uint32_t)(random_double(key, 5000) * target->count)];
        target_value_t value;
        target_eval(target, space, s, camera, light, &value);
        const double x = value.c * target->count;
        sum += x;
        sum2 += x * x;
        out.hits += x > 0;
        out.largest = math_max(out.largest, x);
    }
    out.mean = sum / SAMPLES;
    out.error = sqrt((sum2 / SAMPLES - out.mean * out.mean) / SAMPLES);
    out.largest /= sum;
    return out;
}

/* Returns how many techniques could be compared. */
static uint32_t check_length(const char *name, path_space_t *space, const target_t *all, bool with_zero)
{
    const uint32_t k = all->length;
    const estimate_t together = estimate(space, all, 200);
    print_message("%s, length %u: all %.5g +- %.2g;", name, k, together.mean, together.error);
    uint32_t compared = 0;
    for (uint32_t i = 0; i < all->count; i++) {
        target_t alone = *all;
        alone.count = 1;
        alone.list[0] = all->list[i];
        memset(alone.techniques.allowed, 0, sizeof alone.techniques.allowed);
        alone.techniques.allowed[all->list[i]] = 1;
        if (with_zero && all->list[i] != 0) {
            alone.list[alone.count++] = 0;
            alone.techniques.allowed[0] = 1;
        }
        const estimate_t single = estimate(space, &alone, all->list[i]);
        print_message(" s=%u %.5g +- %.2g", all->list[i], single.mean, single.error);
        if (single.hits < HITS_LEAST || single.largest > largest_most)
            continue; /* it hardly ever finds the light: its error is not to be believed */
        compared++;
        if (!(fabs(single.mean - together.mean) <= z_most * hypot(single.error, together.error)))
            fail_msg("%s, length %u: technique %u alone gives %g +- %g, all together %g +- %g", name, k,
                     all->list[i], single.mean, single.error, together.mean, together.error);
    }
    print_message(" (%u compared)\n", compared);
    return compared;
}

static void check_scene(const char *name, bool with_zero)
{
    const scene_t *scene = load_scene(name);
    fault_t fault = {0};
    path_scene_t ps;
    if (path_scene_init(&ps, scene, scene->camera, 0, 0, &fault))
        fail_msg("%s: %s", name, fault.text);
    path_space_t *space = path_space_new();
    settings_t settings;
    settings_default(&settings);
    uint32_t compared = 0;
    for (uint32_t k = 2; k <= LONGEST; k++) {
        target_t target;
        target_init(&target, &ps, &settings, k);
        compared += check_length(name, space, &target, with_zero);
    }
    assert_true(compared >= 6);
    free(space);
    path_scene_clear(&ps);
    load_clear();
}

#define SCENE_TEST(function, name, with_zero)                                                                      \
    static void function(void **state)                                                                             \
    {                                                                                                              \
        (void)state;                                                                                               \
        check_scene(name, with_zero);                                                                              \
    }

SCENE_TEST(diffuse_room, "diffuse", false)
SCENE_TEST(glossy_room, "glossy", false)
SCENE_TEST(tiny_light, "tiny-light", false)
SCENE_TEST(point_and_spot, "delta-lights", false)
SCENE_TEST(lens_and_filter, "lens", false)
SCENE_TEST(interpolated_normals, "normals", false)
SCENE_TEST(sky, "sky", false)
SCENE_TEST(specular_room, "glass", true)
SCENE_TEST(transmitting_screens, "transmission", true)

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(diffuse_room),
        cmocka_unit_test(glossy_room),
        cmocka_unit_test(tiny_light),
        cmocka_unit_test(point_and_spot),
        cmocka_unit_test(lens_and_filter),
        cmocka_unit_test(interpolated_normals),
        cmocka_unit_test(sky),
        cmocka_unit_test(specular_room),
        cmocka_unit_test(transmitting_screens),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
