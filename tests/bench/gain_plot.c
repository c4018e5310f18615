#include "gain_plot.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/bench/curve.h"
#include "client/bench/seeds.h"

enum {
    COLUMNS = 3,
    CELL_WIDTH = 310,
    LABELS = 118, /* left of rows */
    NUMBERS = 52, /* left of a y axis */
    HEAD = 34,
    PANEL_HEIGHT = 200,
    ROW = 13,
    KEY_WIDTH = 150,
    KEY_HEIGHT = 18,
    GAP = 46, /* below a panel */
    MAX_KEYS = 32
};

/* Colours that people who see few colours can tell apart (Okabe, Ito 2008) and dashes that tell them apart in
 * print. */
static svg_style_t style_of(const gain_variant_t *variant)
{
    static const struct {
        const char *algorithm, *colour, *dash;
    } styles[] = {{"bdpt", "#7a7a7a", "2 2"},   {"pt", "#b0b0b0", "1 2"},         {"mmlt", "#0072b2", ""},
                  {"pssmlt", "#e69f00", "6 2"}, {"pssmlt-mix", "#a6761d", "3 2"}, {"rjmlt", "#009e73", ""},
                  {"cmlt", "#d55e00", ""},      {"cmlt-rex", "#cc79a7", "6 2"},   {"cmlt-ipsm", "#56b4e9", "3 2"}};
    svg_style_t style = {"#000000", "8 2 2 2", 0};
    for (size_t i = 0; i < sizeof styles / sizeof *styles; i++)
        if (strcmp(styles[i].algorithm, variant->algorithm) == 0)
            style = (svg_style_t){styles[i].colour, styles[i].dash, 0};
    if (gain_name_has_remedy(variant->name, "published"))
        style.shape = 2;
    else if (!gain_name_is_plain(variant->name))
        style.shape = 1;
    return style;
}

/* Beyond what is shown. */
static const double MARGIN = 1.25;

static int picture_rows(size_t count)
{
    return (int)((count + COLUMNS - 1) / COLUMNS);
}

/* ---- relMSE over time ---- */

static curve_t curve_of(const gain_entry_t *entry, size_t points)
{
    static_assert((int)GAIN_POINTS <= (int)CURVE_POINTS, "a point for each time");
    curve_t curve = {.count = 0};
    for (size_t i = 0; i < points; i++)
        curve_add(&curve, gain_entry_spread(entry, i, GAIN_CPU).median, gain_entry_spread(entry, i, GAIN_RELMSE));
    return curve;
}

static bool is_shown(const gain_entry_t *entry)
{
    return !entry->refused[0] && gain_name_is_plain(entry->variant.name);
}

static svg_panel_t time_panel(const gain_scene_t *scene, size_t index, double top)
{
    curve_range_t x = {0}, y = {0};
    for (size_t p = 0; p < scene->point_count; p++)
        curve_range_take(&x, scene->times[p]);
    for (size_t i = 0; i < scene->entry_count; i++) {
        if (!is_shown(&scene->entries[i]))
            continue;
        const curve_t curve = curve_of(&scene->entries[i], scene->point_count);
        curve_range_take_curve(&x, &y, &curve);
    }
    x = curve_range_finish(x, MARGIN);
    y = curve_range_finish(y, MARGIN);
    return (svg_panel_t){.left = CELL_WIDTH * (double)(index % COLUMNS) + NUMBERS,
                         .top = top + (double)(index / COLUMNS) * (PANEL_HEIGHT + GAP),
                         .width = CELL_WIDTH - NUMBERS - 10,
                         .height = PANEL_HEIGHT,
                         .x0 = x.low,
                         .x1 = x.high,
                         .y0 = y.low,
                         .y1 = y.high};
}

static void time_scene(svg_t *svg, const gain_scene_t *scene, const svg_panel_t *panel)
{
    char label[128];
    svg_grid(svg, panel, scene->name);
    for (size_t p = 0; p < scene->point_count; p++) {
        snprintf(label, sizeof label, "%g s", scene->times[p]);
        svg_tick_x(svg, panel, scene->times[p], label);
    }
    for (int pass = 0; pass < 2; pass++) /* lines above all bands */
        for (size_t i = 0; i < scene->entry_count; i++) {
            const gain_entry_t *entry = &scene->entries[i];
            if (!is_shown(entry))
                continue;
            const curve_t curve = curve_of(entry, scene->point_count);
            const svg_style_t style = style_of(&entry->variant);
            if (pass == 0)
                curve_draw_band(svg, panel, &curve, &style);
            else
                curve_draw_line(svg, panel, &curve, &style, entry->variant.name);
        }
}

/* The variants shown in any scene, each once. */
static size_t time_keys(const gain_scene_t *scenes, size_t count, const gain_variant_t *keys[MAX_KEYS])
{
    size_t found = 0;
    for (size_t s = 0; s < count; s++)
        for (size_t i = 0; i < scenes[s].entry_count; i++) {
            const gain_entry_t *entry = &scenes[s].entries[i];
            size_t k = 0;
            while (k < found && strcmp(keys[k]->name, entry->variant.name) != 0)
                k++;
            if (k == found && found < MAX_KEYS && is_shown(entry))
                keys[found++] = &entry->variant;
        }
    return found;
}

char *gain_plot_time(const gain_scene_t *scenes, size_t count)
{
    const gain_variant_t *keys[MAX_KEYS];
    const size_t key_count = time_keys(scenes, count, keys), a_line = COLUMNS * CELL_WIDTH / KEY_WIDTH;
    const double top = HEAD + KEY_HEIGHT * (double)((key_count + a_line - 1) / a_line) + 24;
    svg_t *svg =
        svg_new(COLUMNS * CELL_WIDTH, (int)top + picture_rows(count) * (PANEL_HEIGHT + GAP), "relMSE over CPU time",
                "A panel a scene, both axes logarithmic: the relative mean squared error of each algorithm's "
                "image after so many CPU seconds of one thread. Lines are medians over the seeds, bands go "
                "from the least to the most. The tables hold the numbers.");
    for (size_t k = 0; k < key_count; k++) {
        const svg_style_t style = style_of(keys[k]);
        svg_key(svg, 20 + KEY_WIDTH * (double)(k % a_line), HEAD + 14 + KEY_HEIGHT * (double)(k / a_line), &style,
                keys[k]->name);
    }
    for (size_t i = 0; i < count; i++) {
        const svg_panel_t panel = time_panel(&scenes[i], i, top);
        time_scene(svg, &scenes[i], &panel);
    }
    return svg_finish(&svg);
}

/* ---- rows of dots ---- */

typedef struct row {
    double middle, low, high, other;
} row_t;

typedef row_t row_maker_t(const gain_scene_t *scene, const gain_entry_t *entry);

static row_t row_end(const gain_scene_t *scene, const gain_entry_t *entry)
{
    const spread_t all = gain_entry_spread(entry, scene->point_count - 1, GAIN_RELMSE),
                   trimmed = gain_entry_spread(entry, scene->point_count - 1, GAIN_TRIMMED);
    return (row_t){all.median, all.min, all.max, trimmed.median};
}

static row_t row_stability(const gain_scene_t *scene, const gain_entry_t *entry)
{
    (void)scene;
    const gain_figure_t d = entry->deviation;
    return (row_t){d.value, d.value - SEEDS_WIDTH * d.error, d.value + SEEDS_WIDTH * d.error,
                   entry->deviation_99.value};
}

static void rows_scene(svg_t *svg, const gain_scene_t *scene, svg_panel_t panel, row_maker_t *make)
{
    curve_range_t x = {0};
    for (size_t i = 0; i < scene->entry_count; i++)
        if (!scene->entries[i].refused[0]) {
            const row_t row = make(scene, &scene->entries[i]);
            curve_range_take(&x, row.middle);
            curve_range_take(&x, row.low);
            curve_range_take(&x, row.high);
            curve_range_take(&x, row.other);
        }
    x = curve_range_finish(x, MARGIN);
    panel.x0 = x.low;
    panel.x1 = x.high;
    svg_grid(svg, &panel, scene->name);
    double y = panel.top + ROW;
    for (size_t i = 0; i < scene->entry_count; i++) {
        const gain_entry_t *entry = &scene->entries[i];
        if (entry->refused[0])
            continue;
        const row_t row = make(scene, entry);
        const svg_style_t style = style_of(&entry->variant);
        char label[160];
        if (isfinite(row.high - row.low))
            snprintf(label, sizeof label, "%s: %.3g (%.3g to %.3g), tick %.3g", entry->variant.name, row.middle,
                     row.low, row.high, row.other);
        else
            snprintf(label, sizeof label, "%s: %.3g, tick %.3g", entry->variant.name, row.middle, row.other);
        svg_text(svg, panel.left - 5, y + 3.5, "end", 10, entry->variant.name);
        svg_row(svg, &panel, y, row.middle, row.low, row.high, row.other, &style, label);
        y += ROW;
    }
}

/* The most variants that any scene shows. */
static size_t rows_most(const gain_scene_t *scenes, size_t count)
{
    size_t most = 1;
    for (size_t s = 0; s < count; s++) {
        size_t shown = 0;
        for (size_t i = 0; i < scenes[s].entry_count; i++)
            shown += !scenes[s].entries[i].refused[0];
        most = shown > most ? shown : most;
    }
    return most;
}

static char *rows_plot(const gain_scene_t *scenes, size_t count, const char *title, const char *description,
                       row_maker_t *make)
{
    const double height = ROW * (double)(rows_most(scenes, count) + 1), top = HEAD + 24;
    svg_t *svg =
        svg_new(COLUMNS * CELL_WIDTH, (int)(top + picture_rows(count) * (height + GAP)), title, description);
    for (size_t i = 0; i < count; i++) {
        const svg_panel_t panel = {.left = CELL_WIDTH * (double)(i % COLUMNS) + LABELS,
                                   .top = top + (double)(i / COLUMNS) * (height + GAP),
                                   .width = CELL_WIDTH - LABELS - 14,
                                   .height = height};
        rows_scene(svg, &scenes[i], panel, make);
    }
    return svg_finish(&svg);
}

char *gain_plot_end(const gain_scene_t *scenes, size_t count)
{
    return rows_plot(
        scenes, count, "relMSE after equal CPU time",
        "A panel a scene, a row a variant, on a logarithmic axis: dots are medians over the seeds, lines "
        "go from the least to the most, ticks are medians without the worst 0.1 % of the pixels. "
        "Squares: failures delayed; open triangles: as published, biased.",
        row_end);
}

char *gain_plot_stability(const gain_scene_t *scenes, size_t count)
{
    return rows_plot(scenes, count, "Standard deviation of a pixel over the seeds, over the mean luminance",
                     "A panel a scene, a row a variant, on a logarithmic axis: dots are means over the pixels with "
                     "their error, ticks the 99th percentile. Squares: failures delayed; open triangles: as "
                     "published, biased.",
                     row_stability);
}
