/* The laboratory's charts: inverses, quadrature against plain Monte Carlo, six unbiased algorithms, exchanges in
 * detailed balance, and mistakes that these tests notice.
 *
 * Every comparison has a false-alarm rate of at most one in a million, were the seed not fixed: of COMPARISONS bins
 * at once each gets ALARM / COMPARISONS. Bins are means of independent chains that start in their law, so they are
 * unbiased without a burn-in; their means are taken for normal (Student's law, as the variance is estimated). */
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "client/lab/charted_report.h"
#include "support/near.h"

#define ALARM 1e-6
#define SEED 2385
#define LARGE 0.1 /* probability of a large step */

/* Bins of a picture: GRID x GRID blocks of three channels. Compared with them: the mean of w_1 in each chart. */
enum { GRID = 4, BINS = GRID * GRID * 3, COMPARISONS = BINS + CHARTED_CHARTS, CHAINS = 256, SAMPLES = 4096 };

#define assert_above(found, least)                                                                                 \
    do {                                                                                                           \
        const double found_ = (found), least_ = (least);                                                           \
        if (!(found_ > least_))                                                                                    \
            fail_msg("%s = %.9g, expected more than %.9g", #found, found_, least_);                                \
    } while (0)

static charted_picture_t reference;
static charted_setup_t setup;
static double exact[BINS];
static double weight_mean[CHARTED_CHARTS], weight_error[CHARTED_CHARTS]; /* of w_1 where the law is w_i f* / b_i */

static double limit(void)
{
    return gsl_cdf_tdist_Qinv(ALARM / COMPARISONS / 2, CHAINS - 1);
}

static int bin_of(double x, double y, int channel)
{
    return ((int)(y * GRID) * GRID + (int)(x * GRID)) * 3 + channel;
}

static void bins_of(const charted_picture_t *picture, double bins[BINS])
{
    const int each = CHARTED_SIDE / GRID;
    memset(bins, 0, BINS * sizeof *bins);
    for (int p = 0; p < CHARTED_PIXELS; p++)
        for (int c = 0; c < 3; c++) {
            const int row = p / CHARTED_SIDE / each, column = p % CHARTED_SIDE / each;
            bins[(row * GRID + column) * 3 + c] += picture->rgb[p][c] / (each * each);
        }
}

static void draw_weights(int chart)
{
    enum { DRAWS = 100000 };
    double sum = 0, squares = 0;
    stream_t stream = stream_of(SEED, 30 + (uint64_t)chart);
    for (int i = 0; i < DRAWS; i++) {
        const charted_path_t path = charted_draw(chart, &stream);
        const double w = charted_weight(&path, CHARTED_LIGHT);
        sum += w / DRAWS;
        squares += w * w / DRAWS;
    }
    weight_mean[chart] = sum;
    weight_error[chart] = sqrt((squares - sum * sum) / DRAWS);
}

static int prepare(void **state)
{
    (void)state;
    const double b = charted_reference(&reference);
    setup = (charted_setup_t){.constants = charted_constants(b, 1 << 16, SEED), .large = LARGE};
    bins_of(&reference, exact);
    draw_weights(CHARTED_LIGHT);
    draw_weights(CHARTED_DIRECTION);
    return 0;
}

/* ---- charts ---- */

static charted_path_t lit_sample(int chart, double u[CHARTED_NUMBERS], stream_t *stream)
{
    charted_path_t path;
    do {
        for (int d = 0; d < CHARTED_NUMBERS; d++)
            u[d] = stream_uniform(stream);
        path = charted_sample(chart, u);
    } while (!(path.target > 0));
    return path;
}

static double run_of(const charted_path_t *path)
{
    return fabs((path->light == 0 ? 0 : CHARTED_LIGHT2_X) - path->x);
}

/* Every path in both charts. A number is known to 1.1e-16, which the chart of the light stretches by 1 / (density)
 * at most: 27 for light 1's dark end. A direction's place on the light is at run / w.x times (w.y, w.z): an angle's
 * error (7e-16) counts d^2 / run, that of w.z = sqrt(1 - u), 1.1e-16 / w.z, counts d / w.z = d^2 / up. */
static void paths_come_back_from_both_charts(void **state)
{
    (void)state;
    stream_t stream = stream_of(SEED, 1);
    for (int i = 0; i < 40000; i++) {
        double u[CHARTED_NUMBERS], v[CHARTED_NUMBERS];
        const charted_path_t path = lit_sample(i % 2, u, &stream);
        const double run = run_of(&path), rise = path.across - path.y;
        const double square = run * run + rise * rise + path.up * path.up;
        for (int chart = 0; chart < CHARTED_CHARTS; chart++) {
            charted_invert(chart, &path, v);
            const charted_path_t back = charted_sample(chart, v);
            const double tolerance = chart == CHARTED_LIGHT ? 1e-14 : 1e-14 * (1 + square / run + square / path.up);
            assert_int_equal(back.light, path.light);
            assert_near(back.x, path.x, 0);
            assert_near(back.y, path.y, 0);
            assert_near(back.across, path.across, tolerance);
            assert_near(back.up, path.up, tolerance);
        }
    }
}

/* The inverse of a sample is the sample's own numbers: one to one, so that no interval has to be drawn in. */
static void numbers_come_back_from_their_paths(void **state)
{
    (void)state;
    stream_t stream = stream_of(SEED, 2);
    for (int chart = 0; chart < CHARTED_CHARTS; chart++)
        for (int i = 0; i < 20000; i++) {
            double u[CHARTED_NUMBERS], v[CHARTED_NUMBERS];
            const charted_path_t path = lit_sample(chart, u, &stream);
            charted_invert(chart, &path, v);
            /* directions: the light's point is known to some 1e-16, the angle to that over the run */
            const double tolerance = chart == CHARTED_LIGHT ? 1e-14 : 1e-14 * (1 + 1 / run_of(&path));
            for (int d = 0; d < CHARTED_NUMBERS; d++) {
                assert_true(v[d] >= 0 && v[d] < 1);
                assert_near(remainder(v[d] - u[d], 1), 0, tolerance);
            }
        }
}

/* Samples of both charts with the balance heuristic, against the quadrature: tells p_1, p_2, f and the quadrature.
 */
static void quadrature_is_what_plain_monte_carlo_gives(void **state)
{
    (void)state;
    enum { COUNT = 400000 };
    static double sums[CHARTED_CHARTS][BINS], squares[CHARTED_CHARTS][BINS];
    stream_t stream = stream_of(SEED, 3);
    double worst = 0;
    for (int chart = 0; chart < CHARTED_CHARTS; chart++)
        for (int i = 0; i < COUNT; i++) {
            double u[CHARTED_NUMBERS];
            for (int d = 0; d < CHARTED_NUMBERS; d++)
                u[d] = stream_uniform(&stream);
            const charted_path_t path = charted_sample(chart, u);
            if (!(path.target > 0))
                continue;
            const rgb_t colour = charted_colour(path.light, path.across);
            const double f = GRID * GRID * path.target / (path.density[0] + path.density[1]);
            const double values[3] = {f * colour.r, f * colour.g, f * colour.b};
            for (int c = 0; c < 3; c++) {
                const int bin = bin_of(path.x, path.y, c);
                sums[chart][bin] += values[c] / COUNT;
                squares[chart][bin] += values[c] * values[c] / COUNT;
            }
        }
    for (int k = 0; k < BINS; k++) {
        double sum = 0, variance = 0;
        for (int chart = 0; chart < CHARTED_CHARTS; chart++) {
            sum += sums[chart][k];
            variance += (squares[chart][k] - sums[chart][k] * sums[chart][k]) / COUNT;
        }
        worst = math_max(worst, fabs(sum - exact[k]) / sqrt(variance));
        assert_near(sum, exact[k], limit() * sqrt(variance));
    }
    print_message("farthest bin: %.2f of its standard errors, limit %.2f\n", worst, limit());
}

static void integrals_of_the_charts_sum_to_the_quadrature(void **state)
{
    (void)state;
    double e0, e1;
    const double first = charted_share(CHARTED_LIGHT, 1 << 14, SEED + 1, &e0);
    const double second = charted_share(CHARTED_DIRECTION, 1 << 14, SEED + 1, &e1);
    const charted_constants_t *b = &setup.constants;
    print_message("b = %.6f: %.6f +- %.6f and %.6f +- %.6f\n", b->all, first, e0, second, e1);
    /* each standard error is itself of CHARTED_SHIFTS values */
    assert_near(first + second, b->all, gsl_cdf_tdist_Qinv(ALARM / 2, CHARTED_SHIFTS - 1) * hypot(e0, e1));
    assert_near(b->of_chart[0] + b->of_chart[1], b->all, 1e-15);
    /* far below the noise of the chains here, which share the constants */
    assert_near(b->error / b->all, 0, 2e-4);
}

/* ---- chains ---- */

/* Sums over chains: of a figure and of its square. */
typedef struct figure {
    double sum, square;
} figure_t;

static void add_figure(figure_t *figure, double value)
{
    figure->sum += value;
    figure->square += value * value;
}

/* The distance of the figure's mean from what it should be, itself known to `error`, in standard errors. */
static double distance_of(const figure_t *figure, double wanted, double error)
{
    const double mean = figure->sum / CHAINS;
    const double variance = (figure->square / CHAINS - mean * mean) / (CHAINS - 1);
    return fabs(mean - wanted) / hypot(sqrt(variance), error);
}

/* How far CHAINS chains are from the exact law: the farthest bin of the picture, the farther chart's mean of w_1.
 */
typedef struct distances {
    double bin, weight;
} distances_t;

static double weight_distance(const figure_t *figure, int chart, bool weighted)
{
    const charted_constants_t *b = &setup.constants;
    if (weighted)
        return distance_of(figure, weight_mean[chart], weight_error[chart]);
    return distance_of(figure, b->of_chart[CHARTED_LIGHT] / b->all, b->error / b->all);
}

static distances_t distances(charted_algorithm_t algorithm, charted_mistake_t mistake, uint64_t first)
{
    charted_result_t *result = malloc(sizeof *result);
    const bool weighted = algorithm == CHARTED_MIX || algorithm == CHARTED_CMLT;
    figure_t figures[BINS] = {{0, 0}}, weights[CHARTED_CHARTS] = {{0, 0}};
    charted_setup_t wrong = setup;
    distances_t farthest = {0, 0};
    assert_non_null(result);
    wrong.mistake = mistake;
    for (int c = 0; c < CHAINS; c++) {
        double bins[BINS];
        stream_t stream = stream_of(SEED, first + (uint64_t)c);
        charted_run(result, algorithm, &wrong, SAMPLES, &stream);
        bins_of(&result->picture, bins);
        for (int k = 0; k < BINS; k++)
            add_figure(&figures[k], bins[k]);
        for (int i = 0; i < CHARTED_CHARTS; i++)
            if (result->samples[i] > 0)
                add_figure(&weights[i], result->weights[i] / result->samples[i]);
    }
    for (int k = 0; k < BINS; k++)
        farthest.bin = math_max(distance_of(&figures[k], exact[k], 0), farthest.bin);
    for (int i = 0; i < CHARTED_CHARTS; i++)
        if (weights[i].sum > 0)
            farthest.weight = math_max(weight_distance(&weights[i], i, weighted), farthest.weight);
    free(result);
    return farthest;
}

static void six_algorithms_are_unbiased(void **state)
{
    (void)state;
    for (int a = 0; a < CHARTED_ALGORITHMS; a++) {
        const distances_t d = distances((charted_algorithm_t)a, CHARTED_RIGHT, 1000 * (uint64_t)(a + 1));
        print_message("%s: farthest bin %.2f of its standard errors, w_1 %.2f, limit %.2f\n", charted_names[a],
                      d.bin, d.weight, limit());
        assert_near(d.bin, 0, limit());
        assert_near(d.weight, 0, limit());
    }
}

static void wrong_acceptance_ratios_are_noticed(void **state)
{
    (void)state;
    const distances_t swaps = distances(CHARTED_CMLT, CHARTED_SWAP_ALWAYS, 10000);
    const distances_t densities = distances(CHARTED_IPSM, CHARTED_WITHOUT_DENSITY, 11000);
    print_message("exchanges always accepted: bin %.1f, w_1 %.1f; densities left out: %.1f, %.1f; limit %.2f\n",
                  swaps.bin, swaps.weight, densities.bin, densities.weight, limit());
    assert_above(swaps.weight, limit());
    assert_above(densities.bin, limit());
}

/* ---- exchanges ---- */

/* Classes of paths by what the exchange depends on, log2(p_1 / p_2), in steps of one from -4 to 4. */
enum { CLASSES = 8, PAIRS = 200000 };

static int class_of(const charted_path_t *path)
{
    const double place = log2(path->density[0] / path->density[1]) + CLASSES / 2;
    return (int)math_min(math_max(place, 0), CLASSES - 1);
}

/* Pairs of paths from their exact law, one exchange each. In detailed balance as many go from classes (a, b) to
 * (b, a) as back: of their number n half, by the binomial law. Returns the chi-square probability of all (a, b). */
static double balance(charted_mistake_t mistake, uint64_t number)
{
    static double flow[CLASSES][CLASSES];
    double statistic = 0;
    int freedoms = 0;
    stream_t stream = stream_of(SEED, number);
    memset(flow, 0, sizeof flow);
    for (int i = 0; i < PAIRS; i++) {
        charted_chain_t chains[CHARTED_CHARTS];
        for (int c = 0; c < CHARTED_CHARTS; c++)
            chains[c].path = charted_draw(c, &stream);
        const int a = class_of(&chains[0].path), b = class_of(&chains[1].path);
        if (!charted_swap(chains, mistake, &stream))
            continue;
        assert_int_equal(class_of(&chains[0].path), b);
        assert_int_equal(class_of(&chains[1].path), a);
        flow[a][b]++;
    }
    for (int a = 0; a < CLASSES; a++)
        for (int b = 0; b < a; b++) {
            const double there = flow[a][b], back = flow[b][a];
            if (there + back < 50) /* the normal law does for the others */
                continue;
            statistic += (there - back) * (there - back) / (there + back);
            freedoms++;
        }
    assert_true(freedoms >= 10);
    print_message("chi-square %.1f of %d\n", statistic, freedoms);
    return gsl_cdf_chisq_Q(statistic, freedoms);
}

static void exchanges_are_in_detailed_balance(void **state)
{
    (void)state;
    assert_above(balance(CHARTED_RIGHT, 20), ALARM);
    assert_above(ALARM, balance(CHARTED_SWAP_ALWAYS, 21)); /* and the test would notice */
}

/* After an exchange the numbers are those of the new paths. */
static void exchanges_leave_each_chain_in_its_chart(void **state)
{
    (void)state;
    stream_t stream = stream_of(SEED, 22);
    int accepted = 0;
    for (int i = 0; i < 1000; i++) {
        charted_chain_t chains[CHARTED_CHARTS];
        for (int c = 0; c < CHARTED_CHARTS; c++) {
            chains[c].path = charted_draw(c, &stream);
            charted_invert(c, &chains[c].path, chains[c].u);
        }
        accepted += charted_swap(chains, CHARTED_RIGHT, &stream);
        for (int c = 0; c < CHARTED_CHARTS; c++) {
            double u[CHARTED_NUMBERS];
            charted_invert(c, &chains[c].path, u);
            assert_memory_equal(u, chains[c].u, sizeof u);
        }
    }
    assert_in_range(accepted, 100, 999);
}

/* ---- errors ---- */

static charted_figures_t *measured(charted_algorithm_t algorithm, uint64_t first)
{
    charted_figures_t *figures = malloc(sizeof *figures);
    assert_non_null(figures);
    charted_report_measure(figures, algorithm, &setup, &reference, 20000, 128, SEED, first);
    return figures;
}

/* By how many standard errors the quotient of errors is below one. */
static double below(const charted_figures_t *better, const charted_figures_t *worse)
{
    double error;
    const double quotient = charted_report_quotient(better, worse, &error);
    print_message("%.3f +- %.3f\n", quotient, error);
    return (1 - quotient) / error;
}

/* The paper's conclusion about two chains: weights belong in the targets; weighted afterwards, two chains are worse
 * than one. Its other differences are a few hundredths here: too small for a test. */
static void weighted_targets_beat_weighted_samples(void **state)
{
    (void)state;
    charted_figures_t *second = measured(CHARTED_PSSMLT_2, 20000);
    charted_figures_t *average = measured(CHARTED_AVERAGE, 21000);
    charted_figures_t *mix = measured(CHARTED_MIX, 22000);
    const double normal_limit = gsl_cdf_ugaussian_Qinv(ALARM);
    assert_above(below(mix, average), normal_limit);
    assert_above(below(second, average), normal_limit);
    free(second);
    free(average);
    free(mix);
}

/* ---- the report ---- */

static void report_is_a_function_of_steps_and_seed(void **state)
{
    (void)state;
    char *texts[3];
    charted_report_t *report = calloc(1, sizeof *report);
    assert_non_null(report);
    for (int i = 0; i < 3; i++) {
        charted_report_run(report, 20000, LARGE, i < 2 ? 7 : 8);
        json_t *json = charted_report_json(report);
        texts[i] = json_print(json, false);
        json_destroy(&json);
    }
    assert_string_equal(texts[0], texts[1]);
    assert_string_not_equal(texts[0], texts[2]);
    assert_null(strstr(texts[0], "null")); /* figures are finite */
    for (int i = 0; i < 3; i++)
        free(texts[i]);
    free(report);
}

static void montage_shows_all_pictures(void **state)
{
    (void)state;
    charted_report_t *report = calloc(1, sizeof *report);
    fault_t fault = {0};
    image_t image;
    assert_non_null(report);
    report->reference = reference;
    for (int n = 0; n < CHARTED_REPORT_COUNTS; n++)
        for (int a = 0; a < CHARTED_ALGORITHMS; a++)
            for (int p = 0; p < CHARTED_PIXELS; p++)
                for (int c = 0; c < 3; c++)
                    report->figures[n][a].picture.rgb[p][c] = reference.rgb[p][c] * (2 + n + 2 * a);
    assert_int_equal(charted_report_montage(report, &image, &fault), FAULT_NONE);
    double sum = 0, wanted = 0;
    for (size_t i = 0; i < (size_t)3 * image.width * image.height; i++)
        sum += (double)image.data[i];
    for (int p = 0; p < CHARTED_PIXELS; p++)
        for (int c = 0; c < 3; c++)
            wanted += reference.rgb[p][c] * 4; /* a pixel is 2 x 2 */
    /* 2 references, algorithms 2 + n + 2 a: 2 + 2 (2 + 4 + .. + 12) + 6; sums in single precision pixels */
    assert_near(sum / wanted, 2 + 84 + 6, 1e-5);
    assert_true(charted_report_exposure(report) > 0 && isfinite(charted_report_exposure(report)));
    image_clear(&image);
    free(report);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(paths_come_back_from_both_charts),
        cmocka_unit_test(numbers_come_back_from_their_paths),
        cmocka_unit_test(quadrature_is_what_plain_monte_carlo_gives),
        cmocka_unit_test(integrals_of_the_charts_sum_to_the_quadrature),
        cmocka_unit_test(six_algorithms_are_unbiased),
        cmocka_unit_test(wrong_acceptance_ratios_are_noticed),
        cmocka_unit_test(exchanges_are_in_detailed_balance),
        cmocka_unit_test(exchanges_leave_each_chain_in_its_chart),
        cmocka_unit_test(weighted_targets_beat_weighted_samples),
        cmocka_unit_test(report_is_a_function_of_steps_and_seed),
        cmocka_unit_test(montage_shows_all_pictures),
    };
    return cmocka_run_group_tests(tests, prepare, NULL);
}
