/* plan_split.c: what independent samples bring and what chains do: the caps of split.h, and how the work is shared.
 *
 * With the importance g, c = C g is relative error's own measure: in units where it is 1 everywhere, the mean
 * relative variance of a pixel is
 *
 *     V / N of N samples, V = Var X within a pixel (there are as many samples in each),
 *
 *     inefficiency b_k^2 / N_k of N_k mutations,
 *
 * X = sum over k of min(c_k, cap_k) being a sample's sum, b_k = E max(c_k - cap_k, 0) what chains of length k
 * follow; the inefficiency (settings.split) is how many mutations do what one independent draw from the chains' law
 * would do. With costs a sample and d_k a mutation, at a fixed cost in all the least variance is
 *
 *     (sqrt(a V) + sum_k sqrt(d_k inefficiency) b_k)^2,
 *
 * reached with N in proportion to sqrt(V / a), N_k to b_k sqrt(inefficiency / d_k). Its derivative by cap_k, all
 * lengths but one being fixed, is zero where cap_k = lambda sqrt(d_k inefficiency / a) with one lambda for all
 * lengths (the root of V, if a sample is seldom of more than one part). So there is one number to choose: the least
 * is looked for over a grid of lambda, 0 (chains bring all) among it, from the sums of one batch of samples that
 * are used for nothing else. What the caps are decides how noisy the image is, not what it converges to.
 *
 * Costs are in rays, counted, as nothing here may depend on a clock.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/plan_state.h"

/* Indices of samples that are neither candidates nor the sketch's, and come in pairs. */
#define SPLIT_FIRST WORK_PAIRS_FIRST
enum {
    SPLIT_PARTS = 8, /* one sample in so many of the pilot's */
    SPLIT_GRID = 64, /* values of lambda */
    SPLIT_SEEDS = 4  /* candidates above the cap that a length's chains need at least */
};
/* Rays of a mutation of length k over k + 2: measured on the scenes of docs/benchmarks.md, 0.3 to 0.5. */
static const double SPLIT_RAYS = 0.4;

uint64_t plan_split_size(const plan_t *plan, uint64_t units)
{
    return plan->settings.split > 0 && plan_is_chains(plan) ? (units + SPLIT_PARTS - 1) / SPLIT_PARTS : 0;
}

void plan_split_record(const plan_t *plan, uint64_t index, work_record_t *record)
{
    record->kind = WORK_PILOT;
    record->first = SPLIT_FIRST + index * plan->pilot_unit;
    record->count = plan->pilot_unit;
}

bool plan_is_split(const work_record_t *record)
{
    return record->kind == WORK_PILOT && record->first >= SPLIT_FIRST;
}

static double split_mutation(uint32_t k)
{
    return SPLIT_RAYS * (2 + (double)k);
}

/* What lambda gives: the root of the variance at unit cost, and the samples' part of it. */
typedef struct split_choice {
    double lambda, deviation, samples;
} split_choice_t;

/* The batch's sums of sample i of length k, as absorb_pilot keeps weights. */
static double split_total(const plan_t *plan, uint64_t i, uint32_t k)
{
    return plan->lengths[k].weights[i];
}

static split_choice_t split_try(const plan_t *plan, const double *ratios, double sample, double lambda)
{
    const uint64_t n = plan->split_units * plan->pilot_unit;
    const uint32_t K = plan->settings.max_path_length;
    double before = 0, squares = 0, chains = 0, excess[PATH_MAX_VERTICES] = {0};
    for (uint64_t i = 0; i < n; i++) {
        double x = 0;
        for (uint32_t k = 1; k <= K; k++) {
            const double c = split_total(plan, i, k), cap = lambda * ratios[k];
            x += c < cap ? c : cap;
            excess[k] += c > cap ? c - cap : 0;
        }
        if (i % 2 == 1)
            squares += (x - before) * (x - before);
        before = x;
    }
    const double variance = 0.5 * squares / (double)(n / 2);
    for (uint32_t k = 1; k <= K; k++)
        chains += sqrt(split_mutation(k) * plan->settings.split) * excess[k] / (double)n;
    const double samples = sqrt(sample * variance);
    return (split_choice_t){lambda, samples + chains, samples / sample};
}

/* The largest lambda at which a sample of the batch still meets a cap. */
static double split_largest(const plan_t *plan, const double *ratios)
{
    const uint64_t n = plan->split_units * plan->pilot_unit;
    double largest = 0;
    for (uint64_t i = 0; i < n; i++)
        for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
            largest = fmax(largest, split_total(plan, i, k) / ratios[k]);
    return largest;
}

static void split_finish(plan_t *plan)
{
    const uint64_t n = plan->split_units * plan->pilot_unit;
    const double sample = fmax(1, (double)plan->split_rays / (double)n);
    double ratios[PATH_MAX_VERTICES];
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        ratios[k] = sqrt(split_mutation(k) * plan->settings.split / sample);
    const double largest = split_largest(plan, ratios);
    split_choice_t best = split_try(plan, ratios, sample, 0);
    for (int i = 0; i < SPLIT_GRID && largest > 0; i++) {
        const split_choice_t choice = split_try(plan, ratios, sample, largest * exp2(-0.5 * i));
        if (choice.deviation < best.deviation)
            best = choice;
    }
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        plan->caps[k - 1] = best.lambda * ratios[k];
        memset(plan->lengths[k].weights, 0, sizeof(double) * n);
    }
    plan->split_samples = best.samples;
    plan->has_caps = true;
}

void plan_absorb_split(plan_t *plan, const work_record_t *record, const work_result_t *result)
{
    const uint32_t K = plan->settings.max_path_length;
    for (uint64_t i = 0; i < record->count; i++)
        for (uint32_t k = 1; k <= K; k++)
            plan->lengths[k].weights[record->first - SPLIT_FIRST + i] = result->weights[i * K + k - 1];
    plan->split_rays += result->stats.rays + result->stats.shadow_rays;
    plan->split_in++;
    if (plan->split_in == plan->split_units)
        split_finish(plan);
}

/* A length whose chains would have nowhere to start leaves all of it to samples. */
void plan_split_settle(plan_t *plan)
{
    if (!plan->has_caps)
        return;
    for (uint32_t k = 1; k <= plan->settings.max_path_length && plan->split_samples > 0; k++) {
        uint32_t seeds = 0;
        for (uint64_t i = 0; i < plan->candidates && seeds < SPLIT_SEEDS; i++)
            seeds += plan->lengths[k].weights[i] > 0;
        if (seeds < SPLIT_SEEDS)
            plan->caps[k - 1] = INFINITY;
    }
}

void plan_split_shares(plan_t *plan)
{
    const double least = 0.005;
    double sum = 0;
    plan->lengths[0].share = plan->split_samples * PLAN_SAMPLE_MUTATIONS;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        plan_length_t *length = &plan->lengths[k];
        length->share =
            plan->caps[k - 1] < INFINITY ? length->b * sqrt(plan->settings.split / split_mutation(k)) : 0;
        sum += length->share;
    }
    double all = plan->lengths[0].share;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        plan_length_t *length = &plan->lengths[k];
        if (length->share > 0)
            length->share = fmax(length->share, least * (sum + plan->lengths[0].share));
        all += length->share;
    }
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        plan->lengths[k].share /= all;
}

fault_code_t plan_set_caps(const plan_t *plan, work_record_t *record, fault_t *fault)
{
    if (!plan->has_caps)
        return FAULT_NONE;
    const bool chains = record->kind == WORK_CHAINS;
    record->cap_count = chains ? 1 : plan->settings.max_path_length;
    record->caps = malloc(sizeof(double) * record->cap_count);
    if (!record->caps)
        return fault_set(fault, FAULT_MEMORY, "no memory for a unit's caps");
    memcpy(record->caps, plan->caps + (chains ? record->length - 1 : 0), sizeof(double) * record->cap_count);
    return FAULT_NONE;
}
