/* page_error.c: the error over time: what was measured, the law fitted to it, when the next marks will be reached.
 */
#include <math.h>
#include <string.h>

#include "client/report/page_parts.h"

enum { LAW_POINTS = 96, MAX_LABELS = 32 };

static const double beyond = 300; /* the plot ends at so many times the time that has been spent */

/* What the plot shows: errors over seconds of work. */
typedef struct curve {
    double x[REPORT_MAX_HISTORY], y[REPORT_MAX_HISTORY];
    uint32_t count;
    double first, last; /* of x */
    double target_x[REPORT_MAX_TARGETS], low_x[REPORT_MAX_TARGETS], high_x[REPORT_MAX_TARGETS],
        target_y[REPORT_MAX_TARGETS]; /* by falling error */
    uint32_t target_count;
    double end;    /* of the x axis */
    double y0, y1; /* the y axis */
    bool cpu;      /* x are processor seconds; else wall time */
    bool has_law;
} curve_t;

/* ---- what there is ---- */

static void take_points(curve_t *curve, const report_t *report)
{
    for (uint32_t i = 0; i < report->history_count; i++)
        curve->cpu |= report->history[i].cpu_seconds > 0;
    for (uint32_t i = 0; i < report->history_count; i++) {
        const report_point_t *point = &report->history[i];
        const double x = curve->cpu ? point->cpu_seconds : point->seconds;
        if (!(x > 0 && x < 1e15 && point->error > 1e-9 && point->error < 1e9))
            continue;
        if (curve->count > 0 && !(x > curve->x[curve->count - 1]))
            continue;
        curve->x[curve->count] = x;
        curve->y[curve->count++] = point->error;
    }
}

/* Targets beyond what is shown are left to the table. */
static void take_targets(curve_t *curve, const report_t *report)
{
    double before = INFINITY;
    for (uint32_t i = 0; i < report->target_count; i++) {
        const report_target_t *target = &report->targets[i];
        const double wall = target->seconds, x = curve->cpu ? 3600 * target->worker_hours : wall;
        if (!(x >= curve->first && x <= beyond * curve->last && target->error > 1e-9 && target->error < before))
            continue;
        const uint32_t at = curve->target_count++;
        const double scale = wall > 0 ? x / wall : NAN;
        before = curve->target_y[at] = target->error;
        curve->target_x[at] = x;
        curve->low_x[at] = target->low * scale;
        curve->high_x[at] = target->high * scale;
    }
}

static double law(const report_t *report, double t)
{
    return report->law_a + report->law_c * pow(t, -report->law_p);
}

static void find_ranges(curve_t *curve)
{
    double low = INFINITY, high = 0;
    for (uint32_t i = 0; i < curve->count; i++) {
        low = fmin(low, curve->y[i]);
        high = fmax(high, curve->y[i]);
    }
    curve->end = 1.4 * curve->last;
    for (uint32_t i = 0; i < curve->target_count; i++) {
        curve->end = fmax(curve->end, 1.6 * curve->target_x[i]);
        low = fmin(low, curve->target_y[i]);
    }
    curve->y0 = 0.72 * low;
    curve->y1 = fmax(1.4 * high, 2.2 * low);
}

/* False: there is nothing to draw. */
static bool curve_of(curve_t *curve, const report_t *report)
{
    memset(curve, 0, sizeof *curve);
    take_points(curve, report);
    if (curve->count == 0)
        return false;
    curve->first = curve->x[0];
    curve->last = curve->x[curve->count - 1];
    curve->has_law = curve->cpu && isfinite(report->law_a + report->law_c + report->law_p) && report->law_p >= 0 &&
                     report->law_c >= 0 && isfinite(law(report, curve->last));
    take_targets(curve, report);
    find_ranges(curve);
    return true;
}

/* ---- axes ---- */

typedef void tick_t(svg_t *svg, const svg_panel_t *panel, double value, const char *label);

/* Labels at those of the values that are in range and `apart` pixels from one that has one; the first ones first.
 */
static void put_ticks(svg_t *svg, const svg_panel_t *panel, const double *values, size_t count, page_kind_t kind,
                      bool along_x, double apart)
{
    double taken[MAX_LABELS];
    size_t labels = 0;
    const double low = along_x ? panel->x0 : panel->y0, high = along_x ? panel->x1 : panel->y1;
    tick_t *tick = along_x ? svg_tick_x : svg_tick_y;
    for (size_t i = 0; i < count && labels < MAX_LABELS; i++) {
        if (!(values[i] >= low && values[i] <= high))
            continue;
        const double at = along_x ? svg_place_x(panel, values[i]) : svg_place_y(panel, values[i]);
        bool free = true;
        for (size_t j = 0; j < labels; j++)
            free = free && fabs(at - taken[j]) >= apart;
        if (!free)
            continue;
        char text[PAGE_NUMBER_SIZE];
        taken[labels++] = at;
        tick(svg, panel, values[i], page_number(text, kind, values[i]));
    }
}

static void put_axes(svg_t *svg, const svg_panel_t *panel, const curve_t *curve)
{
    static const double times[] = {1e-3,  1e-2,  .1,    1, 10, 60,  600,  3600, 36e3, 864e2, 864e3,
                                   864e4, 864e5, 864e6, 5, 30, 300, 1800, 18e3, 2,    20,    120,
                                   1200,  7200,  72e3,  3, 40, 50,  180,  240,  900,  2700,  108e2},
                        errors[] = {.01,  .1,   1,    .001, 1e-4, 10,  100, .02, .05, .2,  .5, 2,   5e-3,
                                    2e-3, 5e-4, 2e-4, 5,    20,   .03, .3,  .04, .4,  .07, .7, .15, .6};
    put_ticks(svg, panel, times, sizeof times / sizeof times[0], PAGE_SECONDS, true, 64);
    put_ticks(svg, panel, errors, sizeof errors / sizeof errors[0], PAGE_PERCENT, false, 22);
    svg_axis_names(svg, panel, curve->cpu ? "processor time, all workers together" : "time since the job began",
                   "estimated error");
    svg_frame(svg, panel);
}

/* ---- marks ---- */

static void put_law(svg_t *svg, const svg_panel_t *panel, const curve_t *curve, const report_t *report)
{
    static const svg_style_t known = {"var(--c1)", "", -1}, ahead = {"var(--c2)", "6 4", -1};
    double x[LAW_POINTS], y[LAW_POINTS];
    for (int part = 0; part < 2; part++) {
        const double from = part ? curve->last : curve->first, to = part ? panel->x1 : curve->last;
        size_t count = 0;
        for (int i = 0; i < LAW_POINTS; i++) {
            x[count] = from * pow(to / from, i / (LAW_POINTS - 1.));
            y[count] = law(report, x[count]);
            if (y[count] >= panel->y0 && y[count] <= panel->y1)
                count++;
        }
        if (count > 1)
            svg_line(svg, panel, x, y, count, part ? &ahead : &known, part ? "the law, ahead" : "the law fitted");
    }
}

/* Between the earliest and the latest time at which each target may be reached. */
static void put_band(svg_t *svg, const svg_panel_t *panel, const curve_t *curve)
{
    static const svg_style_t style = {"var(--c2)", "", -1};
    double x[2 * REPORT_MAX_TARGETS + 1], y[2 * REPORT_MAX_TARGETS + 1];
    size_t count = 0;
    x[count] = curve->last;
    y[count++] = curve->y[curve->count - 1];
    for (uint32_t i = 0; i < curve->target_count; i++)
        if (curve->target_x[i] > curve->last && curve->high_x[i] >= curve->low_x[i]) {
            x[count] = fmax(curve->low_x[i], curve->last);
            y[count++] = curve->target_y[i];
        }
    for (uint32_t i = curve->target_count; i-- > 0;)
        if (curve->target_x[i] > curve->last && curve->high_x[i] >= curve->low_x[i]) {
            x[count] = curve->high_x[i];
            y[count++] = curve->target_y[i];
        }
    if (count > 2)
        svg_area(svg, panel, x, y, count, &style);
}

static void put_targets(svg_t *svg, const svg_panel_t *panel, const curve_t *curve)
{
    static const svg_style_t line = {"var(--c2)", "2 4", -1}, mark = {"var(--c2)", "", 2};
    for (uint32_t i = 0; i < curve->target_count; i++) {
        char error[PAGE_NUMBER_SIZE], time[PAGE_NUMBER_SIZE], low[PAGE_NUMBER_SIZE], high[PAGE_NUMBER_SIZE],
            text[4 * PAGE_NUMBER_SIZE + 32];
        page_number(error, PAGE_PERCENT, curve->target_y[i]);
        page_number(time, PAGE_SECONDS, curve->target_x[i]);
        snprintf(text, sizeof text, "%s after %s (%s to %s)", error, time,
                 page_number(low, PAGE_SECONDS, curve->low_x[i]),
                 page_number(high, PAGE_SECONDS, curve->high_x[i]));
        svg_level(svg, panel, curve->target_y[i], &line);
        svg_dot(svg, panel, curve->target_x[i], curve->target_y[i], &mark, text);
        /* where the falling curve is not: above to the right, or below to the left */
        const double at = svg_place_x(panel, curve->target_x[i]), y = svg_place_y(panel, curve->target_y[i]);
        const bool left = at > panel->left + panel->width - 110;
        snprintf(text, sizeof text, "%s: %s", error, time);
        svg_text(svg, left ? at - 7 : at + 7, left ? y + 15 : y - 7, left ? "end" : "start", 11, text);
    }
}

static void put_points(svg_t *svg, const svg_panel_t *panel, const curve_t *curve)
{
    static const svg_style_t style = {"var(--c1)", "", 0};
    for (uint32_t i = 0; i < curve->count; i++) {
        char error[PAGE_NUMBER_SIZE], time[PAGE_NUMBER_SIZE], text[2 * PAGE_NUMBER_SIZE + 16];
        snprintf(text, sizeof text, "%s after %s", page_number(error, PAGE_PERCENT, curve->y[i]),
                 page_number(time, PAGE_SECONDS, curve->x[i]));
        svg_dot(svg, panel, curve->x[i], curve->y[i], &style, text);
    }
}

static void put_curve(page_t *page, const curve_t *curve, int width, int height, bool narrow)
{
    char first[PAGE_NUMBER_SIZE], last[PAGE_NUMBER_SIZE], time[PAGE_NUMBER_SIZE], text[320];
    snprintf(
        text, sizeof text,
        "%u estimates of the error from %s to %s, the last after %s of processor time. %u of the marks ahead are "
        "shown; all are in the table.",
        curve->count, page_number(first, PAGE_PERCENT, curve->y[0]),
        page_number(last, PAGE_PERCENT, curve->y[curve->count - 1]), page_number(time, PAGE_SECONDS, curve->last),
        curve->target_count);
    svg_t *svg = svg_new_embedded(width, height, narrow ? "error-narrow" : "error-plot",
                                  "Estimated error over time, both logarithmic", text);
    const svg_panel_t panel = {.left = 52,
                               .top = 22,
                               .width = width - 66,
                               .height = height - 62,
                               .x0 = 0.9 * curve->first,
                               .x1 = curve->end,
                               .y0 = curve->y0,
                               .y1 = curve->y1};
    put_axes(svg, &panel, curve);
    put_band(svg, &panel, curve);
    if (curve->has_law)
        put_law(svg, &panel, curve, page->report);
    put_points(svg, &panel, curve);
    put_targets(svg, &panel, curve);
    page_plot(page, &svg, narrow ? "for-narrow" : "for-wide");
}

/* ---- words and tables ---- */

static void put_law_words(page_t *page)
{
    const report_t *report = page->report;
    if (!isfinite(report->law_a + report->law_c + report->law_p))
        return;
    page_put(page, "<p>The law fitted to the estimates: error = ");
    if (report->law_a != 0) {
        page_say_number(page, PAGE_NUMBER, report->law_a);
        page_put(page, " + ");
    }
    page_say_number(page, PAGE_NUMBER, report->law_c);
    page_put(page, " t<sup>\xe2\x88\x92");
    page_say_number(page, PAGE_NUMBER, report->law_p);
    page_put(page, "</sup>, t in seconds of processor time");
    if (report_number(report, "prediction", "workers") > 0) {
        page_put(page, ", of which there were ");
        page_say_number(page, PAGE_NUMBER, report_number(report, "prediction", "workers"));
        page_put(page, " a second of wall clock");
    }
    page_put(page, ".</p>\n");
}

/* Where the variances come from. */
static void put_method(page_t *page)
{
    if (!report_text(page->report, "error", "method"))
        return;
    page_put(page, "<p>Estimates: ");
    page_say(page, report_text(page->report, "error", "method"));
    page_put(page, ".</p>\n");
}

/* What the prediction was worth: made after a tenth of the time, told what came. */
static void put_first_tenth(page_t *page)
{
    const json_t *prediction = report_member(page->report, "prediction"),
                 *tenth = prediction && json_is_object(prediction) ? json_get(prediction, "first_tenth") : NULL;
    const double at = report_number_of(tenth, "at_seconds"),
                 predicted = report_number_of(tenth, "predicted_seconds"),
                 actual = report_number_of(tenth, "actual_seconds");
    if (!isfinite(at + predicted + actual))
        return;
    page_put(page, "<p>After ");
    page_say_number(page, PAGE_SECONDS, at);
    page_put(page, " the error at the end was predicted to be reached after ");
    page_say_number(page, PAGE_SECONDS, predicted);
    page_put(page, "; it took ");
    page_say_number(page, PAGE_SECONDS, actual);
    page_put(page, ".</p>\n");
}

static void put_targets_table(page_t *page)
{
    static const page_column_t columns[] = {{"Error", false},
                                            {"Expected after", false},
                                            {"Not before", false},
                                            {"Not after", false},
                                            {"Worker hours", false}};
    const report_t *report = page->report;
    if (report->target_count == 0)
        return;
    page_table(page, "When an error is reached, wall clock", columns, sizeof columns / sizeof columns[0], false);
    for (uint32_t i = 0; i < report->target_count; i++) {
        const report_target_t *target = &report->targets[i];
        page_row(page);
        page_cell_number(page, PAGE_PERCENT, target->error);
        page_cell_number(page, PAGE_SECONDS, target->seconds);
        page_cell_number(page, PAGE_SECONDS, target->low);
        page_cell_number(page, PAGE_SECONDS, target->high);
        page_cell_number(page, PAGE_NUMBER, target->worker_hours);
        page_row_end(page);
    }
    page_table_end(page, false);
}

static void put_history_table(page_t *page)
{
    static const page_column_t columns[] = {
        {"Time", false}, {"Processor time", false}, {"Mutations", false}, {"Error", false}, {"relMSE", false}};
    const report_t *report = page->report;
    page_table(page, "All estimates", columns, sizeof columns / sizeof columns[0], true);
    for (uint32_t i = 0; i < report->history_count; i++) {
        const report_point_t *point = &report->history[i];
        page_row(page);
        page_cell_number(page, PAGE_SECONDS, point->seconds);
        page_cell_number(page, PAGE_SECONDS, point->cpu_seconds);
        page_cell_number(page, PAGE_COUNT, point->mutations);
        page_cell_number(page, PAGE_PERCENT, point->error);
        page_cell_number(page, PAGE_NUMBER, point->relmse);
        page_row_end(page);
    }
    page_table_end(page, true);
}

void page_error(page_t *page)
{
    const report_t *report = page->report;
    curve_t curve;
    if (report->history_count == 0 && report->target_count == 0)
        return;
    page_section(page, "error", "wide", "Error over time");
    if (curve_of(&curve, report)) {
        page_put(page, "<p>Dots: the estimates as the render went on. %sBoth axes are logarithmic.</p>\n",
                 curve.has_law
                     ? "Line: the law fitted to them, dashed where it is a prediction; pale: where the marks "
                       "may be reached (95\xc2\xa0%). "
                     : "");
        put_curve(page, &curve, 1040, 360, false);
        put_curve(page, &curve, 400, 330, true);
    } else {
        page_put(page, "<p>No estimate of the error was made while the render ran.</p>\n");
    }
    put_method(page);
    put_law_words(page);
    put_first_tenth(page);
    put_targets_table(page);
    if (report->history_count > 0)
        put_history_table(page);
    page_section_end(page);
}
