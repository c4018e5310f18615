#include "plan/plan_eras.h"

#include <math.h>
#include <stdlib.h>

#include "plan/plan_budget.h"
#include "plan/plan_estimate.h"
#include "stats/shift.h"
#include "plan/plan_state.h"

enum {
    ERAS_DOUBLED = 4, /* each era but the second is twice the one before: where the end is known so many times at */
    ERAS_MOST = 7,    /* least, and at most, so that the first one is a sixteenth to a 128th of all */
    ERAS_CHAINS = 4,  /* of each length in the first era, if that does not make it larger than a sixteenth */
    ERAS_AHEAD = 2,   /* that are decided before any is in */
    ERAS_CHEAP = 50   /* a pass of samples is in every era that it is not more than such a part of */
};
#define ERAS_LARGEST 0x1p61
/* Passes over the image that are due to samples in an era that has some: rounded, one. What is due in the eras
 * before, which are as large together, is as much, and one pass as well: a render that is ended by the clock may
 * have no more eras than these. */
static const double ERAS_LEAST_PASSES = M_SQRT1_2;
static const double ERAS_LEAST_SHARE = 0.005;

fault_code_t plan_eras_init(plan_eras_t *eras, uint32_t max_path_length, fault_t *fault)
{
    eras->parts = calloc((size_t)PLAN_ERAS * (max_path_length + 1), sizeof *eras->parts);
    return eras->parts ? FAULT_NONE : fault_set(fault, FAULT_MEMORY, "no memory for the shares of eras");
}

void plan_eras_clear(plan_eras_t *eras)
{
    free(eras->parts);
    plan_pending_clear(&eras->pending);
    *eras = (plan_eras_t){0};
}

plan_part_t *plan_eras_part(const plan_t *plan, uint32_t era, uint32_t k)
{
    return &plan->eras.parts[(size_t)era * (plan->settings.max_path_length + 1) + k];
}

/* ---- sizes ---- */

/* Mutations that make a chain of every length; 0: there is nothing to share, or the law is not to be changed. */
static double eras_chains(const plan_t *plan)
{
    double lengths = 0;
    if (!plan->settings.shift || !plan_is_chains(plan) || plan_is_whole(plan) ||
        plan->settings.failures == SETTINGS_FAILURES_PUBLISHED)
        return 0;
    for (uint32_t k = 1; k <= plan_last(plan); k++)
        lengths += plan->lengths[k].share > 0;
    return lengths * (double)plan_chain_length(plan);
}

/* How large eras are; one alone if there is too little work for more. */
static void eras_size(plan_t *plan)
{
    plan_eras_t *eras = &plan->eras;
    const double chains = eras_chains(plan), seconds = fmin(plan->job.stop.seconds, 1e9);
    double first = fmax(seconds * PLAN_USUAL_RATE * exp2(-ERAS_DOUBLED), ERAS_CHAINS * chains);
    eras->count = chains > 0 ? PLAN_ERAS : 1;
    if (chains > 0 && plan->mutations_total > 0) {
        uint32_t doubled = ERAS_DOUBLED;
        while (doubled < ERAS_MOST && plan->mutations_total * exp2(-1.0 - doubled) >= ERAS_CHAINS * chains)
            doubled++;
        first = plan->mutations_total * exp2(-(double)doubled);
        eras->count = first >= chains ? doubled + 1 : 1;
    }
    for (uint32_t r = 0; r < eras->count; r++)
        eras->list[r].work = r < 2 ? first : 2 * eras->list[r - 1].work;
}

/* What a length needs of an era to be in it: mutations, or samples as what they count. */
static double eras_least(const plan_t *plan, uint32_t k)
{
    const uint64_t unit = plan->lengths[k].unit_mutations, chain = plan_chain_length(plan);
    return plan_is_samples(plan, k) ? plan_mutations_of(plan, k) * (double)plan->pixels
                                    : (double)(unit < chain ? unit : chain);
}

/* Whether an era is large enough for a length: its share is what it needs. Samples come in whole passes: about one
 * is due, or they are so cheap that they do not matter. */
static bool eras_is_large(const plan_t *plan, uint32_t k, double work)
{
    const double least = eras_least(plan, k), own = plan->lengths[k].share * work;
    return plan_is_samples(plan, k) ? own >= ERAS_LEAST_PASSES * least || work >= ERAS_CHEAP * least : own >= least;
}

/* W_r of each length: the era's, but for eras that are too small for it. */
static void eras_spread(plan_t *plan, uint32_t k)
{
    for (uint32_t r = 0; r < plan->eras.count && plan->lengths[k].share > 0; r++) {
        const double work = plan->eras.list[r].work;
        plan_eras_part(plan, eras_is_large(plan, k, work) ? r : 0, k)->work += work;
    }
}

/* The last era of a known number of mutations. */
static bool eras_is_last(const plan_t *plan, uint32_t era)
{
    return plan->mutations_total > 0 && era + 1 == plan->eras.count;
}

/* Mutations of the rule that the eras before have no budgets for. */
static uint64_t eras_left(const plan_t *plan, uint32_t era)
{
    double left = plan->mutations_total;
    for (uint32_t r = 0; r < era; r++)
        for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++)
            left -= plan_mutations_of(plan, k) * (double)plan_eras_part(plan, r, k)->budget;
    return left > 0 ? (uint64_t)left : 0;
}

/* Samples in whole passes. */
static uint64_t eras_passes(const plan_t *plan, double mutations)
{
    const double pass = PLAN_SAMPLE_MUTATIONS * (double)plan->pixels;
    return plan->pixels * (uint64_t)fmax(rint(fmin(mutations, ERAS_LARGEST) / pass), 1);
}

/* All that is left, to the last mutation: of samples whole passes, of what chains leave that need some. */
static void eras_divide_last(plan_t *plan, uint32_t era, const double *shares)
{
    uint64_t left = eras_left(plan, era);
    double share_left = 0, chains = 0;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        const bool is_in = plan_eras_part(plan, era, k)->work > 0;
        share_left += is_in ? shares[k] : 0;
        chains += is_in && !plan_is_samples(plan, k) ? eras_least(plan, k) : 0;
    }
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        plan_part_t *part = plan_eras_part(plan, era, k);
        if (!(part->work > 0))
            continue;
        const double own = shares[k] >= share_left * (1 - 1e-12) ? 1 : shares[k] / share_left;
        if (plan_is_samples(plan, k)) {
            const double pass = PLAN_SAMPLE_MUTATIONS * (double)plan->pixels;
            part->budget = eras_passes(plan, fmin(own * (double)left, (double)left - chains - pass / 2));
            const uint64_t mutations = PLAN_SAMPLE_MUTATIONS * part->budget;
            left -= mutations < left ? mutations : left;
        } else {
            part->budget = own < 1 ? (uint64_t)rint(own * (double)left) : left;
            left -= part->budget;
        }
        share_left -= shares[k];
    }
}

/* Budgets by shares of all work. */
static void eras_divide(plan_t *plan, uint32_t era, const double *shares)
{
    if (eras_is_last(plan, era) && era > 0) {
        eras_divide_last(plan, era, shares);
        return;
    }
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        plan_part_t *part = plan_eras_part(plan, era, k);
        const double mutations = fmin(shares[k] * part->work, ERAS_LARGEST);
        if (!(part->work > 0))
            part->budget = 0;
        else if (plan_is_samples(plan, k))
            part->budget = eras_passes(plan, mutations);
        else
            part->budget = (uint64_t)fmax(rint(mutations), eras_least(plan, k));
    }
}

/* Shares and weights that go with the budgets. */
static void eras_weigh(plan_t *plan, uint32_t era)
{
    double all = 0;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++)
        all += plan_mutations_of(plan, k) * (double)plan_eras_part(plan, era, k)->budget;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        plan_part_t *part = plan_eras_part(plan, era, k);
        const plan_part_t *first = plan_eras_part(plan, 0, k);
        const double own = plan_mutations_of(plan, k) * (double)part->budget;
        part->due = all > 0 ? own / all : 0;
        if (part->budget == 0)
            continue;
        part->share = own / part->work;
        part->weight = part->work / (double)part->budget / (first->work / (double)first->budget);
    }
}

/* One era for all: budgets and shares as they are. */
static void eras_freeze(plan_t *plan)
{
    plan->eras.decided = 1;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        const plan_length_t *length = &plan->lengths[k];
        *plan_eras_part(plan, 0, k) = (plan_part_t){
            .work = 1, .share = length->share, .due = length->share, .weight = 1, .budget = length->budget};
    }
}

void plan_eras_begin(plan_t *plan)
{
    plan_eras_t *eras = &plan->eras;
    double shares[PATH_MAX_VERTICES] = {0};
    eras_size(plan);
    if (eras->count == 1) {
        eras_freeze(plan);
        return;
    }
    eras->decided = ERAS_AHEAD;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        eras_spread(plan, k);
        shares[k] = plan->lengths[k].share;
    }
    for (uint32_t r = 0; r < ERAS_AHEAD; r++) {
        eras_divide(plan, r, shares);
        eras_weigh(plan, r);
    }
}

/* ---- the course ---- */

static bool eras_is_handed(const plan_t *plan)
{
    if (plan_refine_is_due(plan))
        return false;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        const plan_part_t *part = plan_eras_part(plan, plan->eras.current, k);
        if (part->due > 0 && part->handed < part->budget)
            return false;
    }
    return true;
}

/* All units are made, in, and added up. */
static bool eras_is_over(const plan_t *plan, uint32_t era)
{
    const plan_era_t *one = &plan->eras.list[era];
    return (era < plan->eras.current || (era == plan->eras.current && eras_is_handed(plan))) &&
           one->in == one->units;
}

bool plan_eras_ready(plan_t *plan)
{
    plan_eras_t *eras = &plan->eras;
    while (eras_is_handed(plan)) { /* an era that no length is in is over at once */
        if (eras->current + 1 >= eras->decided && !plan_eras_decide(plan))
            return false;
        eras->current++;
    }
    return eras->current == 0 || eras->list[eras->current].units < PLAN_PENDING_MOST ||
           eras_is_over(plan, eras->current - 1);
}

bool plan_eras_spent(const plan_t *plan)
{
    return plan->eras.current + 1 == plan->eras.count && eras_is_handed(plan);
}

void plan_eras_made(plan_t *plan, plan_unit_t *unit)
{
    unit->era = (uint8_t)plan->eras.current;
    plan->eras.list[plan->eras.current].units++;
}

bool plan_eras_takes(const plan_t *plan, const plan_unit_t *unit)
{
    const plan_eras_t *eras = &plan->eras;
    return unit->era == PLAN_NO_ERA || plan->stopped || unit->era + 1U < eras->decided ||
           unit->era + 1U >= eras->count;
}

void plan_eras_took(plan_t *plan, const plan_unit_t *unit)
{
    if (unit->era != PLAN_NO_ERA)
        plan->eras.list[unit->era].in++;
}

void plan_eras_add(plan_t *plan, const plan_unit_t *unit, uint32_t k, uint64_t mutations)
{
    plan_part_t *part = plan_eras_part(plan, unit->era, k);
    part->merged += mutations;
    part->units++;
}

double plan_eras_weight(const plan_t *plan, const plan_unit_t *unit)
{
    return unit->era == PLAN_NO_ERA ? 1 : plan_eras_part(plan, unit->era, unit->record.length)->weight;
}

/* ---- decisions ---- */

/* What a mutation of lengths[k] brings to the error of the film, and its part in the errors of the b_k. A sample
 * beside chains counts for all of these: were there more, both would be less; by how much is what counts. */
static double eras_variance(const plan_t *plan, const plan_error_t *error, uint32_t k)
{
    const double counted = plan_eras_counted(plan, k), squared = plan_eras_squared(plan, k),
                 effective = squared > 0 ? counted * counted / squared : 0;
    double sum = error->lengths[k] - error->of_b[k];
    if (k > 0)
        sum += error->of_b[k] * (1 - plan_length_b_by_samples(plan, k));
    for (uint32_t i = 1; k == 0 && i <= plan->settings.max_path_length; i++) {
        const double samples = exact_value(&plan->lengths[i].samples[0].n, 1);
        sum += samples > 0 ? error->of_b[i] * plan_length_b_by_samples(plan, i) * effective / samples : 0;
    }
    return sum * effective * plan_mutations_of(plan, k);
}

/* Units that this is measured from. A single one of samples is judged by neighbouring pixels (plan_estimate.c). */
static double eras_evidence(const plan_t *plan, const plan_error_t *error, uint32_t k)
{
    const double units = plan_eras_units(plan, k), least = plan_is_samples(plan, k) && units > 0 ? 2 : 0;
    return error->relmse > 0 ? fmax(units, least) : 0;
}

/* Shares for an era, of what is measured by now. */
static void eras_choose(const plan_t *plan, uint32_t era, double *shares)
{
    const uint32_t first = plan_first(plan), last = plan_last(plan);
    shift_length_t lengths[SHIFT_MOST] = {{0}};
    double chosen[SHIFT_MOST];
    plan_error_t error;
    plan_estimate_error(plan, &error);
    for (uint32_t k = first; k <= last; k++) {
        const plan_length_t *length = &plan->lengths[k];
        const bool is_in = plan_eras_part(plan, era, k)->work > 0;
        const plan_part_t *before = plan_eras_part(plan, era - 1, k);
        shares[k] = before->work > 0 ? before->share : length->share;
        lengths[k - first] = (shift_length_t){
            .prior = is_in ? length->share : 0,
            .last = is_in ? shares[k] : 0,
            .variance = eras_variance(plan, &error, k),
            .cost = fmax((double)length->rays / fmax((double)length->merged, 1) / plan_mutations_of(plan, k), 1e-3),
            .units = eras_evidence(plan, &error, k),
            .least = fmin(length->share, ERAS_LEAST_SHARE) / 4,
        };
    }
    shift_shares(lengths, last - first + 1, chosen);
    for (uint32_t k = first; k <= last; k++)
        if (lengths[k - first].prior > 0)
            shares[k] = chosen[k - first];
}

bool plan_eras_decide(plan_t *plan)
{
    plan_eras_t *eras = &plan->eras;
    double shares[PATH_MAX_VERTICES] = {0};
    if (plan->stopped || eras->decided >= eras->count || !eras_is_over(plan, eras->decided - ERAS_AHEAD))
        return false;
    plan_nets_measure(plan);
    eras_choose(plan, eras->decided, shares);
    eras_divide(plan, eras->decided, shares);
    eras_weigh(plan, eras->decided);
    eras->decided++;
    return true;
}

/* ---- what was added up ---- */

/* Sum over eras of weight^power x mutations, or units for none. */
static double eras_sum(const plan_t *plan, uint32_t k, int power, bool units)
{
    double sum = 0;
    for (uint32_t r = 0; r < plan->eras.decided; r++) {
        const plan_part_t *part = plan_eras_part(plan, r, k);
        double term = (double)(units ? part->units : part->merged);
        for (int i = 0; i < power && term > 0; i++)
            term *= part->weight;
        sum += term;
    }
    return sum;
}

double plan_eras_counted(const plan_t *plan, uint32_t k)
{
    return eras_sum(plan, k, 1, false);
}

double plan_eras_squared(const plan_t *plan, uint32_t k)
{
    return eras_sum(plan, k, 2, false);
}

double plan_eras_units(const plan_t *plan, uint32_t k)
{
    const double squared = plan_eras_squared(plan, k);
    return squared > 0 ? eras_sum(plan, k, 1, true) * plan_eras_counted(plan, k) / squared : 0;
}

json_t *plan_eras_json(const plan_t *plan, uint32_t k)
{
    if (plan->eras.count < 2)
        return NULL;
    json_t *list = json_new_array();
    for (uint32_t r = 0; r <= plan->eras.current; r++)
        json_append(list, json_new_number(plan_eras_part(plan, r, k)->share));
    return list;
}

/* ---- bytes ---- */

void plan_eras_put(wire_writer_t *out, const plan_t *plan)
{
    wire_put_u32(out, plan->eras.decided);
    for (uint32_t r = ERAS_AHEAD; r < plan->eras.decided; r++)
        for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++)
            wire_put_u64(out, plan_eras_part(plan, r, k)->budget);
    plan_pending_put(out, &plan->eras.pending);
}

/* Budgets of one era: none where there is no work, and not more than the rule allows. */
static fault_code_t eras_get(wire_reader_t *in, plan_t *plan, uint32_t era)
{
    const uint64_t left = eras_left(plan, era);
    double sum = 0;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        plan_part_t *part = plan_eras_part(plan, era, k);
        part->budget = wire_get_u64(in, "budget");
        if (!in->code && ((part->budget > 0) != (part->work > 0) || (double)part->budget > ERAS_LARGEST))
            return wire_reader_fail(in, FAULT_RANGE, "budget", "%llu of length %u in era %u",
                                    (unsigned long long)part->budget, k, era);
        sum += plan_mutations_of(plan, k) * (double)part->budget;
    }
    if (!in->code && plan->mutations_total > 0 &&
        (eras_is_last(plan, era) ? sum != (double)left : !(sum <= (double)left)))
        return wire_reader_fail(in, FAULT_RANGE, "budget", "%g in era %u, of %llu left", sum, era,
                                (unsigned long long)left);
    eras_weigh(plan, era);
    return in->code;
}

fault_code_t plan_eras_get(wire_reader_t *in, plan_t *plan, uint64_t units)
{
    plan_eras_t *eras = &plan->eras;
    const uint32_t decided = wire_get_u32(in, "eras");
    if (!in->code && (decided > eras->count || decided < eras->decided))
        return wire_reader_fail(in, FAULT_RANGE, "eras", "%u, expected %u to %u", decided, eras->decided,
                                eras->count);
    for (uint32_t r = ERAS_AHEAD; r < decided && !in->code; r++) {
        TRY(eras_get(in, plan, r));
        eras->decided = r + 1;
    }
    return plan_pending_get(in, &eras->pending, units);
}
