/* plan_accuracy.h: what the history says about the time that accuracy takes, for reports and progress. */
#ifndef PLAN_PLAN_ACCURACY_H
#define PLAN_PLAN_ACCURACY_H

#include "base/json.h"
#include "plan/plan_state.h"

/* Estimates the error now and notes it in the history. */
void plan_note_error(plan_t *plan);
/* What the history says of when the rule's error is met; after it has changed. */
void plan_predict(plan_t *plan);
void plan_report_accuracy(const plan_t *plan, json_t *report);

#endif
