#include "client/report/page_parts.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "draw/markup.h"

#define SPACE "\xc2\xa0" /* no line ends here */

/* ---- words and numbers ---- */

/* "3 min 20 s": two units, the second left out where there is none of it. */
static void print_two(char text[PAGE_NUMBER_SIZE], double t, double unit, const char *name, double part,
                      const char *part_name)
{
    const double whole = floor(t / unit), rest = floor((t - unit * whole) / part);
    if (rest > 0)
        snprintf(text, PAGE_NUMBER_SIZE, "%.0f" SPACE "%s" SPACE "%.0f" SPACE "%s", whole, name, rest, part_name);
    else
        snprintf(text, PAGE_NUMBER_SIZE, "%.0f" SPACE "%s", whole, name);
}

static void print_seconds(char text[PAGE_NUMBER_SIZE], double t)
{
    if (t >= 59.95 && t < 3600)
        print_two(text, fmax(t, 60), 60, "min", 1, "s");
    else if (t >= 3600 && t < 2 * 86400)
        print_two(text, t, 3600, "h", 60, "min");
    else if (t >= 2 * 86400)
        snprintf(text, PAGE_NUMBER_SIZE, "%.3g" SPACE "%s", t < 3e7 ? t / 86400 : t / 31557600,
                 t < 3e7 ? "days" : "years");
    else if (t > 0 && t < 1)
        snprintf(text, PAGE_NUMBER_SIZE, "%.3g" SPACE "%s", t < 1e-3 ? 1e6 * t : 1e3 * t,
                 t < 1e-3 ? "\xc2\xb5s" : "ms");
    else
        snprintf(text, PAGE_NUMBER_SIZE, "%.3g" SPACE "s", t);
}

/* Whole numbers below a million with their thousands apart. */
static void print_count(char text[PAGE_NUMBER_SIZE], double n)
{
    if (!(n >= 0) || n != floor(n) || n >= 1e15)
        snprintf(text, PAGE_NUMBER_SIZE, "%.4g", n);
    else if (n >= 1e9)
        snprintf(text, PAGE_NUMBER_SIZE, "%.3g" SPACE "G", n / 1e9);
    else if (n >= 1e6)
        snprintf(text, PAGE_NUMBER_SIZE, "%.3g" SPACE "M", n / 1e6);
    else if (n >= 1e4)
        snprintf(text, PAGE_NUMBER_SIZE, "%.0f" SPACE "%03.0f", floor(n / 1e3), fmod(n, 1e3));
    else
        snprintf(text, PAGE_NUMBER_SIZE, "%.0f", n);
}

const char *page_number(char text[PAGE_NUMBER_SIZE], page_kind_t kind, double value)
{
    if (!isfinite(value))
        snprintf(text, PAGE_NUMBER_SIZE, "\xe2\x80\x93");
    else if (kind == PAGE_PERCENT)
        snprintf(text, PAGE_NUMBER_SIZE,
                 fabs(value) >= 1 && fabs(value) < 1e4 ? "%.0f" SPACE "%%" : "%.3g" SPACE "%%", 100 * value);
    else if (kind == PAGE_SECONDS)
        print_seconds(text, value);
    else if (kind == PAGE_COUNT)
        print_count(text, value);
    else
        snprintf(text, PAGE_NUMBER_SIZE, "%.4g", value);
    return text;
}

void page_put(page_t *page, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vfprintf(page->out, format, list);
    va_end(list);
}

void page_say(page_t *page, const char *text)
{
    if (text)
        markup_escape_some(page->out, text, REPORT_MAX_TEXT);
}

void page_say_number(page_t *page, page_kind_t kind, double value)
{
    char text[PAGE_NUMBER_SIZE];
    page_say(page, page_number(text, kind, value));
}

/* As many digits as two of the error have. */
void page_say_measured(page_t *page, double value, double error)
{
    if (!isfinite(value) || !(error > 0 && error < 1e3)) {
        page_say_number(page, PAGE_PERCENT, value);
        return;
    }
    const int digits = (int)fmin(fmax(1 - floor(log10(100 * error)), 0), 6);
    char text[PAGE_NUMBER_SIZE];
    if (fabs(value) < 1e3)
        snprintf(text, sizeof text, "%.*f" SPACE "\xc2\xb1" SPACE "%.*f" SPACE "%%", digits, 100 * value, digits,
                 100 * error);
    else
        page_number(text, PAGE_PERCENT, value);
    page_say(page, text);
}

/* ---- sections ---- */

void page_section(page_t *page, const char *id, const char *width, const char *title)
{
    page_put(page, "<section id=\"%s\" class=\"%s\" aria-labelledby=\"%s-name\">\n<h2 id=\"%s-name\">", id, width,
             id, id);
    page_say(page, title);
    page_put(page, "</h2>\n");
}

void page_section_end(page_t *page)
{
    page_put(page, "</section>\n");
}

void page_plot(page_t *page, svg_t **svg, const char *when)
{
    char *text = svg_finish(svg);
    page_put(page, "<div class=\"plot %s\">\n%s</div>\n", when, text);
    free(text);
}

/* ---- tables ---- */

void page_table(page_t *page, const char *caption, const page_column_t *columns, size_t count, bool folded)
{
    if (folded) {
        page_put(page, "<details><summary>");
        page_say(page, caption);
        page_put(page, "</summary>\n");
    }
    page_put(page, "<div class=\"scroll\" role=\"region\" tabindex=\"0\" aria-label=\"");
    page_say(page, caption);
    page_put(page, "\"><table>\n<caption>");
    page_say(page, caption);
    page_put(page, "</caption>\n<thead><tr>");
    for (size_t i = 0; i < count; i++) {
        page_put(page, "<th scope=\"col\"%s>", columns[i].words ? " class=\"words\"" : "");
        page_say(page, columns[i].name);
        page_put(page, "</th>");
    }
    page_put(page, "</tr></thead>\n<tbody>\n");
}

void page_table_end(page_t *page, bool folded)
{
    page_put(page, "</tbody></table></div>\n%s", folded ? "</details>\n" : "");
}

void page_row(page_t *page)
{
    page_put(page, "<tr>");
}

void page_row_end(page_t *page)
{
    page_put(page, "</tr>\n");
}

void page_cell_text(page_t *page, const char *text)
{
    page_put(page, "<td class=\"words\">");
    page_say(page, text ? text : "\xe2\x80\x93");
    page_put(page, "</td>");
}

void page_cell_head(page_t *page, const char *text)
{
    page_put(page, "<th scope=\"row\" class=\"words\">");
    page_say(page, text ? text : "\xe2\x80\x93");
    page_put(page, "</th>");
}

void page_cell_number(page_t *page, page_kind_t kind, double value)
{
    page_put(page, "<td>");
    page_say_number(page, kind, value);
    page_put(page, "</td>");
}

void page_cell_measured(page_t *page, double value, double error)
{
    page_put(page, "<td>");
    page_say_measured(page, value, error);
    page_put(page, "</td>");
}
