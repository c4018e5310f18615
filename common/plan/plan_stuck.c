#include "plan/plan_stuck.h"

#include "plan/plan_estimate.h"
#include "plan/plan_state.h"

void plan_stuck_absorb(plan_t *plan, const work_record_t *record, const work_result_t *result)
{
    plan->lengths[record->length].stuck_rejections += result->stuck.rejections;
    stuck_add(&plan->stuck, &result->stuck);
}

fault_code_t plan_stuck_check(const plan_t *plan, wire_reader_t *in)
{
    uint64_t rejections = 0;
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++) {
        const plan_length_t *length = &plan->lengths[k];
        if (length->stuck_rejections > (k == 0 ? 0 : length->merged))
            return wire_reader_fail(in, FAULT_RANGE, "stuck rejections", "%llu of %llu mutations of length %u",
                                    (unsigned long long)length->stuck_rejections,
                                    (unsigned long long)length->merged, k);
        rejections += length->stuck_rejections;
    }
    if (rejections != plan->stuck.rejections)
        return wire_reader_fail(in, FAULT_FORMAT, "stuck rejections", "%llu, of all lengths %llu",
                                (unsigned long long)plan->stuck.rejections, (unsigned long long)rejections);
    return FAULT_NONE;
}

/* Light that was splatted by stuck states over all light: of length k, b_k rejections / mutations. */
static double plan_stuck_weight(const plan_t *plan)
{
    double stuck = 0, all = 0, error;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        const plan_length_t *length = &plan->lengths[k];
        const double b = plan_length_b(plan, k, &error);
        all += plan_splits(plan) ? length->light : b;
        if (length->merged > 0)
            stuck += b * (double)length->stuck_rejections / (double)length->merged;
    }
    return all > 0 ? stuck / all : NAN;
}

json_t *plan_stuck_json(const plan_t *plan)
{
    json_t *object = json_new_object(), *paths = json_new_array();
    json_add_number(object, "chains", (double)plan->stuck.stays);
    json_add_number(object, "weight", plan_stuck_weight(plan));
    for (uint32_t i = 0; i < plan->stuck.count; i++) {
        char text[STUCK_TEXT];
        stuck_print(&plan->stuck.paths[i], text);
        json_append(paths, json_new_string(text));
    }
    json_add(object, "paths", paths);
    return object;
}
