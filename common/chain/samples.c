/* samples.c: the image by independent samples: bidirectional path tracing, and path tracing as its special case of
 * the techniques s <= 1. Sample i belongs to pixel i mod (width height): every pass over the image is stratified.
 * A unit is of samples in a row, or of every n-th (skip): a part of a pass over a large image. With rates each is
 * made up to a length of its own (cutoff.h). Those of a pixel are points of nets (net.h).
 */
#include "chain/cutoff.h"
#include "chain/sampler.h"

fault_code_t unit_samples(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                          work_result_t *result, fault_t *fault)
{
    const renderer_t *renderer = space->renderer;
    const settings_t *settings = &renderer->settings;
    const uint64_t pixels = (uint64_t)settings->width * settings->height;
    double totals[PATH_MAX_VERTICES], weights[PATH_MAX_VERTICES];
    net_t net;
    TRY(unit_film(space, fault));
    sampler_t sampler = {.space = space,
                         .renderer = renderer,
                         .film = &space->film,
                         .scale = record->scale,
                         .totals = totals,
                         .moments = space->moments,
                         .importance = unit_importance(space, record),
                         .caps = record->caps,
                         .longest = settings->max_path_length,
                         .weights = record->rates ? weights : NULL,
                         .net = &net,
                         .of_image = true};
    for (uint32_t k = 0; k < record->rate_count; k++)
        weights[k] = 1 / record->rates[k];
    for (uint64_t i = 0; i < record->count; i++) {
        if ((i & 63) == 0 && atomic_load_explicit(cancel, memory_order_relaxed))
            return fault_set(fault, FAULT_CANCELLED, "cancelled");
        const uint64_t index = record->first + i * (record->skip + 1);
        const uint64_t key = random_key(settings->seed, RANDOM_PURPOSE_SAMPLES, 0, index);
        net = net_at(settings->seed, record->sequence, index % pixels,
                     record->point + (index / pixels - record->first / pixels));
        if (record->rates) {
            double place = random_double(key, UNIT_DRAW_CUTOFF);
            net_place_one(&net, UNIT_DRAW_CUTOFF, &place);
            sampler.longest = cutoff_length(record->rates, record->rate_count, place);
        }
        sampler_run(&sampler, key, (int64_t)(index % pixels));
    }
    result->moment_count = work_samples_moment(settings->max_path_length + 1);
    for (uint32_t i = 0; i < result->moment_count; i++)
        space->moments[i].n = (double)record->count;
    result->stats.evaluations = record->count;
    result->has_film = true;
    return FAULT_NONE;
}
