/* jump_report.h: the reversible jump experiment as figures: all variants at both small steps, as text, JSON, SVG.
 *
 * Each variant runs as JUMP_REPORT_CHAINS independent chains, so that the sampling noise is known beside the
 * distance from the exact law. The report is a function of (steps, seed).
 */
#ifndef LAB_JUMP_REPORT_H
#define LAB_JUMP_REPORT_H

#include <stdint.h>
#include <stdio.h>

#include "base/json.h"
#include "client/lab/reversible_jump.h"

enum { JUMP_REPORT_CHAINS = 32, JUMP_REPORT_SIZES = 2 };

typedef struct jump_figures {
    double total_variation, noise; /* of the states; what noise alone would give, by expectation */
    double shares[TECHNIQUES];
    double states[JUMP_BINS];              /* share of the bin */
    double weights[TECHNIQUES][JUMP_BINS]; /* share of the technique within the bin */
} jump_figures_t;

typedef struct jump_report {
    uint64_t steps, seed;
    double sizes[JUMP_REPORT_SIZES]; /* of the small step */
    double exact_shares[TECHNIQUES];
    jump_figures_t figures[JUMP_REPORT_SIZES][JUMP_VARIANTS];
} jump_report_t;

/* The figures of one variant from `steps` steps in all; streams first, first + 1, ... of the seed. */
void jump_report_measure(jump_figures_t *figures, jump_variant_t variant, double size, uint64_t steps,
                         uint64_t seed, uint64_t first);
/* Fills *report; some 0.1 us a step and variant. */
void jump_report_run(jump_report_t *report, uint64_t steps, uint64_t seed);
void jump_report_print(const jump_report_t *report, FILE *out);
json_t *jump_report_json(const jump_report_t *report);
char *jump_report_svg(const jump_report_t *report); /* the caller frees it */

#endif
