/* Units of chains of every algorithm: functions of their record, counts that add up, failures left out, hostile
 * shares. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "chain/work_fixture.h"
#include "path/walk.h"
#include "support/near.h"

typedef struct variant {
    settings_algorithm_t algorithm;
    settings_failures_t failures;
    double partial, auxiliary;
} variant_t;

static const variant_t variants[] = {
    {SETTINGS_MMLT, SETTINGS_FAILURES_PLAIN, 0, 0},       {SETTINGS_MMLT, SETTINGS_FAILURES_PUBLISHED, 0.4, 0},
    {SETTINGS_MMLT, SETTINGS_FAILURES_DELAYED, 0.4, 0.1}, {SETTINGS_RJMLT, SETTINGS_FAILURES_DELAYED, 0.2, 0},
    {SETTINGS_CMLT, SETTINGS_FAILURES_PLAIN, 0.5, 0.1},   {SETTINGS_CMLT_REX, SETTINGS_FAILURES_PLAIN, 0.3, 0},
    {SETTINGS_CMLT_IPSM, SETTINGS_FAILURES_PLAIN, 0, 0},  {SETTINGS_PSSMLT_MIX, SETTINGS_FAILURES_DELAYED, 0.2, 0},
    {SETTINGS_PSSMLT, SETTINGS_FAILURES_PLAIN, 0, 0},
};
enum { VARIANTS = sizeof variants / sizeof *variants };

static const double shares[4] = {0.1, 0.2, 0.3, 0.4};

static void make(work_fixture_t *f, const variant_t *v)
{
    fault_t fault = {0};
    work_fixture_make(f, SMALL_LIGHT_AREA, v->algorithm);
    renderer_destroy(&f->renderer);
    work_space_destroy(&f->space);
    f->settings.failures = v->failures;
    f->settings.partial_step = v->partial;
    f->settings.auxiliary_step = v->auxiliary;
    f->settings.jump_step = 0.1;
    assert_int_equal(renderer_new(&f->renderer, &f->small.scene, &f->settings, &fault), FAULT_NONE);
    assert_int_equal(work_space_new(&f->space, f->renderer, &fault), FAULT_NONE);
}

static work_record_t record_of(work_fixture_t *f)
{
    work_record_t record = work_fixture_record(f, WORK_CHAINS);
    if (settings_wants_shares(f->settings.algorithm))
        record.shares = (double *)(uintptr_t)shares;
    return record;
}

/* The same bytes again, after other work, and from another space. */
static void results_are_functions_of_their_record(void **state)
{
    (void)state;
    for (int i = 0; i < VARIANTS; i++) {
        work_fixture_t f;
        work_space_t *other;
        fault_t fault = {0};
        make(&f, &variants[i]);
        assert_int_equal(work_space_new(&other, f.renderer, &fault), FAULT_NONE);
        const work_record_t record = record_of(&f);
        work_record_t before = record;
        before.first += 100;
        size_t size, size_again, size_other;
        uint8_t *bytes = work_fixture_bytes(f.space, &record, &size);
        free(work_fixture_bytes(other, &before, &size_other));
        uint8_t *again = work_fixture_bytes(f.space, &record, &size_again);
        uint8_t *from_other = work_fixture_bytes(other, &record, &size_other);
        assert_int_equal(size_again, size);
        assert_int_equal(size_other, size);
        assert_memory_equal(again, bytes, size);
        assert_memory_equal(from_other, bytes, size);
        free(bytes);
        free(again);
        free(from_other);
        work_space_destroy(&other);
        work_fixture_clear(&f);
    }
}

static double luminance_of_block(const film_t *film, int block)
{
    double sum = 0;
    for (uint32_t y = 0; y < film->height; y++)
        for (uint32_t x = 0; x < film->width; x++) {
            const uint32_t i = x * WORK_FAILED_SIDE / film->width, j = y * WORK_FAILED_SIDE / film->height;
            if (j * WORK_FAILED_SIDE + i == (uint32_t)block)
                sum += rgb_luminance(film_value(film, x, y));
        }
    return sum;
}

/* Each mutation adds a weight of one, wherever it goes: a film's sum of f/f* is the number of mutations that count.
 */
static void weights_add_up_to_the_mutations(void **state)
{
    (void)state;
    const atomic_bool go = false;
    for (int i = 0; i < VARIANTS; i++) {
        work_fixture_t f;
        work_result_t result;
        fault_t fault = {0};
        make(&f, &variants[i]);
        const work_record_t record = record_of(&f);
        assert_int_equal(work_run(f.space, &record, &go, &result, &fault), FAULT_NONE);
        double sum = 0;
        for (int block = 0; block < WORK_FAILED_BLOCKS; block++)
            sum += luminance_of_block(&result.film, block);
        uint64_t counted = record.mutations, proposed = 0;
        if (variants[i].failures == SETTINGS_FAILURES_PUBLISHED)
            counted -= result.stats.zero_proposals;
        /* each of at most two splats a mutation (or states, seen in one place more than there are lengths) rounds
         * three channels to 2^-28 */
        const double splats = settings_joins_all(f.settings.algorithm) ? 2 * (1 + WORK_FIXTURE_LENGTH) : 2,
                     off = splats * 0x1p-28 * (double)record.mutations;
        if (!(fabs(sum - (double)counted) <= off))
            fail_msg("%s: the film holds %.9g, expected %llu", settings_algorithm_name(variants[i].algorithm), sum,
                     (unsigned long long)counted);
        for (int move = 0; move < WORK_MOVE_SECOND; move++)
            proposed += result.stats.proposed[move];
        assert_int_equal(proposed, record.mutations);
        assert_true((result.stats.proposed[WORK_MOVE_SECOND] > 0) ==
                    (variants[i].failures == SETTINGS_FAILURES_DELAYED));
        if (settings_jumps(variants[i].algorithm))
            assert_true(result.stats.accepted[WORK_MOVE_JUMP] > 0);
        if (variants[i].algorithm == SETTINGS_RJMLT) /* accepted always, but where the way back fails */
            assert_true(result.stats.accepted[WORK_MOVE_JUMP] >=
                        0.99 * (double)result.stats.proposed[WORK_MOVE_JUMP]);
        if (variants[i].auxiliary > 0)
            assert_true(result.stats.accepted[WORK_MOVE_AUXILIARY] > 0);
        work_fixture_clear(&f);
    }
}

/* The same chains with failures counted and left out go the same way, so the films differ by the failures alone,
 * block by block: what the report's estimate of the bias rests on. */
static void failures_left_out_are_all_that_is_missing(void **state)
{
    (void)state;
    const atomic_bool go = false;
    const variant_t plain = {SETTINGS_RJMLT, SETTINGS_FAILURES_PLAIN, 0.3, 0},
                    published = {SETTINGS_RJMLT, SETTINGS_FAILURES_PUBLISHED, 0.3, 0};
    work_fixture_t a, b;
    work_result_t of_plain, of_published;
    fault_t fault = {0};
    make(&a, &plain);
    make(&b, &published);
    const work_record_t record = record_of(&a), same = record_of(&b);
    assert_int_equal(work_run(a.space, &record, &go, &of_plain, &fault), FAULT_NONE);
    assert_int_equal(work_run(b.space, &same, &go, &of_published, &fault), FAULT_NONE);
    assert_null(of_plain.failed);
    assert_non_null(of_published.failed);
    assert_true(of_published.stats.zero_proposals > 100);
    assert_int_equal(of_published.stats.zero_proposals, of_plain.stats.zero_proposals);
    for (int block = 0; block < WORK_FAILED_BLOCKS; block++) {
        const double with = luminance_of_block(&of_plain.film, block),
                     without = luminance_of_block(&of_published.film, block);
        if (!(fabs(with - without - (double)of_published.failed[block]) < 4 * 0x1p-28 * (double)record.mutations))
            fail_msg("block %d: %.9g with failures, %.9g and %llu failures without", block, with, without,
                     (unsigned long long)of_published.failed[block]);
    }
    work_fixture_clear(&a);
    work_fixture_clear(&b);
}

static void refuse_shares(work_fixture_t *f, const double *values, const char *expected)
{
    work_record_t record = work_fixture_record(f, WORK_CHAINS), back;
    fault_t fault = {0};
    uint8_t *data;
    size_t size;
    record.shares = (double *)(uintptr_t)values;
    assert_int_equal(work_record_encode(&record, &data, &size, &fault), FAULT_NONE);
    const fault_code_t code = work_record_decode(&back, data, size, &fault);
    if (expected) {
        assert_int_equal(code, FAULT_RANGE);
        assert_non_null(strstr(fault.text, expected));
        assert_null(back.shares);
        assert_null(back.seeds);
    } else {
        assert_int_equal(code, FAULT_NONE);
        assert_memory_equal(back.shares, values, 4 * sizeof *values);
        work_record_clear(&back);
    }
    free(data);
}

static void refuse_record(work_fixture_t *f, const work_record_t *record, const char *expected)
{
    const atomic_bool go = false;
    work_result_t result;
    fault_t fault = {0};
    assert_int_equal(work_run(f->space, record, &go, &result, &fault), FAULT_RANGE);
    if (!strstr(fault.text, expected))
        fail_msg("\"%s\" does not tell of \"%s\"", fault.text, expected);
}

/* Chains of all lengths have no length, all others have one; a seed must carry light. */
static void lengths_go_with_the_algorithm(void **state)
{
    (void)state;
    const double one = 1;
    work_fixture_t f;
    make(&f, &(variant_t){SETTINGS_PSSMLT, SETTINGS_FAILURES_PLAIN, 0, 0});
    work_record_t record = record_of(&f);
    record.length = 3;
    refuse_record(&f, &record, "expected 0");
    record.length = 0;
    record.shares = (double *)(uintptr_t)&one;
    refuse_record(&f, &record, "shares");
    fault_t fault = {0};
    uint8_t *data;
    size_t size;
    work_record_t back;
    assert_int_equal(work_record_encode(&record, &data, &size, &fault), FAULT_NONE);
    assert_int_equal(work_record_decode(&back, data, size, &fault), FAULT_FORMAT);
    assert_non_null(strstr(fault.text, "shares"));
    free(data);
    work_fixture_clear(&f);
    make(&f, &variants[0]);
    record = record_of(&f);
    record.length = 0;
    refuse_record(&f, &record, "expected 1 to 5");
    work_fixture_clear(&f);
}

/* A chain of all lengths with nothing but large steps is a row of independent samples: the estimators of a pilot.
 * Two means of b_k by other random numbers, within 6 standard errors: a false alarm in 1e-8 for the five. */
static void large_steps_of_all_lengths_are_samples(void **state)
{
    (void)state;
    const atomic_bool go = false;
    work_fixture_t f;
    work_result_t result;
    fault_t fault = {0};
    work_fixture_make(&f, SMALL_LIGHT_AREA, SETTINGS_PSSMLT);
    renderer_destroy(&f.renderer);
    work_space_destroy(&f.space);
    f.settings.large_step = 1;
    assert_int_equal(renderer_new(&f.renderer, &f.small.scene, &f.settings, &fault), FAULT_NONE);
    assert_int_equal(work_space_new(&f.space, f.renderer, &fault), FAULT_NONE);
    work_record_t record = record_of(&f);
    record.mutations = 20000;
    const work_record_t pilot = {.kind = WORK_REFINE, .count = 20000};
    work_moments_t steps[64], samples[64];
    const uint32_t count = work_samples_moment(WORK_FIXTURE_LENGTH + 1);
    assert_int_equal(work_run(f.space, &record, &go, &result, &fault), FAULT_NONE);
    assert_int_equal(result.moment_count, count);
    memcpy(steps, result.moments, sizeof *steps * count);
    assert_int_equal(work_run(f.space, &pilot, &go, &result, &fault), FAULT_NONE);
    memcpy(samples, result.moments, sizeof *samples * count);
    for (uint32_t k = 1; k <= WORK_FIXTURE_LENGTH; k++) {
        const work_moments_t *a = &steps[work_samples_moment(k)], *b = &samples[work_samples_moment(k)];
        const double x = a->sum / a->n, y = b->sum / b->n,
                     error = sqrt((a->sum2 / a->n - x * x) / a->n + (b->sum2 / b->n - y * y) / b->n);
        assert_true(a->n == 20000 && x > 0 && error < 0.3 * x);
        if (!(fabs(x - y) <= 6 * error))
            fail_msg("length %u: %g by large steps, %g by samples, error %g", k, x, y, error);
    }
    work_fixture_clear(&f);
}

/* A record of chains for an algorithm that has none is refused before anything is done. */
static void chains_of_independent_samples_are_refused(void **state)
{
    (void)state;
    const atomic_bool go = false;
    work_fixture_t f;
    work_result_t result;
    fault_t fault = {0};
    work_fixture_make(&f, SMALL_LIGHT_AREA, SETTINGS_BDPT);
    const work_record_t record = work_fixture_record(&f, WORK_CHAINS);
    assert_int_equal(work_run(f.space, &record, &go, &result, &fault), FAULT_RANGE);
    assert_non_null(strstr(fault.text, "bdpt"));
    work_fixture_clear(&f);
}

static void shares_are_checked(void **state)
{
    (void)state;
    static const double negative[4] = {-0.1, 0.5, 0.3, 0.3}, nan_share[4] = {NAN, 0.5, 0.3, 0.2},
                        short_sum[4] = {0.1, 0.1, 0.1, 0.1}, large[4] = {2, -1, 0, 0};
    work_fixture_t f;
    work_result_t result;
    fault_t fault = {0};
    const atomic_bool go = false;
    make(&f, &(variant_t){SETTINGS_CMLT, SETTINGS_FAILURES_PLAIN, 0, 0});
    refuse_shares(&f, shares, NULL);
    refuse_shares(&f, negative, "shares");
    refuse_shares(&f, nan_share, "shares");
    refuse_shares(&f, short_sum, "sum");
    refuse_shares(&f, large, "shares");
    const work_record_t without = work_fixture_record(&f, WORK_CHAINS);
    assert_int_equal(work_run(f.space, &without, &go, &result, &fault), FAULT_RANGE);
    assert_non_null(strstr(fault.text, "shares"));
    work_fixture_clear(&f);
}

static void refuse_importance(double value, const char *expected)
{
    double blocks[IMPORTANCE_BLOCKS];
    for (int i = 0; i < IMPORTANCE_BLOCKS; i++)
        blocks[i] = 1 + i;
    blocks[77] = value;
    const work_record_t record = {.kind = WORK_REFINE, .count = 10, .importance = blocks};
    work_record_t back;
    fault_t fault = {0};
    uint8_t *data;
    size_t size;
    assert_int_equal(work_record_encode(&record, &data, &size, &fault), FAULT_NONE);
    const fault_code_t code = work_record_decode(&back, data, size, &fault);
    if (expected) {
        assert_int_equal(code, FAULT_RANGE);
        assert_non_null(strstr(fault.text, expected));
        assert_null(back.importance);
    } else {
        assert_int_equal(code, FAULT_NONE);
        assert_memory_equal(back.importance, blocks, sizeof blocks);
        work_record_clear(&back);
    }
    free(data);
}

static void importance_is_checked(void **state)
{
    (void)state;
    const double ones[IMPORTANCE_BLOCKS] = {1};
    const atomic_bool go = false;
    work_fixture_t f;
    work_result_t result;
    fault_t fault = {0};
    refuse_importance(3, NULL);
    refuse_importance(0, "importance");
    refuse_importance(-1, "importance");
    refuse_importance(NAN, "importance");
    refuse_importance(INFINITY, "importance");
    make(&f, &variants[0]);
    work_record_t record = record_of(&f);
    record.importance = (double *)(uintptr_t)ones;
    assert_int_equal(work_run(f.space, &record, &go, &result, &fault), FAULT_RANGE); /* the job asks for none */
    assert_non_null(strstr(fault.text, "importance"));
    work_fixture_clear(&f);
}

/* Bilinear between the blocks' centres, constant beyond them. */
static void importance_is_bilinear(void **state)
{
    (void)state;
    double blocks[IMPORTANCE_BLOCKS];
    for (int i = 0; i < IMPORTANCE_BLOCKS; i++)
        blocks[i] = 1 + 2 * (i % IMPORTANCE_SIDE) + 5 * (i / IMPORTANCE_SIDE); /* a plane */
    const importance_t g = {blocks, 320, 160};
    for (double y = 0; y <= 160; y += 3.7)
        for (double x = 0; x <= 320; x += 7.3) {
            const double u = fmin(fmax(x / 20 - 0.5, 0), 15), v = fmin(fmax(y / 10 - 0.5, 0), 15);
            assert_near(importance_at(&g, (vec2_t){x, y}), 1 + 2 * u + 5 * v, 1e-11);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(results_are_functions_of_their_record),
        cmocka_unit_test(weights_add_up_to_the_mutations),
        cmocka_unit_test(failures_left_out_are_all_that_is_missing),
        cmocka_unit_test(lengths_go_with_the_algorithm),
        cmocka_unit_test(large_steps_of_all_lengths_are_samples),
        cmocka_unit_test(chains_of_independent_samples_are_refused),
        cmocka_unit_test(shares_are_checked),
        cmocka_unit_test(importance_is_checked),
        cmocka_unit_test(importance_is_bilinear),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
