/* Which points passes get, and what is measured of them: films are replaced by noise of known kinds. Bounds: 6
 * standard deviations. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/random.h"
#include "chain/net.h"
#include "plan/plan_estimate.h"
#include "plan/plan_fixture.h"
#include "plan/plan_nets.h"
#include "plan/plan_state.h"
#include "support/near.h"

enum { WIDTH = 96, HEIGHT = 64, PIXELS = WIDTH * HEIGHT, NUMBERS = FILM_CHANNELS * PIXELS };

/* Of unit variance, for number i of a pass; passes of a sequence by their points. */
typedef double (*noise_t)(uint32_t sequence, uint64_t point, uint64_t i);

static double uniform(uint64_t kind, uint32_t sequence, uint64_t point, uint64_t i)
{
    const uint64_t key = random_key(sequence, RANDOM_PURPOSE_TEST, kind, point);
    return sqrt(12) * (random_double(key, i) - 0.5);
}

static double independent(uint32_t sequence, uint64_t point, uint64_t i)
{
    return uniform(0, sequence, point, i);
}

/* Half of the variance comes from differences that telescope: of m points in a row it is 1/m of what it would be.
 */
static double half_even(uint32_t sequence, uint64_t point, uint64_t i)
{
    const double even = (uniform(1, sequence, point, i) - uniform(1, sequence, point + 1, i)) / sqrt(2);
    return (uniform(0, sequence, point, i) + even) / sqrt(2);
}

static double half_even_on_the_right(uint32_t sequence, uint64_t point, uint64_t i)
{
    return (i / FILM_CHANNELS % WIDTH < WIDTH / 2 ? independent : half_even)(sequence, point, i);
}

static void absorb_noise(plan_t *plan, plan_worker_t *worker, noise_t noise)
{
    const work_record_t *record;
    const atomic_bool go = false;
    uint64_t unit;
    work_result_t result;
    fault_t fault = {0};
    uint8_t *data;
    size_t size;
    plan_absorbed_t how;
    assert_true(plan_next(plan, &unit, &record));
    assert_int_equal(work_run(worker->space, record, &go, &result, &fault), FAULT_NONE);
    for (uint64_t i = 0; record->kind == WORK_SAMPLES && i < NUMBERS; i++) {
        double value = 0;
        for (uint64_t pass = 0; pass < record->count / PIXELS; pass++)
            value += 1 + 0.2 * noise(record->sequence, record->point + pass, i);
        result.film.sums[i] = (int64_t)llround(FILM_ONE * value);
    }
    assert_int_equal(work_result_encode(&result, &data, &size, &fault), FAULT_NONE);
    assert_int_equal(plan_absorb(plan, unit, data, size, &how, &fault), FAULT_NONE);
    free(data);
}

/* Of so many passes; the caller closes it. */
static void render(plan_render_t *render, noise_t noise, int passes)
{
    char text[200];
    snprintf(text, sizeof text,
             "{'scene':'x','algorithm':'pt','max_path_length':2,'film':{'width':%d,'height':%d},"
             "'stop':{'mutations_per_pixel':%d}}",
             WIDTH, HEIGHT, passes);
    const job_t job = plan_fixture_job(text);
    plan_render_open(render, &job);
    while (!plan_check_stop(render->plan, 1))
        absorb_noise(render->plan, &render->worker, noise);
}

static double mean_of_blocks(const plan_t *plan, uint32_t from)
{
    double sum = 0;
    for (uint32_t b = 0; b < GROUPS_BLOCKS; b++)
        if (b % GROUPS_SIDE >= from && b % GROUPS_SIDE < from + GROUPS_SIDE / 2)
            sum += plan->nets.blocks[b] / (GROUPS_BLOCKS / 2);
    return sum;
}

/* The image's error, by what noise there is: variance a pass, passes, factor; the filter of the estimate takes the
 * image for even, as it is. */
static double error_of(int passes, double factor)
{
    return 0.04 * factor / passes / 1.01;
}

/* `factor`: what is left of independent passes' variance; `unit`: of units', which may be of several points. */
static void check_factor(noise_t noise, int passes, double factor, double unit, double tolerance)
{
    plan_render_t course;
    plan_error_t error;
    render(&course, noise, passes);
    assert_near(course.plan->nets.all * unit, factor, tolerance);
    plan_estimate_error(course.plan, &error);
    assert_near(error.relmse, error_of(passes, factor), 0.1 * error_of(passes, factor));
    plan_render_close(&course);
}

static void factors_are_those_of_the_noise(void **state)
{
    (void)state;
    const double sigma = sqrt(2.0 / NUMBERS), eight = 0.5 + 0.5 / 8, eighty = 0.5 + 0.5 / 80;
    check_factor(independent, 2, 1, 1, 1e-3);
    check_factor(independent, 16, 1, 1, 6 * sigma);
    check_factor(independent, 160, 1, 1, 6 * sigma);
    check_factor(half_even, 16, eight, 1, 0.1 * eight);
    check_factor(half_even, 160, eighty, 2.0 / 3, 0.1 * eighty); /* units of three, which differ by less */
}

/* A block is of 24 pixels here, and has as if 64 more of the image. */
static void blocks_have_their_own(void **state)
{
    (void)state;
    plan_render_t course;
    render(&course, half_even_on_the_right, 16);
    const plan_t *plan = course.plan;
    const double half = 0.5 + 0.5 / 8, all = (1 + half) / 2, own = 24.0 / (24 + 64), sigma = sqrt(2.0 / NUMBERS);
    assert_near(plan->nets.all, all, 6 * sigma);
    assert_near(mean_of_blocks(plan, 0), own + (1 - own) * all, 6 * sigma);
    assert_near(mean_of_blocks(plan, GROUPS_SIDE / 2), own * half + (1 - own) * all, 6 * sigma);
    plan_render_close(&course);
}

static double outlook(plan_render_t *course, double factor)
{
    course->plan->nets.all = factor;
    return plan_nets_outlook(course->plan);
}

/* With 8 points in each sequence, of 64 that a net has: independent passes stay as they are; a part that nets do
 * not help stays, too; what falls faster than n^-0.6 goes on by its own power; and whatever factor noise makes,
 * some of the error is left. */
static void outlooks_go_by_the_factor(void **state)
{
    (void)state;
    plan_render_t course;
    render(&course, independent, 16);
    const double now = pow(8, -0.6), later = pow(NET_POINTS, -0.6), half = 0.5 + 0.5 * now;
    assert_near(outlook(&course, 1), 1, 1e-12);
    assert_near(outlook(&course, half), (0.5 + 0.5 * later) / half, 1e-12);
    assert_near(outlook(&course, now), later / now, 1e-12);
    assert_near(outlook(&course, 1.0 / 8), 8.0 / NET_POINTS, 1e-12);
    for (double factor = 2; factor > 1e-12; factor *= 0.7) {
        const double found = outlook(&course, factor);
        assert_true(found > 0 && found <= 1);
    }
    plan_render_close(&course);
}

/* Points of each sequence are given out one after the other, to either in turn, an era's from the first on. */
static void points_are_handed_out_in_order(void **state)
{
    (void)state;
    const job_t job =
        plan_fixture_job("{'scene':'x','algorithm':'auto','max_path_length':4,'chains':{'split_gain':1,"
                         "'length':256},'film':{'width':48,'height':32},"
                         "'stop':{'mutations_per_pixel':400}}");
    plan_render_t course;
    uint64_t next[WORK_SEQUENCES] = {0};
    uint32_t sequences = 0;
    plan_render_open(&course, &job);
    plan_t *plan = course.plan;
    while (!plan_check_stop(plan, 1)) {
        const work_record_t *record;
        uint64_t unit;
        fault_t fault = {0};
        plan_absorbed_t how;
        size_t size;
        assert_true(plan_next(plan, &unit, &record));
        if (record->kind == WORK_SAMPLES) {
            const uint64_t passes = record->count / plan->pixels;
            const uint32_t era = plan->units[unit].era, other = record->sequence ^ 1;
            assert_int_equal(record->sequence / 2, era);
            assert_int_equal(record->point, next[record->sequence]);
            assert_true(next[record->sequence] <= next[other]);
            sequences += next[record->sequence] == 0;
            next[record->sequence] += passes;
        }
        uint8_t *data = plan_worker_run(&course.worker, record, &size);
        assert_int_equal(plan_absorb(plan, unit, data, size, &how, &fault), FAULT_NONE);
        free(data);
    }
    assert_true(sequences >= 6);
    plan_render_close(&course);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(factors_are_those_of_the_noise),
        cmocka_unit_test(blocks_have_their_own),
        cmocka_unit_test(outlooks_go_by_the_factor),
        cmocka_unit_test(points_are_handed_out_in_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
