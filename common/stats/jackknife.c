#include "stats/jackknife.h"

#include <math.h>
#include <stdlib.h>

enum { JACKKNIFE_PAIRS = GROUPS_COUNT / 2, JACKKNIFE_REST = GROUPS_COUNT - 2 };

/* Images at the spots of one pair, groups 2 p and 2 p + 1: [spots] each. */
typedef struct jackknife_pair {
    double *difference;            /* of the two, its variance that of the render's image */
    double *rest;                  /* all other groups */
    double *fewer[JACKKNIFE_REST]; /* these but for one, in their order */
} jackknife_pair_t;

typedef struct jackknife_images {
    uint32_t n;
    double *data;
    double *all; /* the render's image */
    double *own; /* [GROUPS_COUNT][n]: of one length, by group */
    /* Sums over lengths and pairs of squared differences, by the weights at hand: as errors of the image, and as
     * independent groups would have them. */
    double errors, independent;
    jackknife_pair_t pairs[JACKKNIFE_PAIRS];
} jackknife_images_t;

static bool jackknife_open(jackknife_images_t *images, uint32_t n)
{
    const size_t of_pair = 2 + JACKKNIFE_REST, count = 1 + GROUPS_COUNT + of_pair * JACKKNIFE_PAIRS;
    *images = (jackknife_images_t){.n = n, .data = calloc(count * n, sizeof *images->data)};
    if (!images->data)
        return false;
    images->all = images->data;
    images->own = images->all + n;
    for (size_t p = 0; p < JACKKNIFE_PAIRS; p++) {
        double *first = images->own + (GROUPS_COUNT + of_pair * p) * n;
        images->pairs[p].difference = first;
        images->pairs[p].rest = first + n;
        for (size_t j = 0; j < JACKKNIFE_REST; j++)
            images->pairs[p].fewer[j] = first + (2 + j) * n;
    }
    return true;
}

/* The group that is left out of fewer[j]. */
static uint32_t jackknife_left_out(int p, uint32_t j)
{
    return j < (uint32_t)(2 * p) ? j : j + 2;
}

/* Adds one length to the images of one pair. counts: of its groups, `all` together; sums: light of all of them;
 * errors: of the image, over what groups differ by. */
static void jackknife_add_pair(jackknife_images_t *images, int p, const uint64_t *counts, double all,
                               const double *sums, double errors, const double *weights)
{
    const uint32_t n = images->n;
    const double *a = images->own + (size_t)(2 * p) * n, *b = a + n;
    const double of_a = (double)counts[2 * p], of_b = (double)counts[2 * p + 1], left = all - of_a - of_b,
                 scale = sqrt(all / (1 / of_a + 1 / of_b));
    jackknife_pair_t *pair = &images->pairs[p];
    for (uint32_t i = 0; i < n; i++) {
        const double difference = scale * (a[i] / of_a - b[i] / of_b),
                     square = difference * difference * weights[i];
        images->independent += square;
        images->errors += square * errors * errors;
        pair->difference[i] += difference * errors;
        pair->rest[i] += all / left * (sums[i] - a[i] - b[i]);
    }
    for (uint32_t j = 0; j < JACKKNIFE_REST; j++) {
        const uint32_t g = jackknife_left_out(p, j);
        const double *out = images->own + (size_t)g * n, factor = all / (left - (double)counts[g]);
        for (uint32_t i = 0; i < n; i++)
            pair->fewer[j][i] += factor * (sums[i] - a[i] - b[i] - out[i]);
    }
}

/* False if a group has none of the length. */
static bool jackknife_add(jackknife_images_t *images, const groups_t *groups, uint32_t k, double factor,
                          double errors, const double *weights)
{
    const uint32_t n = images->n;
    const uint64_t *counts = groups->counts + (size_t)k * GROUPS_COUNT;
    const exact_uint_t *spots = groups->spots + (size_t)k * GROUPS_COUNT * n;
    double sums[GROUPS_SPOTS] = {0}, all = 0;
    for (uint32_t g = 0; g < GROUPS_COUNT; g++) {
        if (counts[g] == 0)
            return false;
        all += (double)counts[g];
        for (uint32_t i = 0; i < n; i++) {
            const double light = factor * exact_double(spots[(size_t)g * n + i]);
            images->own[(size_t)g * n + i] = light;
            sums[i] += light;
        }
    }
    for (uint32_t i = 0; i < n; i++)
        images->all[i] += sums[i];
    for (int p = 0; p < JACKKNIFE_PAIRS; p++)
        jackknife_add_pair(images, p, counts, all, sums, errors, weights);
    return true;
}

/* All lengths that are in the image. */
static bool jackknife_lengths(jackknife_images_t *images, const groups_t *groups, const double *factor,
                              const double *errors, const double *weights)
{
    bool some = false;
    for (uint32_t k = 0; k < groups->lengths; k++) {
        if (factor[k] == 0)
            continue;
        if (!jackknife_add(images, groups, k, factor[k], errors[k] / factor[k], weights))
            return false;
        some = true;
    }
    return some;
}

/* Sums of squared differences with several weights: those at hand; by the image itself; by fourteen groups, and by
 * thirteen, the mean. */
typedef struct jackknife_sums {
    double hand, own, rest, fewer;
} jackknife_sums_t;

static double jackknife_weight(const jackknife_images_t *images, double value, double floor)
{
    return 1 / (value * value + floor) / images->n;
}

static jackknife_sums_t jackknife_sum(const jackknife_images_t *images, int p, double floor, const double *weights)
{
    const jackknife_pair_t *pair = &images->pairs[p];
    jackknife_sums_t sums = {0};
    for (uint32_t i = 0; i < images->n; i++) {
        const double square = pair->difference[i] * pair->difference[i];
        double fewer = 0;
        for (int j = 0; j < JACKKNIFE_REST; j++)
            fewer += jackknife_weight(images, pair->fewer[j][i], floor) / JACKKNIFE_REST;
        sums.hand += square * weights[i];
        sums.own += square * jackknife_weight(images, images->all[i], floor);
        sums.rest += square * jackknife_weight(images, pair->rest[i], floor);
        sums.fewer += square * fewer;
    }
    return sums;
}

/* How many times what one group less does to the image's variance is in that by fourteen groups, where sixteen have
 * `even` times that of independent ones: without a pair, or one more group, the points of nets have gaps, and what
 * is added is as if they were independent. Thirteen if all are. */
static double jackknife_steps(const jackknife_images_t *images)
{
    const double even = images->errors / images->independent, rest = JACKKNIFE_REST;
    return (even / GROUPS_COUNT + 1 / rest - 1.0 / GROUPS_COUNT) / (1 / (rest - 1) - 1 / rest);
}

static double jackknife_right(const jackknife_sums_t *sums, double steps)
{
    return sums->rest - steps * (sums->fewer - sums->rest);
}

/* What the pairs say; false if it is nothing. */
static bool jackknife_ratio(jackknife_t *out, const jackknife_images_t *images, double floor, const double *weights)
{
    jackknife_sums_t pairs[JACKKNIFE_PAIRS], all = {0};
    double squares = 0;
    const double steps = jackknife_steps(images);
    for (int p = 0; p < JACKKNIFE_PAIRS; p++) {
        pairs[p] = jackknife_sum(images, p, floor, weights);
        all.hand += pairs[p].hand;
        all.own += pairs[p].own;
        all.rest += pairs[p].rest;
        all.fewer += pairs[p].fewer;
    }
    const double right = jackknife_right(&all, steps), by_logarithms = all.rest * pow(all.rest / all.fewer, steps);
    if (!(all.hand > 0 && all.rest <= 2 * right && all.own >= 0.5 * right))
        return false;
    out->ratio = right / all.hand;
    out->room = fmax(0, by_logarithms / right - 1);
    for (int p = 0; p < JACKKNIFE_PAIRS; p++) {
        const double off = jackknife_right(&pairs[p], steps) - out->ratio * pairs[p].hand;
        squares += off * off;
    }
    out->error = sqrt(squares * JACKKNIFE_PAIRS / (JACKKNIFE_PAIRS - 1.0)) / all.hand;
    return true;
}

bool jackknife_measure(jackknife_t *out, const groups_t *groups, const double *factor, const double *errors,
                       double floor, const double weights[GROUPS_SPOTS], double prior)
{
    jackknife_images_t images;
    jackknife_t found;
    *out = (jackknife_t){.ratio = 1};
    if (!jackknife_open(&images, groups->spot_count))
        return false;
    const bool known = jackknife_lengths(&images, groups, factor, errors, weights) &&
                       jackknife_ratio(&found, &images, floor, weights);
    free(images.data);
    if (!known)
        return false;
    const double part = prior * prior / (prior * prior + found.error * found.error);
    *out = (jackknife_t){1 + part * (found.ratio - 1), sqrt(part) * found.error, part * found.room};
    return true;
}
