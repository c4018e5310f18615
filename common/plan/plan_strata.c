/* plan_strata.c: how much the errors of neighbouring pixels hang together.
 *
 * The image is cut into blocks of 8 x 8 pixels. If the errors of a block's pixels are independent, the variance of
 * their sum is the sum of their variances; where a chain wanders about one place they rise and fall together, and
 * it is larger. Both variances are those between units, as in plan_estimate.c, and both are sums over all blocks
 * and channels, over the block's squared mean as the error is:
 *
 *     sum_B w_B Var(sum_{p in B} x_p) / sum_B w_B sum_{p in B} Var(x_p),    w_B = 1 / (mean_B^2 + 0.01 m^2).
 *
 * The error of b_k is the same factor in all pixels, and not in it.
 */
#include "plan/plan_strata.h"

#include <stdlib.h>

#include "plan/packed.h"
#include "plan/plan_estimate.h"

enum { STRATA_SIDE = 8 };

static size_t strata_across(const plan_t *plan)
{
    return (plan->settings.width + STRATA_SIDE - 1) / STRATA_SIDE;
}

size_t plan_strata(const plan_t *plan)
{
    return strata_across(plan) * ((plan->settings.height + STRATA_SIDE - 1) / STRATA_SIDE);
}

static size_t strata_of(const plan_t *plan, size_t pixel)
{
    const size_t width = plan->settings.width;
    return pixel / width / STRATA_SIDE * strata_across(plan) + pixel % width / STRATA_SIDE;
}

/* One row of blocks at a time: its sums are exact, whatever they are. */
void plan_absorb_strata(plan_t *plan, const film_t *film, double c, double size)
{
    const double scale = c / sqrt(size) / FILM_ONE * 0x1p20;
    const size_t across = FILM_CHANNELS * strata_across(plan);
    exact_uint_t *row = plan->strata + FILM_CHANNELS * plan_strata(plan);
    for (uint32_t top = 0; top < film->height; top += STRATA_SIDE) {
        for (size_t i = 0; i < across; i++)
            row[i] = 0;
        for (uint32_t y = top; y < film->height && y < top + STRATA_SIDE; y++)
            for (uint32_t x = 0; x < film->width; x++)
                for (size_t i = 0; i < FILM_CHANNELS; i++)
                    row[x / STRATA_SIDE * FILM_CHANNELS + i] +=
                        (uint64_t)film->sums[((size_t)y * film->width + x) * FILM_CHANNELS + i];
        for (size_t i = 0; i < across; i++) {
            const double x = (double)row[i] * scale;
            plan->strata[top / STRATA_SIDE * across + i] += (exact_uint_t)(x * x + 0.5);
        }
    }
}

/* Of one block and channel. */
typedef struct strata_block {
    double value, pixels; /* of the image: its sum over the block, and how many pixels those are */
    double variances;     /* sum over pixels */
    double taken;         /* what the mean takes off the squares of the block's sums */
} strata_block_t;

/* Films are added one after the other, as the square of a block's sum is each length's own. */
static void strata_add(const plan_pixels_t *pixels, uint32_t i, size_t channel, strata_block_t *blocks,
                       double *sums)
{
    const plan_t *plan = pixels->plan;
    const size_t count = plan_strata(plan);
    for (size_t b = 0; b < count; b++)
        sums[b] = 0;
    for (size_t p = 0; p < plan->pixels; p++) {
        strata_block_t *block = &blocks[strata_of(plan, p)];
        const double sum = (double)pixels->sums[i][FILM_CHANNELS * p + channel];
        sums[strata_of(plan, p)] += sum;
        block->value += sum * pixels->factor[i];
        block->variances -= sum * sum * pixels->square[i];
    }
    for (size_t b = 0; b < count; b++)
        blocks[b].taken += sums[b] * sums[b] * pixels->square[i];
}

static void strata_channel(const plan_pixels_t *pixels, size_t channel, strata_block_t *blocks, double *sums)
{
    const plan_t *plan = pixels->plan;
    const size_t count = plan_strata(plan);
    for (size_t b = 0; b < count; b++)
        blocks[b] = (strata_block_t){0};
    for (uint32_t i = 0; i < pixels->count; i++)
        strata_add(pixels, i, channel, blocks, sums);
    for (size_t p = 0; p < plan->pixels; p++) {
        strata_block_t *block = &blocks[strata_of(plan, p)];
        block->pixels++;
        block->variances += (double)plan->squares[FILM_CHANNELS * p + channel] * pixels->squares_factor;
    }
}

/* The mean of the image's luminance. */
static double strata_level(const plan_pixels_t *pixels)
{
    double sum[FILM_CHANNELS] = {0};
    for (uint32_t i = 0; i < pixels->count; i++)
        for (size_t p = 0; p < FILM_CHANNELS * pixels->plan->pixels; p++)
            sum[p % FILM_CHANNELS] += (double)pixels->sums[i][p] * pixels->factor[i];
    return rgb_luminance(rgb(sum[0], sum[1], sum[2])) / (double)pixels->plan->pixels;
}

double plan_estimate_strata(const plan_t *plan)
{
    uint64_t units = 0;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++)
        units += plan->lengths[k].units_in;
    if (units < 16 || !plan->strata)
        return NAN;
    const size_t count = plan_strata(plan);
    strata_block_t *blocks = malloc(sizeof *blocks * count);
    double *sums = malloc(sizeof *sums * count), of_blocks = 0, of_pixels = 0;
    if (blocks && sums) {
        plan_pixels_t pixels;
        plan_pixels_init(&pixels, plan);
        const double level = strata_level(&pixels), floor = 0.01 * level * level;
        for (size_t channel = 0; channel < FILM_CHANNELS; channel++) {
            strata_channel(&pixels, channel, blocks, sums);
            for (size_t b = 0; b < count; b++) {
                const double mean = blocks[b].value / blocks[b].pixels, weight = 1 / (mean * mean + floor);
                const double squares = (double)plan->strata[FILM_CHANNELS * b + channel] * pixels.squares_factor;
                of_blocks += weight * (squares - blocks[b].taken);
                of_pixels += weight * blocks[b].variances;
            }
        }
    }
    free(blocks);
    free(sums);
    return of_pixels > 0 && of_blocks > 0 ? of_blocks / of_pixels : NAN;
}

static size_t strata_size(const plan_t *plan)
{
    return FILM_CHANNELS * plan_strata(plan) * sizeof *plan->strata;
}

void plan_strata_put(wire_writer_t *out, const plan_t *plan)
{
    packed_put(out, "strata", plan->strata, strata_size(plan));
}

fault_code_t plan_strata_get(wire_reader_t *in, plan_t *plan)
{
    return packed_get(in, "strata", plan->strata, strata_size(plan));
}
