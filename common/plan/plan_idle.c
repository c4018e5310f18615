/* plan_idle.c: techniques of negligible energy leave the state space and the weights.
 *
 * A survey of independent samples beside the pilot's, in two rounds. The first tells how the energy of each length
 * is shared among its techniques. Technique s is idle if it may leave, and if
 *
 *     (S_s + 1.645 sqrt(sum x_s^2)) / S + 3 / n < 0.005,      n = S^2 / sum x^2,
 *
 * S the sum of the length's samples x, S_s that of the technique's part x_s: the upper end of a one-sided 95 %
 * interval for its share, and the rule of three for what was not met, n the number of samples that all would count
 * as, were they equal. The second round makes the same samples again without the idle techniques. Balance weights
 * over the others leave the mean as it is; where the mean square of a length is more than 5 % larger for it, the
 * length keeps all its techniques: some path was found well by one of them alone. Then nothing changes any more:
 * candidates, chains, and the samples beside them are all without the idle techniques.
 *
 * May leave: every path must still be made by some technique, by what the scene has (effects.h), not by what the
 * survey met. The technique that joins two neighbouring vertices needs both to scatter not only specularly; light
 * and lens always do, so that
 *
 *     where nothing is specular, each s >= 1 makes every path: one of them must stay;
 *
 *     where something is, s = 0 makes every path whose light can be hit, and some paths alone: it must stay, and
 *     no other may leave if there are lights that cannot be hit.
 */
#include "plan/plan_idle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plan/effects.h"
#include "plan/packed.h"

/* Indices of the survey's samples among those that refine b_k. */
#define SURVEY_FIRST (UINT64_C(1) << 42)
enum {
    SURVEY_PARTS = 16,     /* either round has one unit for so many of the pilot's */
    SURVEY_LEAST = 1 << 16 /* candidates of a pilot that is long enough to tell */
};
static const double IDLE_SHARE = 0.005, IDLE_RISE = 1.05;

/* Which techniques may leave, by the scene. */
typedef struct survey_rule {
    bool any;       /* some may at all */
    bool hits;      /* s = 0 takes part: some light can be hit */
    bool hit_stays; /* and may not leave */
} survey_rule_t;

static survey_rule_t survey_rule(const plan_t *plan)
{
    effects_t effects;
    effects_analyse(&effects, plan->scene, &plan->settings);
    const effect_t *list = effects.list;
    const bool specular = list[EFFECT_SPECULAR_REFLECTION].present || list[EFFECT_SPECULAR_TRANSMISSION].present,
               unhit = list[EFFECT_POINT_LIGHTS].present || list[EFFECT_SPOT_LIGHTS].present ||
                       list[EFFECT_DISTANT_LIGHTS].present;
    return (survey_rule_t){.any = !specular || !unhit,
                           .hits = list[EFFECT_AREA_LIGHTS].present || list[EFFECT_ENVIRONMENT].present,
                           .hit_stays = specular};
}

uint64_t plan_survey_size(const plan_t *plan)
{
    const settings_t *s = &plan->settings;
    if (!plan_is_chains(plan) || s->effects[SETTINGS_ALL_TECHNIQUES] == SETTINGS_SWITCH_ON ||
        plan->candidates < SURVEY_LEAST || !survey_rule(plan).any)
        return 0;
    const uint64_t parts = SURVEY_PARTS * (uint64_t)plan->pilot_unit;
    return (plan->candidates + parts - 1) / parts;
}

/* Whether a technique of these lengths is idle. */
static bool lengths_are_idle(const plan_t *plan, uint32_t first, uint32_t last)
{
    bool any = false;
    for (uint32_t k = first; k <= last; k++)
        any = any || plan->idle[k - 1].words[0] || plan->idle[k - 1].words[1];
    return any;
}

fault_code_t plan_survey_record(const plan_t *plan, int round, uint64_t index, work_record_t *record)
{
    const bool any = round == 0 || lengths_are_idle(plan, 1, plan->settings.max_path_length);
    record->kind = WORK_REFINE;
    record->first = SURVEY_FIRST + index * plan->pilot_unit;
    record->count = any ? plan->pilot_unit : 1; /* nothing to be tried */
    return round > 0 ? plan_set_idle(plan, record, NULL) : FAULT_NONE;
}

bool plan_is_survey(const work_record_t *record)
{
    return record->kind == WORK_REFINE && record->first >= SURVEY_FIRST;
}

static uint32_t survey_moments(const plan_t *plan)
{
    return work_samples_moment(plan->settings.max_path_length + 1);
}

size_t plan_survey_bytes(const plan_t *plan)
{
    return 2 * plan->survey_units * survey_moments(plan) * sizeof *plan->survey;
}

static const work_moments_t *survey_unit(const plan_t *plan, int round, uint64_t unit)
{
    return plan->survey + ((uint64_t)round * plan->survey_units + unit) * survey_moments(plan);
}

static work_moments_t survey_sum(const plan_t *plan, int round, uint32_t moment)
{
    return work_moments_sum(survey_unit(plan, round, 0) + moment, plan->survey_units, survey_moments(plan));
}

/* The most that the technique has of the length's energy. */
static double survey_share(const plan_t *plan, uint32_t k, uint32_t s)
{
    const work_moments_t all = survey_sum(plan, 0, work_samples_moment(k)),
                         part = survey_sum(plan, 0, work_samples_moment(k) + 1 + s);
    return (part.sum + 1.645 * sqrt(part.sum2)) / all.sum + 3 * all.sum2 / (all.sum * all.sum);
}

static void survey_propose(plan_t *plan, survey_rule_t rule, uint32_t k)
{
    target_idle_t *idle = &plan->idle[k - 1];
    uint32_t stays = 0;
    double energy = 0;
    *idle = (target_idle_t){{0, 0}};
    plan->idle_energy[k - 1] = 0;
    if (!(survey_sum(plan, 0, work_samples_moment(k)).sum > 0))
        return;
    for (uint32_t s = rule.hits ? 0 : 1; s <= k; s++) {
        const double share = survey_share(plan, k, s);
        if (share < IDLE_SHARE && (s > 0 || !rule.hit_stays)) {
            idle->words[s / 64] |= UINT64_C(1) << (s % 64);
            energy += share;
        } else {
            stays += s > 0 || rule.hit_stays;
        }
    }
    if (stays == 0)
        *idle = (target_idle_t){{0, 0}};
    else
        plan->idle_energy[k - 1] = energy;
}

static void survey_try(plan_t *plan, uint32_t k)
{
    const work_moments_t with = survey_sum(plan, 0, work_samples_moment(k)),
                         without = survey_sum(plan, 1, work_samples_moment(k));
    if (without.sum2 <= IDLE_RISE * with.sum2)
        return;
    plan->idle[k - 1] = (target_idle_t){{0, 0}};
    plan->idle_energy[k - 1] = 0;
}

/* What the units say that are in; both rounds, once each. */
static void survey_settle(plan_t *plan)
{
    for (int round = 0; round < 2; round++) {
        uint64_t in = 0;
        for (uint64_t i = 0; i < plan->survey_units; i++)
            in += survey_unit(plan, round, i)->n > 0;
        if (plan->has_idle[round] || in < plan->survey_units || plan->survey_units == 0)
            continue;
        const survey_rule_t rule = survey_rule(plan);
        for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
            if (round == 0)
                survey_propose(plan, rule, k);
            else
                survey_try(plan, k);
        }
        plan->has_idle[round] = true;
    }
}

void plan_absorb_survey(plan_t *plan, int round, const work_record_t *record, const work_result_t *result)
{
    const uint64_t unit = (record->first - SURVEY_FIRST) / plan->pilot_unit;
    memcpy(plan->survey + ((uint64_t)round * plan->survey_units + unit) * survey_moments(plan), result->moments,
           sizeof *plan->survey * survey_moments(plan));
    survey_settle(plan);
}

bool plan_survey_has(const plan_t *plan, int round)
{
    return plan->survey_units == 0 || plan->has_idle[round];
}

double plan_survey_in(const plan_t *plan, int round, uint64_t index)
{
    return survey_unit(plan, round, index)->n;
}

fault_code_t plan_set_idle(const plan_t *plan, work_record_t *record, fault_t *fault)
{
    const uint32_t first = record->length > 0 ? record->length : 1,
                   last = record->length > 0 ? record->length : plan->settings.max_path_length;
    if (!lengths_are_idle(plan, first, last))
        return FAULT_NONE;
    record->idle = malloc(sizeof *record->idle * (last - first + 1));
    if (!record->idle)
        return fault_set(fault, FAULT_MEMORY, "no memory for a unit's idle techniques");
    record->idle_count = last - first + 1;
    memcpy(record->idle, plan->idle + first - 1, sizeof *record->idle * record->idle_count);
    return FAULT_NONE;
}

void plan_report_idle(const plan_t *plan, uint32_t k, json_t *length)
{
    if (plan->survey_units == 0 || !plan->has_idle[1])
        return;
    json_t *list = json_new_array();
    for (uint32_t s = 0; s <= k; s++)
        if (target_is_idle(&plan->idle[k - 1], s))
            json_append(list, json_new_number(s));
    json_add(length, "idle", list);
    json_add_number(length, "idle_energy", plan->idle_energy[k - 1]);
}

bool plan_say_idle(const plan_t *plan, char *text, size_t size)
{
    uint32_t idle = 0, all = 0;
    if (!plan_survey_has(plan, 1))
        return false;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        all += k + 1;
        for (uint32_t s = 0; s <= k; s++)
            idle += target_is_idle(&plan->idle[k - 1], s);
    }
    if (idle > 0)
        snprintf(text, size, "%u of %u have less than %g %% of their length's energy", idle, all, 100 * IDLE_SHARE);
    return idle > 0;
}

void plan_survey_put(wire_writer_t *out, const plan_t *plan)
{
    packed_put(out, "survey", plan->survey, plan_survey_bytes(plan));
}

fault_code_t plan_survey_get(wire_reader_t *in, plan_t *plan)
{
    TRY(packed_get(in, "survey", plan->survey, plan_survey_bytes(plan)));
    for (size_t i = 0; i < plan_survey_bytes(plan) / sizeof *plan->survey; i++)
        if (!work_moments_are_sound(&plan->survey[i]))
            return wire_reader_fail(in, FAULT_RANGE, "survey", "entry %zu is negative or not finite", i);
    survey_settle(plan);
    return FAULT_NONE;
}
