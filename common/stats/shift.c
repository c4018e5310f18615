#include "stats/shift.h"

#include <math.h>

/* Units that the pilot's word counts as; how far a share moves at once; what has to be won: a part of the error at
 * the same cost. */
static const double SHIFT_PRIOR = 4, SHIFT_MOVE = 4, SHIFT_WORTH = 0.02;

static bool shift_is_known(const shift_length_t *length)
{
    return length->prior > 0 && length->units >= 2;
}

/* The variances that go with the pilot's shares are prior^2 cost but for one factor: that which makes the error at
 * unit cost, (sum sqrt(v c))^2, of the lengths that are known what it was measured to be. */
static double shift_scale(const shift_length_t *lengths, uint32_t count)
{
    double measured = 0, implied = 0;
    for (uint32_t k = 0; k < count; k++) {
        if (!shift_is_known(&lengths[k]))
            continue;
        measured += sqrt(lengths[k].variance * lengths[k].cost);
        implied += lengths[k].prior * lengths[k].cost;
    }
    return implied > 0 ? measured / implied : 0;
}

static double shift_variance(const shift_length_t *length, double scale)
{
    const double prior = scale * scale * length->prior * length->prior * length->cost;
    if (!shift_is_known(length))
        return prior;
    return (SHIFT_PRIOR * prior + length->units * length->variance) / (SHIFT_PRIOR + length->units);
}

/* Error times cost. */
static double shift_product(const shift_length_t *lengths, uint32_t count, const double *variances,
                            const double *shares)
{
    double error = 0, cost = 0;
    for (uint32_t k = 0; k < count; k++) {
        if (!(shares[k] > 0))
            continue;
        error += variances[k] / shares[k];
        cost += shares[k] * lengths[k].cost;
    }
    return error * cost;
}

/* What is asked for, within bounds, and made to add up: those inside their bounds give or take in proportion. */
static void shift_fit(const shift_length_t *lengths, uint32_t count, double *shares)
{
    double all = 0, low[SHIFT_MOST], high[SHIFT_MOST], factor_low = 0, factor_high = INFINITY;
    for (uint32_t k = 0; k < count; k++) {
        const shift_length_t *length = &lengths[k];
        all += length->last;
        low[k] = fmin(length->last, fmax(length->least, length->last / SHIFT_MOVE));
        high[k] = length->last * SHIFT_MOVE;
        if (shares[k] > 0) {
            factor_high = fmin(factor_high, low[k] / shares[k]);
            factor_low = fmax(factor_low, high[k] / shares[k]);
        }
    }
    double from = factor_high, to = factor_low; /* all at their low ends; all at their high ends */
    for (int i = 0; i < 100; i++) {
        const double factor = sqrt(from * to);
        double sum = 0;
        for (uint32_t k = 0; k < count; k++)
            sum += fmin(fmax(factor * shares[k], low[k]), high[k]);
        *(sum < all ? &from : &to) = factor;
    }
    double sum = 0;
    for (uint32_t k = 0; k < count; k++)
        sum += shares[k] = fmin(fmax(to * shares[k], low[k]), high[k]);
    for (uint32_t k = 0; k < count; k++)
        shares[k] *= all / sum;
}

bool shift_shares(const shift_length_t *lengths, uint32_t count, double *shares)
{
    const double scale = shift_scale(lengths, count);
    double variances[SHIFT_MOST], last[SHIFT_MOST];
    for (uint32_t k = 0; k < count; k++) {
        variances[k] = shift_variance(&lengths[k], scale);
        last[k] = lengths[k].last;
        shares[k] = lengths[k].prior > 0 ? sqrt(variances[k] / lengths[k].cost) : 0;
    }
    if (scale > 0)
        shift_fit(lengths, count, shares);
    if (scale > 0 && shift_product(lengths, count, variances, shares) <
                         (1 - SHIFT_WORTH) * shift_product(lengths, count, variances, last))
        return true;
    for (uint32_t k = 0; k < count; k++)
        shares[k] = lengths[k].last;
    return false;
}
