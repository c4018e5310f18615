/* page_lists.c: what a report has in words and counts: effects, stuck chains, rejected paths, the service, the job.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "client/report/page_parts.h"
#include "draw/markup.h"

enum { MOST_ENTRIES = 64, MOST_JSON = 1 << 14 /* octets of a value that is shown as it is */ };

/* ---- effects ---- */

static void put_state(page_t *page, const char *state)
{
    const char *look = !state                                                            ? ""
                       : strcmp(state, "present") == 0                                   ? " on"
                       : strcmp(state, "forced") == 0 || strcmp(state, "forbidden") == 0 ? " set"
                                                                                         : "";
    page_put(page, "<td class=\"words\"><span class=\"state%s\">", look);
    page_say(page, state ? state : "not known");
    page_put(page, "</span></td>");
}

static void put_energy(page_t *page, const report_effect_t *effect)
{
    if (effect->energy == 0 && !isfinite(effect->energy_error))
        page_put(page, "<td>none met</td>"); /* which is not to say that there is none */
    else
        page_cell_measured(page, effect->energy, effect->energy_error);
}

static void put_effects_table(page_t *page)
{
    static const page_column_t columns[] = {
        {"Effect", true}, {"State", true}, {"Why", true}, {"What follows", true}, {"Share of the light", false}};
    page_table(page, "Effects and what was done about them", columns, sizeof columns / sizeof columns[0], false);
    for (uint32_t i = 0; i < page->report->effect_count; i++) {
        const report_effect_t *effect = &page->report->effects[i];
        page_row(page);
        page_cell_head(page, effect->name);
        put_state(page, effect->state);
        page_cell_text(page, effect->reason);
        page_cell_text(page, effect->consequence);
        put_energy(page, effect);
        page_row_end(page);
    }
    page_table_end(page, false);
}

void page_effects(page_t *page)
{
    const report_t *report = page->report;
    if (report->effect_count == 0)
        return;
    page_section(page, "effects", "wide", "Plan: what was rendered, and what was switched off");
    page_say_left_out(page);
    put_effects_table(page);
    page_section_end(page);
}

/* ---- stuck and rejected ---- */

/* What chains are shorter for: a stay ends with its chain. */
static void put_shorter(page_t *page)
{
    static const page_column_t columns[] = {{"Length", true}, {"As usual", false}, {"Here, in the mean", false}};
    const json_t *list = json_get(report_member(page->report, "stuck"), "shortened");
    int count = 0;
    for (const json_t *at = json_first(list); json_is_array(list) && at && count < MOST_ENTRIES;
         at = json_next(at)) {
        char name[PAGE_NUMBER_SIZE];
        const double length = report_number_of(at, "length");
        if (!isfinite(length))
            continue;
        if (count++ == 0) {
            page_put(page, "<p>Chains are shorter than usual, and more, where the pilot found places enough for "
                           "them to begin at: none can stay for longer than it is.</p>\n");
            page_table(page, "Mutations of a chain", columns, sizeof columns / sizeof columns[0], true);
        }
        page_row(page);
        page_cell_head(page, length == 0 ? "all" : page_number(name, PAGE_COUNT, length));
        page_cell_number(page, PAGE_COUNT, report_number_of(at, "from"));
        page_cell_number(page, PAGE_COUNT, report_number_of(at, "to"));
        page_row_end(page);
    }
    if (count > 0)
        page_table_end(page, true);
}

static void put_stuck_paths(page_t *page)
{
    const report_t *report = page->report;
    if (report->stuck_count == 0)
        return;
    page_put(page, "<ul>\n");
    for (uint32_t i = 0; i < report->stuck_count; i++) {
        page_put(page, "<li>");
        page_say(page, report->stuck[i]);
        page_put(page, "</li>\n");
    }
    page_put(page, "</ul>\n");
}

static void put_stuck(page_t *page)
{
    const report_t *report = page->report;
    const double chains = report_number(report, "stuck", "chains"),
                 weight = report_number(report, "stuck", "weight"), bound = report_number(report, "stuck", "bound");
    if (!isfinite(chains) && report->stuck_count == 0)
        return;
    page_put(page, "<h3>Stuck chains</h3>\n<p>");
    if (chains > 0) {
        page_say_number(page, PAGE_COUNT, chains);
        page_put(page, " chains were stuck on single paths");
        if (isfinite(weight)) {
            page_put(page, ", which hold ");
            page_say_number(page, PAGE_PERCENT, weight);
            page_put(page, " of the image's light");
        }
        page_put(page, ".");
        if (bound > 0) {
            page_put(page, " No chain of their path lengths brings more than ");
            page_say_number(page, PAGE_PERCENT, bound);
            page_put(page, " of it.");
        }
        page_put(page, "</p>\n");
    } else {
        page_put(page, "No chain was stuck.</p>\n");
    }
    put_stuck_paths(page);
    put_shorter(page);
}

/* What the counts mean; others are shown by their name alone. */
static const char *reject_words(const char *name)
{
    static const struct {
        const char *name, *words;
    } known[] = {{"nonfinite_ray", "a ray was not finite"},
                 {"nonfinite_weight", "a path's weight was not finite"},
                 {"nonfinite_value", "a path's contribution was not finite"},
                 {"negative_value", "a path's contribution was negative"},
                 {"film_nonfinite", "a splat was not finite"},
                 {"film_negative", "a splat was negative"},
                 {"film_saturated", "a splat met the largest number the film holds"}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (strcmp(name, known[i].name) == 0)
            return known[i].words;
    return "";
}

static void put_rejected(page_t *page)
{
    static const page_column_t columns[] = {{"Cause", true}, {"What", true}, {"Count", false}};
    const json_t *rejected = report_member(page->report, "rejected");
    int entries = 0;
    if (!rejected || !json_is_object(rejected))
        return;
    page_put(page, "<h3>Rejected paths</h3>\n");
    page_table(page, "Paths that were thrown away", columns, sizeof columns / sizeof columns[0], false);
    for (const json_t *at = json_first(rejected); at && entries < MOST_ENTRIES; at = json_next(at), entries++) {
        page_row(page);
        page_cell_head(page, json_name(at));
        page_cell_text(page, reject_words(json_name(at)));
        page_cell_number(page, PAGE_COUNT, report_number_of(rejected, json_name(at)));
        page_row_end(page);
    }
    page_table_end(page, false);
}

void page_trouble(page_t *page)
{
    page_section(page, "trouble", "half", "Stuck chains and rejected paths");
    put_stuck(page);
    put_rejected(page);
    if (!report_member(page->report, "rejected") && !report_member(page->report, "stuck"))
        page_put(page, "<p>The report does not say.</p>\n");
    page_section_end(page);
}

/* ---- the service ---- */

static void put_service_row(page_t *page, const char *name, page_kind_t kind, double value)
{
    if (!isfinite(value))
        return;
    page_row(page);
    page_cell_head(page, name);
    page_cell_number(page, kind, value);
    page_row_end(page);
}

void page_service(page_t *page)
{
    static const page_column_t columns[] = {{"What", true}, {"Value", false}};
    const report_t *report = page->report;
    const double submitted = report_number(report, "service", "submitted");
    if (!report_member(report, "service") && !report_member(report, "rates"))
        return;
    page_section(page, "service", "half", "Service and rates");
    if (submitted > 0 && submitted < 1e11) {
        char text[64];
        const time_t seconds = (time_t)submitted;
        struct tm utc;
        if (gmtime_r(&seconds, &utc) && strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &utc) > 0)
            page_put(page, "<p>Submitted %s UTC.</p>\n", text);
    }
    page_table(page, "Service and rates", columns, 2, false);
    put_service_row(page, "Set-up, wall clock", PAGE_SECONDS, report_number(report, "service", "setup_seconds"));
    put_service_row(page, "Pilot, wall clock", PAGE_SECONDS, report_number(report, "service", "pilot_seconds"));
    put_service_row(page, "Rendering, wall clock", PAGE_SECONDS,
                    report_number(report, "service", "render_seconds"));
    put_service_row(page, "Pilot, processor", PAGE_SECONDS, report_number(report, "time", "pilot_cpu_seconds"));
    put_service_row(page, "Rendering, processor", PAGE_SECONDS,
                    report_number(report, "time", "render_cpu_seconds"));
    put_service_row(page, "Pilot's candidates", PAGE_COUNT, report_number(report, "pilot", "candidates"));
    if (report_number(report, "pilot", "trial_chains") > 0)
        put_service_row(page, "Chains tried before the render", PAGE_COUNT,
                        report_number(report, "pilot", "trial_chains"));
    put_service_row(page, "Refining samples", PAGE_COUNT, report_number(report, "pilot", "refining_samples"));
    put_service_row(page, "Mutations per core and second", PAGE_COUNT,
                    floor(report_number(report, "rates", "mutations_per_cpu_second")));
    put_service_row(page, "Rays", PAGE_COUNT, report_number(report, "rates", "rays"));
    put_service_row(page, "Shadow rays among them", PAGE_COUNT, report_number(report, "rates", "shadow_rays"));
    put_service_row(page, "Stratification", PAGE_NUMBER, report_number(report, "", "stratification"));
    if (isfinite(report_number(report, "", "nets")))
        put_service_row(page, "Variance of samples that their even points leave", PAGE_PERCENT,
                        report_number(report, "", "nets"));
    put_service_row(page, "Attempts lost", PAGE_COUNT, report_number(report, "service", "attempts_lost"));
    put_service_row(page, "Attempts failed", PAGE_COUNT, report_number(report, "service", "attempts_failed"));
    page_table_end(page, false);
    page_section_end(page);
}

/* ---- as it is ---- */

static void put_json(page_t *page, const json_t *value)
{
    char *text = json_print(value, true);
    if (!text)
        return;
    page_put(page, "<pre tabindex=\"0\">");
    for (char *line = text, *end; line; line = end) { /* line by line: line ends are not to be spaces */
        end = line - text < MOST_JSON ? strchr(line, '\n') : NULL;
        if (end)
            *end++ = '\0';
        markup_escape_some(page->out, line, end ? REPORT_MAX_TEXT : MOST_JSON);
        fputs(end ? "\n" : "", page->out);
    }
    page_put(page, "</pre>\n");
    free(text);
}

/* Members that other sections show. */
static bool is_shown(const char *name)
{
    static const char *const shown[] = {
        "garland",         "instructions", "job",      "algorithm", "biased",         "width",      "height",
        "max_path_length", "stopped_by",   "time",     "error",     "stratification", "rates",      "lengths",
        "chains",          "pilot",        "rejected", "service",   "history",        "prediction", "groups",
        "effects",         "stuck",        "samples",  "regions",   "left_out",       "missed",     "nets"};
    for (size_t i = 0; i < sizeof shown / sizeof shown[0]; i++)
        if (strcmp(name, shown[i]) == 0)
            return true;
    return false;
}

void page_rest(page_t *page)
{
    int count = 0;
    for (const json_t *at = json_first(page->report->root); at && count < MOST_ENTRIES; at = json_next(at)) {
        if (!json_name(at) || is_shown(json_name(at)))
            continue;
        if (count++ == 0)
            page_section(page, "rest", "wide", "What else the report holds");
        page_put(page, "<h3>");
        page_say(page, json_name(at));
        page_put(page, "</h3>\n");
        put_json(page, at);
    }
    if (count > 0)
        page_section_end(page);
}

void page_job(page_t *page)
{
    const json_t *job = report_member(page->report, "job");
    if (!job)
        return;
    page_section(page, "job", "wide", "The job, with every default filled in");
    put_json(page, job);
    page_section_end(page);
}
