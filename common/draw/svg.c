#include "draw/svg.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "draw/markup.h"

struct svg {
    FILE *out;
    char *text;
    size_t size;
    const char *ink, *muted, *grid, *ground;
};

static void put_title(svg_t *svg, const char *words)
{
    if (!words[0])
        return;
    fputs("<title>", svg->out);
    markup_escape(svg->out, words);
    fputs("</title>", svg->out);
}

static svg_t *svg_open(const char *ink, const char *muted, const char *grid, const char *ground)
{
    svg_t *svg = calloc(1, sizeof *svg);
    if (!svg || !(svg->out = open_memstream(&svg->text, &svg->size)))
        abort();
    svg->ink = ink;
    svg->muted = muted;
    svg->grid = grid;
    svg->ground = ground;
    return svg;
}

static void put_head(svg_t *svg, const char *id, const char *title, const char *description)
{
    fprintf(svg->out,
            "role=\"img\" aria-labelledby=\"%stitle %sdesc\" font-family=\"sans-serif\" font-size=\"11\" "
            "fill=\"%s\">\n<title id=\"%stitle\">",
            id, id, svg->ink, id);
    markup_escape(svg->out, title);
    fprintf(svg->out, "</title>\n<desc id=\"%sdesc\">", id);
    markup_escape(svg->out, description);
    fputs("</desc>\n", svg->out);
}

svg_t *svg_new(int width, int height, const char *title, const char *description)
{
    svg_t *svg = svg_open("#202020", "#202020", "#e4e4e4", "#ffffff");
    fprintf(svg->out, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\" ",
            width, height, width, height);
    put_head(svg, "", title, description);
    fprintf(svg->out, "<rect width=\"%d\" height=\"%d\" fill=\"#ffffff\"/>\n", width, height);
    svg_text(svg, width / 2., 22, "middle", 15, title);
    return svg;
}

svg_t *svg_new_embedded(int width, int height, const char *id, const char *title, const char *description)
{
    char ids[64];
    svg_t *svg = svg_open("var(--ink)", "var(--muted)", "var(--grid)", "var(--surface)");
    fprintf(svg->out, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" ", width, height);
    snprintf(ids, sizeof ids, "%s-", id);
    put_head(svg, ids, title, description);
    return svg;
}

/* ---- axes ---- */

static double part(double value, double low, double high, bool linear)
{
    const double t = linear ? (value - low) / (high - low) : log(value / low) / log(high / low);
    return fmin(1, fmax(0, t));
}

double svg_place_x(const svg_panel_t *p, double x)
{
    return p->left + p->width * part(x, p->x0, p->x1, p->linear_x);
}

double svg_place_y(const svg_panel_t *p, double y)
{
    return p->top + p->height * (1 - part(y, p->y0, p->y1, p->linear_y));
}

/* Whether there is a place for a value. */
static bool can_place(double value, bool linear)
{
    return isfinite(value) && (linear || value > 0);
}

void svg_frame(svg_t *svg, const svg_panel_t *p)
{
    fprintf(svg->out, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"none\" stroke=\"%s\"/>\n",
            p->left, p->top, p->width, p->height, svg->muted);
}

void svg_tick_x(svg_t *svg, const svg_panel_t *p, double x, const char *label)
{
    fprintf(svg->out, "<path d=\"M%.1f %.1fv%.1f\" stroke=\"%s\"/>\n", svg_place_x(p, x), p->top, p->height,
            svg->grid);
    svg_text_in(svg, svg_place_x(p, x), p->top + p->height + 13, "middle", 10, svg->muted, label);
}

void svg_tick_y(svg_t *svg, const svg_panel_t *p, double y, const char *label)
{
    fprintf(svg->out, "<path d=\"M%.1f %.1fh%.1f\" stroke=\"%s\"/>\n", p->left, svg_place_y(p, y), p->width,
            svg->grid);
    svg_text_in(svg, p->left - 4, svg_place_y(p, y) + 3.5, "end", 10, svg->muted, label);
}

void svg_axis_names(svg_t *svg, const svg_panel_t *p, const char *x, const char *y)
{
    svg_text_in(svg, p->left + p->width / 2, p->top + p->height + 28, "middle", 11, svg->muted, x);
    svg_text_in(svg, p->left, p->top - 7, "start", 11, svg->muted, y);
}

/* Powers of ten; where the range holds fewer than two of them, 2 and 5 times them too. */
static void ticks_logarithmic(svg_t *svg, const svg_panel_t *p, double low, double high,
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

/* Multiples of 1, 2 or 5 times a power of ten, five at most but one. */
static void ticks_linear(svg_t *svg, const svg_panel_t *p, double low, double high,
                         void (*tick)(svg_t *, const svg_panel_t *, double, const char *))
{
    const double rough = (high - low) / 5, power = pow(10, floor(log10(rough))), f = rough / power;
    const double step = power * (f <= 1 ? 1 : f <= 2 ? 2 : f <= 5 ? 5 : 10);
    const double first = ceil(low / step - 1e-9);
    for (int i = 0; i < 8 && (first + i) * step <= high + 1e-9 * step; i++) {
        char label[32];
        snprintf(label, sizeof label, "%g", (first + i) * step);
        tick(svg, p, (first + i) * step, label);
    }
}

static void ticks(svg_t *svg, const svg_panel_t *p, bool linear, double low, double high,
                  void (*tick)(svg_t *, const svg_panel_t *, double, const char *))
{
    (linear ? ticks_linear : ticks_logarithmic)(svg, p, low, high, tick);
}

void svg_grid(svg_t *svg, const svg_panel_t *p, const char *title)
{
    if (p->y1 > p->y0)
        ticks(svg, p, p->linear_y, p->y0, p->y1, svg_tick_y);
    else
        ticks(svg, p, p->linear_x, p->x0, p->x1, svg_tick_x);
    svg_frame(svg, p);
    if (title[0])
        svg_text(svg, p->left + p->width / 2, p->top - 6, "middle", 12, title);
}

/* ---- in a panel ---- */

void svg_band(svg_t *svg, const svg_panel_t *p, const double *x, const double *low, const double *high,
              size_t count, const svg_style_t *style)
{
    fprintf(svg->out, "<polygon fill=\"%s\" fill-opacity=\"0.13\" points=\"", style->colour);
    for (size_t i = 0; i < count; i++)
        if (high[i] > 0)
            fprintf(svg->out, "%.1f,%.1f ", svg_place_x(p, x[i]), svg_place_y(p, high[i]));
    for (size_t i = count; i-- > 0;)
        if (high[i] > 0)
            fprintf(svg->out, "%.1f,%.1f ", svg_place_x(p, x[i]), svg_place_y(p, fmax(low[i], p->y0)));
    fputs("\"/>\n", svg->out);
}

void svg_area(svg_t *svg, const svg_panel_t *p, const double *x, const double *y, size_t count,
              const svg_style_t *style)
{
    fprintf(svg->out, "<polygon fill=\"%s\" fill-opacity=\"0.16\" points=\"", style->colour);
    for (size_t i = 0; i < count; i++)
        if (can_place(x[i], p->linear_x) && can_place(y[i], p->linear_y))
            fprintf(svg->out, "%.1f,%.1f ", svg_place_x(p, x[i]), svg_place_y(p, y[i]));
    fputs("\"/>\n", svg->out);
}

static void dot(svg_t *svg, double x, double y, const svg_style_t *style)
{
    if (style->shape < 0)
        return;
    if (style->shape == 0)
        fprintf(svg->out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.8\" fill=\"%s\"/>", x, y, style->colour);
    else if (style->shape == 1)
        fprintf(svg->out, "<rect x=\"%.1f\" y=\"%.1f\" width=\"5\" height=\"5\" fill=\"%s\"/>", x - 2.5, y - 2.5,
                style->colour);
    else
        fprintf(svg->out, "<path d=\"M%.1f %.1fl3.2 5.6h-6.4z\" fill=\"%s\" stroke=\"%s\" stroke-width=\"1.3\"/>",
                x, y - 3.4, svg->ground, style->colour);
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
        if (can_place(x[i], p->linear_x) && can_place(y[i], p->linear_y))
            fprintf(svg->out, "%.1f,%.1f ", svg_place_x(p, x[i]), svg_place_y(p, y[i]));
    fputs("\"/>", svg->out);
    for (size_t i = 0; i < count && style->shape >= 0; i++)
        if (can_place(x[i], p->linear_x) && can_place(y[i], p->linear_y))
            dot(svg, svg_place_x(p, x[i]), svg_place_y(p, y[i]), style);
    fputs("</g>\n", svg->out);
}

void svg_dot(svg_t *svg, const svg_panel_t *p, double x, double y, const svg_style_t *style, const char *title)
{
    if (!can_place(x, p->linear_x) || !can_place(y, p->linear_y))
        return;
    fputs("<g>", svg->out);
    put_title(svg, title);
    dot(svg, svg_place_x(p, x), svg_place_y(p, y), style);
    fputs("</g>\n", svg->out);
}

void svg_whisker(svg_t *svg, const svg_panel_t *p, double x, double y, double low, double high,
                 const svg_style_t *style, const char *title)
{
    if (!can_place(x, p->linear_x) || !can_place(y, p->linear_y))
        return;
    if (can_place(high, p->linear_y) && isfinite(low))
        fprintf(svg->out, "<path d=\"M%.1f %.1fV%.1f\" stroke=\"%s\" stroke-width=\"1.3\"/>", svg_place_x(p, x),
                svg_place_y(p, p->linear_y ? low : fmax(low, p->y0)), svg_place_y(p, high), style->colour);
    svg_dot(svg, p, x, y, style, title);
}

void svg_level(svg_t *svg, const svg_panel_t *p, double y, const svg_style_t *style)
{
    if (!can_place(y, p->linear_y))
        return;
    fprintf(svg->out, "<path d=\"M%.1f %.1fh%.1f\" stroke=\"%s\" stroke-width=\"1\"", p->left, svg_place_y(p, y),
            p->width, style->colour);
    if (style->dash[0])
        fprintf(svg->out, " stroke-dasharray=\"%s\"", style->dash);
    fputs("/>\n", svg->out);
}

void svg_row(svg_t *svg, const svg_panel_t *p, double y, double x, double low, double high, double other,
             const svg_style_t *style, const char *title)
{
    fputs("<g>", svg->out);
    put_title(svg, title);
    if (high > 0)
        fprintf(svg->out, "<path d=\"M%.1f %.1fH%.1f\" stroke=\"%s\" stroke-width=\"1.3\"/>",
                svg_place_x(p, fmax(low, p->x0)), y, svg_place_x(p, high), style->colour);
    if (other > 0)
        fprintf(svg->out, "<path d=\"M%.1f %.1fv7\" stroke=\"%s\" stroke-width=\"1.3\"/>", svg_place_x(p, other),
                y - 3.5, style->colour);
    if (x > 0)
        dot(svg, svg_place_x(p, x), y, style);
    fputs("</g>\n", svg->out);
}

/* ---- in pixels ---- */

void svg_rect(svg_t *svg, double left, double top, double width, double height, const char *colour, double opacity,
              const char *title)
{
    if (!isfinite(left + top + width + height + opacity))
        return;
    fprintf(svg->out,
            "<rect x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\" fill=\"%s\" fill-opacity=\"%.3f\">", left,
            top, fmax(0, width), fmax(0, height), colour, opacity);
    put_title(svg, title);
    fputs("</rect>\n", svg->out);
}

void svg_text_in(svg_t *svg, double x, double y, const char *anchor, double size, const char *colour,
                 const char *words)
{
    fprintf(svg->out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\" font-size=\"%g\"", x, y, anchor, size);
    if (colour != svg->ink)
        fprintf(svg->out, " fill=\"%s\"", colour);
    fputc('>', svg->out);
    markup_escape(svg->out, words);
    fputs("</text>\n", svg->out);
}

void svg_text(svg_t *svg, double x, double y, const char *anchor, double size, const char *words)
{
    svg_text_in(svg, x, y, anchor, size, svg->ink, words);
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
