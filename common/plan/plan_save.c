/* plan_save.c: a plan's sums as bytes, and back. The list of units is not stored: it is a function of job, scene
 * and pilot, and is made again; stored are which of its units are in, and what they added up to.
 *
 * Layout: u32 version; u64 units handed out, pilot units among them; u8 phase (pilot, trials, render); u8 per unit;
 * totals; then per length its sums, candidates and film; squares, of pixels and (chains) of blocks; features;
 * groups, history, stuck chains and trials. Large arrays are packed (u32 size, zstd).
 */
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

#include "base/wire.h"
#include "plan/plan_state.h"

enum { PLAN_SAVE_VERSION = 10 };

/* ---- arrays ---- */

typedef struct save_packed {
    uint8_t *data;
    size_t size;
} save_packed_t;

static fault_code_t save_pack(const void *from, size_t size, save_packed_t *out, fault_t *fault)
{
    const size_t room = ZSTD_compressBound(size);
    out->data = malloc(room);
    if (!out->data)
        return fault_set(fault, FAULT_MEMORY, "checkpoint: no memory for %zu octets", room);
    out->size = ZSTD_compress(out->data, room, from, size, 1);
    if (ZSTD_isError(out->size))
        return fault_set(fault, FAULT_MEMORY, "checkpoint: zstd: %s", ZSTD_getErrorName(out->size));
    return FAULT_NONE;
}

static fault_code_t load_packed(wire_reader_t *in, const char *field, void *to, size_t size)
{
    size_t packed = 0;
    const uint8_t *data = wire_get_bytes(in, field, UINT32_MAX, &packed);
    if (!data)
        return in->code;
    if (ZSTD_decompress(to, size, data, packed) != size)
        return wire_reader_fail(in, FAULT_FORMAT, field, "does not unpack to %zu octets", size);
    return FAULT_NONE;
}

/* ---- scalars ---- */

static void put_exact(wire_writer_t *out, const exact_sum_t *sum)
{
    const exact_uint_t bits = (exact_uint_t)sum->value;
    wire_put_u64(out, (uint64_t)bits);
    wire_put_u64(out, (uint64_t)(bits >> 64));
}

static void get_exact(wire_reader_t *in, exact_sum_t *sum)
{
    const uint64_t low = wire_get_u64(in, "sum"), high = wire_get_u64(in, "sum");
    sum->value = (exact_int_t)((exact_uint_t)high << 64 | low);
}

static void put_moments(wire_writer_t *out, const plan_moments_t *moments)
{
    wire_put_f64(out, moments->n);
    put_exact(out, &moments->sum);
    put_exact(out, &moments->sum2);
}

static void get_moments(wire_reader_t *in, plan_moments_t *moments)
{
    moments->n = wire_get_f64(in, "moments");
    get_exact(in, &moments->sum);
    get_exact(in, &moments->sum2);
    if (!in->code &&
        (!(moments->n >= 0) || !isfinite(moments->n) || moments->sum.value < 0 || moments->sum2.value < 0))
        wire_reader_fail(in, FAULT_RANGE, "moments", "are negative or not finite");
}

static void put_length(wire_writer_t *out, const plan_length_t *length, uint32_t k)
{
    wire_put_f64(out, length->b);
    wire_put_f64(out, length->need);
    wire_put_f64(out, length->light);
    wire_put_u64(out, length->units_in);
    wire_put_u64(out, length->merged);
    wire_put_u64(out, length->zero_proposals);
    wire_put_u64(out, length->longest_stay);
    wire_put_u64(out, length->stuck_rejections);
    wire_put_f64(out, length->cpu_seconds);
    for (int i = 0; i < WORK_MOVES; i++) {
        wire_put_u64(out, length->proposed[i]);
        put_exact(out, &length->accepted[i]);
    }
    for (int i = 0; i < WORK_FAILED_BLOCKS; i++)
        wire_put_u64(out, length->failed[i]);
    for (uint32_t s = 0; s <= k; s++)
        wire_put_f64(out, length->techniques[s]);
    for (uint32_t i = 0; i <= k + 1; i++) {
        put_moments(out, &length->samples[i]);
        put_moments(out, &length->large_steps[i]);
    }
}

static void get_length(wire_reader_t *in, plan_length_t *length, uint32_t k)
{
    length->b = wire_get_f64(in, "b");
    length->need = wire_get_f64(in, "need");
    if (!in->code && (!(length->need >= 0) || !isfinite(length->need)))
        wire_reader_fail(in, FAULT_RANGE, "need", "%g", length->need);
    length->light = wire_get_f64(in, "light");
    if (!in->code && (!(length->light >= 0) || !isfinite(length->light)))
        wire_reader_fail(in, FAULT_RANGE, "light", "%g", length->light);
    length->units_in = wire_get_u64(in, "units_in");
    length->merged = wire_get_u64(in, "merged");
    length->zero_proposals = wire_get_u64(in, "zero_proposals");
    length->longest_stay = wire_get_u64(in, "longest_stay");
    length->stuck_rejections = wire_get_u64(in, "stuck rejections");
    length->cpu_seconds = wire_get_f64(in, "cpu_seconds");
    for (int i = 0; i < WORK_MOVES; i++) {
        length->proposed[i] = wire_get_u64(in, "proposed");
        get_exact(in, &length->accepted[i]);
    }
    for (int i = 0; i < WORK_FAILED_BLOCKS; i++)
        length->failed[i] = wire_get_u64(in, "failed");
    double sum = 0;
    for (uint32_t s = 0; s <= k; s++) {
        length->techniques[s] = wire_get_f64(in, "techniques");
        sum += length->techniques[s];
        if (!in->code && !(length->techniques[s] >= 0))
            wire_reader_fail(in, FAULT_RANGE, "techniques", "%g", length->techniques[s]);
    }
    if (!in->code && !(sum == 0 || fabs(sum - 1) < 1e-9))
        wire_reader_fail(in, FAULT_RANGE, "techniques", "their sum is %g, expected 0 or 1", sum);
    for (uint32_t i = 0; i <= k + 1; i++) {
        get_moments(in, &length->samples[i]);
        get_moments(in, &length->large_steps[i]);
    }
    if (!in->code && length->zero_proposals > length->merged)
        wire_reader_fail(in, FAULT_RANGE, "zero_proposals", "more than the mutations");
    if (!in->code && (!(length->b >= 0) || !isfinite(length->b)))
        wire_reader_fail(in, FAULT_RANGE, "b", "%g", length->b);
    if (!in->code && !(length->cpu_seconds >= 0 && length->cpu_seconds < 1e15))
        wire_reader_fail(in, FAULT_RANGE, "cpu_seconds", "%g", length->cpu_seconds);
    for (int i = 0; i < WORK_MOVES && !in->code; i++)
        if (length->accepted[i].value < 0)
            wire_reader_fail(in, FAULT_RANGE, "accepted", "is negative");
}

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

static void put_split(wire_writer_t *out, const plan_t *plan)
{
    for (uint32_t k = 0; k < plan->settings.max_path_length; k++)
        wire_put_u64(out, plan->split_rays[k]);
    wire_put_u8(out, plan->has_caps);
    if (!plan->has_caps)
        return;
    wire_put_f64(out, plan->split_samples);
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        wire_put_f64(out, plan->caps[k - 1]);
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        wire_put_f64(out, plan->rates[k - 1]);
}

static void get_split(wire_reader_t *in, plan_t *plan)
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
    plan->split_samples = wire_get_f64(in, "split samples");
    if (!in->code && (!(plan->split_samples >= 0) || !isfinite(plan->split_samples)))
        wire_reader_fail(in, FAULT_RANGE, "split samples", "%g", plan->split_samples);
    for (uint32_t k = 1; k <= plan->settings.max_path_length && !in->code; k++) {
        plan->caps[k - 1] = wire_get_f64(in, "caps");
        if (!in->code && !(plan->caps[k - 1] >= 0))
            wire_reader_fail(in, FAULT_RANGE, "caps", "%g", plan->caps[k - 1]);
    }
    for (uint32_t k = 1; k <= plan->settings.max_path_length && !in->code; k++) {
        plan->rates[k - 1] = wire_get_f64(in, "rates");
        if (!in->code && !(plan->rates[k - 1] > 0 && plan->rates[k - 1] <= (k > 1 ? plan->rates[k - 2] : 1)))
            wire_reader_fail(in, FAULT_RANGE, "rates", "%g", plan->rates[k - 1]);
    }
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
    wire_put_u8(out, plan->has_importance);
    for (int i = 0; plan->has_importance && i < IMPORTANCE_BLOCKS; i++)
        wire_put_f64(out, plan->importance[i]);
    put_split(out, plan);
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
    const uint8_t has_importance = wire_get_u8(in, "importance");
    if (!in->code && (has_importance > 1 || (has_importance && plan->sketch_units == 0)))
        wire_reader_fail(in, FAULT_FORMAT, "importance", "%u, of a job %s sketch", has_importance,
                         plan->sketch_units ? "with a" : "without");
    plan->has_importance = !in->code && has_importance;
    for (int i = 0; plan->has_importance && i < IMPORTANCE_BLOCKS && !in->code; i++) {
        plan->importance[i] = wire_get_f64(in, "importance");
        if (!in->code && !(plan->importance[i] >= 1e-3 && plan->importance[i] <= 1e3))
            wire_reader_fail(in, FAULT_RANGE, "importance", "%g, expected 0.001 to 1000", plan->importance[i]);
    }
    get_split(in, plan);
}

static void put_history(wire_writer_t *out, const plan_history_t *history)
{
    wire_put_u32(out, history->count);
    for (uint32_t i = 0; i < history->count; i++) {
        const plan_point_t *point = &history->points[i];
        wire_put_f64(out, point->seconds);
        wire_put_f64(out, point->cpu_seconds);
        wire_put_f64(out, point->mutations);
        wire_put_f64(out, point->relmse);
        wire_put_f64(out, point->spread);
    }
}

static fault_code_t get_history(wire_reader_t *in, plan_history_t *history)
{
    const uint32_t count = wire_get_u32(in, "history");
    if (!in->code && count > PLAN_HISTORY)
        return wire_reader_fail(in, FAULT_RANGE, "history", "%u points, expected at most %d", count, PLAN_HISTORY);
    for (uint32_t i = 0; i < count && !in->code; i++) {
        plan_point_t point;
        point.seconds = wire_get_f64(in, "history");
        point.cpu_seconds = wire_get_f64(in, "history");
        point.mutations = wire_get_f64(in, "history");
        point.relmse = wire_get_f64(in, "history");
        point.spread = wire_get_f64(in, "history");
        plan_history_add(history, &point);
        if (!in->code &&
            (history->count != i + 1 || !(point.seconds >= 0 && point.cpu_seconds >= 0 && point.mutations >= 0)))
            return wire_reader_fail(in, FAULT_RANGE, "history", "point %u is negative, or not after the one before",
                                    i);
    }
    return in->code;
}

static void put_trials(wire_writer_t *out, const plan_t *plan)
{
    wire_put_u64(out, plan->trial_units);
    for (uint64_t i = 0; i < plan->trial_units; i++) {
        wire_put_f64(out, plan->trials[i].spread);
        wire_put_f64(out, plan->trials[i].rays);
    }
}

/* How many there are follows from the candidates. */
static fault_code_t get_trials(wire_reader_t *in, plan_t *plan, fault_t *fault)
{
    if (plan->has_candidates) {
        TRY(plan_find_light(plan, fault));
        TRY(plan_prepare_trials(plan, fault));
    }
    const uint64_t count = wire_get_u64(in, "trials");
    if (!in->code && count != plan->trial_units)
        return wire_reader_fail(in, FAULT_FORMAT, "trials", "%llu, expected %llu", (unsigned long long)count,
                                (unsigned long long)plan->trial_units);
    for (uint64_t i = 0; i < plan->trial_units && !in->code; i++) {
        plan_trial_t *trial = &plan->trials[i];
        trial->spread = wire_get_f64(in, "trials");
        trial->rays = wire_get_f64(in, "trials");
        if (!in->code && (!(trial->spread >= 0 && trial->rays >= 0) || !isfinite(trial->spread + trial->rays)))
            return wire_reader_fail(in, FAULT_RANGE, "trials", "%llu is negative or not finite",
                                    (unsigned long long)i);
    }
    return in->code;
}

/* ---- saving ---- */

typedef struct save_parts {
    const plan_t *plan;
    save_packed_t *weights, *films; /* [max_path_length + 1] */
    save_packed_t squares, strata, features, pilot_moments, pilot_blocks, groups[PLAN_GROUPS_PARTS];
} save_parts_t;

static void put_plan(wire_writer_t *out, const save_parts_t *parts)
{
    const plan_t *plan = parts->plan;
    wire_put_u32(out, PLAN_SAVE_VERSION);
    wire_put_u64(out, plan->unit_count);
    wire_put_u64(out, plan->pilot_units);
    wire_put_u8(out, (uint8_t)(plan->has_candidates + (plan->phase != PLAN_PILOT)));
    for (uint64_t i = 0; i < plan->unit_count; i++)
        wire_put_u8(out, plan->units[i].state);
    put_totals(out, plan);
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++) {
        put_length(out, &plan->lengths[k], k);
        wire_put_bytes(out, "weights", parts->weights[k].data, parts->weights[k].size, UINT32_MAX);
        wire_put_bytes(out, "film", parts->films[k].data, parts->films[k].size, UINT32_MAX);
    }
    wire_put_bytes(out, "squares", parts->squares.data, parts->squares.size, UINT32_MAX);
    wire_put_bytes(out, "strata", parts->strata.data, parts->strata.size, UINT32_MAX);
    wire_put_bytes(out, "features", parts->features.data, parts->features.size, UINT32_MAX);
    wire_put_bytes(out, "pilot moments", parts->pilot_moments.data, parts->pilot_moments.size, UINT32_MAX);
    wire_put_bytes(out, "pilot blocks", parts->pilot_blocks.data, parts->pilot_blocks.size, UINT32_MAX);
    for (int i = 0; i < PLAN_GROUPS_PARTS; i++)
        wire_put_bytes(out, "groups", parts->groups[i].data, parts->groups[i].size, UINT32_MAX);
    put_history(out, &plan->history);
    stuck_put(out, &plan->stuck);
    put_trials(out, plan);
}

/* Octets of the pilot units' coarse images. */
static size_t pilot_blocks_size(const plan_t *plan)
{
    return plan->candidates / plan->pilot_unit * plan->settings.max_path_length * WORK_BLOCKS *
           sizeof *plan->pilot_blocks;
}

/* Octets of the blocks' squares. */
static size_t strata_size(const plan_t *plan)
{
    return FILM_CHANNELS * plan_strata(plan) * sizeof *plan->strata;
}

/* Octets of the pilot units' estimators. */
static size_t pilot_moments_size(const plan_t *plan)
{
    return plan->candidates / plan->pilot_unit * work_samples_moment(plan->settings.max_path_length + 1) *
           sizeof *plan->pilot_moments;
}

static fault_code_t save_pack_all(const plan_t *plan, save_parts_t *parts, fault_t *fault)
{
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++) {
        const plan_length_t *length = &plan->lengths[k];
        if (length->weights)
            TRY(save_pack(length->weights, sizeof(double) * plan->candidates, &parts->weights[k], fault));
        if (length->film.sums)
            TRY(film_encode(&length->film, &parts->films[k].data, &parts->films[k].size, fault));
    }
    if (plan->pilot_moments)
        TRY(save_pack(plan->pilot_moments, pilot_moments_size(plan), &parts->pilot_moments, fault));
    if (plan->pilot_blocks)
        TRY(save_pack(plan->pilot_blocks, pilot_blocks_size(plan), &parts->pilot_blocks, fault));
    TRY(save_pack(plan->squares, FILM_CHANNELS * plan->pixels * sizeof *plan->squares, &parts->squares, fault));
    if (plan->strata)
        TRY(save_pack(plan->strata, strata_size(plan), &parts->strata, fault));
    plan_groups_part_t groups[PLAN_GROUPS_PARTS];
    plan_groups_parts(&plan->groups, groups);
    for (int i = 0; i < PLAN_GROUPS_PARTS; i++)
        TRY(save_pack(groups[i].data, groups[i].size, &parts->groups[i], fault));
    return save_pack(plan->features, WORK_FEATURE_CHANNELS * plan->pixels * sizeof *plan->features,
                     &parts->features, fault);
}

fault_code_t plan_save(const plan_t *plan, uint8_t **data, size_t *size, fault_t *fault)
{
    *data = NULL;
    const size_t lengths = plan->settings.max_path_length + 1;
    save_parts_t parts = {.plan = plan,
                          .weights = calloc(lengths, sizeof *parts.weights),
                          .films = calloc(lengths, sizeof *parts.films)};
    fault_code_t code = FAULT_NONE;
    if (!parts.weights || !parts.films)
        code = fault_set(fault, FAULT_MEMORY, "checkpoint: no memory");
    if (!code)
        code = save_pack_all(plan, &parts, fault);
    wire_writer_t out;
    for (int pass = 0; pass < 2 && !code; pass++) { /* counts, then writes */
        wire_writer_init(&out, *data, pass ? *size : 0, "checkpoint", fault);
        put_plan(&out, &parts);
        code = out.code;
        if (pass == 0 && !code) {
            *size = out.at;
            *data = malloc(*size);
            if (!*data)
                code = fault_set(fault, FAULT_MEMORY, "checkpoint: no memory for %zu octets", *size);
        }
    }
    for (size_t k = 0; k < lengths && parts.weights && parts.films; k++) {
        free(parts.weights[k].data);
        free(parts.films[k].data);
    }
    free(parts.weights);
    free(parts.films);
    free(parts.squares.data);
    free(parts.strata.data);
    free(parts.features.data);
    free(parts.pilot_moments.data);
    free(parts.pilot_blocks.data);
    for (int i = 0; i < PLAN_GROUPS_PARTS; i++)
        free(parts.groups[i].data);
    if (code) {
        free(*data);
        *data = NULL;
    }
    return code;
}

/* ---- restoring ---- */

static fault_code_t load_pilot_moments(plan_t *plan, wire_reader_t *in)
{
    if (plan->has_candidates) {
        free(plan->pilot_moments);
        free(plan->pilot_blocks);
        plan->pilot_moments = NULL;
        plan->pilot_blocks = NULL;
        wire_get_bytes(in, "pilot moments", 0, &(size_t){0});
        wire_get_bytes(in, "pilot blocks", 0, &(size_t){0});
        return in->code;
    }
    TRY(load_packed(in, "pilot moments", plan->pilot_moments, pilot_moments_size(plan)));
    for (size_t i = 0; i < pilot_moments_size(plan) / sizeof *plan->pilot_moments; i++) {
        const work_moments_t *m = &plan->pilot_moments[i];
        if (!(m->n >= 0 && m->sum >= 0 && m->sum2 >= 0) || !isfinite(m->n + m->sum + m->sum2))
            return wire_reader_fail(in, FAULT_RANGE, "pilot moments", "entry %zu is negative or not finite", i);
    }
    TRY(load_packed(in, "pilot blocks", plan->pilot_blocks, pilot_blocks_size(plan)));
    for (size_t i = 0; i < pilot_blocks_size(plan) / sizeof *plan->pilot_blocks; i++)
        if (!(plan->pilot_blocks[i] >= 0) || !isfinite(plan->pilot_blocks[i]))
            return wire_reader_fail(in, FAULT_RANGE, "pilot blocks", "entry %zu is negative or not finite", i);
    return FAULT_NONE;
}

static fault_code_t load_groups(plan_t *plan, wire_reader_t *in)
{
    plan_groups_part_t groups[PLAN_GROUPS_PARTS];
    plan_groups_parts(&plan->groups, groups);
    for (int i = 0; i < PLAN_GROUPS_PARTS; i++)
        TRY(load_packed(in, "groups", groups[i].data, groups[i].size));
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++) {
        uint64_t count = 0;
        for (uint32_t g = 0; g < PLAN_GROUPS; g++)
            count += plan->groups.counts[(size_t)k * PLAN_GROUPS + g];
        if (count != plan->lengths[k].merged)
            return wire_reader_fail(in, FAULT_FORMAT, "groups", "%llu mutations of length %u, expected %llu",
                                    (unsigned long long)count, k, (unsigned long long)plan->lengths[k].merged);
    }
    return FAULT_NONE;
}

static fault_code_t load_arrays(plan_t *plan, wire_reader_t *in, fault_t *fault)
{
    const bool sums = plan->has_candidates;
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++) {
        plan_length_t *length = &plan->lengths[k];
        get_length(in, length, k);
        if (in->code)
            return in->code;
        if (sums && !plan_has_seeds(plan, k)) {
            free(length->weights);
            length->weights = NULL;
        }
        if (length->weights)
            TRY(load_packed(in, "weights", length->weights, sizeof(double) * plan->candidates));
        else
            wire_get_bytes(in, "weights", 0, &(size_t){0});
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
    TRY(load_packed(in, "squares", plan->squares, FILM_CHANNELS * plan->pixels * sizeof *plan->squares));
    if (plan->strata)
        TRY(load_packed(in, "strata", plan->strata, strata_size(plan)));
    else
        wire_get_bytes(in, "strata", 0, &(size_t){0});
    TRY(load_packed(in, "features", plan->features, WORK_FEATURE_CHANNELS * plan->pixels * sizeof *plan->features));
    for (size_t i = 0; i < WORK_FEATURE_CHANNELS * plan->pixels; i++)
        if (!isfinite(plan->features[i]))
            return wire_reader_fail(in, FAULT_RANGE, "features", "number %zu is not finite", i);
    TRY(load_pilot_moments(plan, in));
    TRY(load_groups(plan, in));
    TRY(get_history(in, &plan->history));
    TRY(stuck_get(in, &plan->stuck, plan->settings.max_path_length));
    TRY(plan_stuck_check(plan, in));
    TRY(get_trials(in, plan, fault));
    plan_predict(plan);
    return wire_reader_end(in);
}

/* What the units that are in add up to, by length. */
typedef struct load_counts {
    uint64_t units[PATH_MAX_VERTICES], merged[PATH_MAX_VERTICES];
} load_counts_t;

static void load_count(load_counts_t *counts, const work_record_t *record)
{
    if (record->kind != WORK_CHAINS && record->kind != WORK_SAMPLES)
        return;
    counts->units[record->length]++;
    counts->merged[record->length] += record->kind == WORK_CHAINS ? record->mutations : record->count;
}

/* Makes the list of units again and marks those that are in. */
static fault_code_t load_units(plan_t *plan, wire_reader_t *in, const uint8_t *states, uint64_t count)
{
    load_counts_t counts = {{0}, {0}};
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
        load_count(&counts, &plan->units[i].record);
        work_record_clear(&plan->units[i].record);
        plan->in++;
    }
    for (uint64_t i = 0; i < count && i < plan->sketch_units; i++)
        plan->sketch_in += states[i] == PLAN_UNIT_IN;
    if (plan->sketch_units > 0 && plan->has_importance != (plan->sketch_in == plan->sketch_units))
        return wire_reader_fail(in, FAULT_FORMAT, "importance", "does not go with %llu of %llu sketch units",
                                (unsigned long long)plan->sketch_in, (unsigned long long)plan->sketch_units);
    const uint64_t caps = plan->pilot_units - plan->candidates / plan->pilot_unit - plan->split_units;
    for (uint64_t i = caps; i < count && i < caps + plan->split_units; i++)
        plan->split_in += states[i] == PLAN_UNIT_IN;
    if (plan->split_units > 0 && plan->has_caps != (plan->split_in == plan->split_units))
        return wire_reader_fail(in, FAULT_FORMAT, "caps", "do not go with %llu of %llu units",
                                (unsigned long long)plan->split_in, (unsigned long long)plan->split_units);
    for (uint64_t i = plan->pilot_units; i < count && i < trials; i++)
        plan->trial_in += states[i] == PLAN_UNIT_IN;
    plan->resume = 0;
    const uint64_t next =
        plan->has_candidates ? trials : plan->pilot_units; /* units in with which the phase ends */
    if (count < whole || (plan->phase == PLAN_PILOT && plan->in == next))
        return wire_reader_fail(in, FAULT_FORMAT, "units", "%llu in do not go with the phase",
                                (unsigned long long)plan->in);
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        if (counts.units[k] != plan->lengths[k].units_in || counts.merged[k] != plan->lengths[k].merged)
            return wire_reader_fail(
                in, FAULT_FORMAT, "units_in", "%llu with %llu mutations of length %u, expected %llu with %llu",
                (unsigned long long)plan->lengths[k].units_in, (unsigned long long)plan->lengths[k].merged, k,
                (unsigned long long)counts.units[k], (unsigned long long)counts.merged[k]);
    return FAULT_NONE;
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
    }
    return load_units(plan, in, states, count);
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
