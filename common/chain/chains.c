/* chains.c: a unit of Markov chains of one path length. An algorithm is a set of moves with probabilities:
 *
 *              large  technique  jump     exchange  inverse  small, partial
 * mmlt         yes    yes                                    yes
 * rjmlt        yes               T = w                       yes
 * cmlt         yes               T fixed                     yes
 * cmlt-rex     yes*                       yes                yes
 * cmlt-ipsm    yes                                  yes
 * pssmlt-mix   yes*                                          yes            * the technique is kept
 *
 * Any but the last three may have an auxiliary chain beside each chain. Chains of all lengths at once: bundle.h.
 */

#include <math.h>

#include "chain/auxiliary.h"
#include "chain/exchange.h"
#include "chain/inverse_step.h"
#include "chain/jump.h"
#include "chain/perturb.h"

/* Chains that run together: those of an exchange, or one. Each step goes to all in turn. */
typedef struct ensemble {
    chain_t chains[WORK_REPLICAS];
    uint64_t mutations[WORK_REPLICAS];
    uint32_t count;
    chain_t auxiliary;
    bool has_auxiliary;
    target_t target;   /* with the record's importance */
    double large_step; /* probability */
} ensemble_t;

static void chain_step(chain_t *chain, ensemble_t *with, uint64_t step)
{
    const settings_t *settings = &chain->space->renderer->settings;
    const uint64_t key = random_step(chain->key, step);
    double choice = random_double(key, UNIT_DRAW_MOVE);
    if (choice < with->large_step) {
        perturb_large(chain, key);
        return;
    }
    choice -= with->large_step;
    if (with->has_auxiliary) {
        if (choice < settings->auxiliary_step) {
            auxiliary_step(chain, &with->auxiliary, key);
            return;
        }
        choice -= settings->auxiliary_step;
    }
    double technique = 0;
    switch (settings->algorithm) {
    case SETTINGS_RJMLT:
    case SETTINGS_CMLT:
        if (choice < settings->jump_step) {
            (settings->algorithm == SETTINGS_CMLT ? jump_chart : jump_reversible)(chain, key);
            return;
        }
        choice -= settings->jump_step;
        break;
    case SETTINGS_CMLT_REX:
        if (choice < settings->jump_step) {
            exchange_step(chain, with->chains, with->count, key);
            return;
        }
        choice -= settings->jump_step;
        break;
    case SETTINGS_CMLT_IPSM:
        inverse_step(chain, key);
        return;
    case SETTINGS_MMLT:
        technique = (1 - with->large_step) * settings->technique_step;
        break;
    default:
        break;
    }
    perturb_small(chain, key, choice < technique, choice - technique < settings->partial_step);
}

static void ensemble_open(ensemble_t *ensemble, work_space_t *space, const work_record_t *record,
                          work_result_t *result)
{
    const renderer_t *renderer = space->renderer;
    ensemble->target = space->targets[record->length];
    ensemble->target.importance = unit_importance(space, record);
    ensemble->target.cap = unit_cap(record);
    ensemble->large_step = ldexp(renderer->settings.large_step, record->large);
    ensemble->has_auxiliary = false;
    for (uint32_t i = 0; i < space->room_count; i++) {
        chain_t *chain = i < WORK_REPLICAS ? &ensemble->chains[i] : &ensemble->auxiliary;
        if (renderer->settings.auxiliary_step > 0 && i + 1 == space->room_count)
            chain = &ensemble->auxiliary;
        chain_room_t *room = &space->rooms[i];
        *chain = (chain_t){.space = space,
                           .target = &ensemble->target,
                           .stats = &result->stats,
                           .stuck = &result->stuck,
                           .shares = record->shares,
                           .camera = room->camera,
                           .light = room->light,
                           .kept = room->kept};
    }
}

static fault_code_t ensemble_run(ensemble_t *ensemble, const work_record_t *record, uint64_t first, uint32_t count,
                                 const atomic_bool *cancel, fault_t *fault)
{
    const settings_t *settings = &ensemble->chains[0].space->renderer->settings;
    uint64_t most = 0;
    ensemble->count = count;
    for (uint32_t c = 0; c < count; c++) {
        chain_t *chain = &ensemble->chains[c];
        const uint64_t i = first + c, begin = i * record->mutations / record->count,
                       end = (i + 1) * record->mutations / record->count;
        chain->id = record->first + i;
        chain->key = random_key(settings->seed, RANDOM_PURPOSE_CHAIN, record->length, chain->id);
        TRY(chain_start(chain, record->seeds[i], fault));
        ensemble->mutations[c] = end - begin;
        most = end - begin > most ? end - begin : most;
    }
    if (settings->auxiliary_step > 0)
        ensemble->has_auxiliary =
            auxiliary_start(&ensemble->auxiliary, random_step(ensemble->chains[0].key, UINT64_MAX / 2));
    for (uint64_t step = 0; step < most; step++) {
        if ((step & 1023) == 0 && atomic_load_explicit(cancel, memory_order_relaxed))
            return fault_set(fault, FAULT_CANCELLED, "cancelled");
        for (uint32_t c = 0; c < count; c++)
            if (step < ensemble->mutations[c])
                chain_step(&ensemble->chains[c], ensemble, step);
    }
    for (uint32_t c = 0; c < count; c++)
        chain_finish(&ensemble->chains[c], random_step(ensemble->chains[c].key, ensemble->mutations[c]));
    return FAULT_NONE;
}

fault_code_t unit_run_chains(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                             unit_done_t done, void *context, work_result_t *result, fault_t *fault)
{
    const settings_t *settings = &space->renderer->settings;
    const uint32_t together = work_together(settings->algorithm);
    ensemble_t ensemble;
    TRY(unit_film(space, fault));
    ensemble_open(&ensemble, space, record, result);
    for (uint64_t i = 0; i < record->count; i += together) {
        const uint64_t left = record->count - i;
        TRY(ensemble_run(&ensemble, record, i, left < together ? (uint32_t)left : together, cancel, fault));
        if (done)
            done(context);
    }
    result->moment_count = record->length + 2;
    for (uint32_t i = 0; i < result->moment_count; i++)
        space->moments[i].n =
            settings_keeps_technique(settings->algorithm) ? 0 : (double)result->stats.proposed[WORK_MOVE_LARGE];
    result->stats.evaluations = record->mutations;
    if (settings->failures == SETTINGS_FAILURES_PUBLISHED)
        result->failed = space->failed;
    return FAULT_NONE;
}

fault_code_t unit_chains(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                         work_result_t *result, fault_t *fault)
{
    if (settings_joins_all(space->renderer->settings.algorithm))
        return unit_bundle(space, record, cancel, result, fault);
    TRY(unit_run_chains(space, record, cancel, NULL, NULL, result, fault));
    result->has_film = true;
    return FAULT_NONE;
}
