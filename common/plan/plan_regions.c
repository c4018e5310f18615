#include "plan/plan_regions.h"

#include <math.h>

#include "plan/plan_estimate.h"

/* Cornish and Fisher's expansion about the normal's quantile (Abramowitz and Stegun, 26.7.5). */
double plan_student(double freedom)
{
    const double z = 1.959964, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
    return z + (z3 + z) / (4 * freedom) + (5 * z5 + 16 * z3 + 3 * z) / (96 * freedom * freedom) +
           (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * freedom * freedom * freedom);
}

uint32_t plan_block(const plan_t *plan, size_t p)
{
    const uint32_t x = (uint32_t)(p % plan->settings.width), y = (uint32_t)(p / plan->settings.width);
    return groups_block(y, plan->settings.height) * GROUPS_SIDE + groups_block(x, plan->settings.width);
}

bool plan_estimate_groups(const plan_t *plan, plan_group_figures_t *figures)
{
    double factor[PATH_MAX_VERTICES] = {0}, blocks[GROUPS_COUNT][GROUPS_BLOCKS], mean[GROUPS_BLOCKS] = {0}, all = 0;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        double error;
        if (plan->lengths[k].units_in > 0)
            factor[k] = plan_film_b(plan, k, &error) / FILM_ONE;
    }
    for (uint32_t g = 0; g < GROUPS_COUNT; g++) {
        groups_image(&plan->groups, g, factor, blocks[g]);
        for (uint32_t i = 0; i < GROUPS_BLOCKS; i++)
            mean[i] += blocks[g][i] / GROUPS_COUNT;
    }
    for (uint32_t i = 0; i < GROUPS_BLOCKS; i++)
        all += mean[i] / GROUPS_BLOCKS;
    for (uint32_t g = 0; g < GROUPS_COUNT; g++) {
        double sum = 0, squares = 0;
        for (uint32_t i = 0; i < GROUPS_BLOCKS; i++) {
            const double difference = blocks[g][i] - mean[i];
            sum += blocks[g][i] / GROUPS_BLOCKS;
            squares += difference * difference / (mean[i] * mean[i] + 0.01 * all * all) / GROUPS_BLOCKS;
        }
        figures->brightness[g] = sum / all;
        figures->deviation[g] = sqrt(squares);
    }
    return all > 0;
}

/* Light of one length in a region of blocks: mean, variance of it between groups, and its degrees of freedom; these
 * are 0 while groups are too few. */
typedef struct region_light {
    double mean, variance, freedom;
} region_light_t;

static region_light_t region_of_length(const groups_t *groups, uint32_t k, double b,
                                       const bool region[GROUPS_BLOCKS])
{
    double all = 0, squares = 0, light[GROUPS_COUNT] = {0}, sum = 0, variance = 0;
    for (uint32_t g = 0; g < GROUPS_COUNT; g++) {
        const size_t at = (size_t)k * GROUPS_COUNT + g;
        const double count = (double)groups->counts[at];
        for (uint32_t i = 0; i < GROUPS_BLOCKS; i++)
            light[g] += region[i] ? b / FILM_ONE * (double)groups->light[at * GROUPS_BLOCKS + i] : 0;
        all += count;
        squares += count * count;
        sum += light[g];
    }
    const double alike = all * all / squares;
    for (uint32_t g = 0; g < GROUPS_COUNT; g++) {
        const double part = light[g] - (double)groups->counts[(size_t)k * GROUPS_COUNT + g] / all * sum;
        variance += part * part / (all * all) * alike / (alike - 1);
    }
    return (region_light_t){sum / all, variance, alike > 2.5 ? alike - 1 : 0};
}

/* What the points of samples leave of their variance in a region. */
static double region_nets(const plan_t *plan, const bool region[GROUPS_BLOCKS])
{
    double sum = 0, blocks = 0;
    for (uint32_t i = 0; i < GROUPS_BLOCKS; i++) {
        sum += region[i] ? plan->nets.blocks[i] : 0;
        blocks += region[i];
    }
    return sum / blocks;
}

bool plan_estimate_region(const plan_t *plan, const bool region[GROUPS_BLOCKS], plan_region_t *out)
{
    double mean = 0, variance = 0, over_freedom = 0, of_b = 0, pixels = 0;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        double error;
        if (plan->lengths[k].units_in == 0)
            continue;
        const double b = plan_film_b(plan, k, &error);
        const region_light_t light = region_of_length(&plan->groups, k, b, region);
        if (light.freedom == 0)
            return false;
        mean += light.mean;
        const double own = light.variance * (plan_is_samples(plan, k) ? region_nets(plan, region) : 1);
        variance += own;
        over_freedom += own * own / light.freedom;
        of_b += light.mean * light.mean * error * error / (b * b);
    }
    for (size_t p = 0; p < plan->pixels; p++)
        pixels += region[plan_block(plan, p)];
    if (!(mean > 0) || !(pixels > 0))
        return false;
    const double all = variance + of_b,
                 student = plan_student(over_freedom > 0 ? all * all / over_freedom : INFINITY);
    out->mean = mean / pixels;
    out->low = (mean - student * sqrt(all)) / pixels;
    out->high = (mean + student * sqrt(all)) / pixels;
    return true;
}
