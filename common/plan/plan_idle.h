/* plan_idle.h: techniques of negligible energy leave the state space and the weights (plan_idle.c says when). A
 * survey of two rounds comes before the candidates; what it settles is part of every later unit's record. */
#ifndef PLAN_PLAN_IDLE_H
#define PLAN_PLAN_IDLE_H

#include "plan/plan_state.h"

/* How many of the pilot's units look for them, in either round; 0 if none may leave. */
uint64_t plan_survey_size(const plan_t *plan);
fault_code_t plan_survey_record(const plan_t *plan, int round, uint64_t index, work_record_t *record);
bool plan_is_survey(const work_record_t *record);
void plan_absorb_survey(plan_t *plan, int round, const work_record_t *record, const work_result_t *result);
/* Whether a round is over; true if there is none. */
bool plan_survey_has(const plan_t *plan, int round);
/* Octets of plan->survey. */
size_t plan_survey_bytes(const plan_t *plan);
/* How many values unit `index` of a round brought: 0 before it is in. */
double plan_survey_in(const plan_t *plan, int round, uint64_t index);
/* Gives the record a copy of the idle techniques, if there are any. */
fault_code_t plan_set_idle(const plan_t *plan, work_record_t *record, fault_t *fault);

/* Adds `idle` and `idle_energy` to the report of a length. */
void plan_report_idle(const plan_t *plan, uint32_t k, json_t *length);
/* In words: "11 of 42 have less than 0.5 % of their length's energy"; false if all take part. */
bool plan_say_idle(const plan_t *plan, char *text, size_t size);

/* As bytes: the survey's estimators, packed. Hostile bytes back: what they settle follows from them. */
void plan_survey_put(wire_writer_t *out, const plan_t *plan);
fault_code_t plan_survey_get(wire_reader_t *in, plan_t *plan);

#endif
