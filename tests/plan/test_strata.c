/* Stratification: by its definition from the units' films, and larger for few long chains than for many short ones.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "plan/plan_estimate.h"
#include "plan/plan_fixture.h"
#include "plan/plan_state.h"
#include "plan/plan_strata.h"
#include "support/sanitized.h"

enum { WIDTH = 21, HEIGHT = 13, PIXELS = WIDTH * HEIGHT, UNITS = 256 };

/* What a unit of chains brought: its film over its size. */
typedef struct unit_film {
    uint32_t length;
    double size, values[3 * PIXELS];
} unit_film_t;

typedef struct unit_films {
    uint32_t count;
    unit_film_t units[UNITS];
} unit_films_t;

static void keep_film(unit_films_t *films, const plan_t *plan, const work_record_t *record,
                      const work_result_t *result)
{
    const plan_length_t *length = &plan->lengths[record->length];
    assert_true(films->count < UNITS);
    unit_film_t *unit = &films->units[films->count++];
    unit->length = record->length;
    unit->size = (double)record->mutations / (double)length->unit_mutations;
    for (int i = 0; i < 3 * PIXELS; i++)
        unit->values[i] = (double)result->film.sums[i] / unit->size;
}

static void run_and_keep(plan_t *plan, plan_worker_t *worker, unit_films_t *films)
{
    const atomic_bool go = false;
    fault_t fault = {0};
    while (!plan_finished(plan)) {
        const work_record_t *record;
        uint64_t id;
        work_result_t result;
        plan_absorbed_t how;
        uint8_t *data;
        size_t size;
        if (plan_next(plan, &id, &record)) {
            assert_int_equal(work_run(worker->space, record, &go, &result, &fault), FAULT_NONE);
            if (record->kind == WORK_CHAINS)
                keep_film(films, plan, record, &result);
            assert_int_equal(work_result_encode(&result, &data, &size, &fault), FAULT_NONE);
            assert_int_equal(plan_absorb(plan, id, data, size, &how, &fault), FAULT_NONE);
            free(data);
        }
        plan_check_stop(plan, 0);
    }
}

/* The image's variance, of its sum over a rectangle of pixels: of each length from the squared deviations of its
 * units from their mean, as units of different size weigh. */
static double variance_of(const plan_t *plan, const unit_films_t *films, int channel, int left, int top, int right,
                          int bottom)
{
    double variance = 0;
    for (uint32_t k = 0; k <= 5; k++) {
        double values[UNITS], mean = 0, sizes = 0, sum = 0, units = 0, error;
        for (uint32_t u = 0; u < films->count; u++) {
            const unit_film_t *unit = &films->units[u];
            values[u] = 0;
            for (int y = top; y < bottom; y++)
                for (int x = left; x < right; x++)
                    values[u] += unit->values[3 * (y * WIDTH + x) + channel];
            mean += unit->length == k ? values[u] * unit->size : 0;
            sizes += unit->length == k ? unit->size : 0;
            units += unit->length == k;
        }
        if (units == 0)
            continue;
        for (uint32_t u = 0; u < films->count; u++)
            if (films->units[u].length == k) {
                const double off = values[u] - mean / sizes;
                sum += films->units[u].size * off * off;
            }
        const double factor = plan_film_b(plan, k, &error) / (double)plan->lengths[k].merged;
        variance += factor * factor * sizes * sum / (units - 1);
    }
    return variance;
}

static double by_definition(const plan_t *plan, const unit_films_t *films)
{
    image_t image;
    fault_t fault = {0};
    double level = 0, of_blocks = 0, of_pixels = 0;
    assert_int_equal(plan_image(plan, &image, &fault), FAULT_NONE);
    const float *planes[3] = {image_channel(&image, 0), image_channel(&image, 1), image_channel(&image, 2)};
    for (int p = 0; p < PIXELS; p++)
        level += rgb_luminance(rgb((double)planes[0][p], (double)planes[1][p], (double)planes[2][p])) / PIXELS;
    for (int c = 0; c < 3; c++)
        for (int top = 0; top < HEIGHT; top += 8)
            for (int left = 0; left < WIDTH; left += 8) {
                const int right = left + 8 < WIDTH ? left + 8 : WIDTH, bottom = top + 8 < HEIGHT ? top + 8 : HEIGHT;
                double mean = 0, parts = 0;
                for (int y = top; y < bottom; y++)
                    for (int x = left; x < right; x++) {
                        mean += (double)planes[c][y * WIDTH + x] / ((right - left) * (bottom - top));
                        parts += variance_of(plan, films, c, x, y, x + 1, y + 1);
                    }
                const double weight = 1 / (mean * mean + 0.01 * level * level);
                of_blocks += weight * variance_of(plan, films, c, left, top, right, bottom);
                of_pixels += weight * parts;
            }
    image_clear(&image);
    return of_blocks / of_pixels;
}

static void check_definition(const char *algorithm)
{
    static unit_films_t films;
    char text[256];
    snprintf(text, sizeof text,
             "{'scene':'x','algorithm':'%s','max_path_length':5,'film':{'width':%d,'height':%d},'stop':{"
             "'mutations_per_pixel':61.7}}",
             algorithm, WIDTH, HEIGHT);
    const job_t job = plan_fixture_job(text);
    small_scene_t small;
    plan_worker_t worker;
    small_scene_box(&small, SMALL_LIGHT_AREA);
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    films.count = 0;
    run_and_keep(plan, &worker, &films);
    assert_true(films.count >= 16);
    const double expected = by_definition(plan, &films), found = plan_estimate_strata(plan);
    json_t *report = plan_report(plan);
    assert_true(json_number(json_get(report, "stratification")) == found);
    json_destroy(&report);
    /* squares less the mean's: a cancellation of some three digits; the image's values are floats */
    if (!(fabs(found / expected - 1) < 1e-6))
        fail_msg("%s: %.12g, by definition %.12g", algorithm, found, expected);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    small_scene_clear(&small);
}

static void it_is_what_it_is_defined_to_be(void **state)
{
    (void)state;
    check_definition("mmlt");
    check_definition("pssmlt");
}

static uint64_t fewest_units(const plan_t *plan)
{
    uint64_t fewest = UINT64_MAX;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++)
        if (plan->lengths[k].share > 0 && plan->lengths[k].units_in < fewest)
            fewest = plan->lengths[k].units_in;
    return fewest;
}

/* Told as soon as each length has four units, and then right in the mean, though the first units of a length are
 * small, and as many of a dim length as of a bright one. Logarithms of what is told first over what is told in the
 * end, over 16 seeds: 5 standard errors are a false alarm in 1 of 6 000 runs. */
static void first_words_are_as_the_last(void **state)
{
    (void)state;
    enum { SEEDS = 16 };
    if (SANITIZED)
        skip();
    double sum = 0, sum2 = 0;
    small_scene_t small;
    small_scene_diffuse(&small);
    for (int seed = 1; seed <= SEEDS; seed++) {
        char text[256];
        snprintf(text, sizeof text,
                 "{'scene':'x','algorithm':'mmlt','max_path_length':5,'seed':%d,'film':{'width':48,'height':48},"
                 "'stop':{'mutations_per_pixel':400}}",
                 seed);
        const job_t job = plan_fixture_job(text);
        plan_worker_t worker;
        double first = NAN;
        plan_worker_make(&worker, &job, &small.scene);
        plan_t *plan = plan_fixture_new(&job, &small.scene);
        while (!plan_check_stop(plan, 0)) {
            assert_true(plan_fixture_step(plan, &worker));
            if (isfinite(first))
                continue;
            first = plan_estimate_strata(plan);
            assert_true(isfinite(first) == (plan->phase == PLAN_RENDER && fewest_units(plan) >= 4));
        }
        const double x = log(first / plan_estimate_strata(plan));
        sum += x / SEEDS;
        sum2 += x * x / SEEDS;
        plan_destroy(&plan);
        plan_worker_clear(&worker);
    }
    small_scene_clear(&small);
    const double error = sqrt((sum2 - sum * sum) / (SEEDS - 1));
    print_message("first over last: log %.3f +- %.3f\n", sum, error);
    assert_true(error < 0.15);
    assert_true(fabs(sum) < 5 * error);
}

static double measure(const small_scene_t *small, const char *chains, int seed)
{
    char text[384];
    snprintf(text, sizeof text,
             "{'scene':'x','algorithm':'mmlt','max_path_length':5,'seed':%d,'chains':{'pilot_samples':16384,%s},"
             "'film':{'width':48,'height':48},'stop':{'mutations_per_pixel':40}}",
             seed, chains);
    const job_t job = plan_fixture_job(text);
    plan_worker_t worker;
    plan_worker_make(&worker, &job, &small->scene);
    plan_t *plan = plan_fixture_new(&job, &small->scene);
    plan_fixture_run(plan, &worker, 0);
    const double found = plan_estimate_strata(plan);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    return found;
}

/* Logarithms of the measure over seeds: their mean and its standard error. */
static double mean_log(const small_scene_t *small, const char *chains, double *error)
{
    enum { SEEDS = 12 };
    double sum = 0, sum2 = 0;
    for (int seed = 1; seed <= SEEDS; seed++) {
        const double x = log(measure(small, chains, seed));
        sum += x / SEEDS;
        sum2 += x * x / SEEDS;
    }
    *error = sqrt((sum2 - sum * sum) / (SEEDS - 1));
    print_message("%s: %.3f, log %.3f +- %.3f\n", chains, exp(sum), sum, *error);
    return sum;
}

/* The same work by few long chains, by many short ones, and by large steps alone, whose places are independent but
 * for those that a state keeps. 9 standard errors of 12 seeds (Student, 11 degrees at the least): a false alarm in
 * 1e-6 each, were the seeds not fixed. */
static void long_chains_make_blotches(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_box(&small, SMALL_LIGHT_AREA);
    double e_long, e_short, e_large;
    const double l = mean_log(&small, "'large_step':0.01,'length':1000000", &e_long),
                 s = mean_log(&small, "'large_step':0.01,'length':16", &e_short),
                 i = mean_log(&small, "'large_step':1,'length':1000000", &e_large);
    assert_true(l - s > 9 * hypot(e_long, e_short));
    assert_true(l - i > 9 * hypot(e_long, e_large));
    assert_true(fabs(i) < 1.0 / 36 + 9 * e_large); /* 36 blocks share a given number of mutations */
    small_scene_clear(&small);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_is_what_it_is_defined_to_be),
        cmocka_unit_test(first_words_are_as_the_last),
        cmocka_unit_test(long_chains_make_blotches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
