#include "plan/plan_nets.h"

#include <math.h>
#include <stdlib.h>

#include "chain/net.h"
#include "plan/plan_estimate.h"
#include "plan/plan_regions.h"
#include "plan/plan_state.h"

/* Pixels. */
static const double NETS_PRIOR = 64;
static const double NETS_POWER = 0.6, NETS_POWER_MOST = 2;

static void nets_even(plan_nets_t *nets, double factor)
{
    nets->all = factor;
    for (uint32_t block = 0; block < GROUPS_BLOCKS; block++)
        nets->blocks[block] = factor;
}

void plan_nets_init(plan_nets_t *nets)
{
    *nets = (plan_nets_t){{0}, 0, {0}};
    nets_even(nets, 1);
}

void plan_nets_clear(plan_nets_t *nets)
{
    film_clear(&nets->second);
}

/* ---- handing out, taking in ---- */

void plan_nets_place(plan_t *plan, work_record_t *record)
{
    plan_part_t *part = plan_eras_part(plan, plan->eras.current, 0);
    plan_turns_t *turns = &part->turns;
    const uint64_t passes = record->count > plan->pixels ? record->count / plan->pixels : 1;
    if (part->handed % plan->pixels == 0) { /* a pass begins */
        turns->turn = turns->passes[1] < turns->passes[0];
        turns->passes[turns->turn] += passes;
    }
    record->sequence = 2 * plan->eras.current + turns->turn;
    record->point = turns->passes[turns->turn] - passes;
}

static bool nets_is_second(const plan_unit_t *unit)
{
    return unit->record.sequence % 2 == 1;
}

void plan_nets_count(plan_t *plan, const plan_unit_t *unit, uint64_t samples)
{
    if (nets_is_second(unit))
        plan_eras_part(plan, unit->era, 0)->turns.second += samples;
}

fault_code_t plan_nets_absorb(plan_t *plan, const plan_unit_t *unit, const film_t *film, fault_t *fault)
{
    plan_nets_t *nets = &plan->nets;
    if (!nets_is_second(unit))
        return FAULT_NONE;
    if (!nets->second.sums)
        TRY(film_init(&nets->second, plan->settings.width, plan->settings.height, fault));
    film_add(&nets->second, film);
    return FAULT_NONE;
}

/* ---- the factor ---- */

/* A block of the image (stats/groups.h). */
typedef struct nets_block {
    double pixels, light;       /* their number; the image's light */
    double variance, by_passes; /* of the image's samples, summed: by A - B; were passes independent */
} nets_block_t;

/* By weight (plan_eras.h): samples, and the same with weights squared; of both sequences and of the second. */
typedef struct nets_counts {
    double all, second, all_squared, second_squared;
} nets_counts_t;

static nets_counts_t nets_counts(const plan_t *plan)
{
    nets_counts_t counts = {.all = plan_eras_counted(plan, 0), .all_squared = plan_eras_squared(plan, 0)};
    for (uint32_t r = 0; r < plan->eras.decided; r++) {
        const plan_part_t *part = plan_eras_part(plan, r, 0);
        const double samples = (double)part->turns.second;
        if (samples == 0)
            continue;
        counts.second += part->weight * samples;
        counts.second_squared += part->weight * part->weight * samples;
    }
    return counts;
}

/* The variance of A - B over that of the image, were all passes independent. */
static double nets_independent(const nets_counts_t *counts)
{
    const double one = counts->all - counts->second, one_squared = counts->all_squared - counts->second_squared;
    return counts->all * counts->all / counts->all_squared *
           (one_squared / (one * one) + counts->second_squared / (counts->second * counts->second));
}

bool plan_nets_pair(const plan_t *plan, double unit, plan_nets_pair_t *pair)
{
    const nets_counts_t counts = nets_counts(plan);
    const double one = counts.all - counts.second;
    if (!(counts.second > 0) || !(one > 0) || !plan->nets.second.sums)
        return false;
    *pair = (plan_nets_pair_t){
        .first = unit * counts.all / one,
        .both = unit * counts.all * (1 / one + 1 / counts.second),
        .scale = 1 / nets_independent(&counts),
    };
    return true;
}

/* The image's variance, by what the two sequences differ by. The samples are the first of pixels->lengths. */
static void nets_differ(const plan_pixels_t *pixels, const plan_nets_pair_t *pair, nets_block_t *blocks)
{
    const plan_t *plan = pixels->plan;
    for (size_t p = 0; p < plan->pixels; p++) {
        nets_block_t *block = &blocks[plan_block(plan, p)];
        block->pixels++;
        for (size_t i = FILM_CHANNELS * p; i < FILM_CHANNELS * (p + 1); i++)
            block->variance += plan_nets_variance(pair, pixels->sums[0][i], plan->nets.second.sums[i]);
    }
}

/* The same by what passes differ by; and the light of all lengths. */
static void nets_expect(const plan_pixels_t *pixels, nets_block_t *blocks)
{
    const plan_t *plan = pixels->plan;
    for (uint32_t b = 0; b < GROUPS_BLOCKS; b++) {
        const double squares = groups_squares(&plan->groups, 0, b) * pixels->squares_factor -
                               pixels->squared[0][b] * pixels->square[0];
        blocks[b].by_passes = fmax(0, squares) * pixels->excess[0];
        for (uint32_t i = 0; i < pixels->count; i++)
            blocks[b].light += groups_light(&plan->groups, pixels->lengths[i], b) * pixels->factor[i];
    }
}

/* The ratio over the image, in relMSE's measure. */
static double nets_ratio(const plan_t *plan, const nets_block_t *blocks)
{
    double variance = 0, by_passes = 0, level = 0;
    for (uint32_t b = 0; b < GROUPS_BLOCKS; b++)
        level += blocks[b].light / (double)plan->pixels;
    for (uint32_t b = 0; b < GROUPS_BLOCKS; b++) {
        const double mean = blocks[b].pixels > 0 ? blocks[b].light / blocks[b].pixels : 0,
                     weight = 1 / (mean * mean + 0.01 * level * level);
        variance += weight * blocks[b].variance;
        by_passes += weight * blocks[b].by_passes;
    }
    return variance / by_passes;
}

void plan_nets_measure(plan_t *plan)
{
    plan_nets_t *nets = &plan->nets;
    nets_even(nets, 1);
    if (plan->phase != PLAN_RENDER)
        return;
    nets_block_t blocks[GROUPS_BLOCKS] = {{0, 0, 0, 0}};
    plan_pixels_t pixels;
    plan_nets_pair_t pair;
    plan_pixels_init(&pixels, plan);
    if (pixels.count == 0 || !plan_nets_pair(plan, pixels.factor[0], &pair))
        return;
    nets_differ(&pixels, &pair, blocks);
    nets_expect(&pixels, blocks);
    const double ratio = nets_ratio(plan, blocks);
    if (!(ratio > 0) || !isfinite(ratio))
        return;
    nets->all = ratio;
    for (uint32_t b = 0; b < GROUPS_BLOCKS; b++) {
        const double own = blocks[b].by_passes > 0 ? blocks[b].variance / blocks[b].by_passes : ratio;
        nets->blocks[b] = (blocks[b].pixels * own + NETS_PRIOR * ratio) / (blocks[b].pixels + NETS_PRIOR);
    }
}

double plan_nets_factor(const plan_t *plan, uint32_t k)
{
    return plan_is_samples(plan, k) ? plan->nets.all : 1;
}

double plan_nets_outlook(const plan_t *plan)
{
    double all = 0, young = 0, power = NETS_POWER; /* young: by weight, the mean of n^-power */
    for (uint32_t r = 0; r < plan->eras.decided; r++) {
        const plan_part_t *part = plan_eras_part(plan, r, 0);
        const double points = (double)part->merged / (2 * (double)plan->pixels),
                     weight = part->merged > 0 ? part->weight * (double)part->merged : 0;
        all += weight;
        young += weight > 0 ? weight * pow(fmin(fmax(points, 1), NET_POINTS), -NETS_POWER) : 0;
    }
    if (!(young < all))
        return 1;
    young /= all;
    if (plan->nets.all < young) { /* it falls faster than that: all of it, by a power of its own */
        power = fmin(power * log(plan->nets.all) / log(young), NETS_POWER_MOST);
        young = plan->nets.all;
    }
    const double least = pow(NET_POINTS, -power), later = fmax(young * pow(10, -power), fmin(young, least)),
                 rest = (plan->nets.all - young) / (1 - young);
    return fmin(1, (rest + (1 - rest) * later) / plan->nets.all);
}

/* ---- as bytes ---- */

void plan_nets_put(wire_writer_t *out, const plan_t *plan)
{
    uint8_t *data = NULL;
    size_t size = 0;
    if (plan->nets.second.sums && film_encode(&plan->nets.second, &data, &size, out->fault))
        wire_writer_fail(out, FAULT_MEMORY, "second sequence", "%u x %u pixels are not encoded",
                         plan->settings.width, plan->settings.height);
    wire_put_bytes(out, "second sequence", data, size, UINT32_MAX);
    free(data);
}

fault_code_t plan_nets_get(wire_reader_t *in, plan_t *plan, fault_t *fault)
{
    size_t size = 0;
    const uint8_t *data = wire_get_bytes(in, "second sequence", UINT32_MAX, &size);
    if (in->code || size == 0)
        return in->code;
    TRY(film_init(&plan->nets.second, plan->settings.width, plan->settings.height, fault));
    return film_decode(&plan->nets.second, data, size, fault);
}

fault_code_t plan_nets_check(wire_reader_t *in, plan_t *plan)
{
    const bool has = plan->nets.second.sums;
    if (has != (nets_counts(plan).second > 0))
        return wire_reader_fail(in, FAULT_FORMAT, "second sequence", "%s, but there are %s units of it",
                                has ? "a film" : "no film", has ? "no" : "some");
    for (size_t i = 0; has && i < FILM_CHANNELS * plan->pixels; i++)
        if (plan->nets.second.sums[i] > plan->lengths[0].film.sums[i])
            return wire_reader_fail(in, FAULT_RANGE, "second sequence", "is more than all at number %zu", i);
    plan_nets_measure(plan);
    return FAULT_NONE;
}
