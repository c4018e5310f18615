/* How long chains are: seeds by their definition, as many chains as a length has of them, what one is then of the
 * image, that the image stays the right one, and the same to the bit in any order and over restarts. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "plan/plan_fixture.h"
#include "plan/plan_state.h"
#include "plan/plan_stuck.h"
#include "support/sanitized.h"
#include "transport/agreement.h"
#include "transport/load.h"

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

/* ---- seeds ---- */

/* Of the variance by where chains begin, what is not seen over what is. */
static double unseen(const double *parts, uint64_t count, double chains)
{
    double sum = 0;
    for (uint64_t i = 0; i < count; i++)
        sum += parts[i] * fmax(chains * parts[i] - 1, 0);
    return sum;
}

static double seeds_of(double *parts, uint64_t count)
{
    static double sums[1000];
    double all = 0;
    for (uint64_t i = 0; i < count; i++)
        sums[i] = all += parts[i];
    for (uint64_t i = 0; i < count; i++)
        parts[i] /= all;
    return plan_shorten_seeds(sums, count);
}

/* Heavy-tailed weights (u^-a, some of them zero): as many chains as leave a tenth unseen, and with a quarter more
 * of them it would be more. */
static void seeds_leave_a_tenth_unseen(void **state)
{
    (void)state;
    static double parts[1000];
    for (int i = 0; i < 200; i++) {
        const uint64_t count = 1 + draw(1000);
        const double tail = (double)(i % 10) / 4;
        for (uint64_t j = 0; j < count; j++)
            parts[j] = j > 0 && draw(4) == 0 ? 0 : pow((double)(1 + draw(1 << 20)) * 0x1p-20, -tail);
        const double seeds = seeds_of(parts, count);
        assert_true(seeds >= 1 && seeds <= 1.1 * (1 + 1e-9) * (double)count);
        assert_true(unseen(parts, count, seeds) <= 0.1 * (1 + 1e-9));
        assert_true(unseen(parts, count, 1.25 * seeds) > 0.1);
    }
}

/* Closed forms: candidates that are alike, one that has half of all, one alone, none with light. */
static void seeds_of_a_few(void **state)
{
    (void)state;
    double parts[1000];
    for (int i = 0; i < 1000; i++)
        parts[i] = 3;
    assert_in_range((uint64_t)seeds_of(parts, 1000), 880, 1100); /* 1.1 of them, or a quarter less */
    parts[17] = 999 * parts[0];
    const double seeds = seeds_of(parts, 1000);
    assert_true(seeds <= 2.4 && seeds > 2.4 / 1.25); /* (n / 2 - 1) / 2 = 0.1 */
    parts[0] = 1e-300;
    assert_true(seeds_of(parts, 1) >= 1 && seeds_of(parts, 1) <= 1.1);
    const double zero[2] = {0, 0};
    assert_true(plan_shorten_seeds(zero, 2) == 0);
}

/* ---- lengths, and what a stay can be ---- */

/* By length: chains and mutations of all units; mutations of the longest chain; the most rejections in a row. */
typedef struct lengths {
    uint64_t chains[6], mutations[6], units[6];
    double longest[6], stay[6];
} lengths_t;

static void note_unit(lengths_t *lengths, const work_record_t *record)
{
    const double chain = ceil((double)record->mutations / (double)record->count);
    const uint32_t k = record->length;
    lengths->units[k]++;
    lengths->chains[k] += record->count;
    lengths->mutations[k] += record->mutations;
    lengths->longest[k] = fmax(lengths->longest[k], chain);
}

static plan_t *run_noting(const job_t *job, const scene_t *scene, lengths_t *lengths)
{
    const atomic_bool cancel = false;
    plan_worker_t worker;
    plan_worker_make(&worker, job, scene);
    plan_t *plan = plan_fixture_new(job, scene);
    *lengths = (lengths_t){.chains = {0}};
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
            if (record->kind == WORK_CHAINS) {
                note_unit(lengths, record);
                lengths->stay[record->length] =
                    fmax(lengths->stay[record->length], (double)result.stats.longest_stay);
            }
            if (plan_absorb(plan, unit, data, size, &how, &fault))
                fail_msg("%s", fault.text);
            free(data);
        }
        plan_check_stop(plan, 0.25);
    }
    plan_worker_clear(&worker);
    return plan;
}

static double bound_of(const plan_t *plan, uint32_t *shorter)
{
    json_t *stuck = plan_stuck_json(plan);
    const double bound = json_number(json_get(stuck, "bound"));
    *shorter = (uint32_t)json_size(json_get(stuck, "shortened"));
    json_destroy(&stuck);
    return bound;
}

/* On the scene that provokes stuck chains. Where the job says how long chains are one may have a large part of
 * their length's mutations, and so may a stay. Where not each has a part of about one in as many as there are
 * seeds, from the first on, or of 256 mutations, and no stay is longer. */
static void no_chain_is_much_of_the_image(void **state)
{
    (void)state;
    lengths_t said, short_ones;
    uint32_t shorter;
    const scene_t *scene = load_scene("stuck");
    const double per_pixel = SANITIZED ? 400 : 4000;
    const job_t as_said = job_of("mmlt", "'length':16384", per_pixel, 4),
                free_to = job_of("mmlt", "", per_pixel, 4);
    plan_t *plan = run_noting(&as_said, scene, &said);
    const double before = bound_of(plan, &shorter);
    assert_int_equal(shorter, 0);
    plan_destroy(&plan);

    plan = run_noting(&free_to, scene, &short_ones);
    const double after = bound_of(plan, &shorter);
    print_message("largest share of a chain of the image: %.5f of 16384 mutations, %.5f of short ones\n", before,
                  after);
    assert_true(shorter > 0);
    for (uint32_t k = 1; k <= 5; k++) {
        const double seeds = plan->shorten.seeds[k], mutations = (double)short_ones.mutations[k],
                     share = fmax(256, mutations / seeds);
        print_message("length %u: %.0f seeds, %.0f chains, the longest of %.0f for %.0f, a stay of %.0f for %.0f\n",
                      k, seeds, (double)short_ones.chains[k], short_ones.longest[k], said.longest[k],
                      short_ones.stay[k], said.stay[k]);
        assert_true(seeds >= 1 && mutations > 0);
        assert_true((double)short_ones.chains[k] <= seeds + (double)short_ones.units[k]); /* each rounds them */
        if (!SANITIZED && seeds > 4 * (double)short_ones.units[k])
            assert_true(short_ones.longest[k] <= 2 * share);
        assert_true(short_ones.stay[k] <= short_ones.longest[k]);
        assert_true(plan->shorten.largest[k] <= short_ones.longest[k]);
        assert_true(plan_shorten_bound(plan, k) <= short_ones.longest[k] / mutations);
    }
    assert_true(SANITIZED || (before > 0 && after > 0 && 2 * after < before));
    plan_destroy(&plan);
    load_clear();
}

/* Where the rule does not say how many mutations there will be: never more chains than seeds until they are as long
 * as is usual, none more than five over the seeds of all that its length has had by then, and nothing is waited
 * for. */
static void chains_grow_without_an_end(void **state)
{
    (void)state;
    lengths_t lengths = {.chains = {0}};
    const job_t job = plan_fixture_job("{'scene':'x','algorithm':'mmlt','max_path_length':5,'seed':4,"
                                       "'chains':{'pilot_samples':16384},'stop':{'error':1e-6}}");
    const scene_t *scene = load_scene("stuck");
    plan_worker_t worker;
    plan_worker_make(&worker, &job, scene);
    plan_t *plan = plan_fixture_new(&job, scene);
    while (plan->phase != PLAN_RENDER)
        assert_true(plan_fixture_step(plan, &worker));
    uint32_t usual = 0;
    for (int i = 0; i < 1200; i++) {
        const work_record_t *record;
        uint64_t unit;
        assert_true(plan_next(plan, &unit, &record));
        if (record->kind != WORK_CHAINS)
            continue;
        const uint32_t k = record->length;
        const double chain = (double)record->mutations / (double)record->count, seeds = plan->shorten.seeds[k];
        note_unit(&lengths, record);
        usual += chain > 12000;
        assert_true(chain <= 1.5 * 16384 && chain > 200);
        assert_true(chain > 12000 || (double)lengths.chains[k] <= seeds + (double)lengths.units[k]);
        if (chain > 300 && chain < 12000)
            assert_true(chain <=
                        1.5 * fmax(5 * (double)lengths.mutations[k], (double)record->mutations * 8) / seeds);
    }
    assert_true(usual > 0);
    for (uint32_t k = 2; k <= 4; k++)
        assert_true((double)lengths.chains[k] > 0.5 * plan->shorten.seeds[k]);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    load_clear();
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

/* Results come in any order. */
static plan_t *run_wildly(const job_t *job, const scene_t *scene, plan_worker_t *worker)
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

/* With shares that are frozen, chains of all lengths, and in eras with samples beside chains. */
static void order_and_restarts_leave_no_trace(void **state)
{
    (void)state;
    static const struct {
        const char *algorithm, *chains;
        double per_pixel;
        bool eras;
    } courses[] = {{"mmlt", "", 1000, false},
                   {"cmlt-rex", "", 2000, false},
                   {"pssmlt", "", 300, false},
                   {"rjmlt", "'shift':true,'split':5,'equalize':1", 4000, true}};
    for (size_t i = 0; i < sizeof courses / sizeof *courses; i++) {
        const scene_t *scene = load_scene("stuck");
        image_t expected, image;
        fault_t fault = {0};
        plan_worker_t worker;
        const job_t job = job_of(courses[i].algorithm, courses[i].chains, courses[i].per_pixel, 1);
        assert_true(render(&job, scene, &expected) > 0);
        plan_worker_make(&worker, &job, scene);
        plan_t *plan = run_wildly(&job, scene, &worker);
        assert_true((plan->eras.count > 1) == courses[i].eras);
        if (plan_image(plan, &image, &fault))
            fail_msg("%s", fault.text);
        assert_same_bits(&image, &expected);
        image_clear(&image);
        image_clear(&expected);
        plan_destroy(&plan);
        plan_worker_clear(&worker);
    }
    load_clear();
}

/* ---- the right image ---- */

/* Many short chains against independent samples: means of 16 blocks and of the image
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
    for (int a = 0; a < 2; a++) {
        agreement_run(scene, algorithms[a], "", 5, a ? 100 : 400, SEEDS, NULL, &other);
        agreement_compare("stuck", algorithms[a], &other, &bdpt, alarm);
    }
    load_clear();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(seeds_leave_a_tenth_unseen),
        cmocka_unit_test(seeds_of_a_few),
        cmocka_unit_test(no_chain_is_much_of_the_image),
        cmocka_unit_test(chains_grow_without_an_end),
        cmocka_unit_test(order_and_restarts_leave_no_trace),
        cmocka_unit_test(the_image_is_that_of_independent_samples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
