/* table.h: piecewise-constant distributions by CDF inversion, in one and two dimensions.
 *
 * One interval per entry, so that an inverse exists: sampling maps u to (entry, position within the entry) and
 * table1_invert maps back, with the Jacobian 1/pdf. Zero entries have empty intervals and are never returned.
 * A guide table (Chen and Asau 1974) makes look-up constant time on average.
 * Immutable after creation; any thread.
 */
#ifndef MATH_TABLE_H
#define MATH_TABLE_H

#include <stdint.h>

#include "base/fault.h"

typedef struct table1 {
    uint32_t count;
    uint32_t guide_count;
    double sum;      /* of the weights as given */
    double *cdf;     /* count + 1: cdf[0] = 0, cdf[count] = 1, non-decreasing */
    uint32_t *guide; /* guide[i]: the first entry whose interval ends beyond i / guide_count */
} table1_t;

/* weights[count], finite, not negative, with a positive sum (else FAULT_RANGE). Copied. */
fault_code_t table1_init(table1_t *table, const double *weights, uint32_t count, fault_t *fault);
void table1_clear(table1_t *table);

/* The entry of u in [0,1) with its discrete probability; *rest (may be null) is u's place within it, in [0,1). */
uint32_t table1_sample(const table1_t *table, double u, double *probability, double *rest);
double table1_probability(const table1_t *table, uint32_t entry);
/* The number u that gives `entry` with the place `rest` in [0,1) inside it; always inside the entry's interval. */
double table1_invert(const table1_t *table, uint32_t entry, double rest);

/* A 2D table over [0,1)^2, row-major weights[height][width]: a marginal table of rows and one conditional a row.
 * Densities are per unit area of the square. */
typedef struct table2 {
    uint32_t width, height;
    table1_t rows;
    table1_t *columns; /* height */
} table2_t;

fault_code_t table2_init(table2_t *table, const double *weights, uint32_t width, uint32_t height, fault_t *fault);
void table2_clear(table2_t *table);
/* (x,y) in [0,1)^2 from (u,v) in [0,1)^2, y by v; returns the density. */
double table2_sample(const table2_t *table, double u, double v, double *x, double *y);
double table2_pdf(const table2_t *table, double x, double y);
void table2_invert(const table2_t *table, double x, double y, double *u, double *v);

#endif
