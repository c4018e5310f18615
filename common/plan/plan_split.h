/* plan_split.h: what samples bring and what is left to chains: the caps, from units of the pilot, and shares
 * (plan_split.c says how). */
#ifndef PLAN_PLAN_SPLIT_H
#define PLAN_PLAN_SPLIT_H

#include "plan/plan_state.h"

/* Whether the pilot has units for the caps: with split. */
bool plan_wants_split(const plan_t *plan);
void plan_split_record(const plan_t *plan, uint64_t index, work_record_t *record);
bool plan_is_split(const work_record_t *record);
/* Takes in a unit of them; the last one fixes the caps. */
void plan_absorb_split(plan_t *plan, const work_record_t *record, const work_result_t *result);
/* After the pilot: lengths without chains. Then the shares of samples and lengths. */
void plan_split_settle(plan_t *plan);
void plan_split_shares(plan_t *plan);
/* Gives the record a copy of the caps and rates that it needs, if there are any. */
fault_code_t plan_set_caps(const plan_t *plan, work_record_t *record, fault_t *fault);

/* As bytes: u64 rays of each length, u8 whether there are caps, then u8 whether samples are alone, f64 promise,
 * samples and f64 of each length: caps, rates. Hostile bytes back: faults are the reader's. */
void plan_split_put(wire_writer_t *out, const plan_t *plan);
void plan_split_get(wire_reader_t *in, plan_t *plan);

#endif
