/* plan_accuracy.c: what a render's history says about the time that accuracy takes (stats/law.h). */
#include "plan/plan_accuracy.h"

#include <math.h>

#include "plan/plan_estimate.h"
#include "stats/law.h"
#include "plan/plan_regions.h"

/* What relMSE would be if the points of samples were as even as they are going to be. */
static double accuracy_outlook(const plan_t *plan, const plan_error_t *error)
{
    const double samples = plan_is_samples(plan, 0) ? error->lengths[0] : 0, outlook = plan_nets_outlook(plan);
    return fmax(error->relmse - samples * (1 - outlook), error->relmse * outlook);
}

/* The relative standard error of the outlook as far as it is known. By the filter's weights relMSE is off by a
 * tenth beside, and the outlook by half of what it takes off (docs/accuracy.md). */
static double accuracy_spread(const plan_error_t *error, double outlook)
{
    const double filter = error->weighed ? 0 : 0.1, ahead = 0.5 * (error->relmse / outlook - 1);
    return error->reliable ? hypot(hypot(error->spread, filter), ahead) : NAN;
}

void plan_note_error(plan_t *plan)
{
    plan_nets_measure(plan);
    plan_error_t error;
    plan_estimate_error(plan, &error);
    plan->error = sqrt(error.relmse);
    const double outlook = accuracy_outlook(plan, &error);
    history_add(&plan->history, &(history_point_t){.seconds = plan->seconds,
                                                   .cpu_seconds = plan->totals.cpu_seconds,
                                                   .mutations = plan_merged(plan),
                                                   .relmse = error.relmse,
                                                   .outlook = outlook,
                                                   .spread = accuracy_spread(&error, outlook)});
    plan_predict(plan);
}

void plan_predict(plan_t *plan)
{
    law_t law;
    plan->predicted = NAN;
    if (plan->job.stop.error > 0 && law_fit(&law, &plan->history, plan->history.count, plan->pilot_cpu_seconds))
        plan->predicted = law_time(&law, plan->job.stop.error).median;
}

static json_t *accuracy_history(const plan_t *plan)
{
    json_t *list = json_new_array();
    for (uint32_t i = 0; i < plan->history.count; i++) {
        const history_point_t *point = &plan->history.points[i];
        json_t *entry = json_new_object();
        json_add_number(entry, "seconds", point->seconds);
        json_add_number(entry, "cpu_seconds", point->cpu_seconds);
        json_add_number(entry, "mutations", point->mutations);
        json_add_number(entry, "relmse", point->relmse);
        json_add_number(entry, "error", sqrt(point->relmse));
        json_append(list, entry);
    }
    return list;
}

/* CPU seconds of workers to wall seconds with the workers that the job has had: both at the last point. */
static double accuracy_pace(const plan_t *plan)
{
    const history_point_t *last = &plan->history.points[plan->history.count - 1];
    return last->cpu_seconds > 0 && last->seconds > 0 ? last->seconds / last->cpu_seconds : NAN;
}

static json_t *accuracy_targets(const law_t *law, double pace)
{
    static const double errors[] = {0.1, 0.05, 0.02, 0.01};
    json_t *list = json_new_array();
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
        const law_time_t time = law_time(law, errors[i]);
        json_t *target = json_new_object();
        json_add_number(target, "error", errors[i]);
        json_add_number(target, "seconds", time.median * pace);
        json_add_number(target, "low", time.low * pace);
        json_add_number(target, "high", time.high * pace);
        json_add_number(target, "worker_hours", time.median / 3600);
        json_append(list, target);
    }
    return list;
}

/* What the first tenth of the work after the pilot said about when the error would be what it is in the end; or the
 * first estimate of all, if that is later. */
static json_t *accuracy_first_tenth(const plan_t *plan)
{
    const history_t *history = &plan->history;
    const double end = history->points[history->count - 1].cpu_seconds, pilot = plan->pilot_cpu_seconds,
                 pace = accuracy_pace(plan);
    uint32_t count = 0;
    while (count < history->count &&
           (count == 0 || history->points[count].cpu_seconds <= pilot + 0.1 * (end - pilot)))
        count++;
    if (count == history->count)
        return NULL;
    law_t law;
    if (!law_fit(&law, history, count, pilot))
        return NULL;
    json_t *object = json_new_object();
    json_add_number(object, "at_seconds", history->points[count - 1].cpu_seconds * pace);
    const law_time_t time = law_time(&law, sqrt(history->points[history->count - 1].relmse));
    json_add_number(object, "predicted_seconds", time.median * pace);
    json_add_number(object, "low", time.low * pace);
    json_add_number(object, "high", time.high * pace);
    json_add_number(object, "actual_seconds", end * pace);
    json_add_bool(object, "reliable", isfinite(history->points[count - 1].spread));
    return object;
}

static json_t *accuracy_prediction(const plan_t *plan)
{
    law_t law;
    if (!law_fit(&law, &plan->history, plan->history.count, plan->pilot_cpu_seconds))
        return NULL;
    json_t *prediction = json_new_object(), *numbers = json_new_object();
    json_add_number(numbers, "a", law.a);
    json_add_number(numbers, "c", law.c);
    json_add_number(numbers, "p", law.p);
    json_add_number(numbers, "from_cpu_seconds", law.pilot);
    json_add(prediction, "law", numbers);
    json_add(prediction, "targets", accuracy_targets(&law, accuracy_pace(plan)));
    json_add_number(prediction, "workers", 1 / accuracy_pace(plan));
    json_t *tenth = plan->stopped ? accuracy_first_tenth(plan) : NULL;
    if (tenth)
        json_add(prediction, "first_tenth", tenth);
    return prediction;
}

static json_t *accuracy_groups(const plan_t *plan)
{
    plan_group_figures_t figures;
    if (!plan_estimate_groups(plan, &figures))
        return NULL;
    json_t *groups = json_new_object(), *brightness = json_new_array(), *deviation = json_new_array();
    double squares = 0;
    for (int g = 0; g < GROUPS_COUNT; g++) {
        json_append(brightness, json_new_number(figures.brightness[g]));
        json_append(deviation, json_new_number(figures.deviation[g]));
        squares += (figures.brightness[g] - 1) * (figures.brightness[g] - 1);
    }
    json_add_number(groups, "count", GROUPS_COUNT);
    json_add(groups, "brightness", brightness);
    json_add_number(groups, "spread", sqrt(squares / (GROUPS_COUNT - 1)));
    json_add(groups, "deviation", deviation);
    return groups;
}

/* Row by row from the top left. */
static json_t *accuracy_regions(const plan_t *plan)
{
    const uint32_t part = GROUPS_SIDE / PLAN_REGION_SIDE;
    json_t *object = json_new_object(), *values = json_new_array();
    for (uint32_t r = 0; r < PLAN_REGIONS; r++) {
        bool blocks[GROUPS_BLOCKS];
        for (uint32_t i = 0; i < GROUPS_BLOCKS; i++)
            blocks[i] = i / GROUPS_SIDE / part * PLAN_REGION_SIDE + i % GROUPS_SIDE / part == r;
        plan_region_t region;
        if (!plan_estimate_region(plan, blocks, &region))
            region = (plan_region_t){NAN, NAN, NAN};
        json_t *value = json_new_object();
        json_add_number(value, "luminance", region.mean);
        json_add_number(value, "low", region.low);
        json_add_number(value, "high", region.high);
        json_append(values, value);
    }
    json_add_number(object, "columns", PLAN_REGION_SIDE);
    json_add_number(object, "rows", PLAN_REGION_SIDE);
    json_add(object, "values", values);
    return object;
}

void plan_report_accuracy(const plan_t *plan, json_t *report)
{
    json_add(report, "history", accuracy_history(plan));
    json_t *prediction = plan->history.count > 0 ? accuracy_prediction(plan) : NULL,
           *groups = plan->history.count > 0 ? accuracy_groups(plan) : NULL;
    if (prediction)
        json_add(report, "prediction", prediction);
    if (groups)
        json_add(report, "groups", groups);
    if (plan->history.count > 0)
        json_add(report, "regions", accuracy_regions(plan));
}
