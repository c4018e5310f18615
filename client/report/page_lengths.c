/* page_lengths.c: what paths of each length bring and cost. */
#include <math.h>
#include <stddef.h>

#include "client/report/page_parts.h"

enum { WIDTH = 520, HEIGHT = 270 };

/* A series of the plot by length: a field's share of its sum. */
typedef struct series {
    const char *name, *colour;
    size_t field;
    double sum; /* 0: nothing is known of it */
} series_t;

enum { SERIES = 3 };

static double field_of(const report_length_t *length, size_t field)
{
    return *(const double *)(const void *)((const char *)length + field);
}

static void find_series(series_t series[SERIES], const report_t *report)
{
    series[0] = (series_t){"error (relMSE)", "var(--c2)", offsetof(report_length_t, relmse), 0};
    series[1] = (series_t){"processor time", "var(--c1)", offsetof(report_length_t, cpu_seconds), 0};
    series[2] = (series_t){"light", "var(--c5)", offsetof(report_length_t, b), 0};
    for (int i = 0; i < SERIES; i++) {
        series[i].sum = report_sum(report, series[i].field);
        if (!isfinite(series[i].sum))
            series[i].sum = 0;
    }
}

static double largest_share(const series_t series[SERIES], const report_t *report)
{
    double most = 0;
    for (int i = 0; i < SERIES; i++)
        for (uint32_t j = 0; series[i].sum > 0 && j < report->length_count; j++)
            most = fmax(most, field_of(&report->lengths[j], series[i].field) / series[i].sum);
    return most;
}

static void put_bars(svg_t *svg, const svg_panel_t *panel, const series_t series[SERIES], const report_t *report)
{
    int shown = 0, at = 0;
    for (int i = 0; i < SERIES; i++)
        shown += series[i].sum > 0;
    const double cell = panel->width / report->length_count, bar = 0.78 * cell / fmax(1, shown);
    for (int i = 0; i < SERIES; i++) {
        if (!(series[i].sum > 0))
            continue;
        for (uint32_t j = 0; j < report->length_count; j++) {
            const double share = field_of(&report->lengths[j], series[i].field) / series[i].sum;
            char number[PAGE_NUMBER_SIZE], text[PAGE_NUMBER_SIZE + 64];
            if (!(share > 0))
                continue;
            snprintf(text, sizeof text, "length %.0f: %s of the %s", report->lengths[j].length,
                     page_number(number, PAGE_PERCENT, share), series[i].name);
            const double top = svg_place_y(panel, share);
            svg_rect(svg, panel->left + cell * j + 0.11 * cell + bar * at, top, fmax(0.5, bar - 1),
                     panel->top + panel->height - top, series[i].colour, 1, text);
        }
        at++;
    }
}

/* Numbers below the bars, as many as there is room for. */
static void put_length_numbers(svg_t *svg, const svg_panel_t *panel, const report_t *report)
{
    const double cell = panel->width / report->length_count;
    const uint32_t step = (uint32_t)ceil(18 / cell);
    for (uint32_t j = 0; j < report->length_count; j += step) {
        char text[32];
        snprintf(text, sizeof text, "%.0f", report->lengths[j].length);
        svg_text_in(svg, panel->left + cell * (j + 0.5), panel->top + panel->height + 14, "middle", 10.5,
                    "var(--muted)", text);
    }
}

static void put_percents(svg_t *svg, const svg_panel_t *panel)
{
    const double step = panel->y1 > 0.5 ? 0.2 : panel->y1 > 0.2 ? 0.1 : panel->y1 > 0.1 ? 0.05 : 0.02;
    for (int i = 0; i <= 5 && i * step <= panel->y1 * (1 + 1e-9); i++) {
        char text[PAGE_NUMBER_SIZE];
        svg_tick_y(svg, panel, i * step, page_number(text, PAGE_PERCENT, i * step));
    }
}

static void put_shares_plot(page_t *page, const series_t series[SERIES])
{
    const report_t *report = page->report;
    char text[160];
    snprintf(text, sizeof text,
             "For each of %u path lengths its share of the error, of the time and of the light, "
             "as bars; the table below has the numbers.",
             report->length_count);
    svg_t *svg = svg_new_embedded(WIDTH, HEIGHT, "lengths-plot", "Error, time and light by path length", text);
    const svg_panel_t panel = {.left = 40,
                               .top = 34,
                               .width = WIDTH - 50,
                               .height = HEIGHT - 76,
                               .x1 = 1,
                               .y1 = fmin(1, 1.08 * largest_share(series, report)),
                               .linear_x = true,
                               .linear_y = true};
    put_percents(svg, &panel);
    put_bars(svg, &panel, series, report);
    put_length_numbers(svg, &panel, report);
    double x = panel.left;
    for (int i = 0; i < SERIES; i++)
        if (series[i].sum > 0) {
            svg_rect(svg, x, 8, 11, 11, series[i].colour, 1, "");
            svg_text(svg, x + 16, 18, "start", 12, series[i].name);
            x += i == 0 ? 128 : 124;
        }
    svg_axis_names(svg, &panel, "path length, segments", "");
    page_plot(page, &svg, "");
}

static void put_lengths_table(page_t *page)
{
    static const page_column_t columns[] = {{"Length", false}, {"Light b", false},       {"relMSE", false},
                                            {"Share", false},  {"Mutations", false},     {"Time", false},
                                            {"Chains", false}, {"Without light", false}, {"Longest stay", false}};
    const report_t *report = page->report;
    page_table(page, "Numbers by path length", columns, sizeof columns / sizeof columns[0], true);
    for (uint32_t i = 0; i < report->length_count; i++) {
        const report_length_t *k = &report->lengths[i];
        page_row(page);
        page_cell_number(page, PAGE_COUNT, k->length);
        page_cell_number(page, PAGE_NUMBER, k->b);
        page_cell_number(page, PAGE_NUMBER, k->relmse);
        page_cell_number(page, PAGE_PERCENT, k->share);
        page_cell_number(page, PAGE_COUNT, k->mutations);
        page_cell_number(page, PAGE_SECONDS, k->cpu_seconds);
        page_cell_number(page, PAGE_COUNT, k->chains);
        page_cell_number(page, PAGE_PERCENT, k->zero_contribution / k->mutations);
        page_cell_number(page, PAGE_COUNT, k->longest_stay);
        page_row_end(page);
    }
    page_table_end(page, true);
}

/* Of samples beside the chains no time is known by length. */
static void put_samples_words(page_t *page)
{
    const report_t *report = page->report;
    const double samples = report_number(report, "samples", "samples"),
                 seconds = report_number(report, "samples", "cpu_seconds");
    if (!(samples > 0))
        return;
    page_put(page, "<p>Beside the chains ");
    page_say_number(page, PAGE_COUNT, samples);
    page_put(page, " independent samples brought what they find easily");
    if (isfinite(seconds)) {
        page_put(page, ", in ");
        page_say_number(page, PAGE_SECONDS, seconds);
        page_put(page, " of processor time; the times by length are those of the chains");
    }
    page_put(page, ".</p>\n");
}

void page_lengths(page_t *page)
{
    series_t series[SERIES];
    if (page->report->length_count == 0)
        return;
    page_section(page, "lengths", "half", "By path length");
    find_series(series, page->report);
    page_put(page, "<p>Where the error comes from, and where the time goes.%s</p>\n",
             series[0].sum > 0 ? "" : " The error by length is not known.");
    put_samples_words(page);
    if (largest_share(series, page->report) > 0)
        put_shares_plot(page, series);
    put_lengths_table(page);
    page_section_end(page);
}

/* ---- b_k ---- */

/* The range of the axis: eight powers of ten at most. */
static bool light_range(const report_t *report, double *low, double *high)
{
    *low = INFINITY;
    *high = 0;
    for (uint32_t i = 0; i < report->length_count; i++)
        if (report->lengths[i].b > 1e-200 && report->lengths[i].b < 1e200) {
            *high = fmax(*high, report->lengths[i].b);
            *low = fmin(*low, report->lengths[i].b);
        }
    *low = fmax(*low, 1e-8 * *high) / 1.8;
    *high *= 1.8;
    return *high > 0;
}

static void put_light_plot(page_t *page, double low, double high)
{
    static const svg_style_t style = {"var(--c1)", "", 0};
    const report_t *report = page->report;
    svg_t *svg =
        svg_new_embedded(WIDTH, HEIGHT, "light-plot", "The light that paths of each length bring",
                         "Estimates of b over path length on a logarithmic axis, with lines of two standard "
                         "errors to either side; the table below has the numbers.");
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
        if (!(k->b >= low))
            continue;
        snprintf(text, sizeof text, "length %.0f: b %.4g, standard error %.2g", k->length, k->b, k->b_error);
        svg_whisker(svg, &panel, i + 0.5, k->b, k->b - 2 * k->b_error, k->b + 2 * k->b_error, &style, text);
    }
    put_length_numbers(svg, &panel, report);
    svg_axis_names(svg, &panel, "path length, segments", "b");
    page_plot(page, &svg, "");
}

static void put_light_table(page_t *page)
{
    static const page_column_t columns[] = {{"Length", false},
                                            {"b", false},
                                            {"Standard error", false},
                                            {"Relative", false},
                                            {"Share of the light", false}};
    const report_t *report = page->report;
    const double sum = report_sum(report, offsetof(report_length_t, b));
    page_table(page, "b of each length", columns, sizeof columns / sizeof columns[0], true);
    for (uint32_t i = 0; i < report->length_count; i++) {
        const report_length_t *k = &report->lengths[i];
        page_row(page);
        page_cell_number(page, PAGE_COUNT, k->length);
        page_cell_number(page, PAGE_NUMBER, k->b);
        page_cell_number(page, PAGE_NUMBER, k->b_error);
        page_cell_number(page, PAGE_PERCENT, k->b_error / k->b);
        page_cell_number(page, PAGE_PERCENT, k->b / sum);
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
                 "side.</p>\n");
        put_light_plot(page, low, high);
    } else {
        page_put(page, "<p>No light was found.</p>\n");
    }
    put_light_table(page);
    page_section_end(page);
}
