/* plan_left_out.h: the energy of what the job leaves out (plan_left_out.c says how). */
#ifndef PLAN_PLAN_LEFT_OUT_H
#define PLAN_PLAN_LEFT_OUT_H

#include "plan/plan_state.h"

/* How many of the pilot's units measure it. */
uint64_t plan_left_out_size(const plan_t *plan);
void plan_left_out_record(uint64_t index, work_record_t *record);
void plan_absorb_left_out(plan_t *plan, const work_record_t *record, const work_result_t *result);

/* Share of all light, what is left out included, that an effect (settings_effect_t, or WORK_LEFT_OUT_ALL) has, with
 * its standard error; NaN where it is not known. */
typedef struct plan_energy {
    double share, error;
} plan_energy_t;
plan_energy_t plan_left_out_energy(const plan_t *plan, uint32_t effect);
/* In words, for headers: "caustics 0.031 +- 0.002, ..."; empty if nothing is left out. */
void plan_left_out_say(const plan_t *plan, char *text, size_t size);

/* As bytes: all units' estimators, packed. Hostile bytes back: faults are the reader's. */
void plan_left_out_put(wire_writer_t *out, const plan_t *plan);
fault_code_t plan_left_out_get(wire_reader_t *in, plan_t *plan);

#endif
