/* plan_trial.h: chains tried out before the render (plan_trial.c says how). */
#ifndef PLAN_PLAN_TRIAL_H
#define PLAN_PLAN_TRIAL_H

#include "plan/plan_state.h"

/* How many there are once the candidates are in, and room for what they tell: none where they would not pay. */
fault_code_t plan_prepare_trials(plan_t *plan, fault_t *fault);
/* Unit number `index` of them. */
bool plan_trial_record(const plan_t *plan, uint64_t index, work_record_t *record);
void plan_absorb_trial(plan_t *plan, uint64_t index, const work_record_t *record, const work_result_t *result);
/* With all of them in: steps, inefficiencies and costs of the lengths. */
void plan_finish_trials(plan_t *plan);

/* As bytes: u64 units, then of each f64 spread and rays. Hostile bytes back, of a plan that knows how many there
 * are: faults are the reader's. */
void plan_trial_put(wire_writer_t *out, const plan_t *plan);
void plan_trial_get(wire_reader_t *in, plan_t *plan);

#endif
