/* Shorter chains where chains get stuck: that they come, what a stay can then be, that the image stays the right
 * one, the same to the bit in any order and over restarts, and untouched where nothing is stuck.
 *
 * The linker sends all calls of stuck_is here (--wrap): where `always` is set every stay that is long enough to be
 * asked about is called stuck, so that chains become shorter in short renders too. */
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
#include "support/sanitized.h"
#include "transport/agreement.h"
#include "transport/load.h"

static bool always;

bool __real_stuck_is(uint64_t stay, uint64_t accepted, uint64_t steps);
bool __wrap_stuck_is(uint64_t stay, uint64_t accepted, uint64_t steps);

bool __wrap_stuck_is(uint64_t stay, uint64_t accepted, uint64_t steps)
{
    return always || __real_stuck_is(stay, accepted, steps);
}

static uint64_t counter;

static uint64_t draw(uint64_t below)
{
    return random_u64(random_key(1789, RANDOM_PURPOSE_TEST, 3, 0), counter++) % below;
}

static job_t job_of(const char *algorithm, const char *chains, double per_pixel, int seed)
{
    char text[256];
    snprintf(text, sizeof text,
             "{'scene':'x','algorithm':'%s','max_path_length':5,'seed':%d,'chains':{%s},"
             "'stop':{'mutations_per_pixel':%g}}",
             algorithm, seed, chains, per_pixel);
    return plan_fixture_job(text);
}

/* ---- shorter, and what a stay can be ---- */

/* By length, of the first and of the last unit: mutations of a chain; the most rejections in a row of units whose
 * chains are as short as the last. */
typedef struct lengths {
    double first[6], last[6], stay[6];
} lengths_t;

static void note_unit(lengths_t *lengths, const work_record_t *record, const work_result_t *result)
{
    const double chain = (double)record->mutations / (double)record->count;
    const uint32_t k = record->length;
    if (lengths->first[k] == 0 || chain > lengths->first[k])
        lengths->first[k] = chain;
    if (chain < 0.5 * lengths->last[k])
        lengths->stay[k] = 0;
    lengths->last[k] = chain;
    lengths->stay[k] = fmax(lengths->stay[k], (double)result->stats.longest_stay);
    assert_true((double)result->stats.longest_stay <= ceil(chain));
}

static plan_t *run_noting(const job_t *job, const scene_t *scene, lengths_t *lengths)
{
    const atomic_bool cancel = false;
    plan_worker_t worker;
    plan_worker_make(&worker, job, scene);
    plan_t *plan = plan_fixture_new(job, scene);
    *lengths = (lengths_t){{0}, {0}, {0}};
    while (!plan_finished(plan)) {
        const work_record_t *record;
        work_result_t result;
        uint64_t unit;
        uint8_t *data;
        size_t size;
        plan_absorbed_t how;
        fault_t fault = {0};
        if (plan_next(plan, &unit, &record)) {
            if (work_run(worker.space, record, &cancel, &result, &fault) ||
                work_result_encode(&result, &data, &size, &fault))
                fail_msg("%s", fault.text);
            if (record->kind == WORK_CHAINS)
                note_unit(lengths, record, &result);
            if (plan_absorb(plan, unit, data, size, &how, &fault))
                fail_msg("%s", fault.text);
            free(data);
        }
        plan_check_stop(plan, 0.25);
    }
    plan_worker_clear(&worker);
    return plan;
}

/* As the rule has it, on the scene that provokes it (under the sanitizers in a shorter render, where any stay is).
 * Where the job says how long chains are nothing is done, and a stay may be a large part of the longest of them;
 * where not, later chains are at least four times shorter, and no stay of theirs is longer than they are. */
static void stuck_chains_become_shorter(void **state)
{
    (void)state;
    lengths_t fixed, shorter;
    const scene_t *scene = load_scene("stuck");
    const double per_pixel = SANITIZED ? 400 : 4000;
    const job_t as_said = job_of("mmlt", "'length':16384", per_pixel, 4),
                free_to = job_of("mmlt", "", per_pixel, 4);
    always = SANITIZED;
    plan_t *plan = run_noting(&as_said, scene, &fixed);
    json_t *stuck = plan_stuck_json(plan);
    assert_int_equal(json_size(json_get(stuck, "shortened")), 0);
    const double before = json_number(json_get(stuck, "bound"));
    assert_true(before > 0 && before < 1);
    json_destroy(&stuck);
    plan_destroy(&plan);

    plan = run_noting(&free_to, scene, &shorter);
    stuck = plan_stuck_json(plan);
    const json_t *list = json_get(stuck, "shortened");
    assert_true(json_size(list) > 0);
    const double bound = json_number(json_get(stuck, "bound"));
    print_message("largest share of a chain: %.4f, %.4f with chains that become shorter\n", before, bound);
    assert_true(bound > 0 && bound < 1);
    for (const json_t *at = json_first(list); at; at = json_next(at)) {
        const uint32_t k = (uint32_t)json_number(json_get(at, "length"));
        const double from = json_number(json_get(at, "from")), to = json_number(json_get(at, "to"));
        print_message("length %u: chains of %.0f, then of %.0f; stays of %.0f at most\n", k, shorter.first[k],
                      shorter.last[k], shorter.stay[k]);
        assert_true(k >= 2 && k <= 5 && to >= 256 && 4 * to <= from);
        assert_true(shorter.first[k] <= from + 1 && shorter.last[k] <= 1.5 * to);
        assert_true(shorter.stay[k] <= ceil(shorter.last[k] * 1.5));
        assert_true(4 * shorter.last[k] <= fixed.last[k]); /* what one chain is of the image */
    }
    json_destroy(&stuck);
    plan_destroy(&plan);
    load_clear();
    always = false;
}

/* ---- the same bits ---- */

/* The image, and of how many lengths chains became shorter. */
static size_t render(const job_t *job, const scene_t *scene, image_t *image)
{
    fault_t fault = {0};
    plan_worker_t worker;
    plan_worker_make(&worker, job, scene);
    plan_t *plan = plan_fixture_new(job, scene);
    plan_fixture_run(plan, &worker, 0.25);
    if (plan_image(plan, image, &fault))
        fail_msg("%s", fault.text);
    json_t *list = plan_shorten_json(plan);
    const size_t shorter = json_size(list);
    json_destroy(&list);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    return shorter;
}

static void assert_same_bits(const image_t *a, const image_t *b)
{
    assert_int_equal(a->channel_count, b->channel_count);
    assert_memory_equal(a->data, b->data, sizeof(float) * a->channel_count * a->width * a->height);
}

/* Chains of the usual length, whether the job says so or not. */
static void where_nothing_is_stuck_nothing_changes(void **state)
{
    (void)state;
    static const char *const algorithms[] = {"mmlt", "pssmlt"};
    for (int a = 0; a < 2; a++) {
        const job_t usual = job_of(algorithms[a], "", 150, 4),
                    said = job_of(algorithms[a], "'length':16384", 150, 4);
        image_t x, y;
        const scene_t *scene = load_scene("diffuse");
        render(&usual, scene, &x);
        render(&said, scene, &y);
        assert_same_bits(&x, &y);
        image_clear(&x);
        image_clear(&y);
    }
    load_clear();
}

enum { FLIGHT = 48 };

typedef struct result {
    uint64_t unit;
    uint8_t *data;
    size_t size;
} result_t;

/* The master dies and is restarted from its checkpoint, and half of the results on their way are lost. */
static void restart(plan_t **plan, const job_t *job, const scene_t *scene, result_t *flight, int *count)
{
    uint8_t *data, *again;
    size_t size, again_size;
    fault_t fault = {0};
    if (plan_save(*plan, &data, &size, &fault))
        fail_msg("%s", fault.text);
    plan_destroy(plan);
    if (plan_restore(plan, job, scene, data, size, &fault) || plan_save(*plan, &again, &again_size, &fault))
        fail_msg("%s", fault.text);
    assert_int_equal(size, again_size);
    assert_memory_equal(data, again, size);
    free(data);
    free(again);
    for (int i = *count; i-- > 0;)
        if (draw(2)) {
            free(flight[i].data);
            flight[i] = flight[--*count];
        }
}

/* Results come in any order; plan_next has none where chains wait for what their lengths depend on. */
static plan_t *run_wildly(const job_t *job, const scene_t *scene, plan_worker_t *worker, int *waits)
{
    result_t flight[FLIGHT];
    int count = 0;
    plan_t *plan = plan_fixture_new(job, scene);
    while (!plan_finished(plan)) {
        const work_record_t *record;
        uint64_t unit;
        if (draw(40) == 0)
            restart(&plan, job, scene, flight, &count);
        if (count < FLIGHT && draw(4) > 0) {
            if (plan_next(plan, &unit, &record)) {
                flight[count].unit = unit;
                flight[count].data = plan_worker_run(worker, record, &flight[count].size);
                count++;
                continue;
            }
            *waits += plan->phase == PLAN_RENDER && !plan_shorten_ready(plan);
        }
        if (count > 0) {
            const int i = (int)draw((uint64_t)count);
            plan_absorbed_t how;
            fault_t fault = {0};
            if (plan_absorb(plan, flight[i].unit, flight[i].data, flight[i].size, &how, &fault))
                fail_msg("%s", fault.text);
            free(flight[i].data);
            flight[i] = flight[--count];
        }
        plan_check_stop(plan, 1);
    }
    for (int i = 0; i < count; i++)
        free(flight[i].data);
    return plan;
}

/* The first seed with which chains become shorter, and its image in order. */
static job_t job_that_shortens(const char *algorithm, const char *chains, double per_pixel, const scene_t *scene,
                               image_t *image)
{
    for (int seed = 1; seed <= 20; seed++) {
        const job_t job = job_of(algorithm, chains, per_pixel, seed);
        if (render(&job, scene, image) > 0)
            return job;
        image_clear(image);
    }
    fail_msg("%s: chains of no length become shorter", algorithm);
    return (job_t){0};
}

/* With shares that are frozen, chains of all lengths, and in eras with samples beside chains. */
static void order_and_restarts_leave_no_trace(void **state)
{
    (void)state;
    static const struct {
        const char *algorithm, *chains;
        double per_pixel;
        bool eras;
    } courses[] = {{"mmlt", "", 120, false},
                   {"cmlt-rex", "", 120, false},
                   {"pssmlt", "", 100, false},
                   {"rjmlt", "'shift':true,'split':200,'equalize':1", 1500, true}};
    int waits = 0;
    always = true;
    for (size_t i = 0; i < sizeof courses / sizeof *courses; i++) {
        const scene_t *scene = load_scene("stuck");
        image_t expected, image;
        fault_t fault = {0};
        plan_worker_t worker;
        const job_t job =
            job_that_shortens(courses[i].algorithm, courses[i].chains, courses[i].per_pixel, scene, &expected);
        plan_worker_make(&worker, &job, scene);
        plan_t *plan = run_wildly(&job, scene, &worker, &waits);
        assert_true((plan->eras.count > 1) == courses[i].eras);
        if (plan_image(plan, &image, &fault))
            fail_msg("%s", fault.text);
        assert_same_bits(&image, &expected);
        image_clear(&image);
        image_clear(&expected);
        plan_destroy(&plan);
        plan_worker_clear(&worker);
    }
    always = false;
    load_clear();
    assert_true(waits > 0);
}

/* ---- the right image ---- */

/* Chains that become shorter as soon as may be, against independent samples: means of 16 blocks and of the image
 * over 24 seeds by t scores, a false alarm in 1e-6 of all runs. Half of all runs see what is printed. */
static void the_image_is_that_of_independent_samples(void **state)
{
    (void)state;
    if (SANITIZED)
        skip();
    enum { SEEDS = 24 };
    static const char *const algorithms[] = {"mmlt", "pssmlt"};
    const double alarm = 1e-6 / (2 * 2 * AGREEMENT_REGIONS);
    const scene_t *scene = load_scene("stuck");
    regions_t bdpt, other;
    agreement_run(scene, "bdpt", "", 5, 60, SEEDS, NULL, &bdpt);
    always = true;
    for (int a = 0; a < 2; a++) {
        agreement_run(scene, algorithms[a], "", 5, a ? 100 : 400, SEEDS, NULL, &other);
        agreement_compare("stuck", algorithms[a], &other, &bdpt, alarm);
    }
    always = false;
    load_clear();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stuck_chains_become_shorter),
        cmocka_unit_test(where_nothing_is_stuck_nothing_changes),
        cmocka_unit_test(order_and_restarts_leave_no_trace),
        cmocka_unit_test(the_image_is_that_of_independent_samples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
