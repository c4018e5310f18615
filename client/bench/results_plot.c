#include "client/bench/results_plot.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "client/bench/curve.h"

enum {
    COLUMNS = 3,
    CELL_WIDTH = 330,
    NUMBERS = 62,
    HEAD = 34,
    PANEL_HEIGHT = 210,
    GAP = 46,
    KEY_WIDTH = 190,
    KEY_HEIGHT = 18
};

/* Colours that people who see few colours can tell apart (Okabe, Ito 2008); then the same with dashes. */
static svg_style_t style_of(size_t variant)
{
    static const char *const colours[] = {"#7a7a7a", "#0072b2", "#d55e00", "#009e73",
                                          "#cc79a7", "#e69f00", "#56b4e9", "#000000"};
    static const char *const dashes[] = {"", "6 2", "2 2", "8 2 2 2"};
    enum { COLOURS = sizeof colours / sizeof *colours, DASHES = sizeof dashes / sizeof *dashes };
    return (svg_style_t){colours[variant % COLOURS], dashes[variant / COLOURS % DASHES],
                         (int)(variant / COLOURS % 3)};
}

/* What one variant's line shows. */
static curve_t curve_of(const results_t *results, size_t scene, size_t variant)
{
    static_assert((int)MATRIX_BUDGETS <= (int)CURVE_POINTS, "a point for each budget");
    curve_t curve = {.count = 0};
    for (size_t b = 0; b < results->matrix->budget_count; b++)
        curve_add(&curve, results_cell(results, scene, variant, b).cpu_seconds.median,
                  results_error_spread(results, scene, variant, b));
    return curve;
}

static svg_panel_t panel_of(const results_t *results, size_t scene, double top)
{
    curve_range_t x = {0}, y = {0};
    for (size_t v = 0; v < results->matrix->variant_count; v++) {
        const curve_t curve = curve_of(results, scene, v);
        curve_range_take_curve(&x, &y, &curve);
    }
    x = curve_range_finish(x, 1.15);
    y = curve_range_finish(y, 1.3);
    return (svg_panel_t){.left = CELL_WIDTH * (double)(scene % COLUMNS) + NUMBERS,
                         .top = top + (double)(scene / COLUMNS) * (PANEL_HEIGHT + GAP),
                         .width = CELL_WIDTH - NUMBERS - 12,
                         .height = PANEL_HEIGHT,
                         .x0 = x.low,
                         .x1 = x.high,
                         .y0 = y.low,
                         .y1 = y.high};
}

/* Labels at the budgets in seconds, or at 1, 2 and 5 times powers of ten, at most about six. */
static void draw_times(svg_t *svg, const results_t *results, const svg_panel_t *panel)
{
    const matrix_t *m = results->matrix;
    char label[32];
    if (!m->by_mutations) {
        const size_t step = (m->budget_count + 5) / 6;
        for (size_t b = m->budget_count; b-- > 0;)
            if ((m->budget_count - 1 - b) % step == 0 && m->budgets[b] >= panel->x0 && m->budgets[b] <= panel->x1) {
                snprintf(label, sizeof label, "%g s", m->budgets[b]);
                svg_tick_x(svg, panel, m->budgets[b], label);
            }
        return;
    }
    const double decades = log10(panel->x1 / panel->x0);
    for (double power = pow(10, floor(log10(panel->x0))); power <= panel->x1; power *= 10)
        for (int i = 0; i < 3; i++) {
            static const double steps[] = {1, 2, 5};
            const double x = power * steps[i];
            if (x < panel->x0 || x > panel->x1 || (decades > 2 && i > 0))
                continue;
            snprintf(label, sizeof label, "%g s", x);
            svg_tick_x(svg, panel, x, label);
        }
}

static void draw_scene(svg_t *svg, const results_t *results, size_t scene, double top)
{
    const matrix_t *m = results->matrix;
    const svg_panel_t panel = panel_of(results, scene, top);
    char title[2 * MATRIX_NAME];
    snprintf(title, sizeof title, "%s%s", m->scenes[scene].name,
             results->scenes[scene].reference[0] ? "" : " (own estimates)");
    svg_grid(svg, &panel, title);
    draw_times(svg, results, &panel);
    for (size_t v = 0; v < m->variant_count; v++) { /* lines above all bands */
        const curve_t curve = curve_of(results, scene, v);
        const svg_style_t style = style_of(v);
        curve_draw_band(svg, &panel, &curve, &style);
    }
    for (size_t v = 0; v < m->variant_count; v++) {
        const curve_t curve = curve_of(results, scene, v);
        const svg_style_t style = style_of(v);
        curve_draw_line(svg, &panel, &curve, &style, m->variants[v].name);
    }
}

char *results_plot(const results_t *results)
{
    const matrix_t *m = results->matrix;
    const size_t columns = m->scene_count < COLUMNS ? m->scene_count : COLUMNS;
    const int width = (int)columns * CELL_WIDTH;
    const size_t a_line = width > KEY_WIDTH ? (size_t)(width - 20) / KEY_WIDTH : 1;
    const double top = HEAD + KEY_HEIGHT * (double)((m->variant_count + a_line - 1) / a_line) + 30;
    const size_t rows = (m->scene_count + COLUMNS - 1) / COLUMNS;
    svg_t *svg =
        svg_new(width, (int)top + (int)rows * (PANEL_HEIGHT + GAP), "relMSE over CPU time",
                "A panel a scene, both axes logarithmic: the relative mean squared error of each variant's "
                "image after so many CPU seconds of one thread. Lines are medians over the seeds, bands "
                "go from the least to the most. The tables hold the numbers.");
    for (size_t v = 0; v < m->variant_count; v++) {
        const svg_style_t style = style_of(v);
        svg_key(svg, 20 + KEY_WIDTH * (double)(v % a_line), HEAD + 14 + KEY_HEIGHT * (double)(v / a_line), &style,
                m->variants[v].name);
    }
    for (size_t s = 0; s < m->scene_count; s++)
        draw_scene(svg, results, s, top);
    return svg_finish(&svg);
}
