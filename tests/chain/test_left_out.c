/* Effects that a job leaves out: what is left is the same whichever techniques make it, what is gone is gone. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "chain/work_fixture.h"
#include "support/sanitized.h"

/* Under the sanitizers an eighth: comparisons by standard errors hold for any number. */
enum { ROUNDS = SANITIZED ? 16 : 128, SAMPLES = 24 * 24 * ROUNDS, K = WORK_FIXTURE_LENGTH };

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

/* What is left out, of the light that there would be, by a unit that measures it: sums over `count` draws. */
enum { ENERGY_DRAWS = 1 << 17 };
typedef struct energies {
    work_moments_t moments[WORK_LEFT_OUT_MOMENTS];
} energies_t;

static energies_t energies_of(small_light_t kind, const int *effects, int count)
{
    work_fixture_t fixture;
    work_fixture_make(&fixture, kind, SETTINGS_BDPT);
    settings_t settings = fixture.settings;
    for (int i = 0; i < count; i++)
        settings.effects[effects[i]] = SETTINGS_SWITCH_OFF;
    renderer_t *renderer;
    work_space_t *space;
    fault_t fault = {0};
    const work_record_t record = {.kind = WORK_LEFT_OUT, .count = ENERGY_DRAWS};
    work_result_t result;
    energies_t energies;
    if (renderer_new(&renderer, &fixture.small.scene, &settings, &fault) ||
        work_space_new(&space, renderer, &fault) || work_run(space, &record, &go, &result, &fault))
        fail_msg("%s", fault.text);
    assert_int_equal(result.moment_count, WORK_LEFT_OUT_MOMENTS);
    memcpy(energies.moments, result.moments, sizeof energies.moments);
    work_space_destroy(&space);
    renderer_destroy(&renderer);
    work_fixture_clear(&fixture);
    return energies;
}

static const work_moments_t *part_of(const energies_t *energies, int effect)
{
    return &energies->moments[1 + 2 * effect];
}

/* Mean and its variance. */
static double mean_of(const work_moments_t *m, double *variance)
{
    const double mean = m->sum / m->n;
    *variance = fmax(0, m->sum2 / m->n - mean * mean) / m->n;
    return mean;
}

/* The light by which two images differ, one without the effect, is the energy that is told of it. Four comparisons
 * at 4.5 standard errors: 2.7e-5 of false alarm, were the sums normal. */
static void energies_are_what_images_lack(void **state)
{
    (void)state;
    static const struct {
        small_light_t light;
        int effect;
    } cases[] = {{SMALL_LIGHT_AREA, SETTINGS_CAUSTICS},
                 {SMALL_LIGHT_CONSTANT, SETTINGS_ENVIRONMENT},
                 {SMALL_LIGHT_AREA, SETTINGS_INDIRECT},
                 {SMALL_LIGHT_AREA, SETTINGS_EMISSION}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const light_t all = light_without(cases[i].light, SETTINGS_BDPT, SETTINGS_EFFECTS),
                      rest = light_without(cases[i].light, SETTINGS_BDPT, cases[i].effect);
        const energies_t energies = energies_of(cases[i].light, &cases[i].effect, 1);
        double lacks = 0, error = 0, variance;
        for (uint32_t k = 1; k <= K; k++) { /* of the same draws: errors of lengths add up at most */
            lacks += (all.sum[k] - rest.sum[k]) / SAMPLES;
            error += sqrt(variance_of(&all, k)) / SAMPLES;
        }
        const double told = mean_of(part_of(&energies, cases[i].effect), &variance);
        assert_true(told > 0);
        if (!(fabs(told - lacks) < 4.5 * sqrt(variance + error * error)))
            fail_msg("effect %d: %g, but images differ by %g", cases[i].effect, told, lacks);
    }
}

/* What several effects take away together is counted once; parts and rest are all there is. */
static void energies_of_several_effects_add_up(void **state)
{
    (void)state;
    static const int both[] = {SETTINGS_CAUSTICS, SETTINGS_INDIRECT},
                     three[] = {SETTINGS_CAUSTICS, SETTINGS_INDIRECT, SETTINGS_EMISSION};
    const energies_t two = energies_of(SMALL_LIGHT_AREA, both, 2), more = energies_of(SMALL_LIGHT_AREA, three, 3);
    for (int e = 0; e < SETTINGS_EFFECTS; e++) /* the same draws, whatever is left out */
        assert_true(part_of(&two, e)->sum == part_of(&more, e)->sum);
    for (int e = 0; e <= WORK_LEFT_OUT_ALL; e++) {
        const double sum = part_of(&two, e)->sum + two.moments[2 + 2 * e].sum;
        assert_true(fabs(sum - two.moments[0].sum) < 1e-9 * sum);
    }
    /* a caustic has three segments or more */
    assert_true(part_of(&two, SETTINGS_CAUSTICS)->sum < part_of(&two, SETTINGS_INDIRECT)->sum);
    assert_true(part_of(&two, WORK_LEFT_OUT_ALL)->sum == part_of(&two, SETTINGS_INDIRECT)->sum);
    const double together = part_of(&more, SETTINGS_INDIRECT)->sum + part_of(&more, SETTINGS_EMISSION)->sum;
    assert_true(fabs(part_of(&more, WORK_LEFT_OUT_ALL)->sum - together) < 1e-9 * together);
    assert_true(part_of(&two, SETTINGS_APERTURE)->sum == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_rest_is_the_same_by_all_techniques),
        cmocka_unit_test(caustics_are_of_three_segments_and_more),
        cmocka_unit_test(light_from_infinity_is_left_out),
        cmocka_unit_test(lengths_are_left_out),
        cmocka_unit_test(a_lens_without_aperture_is_a_pinhole),
        cmocka_unit_test(energies_are_what_images_lack),
        cmocka_unit_test(energies_of_several_effects_add_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
