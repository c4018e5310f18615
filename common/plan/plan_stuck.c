#include "plan/plan_stuck.h"

#include "plan/plan_estimate.h"
#include "plan/plan_state.h"

void plan_stuck_absorb(plan_t *plan, const work_record_t *record, const work_result_t *result, double weight)
{
    uint64_t *light = &plan->lengths[record->length].stuck_light;
    stuck_t stuck = result->stuck;
    if (weight != 1) {
        const double scaled = (double)stuck.light * weight;
        stuck.light = scaled < 0x1p63 ? (uint64_t)(scaled + 0.5) : UINT64_MAX;
    }
    *light = stuck_sum_light(*light, stuck.light);
    stuck_add(&plan->stuck, &stuck);
}

fault_code_t plan_stuck_check(const plan_t *plan, wire_reader_t *in)
{
    uint64_t mutations = 0, light = 0;
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++) {
        const plan_length_t *length = &plan->lengths[k];
        if (length->stuck_light > 0 && (length->merged == 0 || plan_is_samples(plan, k)))
            return wire_reader_fail(in, FAULT_RANGE, "stuck light", "%llu of length %u, which has no chains",
                                    (unsigned long long)length->stuck_light, k);
        mutations += plan_is_samples(plan, k) ? 0 : length->merged;
        light = stuck_sum_light(light, length->stuck_light);
    }
    if (plan->stuck.rejections > mutations)
        return wire_reader_fail(in, FAULT_RANGE, "stuck rejections", "%llu of %llu mutations",
                                (unsigned long long)plan->stuck.rejections, (unsigned long long)mutations);
    if (light != plan->stuck.light)
        return wire_reader_fail(in, FAULT_FORMAT, "stuck light", "%llu, of all lengths %llu",
                                (unsigned long long)plan->stuck.light, (unsigned long long)light);
    return FAULT_NONE;
}

/* Of the image's light what stuck states were splatted for, and the most that one chain has of lengths in which
 * some were stuck. */
typedef struct plan_stuck_shares {
    double weight, bound;
} plan_stuck_shares_t;

static plan_stuck_shares_t plan_stuck_shares(const plan_t *plan)
{
    plan_pixels_t pixels;
    double stuck = 0, most = 0, all = 0;
    plan_pixels_init(&pixels, plan);
    for (uint32_t i = 0; i < pixels.count; i++) {
        const uint32_t k = pixels.lengths[i];
        double light = 0;
        for (size_t p = 0; p < plan->pixels; p++) {
            const int64_t *sum = pixels.sums[i] + FILM_CHANNELS * p;
            light += rgb_luminance(rgb((double)sum[0], (double)sum[1], (double)sum[2]));
        }
        all += pixels.factor[i] * light;
        stuck += pixels.factor[i] * FILM_ONE * ((double)plan->lengths[k].stuck_light / STUCK_LIGHT_ONE);
        if (plan->lengths[k].stuck_light > 0)
            most = fmax(most, pixels.factor[i] * light * plan_shorten_bound(plan, k));
    }
    return all > 0 ? (plan_stuck_shares_t){stuck / all, most / all} : (plan_stuck_shares_t){NAN, NAN};
}

json_t *plan_stuck_json(const plan_t *plan)
{
    json_t *object = json_new_object(), *paths = json_new_array();
    const plan_stuck_shares_t shares = plan_stuck_shares(plan);
    json_add_number(object, "chains", (double)plan->stuck.stays);
    json_add_number(object, "weight", shares.weight);
    json_add_number(object, "bound", shares.bound);
    json_add(object, "shortened", plan_shorten_json(plan));
    for (uint32_t i = 0; i < plan->stuck.count; i++) {
        char text[STUCK_TEXT];
        stuck_print(&plan->stuck.paths[i], text);
        json_append(paths, json_new_string(text));
    }
    json_add(object, "paths", paths);
    return object;
}
