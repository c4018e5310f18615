/* plan_sketch.h: the importance of the image's blocks from the first units of the pilot (plan_sketch.c says how).
 */
#ifndef PLAN_PLAN_SKETCH_H
#define PLAN_PLAN_SKETCH_H

#include "plan/plan_state.h"

/* Whether the pilot has units that make the sketch, first of all: with equalize. */
bool plan_wants_sketch(const plan_t *plan);
/* The sketch's unit number `index`. */
void plan_sketch_record(const plan_t *plan, uint64_t index, work_record_t *record);
bool plan_is_sketch(const work_record_t *record);
/* Takes in a unit of it; the last one fixes the importance. */
void plan_absorb_sketch(plan_t *plan, const work_record_t *record, const work_result_t *result);
/* Gives the record a copy of the importance, if there is one. */
fault_code_t plan_set_importance(const plan_t *plan, work_record_t *record, fault_t *fault);

/* As bytes: u8 whether there is an importance, f64 of every block. Hostile bytes back: faults are the reader's. */
void plan_sketch_put(wire_writer_t *out, const plan_t *plan);
void plan_sketch_get(wire_reader_t *in, plan_t *plan);

#endif
