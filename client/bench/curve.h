/* curve.h: how an error falls over time, as the pictures of benches show it: medians over the seeds as a line, a
 * band from the least to the most, both axes logarithmic. */
#ifndef CLIENT_BENCH_CURVE_H
#define CLIENT_BENCH_CURVE_H

#include "client/bench/spread.h"
#include "draw/svg.h"

enum { CURVE_POINTS = 16 };

/* All zero: no points. */
typedef struct curve {
    double time[CURVE_POINTS], middle[CURVE_POINTS], low[CURVE_POINTS], high[CURVE_POINTS];
    size_t count;
} curve_t;

/* A point is passed over if its time or median is not known or not positive: an error near the noise of its
 * reference. */
void curve_add(curve_t *curve, double time, spread_t error);

/* A range grows to hold what is positive; all zero: of nothing. */
typedef struct curve_range {
    double low, high;
} curve_range_t;

void curve_range_take(curve_range_t *range, double value);
void curve_range_take_curve(curve_range_t *x, curve_range_t *y, const curve_t *curve);
/* With a margin (a factor) on both sides; something to show where there is nothing. */
curve_range_t curve_range_finish(curve_range_t range, double margin);

/* All bands of a panel go before all lines. */
void curve_draw_band(svg_t *svg, const svg_panel_t *panel, const curve_t *curve, const svg_style_t *style);
/* A whisker where there is but one point; the title says what the last point is. */
void curve_draw_line(svg_t *svg, const svg_panel_t *panel, const curve_t *curve, const svg_style_t *style,
                     const char *name);

#endif
