/* plan_missed.h: upper bounds for the lengths' light, and what chains cannot bring (plan_missed.c says how). */
#ifndef PLAN_PLAN_MISSED_H
#define PLAN_PLAN_MISSED_H

#include "plan/plan_state.h"

/* Fills lengths[].most and `measurable` from the candidates' weights, while they are not yet running sums. */
void plan_bound_lengths(plan_t *plan);
/* The least share of a length that carries light: `least`, and beyond the last measurable one no more than its
 * bound's share of the light. */
double plan_least_share(const plan_t *plan, uint32_t k, double least);
/* Lengths without chains, and the most that they bring, over b. */
json_t *plan_missed_json(const plan_t *plan);

#endif
