#include "client/lab/jump_report.h"

#include <inttypes.h>

#include "client/lab/plot.h"

void jump_report_measure(jump_figures_t *figures, jump_variant_t variant, double size, uint64_t steps,
                         uint64_t seed, uint64_t first)
{
    static const jump_figures_t none;
    histogram_t chains[JUMP_REPORT_CHAINS];
    double exact[JUMP_BINS], by[TECHNIQUES][JUMP_BINS] = {{0}};
    *figures = none;
    for (int c = 0; c < JUMP_REPORT_CHAINS; c++) {
        jump_result_t result;
        stream_t stream = stream_of(seed, first + (uint64_t)c);
        jump_run(&result, variant, size, steps / JUMP_REPORT_CHAINS, &stream);
        chains[c] = result.all;
        for (int t = 0; t < TECHNIQUES; t++) {
            figures->shares[t] += result.by[t].total / result.all.total / JUMP_REPORT_CHAINS;
            for (int k = 0; k < JUMP_BINS; k++)
                by[t][k] += result.by[t].weight[k];
        }
    }
    const histogram_t all = histogram_sum(chains, JUMP_REPORT_CHAINS);
    jump_exact(exact);
    figures->total_variation = histogram_total_variation(&all, exact);
    figures->noise = histogram_noise(chains, JUMP_REPORT_CHAINS);
    for (int k = 0; k < JUMP_BINS; k++) {
        figures->states[k] = all.weight[k] / all.total;
        for (int t = 0; t < TECHNIQUES && all.weight[k] > 0; t++)
            figures->weights[t][k] = by[t][k] / all.weight[k];
    }
}

void jump_report_run(jump_report_t *report, uint64_t steps, uint64_t seed)
{
    report->steps = steps;
    report->seed = seed;
    report->sizes[0] = 0.02;
    report->sizes[1] = 0.1;
    for (int t = 0; t < TECHNIQUES; t++)
        report->exact_shares[t] = techniques_exact_share(t, 0, 1);
    for (int s = 0; s < JUMP_REPORT_SIZES; s++)
        for (int v = 0; v < JUMP_VARIANTS; v++)
            jump_report_measure(&report->figures[s][v], (jump_variant_t)v, report->sizes[s], steps, seed,
                                (uint64_t)(s * JUMP_VARIANTS + v) * JUMP_REPORT_CHAINS);
}

void jump_report_print(const jump_report_t *r, FILE *out)
{
    fprintf(
        out,
        "Reversible jumps (Bitterli et al. 2017, section 7.1): target 1 + 0.8 cos(2 pi x), jump probability %g,\n"
        "%" PRIu64 " steps, seed %" PRIu64
        ". Total variation of the states from the target (100 bins), the noise of a\n"
        "right chain's, shares of the techniques.\n\n",
        JUMP_PROBABILITY, r->steps, r->seed);
    fprintf(out, "small step  variant       total variation  noise     tent   step  mixture\n");
    for (int s = 0; s < JUMP_REPORT_SIZES; s++)
        for (int v = 0; v < JUMP_VARIANTS; v++) {
            const jump_figures_t *f = &r->figures[s][v];
            fprintf(out, "%-10g  %-12s  %-15.4f  %-7.4f  %5.3f  %5.3f  %5.3f\n", r->sizes[s], jump_names[v],
                    f->total_variation, f->noise, f->shares[0], f->shares[1], f->shares[2]);
        }
    fprintf(out, "%-10s  %-12s  %-15d  %-7s  %5.3f  %5.3f  %5.3f\n\n", "", "exact", 0, "", r->exact_shares[0],
            r->exact_shares[1], r->exact_shares[2]);
}

static json_t *shares_json(const double shares[TECHNIQUES])
{
    json_t *json = json_new_object();
    for (int t = 0; t < TECHNIQUES; t++)
        json_add_number(json, techniques_names[t], shares[t]);
    return json;
}

static json_t *figures_json(const jump_figures_t *f, double size, int variant)
{
    json_t *json = json_new_object();
    json_add_number(json, "small_step", size);
    json_add_string(json, "variant", jump_names[variant]);
    json_add_number(json, "total_variation", f->total_variation);
    json_add_number(json, "noise", f->noise);
    json_add(json, "shares", shares_json(f->shares));
    return json;
}

json_t *jump_report_json(const jump_report_t *r)
{
    json_t *json = json_new_object(), *rows = json_new_array();
    json_add_u64(json, "steps", r->steps);
    json_add_u64(json, "seed", r->seed);
    json_add(json, "exact_shares", shares_json(r->exact_shares));
    for (int s = 0; s < JUMP_REPORT_SIZES; s++)
        for (int v = 0; v < JUMP_VARIANTS; v++)
            json_append(rows, figures_json(&r->figures[s][v], r->sizes[s], v));
    json_add(json, "variants", rows);
    return json;
}

/* ---- the picture: a column a variant, two rows a small step ---- */

enum { PANEL_WIDTH = 190, PANEL_HEIGHT = 120, COLUMN = 226, ROW = 175, LEFT = 64, TOP = 66 };
static const char *const colours[TECHNIQUES] = {PLOT_BLUE, PLOT_GREEN, PLOT_RED};

static plot_panel_t panel_at(int row, int column, double y1)
{
    return (plot_panel_t){.left = LEFT + COLUMN * column,
                          .top = TOP + ROW * row,
                          .width = PANEL_WIDTH,
                          .height = PANEL_HEIGHT,
                          .x1 = 1,
                          .y1 = y1};
}

static void draw_states(plot_t *plot, const jump_figures_t *f, plot_panel_t panel)
{
    double density[JUMP_BINS], exact[JUMP_BINS];
    jump_exact(exact);
    for (int k = 0; k < JUMP_BINS; k++) {
        density[k] = f->states[k] * JUMP_BINS;
        exact[k] *= JUMP_BINS;
    }
    plot_bars(plot, &panel, NULL, density, JUMP_BINS, PLOT_GREY);
    plot_curve(plot, &panel, exact, JUMP_BINS, PLOT_ORANGE, false);
    plot_axes(plot, &panel);
}

/* Bands from bottom to top; curves where right bands end. */
static void draw_weights(plot_t *plot, const jump_figures_t *f, plot_panel_t panel)
{
    double below[JUMP_BINS] = {0}, above[JUMP_BINS], curve[JUMP_BINS] = {0}, exact[JUMP_BINS];
    double curves[TECHNIQUES - 1][JUMP_BINS];
    jump_exact(exact);
    for (int t = 0; t < TECHNIQUES; t++) {
        for (int k = 0; k < JUMP_BINS; k++) {
            above[k] = below[k] + f->weights[t][k];
            curve[k] += techniques_exact_share(t, (double)k / JUMP_BINS, (k + 1.0) / JUMP_BINS) / exact[k];
            if (t < TECHNIQUES - 1)
                curves[t][k] = curve[k];
        }
        plot_bars(plot, &panel, below, above, JUMP_BINS, colours[t]);
        for (int k = 0; k < JUMP_BINS; k++)
            below[k] = above[k];
    }
    for (int t = 0; t < TECHNIQUES - 1; t++)
        plot_curve(plot, &panel, curves[t], JUMP_BINS, PLOT_BLACK, false);
    plot_axes(plot, &panel);
}

static void draw_column(plot_t *plot, const jump_report_t *r, int size, int variant)
{
    const jump_figures_t *f = &r->figures[size][variant];
    char title[64];
    snprintf(title, sizeof title, "%s: %.4f", jump_names[variant], f->total_variation);
    plot_panel_t states = panel_at(2 * size, variant, 2.4), weights = panel_at(2 * size + 1, variant, 1);
    states.title = title;
    weights.x_label = "x";
    char y_label[64];
    snprintf(y_label, sizeof y_label, "density, step %g", r->sizes[size]);
    if (variant == 0) {
        states.y_label = y_label;
        weights.y_label = "techniques";
    }
    draw_states(plot, f, states);
    draw_weights(plot, f, weights);
}

char *jump_report_svg(const jump_report_t *r)
{
    const int width = LEFT + COLUMN * JUMP_VARIANTS, height = TOP + 2 * ROW * JUMP_REPORT_SIZES + 24;
    plot_t *plot = plot_new(width, height,
                            "Reversible jumps: histograms of states and techniques, total variation from exact");
    for (int s = 0; s < JUMP_REPORT_SIZES; s++)
        for (int v = 0; v < JUMP_VARIANTS; v++)
            draw_column(plot, r, s, v);
    for (int t = 0; t < TECHNIQUES; t++)
        plot_key(plot, LEFT + 90 * t, height - 12, colours[t], techniques_names[t]);
    plot_key(plot, LEFT + 290, height - 12, PLOT_BLACK, "exact weights, summed");
    plot_key(plot, LEFT + 470, height - 12, PLOT_ORANGE, "exact target");
    return plot_finish(&plot);
}
