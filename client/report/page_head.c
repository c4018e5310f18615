/* page_head.c: the top of the page: what was rendered, how good it is, what to beware of. */
#include <math.h>
#include <string.h>

#include "client/report/page_parts.h"

/* ---- the picture ---- */

static void put_base64(page_t *page, const uint8_t *data, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char group[4];
    for (size_t i = 0; i < size; i += 3) {
        const size_t left = size - i;
        const uint32_t bits = (uint32_t)data[i] << 16 | (left > 1 ? (uint32_t)data[i + 1] << 8 : 0) |
                              (left > 2 ? (uint32_t)data[i + 2] : 0);
        group[0] = digits[bits >> 18];
        group[1] = digits[bits >> 12 & 63];
        group[2] = left > 1 ? digits[bits >> 6 & 63] : '=';
        group[3] = left > 2 ? digits[bits & 63] : '=';
        fwrite(group, 1, sizeof group, page->out);
    }
}

static bool has_picture(const page_t *page)
{
    return page->picture && page->picture->size <= PAGE_MAX_PICTURE;
}

static void put_picture(page_t *page)
{
    page_put(page, "<figure><img alt=\"The rendered image\" src=\"data:image/png;base64,");
    put_base64(page, page->picture->png, page->picture->size);
    page_put(page, "\"/></figure>\n");
}

/* ---- the headline ---- */

/* The scene's file with the folder that it is in: many are called scene.pbrt. */
static const char *scene_name(const report_t *report)
{
    const char *scene = report_text_of(report_member(report, "job"), "scene"), *name = scene;
    int folders = 0;
    for (const char *c = scene ? scene + strlen(scene) : NULL; c && c > scene; c--)
        if (c[-1] == '/' && ++folders == 2) {
            name = c;
            break;
        }
    return name && name[0] ? name : "A render";
}

static void put_facts(page_t *page)
{
    const report_t *report = page->report;
    const json_t *job = report_member(report, "job"),
                 *seed = job && json_is_object(job) ? json_get(job, "seed") : NULL;
    const double width = report_number(report, "", "width"), height = report_number(report, "", "height"),
                 longest = report_number(report, "", "max_path_length");
    const char *algorithm = report_text(report, "", "algorithm"), *between = "";
    page_put(page, "<p class=\"facts\">");
    if (width > 0 && height > 0) {
        page_put(page, "%.0f \xc3\x97 %.0f pixels", width, height);
        between = " \xc2\xb7 ";
    }
    if (algorithm) {
        page_put(page, "%s", between);
        page_say(page, algorithm);
        between = " \xc2\xb7 ";
    }
    if (longest > 0) {
        page_put(page, "%spaths of up to %.0f segments", between, longest);
        between = " \xc2\xb7 ";
    }
    if (seed && json_string(seed)) {
        page_put(page, "%sseed ", between);
        page_say(page, json_string(seed));
    }
    page_put(page, "</p>\n");
}

/* The two ends of error.interval as errors, not their squares; false if they are not known. */
static bool error_interval(const report_t *report, double ends[2])
{
    const json_t *error = report_member(report, "error"),
                 *interval = error && json_is_object(error) ? json_get(error, "interval") : NULL;
    if (!interval || !json_is_array(interval) || json_size(interval) != 2)
        return false;
    for (size_t i = 0; i < 2; i++)
        ends[i] = json_is_number(json_at(interval, i)) ? sqrt(json_number(json_at(interval, i))) : (double)NAN;
    return isfinite(ends[0] + ends[1]);
}

static const char *rule_words(const char *rule)
{
    static const struct {
        const char *rule, *words;
    } rules[] = {{"mutations_per_pixel", "all the mutations asked for were made"},
                 {"seconds", "the time asked for was over"},
                 {"error", "the error asked for was reached"}};
    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++)
        if (strcmp(rule, rules[i].rule) == 0)
            return rules[i].words;
    return NULL;
}

static void put_verdict(page_t *page)
{
    const report_t *report = page->report;
    const double error = report_number(report, "error", "error"),
                 wall = report_number(report, "time", "wall_seconds");
    const char *rule = report_text(report, "", "stopped_by");
    double ends[2];
    page_put(page, "<p class=\"verdict\">");
    if (isfinite(error)) {
        page_put(page, "The estimated error is <strong>");
        page_say_number(page, PAGE_PERCENT, error);
        page_put(page, "</strong>");
        if (error_interval(report, ends)) {
            page_put(page, " (95\xc2\xa0%%: ");
            page_say_number(page, PAGE_PERCENT, ends[0]);
            page_put(page, " to ");
            page_say_number(page, PAGE_PERCENT, ends[1]);
            page_put(page, ")");
        }
    } else {
        const char *reason = report_text(report, "error", "reason");
        page_put(page, "The error is <strong>not known</strong>: ");
        page_say(page, reason ? reason : "too few units of work for an estimate");
    }
    if (isfinite(wall)) {
        page_put(page, ", after <strong>");
        page_say_number(page, PAGE_SECONDS, wall);
        page_put(page, "</strong>");
    }
    page_put(page, ".");
    if (rule) {
        page_put(page, " The render ended by the rule <strong>");
        page_say(page, rule);
        page_put(page, "</strong>%s%s.", rule_words(rule) ? ": " : "", rule_words(rule) ? rule_words(rule) : "");
    }
    page_put(page, "</p>\n");
}

static void put_tile(page_t *page, const char *name, page_kind_t kind, double value, const char *below)
{
    if (!isfinite(value))
        return;
    page_put(page, "<div><dt>%s</dt><dd>", name);
    page_say_number(page, kind, value);
    if (below[0]) {
        page_put(page, "<small>");
        page_say(page, below);
        page_put(page, "</small>");
    }
    page_put(page, "</dd></div>\n");
}

static void put_tiles(page_t *page)
{
    const report_t *report = page->report;
    const double cpu =
        report_number(report, "time", "pilot_cpu_seconds") + report_number(report, "time", "render_cpu_seconds");
    char text[PAGE_NUMBER_SIZE], below[96] = "";
    double ends[2];
    if (error_interval(report, ends)) {
        snprintf(below, sizeof below, "relMSE %.4g", report_number(report, "error", "relmse"));
        if (!isfinite(report_number(report, "error", "relmse")))
            below[0] = '\0';
    }
    page_put(page, "<dl class=\"tiles\">\n");
    put_tile(page, "Estimated error", PAGE_PERCENT, report_number(report, "error", "error"), below);
    put_tile(page, "Time", PAGE_SECONDS, report_number(report, "time", "wall_seconds"), "wall clock");
    put_tile(page, "Work", PAGE_SECONDS, cpu, "of one processor core");
    const double workers = report_number(report, "service", "workers");
    put_tile(page, "Workers", PAGE_COUNT, workers, "processes that contributed");
    snprintf(below, sizeof below, "%s in all",
             page_number(text, PAGE_COUNT, report_number(report, "rates", "mutations")));
    put_tile(page, "Mutations per pixel", PAGE_NUMBER, report_number(report, "rates", "mutations_per_pixel"),
             below);
    const double rate = report_number(report, "rates", "rays_per_cpu_second");
    put_tile(page, "Rays per core and second", PAGE_COUNT, isfinite(rate) ? floor(rate) : rate, "");
    page_put(page, "</dl>\n");
}

/* ---- what to beware of ---- */

static void warn_of_counts(page_t *page)
{
    const json_t *rejected = report_member(page->report, "rejected");
    double sum = 0;
    for (const json_t *at = rejected && json_is_object(rejected) ? json_first(rejected) : NULL; at;
         at = json_next(at))
        if (json_is_number(at) && json_number(at) > 0)
            sum += json_number(at);
    if (!(sum > 0))
        return;
    page_put(page, "<p class=\"warn\">");
    page_say_number(page, PAGE_COUNT, sum);
    page_put(page,
             " paths or splats were thrown away for arithmetic's sake (see <a href=\"#trouble\">below</a>).</p>\n");
}

/* Whether chains of the length are shorter than usual, and more: they need not forget where they begin. */
static bool is_shortened(const report_t *report, double length)
{
    const json_t *list = json_get(report_member(report, "stuck"), "shortened");
    for (const json_t *at = json_is_array(list) ? json_first(list) : NULL; at; at = json_next(at))
        if (report_number_of(at, "length") == length)
            return true;
    return false;
}

/* Chains of the usual length that stayed on one path for a quarter of it or more. */
static void warn_of_stays(page_t *page)
{
    const report_t *report = page->report;
    uint32_t lengths = 0;
    double first = 0;
    for (uint32_t i = 0; i < report->length_count; i++) {
        const report_length_t *k = &report->lengths[i];
        if (k->longest_stay > 0.25 * k->mutations / k->chains && !is_shortened(report, k->length))
            first = lengths++ == 0 ? k->length : first;
    }
    if (lengths > 0)
        page_put(
            page,
            "<p class=\"warn\">Chains of %s %.0f%s stayed on one path for more than a quarter of their run: the "
            "error of the pixels there may be larger than estimated.</p>\n",
            lengths == 1 ? "path length" : "several path lengths, from", first, lengths == 1 ? "" : " on,");
}

static void put_warnings(page_t *page)
{
    const char *biased = report_text(page->report, "", "biased");
    if (biased) {
        page_put(page, "<p class=\"warn\">This image is biased: ");
        page_say(page, biased);
        page_put(page, "</p>\n");
    }
    page_warn_left_out(page);
    warn_of_counts(page);
    warn_of_stays(page);
    if (page->picture && !has_picture(page))
        page_put(page, "<p class=\"warn\">The picture has more than %d octets and is left out.</p>\n",
                 PAGE_MAX_PICTURE);
}

void page_head(page_t *page)
{
    page_put(page, "<header>\n<p class=\"kicker\">Garland render report</p>\n<h1>");
    page_say(page, scene_name(page->report));
    page_put(page, "</h1>\n");
    put_facts(page);
    page_put(page, "<div class=\"lead%s\">\n", has_picture(page) ? "" : " alone");
    if (has_picture(page))
        put_picture(page);
    page_put(page, "<div>\n");
    put_verdict(page);
    page_say_trust(page);
    put_tiles(page);
    page_put(page, "</div>\n</div>\n");
    put_warnings(page);
    page_put(page, "</header>\n");
}
