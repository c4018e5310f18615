/* plan_seeds.h: where chains start. */
#ifndef PLAN_PLAN_SEEDS_H
#define PLAN_PLAN_SEEDS_H

#include "plan/plan_state.h"

/* Turns candidate weights into running sums. */
void plan_prepare_seeds(const plan_t *plan, plan_length_t *length);
/* The candidate that chain `chain` of length k starts from: systematic resampling of as many chains as ever come.
 */
uint64_t plan_seed(const plan_t *plan, uint32_t k, uint64_t chain);

#endif
