#include "client/report/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const json_t *member_of(const json_t *object, const char *name)
{
    return object && json_is_object(object) ? json_get(object, name) : NULL;
}

double report_number_of(const json_t *object, const char *name)
{
    const json_t *value = member_of(object, name);
    const double number = value && json_is_number(value) ? json_number(value) : (double)NAN;
    return isfinite(number) ? number : (double)NAN;
}

const char *report_text_of(const json_t *object, const char *name)
{
    const json_t *value = member_of(object, name);
    return value ? json_string(value) : NULL;
}

/* The first entry of a list or object; null if it is neither. */
static const json_t *entries_of(const json_t *object, const char *name)
{
    const json_t *list = member_of(object, name);
    return list && (json_is_array(list) || json_is_object(list)) ? json_first(list) : NULL;
}

/* ---- the parts of a report ---- */

/* Of more points than there is room for, every second one, as often as need be; the last is kept. */
static void read_history(report_t *report)
{
    uint32_t stride = 1, index = 0;
    for (const json_t *at = entries_of(report->root, "history"); at; at = json_next(at), index++) {
        const report_point_t point = {.seconds = report_number_of(at, "seconds"),
                                      .cpu_seconds = report_number_of(at, "cpu_seconds"),
                                      .mutations = report_number_of(at, "mutations"),
                                      .relmse = report_number_of(at, "relmse"),
                                      .error = report_number_of(at, "error")};
        if (index % stride != 0 && json_next(at))
            continue;
        if (report->history_count == REPORT_MAX_HISTORY) {
            for (uint32_t i = 0; i < REPORT_MAX_HISTORY / 2; i++)
                report->history[i] = report->history[2 * i];
            report->history_count = REPORT_MAX_HISTORY / 2;
            stride *= 2;
        }
        report->history[report->history_count++] = point;
    }
}

static void read_prediction(report_t *report)
{
    const json_t *prediction = member_of(report->root, "prediction"), *law = member_of(prediction, "law");
    report->law_a = report_number_of(law, "a");
    report->law_c = report_number_of(law, "c");
    report->law_p = report_number_of(law, "p");
    for (const json_t *at = entries_of(prediction, "targets"); at && report->target_count < REPORT_MAX_TARGETS;
         at = json_next(at))
        report->targets[report->target_count++] =
            (report_target_t){.error = report_number_of(at, "error"),
                              .seconds = report_number_of(at, "seconds"),
                              .low = report_number_of(at, "low"),
                              .high = report_number_of(at, "high"),
                              .worker_hours = report_number_of(at, "worker_hours")};
}

static void read_chains(report_length_t *length, const json_t *object)
{
    length->mutations = report_number_of(object, "mutations");
    length->chains = report_number_of(object, "chains");
    length->cpu_seconds = report_number_of(object, "cpu_seconds");
    length->zero_contribution = report_number_of(object, "zero_contribution");
    length->longest_stay = report_number_of(object, "longest_stay");
    const json_t *moves = member_of(object, "moves");
    for (const json_t *at = moves && json_is_object(moves) ? json_first(moves) : NULL;
         at && length->move_count < REPORT_MAX_MOVES; at = json_next(at))
        length->moves[length->move_count++] = (report_move_t){.name = json_name(at),
                                                              .proposed = report_number_of(at, "proposed"),
                                                              .acceptance = report_number_of(at, "acceptance")};
}

static void read_length(report_length_t *length, const json_t *object)
{
    const json_t *b = member_of(object, "b");
    length->length = report_number_of(object, "length");
    length->b = report_number_of(b, "value");
    length->b_error = report_number_of(b, "standard_error");
    length->most = report_number_of(object, "most");
    length->light = report_number_of(object, "light");
    length->cap = report_number_of(object, "cap");
    length->relmse = report_number_of(object, "relmse");
    length->inefficiency = report_number_of(object, "inefficiency");
    length->rays = report_number_of(object, "rays");
    length->steps = report_number_of(object, "steps");
    length->large_step = report_number_of(object, "large_step");
    const json_t *bias = member_of(object, "bias");
    length->bias_failures = report_number_of(bias, "failure_share");
    length->bias_variation = report_number_of(bias, "total_variation");
    length->bias_block = report_number_of(bias, "largest_block");
    length->share = report_number_of(object, "share");
    read_chains(length, object);
    for (const json_t *at = entries_of(object, "techniques"); at && length->technique_count < REPORT_MAX_TECHNIQUES;
         at = json_next(at))
        length->techniques[length->technique_count++] =
            (report_technique_t){.s = report_number_of(at, "s"),
                                 .value = report_number_of(at, "value"),
                                 .standard_error = report_number_of(at, "standard_error")};
}

static fault_code_t read_lengths(report_t *report, fault_t *fault)
{
    report->lengths = calloc(REPORT_MAX_LENGTHS, sizeof *report->lengths);
    if (!report->lengths)
        return fault_set(fault, FAULT_MEMORY, "no memory for a report");
    for (const json_t *at = entries_of(report->root, "lengths"); at && report->length_count < REPORT_MAX_LENGTHS;
         at = json_next(at)) {
        report_length_t *length = &report->lengths[report->length_count];
        read_length(length, at);
        if (length->length >= 1 && length->length <= REPORT_MAX_LENGTHS && length->length == floor(length->length))
            report->length_count++;
        else
            *length = (report_length_t){0};
    }
    read_length(&report->all, NULL);
    read_chains(&report->all, member_of(report->root, "chains"));
    report->all.length = 0;
    return FAULT_NONE;
}

static void read_effects(report_t *report)
{
    for (const json_t *at = entries_of(report->root, "effects"); at && report->effect_count < REPORT_MAX_EFFECTS;
         at = json_next(at))
        if (json_is_object(at))
            report->effects[report->effect_count++] =
                (report_effect_t){.name = report_text_of(at, "name"),
                                  .state = report_text_of(at, "state"),
                                  .reason = report_text_of(at, "reason"),
                                  .energy = report_number_of(at, "energy"),
                                  .energy_error = report_number_of(at, "energy_error"),
                                  .consequence = report_text_of(at, "consequence")};
}

/* Whole or not at all: as many values as columns and rows say. */
static void read_regions(report_t *report)
{
    const json_t *regions = member_of(report->root, "regions");
    const double columns = report_number_of(regions, "columns"), rows = report_number_of(regions, "rows");
    uint32_t count = 0;
    if (!(columns >= 1 && rows >= 1 && columns <= REPORT_MAX_REGIONS && rows <= REPORT_MAX_REGIONS) ||
        columns != floor(columns) || rows != floor(rows) || columns * rows > REPORT_MAX_REGIONS)
        return;
    const uint32_t expected = (uint32_t)columns * (uint32_t)rows;
    const json_t *at = entries_of(regions, "values");
    for (; at && count < expected; at = json_next(at))
        report->regions[count++] = (report_region_t){.luminance = report_number_of(at, "luminance"),
                                                     .low = report_number_of(at, "low"),
                                                     .high = report_number_of(at, "high")};
    if (at || count != expected)
        return;
    report->region_columns = (uint32_t)columns;
    report->region_rows = (uint32_t)rows;
}

static void read_lists(report_t *report)
{
    for (uint32_t i = 0; i < REPORT_MAX_GROUPS; i++)
        report->deviations[i] = (double)NAN;
    uint32_t deviation = 0;
    for (const json_t *at = entries_of(member_of(report->root, "groups"), "deviation");
         at && deviation < REPORT_MAX_GROUPS; at = json_next(at), deviation++)
        if (json_is_number(at) && isfinite(json_number(at)))
            report->deviations[deviation] = json_number(at);
    for (const json_t *at = entries_of(member_of(report->root, "groups"), "brightness");
         at && report->group_count < REPORT_MAX_GROUPS; at = json_next(at))
        report->groups[report->group_count++] =
            json_is_number(at) && isfinite(json_number(at)) ? json_number(at) : (double)NAN;
    for (const json_t *at = entries_of(member_of(report->root, "stuck"), "paths");
         at && report->stuck_count < REPORT_MAX_STUCK; at = json_next(at))
        if (json_string(at))
            report->stuck[report->stuck_count++] = json_string(at);
}

static fault_code_t read_whole(report_t *report, fault_t *fault)
{
    if (!json_is_object(report->root))
        return fault_set(fault, FAULT_TYPE, "not a report: expected an object");
    read_history(report);
    read_prediction(report);
    read_effects(report);
    read_lists(report);
    read_regions(report);
    return read_lengths(report, fault);
}

fault_code_t report_read(report_t **out, const char *text, size_t size, const char *name, fault_t *fault)
{
    *out = NULL;
    if (size > REPORT_MAX_BYTES)
        return fault_set(fault, FAULT_LIMIT, "%s: %zu octets, a report has at most %d", name, size,
                         REPORT_MAX_BYTES);
    report_t *report = calloc(1, sizeof *report);
    if (!report)
        return fault_set(fault, FAULT_MEMORY, "%s: no memory for a report", name);
    fault_code_t code = json_parse(&report->root, text, size, fault);
    if (code == FAULT_NONE)
        code = read_whole(report, fault);
    if (code == FAULT_NONE)
        *out = report;
    else
        report_destroy(&report);
    return fault_prefix(fault, code, "%s", name);
}

void report_destroy(report_t **report)
{
    if (!*report)
        return;
    json_destroy(&(*report)->root);
    free((*report)->lengths);
    free(*report);
    *report = NULL;
}

const json_t *report_member(const report_t *report, const char *name)
{
    return member_of(report->root, name);
}

double report_number(const report_t *report, const char *object, const char *name)
{
    return report_number_of(object[0] ? report_member(report, object) : report->root, name);
}

const char *report_text(const report_t *report, const char *object, const char *name)
{
    return report_text_of(object[0] ? report_member(report, object) : report->root, name);
}
