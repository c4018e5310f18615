#include "client/bench/curve.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>

void curve_add(curve_t *curve, double time, spread_t error)
{
    if (!(time > 0) || !(error.median > 0))
        return;
    assert(curve->count < CURVE_POINTS);
    curve->time[curve->count] = time;
    curve->middle[curve->count] = error.median;
    curve->low[curve->count] = error.min > 0 ? error.min : error.median;
    curve->high[curve->count++] = error.max;
}

void curve_range_take(curve_range_t *range, double value)
{
    if (!(value > 0) || !isfinite(value))
        return;
    range->low = range->low > 0 ? fmin(range->low, value) : value;
    range->high = fmax(range->high, value);
}

void curve_range_take_curve(curve_range_t *x, curve_range_t *y, const curve_t *curve)
{
    for (size_t i = 0; i < curve->count; i++) {
        curve_range_take(x, curve->time[i]);
        curve_range_take(y, curve->low[i]);
        curve_range_take(y, curve->high[i]);
    }
}

curve_range_t curve_range_finish(curve_range_t range, double margin)
{
    if (!(range.low > 0))
        return (curve_range_t){0.1, 10};
    return (curve_range_t){range.low / margin, range.high * margin};
}

void curve_draw_band(svg_t *svg, const svg_panel_t *panel, const curve_t *curve, const svg_style_t *style)
{
    if (curve->count > 1)
        svg_band(svg, panel, curve->time, curve->low, curve->high, curve->count, style);
}

void curve_draw_line(svg_t *svg, const svg_panel_t *panel, const curve_t *curve, const svg_style_t *style,
                     const char *name)
{
    char title[192];
    if (curve->count == 0)
        return;
    const size_t last = curve->count - 1;
    snprintf(title, sizeof title, "%.100s: %.3g (%.3g to %.3g) after %.3g s", name, curve->middle[last],
             curve->low[last], curve->high[last], curve->time[last]);
    if (curve->count == 1)
        svg_whisker(svg, panel, curve->time[0], curve->middle[0], curve->low[0], curve->high[0], style, title);
    else
        svg_line(svg, panel, curve->time, curve->middle, curve->count, style, title);
}
