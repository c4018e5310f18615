/* plan_stuck.h: stuck chains (chain/stuck.h) of all units together: sums, the longest stays, their share of the
 * image's light. Free of the order in which units come in. */
#ifndef PLAN_PLAN_STUCK_H
#define PLAN_PLAN_STUCK_H

#include "base/json.h"
#include "chain/work.h"

struct plan;

/* Takes in what a unit of chains found, whose film counts by a weight (plan_eras.h). */
void plan_stuck_absorb(struct plan *plan, const work_record_t *record, const work_result_t *result, double weight);

/* Of a restored plan, whose counts by length are known: they add up, and are of lengths that have chains. */
fault_code_t plan_stuck_check(const struct plan *plan, wire_reader_t *in);

/* The report's `stuck`: chains, weight, paths (docs/reports.md). */
json_t *plan_stuck_json(const struct plan *plan);

#endif
