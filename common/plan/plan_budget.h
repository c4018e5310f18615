/* plan_budget.h: units of work from the job: the pilot's, then the lengths' shares and units of the rendering. */
#ifndef PLAN_PLAN_BUDGET_H
#define PLAN_PLAN_BUDGET_H

#include "plan/plan_state.h"

/* Where the pilot gives no seeds but only the image's scale. */
enum { PLAN_SCALE_CANDIDATES = 4096 };

/* Units of the first phase, in their order. Two of the stages wait for what earlier ones find. Features wait for
 * nothing and are in three parts, so that workers have something to do while the last units before come in. */
typedef enum plan_stage {
    PLAN_STAGE_SKETCH,
    PLAN_STAGE_SURVEY, /* its first round */
    PLAN_STAGE_FEATURES,
    PLAN_STAGE_LEFT_OUT,
    PLAN_STAGE_SURVEY_AGAIN, /* waits for the first round */
    PLAN_STAGE_FEATURES_AGAIN,
    PLAN_STAGE_SPLIT, /* waits for sketch and survey */
    PLAN_STAGE_FEATURES_LAST,
    PLAN_STAGE_CANDIDATES, /* wait for the caps, too */
    PLAN_STAGES
} plan_stage_t;

/* Whether the work is enough for so many whole passes of samples over the image. Where only time or the error ends
 * the job it always is: a first pass need not be whole (plan_passes.h). */
bool plan_has_room(const plan_t *plan, uint32_t passes);
/* Sizes of the first phase from the job; called once. */
void plan_size_pilot(plan_t *plan);
/* The number of a stage's first unit; of none: of the next stage's. */
uint64_t plan_stage_begin(const plan_t *plan, plan_stage_t stage);
/* Unit number `index` of the first phase. */
fault_code_t plan_pilot_record(const plan_t *plan, uint64_t index, work_record_t *record);
/* Whether the next of them waits for those before it to come in. */
bool plan_pilot_waits(const plan_t *plan);
/* With the candidates in: b and what goes with it. FAULT_NO_LIGHT if nothing was found. */
fault_code_t plan_find_light(plan_t *plan, fault_t *fault);
/* After pilot and trials: shares, unit sizes. */
void plan_size_render(plan_t *plan);
/* After the pilot's sums are in: shares of the techniques. */
void plan_freeze_techniques(plan_t *plan);
/* The next unit of the rendering phase, of the current era; false if its budgets are spent or memory is. */
bool plan_render_record(plan_t *plan, plan_unit_t *unit);
/* Whether as much is rendered as makes the b_k be refined next. */
bool plan_refine_is_due(const plan_t *plan);

/* Mutations that a chain makes. */
uint64_t plan_chain_length(const plan_t *plan);
/* Sets the shares by what is known of inefficiencies and costs. */
void plan_shares(plan_t *plan);
/* Rays of a mutation of length k, about. */
double plan_usual_cost(uint32_t k);
/* A unit of chains of length k; false if memory is out. */
bool plan_chains_record(const plan_t *plan, work_kind_t kind, uint32_t k, uint64_t first, uint64_t chains,
                        uint64_t mutations, plan_steps_t steps, work_record_t *record);

#endif
