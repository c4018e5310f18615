/* plan_estimate.c: the image and its error, from the sums alone.
 *
 * Chains: I = sum_k (b_k / N_k) S_k, S_k the film of length k, N_k its mutations. Units of one length are (given
 * the seeds) independent and of equal size, so the variance of S_k is that between units: U_k / (U_k - 1) (Q_k -
 * S_k^2 / U_k), Q_k the sum of squares. The error of b_k itself adds (sigma_{b_k} / b_k)^2 I_k^2. Samples: the same
 * with one film.
 */
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

double plan_length_b(const plan_length_t *length, double *error)
{
    return moments_mean(&length->moments[0], length->b, error);
}

double plan_technique_b(const plan_length_t *length, uint32_t s, double *error)
{
    return moments_mean(&length->moments[1 + s], length->b, error);
}

/* Image value of a film's unit for length k; 0 if nothing was rendered. */
static double pixel_factor(const plan_t *plan, uint32_t k)
{
    const plan_length_t *length = &plan->lengths[k];
    if (length->merged == 0)
        return 0;
    if (k == 0)
        return 1 / (plan->scale * (double)length->merged * FILM_ONE);
    double error;
    return plan_length_b(length, &error) / ((double)length->merged * FILM_ONE);
}

void plan_pixel(const plan_t *plan, size_t pixel, double value[3], double variance[3])
{
    double squares_scale = 0, units = 0; /* squares -> image units^2 */
    const uint32_t K = plan_is_chains(plan) ? plan->settings.max_path_length : 0;
    double merged = 0;
    for (uint32_t k = K ? 1 : 0; k <= K; k++)
        merged += (double)plan->lengths[k].merged;
    for (int c = 0; c < FILM_CHANNELS; c++)
        value[c] = variance[c] = 0;
    if (!(merged > 0))
        return;
    squares_scale = plan->weight_max / merged;
    for (uint32_t k = K ? 1 : 0; k <= K; k++) {
        const plan_length_t *length = &plan->lengths[k];
        if (length->merged == 0)
            continue;
        const double factor = pixel_factor(plan, k);
        const double c_k = k == 0 ? 1 : length->b / length->share / plan->weight_max;
        double b_error = 0;
        const double b = k == 0 ? 1 : plan_length_b(length, &b_error);
        for (int c = 0; c < FILM_CHANNELS; c++) {
            const double sum = (double)length->film.sums[FILM_CHANNELS * pixel + (size_t)c];
            const double part = sum * factor, x = sum / FILM_ONE * c_k;
            value[c] += part;
            variance[c] += b_error * b_error / (b * b) * part * part -
                           squares_scale * squares_scale * x * x / (double)length->units_in;
        }
        units += (double)length->units_in * length->share;
    }
    for (int c = 0; c < FILM_CHANNELS; c++) {
        const double squares = (double)plan->squares[FILM_CHANNELS * pixel + (size_t)c] * 0x1p-20;
        variance[c] += squares * squares_scale * squares_scale;
        variance[c] = units > 1 ? fmax(0, variance[c]) * units / (units - 1) : INFINITY;
    }
}

double plan_estimate_relmse(const plan_t *plan)
{
    uint64_t units = 0;
    for (uint32_t k = 0; k <= plan->settings.max_path_length; k++)
        units += plan->lengths[k].units_in;
    if (units < 16)
        return NAN;
    double mean = 0, value[3], variance[3];
    for (size_t p = 0; p < plan->pixels; p++) {
        plan_pixel(plan, p, value, variance);
        mean += rgb_luminance(rgb(value[0], value[1], value[2]));
    }
    mean /= (double)plan->pixels;
    if (!(mean > 0))
        return NAN;
    const double floor = 0.01 * mean * mean; /* accuracy: both images are scaled to mean luminance 1 */
    double sum = 0;
    for (size_t p = 0; p < plan->pixels; p++) {
        plan_pixel(plan, p, value, variance);
        for (int c = 0; c < FILM_CHANNELS; c++)
            sum += variance[c] / (value[c] * value[c] + floor);
    }
    return sum / (double)(FILM_CHANNELS * plan->pixels);
}
