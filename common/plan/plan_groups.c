#include "plan/plan_groups.h"

#include <math.h>
#include <stdlib.h>

#include "base/random.h"

fault_code_t plan_groups_init(plan_groups_t *groups, uint32_t max_path_length, size_t pixels, fault_t *fault)
{
    const size_t lengths = max_path_length + 1, spots = pixels < PLAN_SPOTS ? pixels : PLAN_SPOTS;
    *groups = (plan_groups_t){.lengths = (uint32_t)lengths,
                              .spot_count = (uint32_t)spots,
                              .pixels = pixels,
                              .spots = calloc(lengths * PLAN_GROUPS * spots, sizeof *groups->spots),
                              .light = calloc(lengths * PLAN_GROUPS * PLAN_GROUP_BLOCKS, sizeof *groups->light),
                              .own = calloc(lengths * PLAN_GROUP_BLOCKS, sizeof *groups->own),
                              .counts = calloc(lengths * PLAN_GROUPS, sizeof *groups->counts)};
    if (groups->spots && groups->light && groups->own && groups->counts)
        return FAULT_NONE;
    plan_groups_clear(groups);
    return fault_set(fault, FAULT_MEMORY, "no memory for groups of %u path lengths", max_path_length);
}

void plan_groups_clear(plan_groups_t *groups)
{
    free(groups->spots);
    free(groups->light);
    free(groups->own);
    free(groups->counts);
    *groups = (plan_groups_t){0};
}

void plan_groups_parts(const plan_groups_t *groups, plan_groups_part_t parts[PLAN_GROUPS_PARTS])
{
    const size_t lengths = groups->lengths, blocks = PLAN_GROUP_BLOCKS;
    parts[0] = (plan_groups_part_t){groups->light, lengths * PLAN_GROUPS * blocks * sizeof *groups->light};
    parts[1] =
        (plan_groups_part_t){groups->spots, lengths * PLAN_GROUPS * groups->spot_count * sizeof *groups->spots};
    parts[2] = (plan_groups_part_t){groups->own, lengths * blocks * sizeof *groups->own};
    parts[3] = (plan_groups_part_t){groups->counts, lengths * PLAN_GROUPS * sizeof *groups->counts};
}

/* One in each of as many equal parts of the rows laid end to end, at a random place in it. */
size_t plan_groups_spot(const plan_groups_t *groups, uint32_t i)
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
static void groups_row(const film_t *film, uint32_t y, double scale, block_sums_t row[PLAN_GROUP_SIDE])
{
    const int64_t *sums = film->sums + FILM_CHANNELS * (size_t)y * film->width;
    for (uint32_t x = 0; x < film->width; x++, sums += FILM_CHANNELS) {
        if ((sums[0] | sums[1] | sums[2]) == 0)
            continue;
        const rgb_t value = rgb((double)sums[0], (double)sums[1], (double)sums[2]);
        block_sums_t *block = &row[plan_groups_block(x, film->width)];
        block->light += rgb_luminance(value);
        block->squares += (value.r * value.r + value.g * value.g + value.b * value.b) * scale * scale;
    }
}

/* Within a unit sums are in doubles, in the pixels' order; each unit's are rounded and added exactly. */
void plan_groups_absorb(plan_groups_t *groups, uint32_t k, uint64_t unit, uint64_t count, const film_t *film,
                        double c, double size)
{
    const double scale = c / sqrt(size) / FILM_ONE * 0x1p20;
    const uint32_t group = (uint32_t)(unit % PLAN_GROUPS);
    exact_uint_t *light = groups->light + ((size_t)k * PLAN_GROUPS + group) * PLAN_GROUP_BLOCKS,
                 *spots = groups->spots + ((size_t)k * PLAN_GROUPS + group) * groups->spot_count,
                 *own = groups->own + (size_t)k * PLAN_GROUP_BLOCKS;
    for (uint32_t y = 0; y < film->height;) {
        block_sums_t row[PLAN_GROUP_SIDE] = {{0, 0}};
        const uint32_t j = plan_groups_block(y, film->height);
        for (; y < film->height && plan_groups_block(y, film->height) == j; y++)
            groups_row(film, y, scale, row);
        for (uint32_t i = 0; i < PLAN_GROUP_SIDE; i++) {
            const uint32_t block = j * PLAN_GROUP_SIDE + i;
            light[block] += (exact_uint_t)(row[i].light + 0.5);
            own[block] += (exact_uint_t)(row[i].squares + 0.5);
        }
    }
    for (uint32_t i = 0; i < groups->spot_count; i++) {
        const int64_t *sums = film->sums + FILM_CHANNELS * plan_groups_spot(groups, i);
        spots[i] += (exact_uint_t)(rgb_luminance(rgb((double)sums[0], (double)sums[1], (double)sums[2])) + 0.5);
    }
    groups->counts[(size_t)k * PLAN_GROUPS + group] += count;
}

double plan_groups_squares(const plan_groups_t *groups, uint32_t k, uint32_t block)
{
    return (double)groups->own[(size_t)k * PLAN_GROUP_BLOCKS + block];
}

double plan_groups_light(const plan_groups_t *groups, uint32_t k, uint32_t block)
{
    double light = 0;
    for (uint32_t g = 0; g < PLAN_GROUPS; g++)
        light += (double)groups->light[((size_t)k * PLAN_GROUPS + g) * PLAN_GROUP_BLOCKS + block];
    return light;
}

void plan_groups_image(const plan_groups_t *groups, uint32_t group, const double *factor,
                       double blocks[PLAN_GROUP_BLOCKS])
{
    for (uint32_t i = 0; i < PLAN_GROUP_BLOCKS; i++)
        blocks[i] = 0;
    for (uint32_t k = 0; k < groups->lengths; k++) {
        const uint64_t *counts = groups->counts + (size_t)k * PLAN_GROUPS;
        const exact_uint_t *light = groups->light + (size_t)k * PLAN_GROUPS * PLAN_GROUP_BLOCKS;
        const bool own = counts[group] > 0;
        const uint32_t first = own ? group : 0, last = own ? group : PLAN_GROUPS - 1;
        double count = 0;
        for (uint32_t g = first; g <= last; g++)
            count += (double)counts[g];
        for (uint32_t g = first; g <= last && count > 0; g++)
            for (uint32_t i = 0; i < PLAN_GROUP_BLOCKS; i++)
                blocks[i] += factor[k] / count * (double)light[(size_t)g * PLAN_GROUP_BLOCKS + i];
    }
}
