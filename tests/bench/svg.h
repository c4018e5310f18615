/* svg.h: plots with logarithmic axes as SVG: panels, lines with bands, dots with whiskers. Words stay words, in
 * whatever sans-serif font the reader has; every mark carries a title that says its numbers.
 *
 *     svg_t *svg = svg_new(900, 400, "A title", "What a reader who cannot see it is told");
 *     svg_panel_t panel = {.left = 60, .top = 40, .width = 200, .height = 120, .x0 = 1, .x1 = 8, .y0 = .1, .y1 =
 * 9}; svg_grid(svg, &panel, "ring-box"); svg_band(svg, &panel, x, low, high, 4, &style); svg_line(svg, &panel, x,
 * middle, 4, &style, "mmlt"); char *text = svg_finish(&svg);
 *
 * Sizes are in pixels from the upper left corner; values outside a panel's range are drawn at its edge; those that
 * are not positive are left out. Out of memory aborts, as nothing here is large. One thread a plot. */
#ifndef TESTS_BENCH_SVG_H
#define TESTS_BENCH_SVG_H

#include <stddef.h>

typedef struct svg svg_t;

typedef struct svg_panel {
    double left, top, width, height;
    double x0, x1, y0, y1; /* the range shown, positive. y0 = y1: no y axis, rows instead (svg_row) */
} svg_panel_t;

typedef struct svg_style {
    const char *colour; /* "#rrggbb" */
    const char *dash;   /* as in stroke-dasharray; "": none */
    int shape;          /* of dots: 0 disk, 1 square, 2 triangle */
} svg_style_t;

svg_t *svg_new(int width, int height, const char *title, const char *description);
/* Frame, grid and numbers of both axes, a title above. */
void svg_grid(svg_t *svg, const svg_panel_t *panel, const char *title);
/* A number below the x axis with a grid line. */
void svg_tick_x(svg_t *svg, const svg_panel_t *panel, double x, const char *label);

void svg_band(svg_t *svg, const svg_panel_t *panel, const double *x, const double *low, const double *high,
              size_t count, const svg_style_t *style);
void svg_line(svg_t *svg, const svg_panel_t *panel, const double *x, const double *y, size_t count,
              const svg_style_t *style, const char *title);
/* A dot at x on the height y (pixels), a line from low to high, a small tick at `other` (NaN: none). */
void svg_row(svg_t *svg, const svg_panel_t *panel, double y, double x, double low, double high, double other,
             const svg_style_t *style, const char *title);

/* anchor: "start", "middle" or "end". */
void svg_text(svg_t *svg, double x, double y, const char *anchor, double size, const char *words);
/* A stroke with a dot, and words to its right. */
void svg_key(svg_t *svg, double x, double y, const svg_style_t *style, const char *words);

/* The document; the caller frees it. Destroys the plot and nulls the pointer. */
char *svg_finish(svg_t **svg);

#endif
