#include "svg.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define INK "#202020"
#define GRID "#e4e4e4"

struct svg {
    FILE *out;
    char *text;
    size_t size;
};

static void escape(FILE *out, const char *words)
{
    for (const char *c = words; *c; c++)
        switch (*c) {
        case '&':
            fputs("&amp;", out);
            break;
        case '<':
            fputs("&lt;", out);
            break;
        case '>':
            fputs("&gt;", out);
            break;
        case '"':
            fputs("&quot;", out);
            break;
        default:
            fputc((unsigned char)*c < ' ' ? ' ' : *c, out);
        }
}

static void put_title(svg_t *svg, const char *words)
{
    fputs("<title>", svg->out);
    escape(svg->out, words);
    fputs("</title>", svg->out);
}

svg_t *svg_new(int width, int height, const char *title, const char *description)
{
    svg_t *svg = calloc(1, sizeof *svg);
    if (!svg || !(svg->out = open_memstream(&svg->text, &svg->size)))
        abort();
    fprintf(
        svg->out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\" role=\"img\" "
        "aria-labelledby=\"title desc\" font-family=\"sans-serif\" font-size=\"11\" fill=\"%s\">\n"
        "<title id=\"title\">",
        width, height, width, height, INK);
    escape(svg->out, title);
    fputs("</title>\n<desc id=\"desc\">", svg->out);
    escape(svg->out, description);
    fprintf(svg->out, "</desc>\n<rect width=\"%d\" height=\"%d\" fill=\"#ffffff\"/>\n", width, height);
    svg_text(svg, width / 2., 22, "middle", 15, title);
    return svg;
}

/* ---- axes ---- */

static double part(double value, double low, double high)
{
    return fmin(1, fmax(0, log(value / low) / log(high / low)));
}

static double place_x(const svg_panel_t *p, double x)
{
    return p->left + p->width * part(x, p->x0, p->x1);
}

static double place_y(const svg_panel_t *p, double y)
{
    return p->top + p->height * (1 - part(y, p->y0, p->y1));
}

void svg_tick_x(svg_t *svg, const svg_panel_t *p, double x, const char *label)
{
    fprintf(svg->out, "<path d=\"M%.1f %.1fv%.1f\" stroke=\"%s\"/>\n", place_x(p, x), p->top, p->height, GRID);
    svg_text(svg, place_x(p, x), p->top + p->height + 13, "middle", 10, label);
}

static void tick_y(svg_t *svg, const svg_panel_t *p, double y, const char *label)
{
    fprintf(svg->out, "<path d=\"M%.1f %.1fh%.1f\" stroke=\"%s\"/>\n", p->left, place_y(p, y), p->width, GRID);
    svg_text(svg, p->left - 4, place_y(p, y) + 3.5, "end", 10, label);
}

/* Powers of ten; where the range holds fewer than two of them, 2 and 5 times them too. */
static void ticks(svg_t *svg, const svg_panel_t *p, double low, double high,
                  void (*tick)(svg_t *, const svg_panel_t *, double, const char *))
{
    static const double factors[] = {1, 2, 5};
    const double tens = floor(log10(high) + 1e-9) - ceil(log10(low) - 1e-9) + 1;
    for (double e = floor(log10(low)); e <= ceil(log10(high)); e++)
        for (int f = 0; f < (tens < 2 ? 3 : 1); f++) {
            char label[32];
            const double value = factors[f] * pow(10, e);
            snprintf(label, sizeof label, "%g", value);
            if (value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9))
                tick(svg, p, value, label);
        }
}

void svg_grid(svg_t *svg, const svg_panel_t *p, const char *title)
{
    if (p->y1 > p->y0)
        ticks(svg, p, p->y0, p->y1, tick_y);
    else
        ticks(svg, p, p->x0, p->x1, svg_tick_x);
    fprintf(svg->out, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"none\" stroke=\"%s\"/>\n",
            p->left, p->top, p->width, p->height, INK);
    svg_text(svg, p->left + p->width / 2, p->top - 6, "middle", 12, title);
}

/* ---- marks ---- */

void svg_band(svg_t *svg, const svg_panel_t *p, const double *x, const double *low, const double *high,
              size_t count, const svg_style_t *style)
{
    fprintf(svg->out, "<polygon fill=\"%s\" fill-opacity=\"0.13\" points=\"", style->colour);
    for (size_t i = 0; i < count; i++)
        if (high[i] > 0)
            fprintf(svg->out, "%.1f,%.1f ", place_x(p, x[i]), place_y(p, high[i]));
    for (size_t i = count; i-- > 0;)
        if (high[i] > 0)
            fprintf(svg->out, "%.1f,%.1f ", place_x(p, x[i]), place_y(p, fmax(low[i], p->y0)));
    fputs("\"/>\n", svg->out);
}

static void dot(svg_t *svg, double x, double y, const svg_style_t *style)
{
    if (style->shape == 0)
        fprintf(svg->out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.8\" fill=\"%s\"/>", x, y, style->colour);
    else if (style->shape == 1)
        fprintf(svg->out, "<rect x=\"%.1f\" y=\"%.1f\" width=\"5\" height=\"5\" fill=\"%s\"/>", x - 2.5, y - 2.5,
                style->colour);
    else
        fprintf(svg->out,
                "<path d=\"M%.1f %.1fl3.2 5.6h-6.4z\" fill=\"#ffffff\" stroke=\"%s\" stroke-width=\"1.3\"/>", x,
                y - 3.4, style->colour);
}

void svg_line(svg_t *svg, const svg_panel_t *p, const double *x, const double *y, size_t count,
              const svg_style_t *style, const char *title)
{
    fputs("<g>", svg->out);
    put_title(svg, title);
    fprintf(svg->out, "<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"1.6\"", style->colour);
    if (style->dash[0])
        fprintf(svg->out, " stroke-dasharray=\"%s\"", style->dash);
    fputs(" points=\"", svg->out);
    for (size_t i = 0; i < count; i++)
        if (y[i] > 0)
            fprintf(svg->out, "%.1f,%.1f ", place_x(p, x[i]), place_y(p, y[i]));
    fputs("\"/>", svg->out);
    for (size_t i = 0; i < count; i++)
        if (y[i] > 0)
            dot(svg, place_x(p, x[i]), place_y(p, y[i]), style);
    fputs("</g>\n", svg->out);
}

void svg_row(svg_t *svg, const svg_panel_t *p, double y, double x, double low, double high, double other,
             const svg_style_t *style, const char *title)
{
    fputs("<g>", svg->out);
    put_title(svg, title);
    if (high > 0)
        fprintf(svg->out, "<path d=\"M%.1f %.1fH%.1f\" stroke=\"%s\" stroke-width=\"1.3\"/>",
                place_x(p, fmax(low, p->x0)), y, place_x(p, high), style->colour);
    if (other > 0)
        fprintf(svg->out, "<path d=\"M%.1f %.1fv7\" stroke=\"%s\" stroke-width=\"1.3\"/>", place_x(p, other),
                y - 3.5, style->colour);
    if (x > 0)
        dot(svg, place_x(p, x), y, style);
    fputs("</g>\n", svg->out);
}

/* ---- words ---- */

void svg_text(svg_t *svg, double x, double y, const char *anchor, double size, const char *words)
{
    fprintf(svg->out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\" font-size=\"%g\">", x, y, anchor, size);
    escape(svg->out, words);
    fputs("</text>\n", svg->out);
}

void svg_key(svg_t *svg, double x, double y, const svg_style_t *style, const char *words)
{
    fprintf(svg->out, "<path d=\"M%.1f %.1fh24\" stroke=\"%s\" stroke-width=\"1.6\"", x, y - 4, style->colour);
    if (style->dash[0])
        fprintf(svg->out, " stroke-dasharray=\"%s\"", style->dash);
    fputs("/>", svg->out);
    dot(svg, x + 12, y - 4, style);
    svg_text(svg, x + 30, y, "start", 11, words);
}

char *svg_finish(svg_t **svg)
{
    fputs("</svg>\n", (*svg)->out);
    if (fclose((*svg)->out) != 0)
        abort();
    char *text = (*svg)->text;
    free(*svg);
    *svg = NULL;
    return text;
}
