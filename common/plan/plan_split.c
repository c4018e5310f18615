/* plan_split.c: what independent samples bring and what chains do: the caps of split.h, and how the work is shared.
 *
 * With the importance g, c = C g is relative error's own measure: in units where it is 1 everywhere, the mean
 * relative variance of a pixel is
 *
 *     V / N of N samples, V = Var X within a pixel (there are as many samples in each),
 *
 *     inefficiency b_k^2 / N_k of N_k mutations,
 *
 * X = sum over k of min(c_k, cap_k) / rate_k being a sample's sum (stats/rates.h), b_k = E max(c_k - cap_k, 0) what
 * chains of length k follow; the inefficiency (settings.split) is how many mutations do what one independent draw
 * from the chains' law would do. With costs a sample and d_k a mutation, at a fixed cost in all the least variance
 * is
 *
 *     (sqrt(a V) + sum_k sqrt(d_k inefficiency) b_k)^2,
 *
 * reached with N in proportion to sqrt(V / a), N_k to b_k sqrt(inefficiency / d_k). Its derivative by cap_k, all
 * lengths but one being fixed, is zero where cap_k = lambda rate_k sqrt(d_k inefficiency) with one lambda for all
 * lengths (sqrt(V / a), if a sample is seldom of more than one part). So there is one number to choose: the least
 * is looked for over a grid of lambda, 0 (chains bring all) among it, from the sums of one batch of samples that
 * are used for nothing else; twice, with all rates 1 and then with those that went with the best. What the caps and
 * rates are decides how noisy the image is, not what it converges to.
 *
 * What chains promise they seldom keep: of peaks alone their inefficiency is several times that of a whole length
 * (docs/gains.md), and they want a pilot. So where samples alone need less than settings.split_gain times the work
 * of the best choice, they are alone: no caps, no chains, and few candidates, as none is a seed.
 *
 * Costs are in rays, counted, as nothing here may depend on a clock.
 */
#include "plan/plan_split.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/plan_budget.h"
#include "stats/rates.h"
#include "plan/plan_missed.h"

/* Indices of samples that are neither candidates nor the sketch's, and come in pairs. */
#define SPLIT_FIRST WORK_PAIRS_FIRST
enum {
    SPLIT_GRID = 64, /* values of lambda */
    SPLIT_SEEDS = 4  /* candidates above the cap that a length's chains need at least */
};

bool plan_wants_split(const plan_t *plan)
{
    return plan->settings.split > 0 && plan_is_chains(plan);
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

/* The batch's sums of sample i of length k, as absorb_pilot keeps weights. */
static double split_total(const plan_t *plan, uint64_t i, uint32_t k)
{
    return plan->lengths[k].weights[i];
}

/* What lambda gives: the root of the variance at unit cost, the samples that are made then, and their rates. */
typedef struct split_choice {
    double lambda, deviation, samples, rates[PATH_MAX_LENGTH];
} split_choice_t;

/* Sums of the batch under one lambda. */
typedef struct split_sums {
    double squares[PATH_MAX_VERTICES]; /* of what the tails k, k + 1, ... of a pair's samples differ by */
    double excess[PATH_MAX_VERTICES];
} split_sums_t;

static void split_add_pair(const plan_t *plan, uint64_t pair, const double *caps, split_sums_t *sums)
{
    double difference = 0;
    for (uint32_t k = plan->settings.max_path_length; k >= 1; k--) {
        for (uint32_t i = 0; i < 2; i++) {
            const double c = split_total(plan, 2 * pair + i, k), cap = caps[k];
            difference += (c < cap ? c : cap) * (i == 0 ? 1 : -1);
            sums->excess[k] += c > cap ? c - cap : 0;
        }
        sums->squares[k] += difference * difference;
    }
}

static split_choice_t split_try(const plan_t *plan, const double *ratios, double lambda)
{
    const uint64_t n = plan->split_units * plan->pilot_unit;
    const uint32_t K = plan->settings.max_path_length;
    double caps[PATH_MAX_VERTICES], parts[PATH_MAX_LENGTH], costs[PATH_MAX_LENGTH], chains = 0;
    split_sums_t sums = {0};
    split_choice_t choice = {.lambda = lambda};
    for (uint32_t k = 1; k <= K; k++)
        caps[k] = lambda * ratios[k];
    for (uint64_t pair = 0; pair < n / 2; pair++)
        split_add_pair(plan, pair, caps, &sums);
    for (uint32_t k = 1; k <= K; k++) {
        parts[k - 1] = (sums.squares[k] - sums.squares[k + 1]) / (double)n;
        costs[k - 1] = (double)plan->split_rays[k - 1] / (double)n;
        chains += sqrt(plan_usual_cost(k) * plan->settings.split) * sums.excess[k] / (double)n;
    }
    const rates_figures_t sample = rates_best(parts, costs, K, choice.rates);
    choice.deviation = sqrt(sample.variance * sample.cost) + chains;
    choice.samples = sqrt(sample.variance / sample.cost);
    return choice;
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

/* The best of a grid of lambdas. With work for less than a pass of samples and chains beside: of all or nothing. */
static split_choice_t split_search(const plan_t *plan, const double *ratios)
{
    const double largest = plan_has_room(plan, 2) ? split_largest(plan, ratios) : 0;
    split_choice_t best = split_try(plan, ratios, 0);
    for (int i = 0; i < SPLIT_GRID && largest > 0; i++) {
        const split_choice_t choice = split_try(plan, ratios, largest * exp2(-0.5 * i));
        if (choice.deviation < best.deviation)
            best = choice;
    }
    return best;
}

/* No length has chains. The pilot keeps its units, which have fewer candidates, unless the job says how many. */
static void split_leave_alone(plan_t *plan)
{
    const uint64_t units = plan->candidates / plan->candidate_unit;
    plan->samples_alone = true;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        plan->caps[k - 1] = INFINITY;
    if (plan->settings.pilot_samples > 0 || plan->candidates <= PLAN_SCALE_CANDIDATES)
        return;
    plan->candidate_unit = (uint32_t)((PLAN_SCALE_CANDIDATES + units - 1) / units);
    plan->candidates = units * plan->candidate_unit;
}

static void split_finish(plan_t *plan)
{
    const uint64_t n = plan->split_units * plan->pilot_unit;
    const uint32_t K = plan->settings.max_path_length;
    double ratios[PATH_MAX_VERTICES] = {0};
    for (uint32_t k = 1; k <= K; k++)
        ratios[k] = sqrt(plan_usual_cost(k) * plan->settings.split);
    split_choice_t best = split_search(plan, ratios);
    for (uint32_t k = 1; k <= K; k++)
        ratios[k] *= best.rates[k - 1];
    best = split_search(plan, ratios);
    const split_choice_t alone = split_try(plan, ratios, INFINITY);
    const double less = best.deviation > 0 ? alone.deviation / best.deviation : 1;
    plan->split_promise = less * less;
    if (plan->settings.split_gain > 1 && plan->split_promise < plan->settings.split_gain)
        best = alone;
    for (uint32_t k = 1; k <= K; k++) {
        plan->caps[k - 1] = best.lambda * ratios[k];
        plan->rates[k - 1] = best.rates[k - 1];
        memset(plan->lengths[k].weights, 0, sizeof(double) * n);
    }
    plan->split_samples = best.samples;
    plan->has_caps = true;
    if (best.lambda == INFINITY)
        split_leave_alone(plan);
}

void plan_absorb_split(plan_t *plan, const work_record_t *record, const work_result_t *result)
{
    const uint32_t K = plan->settings.max_path_length;
    for (uint64_t i = 0; i < record->count; i++)
        for (uint32_t k = 1; k <= K; k++)
            plan->lengths[k].weights[record->first - SPLIT_FIRST + i] = result->weights[i * K + k - 1];
    for (uint32_t k = 0; k < K; k++)
        plan->split_rays[k] += (uint64_t)fmin(result->weights[(record->count + WORK_BLOCKS) * K + k], 0x1p50);
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
        length->share = plan->caps[k - 1] < INFINITY ? length->b * sqrt(length->inefficiency / length->cost) : 0;
        sum += length->share;
    }
    double all = plan->lengths[0].share;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        plan_length_t *length = &plan->lengths[k];
        if (length->share > 0)
            length->share = fmax(length->share, plan_least_share(plan, k, least) * (sum + plan->lengths[0].share));
        all += length->share;
    }
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        plan->lengths[k].share /= all;
}

static double *split_copy(const double *values, uint32_t count)
{
    double *copy = malloc(sizeof *copy * count);
    if (copy)
        memcpy(copy, values, sizeof *copy * count);
    return copy;
}

fault_code_t plan_set_caps(const plan_t *plan, work_record_t *record, fault_t *fault)
{
    if (!plan->has_caps)
        return FAULT_NONE;
    const bool chains = work_runs_chains(record->kind), samples = record->kind == WORK_SAMPLES;
    if (!plan->samples_alone) {
        record->cap_count = chains ? 1 : plan->settings.max_path_length;
        record->caps = split_copy(plan->caps + (chains ? record->length - 1 : 0), record->cap_count);
    }
    record->rate_count = samples ? plan->settings.max_path_length : 0;
    record->rates = samples ? split_copy(plan->rates, record->rate_count) : NULL;
    return (record->caps || plan->samples_alone) && (record->rates || !samples)
               ? FAULT_NONE
               : fault_set(fault, FAULT_MEMORY, "no memory for a unit's caps");
}

void plan_split_put(wire_writer_t *out, const plan_t *plan)
{
    for (uint32_t k = 0; k < plan->settings.max_path_length; k++)
        wire_put_u64(out, plan->split_rays[k]);
    wire_put_u8(out, plan->has_caps);
    if (!plan->has_caps)
        return;
    wire_put_u8(out, plan->samples_alone);
    wire_put_f64(out, plan->split_promise);
    wire_put_f64(out, plan->split_samples);
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        wire_put_f64(out, plan->caps[k - 1]);
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        wire_put_f64(out, plan->rates[k - 1]);
}

void plan_split_get(wire_reader_t *in, plan_t *plan)
{
    for (uint32_t k = 0; k < plan->settings.max_path_length; k++)
        plan->split_rays[k] = wire_get_u64(in, "split rays");
    const uint8_t has_caps = wire_get_u8(in, "caps");
    if (!in->code && (has_caps > 1 || (has_caps && plan->split_units == 0)))
        wire_reader_fail(in, FAULT_FORMAT, "caps", "%u, of a job %s split", has_caps,
                         plan->split_units ? "with a" : "without");
    plan->has_caps = !in->code && has_caps;
    if (!plan->has_caps)
        return;
    const uint8_t alone = wire_get_u8(in, "samples alone");
    if (!in->code && alone > 1)
        wire_reader_fail(in, FAULT_FORMAT, "samples alone", "%u", alone);
    if (!in->code && alone)
        split_leave_alone(plan);
    plan->split_promise = wire_get_f64(in, "split promise");
    if (!in->code && (!(plan->split_promise >= 0) || !isfinite(plan->split_promise)))
        wire_reader_fail(in, FAULT_RANGE, "split promise", "%g", plan->split_promise);
    plan->split_samples = wire_get_f64(in, "split samples");
    if (!in->code && (!(plan->split_samples >= 0) || !isfinite(plan->split_samples)))
        wire_reader_fail(in, FAULT_RANGE, "split samples", "%g", plan->split_samples);
    for (uint32_t k = 1; k <= plan->settings.max_path_length && !in->code; k++) {
        plan->caps[k - 1] = wire_get_f64(in, "caps");
        if (!in->code && !(plan->caps[k - 1] >= 0 && (plan->caps[k - 1] == INFINITY || !plan->samples_alone)))
            wire_reader_fail(in, FAULT_RANGE, "caps", "%g", plan->caps[k - 1]);
    }
    for (uint32_t k = 1; k <= plan->settings.max_path_length && !in->code; k++) {
        plan->rates[k - 1] = wire_get_f64(in, "rates");
        if (!in->code && !(plan->rates[k - 1] > 0 && plan->rates[k - 1] <= (k > 1 ? plan->rates[k - 2] : 1)))
            wire_reader_fail(in, FAULT_RANGE, "rates", "%g", plan->rates[k - 1]);
    }
}
