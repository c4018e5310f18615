#include "plan/plan.h"

#include <stdlib.h>
#include <string.h>

#include "plan/effects.h"
#include "plan/plan_accuracy.h"
#include "plan/plan_budget.h"
#include "plan/plan_idle.h"
#include "plan/plan_left_out.h"
#include "plan/plan_missed.h"
#include "plan/plan_seeds.h"
#include "plan/plan_sketch.h"
#include "plan/plan_split.h"
#include "plan/plan_state.h"
#include "plan/plan_strata.h"
#include "plan/plan_stuck.h"
#include "plan/plan_trial.h"
#include "plan/techniques.h"

/* Refuses what the scene cannot give before any work is done. */
static fault_code_t plan_check_scene(const scene_t *scene, fault_t *fault)
{
    light_set_t lights = {0};
    const fault_code_t code = light_set_init(&lights, scene, fault);
    if (!code)
        light_set_clear(&lights);
    return code;
}

fault_code_t plan_new(plan_t **out, const job_t *job, const scene_t *scene, fault_t *fault)
{
    *out = NULL;
    TRY(plan_check_scene(scene, fault));
    plan_t *plan = calloc(1, sizeof *plan);
    if (!plan)
        return fault_set(fault, FAULT_MEMORY, "no memory for a plan");
    plan->job = *job;
    plan->settings = job->settings;
    plan->scene = scene;
    plan->error = plan->predicted = NAN;
    plan_nets_init(&plan->nets);
    fault_code_t code = renderer_complete_settings(&plan->settings, scene, fault);
    if (!code)
        code = effects_check(scene, &plan->settings, fault);
    if (!code)
        code = techniques_check(scene, &plan->settings, job->automatic, fault);
    if (code)
        goto cleanup;
    const settings_t *s = &plan->settings;
    plan->pixels = (size_t)s->width * s->height;
    plan->lengths = calloc(s->max_path_length + 1, sizeof *plan->lengths);
    plan->squares = calloc(plan->pixels, FILM_CHANNELS * sizeof *plan->squares);
    plan->features = calloc(plan->pixels, WORK_FEATURE_CHANNELS * sizeof *plan->features);
    if (!plan->lengths || !plan->squares || !plan->features) {
        code = fault_set(fault, FAULT_MEMORY, "no memory for an image of %u x %u", s->width, s->height);
        goto cleanup;
    }
    code = plan_is_chains(plan) ? plan_strata_init(plan, fault) : FAULT_NONE;
    if (!code)
        code = groups_init(&plan->groups, s->max_path_length, plan->pixels, fault);
    if (!code)
        code = plan_eras_init(&plan->eras, s->max_path_length, fault);
    plan_size_pilot(plan);
    plan->survey = calloc(plan_survey_bytes(plan) + 1, 1);
    plan->idle = calloc(s->max_path_length, sizeof *plan->idle);
    plan->idle_energy = calloc(s->max_path_length, sizeof *plan->idle_energy);
    if (!code && (!plan->survey || !plan->idle || !plan->idle_energy))
        code = fault_set(fault, FAULT_MEMORY, "no memory for a look at the techniques");
    plan->left_out = calloc(plan->left_out_units * WORK_LEFT_OUT_MOMENTS + 1, sizeof *plan->left_out);
    if (!code && !plan->left_out)
        code = fault_set(fault, FAULT_MEMORY, "no memory for the energy of what is left out");
    for (uint32_t k = plan_has_seeds(plan, 0) ? 0 : 1; k <= s->max_path_length && !code; k++) {
        plan->lengths[k].weights = calloc(plan->candidates, sizeof(double));
        if (!plan->lengths[k].weights)
            code = fault_set(fault, FAULT_MEMORY, "no memory for the pilot's candidates");
    }
    plan->pilot_moments =
        calloc(plan->candidates / plan->candidate_unit * work_samples_moment(s->max_path_length + 1),
               sizeof *plan->pilot_moments);
    plan->pilot_blocks = calloc(plan->candidates / plan->candidate_unit * s->max_path_length,
                                WORK_BLOCKS * sizeof *plan->pilot_blocks);
    if (!plan->pilot_moments || !plan->pilot_blocks)
        code = fault_set(fault, FAULT_MEMORY, "no memory for the pilot's estimates");
cleanup:
    if (code)
        plan_destroy(&plan);
    *out = plan;
    return code;
}

void plan_destroy(plan_t **out)
{
    plan_t *plan = *out;
    if (!plan)
        return;
    for (uint64_t i = 0; i < plan->unit_count; i++)
        work_record_clear(&plan->units[i].record);
    for (uint32_t k = 0; plan->lengths && k <= plan->settings.max_path_length; k++) {
        free(plan->lengths[k].weights);
        film_clear(&plan->lengths[k].film);
    }
    film_clear(&plan->spare);
    groups_clear(&plan->groups);
    plan_passes_clear(&plan->passes);
    plan_nets_clear(&plan->nets);
    plan_eras_clear(&plan->eras);
    free(plan->units);
    free(plan->pilot_moments);
    free(plan->pilot_blocks);
    free(plan->trials);
    free(plan->left_out);
    free(plan->survey);
    free(plan->idle);
    free(plan->idle_energy);
    free(plan->lengths);
    free(plan->squares);
    free(plan->strata);
    free(plan->features);
    free(plan);
    *out = NULL;
}

/* ---- handing out ---- */

bool plan_generate(plan_t *plan)
{
    if (plan->unit_count == plan->unit_room) {
        const uint64_t room = plan->unit_room ? 2 * plan->unit_room : 256;
        plan_unit_t *units = realloc(plan->units, sizeof *units * room);
        if (!units)
            return false;
        plan->units = units;
        plan->unit_room = room;
    }
    if (plan_pilot_waits(plan))
        return false;
    plan_unit_t *unit = &plan->units[plan->unit_count];
    *unit = (plan_unit_t){.era = PLAN_NO_ERA};
    if (plan->pilot_next < plan->pilot_units) {
        if (plan_pilot_record(plan, plan->pilot_next, &unit->record))
            return false;
        plan->pilot_next++;
    } else if (plan->trial_next < plan->trial_units) {
        if (!plan_trial_record(plan, plan->trial_next, &unit->record))
            return false;
        plan->trial_next++;
    } else if (plan->phase != PLAN_RENDER || !plan_eras_ready(plan) || !plan_render_record(plan, unit)) {
        return false;
    } else {
        plan_eras_made(plan, unit);
    }
    plan->unit_count++;
    return true;
}

bool plan_next(plan_t *plan, uint64_t *unit, const work_record_t **record)
{
    if (plan->stopped)
        return false;
    while (plan->resume < plan->unit_count) {
        plan_unit_t *again = &plan->units[plan->resume];
        if (again->state == PLAN_UNIT_OUT && !again->handed) {
            again->handed = true;
            *unit = plan->resume++;
            *record = &again->record;
            return true;
        }
        plan->resume++;
    }
    if (!plan_generate(plan))
        return false;
    *unit = plan->unit_count - 1;
    plan->resume = plan->unit_count;
    plan->units[*unit].handed = true;
    *record = &plan->units[*unit].record;
    return true;
}

const work_record_t *plan_record(const plan_t *plan, uint64_t unit)
{
    return unit < plan->unit_count && plan->units[unit].state == PLAN_UNIT_OUT ? &plan->units[unit].record : NULL;
}

/* ---- taking in ---- */

static void absorb_moments(plan_moments_t *to, const work_moments_t *from, double unit)
{
    exact_add(&to->n, from->n, 1);
    exact_add(&to->sum, from->sum, unit);
    exact_add(&to->sum2, from->sum2, unit * unit);
}

/* Adds the estimators of all lengths from bidirectional samples. */
static void absorb_all_moments(plan_t *plan, const work_moments_t *moments)
{
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        for (uint32_t i = 0; i <= k + 1; i++)
            absorb_moments(&plan->lengths[k].samples[i], &moments[work_samples_moment(k) + i], plan->b);
}

static void absorb_pilot(plan_t *plan, const work_record_t *record, const work_result_t *result)
{
    const uint32_t K = plan->settings.max_path_length;
    for (uint64_t i = 0; i < record->count; i++)
        for (uint32_t k = 1; k <= K; k++)
            plan->lengths[k].weights[record->first + i] = result->weights[i * K + k - 1];
    memcpy(plan->pilot_blocks + record->first / plan->candidate_unit * K * WORK_BLOCKS,
           result->weights + record->count * K, sizeof *plan->pilot_blocks * K * WORK_BLOCKS);
    memcpy(plan->pilot_moments + record->first / plan->candidate_unit * result->moment_count, result->moments,
           sizeof *result->moments * result->moment_count);
}

static void absorb_features(plan_t *plan, const work_record_t *record, const work_result_t *result)
{
    const size_t row = (size_t)WORK_FEATURE_CHANNELS * plan->settings.width;
    memcpy(plan->features + row * record->first, result->features, sizeof(float) * row * record->count);
}

/* Adds the squares of a unit's pixels, over its size: what the variance between units comes from. */
static void absorb_squares(plan_t *plan, const film_t *film, double c, double size)
{
    const double scale = c / sqrt(size) / FILM_ONE * 0x1p20;
    for (size_t i = 0; i < FILM_CHANNELS * plan->pixels; i++) {
        if (film->sums[i] == 0)
            continue;
        const double x = (double)film->sums[i] * scale;
        plan->squares[i] += exact_round(x * x);
    }
}

static fault_code_t absorb_film(plan_t *plan, plan_length_t *length, const film_t *film, fault_t *fault)
{
    if (!length->film.sums)
        TRY(film_init(&length->film, plan->settings.width, plan->settings.height, fault));
    film_add(&length->film, film);
    const film_counts_t *counts = &film->counts;
    plan->film_counts.splats += counts->splats;
    plan->film_counts.outside += counts->outside;
    plan->film_counts.nonfinite += counts->nonfinite;
    plan->film_counts.negative += counts->negative;
    plan->film_counts.saturated += counts->saturated;
    return FAULT_NONE;
}

/* A unit's weight (plan_eras.h) goes into all sums that the image and its error come from. */
static double absorb_weight(const plan_t *plan, const plan_unit_t *unit, work_result_t *result)
{
    const double weight = plan_eras_weight(plan, unit);
    if (weight == 1)
        return 1;
    film_scale(&result->film, weight);
    for (uint32_t i = 0; i < result->moment_count; i++) {
        result->moments[i].n *= weight;
        result->moments[i].sum *= weight;
        result->moments[i].sum2 *= weight;
    }
    return weight;
}

static fault_code_t absorb_chains(plan_t *plan, const plan_unit_t *unit, work_result_t *result, fault_t *fault)
{
    const work_record_t *record = &unit->record;
    const double weight = absorb_weight(plan, unit, result);
    plan_length_t *length = &plan->lengths[record->length];
    TRY(absorb_film(plan, length, &result->film, fault));
    const double c = plan_weight(plan, record->length) / plan->weight_max,
                 size = weight * (double)record->mutations / (double)length->unit_mutations;
    const uint64_t counted = (uint64_t)llround(weight * (double)record->mutations);
    absorb_squares(plan, &result->film, c, size);
    plan_absorb_strata(plan, record->length, &result->film, c, size);
    groups_absorb(&plan->groups, record->length, unit->number, counted, &result->film, c, size);
    if (plan_is_whole(plan)) /* their large steps are samples like all others */
        absorb_all_moments(plan, result->moments);
    for (uint32_t i = 0; !plan_is_whole(plan) && i < result->moment_count; i++)
        absorb_moments(&length->large_steps[i], &result->moments[i], plan->b);
    for (int i = 0; i < WORK_MOVES; i++) {
        length->proposed[i] += result->stats.proposed[i];
        exact_add(&length->accepted[i], result->stats.accepted[i], 1);
    }
    length->zero_proposals += result->stats.zero_proposals;
    for (int i = 0; result->failed && i < WORK_FAILED_BLOCKS; i++)
        length->failed[i] += result->failed[i];
    if (result->stats.longest_stay > length->longest_stay)
        length->longest_stay = result->stats.longest_stay;
    plan_stuck_absorb(plan, record, result, weight);
    plan_shorten_absorb(plan, record, weight);
    plan_eras_add(plan, unit, record->length, record->mutations);
    length->merged += record->mutations;
    length->counted += counted;
    length->rays += result->stats.rays + result->stats.shadow_rays;
    length->units_in++;
    length->cpu_seconds += result->stats.cpu_seconds;
    return FAULT_NONE;
}

/* A pass over the image, or several: what is a unit to all estimates. `unit`: one of its units, or its only one. */
static fault_code_t absorb_pass(plan_t *plan, const plan_unit_t *unit, uint64_t number, uint64_t count,
                                const film_t *film, double cpu_seconds, fault_t *fault)
{
    plan_length_t *all = &plan->lengths[0];
    TRY(absorb_film(plan, all, film, fault));
    TRY(plan_nets_absorb(plan, unit, film, fault));
    const double weight = plan_eras_weight(plan, unit), c = plan_weight(plan, 0) / plan->weight_max,
                 size = weight * (double)count / (double)all->unit_mutations;
    const uint64_t counted = (uint64_t)llround(weight * (double)count);
    absorb_squares(plan, film, c, size);
    if (plan->strata)
        plan_absorb_strata(plan, 0, film, c, size);
    groups_absorb(&plan->groups, 0, number, counted, film, c, size);
    plan_eras_add(plan, unit, 0, count);
    plan_nets_count(plan, unit, count);
    all->merged += count;
    all->counted += counted;
    all->units_in++;
    all->cpu_seconds += cpu_seconds;
    return FAULT_NONE;
}

/* A pass that was collected, if it is one. */
static fault_code_t absorb_collected(plan_t *plan, const plan_unit_t *unit, plan_pass_t *pass, fault_t *fault)
{
    if (!pass->film.sums)
        return FAULT_NONE;
    const fault_code_t code =
        absorb_pass(plan, unit, pass->number, pass->count, &pass->film, pass->cpu_seconds, fault);
    film_clear(&pass->film);
    return code;
}

static fault_code_t absorb_samples(plan_t *plan, const plan_unit_t *unit, work_result_t *result, fault_t *fault)
{
    const work_record_t *record = &unit->record;
    plan_pass_t whole;
    absorb_weight(plan, unit, result);
    if (plan->passes.parts == 1) {
        TRY(absorb_pass(plan, unit, unit->number, record->count, &result->film, result->stats.cpu_seconds, fault));
    } else {
        TRY(plan_passes_take(plan, record, result, &whole, fault));
        TRY(absorb_collected(plan, unit, &whole, fault));
    }
    absorb_all_moments(plan, result->moments);
    plan->lengths[0].rays += result->stats.rays + result->stats.shadow_rays;
    return FAULT_NONE;
}

static void absorb_totals(plan_t *plan, const work_stats_t *stats)
{
    plan->totals.cpu_seconds += stats->cpu_seconds;
    plan->totals.tracing_seconds += stats->tracing_seconds;
    plan->totals.inversion_seconds += stats->inversion_seconds;
    plan->totals.merging_seconds += stats->merging_seconds;
    plan->totals.waiting_seconds += stats->waiting_seconds;
    plan->totals.rays += stats->rays;
    plan->totals.shadow_rays += stats->shadow_rays;
    plan->totals.evaluations += stats->evaluations;
    for (int i = 0; i < WORK_REJECTS; i++)
        plan->totals.rejects[i] += stats->rejects[i];
}

/* The pilot's estimate of b_k from its candidates, in their order. */
static void pilot_finish_length(const plan_t *plan, plan_length_t *length)
{
    double sum = 0;
    for (uint64_t i = 0; i < plan->candidates; i++)
        sum += length->weights[i];
    length->b = sum / (double)plan->candidates;
}

/* Where chains start: in proportion to a candidate's weight for their length, or for all of them. */
static void pilot_finish_seeds(plan_t *plan)
{
    plan_length_t *all = &plan->lengths[0];
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        plan_length_t *length = &plan->lengths[k];
        for (uint64_t i = 0; plan_has_seeds(plan, 0) && i < plan->candidates; i++)
            all->weights[i] += length->weights[i];
        if (plan_has_seeds(plan, k)) {
            plan_prepare_seeds(plan, length);
        } else {
            free(length->weights);
            length->weights = NULL;
        }
    }
    if (plan_has_seeds(plan, 0)) {
        plan_prepare_seeds(plan, all);
        all->b = all->weights[plan->candidates - 1] / (double)plan->candidates;
    }
}

/* How much of the error is in the pixels that each length lights, from the pilot's coarse image. */
static void pilot_finish_needs(plan_t *plan)
{
    const uint32_t K = plan->settings.max_path_length;
    const uint64_t units = plan->candidates / plan->candidate_unit;
    double image[WORK_BLOCKS] = {0}, mean = 0;
    for (uint64_t u = 1; u < units; u++) /* in their order, whichever came first */
        for (size_t i = 0; i < (size_t)K * WORK_BLOCKS; i++)
            plan->pilot_blocks[i] += plan->pilot_blocks[u * K * WORK_BLOCKS + i];
    for (size_t i = 0; i < (size_t)K * WORK_BLOCKS; i++) {
        image[i % WORK_BLOCKS] += plan->pilot_blocks[i];
        mean += plan->pilot_blocks[i] / WORK_BLOCKS;
    }
    for (uint32_t k = 1; k <= K && mean > 0; k++) {
        double need = 0, light = 0;
        for (int i = 0; i < WORK_BLOCKS; i++)
            light += plan->pilot_blocks[(k - 1) * WORK_BLOCKS + i];
        plan->lengths[k].light = light / (double)plan->candidates;
        for (int i = 0; i < WORK_BLOCKS; i++)
            need += plan->pilot_blocks[(k - 1) * WORK_BLOCKS + i] * mean /
                    (image[i] * image[i] + 0.01 * mean * mean) / WORK_BLOCKS /
                    (plan->has_importance ? plan->importance[i] : 1);
        plan->lengths[k].need = need;
    }
    free(plan->pilot_blocks);
    plan->pilot_blocks = NULL;
}

/* With the last candidate: b_k and seeds are known, and how much is to be tried. */
static fault_code_t plan_finish_pilot(plan_t *plan, fault_t *fault)
{
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        pilot_finish_length(plan, &plan->lengths[k]);
    plan_bound_lengths(plan);
    plan_split_settle(plan);
    pilot_finish_seeds(plan);
    pilot_finish_needs(plan);
    plan->has_candidates = true;
    plan->stopped = true; /* unless there is light, and memory */
    TRY(plan_find_light(plan, fault));
    TRY(plan_prepare_trials(plan, fault));
    const uint32_t count = work_samples_moment(plan->settings.max_path_length + 1);
    for (uint64_t i = 0; i < plan->candidates / plan->candidate_unit; i++)
        absorb_all_moments(plan, plan->pilot_moments + i * count);
    free(plan->pilot_moments);
    plan->pilot_moments = NULL;
    plan_freeze_techniques(plan);
    plan->stopped = false;
    return FAULT_NONE;
}

static void plan_begin_render(plan_t *plan)
{
    plan_finish_trials(plan);
    plan_size_render(plan);
    plan->phase = PLAN_RENDER;
    plan->pilot_cpu_seconds = plan->totals.cpu_seconds;
}

/* Adds up a unit's result. */
static fault_code_t plan_merge(plan_t *plan, uint64_t unit, work_result_t *result, fault_t *fault)
{
    plan_unit_t *entry = &plan->units[unit];
    work_record_t *record = &entry->record;
    switch (record->kind) {
    case WORK_PILOT:
        (plan_is_split(record)    ? plan_absorb_split
         : plan_is_sketch(record) ? plan_absorb_sketch
                                  : absorb_pilot)(plan, record, result);
        break;
    case WORK_FEATURES:
        absorb_features(plan, record, result);
        break;
    case WORK_LEFT_OUT:
        plan_absorb_left_out(plan, record, result);
        break;
    case WORK_REFINE:
        if (plan_is_survey(record)) {
            plan_absorb_survey(plan, unit >= plan->sketch_units + plan->survey_units, record, result);
            break;
        }
        absorb_all_moments(plan, result->moments);
        break;
    case WORK_CHAINS:
        TRY(absorb_chains(plan, entry, result, fault));
        break;
    case WORK_TRIAL:
        plan_absorb_trial(plan, unit - plan->pilot_units, record, result);
        break;
    default:
        TRY(absorb_samples(plan, entry, result, fault));
    }
    absorb_totals(plan, &result->stats);
    plan_eras_took(plan, entry);
    work_record_clear(record);
    return FAULT_NONE;
}

static fault_code_t plan_decode(plan_t *plan, uint64_t unit, const uint8_t *data, size_t size,
                                work_result_t *result, fault_t *fault)
{
    return work_result_decode(result, &plan->units[unit].record, plan->settings.width, plan->settings.height,
                              plan->settings.max_path_length, &plan->spare, data, size, fault);
}

/* Keeps its film for the next one. */
static void plan_drop(plan_t *plan, work_result_t *result)
{
    if (result->has_film) {
        film_clear(&plan->spare);
        plan->spare = result->film;
        result->has_film = false;
    }
    work_result_clear(result);
}

/* Adds up what may be of the results that were kept. */
static fault_code_t plan_merge_pending(plan_t *plan, fault_t *fault)
{
    plan_pending_t *pending = &plan->eras.pending;
    for (size_t i = 0; i < pending->count;) {
        if (!plan_eras_takes(plan, &plan->units[pending->results[i].unit])) {
            i++;
            continue;
        }
        plan_pending_result_t kept = plan_pending_take(pending, i);
        work_result_t result;
        fault_code_t code = plan_decode(plan, kept.unit, kept.data, kept.size, &result, fault);
        free(kept.data);
        TRY(code);
        code = plan_merge(plan, kept.unit, &result, fault);
        plan_drop(plan, &result);
        TRY(code);
    }
    return FAULT_NONE;
}

fault_code_t plan_settle(plan_t *plan, fault_t *fault)
{
    TRY(plan_merge_pending(plan, fault));
    while (plan->phase == PLAN_RENDER && plan_eras_decide(plan))
        TRY(plan_merge_pending(plan, fault));
    return FAULT_NONE;
}

fault_code_t plan_absorb(plan_t *plan, uint64_t unit, const uint8_t *data, size_t size, plan_absorbed_t *how,
                         fault_t *fault)
{
    *how = PLAN_UNKNOWN;
    if (unit >= plan->unit_count)
        return FAULT_NONE;
    plan_unit_t *entry = &plan->units[unit];
    *how = PLAN_DUPLICATE;
    if (entry->state == PLAN_UNIT_IN)
        return FAULT_NONE;
    *how = PLAN_UNKNOWN;
    work_result_t result;
    TRY(plan_decode(plan, unit, data, size, &result, fault));
    const fault_code_t code = plan_eras_takes(plan, entry)
                                  ? plan_merge(plan, unit, &result, fault)
                                  : plan_pending_add(&plan->eras.pending, unit, data, size, fault);
    plan_drop(plan, &result);
    TRY(code);
    entry->state = PLAN_UNIT_IN;
    plan->in++;
    *how = PLAN_MERGED;
    if (!plan->has_candidates && plan->in == plan->pilot_units)
        TRY(plan_finish_pilot(plan, fault));
    if (plan->has_candidates && plan->phase == PLAN_PILOT && plan->trial_in == plan->trial_units)
        plan_begin_render(plan);
    return plan_settle(plan, fault);
}

/* ---- stopping ---- */

/* Every length that has a share has been seen: the image is whole, if noisy, or dotted. */
static bool plan_has_image(const plan_t *plan)
{
    if (plan->phase != PLAN_RENDER)
        return false;
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        if (plan->lengths[k].share > 0 && plan->lengths[k].budget > 0 && plan->lengths[k].units_in == 0 &&
            !(k == 0 && plan_passes_begun(plan)))
            return false;
    return true;
}

static bool plan_spent(const plan_t *plan)
{
    if (plan->phase != PLAN_RENDER || plan->in < plan->unit_count)
        return false;
    return plan_eras_spent(plan);
}

static bool plan_stop(plan_t *plan, const char *rule)
{
    const plan_unit_t first = {.era = 0}; /* that of the first pass */
    plan_pass_t parts;
    fault_t fault = {0};
    plan->stopped = true;
    plan->stopped_by = rule;
    plan_merge_pending(plan, &fault); /* without memory: fewer units are in the image */
    plan_passes_settle(plan, &parts);
    absorb_collected(plan, &first, &parts, &fault); /* likewise */
    plan_note_error(plan);
    return true;
}

void plan_note_merging(plan_t *plan, double seconds)
{
    if (seconds > 0)
        plan->totals.merging_seconds += seconds;
}

/* Whether there may be an estimate of the error to go by: a dotted image is for a late end alone, and that of a
 * single pass over the image is a stand-in. */
static bool plan_has_error(const plan_t *plan)
{
    return !plan_passes_begun(plan) && (plan_runs_chains(plan) || plan->lengths[0].units_in > 1);
}

/* Seconds from one estimate of the error to the next, at least: nothing is handed out meanwhile. Of half a million
 * pixels it takes a tenth of a second, and predictions want all they can get; of a large image it should take no
 * more than a tenth of the time. */
static double plan_error_pause(const plan_t *plan)
{
    const double small = 1 << 19;
    return 3e-6 * fmax(0, (double)plan->pixels - small);
}

/* Units until the error is estimated anew: the history's points are a quarter apart, where a rule waits for an
 * error a tenth; the first is as early as there is an estimate. */
static uint64_t plan_error_wait(const plan_t *plan)
{
    const bool rule = plan->job.stop.error > 0;
    const uint64_t rendered = plan->in - plan->pilot_units - plan->trial_units, least = rule ? 4 : 1,
                   wait = rendered / (rule ? 10 : 4);
    return isfinite(plan->error) && wait > least ? wait : isfinite(plan->error) ? least : 1;
}

bool plan_check_stop(plan_t *plan, double seconds)
{
    const job_stop_t *stop = &plan->job.stop;
    plan->seconds = seconds;
    if (plan->stopped || !plan_has_image(plan))
        return false;
    if (plan_spent(plan))
        return plan_stop(plan, "mutations_per_pixel");
    if (stop->seconds > 0 && seconds >= stop->seconds)
        return plan_stop(plan, "seconds");
    if (plan->in >= plan->error_next && seconds >= plan->error_due && plan_has_error(plan)) {
        plan_note_error(plan);
        plan->error_due = isfinite(plan->error) ? seconds + plan_error_pause(plan) : 0;
        plan->error_next = plan->in + plan_error_wait(plan);
        if (stop->error > 0 && plan->error <= stop->error)
            return plan_stop(plan, "error");
    }
    return false;
}

bool plan_finished(const plan_t *plan)
{
    return plan->stopped;
}

double plan_merged(const plan_t *plan)
{
    double merged = 0;
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        merged += plan_mutations_of(plan, k) * (double)plan->lengths[k].merged;
    return merged;
}

void plan_progress(const plan_t *plan, plan_progress_t *progress)
{
    const job_stop_t *stop = &plan->job.stop;
    const double open = plan->stopped ? 0 : (double)plan_passes_waiting(plan);
    *progress = (plan_progress_t){.phase = plan->stopped ? PLAN_DONE : plan->phase,
                                  .mutations = plan_merged(plan) + plan_mutations_of(plan, 0) * open,
                                  .error = plan->error,
                                  .seconds = plan->seconds,
                                  .seconds_left = NAN,
                                  .units_out = plan->unit_count - plan->in,
                                  .units_in = plan->in,
                                  .stopped_by = plan->stopped_by};
    progress->mutations_per_pixel = progress->mutations / (double)plan->pixels;
    if (plan->phase == PLAN_PILOT) {
        progress->fraction = stop->seconds > 0 ? fmin(1, plan->seconds / stop->seconds) : 0;
        return;
    }
    double fraction = 0;
    if (plan->mutations_total > 0)
        fraction = fmax(fraction, progress->mutations / plan->mutations_total);
    if (stop->seconds > 0)
        fraction = fmax(fraction, plan->seconds / stop->seconds);
    if (stop->error > 0 && plan->error > 0)
        fraction = fmax(fraction, plan->totals.cpu_seconds / plan->predicted);
    progress->fraction = fmin(1, fraction);
    if (fraction > 0 && plan->seconds > 0)
        progress->seconds_left = fmax(0, plan->seconds * (1 / fraction - 1));
}
