#include "plan/plan_shorten.h"

#include <math.h>

#include "plan/plan_budget.h"
#include "plan/plan_state.h"

enum {
    SHORTEN_UNITS = 2,   /* a length, of the first stage where stages are not eras */
    SHORTEN_LEAST = 256, /* mutations a chain */
    SHORTEN_LONG = 64,   /* parts of a chain: one is a long stay */
    SHORTEN_TIMES = 16   /* shorter */
};

static bool shorten_may(const plan_t *plan)
{
    return plan_is_chains(plan) && plan->settings.chain_length == 0;
}

/* ---- stages ---- */

static uint64_t shorten_first(const plan_t *plan)
{
    return plan->pilot_units + plan->trial_units;
}

static uint64_t stage_size(const plan_t *plan, uint32_t stage)
{
    const uint64_t lengths = plan_last(plan) - plan_first(plan) + 1;
    return SHORTEN_UNITS * lengths << (stage > 0 ? stage - 1 : 0);
}

/* Of a unit of the rendering. */
static uint32_t stage_of(const plan_t *plan, uint64_t unit)
{
    uint32_t stage = 0;
    for (uint64_t left = (unit - shorten_first(plan)) / stage_size(plan, 0); left > 0; left /= 2)
        stage++;
    return stage < PLAN_STAGES ? stage : PLAN_STAGES - 1;
}

/* Of the next unit. */
static uint32_t stage_next(const plan_t *plan)
{
    return plan->eras.count > 1 ? plan->eras.current : stage_of(plan, plan->unit_count);
}

/* Of a unit that is there. */
static uint32_t stage_of_unit(const plan_t *plan, const plan_unit_t *unit)
{
    return plan->eras.count > 1 ? unit->era : stage_of(plan, (uint64_t)(unit - plan->units));
}

bool plan_shorten_ready(const plan_t *plan)
{
    const uint32_t stage = stage_next(plan);
    return !shorten_may(plan) || plan->eras.count > 1 || stage < 2 ||
           plan->shorten.in[stage - 2] == stage_size(plan, stage - 2);
}

void plan_shorten_count(plan_t *plan, uint64_t unit)
{
    if (unit >= shorten_first(plan))
        plan->shorten.in[stage_of(plan, unit)]++;
}

/* ---- lengths ---- */

static uint64_t shorten_base(const plan_t *plan, uint32_t k)
{
    const uint64_t usual = plan_chain_length(plan), unit = plan->lengths[k].unit_mutations;
    return unit < usual ? unit : usual;
}

/* level_r of lengths[k]. */
static uint32_t shorten_level(const plan_t *plan, uint32_t stage, uint32_t k)
{
    uint32_t levels[PLAN_STAGES] = {0};
    for (uint32_t r = 2; r <= stage; r++) {
        const uint32_t own = levels[r - 2] + plan->shorten.cut[r - 2][k];
        levels[r] = own > levels[r - 1] ? own : levels[r - 1];
    }
    return levels[stage];
}

/* Weights are running sums by then. */
void plan_shorten_init(plan_t *plan)
{
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        const double *weights = plan->lengths[k].weights;
        double squares = 0;
        plan->shorten.seeds[k] = 0;
        if (!plan_has_seeds(plan, k) || !weights)
            continue;
        for (uint64_t i = 0; i < plan->candidates; i++) {
            const double own = weights[i] - (i > 0 ? weights[i - 1] : 0);
            squares += own * own;
        }
        const double sum = weights[plan->candidates - 1];
        plan->shorten.seeds[k] = squares > 0 ? sum * sum / squares : 0;
    }
}

uint64_t plan_shorten_chain(const plan_t *plan, uint32_t k)
{
    const uint32_t level = shorten_may(plan) ? shorten_level(plan, stage_next(plan), k) : 0;
    if (level == 0)
        return 0;
    const plan_length_t *length = &plan->lengths[k];
    const double base = (double)shorten_base(plan, k), seeds = plan->shorten.seeds[k] - (double)length->chains,
                 wanted = fmax(base * pow(SHORTEN_TIMES, -(double)level), SHORTEN_LEAST),
                 least = seeds > 0 ? (double)length->unit_mutations / seeds : base;
    return (uint64_t)fmin(fmax(wanted, ceil(least)), base);
}

void plan_shorten_absorb(plan_t *plan, const plan_unit_t *unit, const work_result_t *result, double weight)
{
    const work_record_t *record = &unit->record;
    const stuck_t *stuck = &result->stuck;
    const double chain = (double)record->mutations / (double)record->count;
    double *largest = &plan->shorten.largest[record->length];
    *largest = fmax(*largest, weight * chain);
    if (stuck->count > 0 && SHORTEN_LONG * (double)stuck->paths[0].stay >= chain)
        plan->shorten.cut[stage_of_unit(plan, unit)][record->length] = 1;
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
    for (uint32_t k = plan_first(plan); plan->phase != PLAN_PILOT && k <= plan_last(plan); k++) {
        const uint64_t now = plan_shorten_chain(plan, k), base = shorten_base(plan, k);
        if (now == 0 || now >= base)
            continue;
        json_t *object = json_new_object();
        json_add_number(object, "length", k);
        json_add_number(object, "from", (double)base);
        json_add_number(object, "to", (double)now);
        json_append(list, object);
    }
    return list;
}

/* ---- bytes ---- */

void plan_shorten_put(wire_writer_t *out, const plan_t *plan)
{
    const uint32_t stages = stage_next(plan) + 1;
    wire_put_u32(out, stages);
    for (uint32_t r = 0; r < stages; r++)
        wire_put_raw(out, plan->shorten.cut[r], plan->settings.max_path_length + 1);
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        wire_put_f64(out, plan->shorten.largest[k]);
}

fault_code_t plan_shorten_get(wire_reader_t *in, plan_t *plan)
{
    const uint32_t stages = wire_get_u32(in, "stages"), K = plan->settings.max_path_length;
    if (!in->code && (stages < 1 || stages > PLAN_STAGES))
        return wire_reader_fail(in, FAULT_RANGE, "stages", "%u, expected 1 to %d", stages, PLAN_STAGES);
    for (uint32_t r = 0; r < stages && !in->code; r++)
        for (uint32_t k = 0; k <= K; k++) {
            const uint8_t cut = plan->shorten.cut[r][k] = wire_get_u8(in, "stuck stage");
            if (!in->code && (cut > 1 || (cut && plan->stuck.stays == 0)))
                return wire_reader_fail(in, FAULT_RANGE, "stuck stage",
                                        "%u of length %u in stage %u, with %llu stays", cut, k, r,
                                        (unsigned long long)plan->stuck.stays);
        }
    for (uint32_t k = 0; k <= K && !in->code; k++) {
        const double most = plan_is_samples(plan, k) ? 0 : (double)plan->lengths[k].counted + 1,
                     largest = plan->shorten.largest[k] = wire_get_f64(in, "largest chain");
        if (!in->code && !(largest >= 0 && largest <= (plan->lengths[k].merged > 0 ? most : 0)))
            return wire_reader_fail(in, FAULT_RANGE, "largest chain", "%g of length %u, expected at most %g",
                                    largest, k, most);
    }
    return in->code;
}
