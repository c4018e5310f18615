/* work_codec.c: records and results as bytes (proto/PROTOCOL.md names them opaque; the layout is stated here).
 *
 * Record: u32 version, kind, length; u64 first, count, mutations; f64 scale; for chains u64 seeds[count], u32
 * steps, large, u32 0 or length + 1 and that many f64: shares; for all but features and what is left out u32 0 or
 * IMPORTANCE_BLOCKS and that many f64, u32 caps and that many f64, u32 lengths with idle techniques and that many
 * pairs of u64; for samples u32 rates and that many f64, u64 skip, u32 sequence, u64 point.
 *
 * Result: u32 version, kind, length; stats in the order of work_stats_t; u32 moment_count and that many (n, sum,
 * sum2); u32 0 or WORK_FAILED_BLOCKS and that many u64: failed; what was stuck (stuck.h); of trials f64 spread;
 * then by kind: pilot packed doubles; chains and samples a film; features packed floats. Packed: u32 size and that
 * many octets of zstd. All little endian.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

#include "base/wire.h"
#include "chain/work.h"
#include "path/walk.h"

enum { WORK_CODEC_VERSION = 14 };

void work_record_clear(work_record_t *record)
{
    free(record->seeds);
    free(record->shares);
    free(record->importance);
    free(record->caps);
    free(record->rates);
    free(record->idle);
    *record = (work_record_t){0};
}

/* And caps and idle techniques. */
static bool record_has_importance(uint32_t kind)
{
    return kind != WORK_FEATURES && kind != WORK_LEFT_OUT;
}

static void record_put(wire_writer_t *out, const void *value)
{
    const work_record_t *record = value;
    wire_put_u32(out, WORK_CODEC_VERSION);
    wire_put_u32(out, record->kind);
    wire_put_u32(out, record->length);
    wire_put_u64(out, record->first);
    wire_put_u64(out, record->count);
    wire_put_u64(out, record->mutations);
    wire_put_f64(out, record->scale);
    for (uint64_t i = 0; work_runs_chains(record->kind) && i < record->count; i++)
        wire_put_u64(out, record->seeds[i]);
    if (work_runs_chains(record->kind)) {
        const uint32_t shares = record->shares ? record->length + 1 : 0;
        wire_put_u32(out, (uint32_t)record->steps);
        wire_put_u32(out, (uint32_t)record->large);
        wire_put_u32(out, shares);
        for (uint32_t s = 0; s < shares; s++)
            wire_put_f64(out, record->shares[s]);
    }
    if (record->kind == WORK_FEATURES)
        wire_put_u32(out, record->side);
    if (!record_has_importance(record->kind))
        return;
    wire_put_u32(out, record->importance ? IMPORTANCE_BLOCKS : 0);
    for (int i = 0; record->importance && i < IMPORTANCE_BLOCKS; i++)
        wire_put_f64(out, record->importance[i]);
    wire_put_u32(out, record->cap_count);
    for (uint32_t i = 0; i < record->cap_count; i++)
        wire_put_f64(out, record->caps[i]);
    wire_put_u32(out, record->idle_count);
    for (uint32_t i = 0; i < record->idle_count; i++)
        for (int w = 0; w < 2; w++)
            wire_put_u64(out, record->idle[i].words[w]);
    if (record->kind != WORK_SAMPLES)
        return;
    wire_put_u32(out, record->rate_count);
    for (uint32_t i = 0; i < record->rate_count; i++)
        wire_put_f64(out, record->rates[i]);
    wire_put_u64(out, record->skip);
    wire_put_u32(out, record->sequence);
    wire_put_u64(out, record->point);
}

/* Runs a writing function twice: to count, then to write into memory of that size. */
static fault_code_t codec_encode(void (*put)(wire_writer_t *, const void *), const void *value, const char *what,
                                 uint8_t **data, size_t *size, fault_t *fault)
{
    *data = NULL;
    wire_writer_t out;
    wire_writer_init(&out, NULL, 0, what, fault);
    put(&out, value);
    if (out.code)
        return out.code;
    *size = out.at;
    *data = malloc(*size);
    if (!*data)
        return fault_set(fault, FAULT_MEMORY, "%s: no memory for %zu octets", what, *size);
    wire_writer_init(&out, *data, *size, what, fault);
    put(&out, value);
    return out.code;
}

fault_code_t work_record_encode(const work_record_t *record, uint8_t **data, size_t *size, fault_t *fault)
{
    return codec_encode(record_put, record, "unit record", data, size, fault);
}

static fault_code_t record_check(wire_reader_t *in, const work_record_t *r)
{
    static const uint64_t most[WORK_KINDS] = {
        [WORK_PILOT] = WORK_MAX_CANDIDATES, [WORK_CHAINS] = WORK_MAX_CHAINS, [WORK_TRIAL] = WORK_MAX_CHAINS,
        [WORK_SAMPLES] = UINT64_C(1) << 40, [WORK_FEATURES] = FILM_MAX_SIDE, [WORK_REFINE] = UINT64_C(1) << 40,
        [WORK_LEFT_OUT] = UINT64_C(1) << 40};
    if (in->code)
        return in->code;
    if (r->kind == 0 || r->kind >= WORK_KINDS)
        return wire_reader_fail(in, FAULT_FORMAT, "kind", "%u, expected 1 to %d", r->kind, WORK_KINDS - 1);
    if (r->count == 0 || r->count > most[r->kind])
        return wire_reader_fail(in, FAULT_RANGE, "count", "%llu, expected 1 to %llu", (unsigned long long)r->count,
                                (unsigned long long)most[r->kind]);
    if (r->first > UINT64_MAX / 2)
        return wire_reader_fail(in, FAULT_RANGE, "first", "%llu is beyond 2^63", (unsigned long long)r->first);
    if (work_runs_chains(r->kind) ? r->length > PATH_MAX_LENGTH : r->length != 0)
        return wire_reader_fail(in, FAULT_RANGE, "length", "%u does not go with the kind", r->length);
    if (work_runs_chains(r->kind) ? r->mutations < r->count || r->mutations > UINT64_C(1) << 40 : r->mutations != 0)
        return wire_reader_fail(in, FAULT_RANGE, "mutations", "%llu does not go with kind and count",
                                (unsigned long long)r->mutations);
    if (r->kind == WORK_SAMPLES || r->kind == WORK_TRIAL ? !(r->scale > 0) || !isfinite(r->scale) : r->scale != 0)
        return wire_reader_fail(in, FAULT_RANGE, "scale", "%g does not go with the kind", r->scale);
    return FAULT_NONE;
}

static fault_code_t record_get_steps(wire_reader_t *in, work_record_t *record)
{
    record->steps = (int32_t)wire_get_u32(in, "steps");
    record->large = (int32_t)wire_get_u32(in, "large");
    if (!in->code && (record->steps < -WORK_STEPS || record->steps > WORK_STEPS))
        return wire_reader_fail(in, FAULT_RANGE, "steps", "%d, expected %d to %d", record->steps, -WORK_STEPS,
                                WORK_STEPS);
    if (!in->code && (record->large < -WORK_STEPS || record->large > 0))
        return wire_reader_fail(in, FAULT_RANGE, "large", "%d, expected %d to 0", record->large, -WORK_STEPS);
    return in->code;
}

static fault_code_t record_get_shares(wire_reader_t *in, work_record_t *record, fault_t *fault)
{
    const uint32_t count = wire_get_u32(in, "shares");
    if (in->code || count == 0)
        return in->code;
    if (record->length == 0 || count != record->length + 1)
        return wire_reader_fail(in, FAULT_FORMAT, "shares", "%u, expected 0%s", count,
                                record->length ? " or one more than the length" : "");
    record->shares = malloc(sizeof(double) * count);
    if (!record->shares)
        return fault_set(fault, FAULT_MEMORY, "unit record: no memory for its shares");
    double sum = 0;
    for (uint32_t s = 0; s < count && !in->code; s++) {
        record->shares[s] = wire_get_f64(in, "shares");
        if (!(record->shares[s] >= 0 && record->shares[s] <= 1))
            return wire_reader_fail(in, FAULT_RANGE, "shares", "%g, expected 0 to 1", record->shares[s]);
        sum += record->shares[s];
    }
    if (!in->code && !(fabs(sum - 1) < 1e-9))
        return wire_reader_fail(in, FAULT_RANGE, "shares", "their sum is %g, expected 1", sum);
    return in->code;
}

static fault_code_t record_get_importance(wire_reader_t *in, work_record_t *record, fault_t *fault)
{
    const uint32_t count = wire_get_u32(in, "importance");
    if (in->code || count == 0)
        return in->code;
    if (count != IMPORTANCE_BLOCKS)
        return wire_reader_fail(in, FAULT_FORMAT, "importance", "%u, expected 0 or %d", count, IMPORTANCE_BLOCKS);
    record->importance = malloc(sizeof(double) * count);
    if (!record->importance)
        return fault_set(fault, FAULT_MEMORY, "unit record: no memory for its importance");
    for (uint32_t i = 0; i < count && !in->code; i++) {
        record->importance[i] = wire_get_f64(in, "importance");
        if (!in->code && !(record->importance[i] >= 1e-6 && record->importance[i] <= 1e6))
            return wire_reader_fail(in, FAULT_RANGE, "importance", "%g, expected 1e-6 to 1e6",
                                    record->importance[i]);
    }
    return in->code;
}

static fault_code_t record_get_caps(wire_reader_t *in, work_record_t *record, fault_t *fault)
{
    const uint32_t count = wire_get_u32(in, "caps"), most = work_runs_chains(record->kind) ? 1 : PATH_MAX_LENGTH;
    if (in->code || count == 0)
        return in->code;
    if (count > most)
        return wire_reader_fail(in, FAULT_FORMAT, "caps", "%u, expected 0 to %u", count, most);
    record->caps = malloc(sizeof(double) * count);
    if (!record->caps)
        return fault_set(fault, FAULT_MEMORY, "unit record: no memory for its caps");
    record->cap_count = count;
    for (uint32_t i = 0; i < count && !in->code; i++) {
        record->caps[i] = wire_get_f64(in, "caps");
        if (!in->code && !(record->caps[i] >= 0))
            return wire_reader_fail(in, FAULT_RANGE, "caps", "%g, expected 0 or more", record->caps[i]);
    }
    return in->code;
}

/* From 1 down, and never to 0. */
static fault_code_t record_get_rates(wire_reader_t *in, work_record_t *record, fault_t *fault)
{
    const uint32_t count = wire_get_u32(in, "rates");
    if (in->code || count == 0)
        return in->code;
    if (count > PATH_MAX_LENGTH)
        return wire_reader_fail(in, FAULT_FORMAT, "rates", "%u, expected 0 to %d", count, PATH_MAX_LENGTH);
    record->rates = malloc(sizeof(double) * count);
    if (!record->rates)
        return fault_set(fault, FAULT_MEMORY, "unit record: no memory for its rates");
    record->rate_count = count;
    double before = 1;
    for (uint32_t i = 0; i < count && !in->code; i++) {
        const double rate = record->rates[i] = wire_get_f64(in, "rates");
        if (!in->code && !(rate >= 1e-6 && rate <= before && (i > 0 || rate == 1)))
            return wire_reader_fail(in, FAULT_RANGE, "rates",
                                    "%g after %g, expected them to fall from 1 to 1e-6 or more", rate, before);
        before = rate;
    }
    return in->code;
}

/* No bit stands for a technique that its length lacks. */
static fault_code_t record_get_idle(wire_reader_t *in, work_record_t *record, fault_t *fault)
{
    const bool one = work_runs_chains(record->kind) && record->length > 0;
    const uint32_t count = wire_get_u32(in, "idle"), most = one ? 1 : PATH_MAX_LENGTH;
    if (in->code || count == 0)
        return in->code;
    if (count > most)
        return wire_reader_fail(in, FAULT_FORMAT, "idle", "%u lengths, expected 0 to %u", count, most);
    record->idle = calloc(count, sizeof *record->idle);
    if (!record->idle)
        return fault_set(fault, FAULT_MEMORY, "unit record: no memory for its idle techniques");
    record->idle_count = count;
    for (uint32_t i = 0; i < count && !in->code; i++) {
        const uint32_t techniques = (one ? record->length : i + 1) + 1;
        for (int w = 0; w < 2; w++)
            record->idle[i].words[w] = wire_get_u64(in, "idle");
        for (uint32_t s = techniques; s < PATH_MAX_VERTICES && !in->code; s++)
            if (target_is_idle(&record->idle[i], s))
                return wire_reader_fail(in, FAULT_RANGE, "idle", "technique %u of length %u", s, techniques - 1);
    }
    return in->code;
}

/* Which samples, and which points. */
static fault_code_t record_get_places(wire_reader_t *in, work_record_t *record)
{
    record->skip = wire_get_u64(in, "skip");
    record->sequence = wire_get_u32(in, "sequence");
    record->point = wire_get_u64(in, "point");
    if (!in->code &&
        (record->skip > WORK_MAX_SKIP || record->first + record->count * (record->skip + 1) > INT64_MAX))
        return wire_reader_fail(in, FAULT_RANGE, "skip", "%llu, expected 0 to %d", (unsigned long long)record->skip,
                                WORK_MAX_SKIP);
    if (!in->code && record->sequence >= WORK_SEQUENCES)
        return wire_reader_fail(in, FAULT_RANGE, "sequence", "%u, expected less than %d", record->sequence,
                                WORK_SEQUENCES);
    if (!in->code && record->point > WORK_MAX_POINT)
        return wire_reader_fail(in, FAULT_RANGE, "point", "%llu, expected 0 to %llu",
                                (unsigned long long)record->point, (unsigned long long)WORK_MAX_POINT);
    return in->code;
}

static fault_code_t record_get_side(wire_reader_t *in, work_record_t *record)
{
    record->side = wire_get_u32(in, "side");
    if (!in->code && (record->side == 0 || record->side > WORK_MAX_SIDE))
        return wire_reader_fail(in, FAULT_RANGE, "side", "%u, expected 1 to %d", record->side, WORK_MAX_SIDE);
    return in->code;
}

fault_code_t work_record_decode(work_record_t *record, const uint8_t *data, size_t size, fault_t *fault)
{
    *record = (work_record_t){0};
    wire_reader_t in;
    wire_reader_init(&in, data, size, "unit record", fault);
    const uint32_t version = wire_get_u32(&in, "version");
    if (!in.code && version != WORK_CODEC_VERSION)
        return wire_reader_fail(&in, FAULT_VERSION, "version", "%u, expected %d", version, WORK_CODEC_VERSION);
    record->kind = wire_get_u32(&in, "kind");
    record->length = wire_get_u32(&in, "length");
    record->first = wire_get_u64(&in, "first");
    record->count = wire_get_u64(&in, "count");
    record->mutations = wire_get_u64(&in, "mutations");
    record->scale = wire_get_f64(&in, "scale");
    TRY(record_check(&in, record));
    if (work_runs_chains(record->kind)) {
        const uint8_t *seeds = wire_get_raw(&in, "seeds", 8 * record->count);
        if (!seeds)
            return in.code;
        record->seeds = malloc(8 * record->count);
        if (!record->seeds)
            return fault_set(fault, FAULT_MEMORY, "unit record: no memory for its seeds");
        memcpy(record->seeds, seeds, 8 * record->count);
    }
    fault_code_t code = work_runs_chains(record->kind) ? record_get_steps(&in, record) : FAULT_NONE;
    if (!code && work_runs_chains(record->kind))
        code = record_get_shares(&in, record, fault);
    if (!code && record_has_importance(record->kind))
        code = record_get_importance(&in, record, fault);
    if (!code && record_has_importance(record->kind))
        code = record_get_caps(&in, record, fault);
    if (!code && record_has_importance(record->kind))
        code = record_get_idle(&in, record, fault);
    if (!code && record->kind == WORK_SAMPLES)
        code = record_get_rates(&in, record, fault);
    if (!code && record->kind == WORK_SAMPLES)
        code = record_get_places(&in, record);
    if (!code && record->kind == WORK_FEATURES)
        code = record_get_side(&in, record);
    if (!code)
        code = wire_reader_end(&in);
    if (code)
        work_record_clear(record);
    return code;
}

/* ---- results ---- */

/* What a result is written from: its arrays packed beforehand. */
typedef struct result_parts {
    const work_result_t *result;
    uint8_t *packed; /* weights or features, or the film */
    size_t packed_size;
} result_parts_t;

static void result_put(wire_writer_t *out, const void *value)
{
    const result_parts_t *parts = value;
    const work_result_t *r = parts->result;
    const work_stats_t *stats = &r->stats;
    wire_put_u32(out, WORK_CODEC_VERSION);
    wire_put_u32(out, r->kind);
    wire_put_u32(out, r->length);
    wire_put_f64(out, stats->cpu_seconds);
    wire_put_f64(out, stats->tracing_seconds);
    wire_put_f64(out, stats->inversion_seconds);
    wire_put_f64(out, stats->merging_seconds);
    wire_put_f64(out, stats->waiting_seconds);
    wire_put_u64(out, stats->rays);
    wire_put_u64(out, stats->shadow_rays);
    wire_put_u64(out, stats->evaluations);
    for (int i = 0; i < WORK_REJECTS; i++)
        wire_put_u64(out, stats->rejects[i]);
    for (int i = 0; i < WORK_MOVES; i++) {
        wire_put_u64(out, stats->proposed[i]);
        wire_put_f64(out, stats->accepted[i]);
    }
    wire_put_u64(out, stats->zero_proposals);
    wire_put_u64(out, stats->longest_stay);
    wire_put_u32(out, r->moment_count);
    for (uint32_t i = 0; i < r->moment_count; i++) {
        wire_put_f64(out, r->moments[i].n);
        wire_put_f64(out, r->moments[i].sum);
        wire_put_f64(out, r->moments[i].sum2);
    }
    const uint32_t failed = r->failed ? WORK_FAILED_BLOCKS : 0;
    wire_put_u32(out, failed);
    for (uint32_t i = 0; i < failed; i++)
        wire_put_u64(out, r->failed[i]);
    stuck_put(out, &r->stuck);
    if (r->kind == WORK_TRIAL)
        wire_put_f64(out, r->spread);
    wire_put_bytes(out, "body", parts->packed, parts->packed_size, UINT32_MAX);
}

static fault_code_t pack(const void *from, size_t size, uint8_t **data, size_t *packed, fault_t *fault)
{
    const size_t room = ZSTD_compressBound(size);
    *data = malloc(room);
    if (!*data)
        return fault_set(fault, FAULT_MEMORY, "unit result: no memory for %zu octets", room);
    *packed = ZSTD_compress(*data, room, from, size, 1);
    if (!ZSTD_isError(*packed))
        return FAULT_NONE;
    free(*data);
    *data = NULL;
    return fault_set(fault, FAULT_MEMORY, "unit result: zstd: %s", ZSTD_getErrorName(*packed));
}

fault_code_t work_result_encode(const work_result_t *result, uint8_t **data, size_t *size, fault_t *fault)
{
    result_parts_t parts = {.result = result};
    if (result->kind == WORK_PILOT)
        TRY(pack(result->weights, sizeof *result->weights * result->weight_count, &parts.packed, &parts.packed_size,
                 fault));
    else if (result->kind == WORK_FEATURES)
        TRY(pack(result->features,
                 sizeof *result->features * WORK_FEATURE_CHANNELS * result->feature_rows * result->feature_width,
                 &parts.packed, &parts.packed_size, fault));
    else if (result->has_film)
        TRY(film_encode(&result->film, &parts.packed, &parts.packed_size, fault));
    const fault_code_t code = codec_encode(result_put, &parts, "unit result", data, size, fault);
    free(parts.packed);
    return code;
}

static double result_get_seconds(wire_reader_t *in, const char *name, double most)
{
    const double seconds = wire_get_f64(in, name);
    if (!in->code && !(seconds >= 0 && seconds <= most))
        wire_reader_fail(in, FAULT_RANGE, name, "%g, expected 0 to %g", seconds, most);
    return seconds;
}

static void result_get_stats(wire_reader_t *in, work_stats_t *stats)
{
    stats->cpu_seconds = result_get_seconds(in, "cpu_seconds", 1e9);
    stats->tracing_seconds = result_get_seconds(in, "tracing_seconds", stats->cpu_seconds);
    stats->inversion_seconds =
        result_get_seconds(in, "inversion_seconds", stats->cpu_seconds - stats->tracing_seconds);
    stats->merging_seconds = result_get_seconds(in, "merging_seconds", 1e9);
    stats->waiting_seconds = result_get_seconds(in, "waiting_seconds", 1e9);
    stats->rays = wire_get_u64(in, "rays");
    stats->shadow_rays = wire_get_u64(in, "shadow_rays");
    stats->evaluations = wire_get_u64(in, "evaluations");
    for (int i = 0; i < WORK_REJECTS; i++)
        stats->rejects[i] = wire_get_u64(in, "rejects");
    for (int i = 0; i < WORK_MOVES; i++) {
        stats->proposed[i] = wire_get_u64(in, "proposed");
        stats->accepted[i] = wire_get_f64(in, "accepted");
        if (!in->code &&
            !(stats->accepted[i] >= 0 && stats->accepted[i] <= (double)stats->proposed[i] * (1 + 1e-9)))
            wire_reader_fail(in, FAULT_RANGE, "accepted", "%g of %llu", stats->accepted[i],
                             (unsigned long long)stats->proposed[i]);
    }
    stats->zero_proposals = wire_get_u64(in, "zero_proposals");
    stats->longest_stay = wire_get_u64(in, "longest_stay");
}

static fault_code_t result_get_moments(wire_reader_t *in, work_result_t *result, uint32_t expected, fault_t *fault)
{
    result->moment_count = wire_get_u32(in, "moment_count");
    if (!in->code && result->moment_count != expected)
        return wire_reader_fail(in, FAULT_FORMAT, "moment_count", "%u, expected %u", result->moment_count,
                                expected);
    result->moments = calloc(expected ? expected : 1, sizeof *result->moments);
    if (!result->moments)
        return fault_set(fault, FAULT_MEMORY, "unit result: no memory for %u moments", expected);
    for (uint32_t i = 0; i < expected && !in->code; i++) {
        work_moments_t *m = &result->moments[i];
        m->n = wire_get_f64(in, "moments.n");
        m->sum = wire_get_f64(in, "moments.sum");
        m->sum2 = wire_get_f64(in, "moments.sum2");
        if (!work_moments_are_sound(m))
            return wire_reader_fail(in, FAULT_RANGE, "moments", "entry %u is negative or not finite", i);
    }
    return in->code;
}

/* Numbers that the record decides: mutations proposed, and how many values an estimator is the mean of. */
static fault_code_t result_check_counts(wire_reader_t *in, const work_result_t *result, const work_record_t *record)
{
    const uint64_t *proposed = result->stats.proposed;
    uint64_t left = record->mutations;
    for (int i = 0; i < WORK_MOVE_SECOND; i++) {
        if (proposed[i] > left)
            return wire_reader_fail(in, FAULT_RANGE, "proposed", "more than the %llu mutations of the unit",
                                    (unsigned long long)record->mutations);
        left -= proposed[i];
    }
    if (left > 0)
        return wire_reader_fail(in, FAULT_RANGE, "proposed", "%llu mutations of the unit are missing",
                                (unsigned long long)left);
    if (proposed[WORK_MOVE_SECOND] > record->mutations)
        return wire_reader_fail(in, FAULT_RANGE, "proposed", "more second steps than mutations");
    if (result->stats.zero_proposals > record->mutations)
        return wire_reader_fail(in, FAULT_RANGE, "zero_proposals", "more than the %llu mutations of the unit",
                                (unsigned long long)record->mutations);
    const uint64_t n = work_runs_chains(record->kind) ? proposed[WORK_MOVE_LARGE] : record->count;
    for (uint32_t i = 0; i < result->moment_count; i++)
        if (result->moments[i].n != (double)n && !(work_runs_chains(record->kind) && result->moments[i].n == 0 &&
                                                   result->moments[i].sum == 0 && result->moments[i].sum2 == 0))
            return wire_reader_fail(in, FAULT_RANGE, "moments", "entry %u is of %g values, expected %llu", i,
                                    result->moments[i].n, (unsigned long long)n);
    return FAULT_NONE;
}

/* Failures by block: as many as proposals without contribution in all. */
static fault_code_t result_get_failed(wire_reader_t *in, work_result_t *result, const work_record_t *record,
                                      fault_t *fault)
{
    const uint32_t count = wire_get_u32(in, "failed");
    if (in->code || count == 0)
        return in->code;
    if (count != WORK_FAILED_BLOCKS || record->kind != WORK_CHAINS)
        return wire_reader_fail(in, FAULT_FORMAT, "failed", "%u entries", count);
    result->failed = malloc(sizeof *result->failed * count);
    if (!result->failed)
        return fault_set(fault, FAULT_MEMORY, "unit result: no memory for its failures");
    uint64_t left = result->stats.zero_proposals;
    for (uint32_t i = 0; i < count && !in->code; i++) {
        result->failed[i] = wire_get_u64(in, "failed");
        if (result->failed[i] > left)
            return wire_reader_fail(in, FAULT_RANGE, "failed", "more than the proposals without contribution");
        left -= result->failed[i];
    }
    return in->code;
}

/* Stuck stays: of the record's chains alone, and of no more rejections than mutations. */
static fault_code_t result_get_stuck(wire_reader_t *in, work_result_t *result, const work_record_t *record,
                                     uint32_t max_path_length)
{
    stuck_t *stuck = &result->stuck;
    TRY(stuck_get(in, stuck, max_path_length));
    if (stuck->rejections > (work_runs_chains(record->kind) ? record->mutations : 0))
        return wire_reader_fail(in, FAULT_RANGE, "stuck rejections", "%llu of %llu mutations",
                                (unsigned long long)stuck->rejections, (unsigned long long)record->mutations);
    for (uint32_t i = 0; i < stuck->count; i++)
        if ((record->length > 0 && stuck->paths[i].length != record->length) ||
            stuck->paths[i].chain < record->first || stuck->paths[i].chain - record->first >= record->count ||
            stuck->paths[i].stay > result->stats.longest_stay)
            return wire_reader_fail(in, FAULT_RANGE, "stuck paths", "%u is not of the unit's chains", i);
    return FAULT_NONE;
}

static fault_code_t result_get_spread(wire_reader_t *in, work_result_t *result)
{
    result->spread = wire_get_f64(in, "spread");
    if (!in->code && !(result->spread >= 0 && isfinite(result->spread)))
        return wire_reader_fail(in, FAULT_RANGE, "spread", "%g, expected 0 or more", result->spread);
    return in->code;
}

/* Unpacks exactly `size` octets into new memory. */
static fault_code_t unpack(wire_reader_t *in, const uint8_t *packed, size_t packed_size, size_t size, void **out,
                           fault_t *fault)
{
    *out = malloc(size ? size : 1);
    if (!*out)
        return fault_set(fault, FAULT_MEMORY, "unit result: no memory for %zu octets", size);
    if (ZSTD_decompress(*out, size, packed, packed_size) == size)
        return FAULT_NONE;
    free(*out);
    *out = NULL;
    return wire_reader_fail(in, FAULT_FORMAT, "body", "does not unpack to %zu octets", size);
}

static fault_code_t result_get_body(wire_reader_t *in, work_result_t *result, const work_record_t *record,
                                    uint32_t width, uint32_t height, uint32_t max_path_length, film_t *spare,
                                    fault_t *fault)
{
    size_t packed_size = 0;
    const uint8_t *packed = wire_get_bytes(in, "body", UINT32_MAX, &packed_size);
    if (!packed)
        return in->code;
    if (record->kind == WORK_PILOT) {
        void *weights;
        const uint32_t count = (uint32_t)work_pilot_weights(record->count, max_path_length);
        TRY(unpack(in, packed, packed_size, sizeof(double) * count, &weights, fault));
        result->weights = weights;
        result->weight_count = count;
        for (uint32_t i = 0; i < count; i++)
            if (!(result->weights[i] >= 0) || !isfinite(result->weights[i]))
                return wire_reader_fail(in, FAULT_RANGE, "body", "weight %u is negative or not finite", i);
        return FAULT_NONE;
    }
    if (record->kind == WORK_FEATURES) {
        void *features;
        TRY(unpack(in, packed, packed_size, sizeof(float) * WORK_FEATURE_CHANNELS * record->count * width,
                   &features, fault));
        result->features = features;
        result->feature_rows = (uint32_t)record->count;
        result->feature_width = width;
        for (size_t i = 0; i < (size_t)WORK_FEATURE_CHANNELS * record->count * width; i++)
            if (!isfinite(result->features[i]))
                return wire_reader_fail(in, FAULT_RANGE, "body", "feature %zu is not finite", i);
        return FAULT_NONE;
    }
    if (record->kind == WORK_REFINE || record->kind == WORK_LEFT_OUT || record->kind == WORK_TRIAL)
        return packed_size == 0 ? FAULT_NONE : wire_reader_fail(in, FAULT_FORMAT, "body", "is not empty");
    if (spare && spare->sums) {
        result->film = *spare;
        *spare = (film_t){0};
    } else {
        TRY(film_init(&result->film, width, height, fault));
    }
    result->has_film = true;
    return film_decode(&result->film, packed, packed_size, fault);
}

fault_code_t work_result_decode(work_result_t *result, const work_record_t *record, uint32_t width, uint32_t height,
                                uint32_t max_path_length, film_t *spare, const uint8_t *data, size_t size,
                                fault_t *fault)
{
    *result = (work_result_t){0};
    wire_reader_t in;
    wire_reader_init(&in, data, size, "unit result", fault);
    const uint32_t version = wire_get_u32(&in, "version");
    if (!in.code && version != WORK_CODEC_VERSION)
        return wire_reader_fail(&in, FAULT_VERSION, "version", "%u, expected %d", version, WORK_CODEC_VERSION);
    result->kind = wire_get_u32(&in, "kind");
    result->length = wire_get_u32(&in, "length");
    if (!in.code && (result->kind != record->kind || result->length != record->length))
        return wire_reader_fail(&in, FAULT_FORMAT, "kind", "%u of length %u, expected %u of length %u",
                                result->kind, result->length, record->kind, record->length);
    result_get_stats(&in, &result->stats);
    const uint32_t moments = record->kind == WORK_FEATURES   ? 0
                             : record->kind == WORK_LEFT_OUT ? WORK_LEFT_OUT_MOMENTS
                             : work_runs_chains(record->kind) && record->length > 0
                                 ? record->length + 2
                                 : work_samples_moment(max_path_length + 1);
    fault_code_t code = result_get_moments(&in, result, moments, fault);
    if (!code)
        code = result_check_counts(&in, result, record);
    if (!code)
        code = result_get_failed(&in, result, record, fault);
    if (!code)
        code = result_get_stuck(&in, result, record, max_path_length);
    if (!code && record->kind == WORK_TRIAL)
        code = result_get_spread(&in, result);
    if (!code)
        code = result_get_body(&in, result, record, width, height, max_path_length, spare, fault);
    if (!code)
        code = wire_reader_end(&in);
    if (code)
        work_result_clear(result);
    return code;
}

void work_result_clear(work_result_t *result)
{
    free(result->moments);
    free(result->weights);
    free(result->failed);
    free(result->features);
    if (result->has_film)
        film_clear(&result->film);
    *result = (work_result_t){0};
}
