/* The laboratory: techniques and inverses, right and wrong chains against exact laws, failed proposals, published
 * figures.
 *
 * Noise. A figure comes from CHAINS independent chains that start in (or next to) their law. Their spread gives
 * each bin's standard error se_k without the exact law; S = 1/2 sum se_k. If all bins moved together, the total
 * variation of a right chain were S |t|, t of Student's law with CHAINS - 1 degrees of freedom; if they don't it is
 * more concentrated (for normal errors P(TV > E TV + r S) <= exp(-r^2 / 2), Borell 1975, and E TV <= 0.8 S). The
 * bound is S times t's quantile: one false alarm in a million for each comparison, were the seed not fixed. */
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "client/lab/failure_report.h"
#include "client/lab/jump_report.h"
#include "support/near.h"

enum { CHAINS = 64 };
#define ALARM 1e-6
#define SEED 2385

#define assert_above(found, least)                                                                                 \
    do {                                                                                                           \
        const double found_ = (found), least_ = (least);                                                           \
        if (!(found_ > least_))                                                                                    \
            fail_msg("%s = %.9g, expected more than %.9g", #found, found_, least_);                                \
    } while (0)

static double normal_limit(void)
{
    return gsl_cdf_ugaussian_Qinv(ALARM / 2);
}

static double student_limit(void)
{
    return gsl_cdf_tdist_Qinv(ALARM / 2, CHAINS - 1);
}

/* S times the limit; histogram_noise is sqrt(2/pi) S. */
static double bound_of(const histogram_t chains[CHAINS])
{
    return histogram_noise(chains, CHAINS) / sqrt(2 / MATH_PI) * student_limit();
}

/* ---- histograms ---- */

static void histograms_weigh_and_compare(void **state)
{
    (void)state;
    histogram_t h = histogram_make(-3, 9, 4);
    histogram_add(&h, -3, 1);
    histogram_add(&h, 8.999, 2);
    histogram_add(&h, 9, 3); /* outside: only in the total */
    histogram_add(&h, -3.001, 2);
    const double exact[4] = {0.25, 0.25, 0.25, 0.25};
    assert_near(h.total, 8, 0);
    assert_near(h.weight[0], 1, 0);
    assert_near(h.weight[3], 2, 0);
    assert_near(histogram_total_variation(&h, exact), 0.5 * (0.125 + 0.25 + 0.25 + 0), 1e-15);
    assert_near(histogram_mean_square(&h, exact), (0.125 * 0.125 + 2 * 0.0625) / 4, 1e-15);
}

/* Independent numbers: the share of a bin has the variance p (1-p) / n. */
static void noise_of_independent_numbers_is_the_binomial_one(void **state)
{
    (void)state;
    enum { BINS = 20, COUNT = 2000 };
    histogram_t parts[CHAINS];
    for (int c = 0; c < CHAINS; c++) {
        stream_t stream = stream_of(SEED, (uint64_t)c);
        parts[c] = histogram_make(0, 1, BINS);
        for (int i = 0; i < COUNT; i++)
            histogram_add(&parts[c], stream_uniform(&stream), 1);
    }
    const double p = 1.0 / BINS;
    const double wanted = 0.5 * sqrt(2 / MATH_PI) * BINS * sqrt(p * (1 - p) / COUNT / CHAINS);
    /* a standard error from 64 values is off by 1 in sqrt(2 * 63), all bins alike at worst */
    assert_near(histogram_noise(parts, CHAINS), wanted, normal_limit() * wanted / sqrt(2.0 * (CHAINS - 1)));
}

static void normal_numbers_are_normal(void **state)
{
    (void)state;
    enum { COUNT = 200000, BINS = 40 };
    double counts[BINS] = {0}, statistic = 0;
    stream_t stream = stream_of(SEED, 99);
    for (int i = 0; i < COUNT; i++)
        counts[(int)(BINS * gsl_cdf_ugaussian_P(stream_normal(&stream)))]++;
    for (int k = 0; k < BINS; k++)
        statistic +=
            (counts[k] - (double)COUNT / BINS) * (counts[k] - (double)COUNT / BINS) / ((double)COUNT / BINS);
    assert_above(gsl_cdf_chisq_Q(statistic, BINS - 1), ALARM);
}

/* ---- techniques ---- */

/* u is known to 1.1e-16 and x moves by that over the density of a part: at least 0.003 here, three roundings. */
static void samples_of_inverses_return(void **state)
{
    (void)state;
    stream_t stream = stream_of(SEED, 0);
    for (int t = 0; t < TECHNIQUES; t++)
        for (int i = 0; i < 20000; i++) {
            const double x = 0.001 + 0.998 * stream_uniform(&stream);
            const double part = stream_uniform(&stream), within = stream_uniform(&stream);
            const technique_numbers_t u = techniques_invert(t, x, part, within);
            assert_true(u.place >= 0 && u.place < 1 && u.choice >= 0 && u.choice < 1);
            assert_near(techniques_sample(t, u), x, 1.2e-13);
        }
}

/* Where x has the density p, a right inverse's numbers are uniform on the square: chi-square over 12 x 20 cells,
 * whose borders include those of all intervals. x comes from p by rejection: samplers have no part in it. */
static void inverses_give_uniform_numbers(void **state)
{
    (void)state;
    enum { COLUMNS = 12, ROWS = 20, COUNT = 240000 };
    for (int t = 0; t < TECHNIQUES; t++) {
        double counts[COLUMNS][ROWS] = {{0}}, statistic = 0;
        const double expected = (double)COUNT / (COLUMNS * ROWS);
        stream_t stream = stream_of(SEED, 10 + (uint64_t)t);
        for (int i = 0; i < COUNT;) {
            const double x = stream_uniform(&stream);
            if (stream_uniform(&stream) * 2.1 >= techniques_pdf(t, x)) /* 2.1: above every density */
                continue;
            const double part = stream_uniform(&stream), within = stream_uniform(&stream);
            const technique_numbers_t u = techniques_invert(t, x, part, within);
            counts[(int)(u.place * COLUMNS)][(int)(u.choice * ROWS)]++;
            i++;
        }
        for (int a = 0; a < COLUMNS; a++)
            for (int b = 0; b < ROWS; b++)
                statistic += (counts[a][b] - expected) * (counts[a][b] - expected) / expected;
        const double chance = gsl_cdf_chisq_Q(statistic, COLUMNS * ROWS - 1);
        if (!(chance >= ALARM))
            fail_msg("%s: chi-square %g, chance %g", techniques_names[t], statistic, chance);
    }
}

static void exact_shares_are_the_known_ones(void **state)
{
    (void)state;
    const double known[TECHNIQUES] = {0.273, 0.367, 0.360};
    double sum = 0;
    for (int t = 0; t < TECHNIQUES; t++) {
        double parts = 0;
        for (int k = 0; k < 12; k++)
            parts += techniques_exact_share(t, k / 12.0, (k + 1) / 12.0);
        assert_near(techniques_exact_share(t, 0, 1), known[t], 0.0005);
        assert_near(techniques_exact_share(t, 0, 1), parts, 1e-7);
        sum += parts;
    }
    assert_near(sum, techniques_target_integral(1), 1e-9);
}

/* ---- reversible jumps ---- */

typedef struct jump_chains {
    jump_result_t results[CHAINS];
    histogram_t all[CHAINS];
    double total_variation, bound;
} jump_chains_t;

static jump_chains_t *run_jumps(jump_variant_t variant, double step, uint64_t steps)
{
    static jump_chains_t chains;
    double exact[JUMP_BINS];
    for (int c = 0; c < CHAINS; c++) {
        stream_t stream = stream_of(SEED, 1000 * (uint64_t)(variant + 1) + (uint64_t)c);
        jump_run(&chains.results[c], variant, step, steps / CHAINS, &stream);
        chains.all[c] = chains.results[c].all;
    }
    const histogram_t sum = histogram_sum(chains.all, CHAINS);
    jump_exact(exact);
    chains.total_variation = histogram_total_variation(&sum, exact);
    chains.bound = bound_of(chains.all);
    print_message("%-12s step %g: total variation %.4f, bound of a right chain %.4f\n", jump_names[variant], step,
                  chains.total_variation, chains.bound);
    return &chains;
}

/* The share of technique t over the chains against `wanted`, by Student's t. */
static void assert_share(const jump_chains_t *chains, int t, double wanted)
{
    double sum = 0, squares = 0;
    for (int c = 0; c < CHAINS; c++) {
        const double share = chains->results[c].by[t].total / chains->results[c].all.total;
        sum += share;
        squares += share * share;
    }
    const double mean = sum / CHAINS, variance = (squares / CHAINS - mean * mean) / (CHAINS - 1);
    assert_near(mean, wanted, student_limit() * sqrt(variance));
}

static void assert_right(jump_variant_t variant, double step, uint64_t steps)
{
    const jump_chains_t *chains = run_jumps(variant, step, steps);
    assert_near(chains->total_variation, 0, chains->bound);
    for (int t = 0; t < TECHNIQUES; t++)
        assert_share(chains, t, techniques_exact_share(t, 0, 1));
}

static void full_jumps_keep_the_target(void **state)
{
    (void)state;
    assert_right(JUMP_FULL, 0.02, 8000000);
    assert_right(JUMP_FULL, 0.1, 2000000);
}

static void multiplexed_steps_keep_the_target(void **state)
{
    (void)state;
    assert_right(JUMP_MULTIPLEXED, 0.1, 2000000);
}

/* Bounds: half of the independent program's figures, 0.09, 0.10 and 0.12. By the triangle inequality a false alarm
 * needs noise of that half, beyond the bound of a right chain (asserted). */
static const double wrong_least[] = {[JUMP_NO_JACOBIAN] = 0.045, [JUMP_FIXED_POINT] = 0.05, [JUMP_NEITHER] = 0.06};

static void wrong_jumps_miss_the_target(void **state)
{
    (void)state;
    for (int v = JUMP_NO_JACOBIAN; v <= JUMP_NEITHER; v++) {
        const jump_chains_t *chains = run_jumps((jump_variant_t)v, 0.02, 4000000);
        assert_above(wrong_least[v], chains->bound);
        assert_above(chains->total_variation, wrong_least[v]);
        if (v == JUMP_NO_JACOBIAN) /* 0.09 in two digits */
            assert_near(chains->total_variation, 0.09, 0.005 + chains->bound);
        /* every jump is accepted, among others alike: the technique is a chain of its own, with equal shares */
        for (int t = 0; t < TECHNIQUES && v != JUMP_FIXED_POINT; t++)
            assert_share(chains, t, 1.0 / TECHNIQUES);
    }
}

/* ---- failed proposals ---- */

static histogram_t run_failures(histogram_t chains[CHAINS], failure_method_t method, double sigma,
                                uint64_t evaluations)
{
    for (int c = 0; c < CHAINS; c++) {
        stream_t stream = stream_of(SEED, 20000 + 1000 * (uint64_t)method + (uint64_t)c);
        failures_run(&chains[c], method, sigma, evaluations / CHAINS, &stream);
    }
    return histogram_sum(chains, CHAINS);
}

static double distance(const double *a, const double *b)
{
    double sum = 0;
    for (int k = 0; k < FAILURE_BINS; k++)
        sum += 0.5 * fabs(a[k] - b[k]);
    return sum;
}

/* The share of the bins where the rectified law is above the target: the law has `predicted`, the total variation,
 * more of it than the target. One number for each chain, so that Student's t sees more than the bound on all bins
 * does. */
static double excess_share(const double *share, const double *law, const double *exact)
{
    double sum = 0;
    for (int k = 0; k < FAILURE_BINS; k++)
        sum += law[k] > exact[k] ? share[k] : 0;
    return sum;
}

/* The chains' excess share is `wanted`; returns the tolerance. */
static double assert_excess_share(const histogram_t chains[CHAINS], const double *law, const double *exact,
                                  double wanted)
{
    double sum = 0, squares = 0;
    for (int c = 0; c < CHAINS; c++) {
        const double share = excess_share(chains[c].weight, law, exact) / chains[c].total;
        sum += share - wanted;
        squares += (share - wanted) * (share - wanted);
    }
    const double mean = sum / CHAINS, variance = (squares / CHAINS - mean * mean) / (CHAINS - 1);
    const double tolerance = student_limit() * sqrt(variance);
    assert_near(mean, 0, tolerance);
    return tolerance;
}

static void rectified_chains_follow_their_law(void **state)
{
    (void)state;
    /* the independent program's figures, in two digits; its noise at 10^7 steps is below 0.002 */
    const double sigmas[5] = {0.01, 0.03, 0.1, 0.3, 1}, known[5] = {0.0076, 0.021, 0.054, 0.071, 0.015};
    double law[FAILURE_BINS], exact[FAILURE_BINS];
    histogram_t chains[CHAINS];
    failures_exact(exact);
    for (int i = 0; i < 5; i++) {
        const double failure = failures_law(sigmas[i], law), predicted = distance(law, exact);
        assert_true(failure > 0 && failure < 1);
        assert_near(predicted, known[i], 0.0005 + 0.002);
        const histogram_t sum = run_failures(chains, FAILURE_RECTIFIED, sigmas[i], 2000000);
        const double bound = bound_of(chains), from_law = histogram_total_variation(&sum, law);
        const double tolerance = assert_excess_share(chains, law, exact, excess_share(law, law, exact));
        print_message("sigma %g: law %.4f from the target, chains %.4f, %.4f from the law (bounds %.4f, %.4f)\n",
                      sigmas[i], predicted, histogram_total_variation(&sum, exact), from_law, bound, tolerance);
        assert_near(from_law, 0, bound);
        if (sigmas[i] > 0.05) /* the law is told from the target */
            assert_above(predicted, tolerance);
    }
}

static void unbiased_methods_keep_the_target(void **state)
{
    (void)state;
    const failure_method_t methods[4] = {FAILURE_PLAIN, FAILURE_EXPECTED, FAILURE_DELAYED, FAILURE_BOTH};
    const double sigmas[3] = {0.1, 0.3, 1};
    double exact[FAILURE_BINS], law[FAILURE_BINS];
    histogram_t chains[CHAINS];
    failures_exact(exact);
    for (int m = 0; m < 4; m++)
        for (int s = 0; s < 3; s++) {
            const histogram_t sum = run_failures(chains, methods[m], sigmas[s], 2000000);
            failures_law(sigmas[s], law);
            const double tolerance = assert_excess_share(chains, law, exact, excess_share(exact, law, exact));
            print_message("sigma %g, %s: %.4f, bounds %.4f, %.4f\n", sigmas[s], failures_names[methods[m]],
                          histogram_total_variation(&sum, exact), bound_of(chains), tolerance);
            assert_near(histogram_total_variation(&sum, exact), 0, bound_of(chains));
            assert_above(distance(law, exact), tolerance); /* the published bias would be seen */
        }
}

static void random_failures_reproduce_the_published_table(void **state)
{
    (void)state;
    /* [p][plain, rectified]: the paper's table 2, 100 runs; an independent program, more runs */
    const double rates[2] = {0.4, 0.6}, paper[2][2] = {{0.006834, 0.006370}, {0.008760, 0.007728}},
                 program[2][2] = {{0.00694, 0.00645}, {0.00877, 0.00789}};
    enum { RUNS = 800, PAPER_RUNS = 100 };
    for (int i = 0; i < 2; i++) {
        random_failures_error_t e[2];
        for (int rectified = 0; rectified < 2; rectified++) {
            e[rectified] = random_failures_measure(rates[i], rectified, RUNS, SEED,
                                                   40000 + 2000 * (uint64_t)(2 * i + rectified));
            const double published = e[rectified].error * sqrt((double)RUNS / PAPER_RUNS);
            const double tolerance = normal_limit() * hypot(e[rectified].error, published);
            print_message("p %.1f: %.5f +- %.5f (published %.5f)\n", rates[i], e[rectified].mean,
                          e[rectified].error, paper[i][rectified]);
            assert_near(e[rectified].mean, paper[i][rectified], tolerance);
            assert_near(e[rectified].mean, program[i][rectified], tolerance);
        }
        /* with constant probability the remedy is unbiased, and better at this length */
        assert_above(e[0].mean - e[1].mean, normal_limit() * hypot(e[0].error, e[1].error) / 2);
    }
}

static void squared_errors_are_the_known_ones(void **state)
{
    (void)state;
    /* [method][sigma .1, .3, 1], relative to plain, in two digits: an independent program, of about as many runs */
    const double sigmas[3] = {0.1, 0.3, 1};
    const double known[FAILURE_METHODS][3] = {
        {1, 1, 1}, {3.9, 4.1, 0.79}, {0.94, 0.86, 0.93}, {1.01, 0.86, 0.49}, {0.97, 0.70, 0.41}};
    enum { RUNS = 160, EVALUATIONS = 10000 };
    for (int s = 0; s < 3; s++) {
        failure_error_t plain = {0, 0};
        for (int m = 0; m < FAILURE_METHODS; m++) {
            const failure_error_t e = failures_measure((failure_method_t)m, sigmas[s], EVALUATIONS, RUNS, SEED,
                                                       60000 + 1000 * (uint64_t)(3 * m + s));
            if (m == FAILURE_PLAIN) {
                plain = e;
                continue;
            }
            const failure_error_t ratio = failure_report_ratio(e, plain);
            const double rounding = known[m][s] > 1.5 ? 0.05 : 0.005;
            print_message("sigma %g, %s: %.3f +- %.3f (known %.2f)\n", sigmas[s], failures_names[m], ratio.mean,
                          ratio.error, known[m][s]);
            assert_near(ratio.mean, known[m][s], rounding + normal_limit() * sqrt(2) * ratio.error);
            if (m == FAILURE_BOTH && s > 0)
                assert_above(1 - ratio.mean, normal_limit() * ratio.error);
        }
    }
}

/* ---- reports ---- */

static char *json_text(json_t *json)
{
    char *text = json_print(json, false);
    json_destroy(&json);
    return text;
}

static void assert_picture(char *svg, const char *word)
{
    const size_t length = strlen(svg);
    assert_memory_equal(svg, "<svg ", 5);
    assert_true(length > 7 && strcmp(svg + length - 7, "</svg>\n") == 0);
    assert_non_null(strstr(svg, word));
    assert_null(strstr(svg, "nan"));
    assert_null(strstr(svg, "inf"));
    free(svg);
}

static void reports_are_functions_of_steps_and_seed(void **state)
{
    (void)state;
    static jump_report_t jumps[3];
    static failure_report_t failures[3];
    char *texts[3][2];
    for (int i = 0; i < 3; i++) {
        jump_report_run(&jumps[i], 20000, i < 2 ? 7 : 8);
        failure_report_run(&failures[i], 20000, i < 2 ? 7 : 8);
        texts[i][0] = json_text(jump_report_json(&jumps[i]));
        texts[i][1] = json_text(failure_report_json(&failures[i]));
    }
    for (int k = 0; k < 2; k++) {
        assert_string_equal(texts[0][k], texts[1][k]);
        assert_string_not_equal(texts[0][k], texts[2][k]);
        assert_null(strstr(texts[0][k], "null")); /* figures are finite */
    }
    assert_picture(jump_report_svg(&jumps[0]), "no Jacobian");
    assert_picture(failure_report_svg(&failures[0]), "delayed rejection");
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 2; k++)
            free(texts[i][k]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(histograms_weigh_and_compare),
        cmocka_unit_test(noise_of_independent_numbers_is_the_binomial_one),
        cmocka_unit_test(normal_numbers_are_normal),
        cmocka_unit_test(samples_of_inverses_return),
        cmocka_unit_test(inverses_give_uniform_numbers),
        cmocka_unit_test(exact_shares_are_the_known_ones),
        cmocka_unit_test(full_jumps_keep_the_target),
        cmocka_unit_test(multiplexed_steps_keep_the_target),
        cmocka_unit_test(wrong_jumps_miss_the_target),
        cmocka_unit_test(rectified_chains_follow_their_law),
        cmocka_unit_test(unbiased_methods_keep_the_target),
        cmocka_unit_test(random_failures_reproduce_the_published_table),
        cmocka_unit_test(squared_errors_are_the_known_ones),
        cmocka_unit_test(reports_are_functions_of_steps_and_seed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
