/* Trials: what a unit says of how much its chains differ, against the chains' films one by one; steps that are
 * scaled, large steps that are fewer. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "chain/importance.h"
#include "chain/work_fixture.h"

enum { SIDE = 24, PIXELS = SIDE * SIDE };

static const atomic_bool go = false;

static work_result_t run(work_fixture_t *f, const work_record_t *record)
{
    work_result_t result;
    fault_t fault = {0};
    if (work_run(f->space, record, &go, &result, &fault))
        fail_msg("%s", fault.text);
    return result;
}

/* The spread from films, as chain/trial.c defines it: pixel by pixel, chain by chain, with differences from the
 * mean in place of its difference of squares. */
static double spread_of_films(double (*films)[PIXELS], uint32_t count, double scale)
{
    double spread = 0;
    for (size_t p = 0; p < PIXELS; p++) {
        double mean = 0, variance = 0, others = 0;
        for (uint32_t u = 0; u < count; u++)
            mean += films[u][p] / count;
        if (mean == 0)
            continue;
        for (uint32_t u = 0; u < count; u++) {
            variance += (films[u][p] - mean) * (films[u][p] - mean) / (count - 1);
            for (uint32_t v = 0; v < count; v++)
                others += v == u ? 0 : films[u][p] * films[v][p];
        }
        const double r = scale * others / (mean * count) / (count - 1);
        spread += variance / ((1 + r) * (1 + r));
    }
    return spread;
}

static void a_trial_is_what_its_chains_differ_by(void **state)
{
    (void)state;
    static const settings_algorithm_t algorithms[] = {SETTINGS_MMLT, SETTINGS_RJMLT, SETTINGS_CMLT_REX};
    for (size_t a = 0; a < sizeof algorithms / sizeof *algorithms; a++)
        for (int scaled = 0; scaled < 2; scaled++) {
            work_fixture_t f;
            work_fixture_make(&f, SMALL_LIGHT_AREA, algorithms[a]);
            const uint32_t together = algorithms[a] == SETTINGS_CMLT_REX ? WORK_REPLICAS : 1, runs = 5;
            work_record_t record = work_fixture_record(&f, WORK_TRIAL);
            record.count = runs * together;
            record.mutations = 400 * record.count;
            record.scale = scaled ? 0.02 : 1e-300;
            record.steps = scaled;
            record.large = -scaled;
            const double spread = run(&f, &record).spread;
            static double films[5][PIXELS];
            for (uint32_t u = 0; u < runs; u++) {
                work_record_t one = record;
                one.kind = WORK_CHAINS;
                one.scale = 0;
                one.first += (uint64_t)u * together;
                one.seeds += (size_t)u * together;
                one.count = together;
                one.mutations = 400 * together;
                const work_result_t result = run(&f, &one);
                for (uint32_t p = 0; p < PIXELS; p++)
                    films[u][p] = rgb_luminance(film_value(&result.film, p % SIDE, p / SIDE));
            }
            const double expected = spread_of_films(films, runs, record.scale);
            if (!(expected > 0 && fabs(spread - expected) < 1e-9 * expected))
                fail_msg("%s: spread %.12g, expected %.12g", settings_algorithm_name(algorithms[a]), spread,
                         expected);
            work_fixture_clear(&f);
        }
}

/* Large steps as often as the record says (4.5 standard errors); longer steps are accepted less often. */
static void steps_are_scaled(void **state)
{
    (void)state;
    work_fixture_t f;
    work_fixture_make(&f, SMALL_LIGHT_AREA, SETTINGS_MMLT);
    double acceptance = 1;
    for (int32_t steps = -4; steps <= 4; steps += 4) {
        work_record_t record = work_fixture_record(&f, WORK_CHAINS);
        record.mutations = 40000;
        record.steps = steps;
        record.large = steps / 4 - 1;
        const work_stats_t stats = run(&f, &record).stats;
        const double p = ldexp(f.settings.large_step, record.large), n = (double)record.mutations;
        assert_true(fabs((double)stats.proposed[WORK_MOVE_LARGE] - n * p) < 4.5 * sqrt(n * p * (1 - p)));
        const double small = stats.accepted[WORK_MOVE_SMALL] / (double)stats.proposed[WORK_MOVE_SMALL];
        if (!(small < acceptance - 0.005))
            fail_msg("steps 2^%d: accepted %g, shorter ones %g", steps, small, acceptance);
        acceptance = small;
    }
    work_fixture_clear(&f);
}

static void trials_that_cannot_be_are_refused(void **state)
{
    (void)state;
    work_fixture_t f;
    work_fixture_make(&f, SMALL_LIGHT_AREA, SETTINGS_MMLT);
    work_record_t record = work_fixture_record(&f, WORK_TRIAL);
    record.scale = 1;
    record.count = 1;
    work_result_t result;
    fault_t fault = {0};
    assert_int_equal(work_run(f.space, &record, &go, &result, &fault), FAULT_RANGE);
    assert_non_null(strstr(fault.text, "expected 2 or more"));
    work_fixture_clear(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_trial_is_what_its_chains_differ_by),
        cmocka_unit_test(steps_are_scaled),
        cmocka_unit_test(trials_that_cannot_be_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
