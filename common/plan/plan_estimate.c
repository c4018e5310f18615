/* plan_estimate.c: the image and its error, from the sums alone.
 *
 * Chains: I = sum_k (b_k / N_k) S_k, S_k the film of length k, N_k its mutations. Units of one length are (given
 * the seeds) independent, their variance in proportion to their size n (1 but for the last one), so the variance of
 * S_k is that between units: n_k / (U_k - 1) (Q_k - S_k^2 / n_k), Q_k the sum of x^2 / n over U_k units, n_k the
 * sum of n. Units that count by weights w (plan_eras.h) have them in film, N_k and n; sum w^2 x^2 / (w n) less the
 * square over the sum of w n is then sum w - sum w^2 n / sum w n variances of one unit, and the film has sum w^2 n
 * of them: U_k is plan_eras_units. Lengths share one sum of squares by pixel, in which they have the weights that
 * the plan foresaw; what b_k / N_k and U_k have become since is known by length. So the squares are brought to the
 * image's variance by a factor (`correction`) that is a mean over lengths, each with its part of the variance in a
 * block of the image. The error of b_k itself adds (sigma_{b_k} / b_k)^2 I_k^2. Samples, and chains of all lengths
 * at once: the same with one film; what passes of samples differ by is more than what their points leave of it, by
 * a factor that is measured (plan_nets.h).
 */
#include "plan/plan_estimate.h"

#include <stdio.h>
#include <stdlib.h>

#include "stats/jackknife.h"
#include "plan/plan_regions.h"
#include "stats/scatter.h"
#include "film/smooth.h"

/* An estimate of chains needs so many units, and has to have seen all but a part of what they bring. Of samples a
 * single pass over the image will do. */
enum { ESTIMATE_UNITS = 4, FILTER_RADIUS = 3 /* pixels */ };
static const double ESTIMATE_UNSEEN = 2;

static double moments_mean(const plan_moments_t *moments, double unit, double *error)
{
    const double n = exact_value(&moments->n, 1);
    if (!(n > 0)) {
        *error = 0;
        return 0;
    }
    const double mean = exact_value(&moments->sum, unit) / n;
    const double square = exact_value(&moments->sum2, unit * unit) / n;
    *error = n > 1 ? sqrt(fmax(0, square - mean * mean) / (n - 1)) : INFINITY;
    return mean;
}

/* Of what is added up by weights w (plan_eras.h): by how much the variance of its mean is larger than that of as
 * many values with weight 1: sum w^2 m / sum w m over the units of lengths[k], beside values with weight 1 (of n in
 * all). */
static double moments_spread(const plan_t *plan, uint32_t k, double n)
{
    const double counted = plan_eras_counted(plan, k), squared = plan_eras_squared(plan, k);
    if (!(counted > 0) || squared == counted)
        return 1;
    const double part = k > 0 ? 1 : fmin(counted / n, 1); /* large steps are all of such units */
    return 1 + part * (squared / counted - 1);
}

/* An estimator's mean by samples and by large steps, with errors and weights. */
typedef struct estimate_two {
    double samples, steps, e_samples, e_steps, w_samples, w_steps;
} estimate_two_t;

/* Two estimators of the same: bidirectional samples and large steps. A large step tries one of the length's
 * techniques, a sample all of them, so a sample counts as so many large steps: weights fixed beforehand keep the
 * mean unbiased. */
static estimate_two_t estimate_two(const plan_t *plan, uint32_t k, uint32_t entry)
{
    const plan_length_t *length = &plan->lengths[k];
    const double samples = exact_value(&length->samples[entry].n, 1),
                 steps = exact_value(&length->large_steps[entry].n, 1);
    estimate_two_t two = {.w_samples = samples * (k + 1), .w_steps = steps};
    two.samples = moments_mean(&length->samples[entry], plan->b, &two.e_samples);
    two.steps = moments_mean(&length->large_steps[entry], plan->b, &two.e_steps);
    two.e_samples *= sqrt(moments_spread(plan, 0, samples));
    two.e_steps *= sqrt(moments_spread(plan, k, steps));
    return two;
}

static double estimate_join(const plan_t *plan, uint32_t k, uint32_t entry, double *error)
{
    const estimate_two_t two = estimate_two(plan, k, entry);
    if (!(two.w_steps > 0)) {
        *error = two.e_samples;
        return two.samples;
    }
    const double total = two.w_samples + two.w_steps;
    *error = hypot(two.w_samples * two.e_samples, two.w_steps * two.e_steps) / total;
    return (two.w_samples * two.samples + two.w_steps * two.steps) / total;
}

double plan_length_b_by_samples(const plan_t *plan, uint32_t k)
{
    const estimate_two_t two = estimate_two(plan, k, 0);
    const double samples = two.w_samples * two.e_samples, steps = two.w_steps * two.e_steps,
                 all = samples * samples + steps * steps;
    return all > 0 && isfinite(all) ? samples * samples / all : 1;
}

double plan_length_b(const plan_t *plan, uint32_t k, double *error)
{
    if (k > 0)
        return estimate_join(plan, k, 0, error);
    double b = 0;
    *error = 0;
    for (k = 1; k <= plan->settings.max_path_length; k++) {
        double e;
        b += estimate_join(plan, k, 0, &e);
        *error += e;
    }
    return b;
}

double plan_film_b(const plan_t *plan, uint32_t k, double *error)
{
    *error = 0;
    return plan_is_samples(plan, k) ? 1 / plan->scale : plan_length_b(plan, k, error);
}

double plan_technique_b(const plan_t *plan, uint32_t k, uint32_t s, double *error)
{
    return estimate_join(plan, k, 1 + s, error);
}

/* The squares of a film's sums, by block: rows of a block are runs of numbers. */
static void pixels_square(const plan_t *plan, const int64_t *sums, double blocks[GROUPS_BLOCKS])
{
    const uint32_t width = plan->settings.width, height = plan->settings.height;
    for (uint32_t block = 0; block < GROUPS_BLOCKS; block++)
        blocks[block] = 0;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < GROUPS_SIDE; x++) {
            const int64_t *row = sums + FILM_CHANNELS * (size_t)width * y;
            const size_t end = (size_t)FILM_CHANNELS * groups_begin(x + 1, width);
            double squares = 0;
            for (size_t i = (size_t)FILM_CHANNELS * groups_begin(x, width); i < end; i++)
                squares += (double)row[i] * (double)row[i];
            blocks[groups_block(y, height) * GROUPS_SIDE + x] += squares;
        }
}

/* Squares of one length less what their mean takes off them, by block. */
static void pixels_blocks(const plan_pixels_t *pixels, uint32_t i, double blocks[GROUPS_BLOCKS])
{
    const plan_t *plan = pixels->plan;
    for (uint32_t block = 0; block < GROUPS_BLOCKS; block++)
        blocks[block] = fmax(0, groups_squares(&plan->groups, pixels->lengths[i], block) * pixels->squares_factor -
                                    pixels->squared[i][block] * pixels->square[i]);
}

/* A chain length with a single unit has no variance yet. What it will bring beside the others is foreseen by their
 * shares (plan_budget.c): they stand in for it. */
static double pixels_unseen(const plan_t *plan)
{
    double all = 0, seen = 0;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        const plan_length_t *length = &plan->lengths[k];
        if (length->merged == 0 || plan_is_samples(plan, k))
            continue;
        const double part = plan_is_whole(plan) ? 1 : length->b * length->need / (double)length->merged;
        all += part;
        seen += length->units_in > 1 ? part : 0;
    }
    return all > 0 ? all / seen : 1;
}

static void pixels_correct(plan_pixels_t *pixels)
{
    const plan_t *plan = pixels->plan;
    const double unseen = pixels_unseen(plan);
    const bool known = unseen <= ESTIMATE_UNSEEN;
    double all[GROUPS_BLOCKS] = {0}, sums[2] = {0, 0};
    for (uint32_t i = 0; i < pixels->count; i++) {
        const double units = plan_eras_units(plan, pixels->lengths[i]);
        double blocks[GROUPS_BLOCKS];
        if (units < 2 && plan_is_samples(plan, pixels->lengths[i])) {
            pixels->single = pixels->sums[i];
            pixels->single_factor = 0.5 * pixels->factor[i] * pixels->factor[i];
        }
        if (units < 2)
            continue;
        pixels->excess[i] = pixels->factor[i] * pixels->factor[i] / pixels->square[i] / (units - 1);
        const bool samples = plan_is_samples(plan, pixels->lengths[i]);
        pixels->excess[i] *= samples ? 1 : unseen;
        pixels_blocks(pixels, i, blocks);
        for (uint32_t block = 0; block < GROUPS_BLOCKS; block++) {
            all[block] += blocks[block];
            pixels->correction[block] +=
                blocks[block] * pixels->excess[i] * (samples ? plan->nets.blocks[block] : 1);
        }
        pixels->excess[i] *= samples ? plan->nets.all : 1;
    }
    for (uint32_t block = 0; block < GROUPS_BLOCKS; block++) {
        sums[0] += pixels->correction[block];
        sums[1] += all[block];
    }
    for (uint32_t block = 0; block < GROUPS_BLOCKS; block++) {
        if (!known)
            pixels->correction[block] = INFINITY;
        else if (all[block] > 0)
            pixels->correction[block] /= all[block];
        else
            pixels->correction[block] = sums[1] > 0 ? sums[0] / sums[1] : 1;
    }
}

void plan_pixels_init(plan_pixels_t *pixels, const plan_t *plan)
{
    *pixels = (plan_pixels_t){.plan = plan};
    const uint32_t first = plan_first(plan), last = plan_last(plan);
    double counted = 0;
    for (uint32_t k = first; k <= last; k++)
        counted += plan_mutations_of(plan, k) * plan_counted(plan, k);
    const double squares = plan->weight_max / counted; /* of one unit of c_k x */
    for (uint32_t k = first; k <= last; k++) {
        const plan_length_t *length = &plan->lengths[k];
        if (length->merged == 0)
            continue;
        const uint32_t i = pixels->count++;
        pixels->lengths[i] = k;
        double b_error;
        const double b = plan_film_b(plan, k, &b_error), c_k = plan_weight(plan, k) / plan->weight_max;
        pixels->sums[i] = length->film.sums;
        pixels->factor[i] = b / (plan_counted(plan, k) * FILM_ONE);
        pixels->b_variance[i] = b_error * b_error / (b * b) * pixels->factor[i] * pixels->factor[i];
        const double size = plan_eras_counted(plan, k) / (double)length->unit_mutations;
        pixels->square[i] = squares * squares * c_k * c_k / (FILM_ONE * FILM_ONE * size);
        pixels_square(plan, length->film.sums, pixels->squared[i]);
    }
    pixels->squares_factor = squares * squares * 0x1p-40;
    pixels_correct(pixels);
}

/* A single unit of samples has no variance between units: half the squared difference from the next pixel stands in
 * for it, which is too large by how the image itself differs there. */
static double pixels_single(const plan_pixels_t *pixels, size_t p, size_t c)
{
    const uint32_t width = pixels->plan->settings.width;
    if (!pixels->single || width < 2)
        return 0;
    const size_t next = (p + 1) % width ? p + 1 : p - 1;
    const double d =
        (double)pixels->single[FILM_CHANNELS * p + c] - (double)pixels->single[FILM_CHANNELS * next + c];
    return d * d * pixels->single_factor;
}

void plan_pixel(const plan_pixels_t *pixels, size_t p, double value[3], double variance[3])
{
    const double correction = pixels->correction[plan_block(pixels->plan, p)];
    for (size_t c = 0; c < FILM_CHANNELS; c++) {
        double v = 0, b_part = 0, taken = 0;
        for (uint32_t i = 0; i < pixels->count; i++) {
            const double sum = (double)pixels->sums[i][FILM_CHANNELS * p + c];
            v += sum * pixels->factor[i];
            b_part += sum * sum * pixels->b_variance[i];
            taken += sum * sum * pixels->square[i];
        }
        const double squares = (double)pixels->plan->squares[FILM_CHANNELS * p + c] * pixels->squares_factor;
        value[c] = v;
        variance[c] = pixels_single(pixels, p, c) + b_part + (squares > taken ? (squares - taken) * correction : 0);
    }
}

/* Planes of the image: values and variances, [FILM_CHANNELS][pixels] each. */
typedef struct estimate_planes {
    double *values, *variances;
    double *scratch; /* three planes, and what smoothing needs */
    double floor;    /* 0.01 m^2, m the mean luminance: both images are scaled to mean luminance 1 */
} estimate_planes_t;

/* The error is relative to the reference, which is not known: in its place stands the image without its noise. The
 * pixel's own value would not do: where an outlier makes its variance large it makes the value large too, and their
 * ratio hides it. Nor would the mean over its neighbours: pixels that are dark among bright ones would count for
 * little. Between the two is Lee's filter (Digital image enhancement and noise filtering by use of local
 * statistics, 1980), the local linear estimate of least error, here over 7 x 7 pixels:
 *
 *     mean + own / (own + 9 variance) (value - mean),   own = max(0, spread - 3 mean variance).
 *
 * The factors, one in Lee's, are on the safe side because variances are themselves estimates, small in most pixels
 * and large in few: what is within three standard deviations is taken for noise. */
static void estimate_filter(const plan_t *plan, estimate_planes_t *planes, size_t c)
{
    const settings_t *s = &plan->settings;
    const size_t n = plan->pixels;
    double *values = planes->values + c * n, *mean = planes->scratch, *square = mean + n, *noise = square + n,
           *smoothing = noise + n;
    for (size_t p = 0; p < n; p++) {
        mean[p] = values[p];
        square[p] = values[p] * values[p];
        noise[p] = planes->variances[c * n + p];
    }
    smooth_square(mean, s->width, s->height, FILTER_RADIUS, smoothing);
    smooth_square(square, s->width, s->height, FILTER_RADIUS, smoothing);
    smooth_square(noise, s->width, s->height, FILTER_RADIUS, smoothing);
    for (size_t p = 0; p < n; p++) {
        const double own = fmax(0, square[p] - mean[p] * mean[p] - 3 * noise[p]),
                     all = own + 9 * planes->variances[c * n + p];
        values[p] = mean[p] + (all > 0 ? own / all : 0) * (values[p] - mean[p]);
    }
}

/* False without memory or light. */
static bool estimate_planes(const plan_t *plan, const plan_pixels_t *pixels, estimate_planes_t *planes)
{
    const settings_t *s = &plan->settings;
    const size_t n = plan->pixels, smoothing = smooth_scratch(s->width, s->height, FILTER_RADIUS);
    planes->values = malloc(sizeof(double) * ((2 * FILM_CHANNELS + 3) * n + smoothing));
    if (!planes->values)
        return false;
    planes->variances = planes->values + FILM_CHANNELS * n;
    planes->scratch = planes->variances + FILM_CHANNELS * n;
    double mean = 0;
    for (size_t p = 0; p < n; p++) {
        double value[3], variance[3];
        plan_pixel(pixels, p, value, variance);
        mean += rgb_luminance(rgb(value[0], value[1], value[2])) / (double)n;
        for (size_t c = 0; c < FILM_CHANNELS; c++) {
            planes->values[c * n + p] = value[c];
            planes->variances[c * n + p] = variance[c];
        }
    }
    planes->floor = 0.01 * mean * mean;
    for (size_t c = 0; c < FILM_CHANNELS; c++)
        estimate_filter(plan, planes, c);
    return mean > 0;
}

static double estimate_weight(const plan_t *plan, const estimate_planes_t *planes, size_t p, size_t c)
{
    const double value = planes->values[c * plan->pixels + p];
    return 1 / (value * value + planes->floor) / (double)(FILM_CHANNELS * plan->pixels);
}

static double estimate_relmse(const plan_t *plan, const estimate_planes_t *planes)
{
    double sum = 0;
    for (size_t p = 0; p < plan->pixels; p++)
        for (size_t c = 0; c < FILM_CHANNELS; c++)
            sum += planes->variances[c * plan->pixels + p] * estimate_weight(plan, planes, p, c);
    return sum;
}

/* Weights of the squared errors of luminance at the spots of the groups. */
static void estimate_spots(const plan_t *plan, const estimate_planes_t *planes, double weights[GROUPS_SPOTS])
{
    for (uint32_t i = 0; i < plan->groups.spot_count; i++) {
        const size_t p = groups_spot(&plan->groups, i);
        const double value = rgb_luminance(
            rgb(planes->values[p], planes->values[plan->pixels + p], planes->values[2 * plan->pixels + p]));
        weights[i] = 1 / (value * value + planes->floor) / plan->groups.spot_count;
    }
}

/* What samples bring to relMSE, with its standard error, of weights at hand. */
typedef struct estimate_samples {
    bool known; /* else their two sequences (plan_nets.h) do not tell */
    double relmse, error;
} estimate_samples_t;

/* Directly by what both sequences differ by: over all pixels that is sure, and nothing is said of how nets help in
 * this pixel or that. Channels go together; of a normal number's square the variance is two thirds of its own
 * square's mean. */
static estimate_samples_t estimate_samples(const plan_pixels_t *pixels, const estimate_planes_t *planes)
{
    const plan_t *plan = pixels->plan;
    plan_nets_pair_t pair;
    estimate_samples_t samples = {.known = plan_is_samples(plan, 0) && pixels->count > 0 &&
                                           pixels->lengths[0] == 0 &&
                                           plan_nets_pair(plan, pixels->factor[0], &pair)};
    for (size_t p = 0; p < plan->pixels && samples.known; p++) {
        double part = 0;
        for (size_t c = 0; c < FILM_CHANNELS; c++) {
            const size_t i = FILM_CHANNELS * p + c;
            part += plan_nets_variance(&pair, pixels->sums[0][i], plan->nets.second.sums[i]) *
                    estimate_weight(plan, planes, p, c);
        }
        samples.relmse += part;
        samples.error += 2.0 / 3 * part * part;
    }
    samples.error = sqrt(samples.error);
    return samples;
}

/* What films of lengths bring to relMSE by the errors of the b_k. */
static void estimate_of_b(const plan_pixels_t *pixels, const estimate_planes_t *planes, plan_error_t *error)
{
    const plan_t *plan = pixels->plan;
    uint32_t with_b[PATH_MAX_VERTICES], count = 0;
    for (uint32_t i = 0; i < pixels->count; i++)
        if (pixels->b_variance[i] > 0)
            with_b[count++] = i;
    for (size_t p = 0; p < plan->pixels && count > 0; p++)
        for (size_t c = 0; c < FILM_CHANNELS; c++) {
            const double weight = estimate_weight(plan, planes, p, c);
            for (uint32_t i = 0; i < count; i++) {
                const double x = (double)pixels->sums[with_b[i]][FILM_CHANNELS * p + c];
                error->of_b[pixels->lengths[with_b[i]]] += x * x * weight * pixels->b_variance[with_b[i]];
            }
        }
}

static double estimate_single(const plan_pixels_t *pixels, const estimate_planes_t *planes)
{
    const plan_t *plan = pixels->plan;
    double sum = 0;
    for (size_t p = 0; p < plan->pixels && pixels->single; p++)
        for (size_t c = 0; c < FILM_CHANNELS; c++)
            sum += estimate_weight(plan, planes, p, c) * pixels_single(pixels, p, c);
    return sum;
}

/* What each length brings to relMSE, and relMSE, which is `relmse` by all variances together. Squares are kept by
 * block for each length, and a block's mean weight says little where a lamp is beside a shadow: so the films' part
 * is that of the spots, pixels with weights of their own; but for samples that both sequences tell of. */
static void estimate_lengths(const plan_pixels_t *pixels, const estimate_planes_t *planes,
                             const estimate_samples_t *samples, const double spots[GROUPS_SPOTS], double relmse,
                             plan_error_t *error)
{
    const plan_t *plan = pixels->plan;
    const double of_single = estimate_single(pixels, planes);
    double all = 0;
    estimate_of_b(pixels, planes, error);
    for (uint32_t i = 0; i < pixels->count; i++) {
        const uint32_t k = pixels->lengths[i];
        error->lengths[k] = error->of_b[k] + (plan_is_samples(plan, k) ? of_single : 0) +
                            scatter_part(&plan->groups, k, pixels->factor[i], spots) * plan_nets_factor(plan, k);
        all += error->lengths[k];
    }
    error->relmse = all > 0 ? 0 : relmse;
    for (uint32_t i = 0; i < pixels->count && all > 0; i++) { /* spots are not quite all pixels */
        const uint32_t k = pixels->lengths[i];
        error->lengths[k] = k == 0 && samples->known ? samples->relmse : error->lengths[k] * relmse / all;
        error->of_b[k] *= relmse / all;
        error->relmse += error->lengths[k];
    }
}

/* The relative variance of relMSE by the errors of the b_k, each one normal number. */
static double estimate_b_variance(const plan_pixels_t *pixels, const plan_error_t *error)
{
    double squares = 0;
    for (uint32_t i = 0; i < pixels->count; i++)
        squares += error->of_b[pixels->lengths[i]] * error->of_b[pixels->lengths[i]];
    return 2 * squares / (error->relmse * error->relmse);
}

/* By the weights that they should have. */
static void estimate_reweigh(plan_error_t *error, const plan_t *plan, double ratio)
{
    error->relmse *= ratio;
    for (uint32_t k = 0; k <= plan_last(plan); k++) {
        error->lengths[k] *= ratio;
        error->of_b[k] *= ratio;
    }
}

/* The part of the image that bears the error: of so many pixels and channels, were all of them alike, the squares
 * would add up to what they do. */
static double estimate_part(const plan_t *plan, const estimate_planes_t *planes)
{
    double sum = 0, squares = 0;
    for (size_t p = 0; p < plan->pixels; p++)
        for (size_t c = 0; c < FILM_CHANNELS; c++) {
            const double part = planes->variances[c * plan->pixels + p] * estimate_weight(plan, planes, p, c);
            sum += part;
            squares += part * part;
        }
    return squares > 0 ? sum * sum / squares / (double)(FILM_CHANNELS * plan->pixels) : 0;
}

/* Whether few paths make most of the error, by what the render has seen of them: then there are likely others that
 * it has not. How often that is right is in docs/accuracy.md. `part`: of the image, that bears the error. */
static void estimate_trust(const scatter_t *scatter, double part, plan_error_t *error)
{
    const double most_scatter = 0.25, most_dominance = 0.25, least_part = 0.01;
    if (scatter->dominance > most_dominance)
        snprintf(error->reason, sizeof error->reason,
                 "one of %d groups of units brings %.0f %% of the squared error", GROUPS_COUNT,
                 100 * scatter->dominance);
    else if (part < least_part)
        snprintf(error->reason, sizeof error->reason, "%.2g %% of the pixels bring most of the squared error",
                 100 * part);
    else if (scatter->own > most_scatter)
        snprintf(error->reason, sizeof error->reason,
                 "the squared error scatters by %.0f %% between groups of units", 100 * scatter->own);
    error->reliable = !error->reason[0];
}

/* Of the groups at the spots: weights of the squared errors; what the films of the lengths are multiplied by for
 * the image, and for its errors: of samples that is less (plan_nets.h). */
typedef struct estimate_groups {
    double weights[GROUPS_SPOTS], factor[PATH_MAX_VERTICES], errors[PATH_MAX_VERTICES];
} estimate_groups_t;

static void estimate_groups(const plan_pixels_t *pixels, const estimate_planes_t *planes, estimate_groups_t *groups)
{
    *groups = (estimate_groups_t){0};
    estimate_spots(pixels->plan, planes, groups->weights);
    for (uint32_t i = 0; i < pixels->count; i++) {
        const uint32_t k = pixels->lengths[i];
        groups->factor[k] = pixels->factor[i];
        groups->errors[k] = pixels->factor[i] * sqrt(plan_nets_factor(pixels->plan, k));
    }
}

/* What noise does to the weights (stats/jackknife.h), and how much of it the filter leaves. Known beforehand: of a
 * pixel it does to w(x) = 1 / (x^2 + floor), by the second order of Taylor's series, 0.5 w'' / w variance = (3 x^2
 * - floor) / (x^2 + floor) e, at most three times its relative squared error e; of all pixels, each with its e,
 * three times sum e^2 / sum e, which is relMSE over the `part` of the image that bears it. And over scenes and
 * algorithms the filter is off by a tenth (docs/accuracy.md; the root of the mean square). Where the groups say
 * nothing there is room for twice relMSE. */
static jackknife_t estimate_weigh(const plan_t *plan, const estimate_groups_t *groups, double floor, double relmse,
                                  double part)
{
    const double off = 0.1, prior = fmin(3 * relmse / part, off);
    jackknife_t weighed;
    if (!jackknife_measure(&weighed, &plan->groups, groups->factor, groups->errors, floor, groups->weights, prior))
        weighed.room = 2 * relmse;
    return weighed;
}

/* The estimate and the error itself differ independently of each other: a sum of their variances. The upper end has
 * room for what noise does to the weights and is not known. `of_b`: relative variance by the errors of the b_k. */
static void estimate_interval(const plan_t *plan, const estimate_groups_t *groups, const jackknife_t *weighed,
                              double of_b, double of_samples, double part, plan_error_t *error)
{
    scatter_t scatter;
    error->reason[0] = 0;
    if (!scatter_measure(&scatter, &plan->groups, groups->errors, groups->weights, plan_is_samples(plan, 0))) {
        snprintf(error->reason, sizeof error->reason, "too few units of work to see how the error scatters");
        return;
    }
    scatter.own = hypot(scatter.own, sqrt(of_b));
    scatter.estimate = hypot(hypot(scatter.estimate, weighed->error / weighed->ratio), of_samples);
    const double sigma = plan_student(scatter.freedom) * hypot(scatter.own, scatter.estimate);
    error->spread = scatter.estimate;
    error->low = error->relmse * exp(-sigma);
    error->high = error->relmse * exp(sigma) * (1 + weighed->room);
    estimate_trust(&scatter, part, error);
}

void plan_estimate_error(const plan_t *plan, plan_error_t *error)
{
    *error = (plan_error_t){.relmse = NAN, .spread = NAN, .low = NAN, .high = NAN};
    uint64_t units = 0;
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        units += plan->lengths[k].units_in;
    snprintf(error->reason, sizeof error->reason, "too few units of work for an estimate");
    if (units < (plan_runs_chains(plan) ? ESTIMATE_UNITS : 1) || pixels_unseen(plan) > ESTIMATE_UNSEEN)
        return;
    plan_pixels_t pixels;
    plan_pixels_init(&pixels, plan);
    estimate_planes_t planes = {0};
    if (estimate_planes(plan, &pixels, &planes)) {
        estimate_groups_t groups;
        const double relmse = estimate_relmse(plan, &planes), part = estimate_part(plan, &planes);
        estimate_groups(&pixels, &planes, &groups);
        const jackknife_t weighed = estimate_weigh(plan, &groups, planes.floor, relmse, part);
        const estimate_samples_t samples = estimate_samples(&pixels, &planes);
        estimate_lengths(&pixels, &planes, &samples, groups.weights, relmse, error);
        const double of_b = estimate_b_variance(&pixels, error), of_samples = samples.error / error->relmse;
        estimate_reweigh(error, plan, weighed.ratio);
        error->weighed = weighed.error > 0;
        estimate_interval(plan, &groups, &weighed, of_b, of_samples, part, error);
    }
    free(planes.values);
}
