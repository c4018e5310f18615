/* Effects that a job leaves out: what is left is the same whichever techniques make it, what is gone is gone. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "chain/work_fixture.h"

enum { ROUNDS = 128, SAMPLES = 24 * 24 * ROUNDS, K = WORK_FIXTURE_LENGTH };

static const atomic_bool go = false;

/* Light by length: sums over SAMPLES draws and sums of squares. */
typedef struct light {
    double sum[K + 1], sum2[K + 1];
} light_t;

static light_t light_of(const scene_t *scene, const settings_t *settings)
{
    renderer_t *renderer;
    work_space_t *space;
    fault_t fault = {0};
    const work_record_t record = {.kind = WORK_SAMPLES, .count = SAMPLES, .scale = 0x1p-10};
    work_result_t result;
    light_t light = {0};
    if (renderer_new(&renderer, scene, settings, &fault) || work_space_new(&space, renderer, &fault) ||
        work_run(space, &record, &go, &result, &fault))
        fail_msg("%s", fault.text);
    for (uint32_t k = 1; k <= renderer_settings(renderer)->max_path_length; k++) {
        light.sum[k] = result.moments[work_samples_moment(k)].sum;
        light.sum2[k] = result.moments[work_samples_moment(k)].sum2;
    }
    work_space_destroy(&space);
    renderer_destroy(&renderer);
    return light;
}

static light_t light_without(small_light_t kind, settings_algorithm_t algorithm, int effect)
{
    work_fixture_t fixture;
    work_fixture_make(&fixture, kind, SETTINGS_BDPT);
    settings_t settings = fixture.settings;
    settings.algorithm = algorithm;
    if (effect < SETTINGS_EFFECTS)
        settings.effects[effect] = SETTINGS_SWITCH_OFF;
    const light_t light = light_of(&fixture.small.scene, &settings);
    work_fixture_clear(&fixture);
    return light;
}

static double variance_of(const light_t *light, uint32_t k)
{
    return fmax(0, light->sum2[k] - light->sum[k] * light->sum[k] / SAMPLES);
}

/* A path is a caustic whoever makes it: techniques s <= 1 alone, which know the first vertex after the light only
 * from the camera, bring what all of them bring. Four comparisons a light at 4.5 standard errors: 5.4e-5 of false
 * alarm in all, were the sums normal. */
static void the_rest_is_the_same_by_all_techniques(void **state)
{
    (void)state;
    static const small_light_t kinds[] = {SMALL_LIGHT_AREA, SMALL_LIGHT_CONSTANT};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        const light_t pt = light_without(kinds[i], SETTINGS_PT, SETTINGS_CAUSTICS),
                      bdpt = light_without(kinds[i], SETTINGS_BDPT, SETTINGS_CAUSTICS);
        for (uint32_t k = 2; k <= K; k++) {
            const double error = sqrt(variance_of(&pt, k) + variance_of(&bdpt, k));
            if (!(fabs(pt.sum[k] - bdpt.sum[k]) < 4.5 * error))
                fail_msg("length %u: %g by pt, %g by bdpt, standard error %g", k, pt.sum[k], bdpt.sum[k], error);
        }
    }
}

/* Of the same draws: shorter paths cannot be caustics and stay to the bit, longer ones lose what caustics bring. */
static void caustics_are_of_three_segments_and_more(void **state)
{
    (void)state;
    const light_t all = light_without(SMALL_LIGHT_AREA, SETTINGS_BDPT, SETTINGS_EFFECTS),
                  rest = light_without(SMALL_LIGHT_AREA, SETTINGS_BDPT, SETTINGS_CAUSTICS);
    for (uint32_t k = 1; k <= 2; k++)
        assert_true(all.sum[k] == rest.sum[k] && all.sum2[k] == rest.sum2[k]);
    for (uint32_t k = 3; k <= K; k++)
        if (!(rest.sum[k] > 0 && rest.sum[k] < all.sum[k]))
            fail_msg("length %u: %g of %g without caustics", k, rest.sum[k], all.sum[k]);
}

static void light_from_infinity_is_left_out(void **state)
{
    (void)state;
    const light_t none = light_without(SMALL_LIGHT_CONSTANT, SETTINGS_BDPT, SETTINGS_ENVIRONMENT);
    for (uint32_t k = 1; k <= K; k++)
        assert_true(none.sum2[k] == 0);
    static const small_light_t others[] = {SMALL_LIGHT_AREA, SMALL_LIGHT_DISTANT};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        const light_t all = light_without(others[i], SETTINGS_BDPT, SETTINGS_EFFECTS),
                      rest = light_without(others[i], SETTINGS_BDPT, SETTINGS_ENVIRONMENT);
        assert_true(all.sum[2] > 0);
        assert_memory_equal(&all, &rest, sizeof all);
    }
}

static void lengths_are_left_out(void **state)
{
    (void)state;
    const light_t all = light_without(SMALL_LIGHT_AREA, SETTINGS_BDPT, SETTINGS_EFFECTS),
                  direct = light_without(SMALL_LIGHT_AREA, SETTINGS_BDPT, SETTINGS_INDIRECT),
                  unseen = light_without(SMALL_LIGHT_AREA, SETTINGS_BDPT, SETTINGS_EMISSION);
    assert_true(all.sum[1] > 0 && unseen.sum[1] == 0 && direct.sum[1] == all.sum[1]);
    assert_true(fabs(direct.sum[2] - all.sum[2]) < 1e-9 * all.sum[2]);
    for (uint32_t k = 3; k <= K; k++)
        assert_true(all.sum[k] > 0 && direct.sum[k] == 0);
    assert_memory_equal(&all.sum[2], &unseen.sum[2], (K - 1) * sizeof *all.sum);
}

static void a_lens_without_aperture_is_a_pinhole(void **state)
{
    (void)state;
    work_fixture_t fixture;
    work_fixture_make(&fixture, SMALL_LIGHT_AREA, SETTINGS_BDPT);
    settings_t settings = fixture.settings;
    scene_t scene = fixture.small.scene;
    scene_camera_t camera = *scene.camera;
    const light_t pinhole = light_of(&scene, &settings);
    camera.lens_radius = 0.1;
    camera.focal_distance = 2;
    scene.camera = &camera;
    const light_t lens = light_of(&scene, &settings);
    settings.effects[SETTINGS_APERTURE] = SETTINGS_SWITCH_OFF;
    const light_t without = light_of(&scene, &settings);
    assert_memory_equal(&without, &pinhole, sizeof pinhole);
    assert_true(lens.sum[2] != pinhole.sum[2]);
    work_fixture_clear(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_rest_is_the_same_by_all_techniques),
        cmocka_unit_test(caustics_are_of_three_segments_and_more),
        cmocka_unit_test(light_from_infinity_is_left_out),
        cmocka_unit_test(lengths_are_left_out),
        cmocka_unit_test(a_lens_without_aperture_is_a_pinhole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
