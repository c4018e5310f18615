/* Jobs that an algorithm cannot do with a scene's techniques are refused before any work, with place and way out;
 * all others are taken. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "plan/plan_fixture.h"

/* A floor and a sphere of one material under a lamp. */
static void make_scene(small_scene_t *small, const scene_material_t *material, small_light_t light)
{
    static const float floor[12] = {-1, -1, 1, 1, -1, 1, 1, -1, -1, -1, -1, -1},
                       lamp[12] = {-0.3f, 0.9f, -0.3f, 0.3f, 0.9f, -0.3f, 0.3f, 0.9f, 0.3f, -0.3f, 0.9f, 0.3f},
                       centre[3] = {0, -0.5f, 0};
    const scene_light_t area = {.kind = SCENE_LIGHT_AREA,
                                .radiance = {5, 5, 5},
                                .image = SCENE_NONE,
                                .direction = {0, 0, 1}},
                        point = {.kind = SCENE_LIGHT_POINT,
                                 .radiance = {5, 5, 5},
                                 .image = SCENE_NONE,
                                 .position = {0, 0.9f, 0},
                                 .direction = {0, 0, 1}};
    small_scene_begin(small);
    const uint32_t used = small_add_material(small, material),
                   lit = small_add_light(small, light == SMALL_LIGHT_AREA ? &area : &point);
    small_add_quads(small, used, SCENE_NONE, floor, 1);
    small_add_sphere(small, used, centre, 0.4f);
    if (light == SMALL_LIGHT_AREA)
        small_add_quads(small, used, (int32_t)lit, lamp, 1);
    small_set_camera(small, 0, 0, 3, 0.5);
    small_scene_finish(small);
}

/* A conductor of this roughness: 0 mirrors. */
static void make_metal(small_scene_t *small, float alpha, small_light_t light)
{
    scene_material_t metal = small_material(SCENE_MATERIAL_CONDUCTOR);
    for (int c = 0; c < 3; c++)
        metal.eta[c] = 0.2f, metal.k[c] = 3;
    metal.alpha_u.value[0] = metal.alpha_v.value[0] = alpha;
    make_scene(small, &metal, light);
}

/* What a plan says of the job, "" if it is taken. */
static const char *verdict(const small_scene_t *small, const char *algorithm, int length, const char *more,
                           fault_code_t *code)
{
    static char text[FAULT_TEXT_SIZE];
    char job_text[512];
    snprintf(job_text, sizeof job_text,
             "{'scene':'x','algorithm':'%s','max_path_length':%d,'stop':{'mutations_per_pixel':20}%s}", algorithm,
             length, more);
    const job_t job = plan_fixture_job(job_text);
    plan_t *plan = NULL;
    fault_t fault = {0};
    *code = plan_new(&plan, &job, &small->scene, &fault);
    assert_true((plan == NULL) == (*code != FAULT_NONE));
    plan_destroy(&plan);
    snprintf(text, sizeof text, "%s", *code ? fault.text : "");
    return text;
}

static void expect(const small_scene_t *small, const char *algorithm, int length, const char *more,
                   fault_code_t expected, const char *words)
{
    fault_code_t code;
    const char *text = verdict(small, algorithm, length, more, &code);
    if (code != expected || (words && !strstr(text, words)))
        fail_msg("%s, lengths to %d%s: %d, \"%s\"; expected %d, \"%s\"", algorithm, length, more, code, text,
                 expected, words ? words : "");
}

static void mirrors_alone_leave_nothing_to_move_between(void **state)
{
    (void)state;
    small_scene_t small;
    make_metal(&small, 0, SMALL_LIGHT_AREA);
    static const char *const movers[] = {"rjmlt", "cmlt", "cmlt-rex", "cmlt-ipsm"}, *const others[] = {
                                                                                        "mmlt",       "pssmlt",
                                                                                        "pssmlt-mix", "bdpt",
                                                                                        "pt",         "auto"};
    for (size_t i = 0; i < sizeof movers / sizeof *movers; i++) {
        char words[128];
        snprintf(words, sizeof words, "algorithm: \"%s\" moves between the techniques of a path, but here every",
                 movers[i]);
        expect(&small, movers[i], 5, "", FAULT_UNSUPPORTED, words);
        expect(&small, movers[i], 5, "", FAULT_UNSUPPORTED, "expected \"mmlt\"");
        expect(&small, movers[i], 1, "", FAULT_NONE, NULL); /* a lamp that is seen has two */
    }
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        expect(&small, others[i], 5, "", FAULT_NONE, NULL);
    expect(&small, "rjmlt", 5, ",'chains':{'jump_step':0}", FAULT_NONE, NULL); /* no jumps are asked for */
    small_scene_clear(&small);
}

static void one_surface_that_is_not_a_mirror_is_enough(void **state)
{
    (void)state;
    small_scene_t small;
    make_metal(&small, 0.1f, SMALL_LIGHT_AREA);
    expect(&small, "rjmlt", 5, "", FAULT_NONE, NULL);
    expect(&small, "cmlt-ipsm", 2, "", FAULT_NONE, NULL);
    small_scene_clear(&small);
    small_scene_box(&small, SMALL_LIGHT_POINT); /* mirrors beside walls */
    expect(&small, "cmlt-rex", 5, "", FAULT_NONE, NULL);
    small_scene_clear(&small);
}

static void jobs_without_any_technique_are_refused(void **state)
{
    (void)state;
    small_scene_t small;
    make_metal(&small, 0, SMALL_LIGHT_POINT);
    expect(&small, "auto", 5, "", FAULT_NO_LIGHT, "scene: every surface is specular");
    small_scene_clear(&small);
    small_scene_box(&small, SMALL_LIGHT_POINT);
    expect(&small, "bdpt", 1, "", FAULT_NO_LIGHT, "max_path_length: 1, but no light has an extent");
    expect(&small, "bdpt", 2, "", FAULT_NONE, NULL);
    small_scene_clear(&small);
    small_scene_box(&small, SMALL_LIGHT_AREA);
    expect(&small, "mmlt", 1, ",'effects':{'emission':'off'}", FAULT_NO_LIGHT, "effects.emission is \"off\"");
    expect(&small, "mmlt", 1, "", FAULT_NONE, NULL);
    small_scene_clear(&small);
}

/* A job that is taken by "auto" stays so as canonical text, by which others know it. */
static void automatic_jobs_stay_automatic(void **state)
{
    (void)state;
    const job_t job = plan_fixture_job("{'scene':'x'}"),
                named = plan_fixture_job("{'scene':'x','algorithm':'rjmlt'}");
    assert_true(job.automatic && !named.automatic);
    char *text = job_print(&job);
    job_t again;
    fault_t fault = {0};
    assert_int_equal(job_parse(&again, text, strlen(text), "job", &fault), FAULT_NONE);
    assert_true(again.automatic && again.settings.algorithm == job.settings.algorithm);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mirrors_alone_leave_nothing_to_move_between),
        cmocka_unit_test(one_surface_that_is_not_a_mirror_is_enough),
        cmocka_unit_test(jobs_without_any_technique_are_refused),
        cmocka_unit_test(automatic_jobs_stay_automatic),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
