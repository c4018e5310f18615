#include "plan/plan_shorten.h"

#include <math.h>

#include "plan/plan_budget.h"
#include "plan/plan_state.h"

enum {
    SHORTEN_LEAST = 256, /* mutations a chain */
    SHORTEN_ENDLESS = 5  /* 1 + ln(16384 / 256), nearly */
};

static const double SHORTEN_UNSEEN = 0.1;

/* ---- seeds ---- */

static double shorten_unseen(const double *weights, uint64_t count, double chains)
{
    const double part = 1 / weights[count - 1];
    double sum = 0, before = 0;
    for (uint64_t i = 0; i < count; i++) {
        const double own = (weights[i] - before) * part;
        sum += chains * own > 1 ? own * (chains * own - 1) : 0;
        before = weights[i];
    }
    return sum;
}

double plan_shorten_seeds(const double *weights, uint64_t count)
{
    double squares = 0, before = 0;
    if (!(weights[count - 1] > 0))
        return 0;
    for (uint64_t i = 0; i < count; i++) {
        const double own = (weights[i] - before) / weights[count - 1];
        squares += own * own;
        before = weights[i];
    }
    /* unseen(n) >= n sum p^2 - 1, so no more than these may be */
    double chains = (1 + SHORTEN_UNSEEN) / squares;
    while (chains > 1 && shorten_unseen(weights, count, chains) > SHORTEN_UNSEEN)
        chains /= 1.25;
    return fmax(chains, 1);
}

/* Weights are running sums by then. */
void plan_shorten_init(plan_t *plan)
{
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++)
        plan->shorten.seeds[k] = plan_has_seeds(plan, k) && plan->lengths[k].weights
                                     ? plan_shorten_seeds(plan->lengths[k].weights, plan->candidates)
                                     : 0;
}

/* ---- lengths ---- */

/* Mutations of a chain of lengths[k] where nothing is done: a unit's, if they are fewer than usual. */
static uint64_t shorten_base(const plan_t *plan, uint32_t k)
{
    const uint64_t usual = plan_chain_length(plan), unit = plan->lengths[k].unit_mutations;
    return unit < usual ? unit : usual;
}

/* Mutations of lengths[k] for each seed that is left. */
static double shorten_part(const plan_t *plan, uint32_t k, double seeds_left)
{
    const plan_length_t *length = &plan->lengths[k];
    const double handed = (double)length->handed,
                 expected = length->share * PLAN_USUAL_RATE * plan->job.stop.seconds;
    return length->budget != UINT64_MAX ? ((double)length->budget - handed) / seeds_left
                                        : SHORTEN_ENDLESS * fmax(handed, expected) / plan->shorten.seeds[k];
}

uint64_t plan_shorten_chain(const plan_t *plan, uint32_t k)
{
    const plan_length_t *length = &plan->lengths[k];
    const double usual = (double)plan_chain_length(plan),
                 seeds_left = plan->shorten.seeds[k] - (double)length->chains;
    if (plan->settings.chain_length > 0 || seeds_left <= 0)
        return plan_chain_length(plan);
    const double least = fmax((double)length->unit_mutations / seeds_left, SHORTEN_LEAST);
    return (uint64_t)fmin(ceil(fmax(shorten_part(plan, k, seeds_left), least)), usual);
}

void plan_shorten_absorb(plan_t *plan, const work_record_t *record, double weight)
{
    double *largest = &plan->shorten.largest[record->length];
    *largest = fmax(*largest, weight * ((double)record->mutations / (double)record->count));
}

/* ---- the report ---- */

double plan_shorten_bound(const plan_t *plan, uint32_t k)
{
    const double counted = plan_counted(plan, k);
    return counted > 0 ? fmin(plan->shorten.largest[k] / counted, 1) : 0;
}

json_t *plan_shorten_json(const plan_t *plan)
{
    json_t *list = json_new_array();
    for (uint32_t k = plan_first(plan); plan->settings.chain_length == 0 && k <= plan_last(plan); k++) {
        const plan_length_t *length = &plan->lengths[k];
        if (plan_is_samples(plan, k) || length->chains == 0)
            continue;
        const double base = (double)shorten_base(plan, k), mean = (double)length->handed / (double)length->chains;
        if (mean > 0.5 * base)
            continue;
        json_t *object = json_new_object();
        json_add_number(object, "length", k);
        json_add_number(object, "from", base);
        json_add_number(object, "to", rint(mean));
        json_append(list, object);
    }
    return list;
}

/* ---- bytes ---- */

void plan_shorten_put(wire_writer_t *out, const plan_t *plan)
{
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        wire_put_f64(out, plan->shorten.largest[k]);
}

fault_code_t plan_shorten_get(wire_reader_t *in, plan_t *plan)
{
    const uint32_t K = plan->settings.max_path_length;
    for (uint32_t k = 0; k <= K && !in->code; k++) {
        const double most = plan_is_samples(plan, k) ? 0 : (double)plan->lengths[k].counted + 1,
                     largest = plan->shorten.largest[k] = wire_get_f64(in, "largest chain");
        if (!in->code && !(largest >= 0 && largest <= (plan->lengths[k].merged > 0 ? most : 0)))
            return wire_reader_fail(in, FAULT_RANGE, "largest chain", "%g of length %u, expected at most %g",
                                    largest, k, most);
    }
    return in->code;
}
