/* Upper bounds for the light of lengths: against known laws of what candidates bring, and in shares and reports. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "plan/plan_fixture.h"
#include "plan/plan_missed.h"

static small_scene_t small;

static plan_t *plan_of(void)
{
    const job_t job =
        plan_fixture_job("{'scene':'x','algorithm':'mmlt','max_path_length':5,'chains':{'pilot_samples':"
                         "2000},'stop':{'mutations_per_pixel':20}}");
    return plan_fixture_new(&job, &small.scene);
}

/* Weights of length 1: with probability p one of 1 .. 2, else 0; their mean is 1.5 p. */
static void fill(plan_t *plan, double p, uint64_t trial)
{
    plan_length_t *length = &plan->lengths[1];
    const uint64_t key = random_key(2385, RANDOM_PURPOSE_TEST, 41, trial);
    length->b = 0;
    for (uint64_t i = 0; i < plan->candidates; i++) {
        length->weights[i] = random_double(key, 2 * i) < p ? 1 + random_double(key, 2 * i + 1) : 0;
        length->b += length->weights[i] / (double)plan->candidates;
    }
    plan->lengths[2].weights[0] = 2; /* the most that any brings */
}

/* From lengths that the pilot never meets to those that it meets all the time. The bound is of 95 %: of 1000 trials
 * at most 79 fall short of the truth with probability 1 - 2e-5 (binomial), four of them. */
static void bounds_hold_as_often_as_they_say(void **state)
{
    (void)state;
    static const double rates[] = {0.2, 1, 10, 1000}; /* times N p */
    plan_t *plan = plan_of();
    for (size_t i = 0; i < sizeof rates / sizeof *rates; i++) {
        const double p = rates[i] / (double)plan->candidates;
        int short_of = 0;
        for (uint64_t trial = 0; trial < 1000; trial++) {
            fill(plan, p, trial);
            plan_bound_lengths(plan);
            short_of += !(plan->lengths[1].most >= 1.5 * p);
        }
        print_message("%g hits expected: %d of 1000 bounds fall short\n", rates[i], short_of);
        assert_true(short_of <= 79);
    }
    plan_destroy(&plan);
}

static void shares_beyond_the_last_measurable_length_are_bounded(void **state)
{
    (void)state;
    plan_t *plan = plan_of();
    const double n = (double)plan->candidates;
    for (uint64_t i = 0; i < plan->candidates; i++)
        plan->lengths[2].weights[i] = 1;
    plan->lengths[2].b = 1;
    plan->lengths[3].weights[7] = 1e-3; /* met once */
    plan->lengths[3].b = 1e-3 / n;
    plan_bound_lengths(plan);
    assert_int_equal(plan->measurable, 2);
    assert_true(plan->lengths[2].most == 1 + 3 / n);
    assert_true(fabs(plan->lengths[3].most - (1 + 1.645 + 3) * 1e-3 / n) < 1e-9 / n);
    assert_true(plan->lengths[4].most == 3 / n && plan->lengths[1].most == 3 / n);
    assert_true(plan_least_share(plan, 1, 0.005) == 0.005);
    assert_true(plan_least_share(plan, 2, 0.005) == 0.005);
    assert_true(fabs(plan_least_share(plan, 3, 0.005) * (1 + 1e-3 / n) - plan->lengths[3].most) < 1e-9 / n);
    assert_true(plan_least_share(plan, 4, 1e-4) == 1e-4); /* less than the bound, 1.5e-3 */
    plan_destroy(&plan);
}

/* A length that no technique makes has no chains: the report lists it with its bound. */
static void reports_say_what_may_be_missing(void **state)
{
    (void)state;
    const job_t job = plan_fixture_job("{'scene':'x','algorithm':'mmlt','max_path_length':3,'effects':{'emission':"
                                       "'off'},'stop':{'mutations_per_pixel':20}}");
    plan_worker_t worker;
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    plan_fixture_run(plan, &worker, 0.25);
    json_t *report = plan_report(plan);
    const json_t *missed = json_get(report, "missed"), *lengths = json_get(missed, "lengths");
    assert_true(json_number(json_first(lengths)) == 1);
    assert_null(json_next(json_first(lengths)));
    const double most = json_number(json_get(json_first(json_get(report, "lengths")), "most"));
    double b = 0;
    for (uint32_t k = 1; k <= 3; k++)
        b += plan->lengths[k].b;
    assert_true(most > 0 && fabs(json_number(json_get(missed, "most")) - most / b) < 1e-9);
    json_destroy(&report);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
}

static int setup(void **state)
{
    (void)state;
    small_scene_diffuse(&small);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    small_scene_clear(&small);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_hold_as_often_as_they_say),
        cmocka_unit_test(shares_beyond_the_last_measurable_length_are_bounded),
        cmocka_unit_test(reports_say_what_may_be_missing),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
