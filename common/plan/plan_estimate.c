/* plan_estimate.c: the image and its error, from the sums alone.
 *
 * Chains: I = sum_k (b_k / N_k) S_k, S_k the film of length k, N_k its mutations. Units of one length are (given
 * the seeds) independent, their variance in proportion to their size n (1 but for the last one), so the variance of
 * S_k is that between units: n_k / (U_k - 1) (Q_k - S_k^2 / n_k), Q_k the sum of x^2 / n over U_k units, n_k the
 * sum of n. Lengths share one sum of squares, so n_k / (U_k - 1) is a mean over them. The error of b_k itself adds
 * (sigma_{b_k} / b_k)^2 I_k^2. Samples, and chains of all lengths at once: the same with one film.
 */
#include "plan/plan_estimate.h"

#include <stdlib.h>

static const double ESTIMATE_STUDENT = 2.131; /* 97.5 % at PLAN_GROUPS - 1 degrees of freedom */

static double moments_mean(const plan_moments_t *moments, double unit, double *error)
{
    const double n = moments->n;
    if (!(n > 0)) {
        *error = 0;
        return 0;
    }
    const double mean = exact_value(&moments->sum, unit) / n;
    const double square = exact_value(&moments->sum2, unit * unit) / n;
    *error = n > 1 ? sqrt(fmax(0, square - mean * mean) / (n - 1)) : INFINITY;
    return mean;
}

/* Two estimators of the same: bidirectional samples and large steps. A large step tries one of the length's
 * techniques, a sample all of them, so a sample counts as so many large steps: weights fixed beforehand keep the
 * mean unbiased. */
static double estimate_join(const plan_t *plan, uint32_t k, uint32_t entry, double *error)
{
    const plan_length_t *length = &plan->lengths[k];
    double e_samples, e_steps;
    const double samples = moments_mean(&length->samples[entry], plan->b, &e_samples),
                 steps = moments_mean(&length->large_steps[entry], plan->b, &e_steps);
    const double w_samples = length->samples[entry].n * (k + 1), w_steps = length->large_steps[entry].n;
    if (!(w_steps > 0)) {
        *error = e_samples;
        return samples;
    }
    const double total = w_samples + w_steps;
    *error = hypot(w_samples * e_samples, w_steps * e_steps) / total;
    return (w_samples * samples + w_steps * steps) / total;
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

double plan_technique_b(const plan_t *plan, uint32_t k, uint32_t s, double *error)
{
    return estimate_join(plan, k, 1 + s, error);
}

void plan_pixels_init(plan_pixels_t *pixels, const plan_t *plan)
{
    *pixels = (plan_pixels_t){.plan = plan};
    const uint32_t first = plan_first(plan), last = plan_last(plan);
    double counted = 0, units = 0, sizes = 0;
    for (uint32_t k = first; k <= last; k++)
        counted += plan_mutations_of(plan, k) * plan_counted(plan, &plan->lengths[k]);
    const double squares = plan->weight_max / counted; /* of one unit of c_k x */
    for (uint32_t k = first; k <= last; k++) {
        const plan_length_t *length = &plan->lengths[k];
        if (length->merged == 0)
            continue;
        const uint32_t i = pixels->count++;
        pixels->lengths[i] = k;
        double b_error = 0;
        const double b = plan_is_samples(plan, k) ? 1 / plan->scale : plan_length_b(plan, k, &b_error),
                     c_k = plan_weight(plan, k) / plan->weight_max;
        pixels->sums[i] = length->film.sums;
        pixels->factor[i] = b / (plan_counted(plan, length) * FILM_ONE);
        pixels->b_variance[i] = b_error * b_error / (b * b) * pixels->factor[i] * pixels->factor[i];
        const double size = (double)length->merged / (double)length->unit_mutations;
        pixels->square[i] = squares * squares * c_k * c_k / (FILM_ONE * FILM_ONE * size);
        units += (double)length->units_in * length->share;
        sizes += size * length->share;
    }
    pixels->squares_factor = squares * squares * 0x1p-40;
    pixels->correction = units > 1 ? sizes / (units - 1) : INFINITY;
}

void plan_pixel(const plan_pixels_t *pixels, size_t p, double value[3], double variance[3])
{
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
        variance[c] = b_part + (squares > taken ? (squares - taken) * pixels->correction : 0);
    }
}

/* In place: the mean over a square of (2 r + 1)^2 pixels, cut at the image's edge; two passes with running sums. */
static void estimate_smooth(double *plane, double *line, uint32_t width, uint32_t height, uint32_t r)
{
    for (int pass = 0; pass < 2; pass++) {
        const uint32_t n = pass ? height : width, lines = pass ? width : height;
        const size_t step = pass ? width : 1, stride = pass ? 1 : width;
        for (uint32_t l = 0; l < lines; l++) {
            double *from = plane + stride * l, sum = 0;
            for (uint32_t i = 0; i < n; i++)
                line[i] = from[step * i];
            for (uint32_t i = 0; i < r && i < n; i++)
                sum += line[i];
            for (uint32_t i = 0; i < n; i++) {
                sum += i + r < n ? line[i + r] : 0;
                sum -= i > r ? line[i - r - 1] : 0;
                const uint32_t low = i > r ? i - r : 0, high = i + r < n ? i + r : n - 1;
                from[step * i] = sum / (high - low + 1);
            }
        }
    }
}

/* Planes of the image: values and variances, [FILM_CHANNELS][pixels] each. */
typedef struct estimate_planes {
    double *values, *variances;
    double *scratch; /* three planes and a line */
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
           *line = noise + n;
    for (size_t p = 0; p < n; p++) {
        mean[p] = values[p];
        square[p] = values[p] * values[p];
        noise[p] = planes->variances[c * n + p];
    }
    estimate_smooth(mean, line, s->width, s->height, 3);
    estimate_smooth(square, line, s->width, s->height, 3);
    estimate_smooth(noise, line, s->width, s->height, 3);
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
    const size_t n = plan->pixels, longest = s->width > s->height ? s->width : s->height;
    planes->values = malloc(sizeof(double) * ((2 * FILM_CHANNELS + 3) * n + longest));
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

static uint32_t estimate_block(const plan_t *plan, size_t p)
{
    const uint32_t x = (uint32_t)(p % plan->settings.width), y = (uint32_t)(p / plan->settings.width);
    return plan_groups_block(y, plan->settings.height) * PLAN_GROUP_SIDE +
           plan_groups_block(x, plan->settings.width);
}

/* relMSE, and the mean weight of each block's pixels. */
static double estimate_relmse(const plan_t *plan, const estimate_planes_t *planes,
                              double weights[PLAN_GROUP_BLOCKS])
{
    double sum = 0, counts[PLAN_GROUP_BLOCKS] = {0};
    for (uint32_t i = 0; i < PLAN_GROUP_BLOCKS; i++)
        weights[i] = 0;
    for (size_t p = 0; p < plan->pixels; p++) {
        const uint32_t block = estimate_block(plan, p);
        for (size_t c = 0; c < FILM_CHANNELS; c++) {
            const double weight = estimate_weight(plan, planes, p, c);
            sum += planes->variances[c * plan->pixels + p] * weight;
            weights[block] += weight;
            counts[block]++;
        }
    }
    for (uint32_t i = 0; i < PLAN_GROUP_BLOCKS; i++)
        weights[i] = counts[i] > 0 ? weights[i] / counts[i] : 0;
    return sum;
}

/* Squares of a length come by block, what their mean takes off them by pixel: with the blocks' weights both. */
static void estimate_lengths(const plan_pixels_t *pixels, const double weights[PLAN_GROUP_BLOCKS], double relmse,
                             double lengths[PATH_MAX_VERTICES])
{
    const plan_t *plan = pixels->plan;
    double all = 0;
    for (uint32_t i = 0; i < pixels->count; i++) {
        double taken = 0, b_part = 0;
        for (size_t p = 0; p < plan->pixels; p++)
            for (size_t c = 0; c < FILM_CHANNELS; c++) {
                const double sum = (double)pixels->sums[i][FILM_CHANNELS * p + c],
                             square = sum * sum * weights[estimate_block(plan, p)];
                taken += square * pixels->square[i];
                b_part += square * pixels->b_variance[i];
            }
        const double squares =
            plan_groups_squares(&plan->groups, pixels->lengths[i], weights) * pixels->squares_factor;
        lengths[pixels->lengths[i]] = b_part + fmax(0, squares - taken) * pixels->correction;
        all += lengths[pixels->lengths[i]];
    }
    for (uint32_t i = 0; i < pixels->count && all > 0; i++) /* blocks' weights are not quite the pixels' */
        lengths[pixels->lengths[i]] *= relmse / all;
}

void plan_estimate_error(const plan_t *plan, plan_error_t *error)
{
    *error = (plan_error_t){NAN, NAN, NAN, NAN, {0}};
    uint64_t units = 0;
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        units += plan->lengths[k].units_in;
    if (units < 16)
        return;
    plan_pixels_t pixels;
    plan_pixels_init(&pixels, plan);
    estimate_planes_t planes;
    if (estimate_planes(plan, &pixels, &planes)) {
        double weights[PLAN_GROUP_BLOCKS], mutations[PATH_MAX_VERTICES];
        error->relmse = estimate_relmse(plan, &planes, weights);
        for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
            mutations[k] = plan_mutations_of(plan, k);
        error->spread = plan_groups_spread(&plan->groups, weights, mutations);
        error->low = error->relmse * exp(-ESTIMATE_STUDENT * error->spread);
        error->high = error->relmse * exp(ESTIMATE_STUDENT * error->spread);
        estimate_lengths(&pixels, weights, error->relmse, error->lengths);
    }
    free(planes.values);
}

bool plan_estimate_groups(const plan_t *plan, plan_group_figures_t *figures)
{
    double factor[PATH_MAX_VERTICES] = {0}, blocks[PLAN_GROUPS][PLAN_GROUP_BLOCKS], mean[PLAN_GROUP_BLOCKS] = {0},
           all = 0;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        double error;
        if (plan->lengths[k].units_in > 0)
            factor[k] = (plan_is_samples(plan, k) ? 1 / plan->scale : plan_length_b(plan, k, &error)) / FILM_ONE;
    }
    for (uint32_t g = 0; g < PLAN_GROUPS; g++) {
        plan_groups_image(&plan->groups, g, factor, blocks[g]);
        for (uint32_t i = 0; i < PLAN_GROUP_BLOCKS; i++)
            mean[i] += blocks[g][i] / PLAN_GROUPS;
    }
    for (uint32_t i = 0; i < PLAN_GROUP_BLOCKS; i++)
        all += mean[i] / PLAN_GROUP_BLOCKS;
    for (uint32_t g = 0; g < PLAN_GROUPS; g++) {
        double sum = 0, squares = 0;
        for (uint32_t i = 0; i < PLAN_GROUP_BLOCKS; i++) {
            const double difference = blocks[g][i] - mean[i];
            sum += blocks[g][i] / PLAN_GROUP_BLOCKS;
            squares += difference * difference / (mean[i] * mean[i] + 0.01 * all * all) / PLAN_GROUP_BLOCKS;
        }
        figures->brightness[g] = sum / all;
        figures->deviation[g] = sqrt(squares);
    }
    return all > 0;
}

/* Light of one length in a region of blocks, of each group. */
static void estimate_region_groups(const plan_t *plan, uint32_t k, double b, const bool region[PLAN_GROUP_BLOCKS],
                                   double groups[PLAN_GROUPS])
{
    double factor[PATH_MAX_VERTICES] = {0}, blocks[PLAN_GROUP_BLOCKS];
    factor[k] = b / FILM_ONE;
    for (uint32_t g = 0; g < PLAN_GROUPS; g++) {
        groups[g] = 0;
        plan_groups_image(&plan->groups, g, factor, blocks);
        for (uint32_t i = 0; i < PLAN_GROUP_BLOCKS; i++)
            groups[g] += region[i] ? blocks[i] : 0;
    }
}

bool plan_estimate_region(const plan_t *plan, const bool region[PLAN_GROUP_BLOCKS], plan_region_t *out)
{
    double groups[PLAN_GROUPS] = {0}, mean = 0, variance = 0, pixels = 0;
    for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
        double own[PLAN_GROUPS], error = 0, light = 0;
        if (plan->lengths[k].units_in == 0)
            continue;
        if (plan->lengths[k].units_in < PLAN_GROUPS)
            return false;
        const double b = plan_is_samples(plan, k) ? 1 / plan->scale : plan_length_b(plan, k, &error);
        estimate_region_groups(plan, k, b, region, own);
        for (uint32_t g = 0; g < PLAN_GROUPS; g++) {
            groups[g] += own[g];
            light += own[g] / PLAN_GROUPS;
        }
        mean += light;
        variance += light * light * error * error / (b * b);
    }
    for (uint32_t g = 0; g < PLAN_GROUPS; g++)
        variance += (groups[g] - mean) * (groups[g] - mean) / (PLAN_GROUPS * (PLAN_GROUPS - 1));
    for (size_t p = 0; p < plan->pixels; p++)
        pixels += region[estimate_block(plan, p)];
    if (!(mean > 0) || !(pixels > 0))
        return false;
    out->mean = mean / pixels;
    out->low = (mean - ESTIMATE_STUDENT * sqrt(variance)) / pixels;
    out->high = (mean + ESTIMATE_STUDENT * sqrt(variance)) / pixels;
    return true;
}
