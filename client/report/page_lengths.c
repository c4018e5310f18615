/* page_lengths.c: what paths of each length bring and cost. */
#include <math.h>

#include "client/report/page_parts.h"

enum { WIDTH = 520, HEIGHT = 270 };

enum { SERIES = 3, ERROR = 0, TIME, LIGHT };

static const struct {
    const char *name, *colour;
} series[SERIES] = {[ERROR] = {"error (relMSE)", "var(--c2)"},
                    [TIME] = {"processor time", "var(--c1)"},
                    [LIGHT] = {"light", "var(--c5)"}};

/* What the bars show: a column for each length, and one for the samples beside chains if there are any. */
typedef struct columns {
    double values[REPORT_MAX_LENGTHS + 1][SERIES];
    double sums[SERIES]; /* 0: nothing is known of it */
    uint32_t count;
    bool samples; /* the last is theirs */
} columns_t;

/* All light of a length, whoever brings it. */
static double light_of(const report_length_t *length)
{
    return isfinite(length->light) ? length->light : length->b;
}

static void columns_of(columns_t *columns, const report_t *report)
{
    *columns =
        (columns_t){.count = report->length_count, .samples = report_number(report, "samples", "samples") > 0};
    for (uint32_t i = 0; i < report->length_count; i++) {
        const report_length_t *k = &report->lengths[i];
        columns->values[i][ERROR] = k->relmse;
        columns->values[i][TIME] = k->cpu_seconds;
        columns->values[i][LIGHT] = light_of(k);
    }
    if (columns->samples) {
        double *last = columns->values[columns->count++];
        last[ERROR] = report_number(report, "samples", "relmse");
        last[TIME] = report_number(report, "samples", "cpu_seconds");
        last[LIGHT] = NAN; /* it is in the lengths */
    }
    for (int s = 0; s < SERIES; s++) {
        for (uint32_t i = 0; i < columns->count; i++)
            if (columns->values[i][s] > 0)
                columns->sums[s] += columns->values[i][s];
        if (!isfinite(columns->sums[s]))
            columns->sums[s] = 0;
    }
}

static double largest_share(const columns_t *columns)
{
    double most = 0;
    for (int s = 0; s < SERIES; s++)
        for (uint32_t i = 0; columns->sums[s] > 0 && i < columns->count; i++)
            most = fmax(most, columns->values[i][s] / columns->sums[s]);
    return most;
}

static void put_bars(svg_t *svg, const svg_panel_t *panel, const columns_t *columns, const report_t *report)
{
    int shown = 0, at = 0;
    for (int s = 0; s < SERIES; s++)
        shown += columns->sums[s] > 0;
    const double cell = panel->width / columns->count, bar = 0.78 * cell / fmax(1, shown);
    for (int s = 0; s < SERIES; s++) {
        if (!(columns->sums[s] > 0))
            continue;
        for (uint32_t i = 0; i < columns->count; i++) {
            const double share = columns->values[i][s] / columns->sums[s];
            char number[PAGE_NUMBER_SIZE], name[32] = "samples", text[PAGE_NUMBER_SIZE + 64];
            if (!(share > 0))
                continue;
            if (i < report->length_count)
                snprintf(name, sizeof name, "length %.0f", report->lengths[i].length);
            snprintf(text, sizeof text, "%s: %s of the %s", name, page_number(number, PAGE_PERCENT, share),
                     series[s].name);
            const double top = svg_place_y(panel, share);
            svg_rect(svg, panel->left + cell * i + 0.11 * cell + bar * at, top, fmax(0.5, bar - 1),
                     panel->top + panel->height - top, series[s].colour, 1, text);
        }
        at++;
    }
}

/* Numbers below the columns, as many as there is room for; `columns`: as many as share the width. */
static void put_length_numbers(svg_t *svg, const svg_panel_t *panel, const report_t *report, uint32_t columns)
{
    const double cell = panel->width / columns;
    const uint32_t step = (uint32_t)ceil(18 / cell);
    for (uint32_t j = 0; j < report->length_count; j += step) {
        char text[32];
        snprintf(text, sizeof text, "%.0f", report->lengths[j].length);
        svg_text_in(svg, panel->left + cell * (j + 0.5), panel->top + panel->height + 14, "middle", 10.5,
                    "var(--muted)", text);
    }
    if (columns > report->length_count)
        svg_text_in(svg, panel->left + panel->width, panel->top + panel->height + 14, "end", 10.5, "var(--muted)",
                    "samples");
}

static void put_percents(svg_t *svg, const svg_panel_t *panel)
{
    const double step = panel->y1 > 0.5 ? 0.2 : panel->y1 > 0.2 ? 0.1 : panel->y1 > 0.1 ? 0.05 : 0.02;
    for (int i = 0; i <= 5 && i * step <= panel->y1 * (1 + 1e-9); i++) {
        char text[PAGE_NUMBER_SIZE];
        svg_tick_y(svg, panel, i * step, page_number(text, PAGE_PERCENT, i * step));
    }
}

static void put_shares_plot(page_t *page, const columns_t *columns)
{
    const report_t *report = page->report;
    char text[160];
    snprintf(text, sizeof text,
             "For each of %u path lengths%s its share of the error, of the time and of the light, "
             "as bars; the table below has the numbers.",
             report->length_count, columns->samples ? " and for the samples" : "");
    svg_t *svg = svg_new_embedded(WIDTH, HEIGHT, "lengths-plot", "Error, time and light by path length", text);
    const svg_panel_t panel = {.left = 40,
                               .top = 34,
                               .width = WIDTH - 50,
                               .height = HEIGHT - 76,
                               .x1 = 1,
                               .y1 = fmin(1, 1.08 * largest_share(columns)),
                               .linear_x = true,
                               .linear_y = true};
    put_percents(svg, &panel);
    put_bars(svg, &panel, columns, report);
    put_length_numbers(svg, &panel, report, columns->count);
    double x = panel.left;
    for (int i = 0; i < SERIES; i++)
        if (columns->sums[i] > 0) {
            svg_rect(svg, x, 8, 11, 11, series[i].colour, 1, "");
            svg_text(svg, x + 16, 18, "start", 12, series[i].name);
            x += i == 0 ? 128 : 124;
        }
    svg_axis_names(svg, &panel, "path length, segments", "");
    page_plot(page, &svg, "");
}

static void put_lengths_table(page_t *page)
{
    static const page_column_t columns[] = {{"Length", false},        {"relMSE", false},      {"Share", false},
                                            {"Mutations", false},     {"Time", false},        {"Chains", false},
                                            {"Without light", false}, {"Longest stay", false}};
    const report_t *report = page->report;
    page_table(page, "Numbers by path length", columns, sizeof columns / sizeof columns[0], true);
    for (uint32_t i = 0; i < report->length_count; i++) {
        const report_length_t *k = &report->lengths[i];
        page_row(page);
        page_cell_number(page, PAGE_COUNT, k->length);
        page_cell_number(page, PAGE_NUMBER, k->relmse);
        page_cell_number(page, PAGE_PERCENT, k->share);
        page_cell_number(page, PAGE_COUNT, k->mutations);
        page_cell_number(page, PAGE_SECONDS, k->cpu_seconds);
        page_cell_number(page, PAGE_COUNT, k->chains);
        page_cell_number(page, PAGE_PERCENT, k->zero_contribution / k->mutations);
        page_cell_number(page, PAGE_COUNT, k->longest_stay);
        page_row_end(page);
    }
    if (report_number(report, "samples", "samples") > 0) {
        page_row(page);
        page_cell_text(page, "samples");
        page_cell_number(page, PAGE_NUMBER, report_number(report, "samples", "relmse"));
        page_cell_number(page, PAGE_PERCENT, report_number(report, "samples", "share"));
        page_cell_number(page, PAGE_COUNT, report_number(report, "samples", "samples"));
        page_cell_number(page, PAGE_SECONDS, report_number(report, "samples", "cpu_seconds"));
        for (int i = 0; i < 3; i++)
            page_cell_number(page, PAGE_COUNT, NAN);
        page_row_end(page);
    }
    page_table_end(page, true);
}

/* What chains that were tried before the render said of their length, and how it is stepped for that. */
static void put_trials_table(page_t *page)
{
    static const page_column_t columns[] = {{"Length", false},
                                            {"Mutations worth a draw", false},
                                            {"Rays a mutation", false},
                                            {"Small steps, times", false},
                                            {"Large steps", false}};
    const report_t *report = page->report;
    uint32_t known = 0;
    for (uint32_t i = 0; i < report->length_count; i++)
        known += isfinite(report->lengths[i].inefficiency);
    if (known == 0)
        return;
    page_table(page, "Trials before the render", columns, sizeof columns / sizeof columns[0], true);
    for (uint32_t i = 0; i < report->length_count; i++) {
        const report_length_t *k = &report->lengths[i];
        if (!isfinite(k->inefficiency))
            continue;
        page_row(page);
        page_cell_number(page, PAGE_COUNT, k->length);
        page_cell_number(page, PAGE_NUMBER, k->inefficiency);
        page_cell_number(page, PAGE_NUMBER, k->rays);
        page_cell_number(page, PAGE_NUMBER, k->steps);
        page_cell_number(page, PAGE_PERCENT, k->large_step);
        page_row_end(page);
    }
    page_table_end(page, true);
}

/* Of samples beside the chains. */
static void put_samples_words(page_t *page)
{
    const double samples = report_number(page->report, "samples", "samples");
    if (!(samples > 0))
        return;
    page_put(page, "<p>Beside the chains ");
    page_say_number(page, PAGE_COUNT, samples);
    page_put(page, " independent samples of all lengths brought what they find easily: the last column.</p>\n");
}

void page_lengths(page_t *page)
{
    columns_t columns;
    if (page->report->length_count == 0)
        return;
    page_section(page, "lengths", "half", "By path length");
    columns_of(&columns, page->report);
    page_put(page, "<p>Where the error comes from, and where the time goes.%s</p>\n",
             columns.sums[ERROR] > 0 ? "" : " The error by length is not known.");
    put_samples_words(page);
    if (largest_share(&columns) > 0)
        put_shares_plot(page, &columns);
    put_lengths_table(page);
    put_trials_table(page);
    page_section_end(page);
}

/* ---- b_k ---- */

/* Whether the pilot said what a length may bring at most. */
static bool is_bounded(const report_t *report)
{
    for (uint32_t i = 0; i < report->length_count; i++)
        if (isfinite(report->lengths[i].most))
            return true;
    return false;
}

/* Whether samples bring a part of any length. */
static bool is_split(const report_t *report)
{
    for (uint32_t i = 0; i < report->length_count; i++)
        if (isfinite(report->lengths[i].light))
            return true;
    return false;
}

static void widen_range(double value, double *low, double *high)
{
    if (!(value > 1e-200 && value < 1e200))
        return;
    *high = fmax(*high, value);
    *low = fmin(*low, value);
}

/* The range of the axis: eight powers of ten at most. */
static bool light_range(const report_t *report, double *low, double *high)
{
    *low = INFINITY;
    *high = 0;
    for (uint32_t i = 0; i < report->length_count; i++) {
        widen_range(report->lengths[i].b, low, high);
        widen_range(report->lengths[i].light, low, high);
        widen_range(report->lengths[i].most, low, high);
    }
    *low = fmax(*low, 1e-8 * *high) / 1.8;
    *high *= 1.8;
    return *high > 0;
}

static void put_light_plot(page_t *page, double low, double high)
{
    static const svg_style_t style = {"var(--c1)", "", 0}, all = {"var(--c5)", "", 1}, most = {"var(--c2)", "", 2};
    const report_t *report = page->report;
    svg_t *svg =
        svg_new_embedded(WIDTH, HEIGHT, "light-plot", "The light that paths of each length bring",
                         "Estimates of b over path length on a logarithmic axis, with lines of two standard "
                         "errors to either side; where samples bring a part, all light of the length as well; what "
                         "b may be at most; the table below has the numbers.");
    const svg_panel_t panel = {.left = 52,
                               .top = 24,
                               .width = WIDTH - 62,
                               .height = HEIGHT - 66,
                               .x1 = report->length_count,
                               .y0 = low,
                               .y1 = high,
                               .linear_x = true};
    svg_grid(svg, &panel, "");
    for (uint32_t i = 0; i < report->length_count; i++) {
        const report_length_t *k = &report->lengths[i];
        char text[128];
        if (k->light >= low) {
            snprintf(text, sizeof text, "length %.0f: all light, %.4g", k->length, k->light);
            svg_dot(svg, &panel, i + 0.5, k->light, &all, text);
        }
        if (k->most >= low) {
            snprintf(text, sizeof text, "length %.0f: b at most %.4g", k->length, k->most);
            svg_dot(svg, &panel, i + 0.5, k->most, &most, text);
        }
        if (!(k->b >= low))
            continue;
        snprintf(text, sizeof text, "length %.0f: b %.4g, standard error %.2g", k->length, k->b, k->b_error);
        svg_whisker(svg, &panel, i + 0.5, k->b, k->b - 2 * k->b_error, k->b + 2 * k->b_error, &style, text);
    }
    put_length_numbers(svg, &panel, report, report->length_count);
    svg_axis_names(svg, &panel, "path length, segments", "b");
    page_plot(page, &svg, "");
}

static void put_light_table(page_t *page)
{
    static const page_column_t columns[] = {
        {"Length", false},  {"b", false},         {"Relative standard error", false},
        {"At most", false}, {"All light", false}, {"Share of the light", false},
        {"Cap", false}};
    const report_t *report = page->report;
    const size_t count = sizeof columns / sizeof columns[0] - !is_split(report);
    double sum = 0;
    for (uint32_t i = 0; i < report->length_count; i++)
        sum += light_of(&report->lengths[i]) > 0 ? light_of(&report->lengths[i]) : 0;
    page_table(page, "b of each length", columns, count, true);
    for (uint32_t i = 0; i < report->length_count; i++) {
        const report_length_t *k = &report->lengths[i];
        page_row(page);
        page_cell_number(page, PAGE_COUNT, k->length);
        page_cell_number(page, PAGE_NUMBER, k->b);
        page_cell_number(page, PAGE_PERCENT, k->b_error / k->b);
        page_cell_number(page, PAGE_NUMBER, k->most);
        page_cell_number(page, PAGE_NUMBER, light_of(k));
        page_cell_number(page, PAGE_PERCENT, light_of(k) / sum);
        if (is_split(report))
            page_cell_number(page, PAGE_NUMBER, k->cap);
        page_row_end(page);
    }
    page_table_end(page, true);
}

void page_light(page_t *page)
{
    double low, high;
    if (page->report->length_count == 0)
        return;
    page_section(page, "light", "half", "Light by path length");
    if (light_range(page->report, &low, &high)) {
        page_put(page,
                 "<p>b: the image's light in the scalar that chains follow. Lines: two standard errors to either "
                 "side.%s%s</p>\n",
                 is_split(page->report) ? " Squares: all light of the length, by the pilot; samples bring of each "
                                          "path what is below the cap, and all "
                                          "where there is none."
                                        : "",
                 is_bounded(page->report) ? " Triangles: the most that b may be by the pilot (95\xc2\xa0%)." : "");
        put_light_plot(page, low, high);
    } else {
        page_put(page, "<p>No light was found.</p>\n");
    }
    page_say_missed(page);
    put_light_table(page);
    page_section_end(page);
}
