/* svg.h: plots as SVG: panels with logarithmic or linear axes, lines, areas, dots with whiskers, bars. Words stay
 * words, in whatever sans-serif font the reader has; every mark carries a title that says its numbers.
 *
 *     svg_t *svg = svg_new(900, 400, "A title", "What a reader who cannot see it is told");
 *     svg_panel_t panel = {.left = 60, .top = 40, .width = 200, .height = 120, .x0 = 1, .x1 = 8, .y0 = .1, .y1 =
 * 9}; svg_grid(svg, &panel, "ring-box"); svg_band(svg, &panel, x, low, high, 4, &style); svg_line(svg, &panel, x,
 * middle, 4, &style, "mmlt"); char *text = svg_finish(&svg);
 *
 * Sizes are in pixels from the upper left corner; values outside a panel's range are drawn at its edge; on a
 * logarithmic axis those that are not positive are left out, and nowhere is drawn what is not a number. Colours are
 * whatever SVG takes for a fill, "#2060a0" or "var(--name)". All words are escaped. Out of memory aborts, as
 * nothing here is large. One thread a plot. */
#ifndef DRAW_SVG_H
#define DRAW_SVG_H

#include <stdbool.h>
#include <stddef.h>

typedef struct svg svg_t;

typedef struct svg_panel {
    double left, top, width, height;
    double x0, x1, y0,
        y1; /* the range shown, positive where logarithmic. y0 = y1: no y axis, rows instead (svg_row) */
    bool linear_x, linear_y;
} svg_panel_t;

typedef struct svg_style {
    const char *colour;
    const char *dash; /* as in stroke-dasharray; "": none */
    int shape;        /* of dots: 0 disk, 1 square, 2 triangle; -1: none */
} svg_style_t;

/* A document of its own: dark on white, its title above. */
svg_t *svg_new(int width, int height, const char *title, const char *description);
/* A part of an HTML page, as wide as there is room. `id` begins its elements' ids. The page's style sheet gives the
 * colours --ink, --muted, --grid and --surface; the title is for readers who cannot see it. */
svg_t *svg_new_embedded(int width, int height, const char *id, const char *title, const char *description);

/* ---- axes ---- */

/* Frame, grid and numbers of the y axis (of the x axis where there are rows), a title above ("": none). */
void svg_grid(svg_t *svg, const svg_panel_t *panel, const char *title);
void svg_frame(svg_t *svg, const svg_panel_t *panel);
/* A label below the x axis, or left of the y axis, with a grid line. */
void svg_tick_x(svg_t *svg, const svg_panel_t *panel, double x, const char *label);
void svg_tick_y(svg_t *svg, const svg_panel_t *panel, double y, const char *label);
/* What the axes show: below, and above the upper left corner. */
void svg_axis_names(svg_t *svg, const svg_panel_t *panel, const char *x, const char *y);
/* Where a value lies. */
double svg_place_x(const svg_panel_t *panel, double x);
double svg_place_y(const svg_panel_t *panel, double y);

/* ---- marks in a panel ---- */

void svg_band(svg_t *svg, const svg_panel_t *panel, const double *x, const double *low, const double *high,
              size_t count, const svg_style_t *style);
/* A polygon, as pale as a band. */
void svg_area(svg_t *svg, const svg_panel_t *panel, const double *x, const double *y, size_t count,
              const svg_style_t *style);
void svg_line(svg_t *svg, const svg_panel_t *panel, const double *x, const double *y, size_t count,
              const svg_style_t *style, const char *title);
/* Dots alone. */
void svg_dot(svg_t *svg, const svg_panel_t *panel, double x, double y, const svg_style_t *style, const char *title);
/* A dot with a line from low to high. */
void svg_whisker(svg_t *svg, const svg_panel_t *panel, double x, double y, double low, double high,
                 const svg_style_t *style, const char *title);
/* A line across. */
void svg_level(svg_t *svg, const svg_panel_t *panel, double y, const svg_style_t *style);
/* A dot at x on the height y (pixels), a line from low to high, a small tick at `other` (NaN: none). */
void svg_row(svg_t *svg, const svg_panel_t *panel, double y, double x, double low, double high, double other,
             const svg_style_t *style, const char *title);

/* ---- marks in pixels ---- */

void svg_rect(svg_t *svg, double left, double top, double width, double height, const char *colour, double opacity,
              const char *title);
/* anchor: "start", "middle" or "end". */
void svg_text(svg_t *svg, double x, double y, const char *anchor, double size, const char *words);
/* The same in another colour than the text's. */
void svg_text_in(svg_t *svg, double x, double y, const char *anchor, double size, const char *colour,
                 const char *words);
/* A stroke with a dot, and words to its right. */
void svg_key(svg_t *svg, double x, double y, const svg_style_t *style, const char *words);

/* The document; the caller frees it. Destroys the plot and nulls the pointer. */
char *svg_finish(svg_t **svg);

#endif
