/* plan_strata.c: how much the errors of neighbouring pixels hang together.
 *
 * The image is cut into blocks of 8 x 8 pixels. If the errors of a block's pixels are independent, the variance of
 * their sum is the sum of their variances; where a chain wanders about one place they rise and fall together, and
 * it is larger. Both variances are those between units, and both are sums over all blocks and channels, over the
 * block's squared mean as the error is:
 *
 *     sum_B w_B Var(sum_{p in B} x_p) / sum_B w_B sum_{p in B} Var(x_p),    w_B = 1 / (mean_B^2 + 0.01 m^2).
 *
 * Each length has its own squares here, of blocks and of their pixels, so that its part of either variance is
 * unbiased whatever the number and size of its units, as soon as there are two: with squares that all lengths share
 * (as those of pixels, plan_estimate.c) the few small units that a render begins with would count for more than
 * they bring to the image. The error of b_k is the same factor in all pixels, and not in it.
 */
#include "plan/plan_strata.h"

#include <stdlib.h>

#include "plan/packed.h"
#include "plan/plan_estimate.h"

enum {
    STRATA_SIDE = 8,
    STRATA_OF = 2, /* squares of a block and channel: of its sum, and of its pixels */
    STRATA_UNITS = 4
};

static size_t strata_across(const plan_t *plan)
{
    return (plan->settings.width + STRATA_SIDE - 1) / STRATA_SIDE;
}

static size_t strata_count(const plan_t *plan)
{
    return strata_across(plan) * ((plan->settings.height + STRATA_SIDE - 1) / STRATA_SIDE);
}

/* Numbers of one length. */
static size_t strata_length(const plan_t *plan)
{
    return STRATA_OF * FILM_CHANNELS * strata_count(plan);
}

fault_code_t plan_strata_init(plan_t *plan, fault_t *fault)
{
    const size_t row = FILM_CHANNELS * strata_across(plan);
    plan->strata = calloc(strata_length(plan) * (plan->settings.max_path_length + 1) + row, sizeof *plan->strata);
    return plan->strata ? FAULT_NONE : fault_set(fault, FAULT_MEMORY, "no memory for blocks of the image");
}

static size_t strata_of(const plan_t *plan, size_t pixel)
{
    const size_t width = plan->settings.width;
    return pixel / width / STRATA_SIDE * strata_across(plan) + pixel % width / STRATA_SIDE;
}

/* One pixel of a film, to its block. */
static void strata_add_pixel(const int64_t *sums, double scale, exact_uint_t *row, exact_uint_t *squares)
{
    if ((sums[0] | sums[1] | sums[2]) == 0) /* most of a chain's film */
        return;
    for (size_t c = 0; c < FILM_CHANNELS; c++) {
        const double own = (double)sums[c] * scale;
        row[c] += (uint64_t)sums[c];
        squares[STRATA_OF * c + 1] += exact_round(own * own);
    }
}

/* One row of blocks at a time: its sums are exact, whatever they are. */
void plan_absorb_strata(plan_t *plan, uint32_t k, const film_t *film, double c, double size)
{
    const double scale = c / sqrt(size) / FILM_ONE * 0x1p20;
    const size_t across = FILM_CHANNELS * strata_across(plan);
    exact_uint_t *row = plan->strata + strata_length(plan) * (plan->settings.max_path_length + 1),
                 *squares = plan->strata + strata_length(plan) * k;
    for (uint32_t top = 0; top < film->height; top += STRATA_SIDE, squares += STRATA_OF * across) {
        for (size_t i = 0; i < across; i++)
            row[i] = 0;
        for (uint32_t y = top; y < film->height && y < top + STRATA_SIDE; y++)
            for (uint32_t x = 0; x < film->width; x++)
                strata_add_pixel(film->sums + ((size_t)y * film->width + x) * FILM_CHANNELS, scale,
                                 row + x / STRATA_SIDE * FILM_CHANNELS,
                                 squares + x / STRATA_SIDE * FILM_CHANNELS * STRATA_OF);
        for (size_t i = 0; i < across; i++) {
            const double x = (double)row[i] * scale;
            squares[STRATA_OF * i] += exact_round(x * x);
        }
    }
}

/* Of one block and channel. */
typedef struct strata_block {
    double value;            /* of the image: its sum over the block */
    double sum, own;         /* of one length's film: its sum, and the sum of its pixels' squares */
    double pixels, variance; /* their number; what a weight is multiplied with: of the block's sum, */
    double variances;        /* and of its pixels, summed */
} strata_block_t;

/* The film of one length, by block and channel. */
static void strata_sum(const plan_pixels_t *pixels, uint32_t i, strata_block_t *blocks)
{
    const plan_t *plan = pixels->plan;
    const size_t count = FILM_CHANNELS * strata_count(plan);
    for (size_t b = 0; b < count; b++)
        blocks[b].sum = blocks[b].own = 0;
    for (size_t p = 0; p < plan->pixels; p++) {
        strata_block_t *block = &blocks[FILM_CHANNELS * strata_of(plan, p)];
        for (size_t c = 0; c < FILM_CHANNELS; c++) {
            const double sum = (double)pixels->sums[i][FILM_CHANNELS * p + c];
            block[c].sum += sum;
            block[c].own += sum * sum;
        }
    }
}

/* Adds one length: its light, and its variances. */
static void strata_add(const plan_pixels_t *pixels, uint32_t i, strata_block_t *blocks)
{
    const plan_t *plan = pixels->plan;
    const size_t count = FILM_CHANNELS * strata_count(plan);
    const exact_uint_t *squares = plan->strata + strata_length(plan) * pixels->lengths[i];
    strata_sum(pixels, i, blocks);
    for (size_t b = 0; b < count; b++) {
        strata_block_t *block = &blocks[b];
        const double of_block = (double)squares[STRATA_OF * b] * pixels->squares_factor,
                     of_pixels = (double)squares[STRATA_OF * b + 1] * pixels->squares_factor;
        block->value += block->sum * pixels->factor[i];
        block->variance += (of_block - block->sum * block->sum * pixels->square[i]) * pixels->excess[i];
        block->variances += (of_pixels - block->own * pixels->square[i]) * pixels->excess[i];
    }
}

static double strata_ratio(const plan_t *plan, const strata_block_t *blocks)
{
    const size_t count = strata_count(plan);
    double of_blocks = 0, of_pixels = 0, level = 0;
    for (size_t b = 0; b < count; b++) {
        const strata_block_t *block = &blocks[FILM_CHANNELS * b];
        level += rgb_luminance(rgb(block[0].value, block[1].value, block[2].value)) / (double)plan->pixels;
    }
    for (size_t b = 0; b < FILM_CHANNELS * count; b++) {
        const double mean = blocks[b].value / blocks[b].pixels, weight = 1 / (mean * mean + 0.01 * level * level);
        of_blocks += weight * blocks[b].variance;
        of_pixels += weight * blocks[b].variances;
    }
    return of_pixels > 0 && of_blocks > 0 ? of_blocks / of_pixels : NAN;
}

double plan_estimate_strata(const plan_t *plan)
{
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++)
        if (plan->lengths[k].share > 0 && plan->lengths[k].units_in < STRATA_UNITS)
            return NAN;
    if (plan->phase != PLAN_RENDER || !plan->strata)
        return NAN;
    strata_block_t *blocks = calloc(FILM_CHANNELS * strata_count(plan), sizeof *blocks);
    double ratio = NAN;
    if (blocks) {
        plan_pixels_t pixels;
        plan_pixels_init(&pixels, plan);
        for (size_t p = 0; p < plan->pixels; p++)
            for (size_t c = 0; c < FILM_CHANNELS; c++)
                blocks[FILM_CHANNELS * strata_of(plan, p) + c].pixels++;
        for (uint32_t i = 0; i < pixels.count; i++)
            strata_add(&pixels, i, blocks);
        ratio = strata_ratio(plan, blocks);
    }
    free(blocks);
    return ratio;
}

static size_t strata_size(const plan_t *plan)
{
    return plan->strata ? strata_length(plan) * (plan->settings.max_path_length + 1) * sizeof *plan->strata : 0;
}

void plan_strata_put(wire_writer_t *out, const plan_t *plan)
{
    packed_put(out, "strata", plan->strata, strata_size(plan));
}

fault_code_t plan_strata_get(wire_reader_t *in, plan_t *plan)
{
    return packed_get(in, "strata", plan->strata, strata_size(plan));
}
