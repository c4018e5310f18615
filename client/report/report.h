/* report.h: a report (docs/reports.md) as numbers and texts, for what shows it: page.h, csv.h.
 *
 * Any field may be missing, null or of the wrong type: such a number is NaN, such a text null, such a list empty. A
 * report comes from a file that anyone may have written: entries beyond the limits below are left out, numbers are
 * finite or NaN.
 *
 *     report_t *report;
 *     TRY(report_read(&report, text, size, "room.json", fault));
 *     ... report->lengths[i].b ...
 *     report_destroy(&report);
 */
#ifndef CLIENT_REPORT_REPORT_H
#define CLIENT_REPORT_REPORT_H

#include <stdint.h>

#include "base/json.h"

enum {
    REPORT_MAX_BYTES = 16 << 20,
    REPORT_MAX_HISTORY = 1024,
    REPORT_MAX_TARGETS = 16,
    REPORT_MAX_LENGTHS = 128,
    REPORT_MAX_MOVES = 16,       /* of a length */
    REPORT_MAX_TECHNIQUES = 128, /* of a length */
    REPORT_MAX_GROUPS = 256,
    REPORT_MAX_REGIONS = 1024,
    REPORT_MAX_EFFECTS = 64,
    REPORT_MAX_STUCK = 32,
    REPORT_MAX_TEXT = 600 /* octets of a text that are shown */
};

/* How good the image was at a time. */
typedef struct report_point {
    double seconds, cpu_seconds, mutations, relmse, error;
} report_point_t;

/* When an error will be, or was, reached: wall time with an interval. */
typedef struct report_target {
    double error, seconds, low, high, worker_hours;
} report_target_t;

typedef struct report_move {
    const char *name;
    double proposed, acceptance;
} report_move_t;

typedef struct report_technique {
    double s, value, standard_error;
} report_technique_t;

/* What was done for the paths of one length; for those of all lengths at once `length` is 0. light, cap: where
 * samples bring a part of it; most: that b may be. */
typedef struct report_length {
    double length, b, b_error, most, light, cap, relmse, share, mutations, chains, cpu_seconds, zero_contribution,
        longest_stay;
    double inefficiency, rays, steps, large_step;     /* by trials before the render */
    double bias_failures, bias_variation, bias_block; /* of failures that are left out */
    report_move_t moves[REPORT_MAX_MOVES];
    uint32_t move_count;
    report_technique_t techniques[REPORT_MAX_TECHNIQUES];
    uint32_t technique_count;
} report_length_t;

typedef struct report_effect {
    const char *name, *state, *reason, *consequence;
    double energy, energy_error;
} report_effect_t;

/* Mean brightness of a part of the image, and between what it lies. */
typedef struct report_region {
    double luminance, low, high;
} report_region_t;

typedef struct report {
    json_t *root; /* texts below are borrowed from it */
    report_point_t history[REPORT_MAX_HISTORY];
    uint32_t history_count;
    double law_a, law_c, law_p; /* error = a + c t^-p, t worker seconds; NaN: none */
    report_target_t targets[REPORT_MAX_TARGETS];
    uint32_t target_count;
    report_length_t *lengths; /* in the report's order */
    uint32_t length_count;
    report_length_t all; /* chains of all lengths at once; b and techniques are in `lengths` */
    double groups[REPORT_MAX_GROUPS];
    double deviations[REPORT_MAX_GROUPS]; /* of the same groups; NaN: not told */
    uint32_t group_count;
    report_region_t regions[REPORT_MAX_REGIONS]; /* row by row from the top left */
    uint32_t region_columns, region_rows;        /* 0: none */
    report_effect_t effects[REPORT_MAX_EFFECTS];
    uint32_t effect_count;
    const char *stuck[REPORT_MAX_STUCK];
    uint32_t stuck_count;
} report_t;

/* Faults: text that is no JSON object, is too large. `name` begins messages. */
fault_code_t report_read(report_t **out, const char *text, size_t size, const char *name, fault_t *fault);
void report_destroy(report_t **report);

/* A member of an object at the root ("" for the root itself): report_number(report, "time", "wall_seconds"). */
double report_number(const report_t *report, const char *object, const char *name);
const char *report_text(const report_t *report, const char *object, const char *name); /* borrowed, or null */
const json_t *report_member(const report_t *report, const char *name);                 /* or null */

/* Of any JSON value, which may be null. */
double report_number_of(const json_t *object, const char *name);
const char *report_text_of(const json_t *object, const char *name);

#endif
