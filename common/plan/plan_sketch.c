/* plan_sketch.c: the importance of light by where it is seen, from a first sketch of the image
 * (chain/importance.h).
 *
 * What is to be small is the mean of Var(I_j) / (I_j^2 + 0.01 m^2), and a pixel's variance is about I_j^2 over the
 * mutations that it gets, N_j. For their sum being fixed the least is where N_j is in proportion to I_j /
 * sqrt(I_j^2 + 0.01 m^2): chains that follow C g with g = m / sqrt(I^2 + 0.01 m^2), to the power `equalize`. I is
 * the light of 16 x 16 blocks of the image, from samples before the pilot's, an eighth as many or more; g is scaled
 * so that the blocks' light times g is what it was.
 */
#include "plan/plan_sketch.h"

#include <stdlib.h>
#include <string.h>

#include "plan/plan_split.h"

/* Indices of samples that are no candidates. */
#define SKETCH_FIRST (UINT64_C(1) << 40)

bool plan_wants_sketch(const plan_t *plan)
{
    return plan->settings.equalize > 0 && plan_is_chains(plan);
}

void plan_sketch_record(const plan_t *plan, uint64_t index, work_record_t *record)
{
    record->kind = WORK_PILOT;
    record->first = SKETCH_FIRST + index * plan->pilot_unit;
    record->count = plan->pilot_unit;
}

bool plan_is_sketch(const work_record_t *record)
{
    return record->kind == WORK_PILOT && record->first >= SKETCH_FIRST && !plan_is_split(record);
}

static void sketch_finish(plan_t *plan)
{
    const size_t numbers = (size_t)plan->settings.max_path_length * WORK_BLOCKS;
    double image[WORK_BLOCKS] = {0}, mean = 0, light = 0, weighted = 0;
    for (size_t i = 0; i < plan->sketch_units * numbers; i++) /* in their order, whichever came first */
        image[i % WORK_BLOCKS] += plan->pilot_blocks[i];
    memset(plan->pilot_blocks, 0, sizeof *plan->pilot_blocks * plan->sketch_units * numbers);
    for (int i = 0; i < WORK_BLOCKS; i++)
        mean += image[i] / WORK_BLOCKS;
    for (int i = 0; i < WORK_BLOCKS; i++) {
        const double relative = mean > 0 ? image[i] / mean : 1;
        plan->importance[i] = pow(relative * relative + 0.01, -0.5 * plan->settings.equalize);
        light += relative;
        weighted += relative * plan->importance[i];
    }
    for (int i = 0; i < WORK_BLOCKS; i++) { /* within what records may hold, by far */
        const double scaled = plan->importance[i] * light / weighted;
        plan->importance[i] = fmin(fmax(scaled, 1e-3), 1e3);
    }
    plan->has_importance = true;
}

void plan_absorb_sketch(plan_t *plan, const work_record_t *record, const work_result_t *result)
{
    const size_t numbers = (size_t)plan->settings.max_path_length * WORK_BLOCKS;
    const uint64_t unit = (record->first - SKETCH_FIRST) / plan->pilot_unit;
    memcpy(plan->pilot_blocks + unit * numbers, result->weights + record->count * plan->settings.max_path_length,
           sizeof(double) * numbers);
    plan->sketch_in++;
    if (plan->sketch_in == plan->sketch_units)
        sketch_finish(plan);
}

fault_code_t plan_set_importance(const plan_t *plan, work_record_t *record, fault_t *fault)
{
    if (!plan->has_importance)
        return FAULT_NONE;
    record->importance = malloc(sizeof plan->importance);
    if (!record->importance)
        return fault_set(fault, FAULT_MEMORY, "no memory for a unit's importance");
    memcpy(record->importance, plan->importance, sizeof plan->importance);
    return FAULT_NONE;
}

void plan_sketch_put(wire_writer_t *out, const plan_t *plan)
{
    wire_put_u8(out, plan->has_importance);
    for (int i = 0; plan->has_importance && i < IMPORTANCE_BLOCKS; i++)
        wire_put_f64(out, plan->importance[i]);
}

void plan_sketch_get(wire_reader_t *in, plan_t *plan)
{
    const uint8_t has_importance = wire_get_u8(in, "importance");
    if (!in->code && (has_importance > 1 || (has_importance && plan->sketch_units == 0)))
        wire_reader_fail(in, FAULT_FORMAT, "importance", "%u, of a job %s sketch", has_importance,
                         plan->sketch_units ? "with a" : "without");
    plan->has_importance = !in->code && has_importance;
    for (int i = 0; plan->has_importance && i < IMPORTANCE_BLOCKS && !in->code; i++) {
        plan->importance[i] = wire_get_f64(in, "importance");
        if (!in->code && !(plan->importance[i] >= 1e-3 && plan->importance[i] <= 1e3))
            wire_reader_fail(in, FAULT_RANGE, "importance", "%g, expected 0.001 to 1000", plan->importance[i]);
    }
}
