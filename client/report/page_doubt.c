/* page_doubt.c: what keeps a figure or the image from being taken at its word, in sentences: whether the estimate
 * of the error is reliable, what light the job leaves out, what light of single lengths may not have been met. */
#include <math.h>
#include <string.h>

#include "client/report/page_parts.h"

enum { MOST_RANGES = 16 /* of path lengths that are listed */ };

/* ---- the error ---- */

typedef enum doubt_trust { TRUST_UNKNOWN, TRUST_RELIABLE, TRUST_UNRELIABLE } doubt_trust_t;

/* A reader of optional fields leaves alone what the report does not tell. */
static doubt_trust_t error_trust(const report_t *report)
{
    const json_t *error = report_member(report, "error");
    bool either[2] = {false, true};
    for (int i = 0; i < 2; i++)
        if (!error || json_read_bool_or(error, "error", "reliable", &either[i], NULL) != FAULT_NONE)
            return TRUST_UNKNOWN;
    return either[0] != either[1] ? TRUST_UNKNOWN : either[0] ? TRUST_RELIABLE : TRUST_UNRELIABLE;
}

void page_say_trust(page_t *page)
{
    const doubt_trust_t trust = error_trust(page->report);
    const char *reason = report_text(page->report, "error", "reason");
    if (trust == TRUST_UNKNOWN || !isfinite(report_number(page->report, "error", "error")))
        return;
    if (trust == TRUST_RELIABLE) {
        page_put(page, "<p class=\"trust\">Nothing that the render has seen speaks against this estimate.</p>\n");
        return;
    }
    page_put(page, "<p class=\"trust warn\">This estimate is <strong>not reliable</strong>");
    if (reason) {
        page_put(page, ": ");
        page_say(page, reason);
    }
    page_put(page, ". The image may be farther off than it says.</p>\n");
}

/* ---- what is left out ---- */

static bool is_left_out(const report_effect_t *effect)
{
    return effect->state && effect->name && strcmp(effect->state, "forbidden") == 0;
}

/* "caustics, indirect and aperture" */
static void say_left_out_effects(page_t *page)
{
    const report_t *report = page->report;
    uint32_t left = 0;
    for (uint32_t i = 0; i < report->effect_count; i++)
        left += is_left_out(&report->effects[i]);
    if (left == 0)
        page_put(page, "some effects");
    for (uint32_t i = 0; i < report->effect_count; i++) {
        if (!is_left_out(&report->effects[i]))
            continue;
        page_say(page, report->effects[i].name);
        left--;
        page_put(page, "%s", left > 1 ? ", " : left == 1 ? " and " : "");
    }
}

void page_warn_left_out(page_t *page)
{
    const double share = report_number(page->report, "left_out", "energy"),
                 error = report_number(page->report, "left_out", "standard_error");
    if (!report_member(page->report, "left_out"))
        return;
    page_put(page, "<p class=\"warn\">The job <a href=\"#effects\">leaves out</a> ");
    say_left_out_effects(page);
    if (isfinite(share) && !(share == 0 && !isfinite(error))) {
        page_put(page, ": the image lacks ");
        page_say_measured(page, share, error);
        page_put(page, " of the light.</p>\n");
    } else {
        page_put(page, ": %s.</p>\n",
                 share == 0 ? "no such light was met, how little it is is not known"
                            : "how much light is not known");
    }
}

void page_say_left_out(page_t *page)
{
    const double share = report_number(page->report, "left_out", "energy"),
                 error = report_number(page->report, "left_out", "standard_error"),
                 samples = report_number(page->report, "left_out", "samples");
    if (!isfinite(share))
        return;
    page_put(page, "<p>All that the job leaves out: ");
    page_say_measured(page, share, error);
    page_put(page, " of the light that there would be, what several effects share counted once");
    if (samples > 0) {
        page_put(page, "; measured by ");
        page_say_number(page, PAGE_COUNT, samples);
        page_put(page, " samples of their own");
    }
    page_put(page, ".</p>\n");
}

/* ---- what was not met ---- */

/* "5, 7 to 9": whole numbers from 1 on, rising; anything else is passed over. */
static void say_lengths(page_t *page, const json_t *list)
{
    uint32_t count = 0, ranges = 0;
    double first = 0, last = 0;
    const json_t *at = list && json_is_array(list) ? json_first(list) : NULL;
    for (;; at = json_next(at)) {
        const double length = at && json_is_number(at) ? json_number(at) : NAN;
        if (at && !(length > last && length <= REPORT_MAX_LENGTHS && length == floor(length)))
            continue;
        if (at && count > 0 && length == last + 1) {
            last = length;
            count++;
            continue;
        }
        if (count > 0 && ranges++ < MOST_RANGES) {
            page_put(page, "%s%.0f", ranges > 1 ? ", " : "", first);
            if (last > first)
                page_put(page, "%s%.0f", last > first + 1 ? " to " : ", ", last);
        }
        if (!at)
            break;
        first = last = length;
        count++;
    }
    if (ranges > MOST_RANGES)
        page_put(page, " and others");
}

void page_say_missed(page_t *page)
{
    const json_t *missed = report_member(page->report, "missed"),
                 *lengths = missed && json_is_object(missed) ? json_get(missed, "lengths") : NULL;
    const double most = report_number(page->report, "missed", "most");
    if (!lengths || !json_is_array(lengths) || json_size(lengths) == 0)
        return;
    page_put(page,
             "<p>Missing from the image, as the pilot met no light of them to start chains from: path lengths ");
    say_lengths(page, lengths);
    if (isfinite(most)) {
        page_put(page, ". They may bring at most ");
        page_say_number(page, PAGE_PERCENT, most);
        page_put(page, " of the light (95\xc2\xa0%%)");
    }
    page_put(page, ".</p>\n");
}
