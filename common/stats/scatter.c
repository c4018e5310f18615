#include "stats/scatter.h"

#include <math.h>
#include <stdlib.h>

enum {
    SCATTER_DRAWS = GROUPS_COUNT - 1,
    SCATTER_LEAST = 3,                 /* groups */
    SCATTER_BANDS = 4 * SCATTER_DRAWS, /* of the image, for what units of nets leave */
};

/* A length's groups at the spots. */
typedef struct scatter_spots {
    const uint64_t *counts;
    const exact_uint_t *sums;   /* [GROUPS_COUNT][spots] */
    double count, alike;        /* N; how many groups of one size they are worth */
    double light[GROUPS_SPOTS]; /* of all groups */
} scatter_spots_t;

static void scatter_open(scatter_spots_t *spots, const groups_t *groups, uint32_t k)
{
    const uint32_t n = groups->spot_count;
    double squares = 0;
    *spots = (scatter_spots_t){.counts = groups->counts + (size_t)k * GROUPS_COUNT,
                               .sums = groups->spots + (size_t)k * GROUPS_COUNT * n};
    for (uint32_t g = 0; g < GROUPS_COUNT; g++) {
        const double count = (double)spots->counts[g];
        spots->count += count;
        squares += count * count;
        for (uint32_t i = 0; i < n; i++)
            spots->light[i] += exact_double(spots->sums[(size_t)g * n + i]);
    }
    spots->alike = squares > 0 ? spots->count * spots->count / squares : 0;
}

/* What a group's light differs from its share by, times the factor; returns the weighted sum of its squares. */
static double scatter_deviate(const scatter_spots_t *spots, uint32_t n, uint32_t g, double factor,
                              const double *weights, double *part)
{
    const double share = (double)spots->counts[g] / spots->count;
    double squares = 0;
    for (uint32_t i = 0; i < n; i++) {
        part[i] = factor * (exact_double(spots->sums[(size_t)g * n + i]) - share * spots->light[i]);
        squares += weights[i] * part[i] * part[i];
    }
    return squares;
}

static double scatter_contrast(uint32_t draw, uint32_t at, uint32_t present)
{
    if (present == GROUPS_COUNT)
        return __builtin_parity((draw + 1) & at) ? -1 : 1;
    return cos(M_PI * (1 + draw % (present - 1)) * (at + 0.5) / present);
}

/* Contrasts of one length's groups: numbers that add up to zero over the groups that have units, in [draw]. All
 * sixteen: rows of the Hadamard matrix of Sylvester's construction. Fewer: those of the discrete cosine transform
 * of so many, over and over. Each is scaled so that its variance is that of the sum of all groups, whatever their
 * sizes n_g: for deviations x_g - n_g mean of independent x_g, of variances n_g, sum v_g^2 n_g - (sum v_g n_g)^2 /
 * N becomes N. */
static void scatter_contrasts(const scatter_spots_t *spots, double contrasts[SCATTER_DRAWS][GROUPS_COUNT])
{
    const uint64_t *counts = spots->counts;
    uint32_t present = 0;
    for (uint32_t g = 0; g < GROUPS_COUNT; g++)
        present += counts[g] > 0;
    for (uint32_t j = 0; j < SCATTER_DRAWS; j++) {
        double own = 0, sum = 0;
        for (uint32_t g = 0, at = 0; g < GROUPS_COUNT; g++) {
            const double v = counts[g] > 0 ? scatter_contrast(j, at++, present) : 0;
            contrasts[j][g] = v;
            own += v * v * (double)counts[g];
            sum += v * (double)counts[g];
        }
        const double scale = sqrt(spots->count / (own - sum * sum / spots->count));
        for (uint32_t g = 0; g < GROUPS_COUNT; g++)
            contrasts[j][g] *= scale;
    }
}

/* Of a render. */
typedef struct scatter_sums {
    double *draws;              /* [SCATTER_DRAWS][spots]: errors */
    double parts[GROUPS_COUNT]; /* squared deviations of each group */
    double all, over_freedom;
} scatter_sums_t;

/* Adds a group's deviations to the draws, in [draw] by one contrast each: in a band of the image the next draw has
 * the next contrast. */
static void scatter_draw_group(scatter_sums_t *sums, uint32_t n, double contrasts[SCATTER_DRAWS][GROUPS_COUNT],
                               uint32_t g, const double *part, uint32_t bands)
{
    for (uint32_t band = 0; band < bands; band++)
        for (uint32_t j = 0; j < SCATTER_DRAWS; j++) {
            const double contrast = contrasts[(j + band) % SCATTER_DRAWS][g];
            const uint32_t end = (uint32_t)((uint64_t)n * (band + 1) / bands);
            for (uint32_t i = (uint32_t)((uint64_t)n * band / bands); i < end; i++)
                sums->draws[(size_t)j * n + i] += contrast * part[i];
        }
}

/* Group by group, spot by spot: arrays are passed in their order. */
static void scatter_add(scatter_sums_t *sums, const scatter_spots_t *spots, uint32_t n, double factor,
                        const double *weights, bool nets)
{
    double contrasts[SCATTER_DRAWS][GROUPS_COUNT], part[GROUPS_SPOTS], squares = 0;
    scatter_contrasts(spots, contrasts);
    for (uint32_t g = 0; g < GROUPS_COUNT; g++) {
        const double own = scatter_deviate(spots, n, g, factor, weights, part);
        scatter_draw_group(sums, n, contrasts, g, part, nets ? SCATTER_BANDS : 1);
        sums->parts[g] += own;
        squares += own;
    }
    sums->all += squares;
    sums->over_freedom += squares * squares / (spots->alike - 1);
}

/* All lengths. False while one has units in too few groups. */
static bool scatter_lengths(scatter_sums_t *sums, const groups_t *groups, const double *factor,
                            const double *weights, bool nets)
{
    for (uint32_t k = 0; k < groups->lengths; k++) {
        scatter_spots_t spots;
        if (factor[k] == 0)
            continue;
        scatter_open(&spots, groups, k);
        if (spots.count == 0)
            continue;
        if (spots.alike < SCATTER_LEAST)
            return false;
        scatter_add(sums, &spots, groups->spot_count, factor[k], weights, nets && k == 0);
    }
    return sums->all > 0;
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
static double scatter_draw(const groups_t *groups, const double *errors, const double *weights,
                           double draws[SCATTER_DRAWS])
{
    double alone = 0;
    for (uint32_t j = 0; j < SCATTER_DRAWS; j++)
        draws[j] = 0;
    for (uint32_t i = 0; i < groups->spot_count; i++) {
        double own[SCATTER_DRAWS];
        for (uint32_t j = 0; j < SCATTER_DRAWS; j++) {
            const double error = errors[(size_t)j * groups->spot_count + i];
            own[j] = weights[i] * error * error;
            draws[j] += own[j];
        }
        alone += scatter_moments(own).variance;
    }
    return alone;
}

double scatter_part(const groups_t *groups, uint32_t k, double factor, const double *weights)
{
    scatter_spots_t spots;
    double part[GROUPS_SPOTS], squares = 0;
    scatter_open(&spots, groups, k);
    if (!(spots.alike > 1 + 1e-9))
        return 0;
    for (uint32_t g = 0; g < GROUPS_COUNT; g++)
        squares += scatter_deviate(&spots, groups->spot_count, g, factor, weights, part);
    return squares * spots.alike / (spots.alike - 1);
}

bool scatter_measure(scatter_t *scatter, const groups_t *groups, const double *factor,
                     const double weights[GROUPS_SPOTS], bool nets)
{
    scatter_sums_t sums = {.draws = calloc((size_t)SCATTER_DRAWS * groups->spot_count, sizeof *sums.draws)};
    if (!sums.draws || !scatter_lengths(&sums, groups, factor, weights, nets)) {
        free(sums.draws);
        return false;
    }
    double draws[SCATTER_DRAWS], most = 0;
    const double alone = scatter_draw(groups, sums.draws, weights, draws);
    free(sums.draws);
    for (uint32_t g = 0; g < GROUPS_COUNT; g++)
        most = fmax(most, sums.parts[g]);
    scatter->freedom = fmin(sums.all * sums.all / sums.over_freedom, SCATTER_DRAWS); /* there are no more draws */
    scatter->dominance = most / sums.all * (scatter->freedom + 1) / GROUPS_COUNT;
    /* In the whole image there are more pixels: what each of them scatters alone is divided among so many. And of
     * fifteen draws no more are different than there are degrees of freedom. */
    const scatter_moments_t all = scatter_moments(draws);
    const double part = (double)groups->spot_count / (double)groups->pixels,
                 different = scatter->freedom / (scatter->freedom - 1) * (SCATTER_DRAWS - 1) / SCATTER_DRAWS,
                 variance = different * fmax(all.variance - (1 - part) * alone, part * alone);
    scatter->own = sqrt(variance) / all.mean;
    scatter->estimate = scatter->own / sqrt(scatter->freedom);
    return all.mean > 0;
}
