/* plan_report.c: the report (docs/reports.md): what was done, what it found, what it cost. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plan/effects.h"
#include "plan/plan_accuracy.h"
#include "plan/plan_estimate.h"
#include "plan/plan_idle.h"
#include "plan/plan_left_out.h"
#include "plan/plan_missed.h"
#include "plan/plan_state.h"
#include "plan/plan_strata.h"
#include "plan/plan_stuck.h"

static const char *const move_names[WORK_MOVES] = {"large", "small",   "technique", "jump",      "camera",
                                                   "light", "inverse", "exchange",  "auxiliary", "second"};
static const char *const reject_names[WORK_REJECTS] = {"nonfinite_ray", "nonfinite_weight", "nonfinite_value",
                                                       "negative_value"};

static json_t *report_estimate(double value, double error)
{
    json_t *object = json_new_object();
    json_add_number(object, "value", value);
    json_add_number(object, "standard_error", error);
    return object;
}

static json_t *report_moves(const plan_length_t *length)
{
    json_t *moves = json_new_object();
    for (int i = 0; i < WORK_MOVES; i++) {
        if (length->proposed[i] == 0)
            continue;
        json_t *move = json_new_object();
        json_add_number(move, "proposed", (double)length->proposed[i]);
        json_add_number(move, "acceptance", exact_value(&length->accepted[i], 1) / (double)length->proposed[i]);
        json_add(moves, move_names[i], move);
    }
    return moves;
}

/* What leaving failures out does, measured by the run itself: its law is C (1 - p_fail), and the same chains with
 * failures counted follow C. The two differ by the failures' weights, summed over blocks of the image. */
static json_t *report_bias(const plan_t *plan, const plan_length_t *length)
{
    const settings_t *s = &plan->settings;
    double published[WORK_FAILED_BLOCKS] = {0}, failed = 0, total = 0, variation = 0, worst = 0;
    for (size_t p = 0; length->film.sums && p < plan->pixels; p++) {
        const size_t x = p % s->width * WORK_FAILED_SIDE / s->width,
                     y = p / s->width * WORK_FAILED_SIDE / s->height;
        const int64_t *sum = length->film.sums + FILM_CHANNELS * p;
        const rgb_t value = rgb((double)sum[0], (double)sum[1], (double)sum[2]);
        published[y * WORK_FAILED_SIDE + x] +=
            (s->target == SETTINGS_TARGET_LUMINANCE ? rgb_luminance(value) : rgb_max(value)) / FILM_ONE;
    }
    for (int i = 0; i < WORK_FAILED_BLOCKS; i++) {
        total += published[i];
        failed += (double)length->failed[i];
    }
    for (int i = 0; i < WORK_FAILED_BLOCKS && total > 0; i++) {
        const double biased = published[i] / total,
                     plain = (published[i] + (double)length->failed[i]) / (total + failed);
        variation += 0.5 * fabs(biased - plain);
        if (plain > 1e-3) /* blocks of hardly any light say nothing */
            worst = fmax(worst, fabs(biased / plain - 1));
    }
    json_t *bias = json_new_object();
    json_add_number(bias, "failure_share", total > 0 ? failed / (total + failed) : 0);
    json_add_number(bias, "total_variation", variation);
    json_add_number(bias, "largest_block", worst);
    return bias;
}

/* What the chains of one length, or of all, did. */
static void report_chains(const plan_t *plan, const plan_length_t *length, json_t *object)
{
    json_add_number(object, "mutations", (double)length->merged);
    json_add_number(object, "chains", (double)length->chains);
    json_add_number(object, "cpu_seconds", length->cpu_seconds);
    json_add(object, "moves", report_moves(length));
    json_add_number(object, "zero_contribution", (double)length->zero_proposals);
    json_add_number(object, "longest_stay", (double)length->longest_stay);
    if (plan->settings.failures == SETTINGS_FAILURES_PUBLISHED)
        json_add(object, "bias", report_bias(plan, length));
}

static json_t *report_length(const plan_t *plan, const plan_error_t *estimate, uint32_t k)
{
    json_t *object = json_new_object();
    json_add_number(object, "length", k);
    double error;
    double b = plan_length_b(plan, k, &error);
    json_add(object, "b", report_estimate(b, error));
    json_t *techniques = json_new_array();
    for (uint32_t s = 0; s <= k; s++) {
        b = plan_technique_b(plan, k, s, &error);
        json_t *technique = report_estimate(b, error);
        json_add_number(technique, "s", s);
        json_append(techniques, technique);
    }
    json_add(object, "techniques", techniques);
    plan_report_idle(plan, k, object);
    if (plan_is_whole(plan))
        return object;
    if (plan_splits(plan)) {
        json_add_number(object, "light", plan->lengths[k].light);
        json_add_number(object, "cap", plan->caps[k - 1]);
        json_add_number(object, "rate", plan->rates[k - 1]);
    }
    json_add_number(object, "most", plan->lengths[k].most);
    json_add_number(object, "relmse", plan->lengths[k].merged > 0 ? estimate->lengths[k] : NAN);
    json_add_number(object, "share", plan->lengths[k].share);
    json_t *eras = plan->lengths[k].share > 0 ? plan_eras_json(plan, k) : NULL;
    if (eras)
        json_add(object, "eras", eras);
    if (plan->lengths[k].trials > 0) {
        json_add_number(object, "inefficiency", plan->lengths[k].inefficiency);
        json_add_number(object, "rays", plan->lengths[k].cost);
        json_add_number(object, "steps", ldexp(1, plan->lengths[k].steps.steps));
        json_add_number(object, "large_step", ldexp(plan->settings.large_step, plan->lengths[k].steps.large));
    }
    report_chains(plan, &plan->lengths[k], object);
    return object;
}

static json_t *report_error(const plan_error_t *estimate)
{
    json_t *error = json_new_object(), *interval = json_new_array();
    json_add_number(error, "relmse", estimate->relmse);
    json_add_number(error, "error", sqrt(estimate->relmse));
    json_append(interval, json_new_number(estimate->low));
    json_append(interval, json_new_number(estimate->high));
    json_add(error, "interval", interval);
    json_add_string(error, "method",
                    "variance between units of work, and of b; interval from contrasts of 16 groups of units");
    json_add(error, "reliable", json_new_bool(estimate->reliable));
    if (!estimate->reliable)
        json_add_string(error, "reason", estimate->reason);
    return error;
}

/* Where the time went, over all workers. */
static json_t *report_time_parts(const plan_t *plan)
{
    const work_stats_t *totals = &plan->totals;
    json_t *parts = json_new_object();
    json_add_number(parts, "tracing", totals->tracing_seconds);
    json_add_number(parts, "shading",
                    fmax(0, totals->cpu_seconds - totals->tracing_seconds - totals->inversion_seconds));
    json_add_number(parts, "inversion", totals->inversion_seconds);
    json_add_number(parts, "merging", totals->merging_seconds);
    json_add_number(parts, "waiting", totals->waiting_seconds);
    return parts;
}

static json_t *report_rejects(const plan_t *plan)
{
    json_t *rejects = json_new_object();
    for (int i = 0; i < WORK_REJECTS; i++)
        json_add_number(rejects, reject_names[i], (double)plan->totals.rejects[i]);
    json_add_number(rejects, "film_nonfinite", (double)plan->film_counts.nonfinite);
    json_add_number(rejects, "film_negative", (double)plan->film_counts.negative);
    json_add_number(rejects, "film_saturated", (double)plan->film_counts.saturated);
    return rejects;
}

static json_t *report_rates(const plan_t *plan, double merged)
{
    double render = 0; /* of chains or samples alone */
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        render += plan->lengths[k].cpu_seconds;
    json_t *rates = json_new_object();
    json_add_number(rates, "mutations", merged);
    json_add_number(rates, "mutations_per_pixel", merged / (double)plan->pixels);
    json_add_number(rates, "mutations_per_cpu_second", render > 0 ? merged / render : NAN);
    json_add_number(rates, "rays", (double)(plan->totals.rays + plan->totals.shadow_rays));
    json_add_number(rates, "shadow_rays", (double)plan->totals.shadow_rays);
    json_add_number(rates, "rays_per_cpu_second",
                    (double)(plan->totals.rays + plan->totals.shadow_rays) / plan->totals.cpu_seconds);
    return rates;
}

/* Energies that are known: what was measured because the job leaves something out; else that of indirect light,
 * from the lengths. */
static void report_energies(const plan_t *plan, effect_energy_t energy[EFFECT_COUNT])
{
    double all = 0, indirect = 0, error;
    for (int kind = 0; kind < EFFECT_COUNT; kind++)
        energy[kind] = (effect_energy_t){NAN, NAN};
    for (uint32_t e = 0; plan->left_out_units > 0 && e < SETTINGS_EFFECTS; e++) {
        const plan_energy_t measured = plan_left_out_energy(plan, e);
        if (e != SETTINGS_APERTURE)
            energy[effects_switched((settings_effect_t)e)] = (effect_energy_t){measured.share, measured.error};
    }
    if (plan->left_out_units > 0)
        return;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        const double b = plan_splits(plan) ? plan->lengths[k].light : plan_length_b(plan, k, &error);
        all += b;
        indirect += k > 2 ? b : 0;
    }
    energy[EFFECT_INDIRECT].share = all > 0 ? indirect / all : NAN;
}

/* What the scene has. */
static json_t *report_effects(const plan_t *plan)
{
    effects_t effects;
    effect_energy_t energy[EFFECT_COUNT];
    report_energies(plan, energy);
    effects_analyse(&effects, plan->scene, &plan->settings);
    effect_t *split = &effects.list[EFFECT_SPLIT];
    if (split->present && !plan_splits(plan)) {
        split->present = false;
        snprintf(split->reason, sizeof split->reason, "the rules leave too few mutations to measure what to split");
    }
    effect_t *techniques = &effects.list[EFFECT_ALL_TECHNIQUES];
    if (plan_say_idle(plan, techniques->reason, sizeof techniques->reason))
        techniques->present = false;
    return effects_json(&effects, energy);
}

/* What the image is missing. */
static json_t *report_left_out(const plan_t *plan)
{
    const plan_energy_t all = plan_left_out_energy(plan, WORK_LEFT_OUT_ALL);
    double samples = 0;
    for (uint64_t i = 0; i < plan->left_out_units; i++)
        samples += plan->left_out[i * WORK_LEFT_OUT_MOMENTS].n;
    json_t *object = json_new_object();
    json_add_number(object, "energy", all.share);
    json_add_number(object, "standard_error", all.error);
    json_add_number(object, "samples", samples);
    return object;
}

json_t *plan_report(const plan_t *plan)
{
    json_t *root = json_new_object();
    json_add_string(root, "garland", GARLAND_VERSION);
    json_add_string(root, "instructions", GARLAND_ARCH);
    char *text = job_print(&plan->job);
    json_t *job = NULL;
    if (text && !json_parse(&job, text, strlen(text), NULL))
        json_add(root, "job", job);
    free(text);
    json_add_string(root, "algorithm", settings_algorithm_name(plan->settings.algorithm));
    if (plan->settings.failures == SETTINGS_FAILURES_PUBLISHED)
        json_add_string(root, "biased", PLAN_BIASED);
    json_add_number(root, "width", plan->settings.width);
    json_add_number(root, "height", plan->settings.height);
    json_add_number(root, "max_path_length", plan->settings.max_path_length);
    if (plan->stopped_by)
        json_add_string(root, "stopped_by", plan->stopped_by);
    json_t *time = json_new_object();
    json_add_number(time, "wall_seconds", plan->seconds);
    json_add_number(time, "pilot_cpu_seconds", plan->pilot_cpu_seconds);
    json_add_number(time, "render_cpu_seconds", plan->totals.cpu_seconds - plan->pilot_cpu_seconds);
    json_add(time, "parts", report_time_parts(plan));
    json_add(root, "time", time);
    json_add(root, "effects", report_effects(plan));
    if (plan->left_out_units > 0)
        json_add(root, "left_out", report_left_out(plan));
    plan_error_t estimate;
    plan_estimate_error(plan, &estimate);
    json_add(root, "error", report_error(&estimate));
    plan_report_accuracy(plan, root);
    if (plan_is_chains(plan))
        json_add_number(root, "stratification", plan_estimate_strata(plan));
    if (plan_is_samples(plan, 0))
        json_add_number(root, "nets", plan->nets.all);
    json_add(root, "rates", report_rates(plan, plan_merged(plan)));
    json_t *lengths = json_new_array();
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        json_append(lengths, report_length(plan, &estimate, k));
    json_add(root, "lengths", lengths);
    if (plan_is_whole(plan) && plan_is_chains(plan)) {
        json_t *chains = json_new_object();
        report_chains(plan, &plan->lengths[0], chains);
        json_add(root, "chains", chains);
    }
    if (plan_splits(plan)) {
        json_t *samples = json_new_object();
        json_add_number(samples, "relmse", plan->lengths[0].merged > 0 ? estimate.lengths[0] : NAN);
        json_add_number(samples, "share", plan->lengths[0].share);
        json_t *eras = plan->lengths[0].share > 0 ? plan_eras_json(plan, 0) : NULL;
        if (eras)
            json_add(samples, "eras", eras);
        json_add_number(samples, "samples", (double)plan->lengths[0].merged);
        json_add_number(samples, "cpu_seconds", plan->lengths[0].cpu_seconds);
        json_add_bool(samples, "alone", plan->samples_alone);
        json_add_number(samples, "promise", plan->split_promise);
        json_add(root, "samples", samples);
    }
    if (plan_is_chains(plan) && !plan_is_whole(plan) && !plan_splits(plan) && plan->phase != PLAN_PILOT)
        json_add(root, "missed", plan_missed_json(plan));
    if (plan_is_chains(plan))
        json_add(root, "stuck", plan_stuck_json(plan));
    json_t *pilot = json_new_object();
    json_add_number(pilot, "candidates", (double)plan->candidates);
    json_add_number(pilot, "trial_chains", (double)plan->trial_units);
    json_add_number(pilot, "refining_samples", (double)plan->refine_handed);
    json_add(root, "pilot", pilot);
    json_add(root, "rejected", report_rejects(plan));
    return root;
}
