#include "client/lab/plot.h"

#include <stdio.h>
#include <stdlib.h>

#include "math/vec.h"

struct plot {
    FILE *out;
    char *text;
    size_t size;
};

plot_t *plot_new(int width, int height, const char *title)
{
    plot_t *plot = calloc(1, sizeof *plot);
    if (!plot || !(plot->out = open_memstream(&plot->text, &plot->size)))
        abort();
    fprintf(plot->out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\" "
            "font-family=\"sans-serif\" font-size=\"11\" fill=\"%s\">\n"
            "<title>%s</title>\n<rect width=\"%d\" height=\"%d\" fill=\"#ffffff\"/>\n"
            "<text x=\"%d\" y=\"24\" font-size=\"15\" text-anchor=\"middle\">%s</text>\n",
            width, height, width, height, PLOT_BLACK, title, width, height, width / 2, title);
    return plot;
}

static double clamp(double t)
{
    return t > 0 ? math_min(t, 1) : 0;
}

static double place_x(const plot_panel_t *p, double x)
{
    return p->left + p->width * clamp((x - p->x0) / (p->x1 - p->x0));
}

static double place_y(const plot_panel_t *p, double y)
{
    return p->top + p->height * (1 - clamp((y - p->y0) / (p->y1 - p->y0)));
}

static void axis_numbers(plot_t *plot, const plot_panel_t *p)
{
    for (int i = 0; i <= 2; i++) {
        const double x = p->x0 + (p->x1 - p->x0) * i / 2, y = p->y0 + (p->y1 - p->y0) * i / 2;
        if (!p->no_x_numbers)
            fprintf(plot->out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\" font-size=\"10\">%g</text>\n",
                    place_x(p, x), p->top + p->height + 13, x);
        fprintf(plot->out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\" font-size=\"10\">%g</text>\n",
                p->left - 5, place_y(p, y) + 3.5, y);
        fprintf(plot->out, "<path d=\"M%.1f %.1fh-4\" stroke=\"%s\"/>\n", p->left, place_y(p, y), PLOT_BLACK);
    }
}

void plot_axes(plot_t *plot, const plot_panel_t *p)
{
    fprintf(plot->out, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"none\" stroke=\"%s\"/>\n",
            p->left, p->top, p->width, p->height, PLOT_BLACK);
    axis_numbers(plot, p);
    if (p->title)
        plot_words(plot, p->left + p->width / 2, p->top - 6, "middle", p->title);
    if (p->x_label)
        plot_words(plot, p->left + p->width / 2, p->top + p->height + 27, "middle", p->x_label);
    if (p->y_label)
        fprintf(plot->out,
                "<text transform=\"translate(%.1f %.1f) rotate(-90)\" text-anchor=\"middle\">%s</text>\n",
                p->left - 34, p->top + p->height / 2, p->y_label);
}

static void box(plot_t *plot, const plot_panel_t *p, double x0, double x1, double y0, double y1, const char *colour)
{
    const double left = place_x(p, x0), top = place_y(p, y1);
    fprintf(
        plot->out,
        "<rect x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\" fill=\"%s\" shape-rendering=\"crispEdges\"/>\n",
        left, top, place_x(p, x1) - left, math_max(place_y(p, y0) - top, 0), colour);
}

void plot_bars(plot_t *plot, const plot_panel_t *p, const double *base, const double *top, int count,
               const char *colour)
{
    const double width = (p->x1 - p->x0) / count;
    for (int i = 0; i < count; i++)
        box(plot, p, p->x0 + i * width, p->x0 + (i + 1) * width, base ? base[i] : p->y0, top[i], colour);
}

void plot_bar(plot_t *plot, const plot_panel_t *p, double x0, double x1, double y, const char *colour)
{
    box(plot, p, x0, x1, p->y0, y, colour);
}

void plot_curve(plot_t *plot, const plot_panel_t *p, const double *y, int count, const char *colour, bool dashed)
{
    fprintf(plot->out, "<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"1.6\"%s points=\"", colour,
            dashed ? " stroke-dasharray=\"5 3\"" : "");
    for (int i = 0; i < count; i++)
        fprintf(plot->out, "%.2f,%.2f ", place_x(p, p->x0 + (p->x1 - p->x0) * (i + 0.5) / count), place_y(p, y[i]));
    fputs("\"/>\n", plot->out);
}

void plot_level(plot_t *plot, const plot_panel_t *p, double y, const char *colour)
{
    fprintf(plot->out,
            "<path d=\"M%.1f %.1fh%.1f\" stroke=\"%s\" stroke-width=\"1.2\" stroke-dasharray=\"5 3\"/>\n", p->left,
            place_y(p, y), p->width, colour);
}

void plot_words(plot_t *plot, double x, double y, const char *anchor, const char *words)
{
    fprintf(plot->out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">%s</text>\n", x, y, anchor, words);
}

void plot_key(plot_t *plot, double x, double y, const char *colour, const char *words)
{
    fprintf(plot->out, "<rect x=\"%.1f\" y=\"%.1f\" width=\"12\" height=\"9\" fill=\"%s\"/>\n", x, y - 9, colour);
    plot_words(plot, x + 17, y, "start", words);
}

char *plot_finish(plot_t **plot)
{
    fputs("</svg>\n", (*plot)->out);
    if (fclose((*plot)->out) != 0)
        abort();
    char *text = (*plot)->text;
    free(*plot);
    *plot = NULL;
    return text;
}
