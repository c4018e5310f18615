#include "math/table.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "math/warp.h"

enum { TABLE_MAX_GUIDE = 1 << 30 };

static fault_code_t check_weights(const double *weights, uint32_t count, long double *sum, fault_t *fault)
{
    *sum = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (!(weights[i] >= 0 && weights[i] <= 0x1.fffffffffffffp1023))
            return fault_set(fault, FAULT_RANGE,
                             "table: weight %u is %g, expected a finite number that isn't negative", i, weights[i]);
        *sum += weights[i];
    }
    if (!(*sum > 0 && isfinite((double)*sum)))
        return fault_set(fault, FAULT_RANGE,
                         "table: the sum of the %u weights is %Lg, expected a positive finite number", count, *sum);
    return FAULT_NONE;
}

/* The same partial sums as check_weights: the last quotient is exactly 1, and a zero weight repeats its neighbour.
 */
static void fill_cdf(double *cdf, const double *weights, uint32_t count, long double sum)
{
    long double partial = 0;
    cdf[0] = 0;
    for (uint32_t i = 0; i < count; i++) {
        partial += weights[i];
        cdf[i + 1] = (double)(partial / sum);
    }
}

static void fill_guide(table1_t *table)
{
    const double step = 1.0 / table->guide_count;
    uint32_t entry = 0;
    for (uint32_t i = 0; i < table->guide_count; i++) {
        while (table->cdf[entry + 1] <= i * step)
            entry++;
        table->guide[i] = entry;
    }
    uint32_t last = table->count - 1;
    while (table->cdf[last] == table->cdf[last + 1])
        last--;
    table->guide[table->guide_count] = last;
}

fault_code_t table1_init(table1_t *table, const double *weights, uint32_t count, fault_t *fault)
{
    memset(table, 0, sizeof *table);
    long double sum;
    TRY(check_weights(weights, count, &sum, fault));
    uint32_t guide_count = 1;
    while (guide_count < count && guide_count < TABLE_MAX_GUIDE)
        guide_count *= 2;
    table->count = count;
    table->guide_count = guide_count;
    table->sum = (double)sum;
    table->cdf = malloc(((size_t)count + 1) * sizeof *table->cdf);
    table->guide = malloc(((size_t)guide_count + 1) * sizeof *table->guide);
    if (!table->cdf || !table->guide) {
        table1_clear(table);
        return fault_set(fault, FAULT_MEMORY, "table: no memory for %u entries", count);
    }
    fill_cdf(table->cdf, weights, count, sum);
    fill_guide(table);
    return FAULT_NONE;
}

void table1_clear(table1_t *table)
{
    free(table->cdf);
    free(table->guide);
    memset(table, 0, sizeof *table);
}

uint32_t table1_sample(const table1_t *table, double u, double *probability, double *rest)
{
    /* exact: guide_count is a power of two */
    const uint32_t cell = (uint32_t)(u * table->guide_count);
    const double *const cdf = table->cdf;
    uint32_t low = table->guide[cell], high = table->guide[cell + 1];
    while (high - low > 4) { /* the entry is in [low, high] */
        const uint32_t middle = low + (high - low) / 2;
        if (cdf[middle + 1] <= u)
            low = middle + 1;
        else
            high = middle;
    }
    while (cdf[low + 1] <= u)
        low++;
    const double p = cdf[low + 1] - cdf[low];
    *probability = p;
    if (rest)
        *rest = warp_clamp_unit((u - cdf[low]) / p);
    return low;
}

double table1_probability(const table1_t *table, uint32_t entry)
{
    return table->cdf[entry + 1] - table->cdf[entry];
}

double table1_invert(const table1_t *table, uint32_t entry, double rest)
{
    const double begin = table->cdf[entry], end = table->cdf[entry + 1];
    const double u = begin + rest * (end - begin);
    return u < end ? u : fmax(begin, nextafter(end, 0.0));
}

static bool row_is_zero(const double *row, uint32_t width)
{
    for (uint32_t x = 0; x < width; x++)
        if (row[x] != 0)
            return false;
    return true;
}

static fault_code_t fill_rows(table2_t *table, const double *weights, double *sums, fault_t *fault)
{
    for (uint32_t y = 0; y < table->height; y++) {
        const double *row = weights + (size_t)y * table->width;
        if (row_is_zero(row, table->width))
            continue;
        TRY(fault_prefix(fault, table1_init(&table->columns[y], row, table->width, fault), "row %u", y));
        sums[y] = table->columns[y].sum;
    }
    return table1_init(&table->rows, sums, table->height, fault);
}

fault_code_t table2_init(table2_t *table, const double *weights, uint32_t width, uint32_t height, fault_t *fault)
{
    memset(table, 0, sizeof *table);
    fault_code_t code;
    double *sums = calloc((size_t)height + 1, sizeof *sums);
    table->columns = calloc((size_t)height + 1, sizeof *table->columns);
    table->width = width;
    table->height = height;
    if (!sums || !table->columns)
        code = fault_set(fault, FAULT_MEMORY, "table: no memory for %u rows", height);
    else
        code = fill_rows(table, weights, sums, fault);
    free(sums);
    if (code != FAULT_NONE)
        table2_clear(table);
    return code;
}

void table2_clear(table2_t *table)
{
    for (uint32_t y = 0; table->columns && y < table->height; y++)
        table1_clear(&table->columns[y]);
    free(table->columns);
    table1_clear(&table->rows);
    memset(table, 0, sizeof *table);
}

/* (entry + rest) / count, below (entry + 1) / count even after rounding: the point is in the entry's cell. */
static double place_in_cell(uint32_t entry, double rest, uint32_t count)
{
    const double cells = entry + rest;
    const double x = (cells < entry + 1.0 ? cells : nextafter(entry + 1.0, 0.0)) / count;
    return (uint32_t)(x * count) == entry ? x : nextafter(x, (uint32_t)(x * count) < entry ? 1.0 : 0.0);
}

static uint32_t cell_of(double x, uint32_t count)
{
    const uint32_t cell = (uint32_t)(x * count);
    return cell < count ? cell : count - 1;
}

double table2_sample(const table2_t *table, double u, double v, double *x, double *y)
{
    double row_probability, column_probability, rest;
    const uint32_t row = table1_sample(&table->rows, v, &row_probability, &rest);
    *y = place_in_cell(row, rest, table->height);
    const uint32_t column = table1_sample(&table->columns[row], u, &column_probability, &rest);
    *x = place_in_cell(column, rest, table->width);
    return row_probability * column_probability * ((double)table->width * table->height);
}

double table2_pdf(const table2_t *table, double x, double y)
{
    const uint32_t row = cell_of(y, table->height), column = cell_of(x, table->width);
    if (!table->columns[row].count)
        return 0;
    return table1_probability(&table->rows, row) * table1_probability(&table->columns[row], column) *
           ((double)table->width * table->height);
}

void table2_invert(const table2_t *table, double x, double y, double *u, double *v)
{
    const uint32_t row = cell_of(y, table->height), column = cell_of(x, table->width);
    *v = warp_clamp_unit(table1_invert(&table->rows, row, warp_clamp_unit(y * table->height - row)));
    *u = !table->columns[row].count ? 0
                                    : warp_clamp_unit(table1_invert(&table->columns[row], column,
                                                                    warp_clamp_unit(x * table->width - column)));
}
