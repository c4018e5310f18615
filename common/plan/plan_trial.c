/* plan_trial.c: chains tried out before the render: how long the steps of each path length should be, and what its
 * mutations are worth. Nothing of a trial is in the image, and what it decides is frozen with it: the render's
 * target and its independence of the decision are as if the job had said so.
 *
 * N mutations of length k bring the image a variance of b_k^2 q_k / N, in units where relative error is one
 * everywhere (plan_split.c; without the importance for that, times need_k / b_k): q_k, the inefficiency, is the
 * spread of a chain's film over its mutations (chain/trial.c), 1 for independent draws. What a mutation costs, d_k,
 * is its rays. The shares go by b_k sqrt(q_k / d_k).
 *
 * Lengths with much work are tried with other steps too, from the same seeds and with the same random numbers,
 * which take the place of the usual ones if their q d is clearly less. Chains are as long as the render's, as
 * shorter ones would tell of something else; a job that has no room for them has no trials. Few chains see little
 * of rare stays: each q is drawn to that of all lengths by the weight of a few chains.
 */
#include "plan/plan_trial.h"

#include <math.h>
#include <stdlib.h>

#include "plan/plan_budget.h"

/* Numbers of chains that no render comes to. */
#define TRIAL_FIRST (UINT64_C(1) << 40)
enum {
    TRIAL_PARTS = 16,      /* one part in so many of the work */
    TRIAL_LEAST = 4,       /* chains of a length */
    TRIAL_CHOICE = 8,      /* chains from which on steps are compared */
    TRIAL_MOST = 32,       /* likewise */
    TRIAL_USUAL = 1 << 26, /* mutations of a render whose rule does not say how many */
    TRIAL_PRIOR = 4,       /* chains that the mean of all lengths counts as */
};
static const double TRIAL_MATTERS = 0.1; /* share of the chains' work from which a length's steps are tried */
static const double TRIAL_CLEARLY = 0.75;

/* Steps and large steps, as in work_record_t; the settings' own first. */
static const plan_steps_t trial_options[] = {{0, 0}, {-2, 0}, {2, 0}, {0, -2}};
enum { TRIAL_OPTIONS = sizeof trial_options / sizeof *trial_options };

static double trial_work(const plan_t *plan)
{
    const double seconds = plan->job.stop.seconds;
    double work = plan->mutations_total > 0 ? plan->mutations_total : INFINITY;
    if (seconds > 0)
        work = fmin(work, seconds * PLAN_USUAL_RATE);
    return work < INFINITY ? work : TRIAL_USUAL;
}

static void trial_size(plan_t *plan)
{
    const uint32_t K = plan->settings.max_path_length;
    plan->trial_units = 0;
    if (!plan->settings.adapt || !plan_is_chains(plan) || plan_is_whole(plan) || plan->samples_alone)
        return;
    plan_shares(plan);
    double chains = 0;
    uint32_t active = 0;
    for (uint32_t k = 1; k <= K; k++) {
        chains += plan->lengths[k].share;
        active += plan->lengths[k].share > 0;
    }
    const double together = work_together(plan->settings.algorithm), mutations = (double)plan_chain_length(plan),
                 work = trial_work(plan) * fmin(1.0 / TRIAL_PARTS, 0.25 * chains),
                 spare = work / (mutations * together) - TRIAL_LEAST * (double)active;
    if (active == 0 || spare < 0)
        return;
    plan->trial_mutations = plan_chain_length(plan);
    for (uint32_t k = 1; k <= K; k++) {
        plan_length_t *length = &plan->lengths[k];
        const double part = length->share / chains;
        if (!(length->share > 0))
            continue;
        length->trials = (uint32_t)fmin(TRIAL_LEAST + floor(spare * part / TRIAL_OPTIONS), TRIAL_MOST);
        length->trial_options = part >= TRIAL_MATTERS && length->trials >= TRIAL_CHOICE ? TRIAL_OPTIONS : 1;
        plan->trial_units += length->trial_options;
    }
}

fault_code_t plan_prepare_trials(plan_t *plan, fault_t *fault)
{
    trial_size(plan);
    plan->trials = calloc(plan->trial_units + 1, sizeof *plan->trials);
    return plan->trials ? FAULT_NONE : fault_set(fault, FAULT_MEMORY, "no memory for the trials' figures");
}

/* The length and option of a trial's unit. */
static uint32_t trial_place(const plan_t *plan, uint64_t index, uint32_t *option)
{
    uint32_t k = 1;
    for (; plan->lengths[k].trials == 0 || index >= plan->lengths[k].trial_options; k++)
        index -= plan->lengths[k].trials > 0 ? plan->lengths[k].trial_options : 0;
    *option = (uint32_t)index;
    return k;
}

bool plan_trial_record(const plan_t *plan, uint64_t index, work_record_t *record)
{
    uint32_t option;
    const uint32_t k = trial_place(plan, index, &option);
    const uint64_t chains = (uint64_t)plan->lengths[k].trials * work_together(plan->settings.algorithm);
    if (!plan_chains_record(plan, WORK_TRIAL, k, TRIAL_FIRST, chains, plan->trial_mutations * chains,
                            trial_options[option], record))
        return false;
    record->scale = plan->lengths[k].b * (double)plan->pixels /
                    (plan->b * (double)(plan->trial_mutations * work_together(plan->settings.algorithm)));
    return true;
}

void plan_absorb_trial(plan_t *plan, uint64_t index, const work_record_t *record, const work_result_t *result)
{
    plan->trials[index] = (plan_trial_t){.spread = result->spread,
                                         .rays = (double)(result->stats.rays + result->stats.shadow_rays) *
                                                 (double)plan->trial_mutations / (double)record->mutations};
    plan->trial_in++;
}

/* The mean spread of the usual steps' chains. */
static double trial_mean(const plan_t *plan)
{
    double spread = 0, chains = 0;
    uint64_t unit = 0;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        const plan_length_t *length = &plan->lengths[k];
        if (length->trials == 0)
            continue;
        spread += plan->trials[unit].spread * length->trials;
        chains += length->trials;
        unit += length->trial_options;
    }
    return chains > 0 ? spread / chains : 0;
}

void plan_finish_trials(plan_t *plan)
{
    const double prior = TRIAL_PRIOR * trial_mean(plan), mutations = (double)plan->trial_mutations;
    uint64_t unit = 0;
    if (!(prior > 0))
        return;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        plan_length_t *length = &plan->lengths[k];
        double best = INFINITY;
        for (uint32_t o = 0; length->trials > 0 && o < length->trial_options; o++, unit++) {
            const plan_trial_t *trial = &plan->trials[unit];
            const double spread = (prior + trial->spread * length->trials) / (TRIAL_PRIOR + length->trials) /
                                  (mutations * work_together(plan->settings.algorithm)),
                         cost = fmax(trial->rays / mutations, 1e-3);
            if (!(spread * cost < best * (o == 0 || length->option > 0 ? 1 : TRIAL_CLEARLY)))
                continue;
            best = spread * cost;
            length->option = o;
            length->steps = trial_options[o];
            length->inefficiency = spread;
            length->cost = cost;
        }
    }
}

void plan_trial_put(wire_writer_t *out, const plan_t *plan)
{
    wire_put_u64(out, plan->trial_units);
    for (uint64_t i = 0; i < plan->trial_units; i++) {
        wire_put_f64(out, plan->trials[i].spread);
        wire_put_f64(out, plan->trials[i].rays);
    }
}

void plan_trial_get(wire_reader_t *in, plan_t *plan)
{
    const uint64_t count = wire_get_u64(in, "trials");
    if (!in->code && count != plan->trial_units)
        wire_reader_fail(in, FAULT_FORMAT, "trials", "%llu, expected %llu", (unsigned long long)count,
                         (unsigned long long)plan->trial_units);
    for (uint64_t i = 0; i < plan->trial_units && !in->code; i++) {
        plan_trial_t *trial = &plan->trials[i];
        trial->spread = wire_get_f64(in, "trials");
        trial->rays = wire_get_f64(in, "trials");
        if (!in->code && (!(trial->spread >= 0 && trial->rays >= 0) || !isfinite(trial->spread + trial->rays)))
            wire_reader_fail(in, FAULT_RANGE, "trials", "%llu is negative or not finite", (unsigned long long)i);
    }
}
