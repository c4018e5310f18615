#include "stats/rates.h"

#include <math.h>

#include "path/walk.h"

/* Lengths that share a rate. */
typedef struct rates_block {
    double part, cost;
    uint32_t count;
} rates_block_t;

static double rates_of(const rates_block_t *block)
{
    return sqrt(block->part / block->cost);
}

rates_figures_t rates_best(const double *parts, const double *costs, uint32_t count, double *rates)
{
    rates_block_t blocks[PATH_MAX_LENGTH];
    uint32_t used = 0;
    for (uint32_t k = 0; k < count; k++) {
        blocks[used++] = (rates_block_t){fmax(parts[k], 0), fmax(costs[k], 1e-3), 1};
        while (used > 1 && rates_of(&blocks[used - 2]) <= rates_of(&blocks[used - 1])) {
            rates_block_t *into = &blocks[used - 2];
            into->part += blocks[used - 1].part;
            into->cost += blocks[used - 1].cost;
            into->count += blocks[--used].count;
        }
    }
    rates_figures_t figures = {0}, plain = {0};
    const double most = rates_of(&blocks[0]);
    for (uint32_t b = 0, k = 0; b < used; b++) {
        const double rate = most > 0 ? fmax(rates_of(&blocks[b]) / most, 1.0 / RATES_SELDOM) : 1;
        figures.variance += blocks[b].part / rate;
        figures.cost += blocks[b].cost * rate;
        for (uint32_t i = 0; i < blocks[b].count; i++)
            rates[k++] = rate;
        plain.variance += blocks[b].part;
        plain.cost += blocks[b].cost;
    }
    if (plain.variance * plain.cost > RATES_GAIN * figures.variance * figures.cost)
        return figures;
    for (uint32_t k = 0; k < count; k++)
        rates[k] = 1;
    return plain;
}
