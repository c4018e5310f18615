/* plan_estimate.c: the image and its error, from the sums alone.
 *
 * Chains: I = sum_k (b_k / N_k) S_k, S_k the film of length k, N_k its mutations. Units of one length are (given
 * the seeds) independent, their variance in proportion to their size n (1 but for the last one), so the variance of
 * S_k is that between units: n_k / (U_k - 1) (Q_k - S_k^2 / n_k), Q_k the sum of x^2 / n over U_k units, n_k the
 * sum of n. Lengths share one sum of squares, so n_k / (U_k - 1) is a mean over them. The error of b_k itself adds
 * (sigma_{b_k} / b_k)^2 I_k^2. Samples, and chains of all lengths at once: the same with one film.
 */
#include <stdlib.h>

#include "plan/plan_state.h"

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

/* The error is relative to the reference, which is not known: in its place stands the image, smoothed over 7 x 7
 * pixels. The pixel's own value would not do: where an outlier makes its variance large it makes the value large
 * too, and their ratio hides it. `values` and `variances`: a plane per channel. */
static double estimate_of_planes(const plan_t *plan, double *values, const double *variances, double *line)
{
    const size_t n = plan->pixels;
    double mean = 0, sum = 0;
    for (size_t p = 0; p < n; p++)
        mean += rgb_luminance(rgb(values[p], values[n + p], values[2 * n + p]));
    mean /= (double)n;
    if (!(mean > 0))
        return NAN;
    const double floor = 0.01 * mean * mean; /* both images are scaled to mean luminance 1 */
    for (size_t c = 0; c < FILM_CHANNELS; c++) {
        double *plane = values + c * n;
        estimate_smooth(plane, line, plan->settings.width, plan->settings.height, 3);
        for (size_t p = 0; p < n; p++)
            sum += variances[c * n + p] / (plane[p] * plane[p] + floor);
    }
    return sum / (double)(FILM_CHANNELS * n);
}

double plan_estimate_relmse(const plan_t *plan)
{
    uint64_t units = 0;
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        units += plan->lengths[k].units_in;
    if (units < 16)
        return NAN;
    const settings_t *s = &plan->settings;
    const size_t n = plan->pixels, longest = s->width > s->height ? s->width : s->height;
    double *room = malloc(sizeof *room * (2 * FILM_CHANNELS * n + longest));
    if (!room)
        return NAN;
    double *values = room, *variances = room + FILM_CHANNELS * n;
    plan_pixels_t pixels;
    plan_pixels_init(&pixels, plan);
    for (size_t p = 0; p < n; p++) {
        double value[3], variance[3];
        plan_pixel(&pixels, p, value, variance);
        for (size_t c = 0; c < FILM_CHANNELS; c++) {
            values[c * n + p] = value[c];
            variances[c * n + p] = variance[c];
        }
    }
    const double relmse = estimate_of_planes(plan, values, variances, room + 2 * FILM_CHANNELS * n);
    free(room);
    return relmse;
}
