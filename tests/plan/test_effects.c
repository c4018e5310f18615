/* Effects: every scene of tests/scenes has those that its text says, made-up scenes have what was put in, and what
 * nothing refers to is not there. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "load.h"
#include "plan/effects.h"
#include "plan/plan_fixture.h"

static settings_t settings_of(settings_algorithm_t algorithm)
{
    settings_t s;
    settings_default(&s);
    s.algorithm = algorithm;
    s.max_path_length = 5;
    return s;
}

/* The names of what a scene (not the settings) brings, with a blank behind each. */
static const char *present(const scene_t *scene)
{
    static char text[1024];
    const settings_t s = settings_of(SETTINGS_BDPT);
    effects_t effects;
    effects_analyse(&effects, scene, &s);
    text[0] = 0;
    for (int kind = 0; kind < EFFECT_INDIRECT; kind++) {
        assert_true(effects.list[kind].reason[0] != 0);
        if (effects.list[kind].present)
            snprintf(text + strlen(text), sizeof text - strlen(text), "%s ", effects_name((effect_kind_t)kind));
    }
    return text;
}

static void test_scenes_have_what_they_say(void **state)
{
    (void)state;
    static const char *const expected[][2] = {
        {"caustics", "diffuse glossy specular_reflection specular_transmission caustics area_lights "
                     "interpolated_normals pixel_filter "},
        {"delta-lights", "diffuse glossy caustics point_lights spot_lights "},
        {"diffuse", "diffuse area_lights "},
        {"environment",
         "diffuse glossy specular_reflection specular_transmission caustics distant_lights environment "},
        {"furnace", "diffuse area_lights "},
        {"glass", "diffuse specular_reflection specular_transmission caustics area_lights "},
        {"glossy", "diffuse glossy caustics area_lights "},
        {"lens", "diffuse glossy caustics area_lights aperture pixel_filter "},
        {"normals", "diffuse glossy caustics area_lights interpolated_normals "},
        {"sky", "diffuse glossy caustics environment "},
        {"tiny-light", "diffuse glossy caustics area_lights "},
        {"transmission",
         "diffuse diffuse_transmission glossy specular_reflection specular_transmission caustics area_lights "},
    };
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        const char *found = present(load_scene(expected[i][0]));
        if (strcmp(found, expected[i][1]) != 0)
            fail_msg("%s has %s\nexpected %s", expected[i][0], found, expected[i][1]);
    }
    load_clear();
}

static void lights_are_told_apart(void **state)
{
    (void)state;
    static const struct {
        small_light_t light;
        effect_kind_t kind;
    } cases[] = {{SMALL_LIGHT_AREA, EFFECT_AREA_LIGHTS},       {SMALL_LIGHT_CONSTANT, EFFECT_ENVIRONMENT},
                 {SMALL_LIGHT_POINT, EFFECT_POINT_LIGHTS},     {SMALL_LIGHT_SPOT, EFFECT_SPOT_LIGHTS},
                 {SMALL_LIGHT_DISTANT, EFFECT_DISTANT_LIGHTS}, {SMALL_LIGHT_NONE, EFFECT_COUNT}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        small_scene_t small;
        effects_t effects;
        const settings_t s = settings_of(SETTINGS_RJMLT);
        small_scene_box(&small, cases[i].light);
        effects_analyse(&effects, &small.scene, &s);
        for (int kind = EFFECT_AREA_LIGHTS; kind <= EFFECT_ENVIRONMENT; kind++)
            assert_int_equal(effects.list[kind].present, kind == (int)cases[i].kind);
        assert_true(effects.list[EFFECT_CAUSTICS].present);
        small_scene_clear(&small);
    }
}

static void what_nothing_refers_to_is_absent(void **state)
{
    (void)state;
    char before[1024];
    small_scene_t small;
    small_scene_diffuse(&small);
    snprintf(before, sizeof before, "%s", present(&small.scene));
    const scene_material_t glass = small_material(SCENE_MATERIAL_DIELECTRIC);
    const scene_light_t dark = {.kind = SCENE_LIGHT_POINT, .image = SCENE_NONE};
    const uint32_t unused = small_add_material(&small, &glass);
    small_add_light(&small, &dark);
    small.scene = scene_builder_view(small.builder);
    assert_string_equal(present(&small.scene), before);
    small_add_sphere(&small, unused, (const float[3]){0, 0, 0}, 0.1f);
    small.scene = scene_builder_view(small.builder);
    assert_non_null(strstr(present(&small.scene), "specular_transmission caustics "));
    assert_null(strstr(before, "specular_transmission"));
    small_scene_clear(&small);
}

static void moves_are_those_of_the_algorithm(void **state)
{
    (void)state;
    static const int expected[SETTINGS_ALGORITHMS] = {[SETTINGS_MMLT] = EFFECT_TECHNIQUE_STEPS,
                                                      [SETTINGS_RJMLT] = EFFECT_JUMPS,
                                                      [SETTINGS_CMLT] = EFFECT_JUMPS,
                                                      [SETTINGS_CMLT_REX] = EFFECT_EXCHANGES,
                                                      [SETTINGS_CMLT_IPSM] = EFFECT_INVERSE_STEPS};
    small_scene_t small;
    small_scene_diffuse(&small);
    for (int a = 0; a < SETTINGS_ALGORITHMS; a++) {
        effects_t effects;
        settings_t s = settings_of((settings_algorithm_t)a);
        s.technique_step = s.jump_step = 0.1;
        effects_analyse(&effects, &small.scene, &s);
        for (int kind = EFFECT_TECHNIQUE_STEPS; kind <= EFFECT_INVERSE_STEPS; kind++)
            assert_int_equal(effects.list[kind].present, kind == expected[a]);
        assert_false(effects.list[EFFECT_LENS_HITS].present);
        assert_true(effects.list[EFFECT_INDIRECT].present);
    }
    small_scene_clear(&small);
}

/* What a report says of switches; what insists on something absent is refused with the reason. */
static void switches_are_said_and_checked(void **state)
{
    (void)state;
    static const struct {
        settings_effect_t effect;
        settings_switch_t choice;
        const char *name, *state, *refused; /* null: not refused */
    } cases[] = {{SETTINGS_CAUSTICS, SETTINGS_SWITCH_OFF, "caustics", "forbidden", NULL},
                 {SETTINGS_CAUSTICS, SETTINGS_SWITCH_ON, "caustics", "forced", NULL},
                 {SETTINGS_INDIRECT, SETTINGS_SWITCH_OFF, "indirect", "forbidden", NULL},
                 {SETTINGS_EMISSION, SETTINGS_SWITCH_OFF, "emission", "forbidden", NULL},
                 {SETTINGS_EMISSION, SETTINGS_SWITCH_AUTO, "emission", "present", NULL},
                 {SETTINGS_APERTURE, SETTINGS_SWITCH_OFF, "aperture", "absent", NULL},
                 {SETTINGS_APERTURE, SETTINGS_SWITCH_ON, "aperture", "absent", "effects.aperture: \"on\""},
                 {SETTINGS_ENVIRONMENT, SETTINGS_SWITCH_ON, "environment", "absent", "infinite lights: none"}};
    small_scene_t small;
    small_scene_box(&small, SMALL_LIGHT_AREA);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        effects_t effects;
        fault_t fault = {0};
        settings_t s = settings_of(SETTINGS_BDPT);
        s.effects[cases[i].effect] = (uint8_t)cases[i].choice;
        effects_analyse(&effects, &small.scene, &s);
        json_t *list = effects_json(&effects, NULL);
        const json_t *at = json_first(list);
        while (at && strcmp(json_string(json_get(at, "name")), cases[i].name) != 0)
            at = json_next(at);
        assert_non_null(at);
        assert_string_equal(json_string(json_get(at, "state")), cases[i].state);
        json_destroy(&list);
        const fault_code_t code = effects_check(&small.scene, &s, &fault);
        assert_int_equal(code, cases[i].refused ? FAULT_UNSUPPORTED : FAULT_NONE);
        assert_true(!cases[i].refused || strstr(fault.text, cases[i].refused));
    }
    small_scene_clear(&small);
}

static const json_t *entry_of(const json_t *report, const char *name)
{
    const json_t *at = json_first(json_get(report, "effects"));
    while (at && strcmp(json_string(json_get(at, "name")), name) != 0)
        at = json_next(at);
    assert_non_null(at);
    return at;
}

static double number_of(const json_t *object, const char *name)
{
    const json_t *value = json_get(object, name);
    return value && json_is_number(value) ? json_number(value) : (double)NAN;
}

/* A report of the box, 24 x 24 pixels, lengths to 5; `header`, if not null, gets what the image says. */
static json_t *report_with(const char *effects, char header[256])
{
    char text[512];
    small_scene_t small;
    plan_worker_t worker;
    small_scene_box(&small, SMALL_LIGHT_AREA);
    snprintf(
        text, sizeof text,
        "{'scene':'x','algorithm':'bdpt','max_path_length':5,'seed':'9','film':{'width':24,'height':24},'stop':"
        "{'mutations_per_pixel':200},'effects':{%s}}",
        effects);
    const job_t job = plan_fixture_job(text);
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    plan_fixture_run(plan, &worker, 0);
    json_t *report = plan_report(plan);
    image_t image;
    fault_t fault = {0};
    assert_int_equal(plan_image(plan, &image, &fault), FAULT_NONE);
    const char *said = image_attribute(&image, "garland.left_out");
    snprintf(header, 256, "%s", said ? said : "");
    image_clear(&image);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    small_scene_clear(&small);
    return report;
}

static double light_of(const json_t *report, double *variance)
{
    double light = 0, error = 0; /* of the same samples: errors add up at most */
    for (const json_t *at = json_first(json_get(report, "lengths")); at; at = json_next(at)) {
        light += number_of(json_get(at, "b"), "value");
        error += number_of(json_get(at, "b"), "standard_error");
    }
    *variance = error * error;
    return light;
}

/* Two renders differ by the energy that the report of one gives what it lacks, at 4.5 standard errors; two of them:
 * 1.4e-5 of false alarm, were the sums normal. */
static void reports_say_what_is_missing(void **state)
{
    (void)state;
    char header[256];
    double variance, less;
    json_t *all = report_with("", header);
    assert_null(json_get(all, "left_out"));
    assert_int_equal(header[0], 0);
    assert_true(isnan(number_of(entry_of(all, "caustics"), "energy")));
    const double light = light_of(all, &variance);
    static const char *const effects[] = {"caustics", "indirect"};
    for (size_t i = 0; i < 2; i++) {
        char text[64];
        snprintf(text, sizeof text, "'%s':'off'", effects[i]);
        json_t *report = report_with(text, header);
        const json_t *entry = entry_of(report, effects[i]);
        assert_string_equal(json_string(json_get(entry, "state")), "forbidden");
        const double energy = number_of(entry, "energy"), error = number_of(entry, "energy_error"),
                     rest = light_of(report, &less), lacks = 1 - rest / light,
                     ratio = rest / light * sqrt(variance / (light * light) + less / (rest * rest));
        assert_true(energy > 0 && energy < 1 && error > 0);
        if (!(fabs(energy - lacks) < 4.5 * hypot(error, ratio)))
            fail_msg("%s: energy %g +- %g, but images differ by %g +- %g", effects[i], energy, error, lacks, ratio);
        assert_true(number_of(json_get(report, "left_out"), "energy") == energy);
        assert_true(strncmp(header, effects[i], strlen(effects[i])) == 0 && strstr(header, " +- "));
        json_destroy(&report);
    }
    json_destroy(&all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scenes_have_what_they_say),   cmocka_unit_test(lights_are_told_apart),
        cmocka_unit_test(what_nothing_refers_to_is_absent), cmocka_unit_test(moves_are_those_of_the_algorithm),
        cmocka_unit_test(switches_are_said_and_checked),    cmocka_unit_test(reports_say_what_is_missing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
