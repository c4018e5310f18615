/* plan.h: the course of a job, without sockets, clocks or threads of its own: which units to do next, what their
 * results add up to, when it is enough.
 *
 *     plan_new -> { plan_next ... plan_absorb ... plan_check_stop } until plan_finished -> plan_output
 *
 * Phases: pilot and features (a fixed list of units), then, once every pilot unit is in, rendering. The list of
 * units is a function of job and scene alone, in a fixed order; results may come in any order, each is absorbed
 * exactly once, and the sums are exact: the same set of units gives the same bits. With a rule
 * "mutations_per_pixel" the set is fixed; time and error rules end the list early.
 *
 * Units have consecutive ids from 0. One thread at a time.
 */
#ifndef PLAN_PLAN_H
#define PLAN_PLAN_H

#include "base/json.h"
#include "chain/work.h"
#include "film/image.h"
#include "plan/job.h"
#include "scene/scene.h"

typedef struct plan plan_t;

typedef enum plan_phase { PLAN_PILOT = 0, PLAN_RENDER = 1, PLAN_DONE = 2 } plan_phase_t;

/* `scene` is borrowed for the plan's life. Faults: what the job asks that the scene cannot do. */
fault_code_t plan_new(plan_t **out, const job_t *job, const scene_t *scene, fault_t *fault);
void plan_destroy(plan_t **plan);

/* Hands out the next unit that was never handed out: its id and record (owned by the plan, valid until the next
 * call of plan_next or plan_absorb). False if there is none at present: all pilot units are out but not yet in, or
 * all is handed out or stopped. */
bool plan_next(plan_t *plan, uint64_t *unit, const work_record_t **record);
/* The record of a unit that is out and not yet in, valid as long; null otherwise. */
const work_record_t *plan_record(const plan_t *plan, uint64_t unit);

typedef enum plan_absorbed { PLAN_MERGED = 0, PLAN_DUPLICATE = 1, PLAN_UNKNOWN = 2 } plan_absorbed_t;
/* Decodes and merges a unit's result bytes, exactly once. Malformed bytes are a fault and change nothing: the unit
 * is still out. The end of the pilot may fault with FAULT_NO_LIGHT: then the job has failed. */
fault_code_t plan_absorb(plan_t *plan, uint64_t unit, const uint8_t *data, size_t size, plan_absorbed_t *how,
                         fault_t *fault);

/* Adds to the time that merging took (seconds of the master's processor), for the report. */
void plan_note_merging(plan_t *plan, double seconds);

/* Tells the plan how long the job has run (seconds of wall time, time before a restart included). Tests the stop
 * rules: once one is met nothing more is handed out; units still out may be absorbed or forgotten. True if just
 * stopped. */
bool plan_check_stop(plan_t *plan, double seconds);
/* Nothing is to be handed out any more and (stopped, or every unit is in). */
bool plan_finished(const plan_t *plan);

typedef struct plan_progress {
    plan_phase_t phase;
    double fraction;  /* of the nearest stop rule, 0..1 */
    double mutations; /* merged, or samples */
    double mutations_per_pixel;
    double error;                 /* sqrt(relMSE) so far; NaN while unknown */
    double seconds, seconds_left; /* left: NaN while unknown */
    uint64_t units_out, units_in;
    const char *stopped_by; /* null, or "mutations_per_pixel", "seconds", "error" */
} plan_progress_t;
void plan_progress(const plan_t *plan, plan_progress_t *progress);

/* The image so far with all layers (docs/images.md): R G B, stderr.R/G/B, samples, albedo, N, Z. Caller clears. */
fault_code_t plan_image(const plan_t *plan, image_t *image, fault_t *fault);
/* The report (docs/reports.md); the caller destroys. Timing by phase and counts of workers are the master's to add.
 */
json_t *plan_report(const plan_t *plan);

/* Everything absorbed so far as bytes, and back: a restarted master goes on from there. Units that were out are
 * handed out again under their old ids. Both sides of the bytes are checked. */
fault_code_t plan_save(const plan_t *plan, uint8_t **data, size_t *size, fault_t *fault);
fault_code_t plan_restore(plan_t **out, const job_t *job, const scene_t *scene, const uint8_t *data, size_t size,
                          fault_t *fault);

#endif
