/* Techniques of negligible energy: which may leave, that they do, and that the image without them is the one that
 * all of them make. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "agreement.h"
#include "load.h"
#include "render.h"

/* 65536 candidates: the shortest pilot that has a survey. */
#define PILOT ",\"chains\":{\"pilot_samples\":65536}"

static const char *const chains[] = {"auto", "mmlt", "cmlt", "cmlt-ipsm", "pssmlt-mix", "pssmlt"};
enum { SEEDS = 16, LENGTH = 6, CHAINS = sizeof chains / sizeof *chains };

/* False alarms: 1e-6 in a whole run, 17 regions, two sides. */
static const double alarm = 1e-6 / (CHAINS * AGREEMENT_REGIONS * 2);

static void images_are_those_of_all_techniques(void **state)
{
    (void)state;
    const scene_t *scene = load_scene("courtyard");
    pilots_t *pilots = pilots_new();
    regions_t bdpt, other;
    agreement_run(scene, "bdpt", AGREEMENT_SAMPLES, LENGTH, 40, SEEDS, NULL, &bdpt);
    for (int i = 0; i < CHAINS; i++) {
        agreement_run(scene, chains[i], PILOT, LENGTH, 100, SEEDS, pilots, &other);
        agreement_compare("courtyard", chains[i], &other, &bdpt, alarm);
    }
    pilots_destroy(&pilots);
    load_clear();
}

/* Renders a scene; how many techniques are idle in all, and whether s = 0 is among them. */
static int idle_of(const scene_t *scene, const char *more, bool *hit, char state[16])
{
    char text[512];
    render_t render;
    int count = 0;
    snprintf(text, sizeof text,
             "{\"scene\":\"x\",\"film\":{\"width\":16,\"height\":16},\"algorithm\":\"mmlt\",\"max_path_length\":%d,"
             "\"stop\":{\"mutations_per_pixel\":16}%s%s}",
             LENGTH, PILOT, more);
    render_run(&render, scene, text);
    *hit = false;
    for (const json_t *k = json_first(json_get(render.report, "lengths")); k; k = json_next(k)) {
        const json_t *idle = json_get(k, "idle");
        double energy = 0;
        for (const json_t *s = idle ? json_first(idle) : NULL; s; s = json_next(s)) {
            *hit = *hit || json_number(s) == 0;
            const json_t *technique = json_at(json_get(k, "techniques"), (size_t)json_number(s));
            energy += json_number(json_get(technique, "value"));
            count++;
        }
        assert_true(energy == 0); /* what takes no part brings nothing */
    }
    for (const json_t *at = json_first(json_get(render.report, "effects")); at; at = json_next(at))
        if (strcmp(json_string(json_get(at, "name")), "all_techniques") == 0)
            snprintf(state, 16, "%s", json_string(json_get(at, "state")));
    render_clear(&render);
    return count;
}

static void walks_that_do_not_arrive_are_not_made(void **state)
{
    (void)state;
    bool hit;
    char said[16];
    const scene_t *scene = load_scene("courtyard");
    const int count = idle_of(scene, "", &hit, said);
    assert_string_equal(said, "absent");
    assert_false(hit); /* the sky is hit often */
    if (count < 6)     /* those of lengths 2 to 4 with light walks of two vertices and more */
        fail_msg("%d techniques are idle", count);
    assert_int_equal(idle_of(scene, ",\"effects\":{\"all_techniques\":\"on\"}", &hit, said), 0);
    assert_string_equal(said, "forced");
    load_clear();
}

/* A light of 2e-4 of the room's width is never hit. Without specular surfaces other techniques make every path that
 * a hit would; once the ball is a mirror, hits alone make some, however little they bring: they stay. */
static void hits_leave_where_nothing_is_specular(void **state)
{
    (void)state;
    bool hit;
    char said[16];
    scene_t scene = *load_scene("tiny-light");
    scene_material_t materials[16];
    assert_true(scene.material_count <= 16);
    assert_true(idle_of(&scene, "", &hit, said) > 0);
    assert_true(hit);
    assert_string_equal(said, "absent");
    for (uint32_t i = 0; i < scene.material_count; i++) {
        materials[i] = scene.materials[i];
        if (materials[i].kind == SCENE_MATERIAL_CONDUCTOR)
            materials[i].alpha_u.value[0] = materials[i].alpha_v.value[0] = 0;
    }
    scene.materials = materials;
    idle_of(&scene, "", &hit, said);
    assert_false(hit);
    load_clear();
}

/* With mirrors and lights that cannot be hit every technique alone makes some paths. */
static void none_leaves_where_each_is_needed(void **state)
{
    (void)state;
    bool hit;
    char said[16];
    assert_int_equal(idle_of(load_scene("environment"), "", &hit, said), 0);
    assert_string_equal(said, "present");
    load_clear();
}

static void all_techniques_are_not_to_be_forbidden(void **state)
{
    (void)state;
    static const char text[] = "{\"scene\":\"x\",\"effects\":{\"all_techniques\":\"off\"}}";
    job_t job;
    fault_t fault = {0};
    assert_int_equal(job_parse(&job, text, strlen(text), "job", &fault), FAULT_FORMAT);
    assert_non_null(strstr(fault.text, "effects.all_techniques: \"off\", expected \"auto\" or \"on\""));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_are_those_of_all_techniques),
        cmocka_unit_test(walks_that_do_not_arrive_are_not_made),
        cmocka_unit_test(hits_leave_where_nothing_is_specular),
        cmocka_unit_test(none_leaves_where_each_is_needed),
        cmocka_unit_test(all_techniques_are_not_to_be_forbidden),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
