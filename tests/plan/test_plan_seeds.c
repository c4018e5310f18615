/* Seeds: any first J chains start in proportion to the candidates' weights; and the sums that do not depend on
 * order. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "plan/plan_seeds.h"
#include "plan/plan_state.h"

enum { CANDIDATES = 500, LENGTH = 3 };

static plan_length_t lengths[LENGTH + 1];
static double weights[CANDIDATES], sums[CANDIDATES];

static double number(uint64_t stream, uint64_t i)
{
    return random_double(random_key(2385, RANDOM_PURPOSE_TEST, 3, stream), i);
}

/* A plan that has just finished its pilot, as far as seeds go. Four fifths of the candidates carry nothing, the
 * others weights over six orders of magnitude. */
static plan_t plan_with_candidates(uint64_t seed)
{
    plan_t plan;
    memset(&plan, 0, sizeof plan);
    for (int i = 0; i < CANDIDATES; i++)
        weights[i] = number(1, 2 * (uint64_t)i) < 0.8 ? 0 : pow(10, 6 * number(1, 2 * (uint64_t)i + 1));
    weights[0] = weights[CANDIDATES - 1] = 0;
    memcpy(sums, weights, sizeof sums);
    lengths[LENGTH] = (plan_length_t){.weights = sums};
    plan.candidates = CANDIDATES;
    plan_prepare_seeds(&plan, &lengths[LENGTH]);
    plan.settings.seed = seed;
    plan.lengths = lengths;
    return plan;
}

/* Number of terms of n as a sum of Fibonacci numbers, the largest first (Zeckendorf). */
static int zeckendorf(uint64_t n)
{
    int terms = 0;
    for (; n > 0; terms++) {
        uint64_t largest = 1, next = 2;
        while (next <= n) {
            const uint64_t sum = largest + next;
            largest = next;
            next = sum;
        }
        n -= largest;
    }
    return terms;
}

/* Chains start at frac(xi + j phi). Over q consecutive ones, q a denominator of phi's convergents (a Fibonacci
 * number), the count in an interval of length l is within 2 of q l (inequality of Denjoy and Koksma: at most the
 * variation of the interval's indicator, which is 2); J chains are as many runs of Fibonacci length as J has terms,
 * so their count is within 2 terms of J l. (The step is phi to 2^-64: the same convergents up to 2^31.) */
static void chains_start_in_proportion_to_weights(void **state)
{
    (void)state;
    static const uint64_t counts[] = {1, 2, 3, 5, 12, 34, 100, 1000, 4181, 10000, 75025, 100000};
    for (uint64_t seed = 1; seed <= 5; seed++) {
        const plan_t plan = plan_with_candidates(seed);
        uint32_t hits[CANDIDATES] = {0};
        uint64_t chain = 0;
        for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
            for (; chain < counts[c]; chain++) {
                const uint64_t candidate = plan_seed(&plan, LENGTH, chain);
                assert_true(candidate < CANDIDATES);
                if (weights[candidate] == 0)
                    fail_msg("chain %llu starts at a candidate without light", (unsigned long long)chain);
                hits[candidate]++;
            }
            const double bound = 2 * zeckendorf(counts[c]);
            for (int i = 0; i < CANDIDATES; i++) {
                const double expected = (double)counts[c] * weights[i] / sums[CANDIDATES - 1];
                if (!(fabs(hits[i] - expected) <= bound))
                    fail_msg("of %llu chains %u start at candidate %d, expected %g +- %g",
                             (unsigned long long)counts[c], hits[i], i, expected, bound);
            }
        }
    }
}

static void zeckendorf_counts_terms(void **state)
{
    (void)state;
    assert_int_equal(zeckendorf(1), 1);
    assert_int_equal(zeckendorf(2), 1);
    assert_int_equal(zeckendorf(4), 2);   /* 3 + 1 */
    assert_int_equal(zeckendorf(100), 3); /* 89 + 8 + 3 */
    assert_int_equal(zeckendorf(4181), 1);
    assert_int_equal(zeckendorf(12), 3); /* 8 + 3 + 1 */
}

/* By itself a chain's start is drawn by weight: no bias. Over seeds of the job; 5.1 standard deviations, 3e-7 each.
 */
static void each_chain_by_itself_is_drawn_by_weight(void **state)
{
    (void)state;
    enum { SEEDS = 20000 };
    static const uint64_t chains[] = {0, 1, 1000};
    double four[4] = {1, 2, 3, 4};
    for (size_t c = 0; c < 3; c++) {
        uint32_t hits[4] = {0};
        for (uint64_t seed = 0; seed < SEEDS; seed++) {
            plan_t plan;
            double run[4] = {four[0], 3, 6, 10};
            memset(&plan, 0, sizeof plan);
            lengths[LENGTH] = (plan_length_t){.weights = run};
            plan.candidates = 4;
            plan.settings.seed = seed;
            plan.lengths = lengths;
            hits[plan_seed(&plan, LENGTH, chains[c])]++;
        }
        for (int i = 0; i < 4; i++) {
            const double p = four[i] / 10, off = hits[i] - SEEDS * p, limit = 5.1 * sqrt(SEEDS * p * (1 - p));
            if (!(fabs(off) <= limit))
                fail_msg("chain %llu: candidate %d is off by %g > %g", (unsigned long long)chains[c], i, off,
                         limit);
        }
    }
}

static void one_candidate_serves_all_chains(void **state)
{
    (void)state;
    plan_t plan = plan_with_candidates(1);
    for (int i = 0; i < CANDIDATES; i++)
        sums[i] = i < 321 ? 0 : 5e-324; /* the smallest weight there is */
    for (uint64_t chain = 0; chain < 1000; chain++)
        assert_int_equal(plan_seed(&plan, LENGTH, chain), 321);
    assert_int_equal(plan_seed(&plan, LENGTH, UINT64_MAX), 321);
}

/* ---- exact sums ---- */

static void exact_sums_do_not_depend_on_order(void **state)
{
    (void)state;
    enum { TERMS = 2000 };
    static double terms[TERMS];
    exact_sum_t forward = {0}, backward = {0}, parts[3] = {{0}};
    long double plain = 0;
    for (uint64_t i = 0; i < TERMS; i++) {
        terms[i] = pow(10, 14 * number(4, i) - 7);
        plain += terms[i];
    }
    for (int i = 0; i < TERMS; i++) {
        exact_add(&forward, terms[i], 0.37);
        exact_add(&backward, terms[TERMS - 1 - i], 0.37);
        exact_add(&parts[i % 3], terms[i], 0.37);
    }
    assert_true(forward.value == backward.value);
    assert_true(forward.value == parts[0].value + parts[1].value + parts[2].value);
    /* each term is rounded to 2^-40 of the unit; and its quotient by the unit to 2^-53 */
    const double off = fabs(exact_value(&forward, 0.37) - (double)plain);
    assert_true(off <= TERMS * 0.37 * 0x1p-41 + (double)plain * 0x1p-51);
}

static void hostile_terms_saturate(void **state)
{
    (void)state;
    static const double terms[] = {INFINITY, 1e308, NAN, 1e40};
    for (size_t i = 0; i < sizeof terms / sizeof *terms; i++) {
        exact_sum_t sum = {0};
        for (int n = 0; n < 10; n++) {
            exact_add(&sum, terms[i], 1e-300);
            assert_true(sum.value > 0);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(zeckendorf_counts_terms),
        cmocka_unit_test(chains_start_in_proportion_to_weights),
        cmocka_unit_test(each_chain_by_itself_is_drawn_by_weight),
        cmocka_unit_test(one_candidate_serves_all_chains),
        cmocka_unit_test(exact_sums_do_not_depend_on_order),
        cmocka_unit_test(hostile_terms_saturate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
