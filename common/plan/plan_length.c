#include "plan/plan_length.h"

#include <math.h>

static void put_moments(wire_writer_t *out, const plan_moments_t *moments)
{
    exact_put(out, &moments->n);
    exact_put(out, &moments->sum);
    exact_put(out, &moments->sum2);
}

static void get_moments(wire_reader_t *in, plan_moments_t *moments)
{
    exact_get(in, &moments->n);
    exact_get(in, &moments->sum);
    exact_get(in, &moments->sum2);
    if (!in->code && (moments->n.value < 0 || moments->sum.value < 0 || moments->sum2.value < 0))
        wire_reader_fail(in, FAULT_RANGE, "moments", "are negative");
}

void plan_length_put(wire_writer_t *out, const plan_length_t *length, uint32_t k)
{
    wire_put_f64(out, length->b);
    wire_put_f64(out, length->need);
    wire_put_f64(out, length->light);
    wire_put_f64(out, length->most);
    wire_put_u64(out, length->units_in);
    wire_put_u64(out, length->merged);
    wire_put_u64(out, length->counted);
    wire_put_u64(out, length->rays);
    wire_put_u64(out, length->zero_proposals);
    wire_put_u64(out, length->longest_stay);
    wire_put_u64(out, length->stuck_light);
    wire_put_f64(out, length->cpu_seconds);
    for (int i = 0; i < WORK_MOVES; i++) {
        wire_put_u64(out, length->proposed[i]);
        exact_put(out, &length->accepted[i]);
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

void plan_length_get(wire_reader_t *in, plan_length_t *length, uint32_t k)
{
    length->b = wire_get_f64(in, "b");
    length->need = wire_get_f64(in, "need");
    if (!in->code && (!(length->need >= 0) || !isfinite(length->need)))
        wire_reader_fail(in, FAULT_RANGE, "need", "%g", length->need);
    length->light = wire_get_f64(in, "light");
    if (!in->code && (!(length->light >= 0) || !isfinite(length->light)))
        wire_reader_fail(in, FAULT_RANGE, "light", "%g", length->light);
    length->most = wire_get_f64(in, "most");
    if (!in->code && (!(length->most >= 0) || !isfinite(length->most)))
        wire_reader_fail(in, FAULT_RANGE, "most", "%g", length->most);
    length->units_in = wire_get_u64(in, "units_in");
    length->merged = wire_get_u64(in, "merged");
    length->counted = wire_get_u64(in, "counted");
    length->rays = wire_get_u64(in, "rays");
    length->zero_proposals = wire_get_u64(in, "zero_proposals");
    length->longest_stay = wire_get_u64(in, "longest_stay");
    length->stuck_light = wire_get_u64(in, "stuck light");
    length->cpu_seconds = wire_get_f64(in, "cpu_seconds");
    for (int i = 0; i < WORK_MOVES; i++) {
        length->proposed[i] = wire_get_u64(in, "proposed");
        exact_get(in, &length->accepted[i]);
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
