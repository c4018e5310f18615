#include "plan/plan_scatter.h"

#include <math.h>
#include <stdlib.h>

enum { SCATTER_DRAWS = PLAN_GROUPS - 1, SCATTER_LEAST = 3 /* groups */ };

/* Row `row` of the Hadamard matrix of Sylvester's construction. */
static double scatter_sign(uint32_t row, uint32_t group)
{
    return __builtin_parity(row & group) ? -1 : 1;
}

/* How many groups of one size a length's are worth. 0: it has none. */
static double scatter_groups(const plan_groups_t *groups, uint32_t k, double *count)
{
    const uint64_t *counts = groups->counts + (size_t)k * PLAN_GROUPS;
    double squares = 0;
    *count = 0;
    for (uint32_t g = 0; g < PLAN_GROUPS; g++) {
        *count += (double)counts[g];
        squares += (double)counts[g] * (double)counts[g];
    }
    return *count > 0 ? *count * *count / squares : 0;
}

/* Adds what each group's part of the image is above its share, for one length; returns the sum of weighted squares.
 * `scale`: what the deviations of all groups would be by those of so many. */
static double scatter_add(const plan_groups_t *groups, uint32_t k, double count, double scale,
                          const double *weights, double *parts)
{
    const uint64_t *counts = groups->counts + (size_t)k * PLAN_GROUPS;
    const exact_uint_t *spots = groups->spots + (size_t)k * PLAN_GROUPS * groups->spot_count;
    double squares = 0;
    for (uint32_t i = 0; i < groups->spot_count; i++) {
        double sum = 0;
        for (uint32_t g = 0; g < PLAN_GROUPS; g++)
            sum += (double)spots[(size_t)g * groups->spot_count + i];
        for (uint32_t g = 0; g < PLAN_GROUPS; g++) {
            const size_t at = (size_t)g * groups->spot_count + i;
            const double part = scale * ((double)spots[at] - (double)counts[g] / count * sum);
            parts[at] += part;
            squares += weights[i] * part * part;
        }
    }
    return squares;
}

/* All lengths. False while one has units in too few groups. */
static bool scatter_parts(plan_scatter_t *scatter, const plan_groups_t *groups, const double *factor,
                          const double *weights, double *parts)
{
    double all = 0, over_freedom = 0;
    for (uint32_t k = 0; k < groups->lengths; k++) {
        double count;
        const double alike = scatter_groups(groups, k, &count);
        if (alike == 0 || factor[k] == 0)
            continue;
        if (alike < SCATTER_LEAST)
            return false;
        const double scale = factor[k] * sqrt(alike / (alike - 1) * (PLAN_GROUPS - 1) / PLAN_GROUPS),
                     squares = scatter_add(groups, k, count, scale, weights, parts);
        all += squares;
        over_freedom += squares * squares / (alike - 1);
    }
    scatter->freedom = all * all / over_freedom;
    return all > 0;
}

static double scatter_dominance(const plan_groups_t *groups, const double *parts, const double *weights)
{
    double most = 0, all = 0;
    for (uint32_t g = 0; g < PLAN_GROUPS; g++) {
        double squares = 0;
        for (uint32_t i = 0; i < groups->spot_count; i++) {
            const double part = parts[(size_t)g * groups->spot_count + i];
            squares += weights[i] * part * part;
        }
        most = fmax(most, squares);
        all += squares;
    }
    return most / all;
}

/* Mean and variance of draws. */
typedef struct scatter_moments {
    double mean, variance;
} scatter_moments_t;

static scatter_moments_t scatter_moments(const double draws[SCATTER_DRAWS])
{
    scatter_moments_t moments = {0, 0};
    for (uint32_t j = 0; j < SCATTER_DRAWS; j++)
        moments.mean += draws[j] / SCATTER_DRAWS;
    for (uint32_t j = 0; j < SCATTER_DRAWS; j++)
        moments.variance += (draws[j] - moments.mean) * (draws[j] - moments.mean) / (SCATTER_DRAWS - 1);
    return moments;
}

/* relMSE of each draw at the spots, and the sum over spots of what the variance would be of each alone. */
static double scatter_draw(const plan_groups_t *groups, const double *parts, const double *weights,
                           double draws[SCATTER_DRAWS])
{
    double alone = 0;
    for (uint32_t j = 0; j < SCATTER_DRAWS; j++)
        draws[j] = 0;
    for (uint32_t i = 0; i < groups->spot_count; i++) {
        double own[SCATTER_DRAWS];
        for (uint32_t j = 0; j < SCATTER_DRAWS; j++) {
            double d = 0;
            for (uint32_t g = 0; g < PLAN_GROUPS; g++)
                d += scatter_sign(j + 1, g) * parts[(size_t)g * groups->spot_count + i];
            own[j] = weights[i] * d * d;
            draws[j] += own[j];
        }
        alone += scatter_moments(own).variance;
    }
    return alone;
}

bool plan_scatter_measure(plan_scatter_t *scatter, const plan_groups_t *groups, const double *factor,
                          const double weights[PLAN_SPOTS])
{
    double *parts = calloc((size_t)PLAN_GROUPS * groups->spot_count, sizeof *parts), draws[SCATTER_DRAWS];
    if (!parts || !scatter_parts(scatter, groups, factor, weights, parts)) {
        free(parts);
        return false;
    }
    const double alone = scatter_draw(groups, parts, weights, draws);
    scatter->dominance = scatter_dominance(groups, parts, weights);
    free(parts);
    /* In the whole image there are more pixels: what each of them scatters alone is divided among so many. */
    const scatter_moments_t all = scatter_moments(draws);
    const double part = (double)groups->spot_count / (double)groups->pixels,
                 variance = fmax(all.variance - (1 - part) * alone, part * alone);
    scatter->own = sqrt(variance) / all.mean;
    scatter->estimate = scatter->own / sqrt(SCATTER_DRAWS);
    return all.mean > 0;
}
