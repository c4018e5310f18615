/* plan_strata.h: how much the errors of neighbouring pixels hang together (plan_strata.c says how). */
#ifndef PLAN_PLAN_STRATA_H
#define PLAN_PLAN_STRATA_H

#include "plan/plan_state.h"

/* Makes plan->strata; the plan frees it. */
fault_code_t plan_strata_init(plan_t *plan, fault_t *fault);
/* Adds the squares of a unit of lengths[k], of its sums over blocks and of its pixels; c, size as for
 * plan->squares. */
void plan_absorb_strata(plan_t *plan, uint32_t k, const film_t *film, double c, double size);
/* Variance of the blocks' sums over the sum of their pixels' variances; NaN while a length has too few units. */
double plan_estimate_strata(const plan_t *plan);

/* As bytes, where there are strata (packed.h). Hostile bytes back. */
void plan_strata_put(wire_writer_t *out, const plan_t *plan);
fault_code_t plan_strata_get(wire_reader_t *in, plan_t *plan);

#endif
