/* Stuck chains: the criterion against stays of known law, scenes with and without them, descriptions as text and as
 * bytes. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "chain/stuck.h"
#include "plan/plan_fixture.h"
#include "plan/plan_state.h"
#include "plan/plan_stuck.h"
#include "transport/load.h"

/* Stays of a chain that accepts with probability p each time, drawn by inversion. */
static uint64_t geometric(double p, uint64_t i)
{
    return (uint64_t)(log1p(-random_double(random_step(1967, i), 0)) / log1p(-p));
}

/* 4 million stays in units of 200, p drawn anew for each unit as the rule supposes (but for 0.2 % at its lower
 * end). At most 4 are expected to be called stuck; more than 20 have a probability below 1e-8 (Poisson). */
static void false_alarms_are_as_rare_as_stated(void **state)
{
    (void)state;
    uint64_t stuck_stays = 0;
    for (uint64_t unit = 0; unit < 20000; unit++) {
        stuck_t stuck = {0};
        const double p = 0.002 + 0.998 * random_double(random_step(1987, unit), 0);
        for (uint64_t i = 0; i < 200; i++)
            stuck_end_stay(&stuck, geometric(p, 200 * unit + i), true);
        stuck_stays += stuck.stays;
    }
    if (stuck_stays > 20)
        fail_msg("%llu of 4e6 stays by chance are called stuck", (unsigned long long)stuck_stays);
}

/* The rule is the probability that it says: for A + 1 = 1 the product telescopes to (N + 1) / (N + 1 + n). */
static void the_criterion_is_the_rule_of_succession(void **state)
{
    (void)state;
    assert_false(stuck_is(99899000, 0, 100)); /* 101 / (101 + n) */
    assert_true(stuck_is(101000000, 0, 100));
    assert_false(stuck_is(63, 1000, 1001));
    assert_false(stuck_is(UINT64_C(1) << 40, 63, 63)); /* too little is known */
    assert_true(stuck_is(64, 500, 1000));
    assert_false(stuck_is(130, 100000, 1000000)); /* 0.9^130 = 1.1e-6 */
    assert_true(stuck_is(133, 100000, 1000000));  /* 0.9^133 = 8.2e-7 */
}

/* The report after a render, which is the same after a checkpoint. Of long chains: short ones are seldom stuck for
 * long enough to be told of (tests/plan/test_shorten.c). */
static json_t *report_of(const char *scene_name, const char *algorithm, double mutations_per_pixel)
{
    char text[256];
    snprintf(text, sizeof text,
             "{'scene':'x','algorithm':'%s','max_path_length':5,'seed':4,'chains':{'length':16384},"
             "'stop':{'mutations_per_pixel':%g}}",
             algorithm, mutations_per_pixel);
    const job_t job = plan_fixture_job(text);
    const scene_t *scene = load_scene(scene_name);
    uint8_t *image = NULL;
    size_t size;
    plan_worker_t worker;
    plan_worker_make(&worker, &job, scene);
    plan_t *plan = plan_fixture_new(&job, scene), *again = NULL;
    plan_fixture_run(plan, &worker, 0.25);
    json_t *report = plan_report(plan);
    fault_t fault = {0};
    if (plan_save(plan, &image, &size, &fault) || plan_restore(&again, &job, scene, image, size, &fault))
        fail_msg("%s", fault.text);
    free(image);
    json_t *restored = plan_report(again);
    const json_t *a = json_get(report, "stuck"), *b = json_get(restored, "stuck");
    assert_true(json_number(json_get(a, "chains")) == json_number(json_get(b, "chains")));
    assert_true(json_number(json_get(a, "weight")) == json_number(json_get(b, "weight")));
    assert_int_equal(json_size(json_get(a, "paths")), json_size(json_get(b, "paths")));
    json_destroy(&restored);
    plan_destroy(&again);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    load_clear();
    return report;
}

static void a_diffuse_room_has_none(void **state)
{
    (void)state;
    static const char *const algorithms[] = {"mmlt", "pssmlt"};
    for (int a = 0; a < 2; a++) {
        json_t *report = report_of("diffuse", algorithms[a], 100);
        const json_t *stuck = json_get(report, "stuck");
        assert_true(json_number(json_get(stuck, "chains")) == 0 && json_number(json_get(stuck, "weight")) == 0);
        assert_int_equal(json_size(json_get(stuck, "paths")), 0);
        json_destroy(&report);
    }
}

static void check_paths(const char *algorithm, double mutations_per_pixel)
{
    json_t *report = report_of("stuck", algorithm, mutations_per_pixel);
    const json_t *stuck = json_get(report, "stuck"), *paths = json_get(stuck, "paths");
    const double chains = json_number(json_get(stuck, "chains")), weight = json_number(json_get(stuck, "weight"));
    if (!(chains > 0 && weight > 0 && weight < 1))
        fail_msg("%g chains with a weight of %g", chains, weight);
    assert_int_equal(json_size(paths), chains < STUCK_PATHS ? (size_t)chains : STUCK_PATHS);
    unsigned long long before = UINT64_MAX;
    for (const json_t *at = json_first(paths); at; at = json_next(at)) {
        unsigned length, technique, x, y;
        unsigned long long stay;
        int read = 0;
        assert_int_equal(sscanf(json_string(at), "length %u, technique %u, pixel (%u, %u), %llu rejections: %n",
                                &length, &technique, &x, &y, &stay, &read),
                         5);
        assert_true(length >= 1 && length <= 5 && technique <= length && x < 24 && y < 24);
        assert_true(stay >= STUCK_LEAST && stay <= before);
        before = stay;
        const char *path = json_string(at) + read;
        unsigned vertices = 1;
        for (const char *c = path; *c; c++)
            vertices += *c == ' ';
        assert_int_equal(vertices, length + 1);
        assert_true(path[0] == 'L' && path[strlen(path) - 1] == 'E');
    }
    /* The longest are at its glass and its mirror. */
    const char *longest = json_string(json_first(paths));
    if (!strpbrk(longest, "GS"))
        fail_msg("stuck longest on diffuse surfaces alone: %s", longest);
    json_destroy(&report);
}

static void paths_that_are_hard_to_leave_are_told_of(void **state)
{
    (void)state;
    check_paths("mmlt", 400);
    check_paths("pssmlt", 100); /* the brightest path of a state */
}

static double image_light(const plan_t *plan)
{
    image_t image;
    fault_t fault = {0};
    double light = 0;
    if (plan_image(plan, &image, &fault))
        fail_msg("%s", fault.text);
    for (size_t p = 0; p < plan->pixels; p++)
        light += rgb_luminance(rgb(image.data[p], image.data[plan->pixels + p], image.data[2 * plan->pixels + p]));
    image_clear(&image);
    return light;
}

/* Were all that chains added to their films stuck, the weight is the chains' share of the image: with importance,
 * and where samples bring the rest. (The image is of floats: 1e-5.) */
static void the_weight_is_of_the_image(void **state)
{
    (void)state;
    const job_t job = plan_fixture_job("{'scene':'x','algorithm':'rjmlt','max_path_length':5,'seed':4,"
                                       "'chains':{'equalize':1,'split':5},'stop':{'mutations_per_pixel':100}}");
    const scene_t *scene = load_scene("stuck");
    plan_worker_t worker;
    plan_worker_make(&worker, &job, scene);
    plan_t *plan = plan_fixture_new(&job, scene);
    plan_fixture_run(plan, &worker, 0.25);
    assert_true(plan->has_importance && plan->has_caps);
    for (uint32_t k = 1; k <= 5; k++) {
        const film_t *film = &plan->lengths[k].film;
        double light = 0;
        for (uint32_t p = 0; film->sums && p < plan->pixels; p++)
            light += rgb_luminance(film_value(film, p % film->width, p / film->width));
        plan->lengths[k].stuck_light = (uint64_t)(light * STUCK_LIGHT_ONE + 0.5);
    }
    json_t *stuck = plan_stuck_json(plan);
    const double weight = json_number(json_get(stuck, "weight")), all = image_light(plan);
    memset(plan->lengths[0].film.sums, 0, sizeof(int64_t) * FILM_CHANNELS * plan->pixels);
    const double expected = image_light(plan) / all;
    if (!(expected > 0.02 && expected < 0.98 && fabs(weight - expected) <= 1e-5))
        fail_msg("%g, expected %g", weight, expected);
    json_destroy(&stuck);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    load_clear();
}

static stuck_path_t some_path(uint64_t i)
{
    stuck_path_t path = {.length = 1 + (uint32_t)(i % 3),
                         .technique = 1,
                         .stay = 64 + i * 7 % 5,
                         .chain = i,
                         .x = 1.5,
                         .y = 2.5,
                         .c = 0.25};
    for (uint32_t v = 0; v + 1 < path.length; v++)
        path.codes[v] = (uint8_t)((i + v) % STUCK_CODES);
    return path;
}

/* Thirty paths, with many ties, added up in units of five from the first or from the last on: the same bytes. */
static void sums_are_free_of_order(void **state)
{
    (void)state;
    stuck_t units[6] = {{0}}, forward = {0}, backward = {0}, back;
    for (uint64_t i = 0; i < 30; i++) {
        const stuck_path_t path = some_path(i);
        units[i / 5].stays++;
        units[i / 5].rejections += path.stay;
        stuck_add_light(&units[i / 5], 0.75 * (double)path.stay);
        stuck_keep(&units[i / 5], &path);
    }
    for (int i = 0; i < 6; i++) {
        stuck_add(&forward, &units[i]);
        stuck_add(&backward, &units[5 - i]);
    }
    assert_int_equal(forward.count, STUCK_PATHS);
    uint8_t bytes[2][2048];
    wire_writer_t out;
    for (int i = 0; i < 2; i++) {
        wire_writer_init(&out, bytes[i], sizeof bytes[i], "stuck", NULL);
        stuck_put(&out, i ? &backward : &forward);
        assert_int_equal(out.code, FAULT_NONE);
    }
    assert_memory_equal(bytes[0], bytes[1], out.at);
    wire_reader_t in;
    wire_reader_init(&in, bytes[0], out.at, "stuck", NULL);
    assert_int_equal(stuck_get(&in, &back, 3), FAULT_NONE);
    assert_int_equal(wire_reader_end(&in), FAULT_NONE);
    assert_true(back.stays == 30 && back.rejections == forward.rejections && back.count == STUCK_PATHS);
    assert_true((double)back.light == 0.75 * (double)back.rejections * STUCK_LIGHT_ONE);
    stuck_add_light(&forward, 1e300);
    stuck_add(&forward, &backward); /* as much as there is room for */
    assert_true(forward.light == UINT64_MAX);
    wire_reader_init(&in, bytes[0], out.at, "stuck", NULL); /* a length too many */
    assert_int_equal(stuck_get(&in, &back, 2), FAULT_RANGE);
    for (size_t size = 0; size < out.at; size++) {
        wire_reader_init(&in, bytes[0], size, "stuck", NULL);
        assert_true(stuck_get(&in, &back, 3) != FAULT_NONE);
    }
}

static void the_longest_path_fits_its_text(void **state)
{
    (void)state;
    stuck_path_t path = {
        .length = STUCK_MAX_INNER + 1, .technique = 127, .stay = UINT64_MAX, .x = 32767, .y = 32767};
    memset(path.codes, STUCK_SPECULAR_THROUGH, sizeof path.codes);
    char text[STUCK_TEXT];
    stuck_print(&path, text);
    assert_string_equal(text + strlen(text) - 8, " St St E");
    path = some_path(2);
    stuck_print(&path, text);
    assert_string_equal(text, "length 3, technique 1, pixel (1, 2), 68 rejections: L S Dt E");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(false_alarms_are_as_rare_as_stated),
        cmocka_unit_test(the_criterion_is_the_rule_of_succession),
        cmocka_unit_test(a_diffuse_room_has_none),
        cmocka_unit_test(paths_that_are_hard_to_leave_are_told_of),
        cmocka_unit_test(the_weight_is_of_the_image),
        cmocka_unit_test(sums_are_free_of_order),
        cmocka_unit_test(the_longest_path_fits_its_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
