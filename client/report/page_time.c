/* page_time.c: where the time went, and how much independent groups of chains differ. */
#include <math.h>

#include "client/report/page_parts.h"

enum { WIDTH = 520, MOST_PARTS = 8 };

typedef struct part {
    const char *name, *what, *colour;
    double seconds;
} part_t;

/* ---- where the time went ---- */

static double part_seconds(const report_t *report, const char *name)
{
    const json_t *time = report_member(report, "time");
    const json_t *parts = time && json_is_object(time) ? json_get(time, "parts") : NULL;
    return report_number_of(parts, name);
}

/* The measured parts; where there are none, what every report has. */
static int find_parts(part_t parts[MOST_PARTS], const report_t *report, bool *measured)
{
    static const part_t all[] = {{"tracing", "rays through the scene", "var(--c1)", 0},
                                 {"shading", "all other work on paths", "var(--c3)", 0},
                                 {"inversion", "from paths back to numbers", "var(--c4)", 0},
                                 {"merging", "packing results, adding them up", "var(--c2)", 0},
                                 {"waiting", "workers without work", "var(--c5)", 0}};
    int count = 0;
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        const double seconds = part_seconds(report, all[i].name);
        if (!(seconds >= 0))
            continue;
        parts[count] = all[i];
        parts[count++].seconds = seconds;
    }
    *measured = count > 0;
    if (count > 0)
        return count;
    const double pilot = report_number(report, "time", "pilot_cpu_seconds"),
                 render = report_number(report, "time", "render_cpu_seconds");
    if (pilot >= 0)
        parts[count++] = (part_t){"pilot", "first look at the scene", "var(--c5)", pilot};
    if (render >= 0)
        parts[count++] = (part_t){"render", "all after it", "var(--c1)", render};
    return count;
}

static void put_time_bar(page_t *page, const part_t *parts, int count, double sum)
{
    svg_t *svg =
        svg_new_embedded(WIDTH, 74, "time-plot", "Where the processor time went",
                         "One bar, divided by what the time was spent on; the table below has the numbers.");
    double x = 0;
    for (int i = 0; i < count; i++) {
        char number[PAGE_NUMBER_SIZE], text[PAGE_NUMBER_SIZE + 64];
        const double share = parts[i].seconds / sum, width = WIDTH * share;
        snprintf(text, sizeof text, "%s: %s", parts[i].name, page_number(number, PAGE_PERCENT, share));
        svg_rect(svg, x, 22, fmax(0, width - 1.5), 42, parts[i].colour, 1, text);
        if (width > 66)
            svg_text_in(svg, x + width / 2, 47, "middle", 12.5, "var(--surface)", number);
        if (width > 66)
            svg_text_in(svg, x + width / 2, 15, "middle", 12, "var(--ink)", parts[i].name);
        x += width;
    }
    page_plot(page, &svg, "");
}

static void put_time_table(page_t *page, const part_t *parts, int count, double sum)
{
    static const page_column_t columns[] = {{"Part", true}, {"What", true}, {"Time", false}, {"Share", false}};
    page_table(page, "Processor time by what it was spent on", columns, sizeof columns / sizeof columns[0], false);
    for (int i = 0; i < count; i++) {
        page_row(page);
        page_put(page,
                 "<th scope=\"row\" class=\"words\"><span class=\"keys\"><svg aria-hidden=\"true\" viewBox=\"0 0 "
                 "10 10\"><rect width=\"10\" height=\"10\" rx=\"2\" fill=\"%s\"/></svg>%s</span></th>",
                 parts[i].colour, parts[i].name);
        page_cell_text(page, parts[i].what);
        page_cell_number(page, PAGE_SECONDS, parts[i].seconds);
        page_cell_number(page, PAGE_PERCENT, parts[i].seconds / sum);
        page_row_end(page);
    }
    page_table_end(page, false);
}

void page_time(page_t *page)
{
    part_t parts[MOST_PARTS];
    bool measured;
    double sum = 0;
    const int count = find_parts(parts, page->report, &measured);
    for (int i = 0; i < count; i++)
        sum += parts[i].seconds;
    if (!(sum > 0) || !isfinite(sum))
        return;
    page_section(page, "time", "half", "Where the time went");
    page_put(page, "<p>%s</p>\n",
             measured ? "Over all workers, from a sample of the rays and steps."
                      : "Processor time over all workers. What parts it has was not measured.");
    put_time_bar(page, parts, count, sum);
    put_time_table(page, parts, count, sum);
    page_section_end(page);
}

/* ---- groups ---- */

/* How far from 1 the axis reaches: past every group and two deviations. */
static double groups_reach(const report_t *report, double spread)
{
    double reach = isfinite(spread) ? 2.4 * fabs(spread) : 0;
    for (uint32_t i = 0; i < report->group_count; i++)
        if (isfinite(report->groups[i]))
            reach = fmax(reach, 1.15 * fabs(report->groups[i] - 1));
    return fmin(1e6, fmax(reach, 1e-6));
}

/* Where every mutation adds the same light, groups are as bright as each other whatever else they are. */
static bool groups_are_equal(const report_t *report)
{
    for (uint32_t i = 0; i < report->group_count; i++)
        if (!(fabs(report->groups[i] - 1) < 1e-6))
            return false;
    return true;
}

static void put_groups_plot(page_t *page, double spread)
{
    static const svg_style_t one = {"var(--muted)", "", -1}, band = {"var(--c3)", "", -1},
                             dot = {"var(--c3)", "", 0};
    const report_t *report = page->report;
    svg_t *svg =
        svg_new_embedded(WIDTH, 230, "groups-plot", "Brightness of independent groups of chains",
                         "A dot for each group: its mean brightness over the image's; a band of one standard "
                         "deviation to either side of 1.");
    const double reach = groups_reach(report, spread);
    const svg_panel_t panel = {.left = 58,
                               .top = 24,
                               .width = WIDTH - 68,
                               .height = 170,
                               .x1 = report->group_count,
                               .y0 = 1 - reach,
                               .y1 = 1 + reach,
                               .linear_x = true,
                               .linear_y = true};
    svg_grid(svg, &panel, "");
    if (isfinite(spread)) {
        const double x[] = {0, panel.x1}, low[] = {1 - spread, 1 - spread}, high[] = {1 + spread, 1 + spread};
        svg_band(svg, &panel, x, low, high, 2, &band);
    }
    svg_level(svg, &panel, 1, &one);
    for (uint32_t i = 0; i < report->group_count; i++) {
        char text[64];
        snprintf(text, sizeof text, "group %u: %.5g", i + 1, report->groups[i]);
        svg_dot(svg, &panel, i + 0.5, report->groups[i], &dot, text);
    }
    svg_axis_names(svg, &panel, "group", "brightness over the image's");
    page_plot(page, &svg, "");
}

void page_groups(page_t *page)
{
    static const page_column_t columns[] = {
        {"Group", false}, {"Brightness over the image's", false}, {"Deviation of its blocks", false}};
    const report_t *report = page->report;
    const double spread = report_number(report, "groups", "spread"),
                 strata = report_number(report, "", "stratification");
    if (report->group_count == 0 && !isfinite(spread))
        return; /* page_service has the stratification then */
    page_section(page, "groups", "half", "Stability between groups of chains");
    page_put(page, "<p>Independent groups of chains should be equally bright. Their standard deviation: ");
    page_say_number(page, PAGE_PERCENT, spread);
    page_put(page, ".</p>\n");
    if (report->group_count > 0 && groups_are_equal(report))
        page_put(page, "<p>They cannot differ here: every mutation adds the same light. What differs is where: the "
                       "deviations in the table.</p>\n");
    else if (report->group_count > 0)
        put_groups_plot(page, spread);
    if (isfinite(strata)) {
        page_put(page, "<p>Stratification: ");
        page_say_number(page, PAGE_NUMBER, strata);
        page_put(page,
                 ". 1: errors of neighbouring pixels are independent; 64: they rise and fall together.</p>\n");
    }
    if (report->group_count > 0) {
        page_table(page, "Brightness by group", columns, sizeof columns / sizeof columns[0], true);
        for (uint32_t i = 0; i < report->group_count; i++) {
            page_row(page);
            page_cell_number(page, PAGE_COUNT, i + 1);
            page_cell_number(page, PAGE_NUMBER, report->groups[i]);
            page_cell_number(page, PAGE_PERCENT, report->deviations[i]);
            page_row_end(page);
        }
        page_table_end(page, true);
    }
    page_section_end(page);
}
