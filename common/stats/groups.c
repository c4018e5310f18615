#include "stats/groups.h"

#include <math.h>
#include <stdlib.h>

#include "base/random.h"

fault_code_t groups_init(groups_t *groups, uint32_t max_path_length, size_t pixels, fault_t *fault)
{
    const size_t lengths = max_path_length + 1, spots = pixels < GROUPS_SPOTS ? pixels : GROUPS_SPOTS;
    *groups = (groups_t){.lengths = (uint32_t)lengths,
                         .spot_count = (uint32_t)spots,
                         .pixels = pixels,
                         .spots = calloc(lengths * GROUPS_COUNT * spots, sizeof *groups->spots),
                         .light = calloc(lengths * GROUPS_COUNT * GROUPS_BLOCKS, sizeof *groups->light),
                         .own = calloc(lengths * GROUPS_BLOCKS, sizeof *groups->own),
                         .counts = calloc(lengths * GROUPS_COUNT, sizeof *groups->counts)};
    if (groups->spots && groups->light && groups->own && groups->counts)
        return FAULT_NONE;
    groups_clear(groups);
    return fault_set(fault, FAULT_MEMORY, "no memory for groups of %u path lengths", max_path_length);
}

void groups_clear(groups_t *groups)
{
    free(groups->spots);
    free(groups->light);
    free(groups->own);
    free(groups->counts);
    *groups = (groups_t){0};
}

void groups_parts(const groups_t *groups, groups_part_t parts[GROUPS_PARTS])
{
    const size_t lengths = groups->lengths, blocks = GROUPS_BLOCKS;
    parts[0] = (groups_part_t){groups->light, lengths * GROUPS_COUNT * blocks * sizeof *groups->light};
    parts[1] = (groups_part_t){groups->spots, lengths * GROUPS_COUNT * groups->spot_count * sizeof *groups->spots};
    parts[2] = (groups_part_t){groups->own, lengths * blocks * sizeof *groups->own};
    parts[3] = (groups_part_t){groups->counts, lengths * GROUPS_COUNT * sizeof *groups->counts};
}

/* One in each of as many equal parts of the rows laid end to end, at a random place in it. */
size_t groups_spot(const groups_t *groups, uint32_t i)
{
    const size_t first = groups->pixels * i / groups->spot_count,
                 room = groups->pixels * (i + 1) / groups->spot_count - first;
    return first + random_u64(RANDOM_GAMMA, i) % room;
}

/* Sums over one block of a unit's film. */
typedef struct block_sums {
    double light, squares;
} block_sums_t;

/* A row of pixels, each added to its block of the row of blocks. */
static void groups_row(const film_t *film, uint32_t y, double scale, block_sums_t row[GROUPS_SIDE])
{
    const int64_t *sums = film->sums + FILM_CHANNELS * (size_t)y * film->width;
    for (uint32_t x = 0; x < film->width; x++, sums += FILM_CHANNELS) {
        if ((sums[0] | sums[1] | sums[2]) == 0)
            continue;
        const rgb_t value = rgb((double)sums[0], (double)sums[1], (double)sums[2]);
        block_sums_t *block = &row[groups_block(x, film->width)];
        block->light += rgb_luminance(value);
        block->squares += (value.r * value.r + value.g * value.g + value.b * value.b) * scale * scale;
    }
}

/* Within a unit sums are in doubles, in the pixels' order; each unit's are rounded and added exactly. */
void groups_absorb(groups_t *groups, uint32_t k, uint64_t unit, uint64_t count, const film_t *film, double c,
                   double size)
{
    const double scale = c / sqrt(size) / FILM_ONE * 0x1p20;
    const uint32_t group = (uint32_t)(unit % GROUPS_COUNT);
    exact_uint_t *light = groups->light + ((size_t)k * GROUPS_COUNT + group) * GROUPS_BLOCKS,
                 *spots = groups->spots + ((size_t)k * GROUPS_COUNT + group) * groups->spot_count,
                 *own = groups->own + (size_t)k * GROUPS_BLOCKS;
    for (uint32_t y = 0; y < film->height;) {
        block_sums_t row[GROUPS_SIDE] = {{0, 0}};
        const uint32_t j = groups_block(y, film->height);
        for (; y < film->height && groups_block(y, film->height) == j; y++)
            groups_row(film, y, scale, row);
        for (uint32_t i = 0; i < GROUPS_SIDE; i++) {
            const uint32_t block = j * GROUPS_SIDE + i;
            light[block] += exact_round(row[i].light);
            own[block] += exact_round(row[i].squares);
        }
    }
    for (uint32_t i = 0; i < groups->spot_count; i++) {
        const int64_t *sums = film->sums + FILM_CHANNELS * groups_spot(groups, i);
        spots[i] += exact_round(rgb_luminance(rgb((double)sums[0], (double)sums[1], (double)sums[2])));
    }
    groups->counts[(size_t)k * GROUPS_COUNT + group] += count;
}

double groups_squares(const groups_t *groups, uint32_t k, uint32_t block)
{
    return (double)groups->own[(size_t)k * GROUPS_BLOCKS + block];
}

double groups_light(const groups_t *groups, uint32_t k, uint32_t block)
{
    double light = 0;
    for (uint32_t g = 0; g < GROUPS_COUNT; g++)
        light += (double)groups->light[((size_t)k * GROUPS_COUNT + g) * GROUPS_BLOCKS + block];
    return light;
}

void groups_image(const groups_t *groups, uint32_t group, const double *factor, double blocks[GROUPS_BLOCKS])
{
    for (uint32_t i = 0; i < GROUPS_BLOCKS; i++)
        blocks[i] = 0;
    for (uint32_t k = 0; k < groups->lengths; k++) {
        const uint64_t *counts = groups->counts + (size_t)k * GROUPS_COUNT;
        const exact_uint_t *light = groups->light + (size_t)k * GROUPS_COUNT * GROUPS_BLOCKS;
        const bool own = counts[group] > 0;
        const uint32_t first = own ? group : 0, last = own ? group : GROUPS_COUNT - 1;
        double count = 0;
        for (uint32_t g = first; g <= last; g++)
            count += (double)counts[g];
        for (uint32_t g = first; g <= last && count > 0; g++)
            for (uint32_t i = 0; i < GROUPS_BLOCKS; i++)
                blocks[i] += factor[k] / count * (double)light[(size_t)g * GROUPS_BLOCKS + i];
    }
}
