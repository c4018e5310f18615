/* gain_data.h: what bench_gain measured on one scene, as a file: figures of every run, so that tables and plots can
 * be made anew without rendering. */
#ifndef TESTS_BENCH_GAIN_DATA_H
#define TESTS_BENCH_GAIN_DATA_H

#include <stddef.h>

#include "base/json.h"
#include "gain_list.h"
#include "client/bench/seeds.h"
#include "client/bench/spread.h"

enum { GAIN_POINTS = 16, GAIN_LENGTHS = 128, GAIN_MOVES = 16, GAIN_TEXT = 256 };

/* A run as it stood at one of the times. */
typedef struct gain_point {
    double cpu_seconds, mutations;
    double relmse, trimmed; /* against the two halves of the reference: may be negative near its noise; NaN: path
                               lengths are still missing */
    double brightness;      /* over the reference's */
} gain_point_t;

typedef struct gain_run {
    uint64_t seed;
    double estimate;          /* of relMSE, the render's own */
    double us_per_mutation;   /* of chains or samples alone, microseconds of CPU time */
    double rays_per_mutation; /* pilot included */
    gain_point_t points[GAIN_POINTS];
} gain_run_t;

typedef struct gain_move {
    char name[GAIN_NAME];
    double proposed, acceptance; /* acceptance: mean over proposals */
} gain_move_t;

/* One path length, over all runs. */
typedef struct gain_length {
    double mutations, cpu_seconds, zero; /* zero: proposals without contribution */
    double longest_stay;
    gain_move_t moves[GAIN_MOVES];
    size_t move_count;
} gain_length_t;

typedef seeds_figure_t gain_figure_t;

typedef struct gain_entry {
    gain_variant_t variant;
    char refused[GAIN_TEXT]; /* why nothing was measured; empty: it was */
    gain_run_t *runs;
    size_t run_count;
    gain_figure_t deviation, deviation_99; /* of a pixel's luminance over the seeds, over the mean luminance: mean
                                              over the pixels, 99th percentile */
    double systematic; /* relMSE that no number of seeds would average out; near its noise it may be negative */
    double nonfinite;  /* pixels, over all runs */
    gain_length_t lengths[GAIN_LENGTHS]; /* [1] .. [length_count]; [0]: chains of all lengths at once */
    size_t length_count;
    json_t *report; /* the first seed's */
} gain_entry_t;

typedef struct gain_scene {
    char name[GAIN_NAME];
    gain_size_t size;
    uint32_t max_path_length;
    double times[GAIN_POINTS]; /* CPU seconds at which runs were looked at */
    size_t point_count;
    double calibration; /* million rays per CPU second: calibrate.h */
    char recipe[GAIN_TEXT];
    double reference_seconds[2], reference_noise, reference_difference; /* gain_reference.h */
    gain_entry_t *entries;
    size_t entry_count;
} gain_scene_t;

json_t *gain_scene_json(const gain_scene_t *scene);
/* Reads what gain_scene_json wrote; the caller clears. Faults name the file. */
fault_code_t gain_scene_read(gain_scene_t *scene, const char *path, fault_t *fault);
void gain_scene_clear(gain_scene_t *scene);

/* The entry of that name, if it was measured; else null. */
const gain_entry_t *gain_scene_find(const gain_scene_t *scene, const char *name);
/* What a run says at one of the times. */
typedef enum gain_quantity {
    GAIN_CPU = 0,
    GAIN_RELMSE,
    GAIN_TRIMMED,
    GAIN_BRIGHTNESS,
    GAIN_MUTATIONS,
    GAIN_RELMSE_CPU, /* products: what equal time leaves of runs that did not end at the same instant */
    GAIN_TRIMMED_CPU,
    GAIN_RELMSE_MUTATIONS,
    GAIN_TRIMMED_MUTATIONS,
    GAIN_COST, /* microseconds a mutation, of the whole run */
    GAIN_RAYS  /* a mutation, of the whole run */
} gain_quantity_t;

/* Of each run, into values[run_count]. */
void gain_entry_values(const gain_entry_t *entry, size_t point, gain_quantity_t quantity, double *values);
/* All NaN if a run's value is. */
spread_t gain_entry_spread(const gain_entry_t *entry, size_t point, gain_quantity_t quantity);
/* All lengths together; a move's acceptance is that over all its proposals. */
gain_length_t gain_entry_total(const gain_entry_t *entry);
/* Null if it was never proposed. */
const gain_move_t *gain_length_move(const gain_length_t *length, const char *name);
/* Adds proposals to the move of that name; nothing if there is no room for another. */
void gain_length_add(gain_length_t *length, const char *name, double proposed, double acceptance);

#endif
