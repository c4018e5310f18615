#include "client/lab/failure_report.h"

#include <inttypes.h>
#include <math.h>

#include "client/lab/plot.h"

/* Streams of one figure; figures' streams are this far apart. */
#define STREAMS UINT64_C(1000000)

void failure_report_measure_law(failure_law_t *law, double sigma, uint64_t evaluations, uint64_t seed,
                                uint64_t first)
{
    histogram_t chains[FAILURE_REPORT_CHAINS];
    double exact[FAILURE_BINS], predicted[FAILURE_BINS];
    for (int c = 0; c < FAILURE_REPORT_CHAINS; c++) {
        stream_t stream = stream_of(seed, first + (uint64_t)c);
        failures_run(&chains[c], FAILURE_RECTIFIED, sigma, evaluations / FAILURE_REPORT_CHAINS, &stream);
    }
    const histogram_t all = histogram_sum(chains, FAILURE_REPORT_CHAINS);
    law->sigma = sigma;
    law->mean_failure = failures_law(sigma, predicted);
    failures_exact(exact);
    law->measured = histogram_total_variation(&all, exact);
    law->from_law = histogram_total_variation(&all, predicted);
    law->noise = histogram_noise(chains, FAILURE_REPORT_CHAINS);
    law->predicted = 0;
    for (int k = 0; k < FAILURE_BINS; k++) {
        law->predicted += 0.5 * fabs(predicted[k] - exact[k]);
        law->states[k] = all.weight[k] / all.total;
    }
}

failure_error_t failure_report_ratio(failure_error_t a, failure_error_t b)
{
    const double ratio = a.mean / b.mean;
    return (failure_error_t){ratio, ratio * hypot(a.error / a.mean, b.error / b.mean)};
}

static void measure_errors(failure_report_t *r, uint64_t first)
{
    for (int s = 0; s < FAILURE_REPORT_SIGMAS; s++) {
        failure_error_t plain = {0, 0};
        for (int m = 0; m < FAILURE_METHODS; m++) {
            const failure_error_t e =
                failures_measure((failure_method_t)m, r->sigmas[s], FAILURE_REPORT_EVALUATIONS, r->runs, r->seed,
                                 first + (uint64_t)(s * FAILURE_METHODS + m) * STREAMS);
            if (m == FAILURE_PLAIN)
                plain = e;
            r->relative[s][m] = m == FAILURE_PLAIN ? (failure_error_t){1, 0} : failure_report_ratio(e, plain);
        }
    }
}

void failure_report_run(failure_report_t *r, uint64_t steps, uint64_t seed)
{
    static const double rates[FAILURE_REPORT_RATES] = {0.4, 0.6}, sigmas[FAILURE_REPORT_SIGMAS] = {0.1, 0.3, 1},
                        laws[FAILURE_REPORT_LAWS] = {0.01, 0.03, 0.1, 0.3, 1};
    r->steps = steps;
    r->seed = seed;
    r->runs = (int)(steps / FAILURE_REPORT_EVALUATIONS);
    r->table_runs = (int)(steps / RANDOM_FAILURES_PROPOSALS);
    uint64_t first = 0;
    for (int i = 0; i < FAILURE_REPORT_RATES; i++) {
        r->rates[i] = rates[i];
        for (int rectified = 0; rectified < 2; rectified++, first += STREAMS)
            r->table[i][rectified] = random_failures_measure(rates[i], rectified, r->table_runs, seed, first);
    }
    for (int i = 0; i < FAILURE_REPORT_LAWS; i++, first += STREAMS)
        failure_report_measure_law(&r->laws[i], laws[i], steps, seed, first);
    for (int i = 0; i < FAILURE_REPORT_SIGMAS; i++)
        r->sigmas[i] = sigmas[i];
    measure_errors(r, first);
}

/* ---- text ---- */

static void print_table(const failure_report_t *r, FILE *out)
{
    fprintf(out,
            "Random failures of constant probability p (table 2 of the paper): normal target, %d proposals,\n"
            "root mean square error over %d bins, mean of %d runs.\n\n"
            "p    plain                 rectified\n",
            RANDOM_FAILURES_PROPOSALS, RANDOM_FAILURES_BINS, r->table_runs);
    for (int i = 0; i < FAILURE_REPORT_RATES; i++)
        fprintf(out, "%.1f  %.5f +- %.5f  %.5f +- %.5f\n", r->rates[i], r->table[i][0].mean, r->table[i][0].error,
                r->table[i][1].mean, r->table[i][1].error);
}

static void print_laws(const failure_report_t *r, FILE *out)
{
    fprintf(out,
            "\nTarget 2x on [0,1], normal steps of sigma, failures not counted: total variation (%d bins) from 2x, "
            "as the\n"
            "law f (1 - p_fail) predicts it and as chains of %" PRIu64
            " steps have it; the chains' from the law; noise.\n\n"
            "sigma  failures  predicted  measured  from the law  noise\n",
            FAILURE_BINS, r->steps);
    for (int i = 0; i < FAILURE_REPORT_LAWS; i++) {
        const failure_law_t *l = &r->laws[i];
        fprintf(out, "%-5g  %-8.4f  %-9.4f  %-8.4f  %-12.4f  %.4f\n", l->sigma, l->mean_failure, l->predicted,
                l->measured, l->from_law, l->noise);
    }
}

void failure_report_print(const failure_report_t *r, FILE *out)
{
    fprintf(out, "Rectified proposal failures (2019); seed %" PRIu64 ".\n", r->seed);
    print_table(r, out);
    print_laws(r, out);
    fprintf(out,
            "\nMean squared error relative to plain Metropolis-Hastings at %d target evaluations, %d runs;\n"
            "rectified is biased, the others are not.\n\n"
            "method            ",
            FAILURE_REPORT_EVALUATIONS, r->runs);
    for (int s = 0; s < FAILURE_REPORT_SIGMAS; s++)
        fprintf(out, " sigma %-8g", r->sigmas[s]);
    fputc('\n', out);
    for (int m = 0; m < FAILURE_METHODS; m++) {
        fprintf(out, "%-18s", failures_names[m]);
        for (int s = 0; s < FAILURE_REPORT_SIGMAS; s++)
            fprintf(out, " %.3f +- %.3f ", r->relative[s][m].mean, r->relative[s][m].error);
        fputc('\n', out);
    }
    fputc('\n', out);
}

/* ---- JSON ---- */

static json_t *estimate_json(double mean, double error)
{
    json_t *json = json_new_object();
    json_add_number(json, "mean", mean);
    json_add_number(json, "standard_error", error);
    return json;
}

static json_t *table_json(const failure_report_t *r)
{
    json_t *rows = json_new_array();
    for (int i = 0; i < FAILURE_REPORT_RATES; i++) {
        json_t *row = json_new_object();
        json_add_number(row, "failure_probability", r->rates[i]);
        json_add(row, "plain", estimate_json(r->table[i][0].mean, r->table[i][0].error));
        json_add(row, "rectified", estimate_json(r->table[i][1].mean, r->table[i][1].error));
        json_append(rows, row);
    }
    return rows;
}

static json_t *laws_json(const failure_report_t *r)
{
    json_t *rows = json_new_array();
    for (int i = 0; i < FAILURE_REPORT_LAWS; i++) {
        json_t *row = json_new_object();
        json_add_number(row, "sigma", r->laws[i].sigma);
        json_add_number(row, "mean_failure", r->laws[i].mean_failure);
        json_add_number(row, "predicted", r->laws[i].predicted);
        json_add_number(row, "measured", r->laws[i].measured);
        json_add_number(row, "from_law", r->laws[i].from_law);
        json_add_number(row, "noise", r->laws[i].noise);
        json_append(rows, row);
    }
    return rows;
}

json_t *failure_report_json(const failure_report_t *r)
{
    json_t *json = json_new_object(), *errors = json_new_array();
    json_add_u64(json, "steps", r->steps);
    json_add_u64(json, "seed", r->seed);
    json_add(json, "random_failures", table_json(r));
    json_add(json, "rectified_law", laws_json(r));
    for (int s = 0; s < FAILURE_REPORT_SIGMAS; s++) {
        json_t *row = json_new_object();
        json_add_number(row, "sigma", r->sigmas[s]);
        for (int m = 0; m < FAILURE_METHODS; m++)
            json_add(row, failures_names[m], estimate_json(r->relative[s][m].mean, r->relative[s][m].error));
        json_append(errors, row);
    }
    json_add(json, "relative_mean_squared_error", errors);
    return json;
}

/* ---- the picture: above, the rectified chain's histograms; below, the errors of the methods ---- */

enum { PANEL_WIDTH = 190, PANEL_HEIGHT = 150, COLUMN = 220, LEFT = 64, TOP = 66, LOWER = 300, WIDE = 300 };
static const char *const colours[FAILURE_METHODS] = {PLOT_GREY, PLOT_RED, PLOT_BLUE, PLOT_GREEN, PLOT_BLACK};

static void draw_law(plot_t *plot, const failure_law_t *l, int column)
{
    double density[FAILURE_BINS], exact[FAILURE_BINS], predicted[FAILURE_BINS];
    char title[64];
    snprintf(title, sizeof title, "sigma %g: %.4f", l->sigma, l->measured);
    const plot_panel_t panel = {.left = LEFT + COLUMN * column,
                                .top = TOP,
                                .width = PANEL_WIDTH,
                                .height = PANEL_HEIGHT,
                                .x1 = 1,
                                .y1 = 2.4,
                                .title = title,
                                .x_label = "x",
                                .y_label = column == 0 ? "density, rectified" : NULL};
    failures_exact(exact);
    failures_law(l->sigma, predicted);
    for (int k = 0; k < FAILURE_BINS; k++) {
        density[k] = l->states[k] * FAILURE_BINS;
        exact[k] *= FAILURE_BINS;
        predicted[k] *= FAILURE_BINS;
    }
    plot_bars(plot, &panel, NULL, density, FAILURE_BINS, PLOT_BLUE);
    plot_curve(plot, &panel, exact, FAILURE_BINS, PLOT_BLACK, true);
    plot_curve(plot, &panel, predicted, FAILURE_BINS, PLOT_ORANGE, false);
    plot_axes(plot, &panel);
}

/* Bars above 2 are cut; the figure below the bar tells. */
static void draw_errors(plot_t *plot, const failure_report_t *r, int s)
{
    char title[64];
    snprintf(title, sizeof title, "sigma %g", r->sigmas[s]);
    const plot_panel_t panel = {.left = LEFT + (WIDE + 60) * s,
                                .top = LOWER,
                                .width = WIDE,
                                .height = PANEL_HEIGHT,
                                .x1 = FAILURE_METHODS,
                                .y1 = 2,
                                .title = title,
                                .y_label = s == 0 ? "relative squared error" : NULL,
                                .no_x_numbers = true};
    for (int m = 0; m < FAILURE_METHODS; m++) {
        char figure[32];
        const double height = r->relative[s][m].mean;
        snprintf(figure, sizeof figure, "%.2f", height);
        plot_bar(plot, &panel, m + 0.15, m + 0.85, height, colours[m]);
        plot_words(plot, panel.left + panel.width * (m + 0.5) / FAILURE_METHODS, panel.top + panel.height + 14,
                   "middle", figure);
    }
    plot_level(plot, &panel, 1, PLOT_BLACK);
    plot_axes(plot, &panel);
}

char *failure_report_svg(const failure_report_t *r)
{
    const int width = LEFT + COLUMN * FAILURE_REPORT_LAWS, height = LOWER + PANEL_HEIGHT + 48;
    plot_t *plot = plot_new(width, height, "Failed proposals: the rectified chain's bias, and the methods' errors");
    for (int i = 0; i < FAILURE_REPORT_LAWS; i++)
        draw_law(plot, &r->laws[i], i);
    plot_key(plot, LEFT, LOWER - 32, PLOT_BLACK, "target 2x (dashed)");
    plot_key(plot, LEFT + 170, LOWER - 32, PLOT_ORANGE, "law f (1 - p_fail)");
    plot_key(plot, LEFT + 340, LOWER - 32, PLOT_BLUE, "chain, with its total variation from 2x");
    for (int s = 0; s < FAILURE_REPORT_SIGMAS; s++)
        draw_errors(plot, r, s);
    for (int m = 0; m < FAILURE_METHODS; m++)
        plot_key(plot, LEFT + 150 * m, height - 14, colours[m], failures_names[m]);
    return plot_finish(&plot);
}
