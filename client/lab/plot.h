/* plot.h: small pictures of functions and histograms as SVG: panels with axes, bars, bands, curves, words.
 *
 *     plot_t *plot = plot_new(640, 400, "A title");
 *     plot_panel_t panel = {.left = 60, .top = 40, .width = 200, .height = 120, .x1 = 1, .y1 = 2, .title = "..."};
 *     plot_axes(plot, &panel);
 *     plot_bars(plot, &panel, heights, 100, PLOT_BLUE);
 *     plot_curve(plot, &panel, f, data, PLOT_BLACK, false);
 *     char *svg = plot_finish(&plot);
 *
 * Sizes are in pixels from the upper left corner. Marks outside a panel's range are drawn at its edge. Texts must
 * not hold characters that XML reserves. Out of memory aborts, as nothing here is large. One thread a plot.
 */
#ifndef LAB_PLOT_H
#define LAB_PLOT_H

#include <stdbool.h>

typedef struct plot plot_t;

#define PLOT_BLACK "#202020"
#define PLOT_GREY "#8c8c8c"
#define PLOT_BLUE "#8fb4d9"
#define PLOT_ORANGE "#d95f02"
#define PLOT_GREEN "#9fcf9f"
#define PLOT_RED "#e8a79a"

typedef struct plot_panel {
    double left, top, width, height;
    double x0, x1, y0, y1;                 /* the range shown */
    const char *title, *x_label, *y_label; /* null: none */
    bool no_x_numbers;
} plot_panel_t;

plot_t *plot_new(int width, int height, const char *title);
/* Frame, three numbers an axis, labels. Draw it last, so that it lies above the bars. */
void plot_axes(plot_t *plot, const plot_panel_t *panel);
/* `count` bars of equal width over the panel's range of x, from `base` (null: y0) to top. */
void plot_bars(plot_t *plot, const plot_panel_t *panel, const double *base, const double *top, int count,
               const char *colour);
/* One bar from x0 to x1. */
void plot_bar(plot_t *plot, const plot_panel_t *panel, double x0, double x1, double y, const char *colour);
/* y[0..count) at the middles of `count` equal intervals of the range of x, joined. */
void plot_curve(plot_t *plot, const plot_panel_t *panel, const double *y, int count, const char *colour,
                bool dashed);
void plot_level(plot_t *plot, const plot_panel_t *panel, double y, const char *colour);
/* Words at a place of the picture; anchor: "start", "middle" or "end". */
void plot_words(plot_t *plot, double x, double y, const char *anchor, const char *words);
/* A coloured square with words to its right. */
void plot_key(plot_t *plot, double x, double y, const char *colour, const char *words);
/* The document; the caller frees it. Destroys the plot and nulls the pointer. */
char *plot_finish(plot_t **plot);

#endif
