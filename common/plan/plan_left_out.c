/* plan_left_out.c: what the image is missing because the job says so, from samples of their own beside the pilot's
 * (chain/left_out.c): shares of all light that there would be. They decide nothing, so nothing waits for them. */
#include "plan/plan_left_out.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "plan/effects.h"
#include "plan/packed.h"

enum {
    LEFT_OUT_UNIT = 8192, /* samples */
    LEFT_OUT_PARTS = 4,   /* one sample for so many candidates */
    LEFT_OUT_LEAST = 2    /* units */
};

/* An aperture is not counted: light that it spreads over the image is not lost. */
static bool left_out_is_measured(const effects_t *effects, settings_effect_t effect)
{
    const effect_t *at = &effects->list[effects_switched(effect)];
    return at->present && at->set == SETTINGS_SWITCH_OFF && effect != SETTINGS_APERTURE;
}

uint64_t plan_left_out_size(const plan_t *plan)
{
    effects_t effects;
    bool any = false;
    effects_analyse(&effects, plan->scene, &plan->settings);
    for (int e = 0; e < SETTINGS_EFFECTS; e++)
        any = any || left_out_is_measured(&effects, (settings_effect_t)e);
    if (!any)
        return 0;
    const uint64_t units = plan->candidates / LEFT_OUT_PARTS / LEFT_OUT_UNIT;
    return units > LEFT_OUT_LEAST ? units : LEFT_OUT_LEAST;
}

void plan_left_out_record(uint64_t index, work_record_t *record)
{
    record->kind = WORK_LEFT_OUT;
    record->first = index * LEFT_OUT_UNIT;
    record->count = LEFT_OUT_UNIT;
}

void plan_absorb_left_out(plan_t *plan, const work_record_t *record, const work_result_t *result)
{
    memcpy(plan->left_out + record->first / LEFT_OUT_UNIT * WORK_LEFT_OUT_MOMENTS, result->moments,
           sizeof *plan->left_out * WORK_LEFT_OUT_MOMENTS);
}

static work_moments_t left_out_sum(const plan_t *plan, uint32_t moment)
{
    return work_moments_sum(plan->left_out + moment, plan->left_out_units, WORK_LEFT_OUT_MOMENTS);
}

/* The ratio r of two means over the same samples, part p and all a = p + q: its variance is that of p - r a = (1 -
 * r) p - r q over n a^2 (the delta method); E p q from the squares of all three. */
plan_energy_t plan_left_out_energy(const plan_t *plan, uint32_t effect)
{
    const work_moments_t all = left_out_sum(plan, 0), part = left_out_sum(plan, 1 + 2 * effect),
                         rest = left_out_sum(plan, 2 + 2 * effect);
    if (!(all.n > 1 && all.sum > 0))
        return (plan_energy_t){NAN, NAN};
    const double r = part.sum / all.sum, both = 0.5 * (all.sum2 - part.sum2 - rest.sum2),
                 squares = (1 - r) * (1 - r) * part.sum2 + r * r * rest.sum2 - 2 * r * (1 - r) * both;
    if (!(part.sum > 0)) /* not met once: nothing says how rare it is */
        return (plan_energy_t){0, NAN};
    return (plan_energy_t){r, sqrt(fmax(0, squares)) / all.sum};
}

void plan_left_out_say(const plan_t *plan, char *text, size_t size)
{
    effects_t effects;
    size_t at = 0;
    text[0] = 0;
    effects_analyse(&effects, plan->scene, &plan->settings);
    for (int e = 0; e < SETTINGS_EFFECTS; e++) {
        const effect_t *effect = &effects.list[effects_switched((settings_effect_t)e)];
        if (!effect->present || effect->set != SETTINGS_SWITCH_OFF)
            continue;
        const char *name = effects_name(effects_switched((settings_effect_t)e)), *comma = at > 0 ? ", " : "";
        const plan_energy_t energy = plan_left_out_energy(plan, (uint32_t)e);
        int written;
        if (left_out_is_measured(&effects, (settings_effect_t)e) && isfinite(energy.share + energy.error))
            written = snprintf(text + at, size - at, "%s%s %.3g +- %.2g", comma, name, energy.share, energy.error);
        else
            written = snprintf(text + at, size - at, "%s%s", comma, name);
        at += written > 0 ? (size_t)written : 0;
        if (at >= size)
            return;
    }
}

static size_t left_out_bytes(const plan_t *plan)
{
    return plan->left_out_units * WORK_LEFT_OUT_MOMENTS * sizeof *plan->left_out;
}

void plan_left_out_put(wire_writer_t *out, const plan_t *plan)
{
    packed_put(out, "left out", plan->left_out, left_out_bytes(plan));
}

fault_code_t plan_left_out_get(wire_reader_t *in, plan_t *plan)
{
    TRY(packed_get(in, "left out", plan->left_out, left_out_bytes(plan)));
    for (size_t i = 0; i < left_out_bytes(plan) / sizeof *plan->left_out; i++)
        if (!work_moments_are_sound(&plan->left_out[i]))
            return wire_reader_fail(in, FAULT_RANGE, "left out", "entry %zu is negative or not finite", i);
    return FAULT_NONE;
}
