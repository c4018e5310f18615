/* plan_missed.c: how much light of a length there may be, by the pilot's candidates, and what chains cannot bring.
 *
 * c_i being a length's weights over N candidates, b their mean, s its standard error,
 *
 *     most = b + 1.645 s + 3 c* / N
 *
 * is an upper bound of 95 % for the length's light, if no path brings more than c*: the normal bound for what was
 * met, and the rule of three for what was not (an event that N trials have not shown has a probability below 3 /
 * N). c* is the largest weight of the length, or of all lengths where it has none. A length is measurable if b
 * > 1.645 s. Beyond the last that is, chains get mutations in proportion to the bound, no more; a length of which
 * no candidate carries light has nowhere to start chains from, and its bound is what the image may be missing.
 */
#include "plan/plan_missed.h"

#include <math.h>

static const double ONE_SIDED = 1.645, RULE_OF_THREE = 3;

static double missed_largest(const plan_t *plan, uint32_t k)
{
    double largest = 0;
    for (uint64_t i = 0; i < plan->candidates; i++)
        largest = fmax(largest, plan->lengths[k].weights[i]);
    return largest;
}

static double missed_error(const plan_t *plan, uint32_t k)
{
    const double n = (double)plan->candidates;
    double squares = 0;
    for (uint64_t i = 0; i < plan->candidates; i++) {
        const double d = plan->lengths[k].weights[i] - plan->lengths[k].b;
        squares += d * d;
    }
    return sqrt(squares / (n * (n - 1)));
}

void plan_bound_lengths(plan_t *plan)
{
    double all = 0;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++)
        all = fmax(all, missed_largest(plan, k));
    plan->measurable = 0;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        plan_length_t *length = &plan->lengths[k];
        const double largest = missed_largest(plan, k), error = missed_error(plan, k);
        length->most = length->b + ONE_SIDED * error +
                       RULE_OF_THREE * (largest > 0 ? largest : all) / (double)plan->candidates;
        if (length->b > ONE_SIDED * error)
            plan->measurable = k;
    }
}

double plan_least_share(const plan_t *plan, uint32_t k, double least)
{
    double all = 0;
    for (uint32_t i = 1; i <= plan->settings.max_path_length; i++)
        all += plan->lengths[i].b;
    return k > plan->measurable && all > 0 ? fmin(least, plan->lengths[k].most / all) : least;
}

json_t *plan_missed_json(const plan_t *plan)
{
    json_t *object = json_new_object(), *lengths = json_new_array();
    double most = 0, all = 0;
    for (uint32_t k = 1; k <= plan->settings.max_path_length; k++) {
        all += plan->lengths[k].b;
        if (plan->lengths[k].share > 0)
            continue;
        most += plan->lengths[k].most;
        json_append(lengths, json_new_number(k));
    }
    json_add(object, "lengths", lengths);
    json_add_number(object, "most", all > 0 ? most / all : NAN);
    return object;
}
