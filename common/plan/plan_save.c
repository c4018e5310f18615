/* plan_save.c: a plan's sums as bytes, and back. The list of units is not stored: it is a function of job, scene
 * and pilot, and is made again; stored are which of its units are in, and what they added up to.
 *
 * Layout: u32 version; u64 units handed out, pilot units among them; u8 phase (pilot, trials, render); u8 per unit;
 * totals; then per length its sums, candidates and film; squares, of pixels and of blocks; features; groups,
 * history, stuck chains, trials, what is left out, the survey of techniques, passes that are not whole, what second
 * sequences of samples brought; in the render what the eras are and the results that wait (plan_eras.h), the
 * longest chains (plan_shorten.h). Large arrays are packed (u32 size, zstd).
 */
#include <math.h>
#include <stdlib.h>

#include "plan/packed.h"
#include "plan/plan_accuracy.h"
#include "plan/plan_budget.h"
#include "plan/plan_idle.h"
#include "plan/plan_left_out.h"
#include "plan/plan_sketch.h"
#include "plan/plan_split.h"
#include "plan/plan_state.h"
#include "plan/plan_strata.h"
#include "plan/plan_stuck.h"
#include "plan/plan_trial.h"

enum { PLAN_SAVE_VERSION = 24 };

/* b_k is what the candidates say; none is known before the pilot's end. */
static fault_code_t check_b(const plan_t *plan, wire_reader_t *in, uint32_t k)
{
    const plan_length_t *length = &plan->lengths[k];
    double b = length->b;
    if (!plan->has_candidates)
        b = 0;
    else if (plan_has_seeds(plan, k))
        b = length->weights[plan->candidates - 1] / (double)plan->candidates;
    else if (k == 0)
        b = 0;
    if (length->b != b)
        return wire_reader_fail(in, FAULT_RANGE, "b", "%g of length %u, expected %g", length->b, k, b);
    return FAULT_NONE;
}

/* Of chains of all lengths, the sums of the same weights by lengths and by candidates. */
static fault_code_t check_b_whole(const plan_t *plan, wire_reader_t *in)
{
    const double b = plan->lengths[0].b;
    double sum = 0;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        sum += plan->lengths[k].b;
    if (b != 0 && !(fabs(sum - b) <= 1e-9 * b))
        return wire_reader_fail(in, FAULT_RANGE, "b", "%g of all lengths, but theirs add up to %g", b, sum);
    return FAULT_NONE;
}

static void put_totals(wire_writer_t *out, const plan_t *plan)
{
    wire_put_f64(out, plan->seconds);
    wire_put_f64(out, plan->pilot_cpu_seconds);
    wire_put_u64(out, plan->error_next);
    wire_put_f64(out, plan->totals.cpu_seconds);
    wire_put_f64(out, plan->totals.tracing_seconds);
    wire_put_f64(out, plan->totals.inversion_seconds);
    wire_put_f64(out, plan->totals.merging_seconds);
    wire_put_f64(out, plan->totals.waiting_seconds);
    wire_put_u64(out, plan->totals.rays);
    wire_put_u64(out, plan->totals.shadow_rays);
    wire_put_u64(out, plan->totals.evaluations);
    for (int i = 0; i < WORK_REJECTS; i++)
        wire_put_u64(out, plan->totals.rejects[i]);
    const film_counts_t *counts = &plan->film_counts;
    wire_put_u64(out, counts->splats);
    wire_put_u64(out, counts->outside);
    wire_put_u64(out, counts->nonfinite);
    wire_put_u64(out, counts->negative);
    wire_put_u64(out, counts->saturated);
    plan_sketch_put(out, plan);
    plan_split_put(out, plan);
    wire_put_u32(out, plan->measurable);
}

static void get_totals(wire_reader_t *in, plan_t *plan)
{
    plan->seconds = wire_get_f64(in, "seconds");
    plan->pilot_cpu_seconds = wire_get_f64(in, "pilot_cpu_seconds");
    plan->error_next = wire_get_u64(in, "error_next");
    plan->totals.cpu_seconds = wire_get_f64(in, "cpu_seconds");
    double *const parts[] = {&plan->totals.tracing_seconds, &plan->totals.inversion_seconds,
                             &plan->totals.merging_seconds, &plan->totals.waiting_seconds};
    for (int i = 0; i < 4; i++) {
        *parts[i] = wire_get_f64(in, "parts of the time");
        if (!in->code && !(*parts[i] >= 0 && *parts[i] < 1e15))
            wire_reader_fail(in, FAULT_RANGE, "parts of the time", "%g", *parts[i]);
    }
    plan->totals.rays = wire_get_u64(in, "rays");
    plan->totals.shadow_rays = wire_get_u64(in, "shadow_rays");
    plan->totals.evaluations = wire_get_u64(in, "evaluations");
    for (int i = 0; i < WORK_REJECTS; i++)
        plan->totals.rejects[i] = wire_get_u64(in, "rejects");
    film_counts_t *counts = &plan->film_counts;
    counts->splats = wire_get_u64(in, "splats");
    counts->outside = wire_get_u64(in, "outside");
    counts->nonfinite = wire_get_u64(in, "nonfinite");
    counts->negative = wire_get_u64(in, "negative");
    counts->saturated = wire_get_u64(in, "saturated");
    plan_sketch_get(in, plan);
    plan_split_get(in, plan);
    plan->measurable = wire_get_u32(in, "measurable");
    if (!in->code && plan->measurable > plan->settings.max_path_length)
        wire_reader_fail(in, FAULT_RANGE, "measurable", "length %u, expected 0 to %u", plan->measurable,
                         plan->settings.max_path_length);
}

/* ---- saving ---- */

/* Octets of the pilot units' coarse images. */
static size_t pilot_blocks_size(const plan_t *plan)
{
    return plan->candidates / plan->candidate_unit * plan->settings.max_path_length * WORK_BLOCKS *
           sizeof *plan->pilot_blocks;
}

/* Octets of the pilot units' estimators. */
static size_t pilot_moments_size(const plan_t *plan)
{
    return plan->candidates / plan->candidate_unit * work_samples_moment(plan->settings.max_path_length + 1) *
           sizeof *plan->pilot_moments;
}

static void put_film(wire_writer_t *out, const film_t *film)
{
    uint8_t *data = NULL;
    size_t size = 0;
    if (film->sums && film_encode(film, &data, &size, out->fault))
        wire_writer_fail(out, FAULT_MEMORY, "film", "%u x %u pixels are not encoded", film->width, film->height);
    wire_put_bytes(out, "film", data, size, UINT32_MAX);
    free(data);
}

static void put_plan(wire_writer_t *out, const plan_t *plan)
{
    wire_put_u32(out, PLAN_SAVE_VERSION);
    wire_put_u64(out, plan->unit_count);
    wire_put_u64(out, plan->pilot_units);
    wire_put_u8(out, (uint8_t)(plan->has_candidates + (plan->phase != PLAN_PILOT)));
    for (uint64_t i = 0; i < plan->unit_count; i++)
        wire_put_u8(out, plan->units[i].state);
    put_totals(out, plan);
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++) {
        plan_length_put(out, &plan->lengths[k], k);
        packed_put(out, "weights", plan->lengths[k].weights, sizeof(double) * plan->candidates);
        put_film(out, &plan->lengths[k].film);
    }
    packed_put(out, "squares", plan->squares, FILM_CHANNELS * plan->pixels * sizeof *plan->squares);
    plan_strata_put(out, plan);
    packed_put(out, "features", plan->features, WORK_FEATURE_CHANNELS * plan->pixels * sizeof *plan->features);
    packed_put(out, "pilot moments", plan->pilot_moments, pilot_moments_size(plan));
    packed_put(out, "pilot blocks", plan->pilot_blocks, pilot_blocks_size(plan));
    groups_part_t groups[GROUPS_PARTS];
    groups_parts(&plan->groups, groups);
    for (int i = 0; i < GROUPS_PARTS; i++)
        packed_put(out, "groups", groups[i].data, groups[i].size);
    history_put(out, &plan->history);
    stuck_put(out, &plan->stuck);
    plan_trial_put(out, plan);
    plan_left_out_put(out, plan);
    plan_survey_put(out, plan);
    plan_passes_put(out, plan);
    plan_nets_put(out, plan);
    if (plan->phase == PLAN_RENDER) {
        plan_eras_put(out, plan);
        plan_shorten_put(out, plan);
    }
}

fault_code_t plan_save(const plan_t *plan, uint8_t **data, size_t *size, fault_t *fault)
{
    wire_writer_t out;
    wire_writer_init_growing(&out, "checkpoint", fault);
    put_plan(&out, plan);
    if (out.code)
        wire_writer_clear(&out);
    *data = out.data;
    *size = out.at;
    return out.code;
}

/* ---- restoring ---- */

static fault_code_t load_pilot_moments(plan_t *plan, wire_reader_t *in)
{
    if (plan->has_candidates) {
        free(plan->pilot_moments);
        free(plan->pilot_blocks);
        plan->pilot_moments = NULL;
        plan->pilot_blocks = NULL;
        TRY(packed_get(in, "pilot moments", NULL, 0));
        return packed_get(in, "pilot blocks", NULL, 0);
    }
    TRY(packed_get(in, "pilot moments", plan->pilot_moments, pilot_moments_size(plan)));
    for (size_t i = 0; i < pilot_moments_size(plan) / sizeof *plan->pilot_moments; i++) {
        const work_moments_t *m = &plan->pilot_moments[i];
        if (!work_moments_are_sound(m))
            return wire_reader_fail(in, FAULT_RANGE, "pilot moments", "entry %zu is negative or not finite", i);
    }
    TRY(packed_get(in, "pilot blocks", plan->pilot_blocks, pilot_blocks_size(plan)));
    for (size_t i = 0; i < pilot_blocks_size(plan) / sizeof *plan->pilot_blocks; i++)
        if (!(plan->pilot_blocks[i] >= 0) || !isfinite(plan->pilot_blocks[i]))
            return wire_reader_fail(in, FAULT_RANGE, "pilot blocks", "entry %zu is negative or not finite", i);
    return FAULT_NONE;
}

static fault_code_t load_groups(plan_t *plan, wire_reader_t *in)
{
    groups_part_t groups[GROUPS_PARTS];
    groups_parts(&plan->groups, groups);
    for (int i = 0; i < GROUPS_PARTS; i++)
        TRY(packed_get(in, "groups", groups[i].data, groups[i].size));
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++) {
        uint64_t count = 0;
        for (uint32_t g = 0; g < GROUPS_COUNT; g++)
            count += plan->groups.counts[(size_t)k * GROUPS_COUNT + g];
        if (count != plan->lengths[k].counted)
            return wire_reader_fail(in, FAULT_FORMAT, "groups", "%llu mutations of length %u, expected %llu",
                                    (unsigned long long)count, k, (unsigned long long)plan->lengths[k].counted);
    }
    return FAULT_NONE;
}

static fault_code_t load_arrays(plan_t *plan, wire_reader_t *in, fault_t *fault)
{
    const bool sums = plan->has_candidates;
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++) {
        plan_length_t *length = &plan->lengths[k];
        plan_length_get(in, length, k);
        if (in->code)
            return in->code;
        if (sums && !plan_has_seeds(plan, k)) {
            free(length->weights);
            length->weights = NULL;
        }
        TRY(packed_get(in, "weights", length->weights, sizeof(double) * plan->candidates));
        for (uint64_t i = 0; length->weights && i < plan->candidates; i++)
            if (!(length->weights[i] >= (sums && i ? length->weights[i - 1] : 0)) || !isfinite(length->weights[i]))
                return wire_reader_fail(in, FAULT_RANGE, "weights", "candidate %llu", (unsigned long long)i);
        TRY(check_b(plan, in, k));
        size_t size = 0;
        const uint8_t *film = wire_get_bytes(in, "film", UINT32_MAX, &size);
        if (in->code)
            return in->code;
        if ((size > 0) != (length->units_in > 0))
            return wire_reader_fail(in, FAULT_FORMAT, "film", "does not go with %llu units",
                                    (unsigned long long)length->units_in);
        if (size > 0) {
            TRY(film_init(&length->film, plan->settings.width, plan->settings.height, fault));
            TRY(film_decode(&length->film, film, size, fault));
        }
    }
    TRY(check_b_whole(plan, in));
    TRY(packed_get(in, "squares", plan->squares, FILM_CHANNELS * plan->pixels * sizeof *plan->squares));
    TRY(plan_strata_get(in, plan));
    TRY(packed_get(in, "features", plan->features, WORK_FEATURE_CHANNELS * plan->pixels * sizeof *plan->features));
    for (size_t i = 0; i < WORK_FEATURE_CHANNELS * plan->pixels; i++)
        if (!isfinite(plan->features[i]))
            return wire_reader_fail(in, FAULT_RANGE, "features", "number %zu is not finite", i);
    TRY(load_pilot_moments(plan, in));
    TRY(load_groups(plan, in));
    TRY(history_get(in, &plan->history));
    TRY(stuck_get(in, &plan->stuck, plan->settings.max_path_length));
    TRY(plan_stuck_check(plan, in));
    if (plan->has_candidates) { /* how many trials there are follows from them */
        TRY(plan_find_light(plan, fault));
        TRY(plan_prepare_trials(plan, fault));
    }
    plan_trial_get(in, plan);
    TRY(plan_left_out_get(in, plan));
    TRY(plan_survey_get(in, plan));
    TRY(plan_passes_get(in, plan, fault));
    TRY(plan_nets_get(in, plan, fault));
    plan_predict(plan);
    return in->code;
}

/* What the units that are in add up to, by length. */
typedef struct load_counts {
    uint64_t units[PATH_MAX_VERTICES], merged[PATH_MAX_VERTICES], counted[PATH_MAX_VERTICES];
    uint64_t open[PASSES_OPEN]; /* samples of the passes that are not whole, */
    uint64_t whole;             /* and of those that are and come in parts */
} load_counts_t;

/* Of a unit of chains or samples, or a pass of samples. */
static void load_count_one(load_counts_t *counts, plan_t *plan, const plan_unit_t *unit, uint64_t merged)
{
    const uint32_t k = unit->record.length;
    plan_eras_add(plan, unit, k, merged);
    counts->units[k]++;
    counts->merged[k] += merged;
    counts->counted[k] += (uint64_t)llround(plan_eras_weight(plan, unit) * (double)merged);
}

static void load_count(load_counts_t *counts, plan_t *plan, const plan_unit_t *unit)
{
    const work_record_t *record = &unit->record;
    plan_eras_took(plan, unit);
    if (record->kind == WORK_CHAINS) {
        load_count_one(counts, plan, unit, record->mutations);
    } else if (record->kind == WORK_SAMPLES && plan->passes.parts == 1) {
        plan_nets_count(plan, unit, record->count);
        load_count_one(counts, plan, unit, record->count);
    } else if (record->kind == WORK_SAMPLES) {
        const uint32_t open = plan_passes_find(plan, record->first / plan->pixels);
        if (open < PASSES_OPEN) {
            counts->open[open] += record->count;
            return;
        }
        plan_nets_count(plan, unit, record->count);
        counts->whole += record->count; /* whole passes, part by part: those of one are of one era */
        if (counts->whole / plan->pixels > counts->units[0])
            load_count_one(counts, plan, unit, plan->pixels);
    }
}

static fault_code_t load_check_counts(const plan_t *plan, wire_reader_t *in, const load_counts_t *counts)
{
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++) {
        const plan_length_t *length = &plan->lengths[k];
        if (counts->units[k] != length->units_in || counts->merged[k] != length->merged ||
            counts->counted[k] != length->counted)
            return wire_reader_fail(in, FAULT_FORMAT, "units_in",
                                    "%llu with %llu mutations of length %u, expected %llu with %llu",
                                    (unsigned long long)length->units_in, (unsigned long long)length->merged, k,
                                    (unsigned long long)counts->units[k], (unsigned long long)counts->merged[k]);
    }
    for (uint32_t i = 0; i < plan->passes.count; i++)
        if (counts->open[i] != plan->passes.open[i].count)
            return wire_reader_fail(in, FAULT_FORMAT, "open pass", "%llu with %llu samples, expected %llu",
                                    (unsigned long long)plan->passes.open[i].number,
                                    (unsigned long long)plan->passes.open[i].count,
                                    (unsigned long long)counts->open[i]);
    return FAULT_NONE;
}

/* Results that wait are of units that are in, and are what those ask for. */
static fault_code_t load_check_pending(const plan_t *plan, wire_reader_t *in, fault_t *fault)
{
    const plan_pending_t *pending = &plan->eras.pending;
    for (size_t i = 0; i < pending->count; i++) {
        const plan_pending_result_t *kept = &pending->results[i];
        const plan_unit_t *unit = &plan->units[kept->unit];
        work_result_t result;
        if (unit->state != PLAN_UNIT_IN || unit->era == PLAN_NO_ERA)
            return wire_reader_fail(in, FAULT_FORMAT, "pending results", "unit %llu is not one that is in",
                                    (unsigned long long)kept->unit);
        TRY(work_result_decode(&result, &unit->record, plan->settings.width, plan->settings.height,
                               plan->settings.max_path_length, NULL, kept->data, kept->size, fault));
        work_result_clear(&result);
    }
    return FAULT_NONE;
}

/* Estimators of a unit are of so many values: of none before it is in. */
static fault_code_t load_check_in(wire_reader_t *in, const char *field, double n, const uint8_t *states,
                                  uint64_t count, uint64_t unit)
{
    if ((n > 0) != (unit < count && states[unit] == PLAN_UNIT_IN))
        return wire_reader_fail(in, FAULT_FORMAT, field, "does not go with unit %llu", (unsigned long long)unit);
    return FAULT_NONE;
}

/* Makes the list of units again and marks those that are in. */
static fault_code_t load_units(plan_t *plan, wire_reader_t *in, const uint8_t *states, uint64_t count,
                               fault_t *fault)
{
    load_counts_t counts = {{0}, {0}, {0}, {0}, 0};
    const uint64_t trials = plan->pilot_units + plan->trial_units, whole = plan->phase == PLAN_RENDER ? trials
                                                                           : plan->has_candidates
                                                                               ? plan->pilot_units
                                                                               : 0;
    for (uint64_t i = 0; i < count; i++) {
        if (!plan_generate(plan))
            return wire_reader_fail(in, FAULT_FORMAT, "units", "%llu, but the job has only %llu",
                                    (unsigned long long)count, (unsigned long long)i);
        if (states[i] > PLAN_UNIT_IN || (i < whole && states[i] != PLAN_UNIT_IN))
            return wire_reader_fail(in, FAULT_FORMAT, "units", "unit %llu has state %u", (unsigned long long)i,
                                    states[i]);
        plan->units[i].state = states[i];
        if (states[i] != PLAN_UNIT_IN)
            continue;
        plan->in++;
        if (plan_pending_has(&plan->eras.pending, i))
            continue;
        load_count(&counts, plan, &plan->units[i]);
        work_record_clear(&plan->units[i].record);
    }
    for (uint64_t i = 0; i < count && i < plan->sketch_units; i++)
        plan->sketch_in += states[i] == PLAN_UNIT_IN;
    if (plan->sketch_units > 0 && plan->has_importance != (plan->sketch_in == plan->sketch_units))
        return wire_reader_fail(in, FAULT_FORMAT, "importance", "does not go with %llu of %llu sketch units",
                                (unsigned long long)plan->sketch_in, (unsigned long long)plan->sketch_units);
    const uint64_t caps = plan_stage_begin(plan, PLAN_STAGE_SPLIT);
    for (uint64_t i = caps; i < count && i < caps + plan->split_units; i++)
        plan->split_in += states[i] == PLAN_UNIT_IN;
    if (plan->split_units > 0 && plan->has_caps != (plan->split_in == plan->split_units))
        return wire_reader_fail(in, FAULT_FORMAT, "caps", "do not go with %llu of %llu units",
                                (unsigned long long)plan->split_in, (unsigned long long)plan->split_units);
    for (uint64_t i = plan->pilot_units; i < count && i < trials; i++)
        plan->trial_in += states[i] == PLAN_UNIT_IN;
    const uint64_t second = plan_stage_begin(plan, PLAN_STAGE_SURVEY_AGAIN),
                   left_out = plan_stage_begin(plan, PLAN_STAGE_LEFT_OUT);
    for (uint64_t i = 0; i < plan->left_out_units; i++)
        TRY(load_check_in(in, "left out", plan->left_out[i * WORK_LEFT_OUT_MOMENTS].n, states, count,
                          left_out + i));
    for (uint64_t i = 0; i < plan->survey_units; i++) {
        TRY(load_check_in(in, "survey", plan_survey_in(plan, 0, i), states, count, plan->sketch_units + i));
        TRY(load_check_in(in, "survey", plan_survey_in(plan, 1, i), states, count, second + i));
    }
    plan->resume = 0;
    const uint64_t next =
        plan->has_candidates ? trials : plan->pilot_units; /* units in with which the phase ends */
    if (count < whole || (plan->phase == PLAN_PILOT && plan->in == next))
        return wire_reader_fail(in, FAULT_FORMAT, "units", "%llu in do not go with the phase",
                                (unsigned long long)plan->in);
    TRY(load_check_counts(plan, in, &counts));
    TRY(plan_nets_check(in, plan));
    TRY(load_check_pending(plan, in, fault));
    return plan_settle(plan, fault);
}

static fault_code_t load_plan(plan_t *plan, wire_reader_t *in, fault_t *fault)
{
    const uint32_t version = wire_get_u32(in, "version");
    if (!in->code && version != PLAN_SAVE_VERSION)
        return wire_reader_fail(in, FAULT_VERSION, "version", "%u, expected %d", version, PLAN_SAVE_VERSION);
    const uint64_t count = wire_get_u64(in, "units"), pilot = wire_get_u64(in, "pilot units");
    const uint8_t phase = wire_get_u8(in, "phase");
    if (in->code)
        return in->code;
    if (pilot != plan->pilot_units || count > in->size || phase > 2)
        return wire_reader_fail(in, FAULT_FORMAT, "units", "%llu with %llu pilot units, expected %llu of them",
                                (unsigned long long)count, (unsigned long long)pilot,
                                (unsigned long long)plan->pilot_units);
    const uint8_t *states = wire_get_raw(in, "states", count);
    if (!states)
        return in->code;
    get_totals(in, plan);
    if (!in->code && !(plan->seconds >= 0 && plan->seconds < 1e12 && plan->totals.cpu_seconds >= 0 &&
                       plan->totals.cpu_seconds < 1e15 && plan->pilot_cpu_seconds >= 0 &&
                       plan->pilot_cpu_seconds <= plan->totals.cpu_seconds))
        return wire_reader_fail(in, FAULT_RANGE, "seconds", "%g, of pilot %g, of processors %g", plan->seconds,
                                plan->pilot_cpu_seconds, plan->totals.cpu_seconds);
    plan->has_candidates = phase > 0;
    plan->phase = phase > 1 ? PLAN_RENDER : PLAN_PILOT;
    TRY(load_arrays(plan, in, fault));
    if (plan->phase == PLAN_RENDER) {
        plan_finish_trials(plan);
        plan_size_render(plan);
        TRY(plan_eras_get(in, plan, count));
        TRY(plan_shorten_get(in, plan));
    }
    TRY(wire_reader_end(in));
    return load_units(plan, in, states, count, fault);
}

fault_code_t plan_restore(plan_t **out, const job_t *job, const scene_t *scene, const uint8_t *data, size_t size,
                          fault_t *fault)
{
    TRY(plan_new(out, job, scene, fault));
    wire_reader_t in;
    wire_reader_init(&in, data, size, "checkpoint", fault);
    const fault_code_t code = load_plan(*out, &in, fault);
    if (code)
        plan_destroy(out);
    return code;
}
