/* How work is shared anew: the shares that are chosen, and why eras count by fixed weights.
 *
 * The second part is a render of two path lengths by numbers alone. Units of one length bring 1 / p with a small
 * probability p, else nothing: rare bright paths; those of the other are all about alike. Eras share the work by
 * shift_shares, from what earlier ones (but for the last) have shown. Averaged by fixed weights the mean is
 * right; over the number of units it is too small, as a length that has been lucky gets more units and one that has
 * not does not. 40000 renders; the right one must be within 5 standard errors (a false alarm in 6e-7, were the seed
 * not fixed), the wrong one must be off by more than 10, or the test could not tell them apart. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "base/random.h"
#include "stats/shift.h"

static uint64_t counter;

static double draw(void)
{
    return random_double_of(random_u64(random_key(771, RANDOM_PURPOSE_TEST, 5, 0), counter++));
}

/* ---- shares ---- */

static double sum_of(const double *shares, uint32_t count)
{
    double sum = 0;
    for (uint32_t k = 0; k < count; k++)
        sum += shares[k];
    return sum;
}

/* So many units that the prior has no say. */
static void shares_go_by_the_root_of_variance_over_cost(void **state)
{
    (void)state;
    const shift_length_t lengths[3] = {
        {0.3, 0.3, 4, 1, 1e9, 0}, {0.3, 0.3, 9, 4, 1e9, 0}, {0.4, 0.4, 1, 4, 1e9, 0}};
    const double wanted[3] = {2, 1.5, 0.5};
    double shares[3];
    assert_true(shift_shares(lengths, 3, shares));
    for (int k = 0; k < 3; k++)
        if (!(fabs(shares[k] - wanted[k] / 4) < 1e-6))
            fail_msg("share %d is %.9f, expected %.9f", k, shares[k], wanted[k] / 4);
}

/* Variances that are what the pilot's shares imply, but for a factor, say nothing new; unknown ones say nothing. */
static void what_confirms_the_pilot_changes_nothing(void **state)
{
    (void)state;
    const shift_length_t confirmed[3] = {
        {0.2, 0.2, 7 * 0.04 * 3, 3, 20, 0}, {0.5, 0.5, 7 * 0.25 * 2, 2, 5, 0}, {0.3, 0.3, 0, 1, 1, 0}};
    const shift_length_t unknown[2] = {{0.1, 0.1, 1e9, 1, 1, 0}, {0.9, 0.9, 1, 1, 0, 0}};
    double shares[3];
    assert_false(shift_shares(confirmed, 3, shares));
    for (int k = 0; k < 3; k++)
        assert_true(shares[k] == confirmed[k].last);
    assert_false(shift_shares(unknown, 2, shares));
    assert_true(shares[0] == 0.1 && shares[1] == 0.9);
}

/* Whatever was measured: they add up to what they did, no share moves by more than four, none falls below its
 * least, lengths that have none get none, and the error that the measured variances foretell does not grow. */
static void shares_stay_in_bounds(void **state)
{
    (void)state;
    int moved = 0;
    for (int round = 0; round < 20000; round++) {
        shift_length_t lengths[8];
        double shares[8], all = 0;
        const uint32_t count = 2 + (uint32_t)(draw() * 6.999);
        for (uint32_t k = 0; k < count; k++) {
            const double prior = draw() < 0.2 ? 0 : exp(-6 * draw());
            lengths[k] = (shift_length_t){.prior = prior,
                                          .last = prior > 0 ? exp(-6 * draw()) : 0,
                                          .variance = draw() < 0.1 ? 0 : exp(20 * draw() - 10),
                                          .cost = exp(4 * draw()),
                                          .units = floor(40 * draw() * draw()),
                                          .least = 0.01 * draw()};
            all += lengths[k].last;
        }
        moved += shift_shares(lengths, count, shares);
        if (!(fabs(sum_of(shares, count) - all) <= 1e-9 * all))
            fail_msg("round %d: shares add up to %.12f, expected %.12f", round, sum_of(shares, count), all);
        for (uint32_t k = 0; k < count; k++) {
            const double last = lengths[k].last, slack = 1 + 1e-9;
            if (!(shares[k] * slack >= last / 4 && shares[k] <= 4 * last * slack &&
                  shares[k] * slack >= fmin(last, lengths[k].least)))
                fail_msg("round %d: share %u went from %g to %g, least %g", round, k, last, shares[k],
                         lengths[k].least);
        }
    }
    assert_true(moved > 5000 && moved < 20000);
}

/* ---- fixed weights ---- */

enum { ERAS = 5, RENDERS = 40000 };

/* Sums over units of one length. */
typedef struct tally {
    double n, sum, squares;
} tally_t;

static void tally_add(tally_t *tally, double x)
{
    tally->n++;
    tally->sum += x;
    tally->squares += x * x;
}

static double tally_variance(const tally_t *tally)
{
    return tally->n > 1 ? fmax(0, tally->squares - tally->sum * tally->sum / tally->n) / (tally->n - 1) : 0;
}

/* A unit: its mean is 1. */
static double unit_of(int length)
{
    const double rare = 0.05;
    return length == 0 ? (draw() < rare ? 1 / rare : 0) : 0.5 + draw();
}

/* One render; the first length's image by fixed weights and by the number of its units. */
static void render(double *weighted, double *pooled)
{
    static const double work[ERAS] = {16, 16, 32, 64, 128};
    tally_t known[2] = {{0}}, last[2] = {{0}}, all = {0};
    double shares[2] = {0.5, 0.5}, sum = 0, works = 0;
    for (int r = 0; r < ERAS; r++) {
        if (r > 1) { /* from all eras but the last one */
            shift_length_t lengths[2];
            for (int k = 0; k < 2; k++)
                lengths[k] = (shift_length_t){0.5, shares[k], tally_variance(&known[k]), 1, known[k].n, 0.01};
            double chosen[2];
            shift_shares(lengths, 2, chosen);
            shares[0] = chosen[0];
            shares[1] = chosen[1];
        }
        for (int k = 0; k < 2; k++) {
            known[k].n += last[k].n;
            known[k].sum += last[k].sum;
            known[k].squares += last[k].squares;
            last[k] = (tally_t){0};
            for (int i = (int)fmax(1, rint(shares[k] * work[r])); i > 0; i--)
                tally_add(&last[k], unit_of(k));
        }
        sum += work[r] * last[0].sum / last[0].n;
        works += work[r];
        all.n += last[0].n;
        all.sum += last[0].sum;
    }
    *weighted = sum / works;
    *pooled = all.sum / all.n;
}

static double standard_errors(const tally_t *tally)
{
    return (tally->sum / tally->n - 1) / sqrt(tally_variance(tally) / tally->n);
}

static void fixed_weights_have_no_bias_and_counts_have(void **state)
{
    (void)state;
    tally_t weighted = {0}, pooled = {0};
    for (int i = 0; i < RENDERS; i++) {
        double w, p;
        render(&w, &p);
        tally_add(&weighted, w);
        tally_add(&pooled, p);
    }
    const double right = standard_errors(&weighted), wrong = standard_errors(&pooled);
    print_message("by fixed weights %.4f (%.1f standard errors), by units %.4f (%.1f); variances %.4f, %.4f\n",
                  weighted.sum / weighted.n, right, pooled.sum / pooled.n, wrong, tally_variance(&weighted),
                  tally_variance(&pooled));
    assert_true(fabs(right) <= 5);
    assert_true(wrong < -10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shares_go_by_the_root_of_variance_over_cost),
        cmocka_unit_test(what_confirms_the_pilot_changes_nothing),
        cmocka_unit_test(shares_stay_in_bounds),
        cmocka_unit_test(fixed_weights_have_no_bias_and_counts_have),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
