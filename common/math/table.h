/* table.h: piecewise-constant distributions by CDF inversion, in one and two dimensions.
 *
 * One interval per entry, so that an inverse exists: sampling maps u to (entry, position within the entry) and
 * table1_invert maps back, with the Jacobian 1/pdf. An entry's probability is the length of its interval as stored,
 * so that sampling and density agree to the last bit; zero entries have empty intervals and are never returned, and
 * so has an entry of less than about 1e-16 of the sum. A guide table (Chen and Asau 1974) makes look-up constant
 * time on average.
 *
 * Accuracy: u is known to 1.1e-16, so the place within an entry of probability p comes back to about 1.1e-16 / p.
 * Immutable after creation; any thread. The look-ups check nothing.
 */
#ifndef MATH_TABLE_H
#define MATH_TABLE_H

#include <stdint.h>

#include "base/fault.h"

typedef struct table1 {
    uint32_t count;
    uint32_t guide_count; /* a power of two */
    double sum;           /* of the weights as given */
    double *cdf;          /* count + 1: cdf[0] = 0, cdf[count] = 1, non-decreasing */
    uint32_t *guide; /* guide_count + 1; guide[i]: the first entry whose interval ends beyond i / guide_count; the
                        last one: the last entry that isn't empty */
} table1_t;

/* weights[count], finite, not negative, with a positive finite sum (else FAULT_RANGE). Copied. On a fault the table
 * is clear. */
fault_code_t table1_init(table1_t *table, const double *weights, uint32_t count, fault_t *fault);
/* Releases and zeroes; a zeroed table may be cleared too. */
void table1_clear(table1_t *table);

/* The entry of u in [0,1) with its discrete probability; *rest (may be null) is u's place within it, in [0,1). */
uint32_t table1_sample(const table1_t *table, double u, double *probability, double *rest);
double table1_probability(const table1_t *table, uint32_t entry);
/* The number u that gives `entry` (not an empty one) with the place `rest` in [0,1) inside it; always inside the
 * entry's interval. */
double table1_invert(const table1_t *table, uint32_t entry, double rest);

/* A 2D table over [0,1)^2, row-major weights[height][width]: a marginal table of rows and one conditional a row.
 * Densities are per unit area of the square. */
typedef struct table2 {
    uint32_t width, height;
    table1_t rows;
    table1_t *columns; /* height; a row of zeros has none */
} table2_t;

fault_code_t table2_init(table2_t *table, const double *weights, uint32_t width, uint32_t height, fault_t *fault);
void table2_clear(table2_t *table);
/* (x,y) in [0,1)^2 from (u,v) in [0,1)^2, y by v; returns the density. */
double table2_sample(const table2_t *table, double u, double v, double *x, double *y);
double table2_pdf(const table2_t *table, double x, double y);
/* Where table2_pdf is zero there is no such (u,v); some numbers in [0,1) are returned. */
void table2_invert(const table2_t *table, double x, double y, double *u, double *v);

#endif
