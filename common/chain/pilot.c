/* pilot.c: independent candidates of one path length: estimates of b_k and of the techniques' shares, and seeds. */
#include "chain/unit.h"

uint32_t unit_candidate(const work_space_t *space, const target_t *target, uint64_t index, double *camera,
                        double *light)
{
    const uint64_t key = random_key(space->renderer->settings.seed, RANDOM_PURPOSE_PILOT, target->length, index);
    kernel_draw(key, UNIT_DRAW_CAMERA, camera, target->camera_count);
    kernel_draw(key, UNIT_DRAW_LIGHT, light, target->light_count);
    return target->list[(uint32_t)(random_double(key, UNIT_DRAW_TECHNIQUE) * target->count)];
}

fault_code_t unit_pilot(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                        work_result_t *result, fault_t *fault)
{
    const target_t *target = &space->renderer->targets[record->length];
    for (uint64_t i = 0; i < record->count; i++) {
        if ((i & 255) == 0 && atomic_load_explicit(cancel, memory_order_relaxed))
            return fault_set(fault, FAULT_CANCELLED, "cancelled");
        space->weights[i] = 0;
        if (target->count == 0)
            continue;
        const uint32_t s = unit_candidate(space, target, record->first + i, space->camera, space->light);
        target_value_t value;
        target_eval(target, &space->path, s, space->camera, space->light, &value);
        const double weight = value.c * target->count;
        space->weights[i] = weight;
        unit_moment(&space->moments[0], weight);
        unit_moment(&space->moments[1 + s], weight);
    }
    result->moment_count = record->length + 2;
    for (uint32_t i = 0; i < result->moment_count; i++)
        space->moments[i].n = (double)record->count;
    result->weights = space->weights;
    result->weight_count = (uint32_t)record->count;
    result->stats.evaluations = record->count;
    return FAULT_NONE;
}
