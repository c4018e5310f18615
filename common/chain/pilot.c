/* pilot.c: candidates for the seeds of chains, and estimates of b_k and of the techniques' shares.
 *
 * A candidate is an independent bidirectional sample of all lengths. Its weight for length k is the sum of C_s over
 * the techniques s: the mean of the weights is b_k. A chain that starts from the candidate takes technique s with
 * probability C_s / sum, and the numbers of the sample's walks: its state is then distributed in proportion to C.
 */
#include <string.h>

#include "chain/sampler.h"

uint64_t unit_pilot_key(const renderer_t *renderer, uint64_t index)
{
    return random_key(renderer->settings.seed, RANDOM_PURPOSE_PILOT, 0, index);
}

bool unit_seed(work_space_t *space, const target_t *target, uint64_t candidate, double place, uint32_t *technique)
{
    double totals[PATH_MAX_VERTICES], by_technique[PATH_MAX_VERTICES] = {0}, caps[PATH_MAX_VERTICES];
    const uint64_t key = unit_pilot_key(space->renderer, candidate);
    sampler_t sampler = {.space = space,
                         .renderer = space->renderer,
                         .totals = totals,
                         .by_technique = by_technique,
                         .only = target->length,
                         .longest = target->length,
                         .importance = target->importance,
                         .caps = target->cap > 0 ? caps : NULL};
    caps[target->length - 1] = target->cap;
    sampler_run(&sampler, key, -1);
    double left = place * totals[target->length];
    uint32_t chosen = PATH_MAX_VERTICES;
    for (uint32_t s = 0; s <= target->length; s++) {
        if (!(by_technique[s] > 0))
            continue;
        chosen = s;
        if (left < by_technique[s])
            break;
        left -= by_technique[s];
    }
    if (chosen == 1) /* the point on the light was a number of its own */
        sampler_next_event(key, target->length, space->light);
    *technique = chosen;
    return chosen < PATH_MAX_VERTICES;
}

/* The pixel of a sample that is one of a pair; -1: anywhere. */
static int64_t pilot_pixel(const settings_t *settings, uint64_t index)
{
    if (index < WORK_PAIRS_FIRST)
        return -1;
    const uint64_t key = random_key(settings->seed, RANDOM_PURPOSE_PAIRS, 0, index / 2);
    return (int64_t)(random_double(key, 0) * ((double)settings->width * settings->height));
}

static fault_code_t pilot_run(work_space_t *space, const work_record_t *record, random_purpose_t purpose,
                              double *weights, const atomic_bool *cancel, work_result_t *result, fault_t *fault)
{
    const settings_t *settings = &space->renderer->settings;
    const uint32_t K = settings->max_path_length;
    double totals[PATH_MAX_VERTICES];
    sampler_t sampler = {.space = space,
                         .renderer = space->renderer,
                         .totals = totals,
                         .moments = space->moments,
                         .importance = unit_importance(space, record),
                         .caps = record->caps,
                         .longest = K,
                         .of_image = record->first >= WORK_PAIRS_FIRST,
                         .rays = weights ? weights + (record->count + WORK_BLOCKS) * K : NULL,
                         .blocks = weights ? weights + record->count * K : NULL};
    if (weights)
        memset(sampler.blocks, 0, sizeof(double) * K * (WORK_BLOCKS + 1));
    for (uint64_t i = 0; i < record->count; i++) {
        if ((i & 63) == 0 && atomic_load_explicit(cancel, memory_order_relaxed))
            return fault_set(fault, FAULT_CANCELLED, "cancelled");
        const uint64_t index = record->first + i;
        sampler_run(&sampler, random_key(settings->seed, purpose, 0, index), pilot_pixel(settings, index));
        for (uint32_t k = 1; weights && k <= K; k++)
            weights[i * K + k - 1] = totals[k];
    }
    result->moment_count = work_samples_moment(K + 1);
    for (uint32_t i = 0; i < result->moment_count; i++)
        space->moments[i].n = (double)record->count;
    result->stats.evaluations = record->count;
    return FAULT_NONE;
}

fault_code_t unit_pilot(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                        work_result_t *result, fault_t *fault)
{
    result->weights = space->weights;
    result->weight_count = (uint32_t)work_pilot_weights(record->count, space->renderer->settings.max_path_length);
    return pilot_run(space, record, RANDOM_PURPOSE_PILOT, space->weights, cancel, result, fault);
}

fault_code_t unit_refine(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                         work_result_t *result, fault_t *fault)
{
    return pilot_run(space, record, RANDOM_PURPOSE_REFINE, NULL, cancel, result, fault);
}
