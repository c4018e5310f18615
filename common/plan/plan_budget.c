/* plan_budget.c: how much of what, in which order: a function of job and scene alone. */
#include "plan/plan_budget.h"

#include <stdlib.h>
#include <string.h>

#include "plan/plan_estimate.h"
#include "plan/plan_idle.h"
#include "plan/plan_left_out.h"
#include "plan/plan_missed.h"
#include "plan/plan_seeds.h"
#include "plan/plan_sketch.h"
#include "plan/plan_split.h"

enum {
    PILOT_UNIT = 8192, /* candidates: some ten milliseconds; */
    PILOT_PARTS = 8,   /* of a short pilot an eighth, */
    PILOT_SMALLEST = 256,
    PILOT_ASIDE = 4096, /* samples for each choice that comes before the candidates, or an eighth of those */
    PILOT_LEAST = 2048,
    PILOT_USUAL = 1 << 17,
    PILOT_MOST = 1 << 19,
    REFINE_PARTS = 20,     /* one part in so many of the work goes on refining b_k */
    CHAIN_USUAL = 1 << 14, /* mutations a chain */
    UNIT_LEAST = 1 << 14,
    UNIT_SMALLEST = 1 << 20,
    UNIT_LARGEST = 1 << 23, /* mutations a unit: packing its film must cost little beside them */
    EARLY_PARTS = 8,        /* of a unit: the first few of a length */
    UNITS_LEAST = 16,       /* a length, so that its variance can be estimated */
    UNITS_TIMED = 64,       /* that a rule of seconds leaves room for on one slow worker */
    FEATURE_SIDE = 2,       /* rays along a pixel's side */
    FEATURE_RAYS = 1 << 16  /* a unit: of a small image some, as they fill gaps */
};

static uint64_t at_least(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

static uint64_t at_most(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

/* Mutations that cost as much as a bidirectional sample: where chains join all, each makes one. */
static uint32_t budget_sample(const plan_t *plan)
{
    return settings_joins_all(plan->settings.algorithm) ? 1 : PLAN_SAMPLE_MUTATIONS;
}

bool plan_has_room(const plan_t *plan, uint32_t passes)
{
    return plan->mutations_total == 0 ||
           plan->mutations_total >= passes * PLAN_SAMPLE_MUTATIONS * (double)plan->pixels;
}

/* Samples for each of the choices that the candidates wait for, sketch and split. They are no candidates, so they
 * should be few; but by less than thousands nothing is chosen well, and most of a short pilot is theirs. */
static uint64_t pilot_aside(const plan_t *plan)
{
    return at_least(plan->candidates / PILOT_PARTS, at_most(plan->candidates, PILOT_ASIDE));
}

static uint64_t pilot_units(const plan_t *plan, uint64_t samples)
{
    return (samples + plan->pilot_unit - 1) / plan->pilot_unit;
}

/* A grid of rays in each pixel, or a single one where the grid's were half of the time of a worker. */
static void budget_features(plan_t *plan)
{
    const settings_t *s = &plan->settings;
    const double seconds = plan->job.stop.seconds,
                 rays = FEATURE_SIDE * FEATURE_SIDE * (double)plan->pixels; /* one costs half a mutation, or less */
    plan->feature_side = seconds > 0 && rays > seconds * PLAN_USUAL_RATE ? 1 : FEATURE_SIDE;
    const uint64_t row = plan->feature_side * plan->feature_side * (uint64_t)s->width;
    plan->feature_rows = (uint32_t)at_most(at_least(FEATURE_RAYS / row, 1), s->height);
}

void plan_size_pilot(plan_t *plan)
{
    const settings_t *s = &plan->settings;
    const job_stop_t *stop = &plan->job.stop;
    plan->mutations_total =
        stop->mutations_per_pixel > 0 ? ceil(stop->mutations_per_pixel * (double)plan->pixels) : 0;
    if (!plan_is_chains(plan)) /* whole passes over the image */
        plan->mutations_total = ceil(stop->mutations_per_pixel) * (double)plan->pixels;
    double candidates = PILOT_USUAL;
    if (!plan_is_chains(plan))
        candidates = PLAN_SCALE_CANDIDATES;
    else if (plan->mutations_total > 0) /* a tenth of the work */
        candidates = plan->mutations_total / (10 * budget_sample(plan));
    else if (stop->seconds > 0) /* a tenth of the time of one worker, at sixty thousand a second */
        candidates = stop->seconds * 6e3;
    if (candidates > PILOT_MOST)
        candidates = PILOT_MOST;
    plan->candidates = at_least((uint64_t)candidates, PILOT_LEAST);
    if (s->pilot_samples > 0)
        plan->candidates = s->pilot_samples;
    const uint64_t part = (plan->candidates + PILOT_PARTS - 1) / PILOT_PARTS;
    plan->pilot_unit = (uint32_t)at_most(at_least(part, PILOT_SMALLEST), PILOT_UNIT);
    const uint64_t units = pilot_units(plan, plan->candidates), aside = pilot_units(plan, pilot_aside(plan));
    plan->candidates = units * plan->pilot_unit;
    plan->candidate_unit = plan->pilot_unit;
    budget_features(plan);
    plan->sketch_units = plan_wants_sketch(plan) ? aside : 0;
    plan->split_units = plan_has_room(plan, 1) && plan_wants_split(plan) ? aside : 0;
    plan->left_out_units = plan_left_out_size(plan);
    plan->survey_units = plan_survey_size(plan);
    plan->pilot_units = plan_stage_begin(plan, PLAN_STAGES);
}

static void features_record(const plan_t *plan, uint64_t index, work_record_t *record)
{
    record->kind = WORK_FEATURES;
    record->side = plan->feature_side;
    record->first = index * plan->feature_rows;
    record->count = at_most(plan->feature_rows, plan->settings.height - record->first);
}

/* Units of a stage. */
static uint64_t stage_units(const plan_t *plan, plan_stage_t stage)
{
    const uint64_t features = (plan->settings.height + plan->feature_rows - 1) / plan->feature_rows;
    switch (stage) {
    case PLAN_STAGE_SKETCH:
        return plan->sketch_units;
    case PLAN_STAGE_SURVEY:
    case PLAN_STAGE_SURVEY_AGAIN:
        return plan->survey_units;
    case PLAN_STAGE_FEATURES:
    case PLAN_STAGE_FEATURES_AGAIN:
        return features / 3;
    case PLAN_STAGE_FEATURES_LAST:
        return features - 2 * (features / 3);
    case PLAN_STAGE_LEFT_OUT:
        return plan->left_out_units;
    case PLAN_STAGE_SPLIT:
        return plan->split_units;
    default:
        return plan->candidates / plan->candidate_unit;
    }
}

uint64_t plan_stage_begin(const plan_t *plan, plan_stage_t stage)
{
    uint64_t begin = 0;
    for (uint32_t earlier = 0; earlier < stage; earlier++)
        begin += stage_units(plan, (plan_stage_t)earlier);
    return begin;
}

/* What a stage's units are told of the stages before. */
static fault_code_t pilot_set_found(const plan_t *plan, bool caps, work_record_t *record)
{
    TRY(plan_set_importance(plan, record, NULL));
    TRY(plan_set_idle(plan, record, NULL));
    return caps ? plan_set_caps(plan, record, NULL) : FAULT_NONE;
}

fault_code_t plan_pilot_record(const plan_t *plan, uint64_t index, work_record_t *record)
{
    plan_stage_t stage = PLAN_STAGE_SKETCH;
    while (stage + 1 < PLAN_STAGES && index >= stage_units(plan, stage))
        index -= stage_units(plan, stage++);
    *record = (work_record_t){0};
    switch (stage) {
    case PLAN_STAGE_SKETCH:
        plan_sketch_record(plan, index, record);
        return FAULT_NONE;
    case PLAN_STAGE_SURVEY:
    case PLAN_STAGE_SURVEY_AGAIN:
        return plan_survey_record(plan, stage == PLAN_STAGE_SURVEY_AGAIN, index, record);
    case PLAN_STAGE_FEATURES:
        features_record(plan, index, record);
        return FAULT_NONE;
    case PLAN_STAGE_FEATURES_AGAIN:
        features_record(plan, index + stage_units(plan, PLAN_STAGE_FEATURES), record);
        return FAULT_NONE;
    case PLAN_STAGE_FEATURES_LAST:
        features_record(plan, index + 2 * stage_units(plan, PLAN_STAGE_FEATURES), record);
        return FAULT_NONE;
    case PLAN_STAGE_LEFT_OUT:
        plan_left_out_record(index, record);
        return FAULT_NONE;
    case PLAN_STAGE_SPLIT:
        plan_split_record(plan, index, record);
        return pilot_set_found(plan, false, record);
    default:
        record->kind = WORK_PILOT;
        record->first = index * plan->candidate_unit;
        record->count = plan->candidate_unit;
        return pilot_set_found(plan, true, record);
    }
}

/* Whether the next unit is the first of a stage. */
static bool pilot_is_at(const plan_t *plan, plan_stage_t stage)
{
    return plan->pilot_next == plan_stage_begin(plan, stage) && stage_units(plan, stage) > 0;
}

bool plan_pilot_waits(const plan_t *plan)
{
    const bool candidates = pilot_is_at(plan, PLAN_STAGE_CANDIDATES),
               found = (plan->sketch_units == 0 || plan->has_importance) && plan_survey_has(plan, 1);
    return (pilot_is_at(plan, PLAN_STAGE_SURVEY_AGAIN) && !plan_survey_has(plan, 0)) ||
           ((candidates || pilot_is_at(plan, PLAN_STAGE_SPLIT)) && !found) ||
           (candidates && plan->split_units > 0 && !plan->has_caps);
}

/* Each walk is half a path in the mean: measured on the scenes of docs/benchmarks.md, 0.3 to 0.5 (k + 2). Times are
 * not measured, as the list of units must not depend on clocks. */
double plan_usual_cost(uint32_t k)
{
    return 0.4 * (2 + (double)k);
}

/* Shares of the mutations. A pixel's variance by length k is about b_k I_k / N_k, relative to the pixel's square as
 * the error is: sum_k b_k need_k / N_k. At a fixed cost sum_k c_k N_k the least is where N_k is in proportion to
 * sqrt(b_k need_k / c_k). That is a coarse image's word, and knows nothing of how mutations of a length hang
 * together, which trials do (plan_trial.c): with them it is times their inefficiency. A part of the shares
 * goes by energy, and no length that is sure to carry light gets less than half a percent. */
void plan_shares(plan_t *plan)
{
    const double least = 0.005, by_energy = 0.1;
    double sum = 0, needs = 0, need[PATH_MAX_VERTICES] = {0};
    if (plan_is_whole(plan)) {
        plan->lengths[0].share = 1;
        return;
    }
    if (plan->split_samples > 0) {
        plan_split_shares(plan);
        return;
    }
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        const plan_length_t *length = &plan->lengths[k];
        const double variance = length->b * length->need * length->inefficiency;
        needs += need[k] = sqrt(variance / length->cost);
    }
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        plan_length_t *length = &plan->lengths[k];
        const double own = needs > 0 ? need[k] / needs : 0;
        length->share = length->b > 0 ? fmax(by_energy * length->b / plan->b + (1 - by_energy) * own,
                                             plan_least_share(plan, k, least))
                                      : 0;
        sum += length->share;
    }
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        plan_length_t *length = &plan->lengths[k];
        length->share /= sum;
    }
}

/* Samples beside chains: whole passes over the image, one at least; a tenth of the work or more is left to chains,
 * if there are any. */
static uint64_t budget_passes(const plan_t *plan)
{
    const double all = plan->mutations_total / (PLAN_SAMPLE_MUTATIONS * (double)plan->pixels),
                 most = plan->samples_alone ? rint(all) : floor(0.9 * all);
    return plan->pixels * at_least((uint64_t)fmin(rint(plan->lengths[0].share * all), most), 1);
}

/* Divides the rule's mutations among the lengths, to the last one. */
static void budget_total(plan_t *plan)
{
    uint64_t left = (uint64_t)plan->mutations_total, first = plan_first(plan);
    double share_left = 1;
    if (plan_splits(plan)) {
        plan_length_t *samples = &plan->lengths[first++];
        samples->budget = plan->mutations_total > 0 && samples->share > 0 ? budget_passes(plan) : UINT64_MAX;
        if (samples->budget != UINT64_MAX)
            left -= at_most(PLAN_SAMPLE_MUTATIONS * samples->budget, left);
        share_left -= samples->share;
    }
    for (uint32_t k = (uint32_t)first; k <= plan_last(plan); k++) {
        plan_length_t *length = &plan->lengths[k];
        length->budget = plan->mutations_total > 0 ? 0 : UINT64_MAX;
        if (length->share == 0 || plan->mutations_total == 0)
            continue;
        const double part = share_left > 0 ? length->share / share_left : 1;
        length->budget = part >= 1 - 1e-12 ? left : at_most(left, (uint64_t)llround(part * (double)left));
        left -= length->budget;
        share_left -= length->share;
    }
}

/* Parts of about `unit`, so that the last one is about as large as the others. */
static uint64_t budget_even(uint64_t budget, uint64_t unit)
{
    const uint64_t parts = budget / at_least(unit, 1) + (budget % at_least(unit, 1) > 0);
    return at_least((budget + parts - 1) / at_least(parts, 1), 1);
}

/* Samples a unit: whole passes over the image, as each pixel has then the same share of every unit: else the
 * variance between units would be that of the pixel's share as well. (What is one unit here may be made in parts:
 * plan_passes.h.) */
static uint64_t budget_samples(const plan_t *plan, uint64_t budget)
{
    const uint64_t passes = budget / plan->pixels;
    const uint64_t usual = (UNIT_LEAST + plan->pixels - 1) / plan->pixels;
    return plan->pixels * at_least(at_most(usual, passes / UNITS_LEAST), 1);
}

uint64_t plan_chain_length(const plan_t *plan)
{
    return plan->settings.chain_length ? plan->settings.chain_length : CHAIN_USUAL;
}

/* Whole ensembles, of shorter chains if need be. */
static uint64_t budget_chains(const plan_t *plan, uint64_t mutations, uint64_t chain)
{
    const uint64_t chains = at_most(at_least((mutations + chain / 2) / chain, 1), WORK_MAX_CHAINS),
                   together = work_together(plan->settings.algorithm);
    return (chains + together - 1) / together * together;
}

static void budget_units(plan_t *plan)
{
    uint64_t usual = at_most(at_least(2 * plan->pixels, UNIT_SMALLEST), UNIT_LARGEST);
    const double seconds = plan->job.stop.seconds;
    if (seconds > 0 && seconds < 1e6) /* a short render is cut finer: for its error, and to end in time */
        usual = at_most(usual, at_least((uint64_t)(seconds * PLAN_USUAL_RATE / UNITS_TIMED), UNIT_LEAST));
    if (plan_is_whole(plan)) /* as long in time */
        usual = at_least(usual / PLAN_SAMPLE_MUTATIONS, UNIT_LEAST);
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        plan_length_t *length = &plan->lengths[k];
        if (plan_is_samples(plan, k)) {
            length->unit_mutations = budget_samples(plan, length->budget);
            continue;
        }
        uint64_t mutations = usual;
        if (length->share * 8 < 1) /* a length of little energy: smaller units, so that it has some */
            mutations = at_least((uint64_t)((double)usual * length->share * 8), UNIT_LEAST);
        if (length->budget != UINT64_MAX)
            mutations = budget_even(length->budget, at_most(mutations, length->budget / UNITS_LEAST));
        length->unit_mutations = mutations;
        length->early_mutations =
            at_most(mutations, at_least(mutations / EARLY_PARTS, at_least(plan->pixels / EARLY_PARTS, UNIT_LEAST)));
    }
}

fault_code_t plan_find_light(plan_t *plan, fault_t *fault)
{
    plan->b = 0;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        plan->b += plan_splits(plan) ? plan->lengths[k].light : plan->lengths[k].b;
    if (!(plan->b > 0))
        return fault_set(
            fault, FAULT_NO_LIGHT,
            "no light reaches the camera: none of %llu candidates carries any, over path lengths 1 to %u",
            (unsigned long long)plan->candidates, plan->settings.max_path_length);
    plan->scale = exp2(-rint(log2(plan->b)));
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        plan->lengths[k].inefficiency = plan->settings.split > 0 ? plan->settings.split : 1;
        plan->lengths[k].cost = plan_usual_cost(k);
    }
    return FAULT_NONE;
}

void plan_size_render(plan_t *plan)
{
    plan_shares(plan);
    budget_total(plan);
    budget_units(plan);
    plan_passes_init(plan);
    plan_shorten_init(plan);
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++)
        if (plan->lengths[k].share > 0)
            plan->weight_max = fmax(plan->weight_max, plan_weight(plan, k));
    plan_eras_begin(plan);
}

/* Where a technique's energy is small its share is not quite: what it alone can change would wait for too long. */
void plan_freeze_techniques(plan_t *plan)
{
    const double least = 0.1;
    if (!settings_wants_shares(plan->settings.algorithm))
        return;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        plan_length_t *length = &plan->lengths[k];
        double sum = 0, taking = 0, error;
        for (uint32_t s = 0; s <= k; s++)
            taking += !target_is_idle(&plan->idle[k - 1], s);
        for (uint32_t s = 0; s <= k; s++)
            sum += length->techniques[s] = plan_technique_b(plan, k, s, &error);
        for (uint32_t s = 0; s <= k && sum > 0; s++)
            length->techniques[s] = (1 - least) * length->techniques[s] / sum +
                                    (target_is_idle(&plan->idle[k - 1], s) ? 0 : least / taking);
    }
}

/* Of all eras. */
static double budget_handed(const plan_t *plan)
{
    double handed = 0;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++)
        handed += plan_mutations_of(plan, k) * (double)plan->lengths[k].handed;
    return handed;
}

/* The length that lags most behind what is due of the era; before all of them those that have had no unit at all,
 * so that there is an image early. 0 (which has no share where lengths have theirs) if none is left. */
static uint32_t budget_neediest(const plan_t *plan)
{
    double handed = 0, need = -INFINITY;
    uint32_t neediest = 0;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++)
        handed += plan_mutations_of(plan, k) * (double)plan_eras_part(plan, plan->eras.current, k)->handed;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        const plan_length_t *length = &plan->lengths[k];
        const plan_part_t *part = plan_eras_part(plan, plan->eras.current, k);
        if (part->due == 0 || part->handed >= part->budget)
            continue;
        const uint64_t first = plan_is_samples(plan, k) ? plan->pixels : 1; /* or less: a part of a pass */
        const double unit = plan_mutations_of(plan, k) * (double)length->unit_mutations,
                     own = plan_mutations_of(plan, k) * (double)part->handed,
                     lag = length->handed < first ? INFINITY : (part->due * (handed + unit) - own) / unit;
        if (lag > need) {
            need = lag;
            neediest = k;
        }
    }
    return neediest;
}

bool plan_refine_is_due(const plan_t *plan)
{
    if (!plan_is_chains(plan) || (plan_splits(plan) && plan->lengths[0].share > 0)) /* its samples do that */
        return false;
    const double due = budget_handed(plan) / (REFINE_PARTS * budget_sample(plan));
    return due >= (double)(plan->refine_handed + PILOT_UNIT);
}

static bool refine_record(plan_t *plan, work_record_t *record)
{
    *record = (work_record_t){.kind = WORK_REFINE, .first = plan->refine_handed, .count = PILOT_UNIT};
    if (plan_set_importance(plan, record, NULL) || plan_set_caps(plan, record, NULL) ||
        plan_set_idle(plan, record, NULL)) {
        work_record_clear(record);
        return false;
    }
    plan->refine_handed += PILOT_UNIT;
    return true;
}

bool plan_chains_record(const plan_t *plan, work_kind_t kind, uint32_t k, uint64_t first, uint64_t chains,
                        uint64_t mutations, plan_steps_t steps, work_record_t *record)
{
    const bool shares = settings_wants_shares(plan->settings.algorithm);
    *record = (work_record_t){.kind = kind,
                              .length = k,
                              .first = first,
                              .count = chains,
                              .mutations = mutations,
                              .steps = steps.steps,
                              .large = steps.large,
                              .seeds = malloc(sizeof(uint64_t) * chains),
                              .shares = shares ? malloc(sizeof(double) * (k + 1)) : NULL};
    if (!record->seeds || (shares && !record->shares) || plan_set_importance(plan, record, NULL) ||
        plan_set_caps(plan, record, NULL) || plan_set_idle(plan, record, NULL)) {
        work_record_clear(record);
        return false;
    }
    if (shares)
        memcpy(record->shares, plan->lengths[k].techniques, sizeof(double) * (k + 1));
    for (uint64_t i = 0; i < chains; i++)
        record->seeds[i] = plan_seed(plan, k, first + i);
    return true;
}

/* Mutations or samples of the next unit of lengths[k]. Where there are eras, their parts are cut evenly: what is
 * left of one would be a small unit each time. */
static uint64_t budget_next(const plan_t *plan, uint32_t k, bool early)
{
    const plan_length_t *length = &plan->lengths[k];
    const plan_part_t *part = plan_eras_part(plan, plan->eras.current, k);
    const uint64_t left = part->budget - part->handed, pass = plan_is_samples(plan, k) ? plan->pixels : 1;
    uint64_t unit = early ? length->early_mutations : length->unit_mutations;
    if (plan->eras.count > 1)
        unit = pass * budget_even(left / pass, unit / pass);
    return at_most(unit, left);
}

bool plan_render_record(plan_t *plan, plan_unit_t *unit)
{
    work_record_t *record = &unit->record;
    *record = (work_record_t){0};
    if (plan_refine_is_due(plan))
        return refine_record(plan, record);
    const uint32_t k = budget_neediest(plan);
    plan_length_t *length = &plan->lengths[k];
    plan_part_t *part = plan_eras_part(plan, plan->eras.current, k);
    if (part->due == 0 || part->handed >= part->budget)
        return false;
    const bool early = length->units_out < PLAN_EARLY && !plan_is_samples(plan, k);
    uint64_t count = budget_next(plan, k, early);
    if (plan_is_samples(plan, k)) {
        if (plan_passes_wait(plan))
            return false;
        *record = (work_record_t){.kind = WORK_SAMPLES, .count = count, .scale = plan->scale};
        plan_passes_place(plan, record);
        plan_nets_place(plan, record);
        count = record->count;
        if (plan_set_importance(plan, record, NULL) || plan_set_caps(plan, record, NULL) ||
            plan_set_idle(plan, record, NULL)) {
            work_record_clear(record);
            return false;
        }
    } else {
        const uint64_t chains = at_most(budget_chains(plan, count, plan_shorten_chain(plan, k)), count);
        if (!plan_chains_record(plan, WORK_CHAINS, k, length->chains, chains, count, length->steps, record))
            return false;
        length->chains += chains;
    }
    unit->number = length->units_out++;
    length->handed += count;
    part->handed += count;
    return true;
}
