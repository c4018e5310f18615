/* The rates of samples' lengths: against the least of a grid, or 1 where that is hardly less than without. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/random.h"
#include "stats/rates.h"

enum { LENGTHS = 4, GRID = 40 };

static double product(const double *parts, const double *costs, const double *rates)
{
    double variance = 0, cost = 0;
    for (int k = 0; k < LENGTHS; k++) {
        variance += parts[k] / rates[k];
        cost += costs[k] * rates[k];
    }
    return variance * cost;
}

/* Over rates 1 >= r_2 >= ... >= r_LENGTHS, powers of 16 between 1 and 1/16. */
static double least_of_grid(const double *parts, const double *costs)
{
    double least = INFINITY;
    for (int a = 0; a <= GRID; a++)
        for (int b = a; b <= GRID; b++)
            for (int c = b; c <= GRID; c++) {
                const double rates[LENGTHS] = {1, pow(16, -(double)a / GRID), pow(16, -(double)b / GRID),
                                               pow(16, -(double)c / GRID)};
                least = fmin(least, product(parts, costs, rates));
            }
    return least;
}

static void no_other_rates_are_better(void **state)
{
    (void)state;
    const uint64_t key = random_key(2385, RANDOM_PURPOSE_TEST, 77, 0);
    int plains = 0;
    for (uint64_t i = 0; i < 100; i++) {
        double parts[LENGTHS], costs[LENGTHS], rates[LENGTHS];
        for (uint64_t k = 0; k < LENGTHS; k++) {
            parts[k] = pow(8, random_double(key, 16 * i + k));
            costs[k] = pow(8, random_double(key, 16 * i + 8 + k));
        }
        const rates_figures_t figures = rates_best(parts, costs, LENGTHS, rates);
        assert_true(rates[0] == 1);
        for (int k = 1; k < LENGTHS; k++)
            assert_true(rates[k] <= rates[k - 1] && rates[k] >= 1.0 / RATES_SELDOM);
        const double own = product(parts, costs, rates), least = least_of_grid(parts, costs);
        assert_true(fabs(figures.variance * figures.cost - own) < 1e-12 * own);
        const bool plain = rates[LENGTHS - 1] == 1;
        if (!(own <= least * (plain ? RATES_GAIN : 1) * (1 + 1e-12)))
            fail_msg("case %d: %g, the grid has %g", (int)i, own, least);
        if (!plain)
            assert_true(product(parts, costs, (double[LENGTHS]){1, 1, 1, 1}) > RATES_GAIN * own);
        plains += plain;
    }
    assert_in_range(plains, 5, 95); /* of both kinds */
}

static void odd_figures_give_rates_all_the_same(void **state)
{
    (void)state;
    static const double cases[][2][LENGTHS] = {
        {{0, 0, 0, 0}, {1, 1, 1, 1}}, {{-1, 2, -3, 4}, {0, 0, 0, 0}}, {{1e300, 1e-300, 0, 1}, {1, 1e9, 1, 1}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double rates[LENGTHS];
        rates_best(cases[i][0], cases[i][1], LENGTHS, rates);
        for (int k = 0; k < LENGTHS; k++)
            assert_true(rates[k] > 0 && rates[k] <= (k > 0 ? rates[k - 1] : 1));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_other_rates_are_better),
                                       cmocka_unit_test(odd_figures_give_rates_all_the_same)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
