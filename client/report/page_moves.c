/* page_moves.c: two tables of shades over path length: how often moves are accepted, and what part of the light
 * each technique brings. */
#include <math.h>
#include <string.h>

#include "client/report/page_parts.h"

enum { WIDTH = 520, LEFT = 82, TOP = 26, ROW = 25, WIDEST = 60, MOST_ROWS = 128 };

/* A table of shades: columns are path lengths. */
typedef struct heat {
    svg_t *svg;
    const char *colour;
    uint32_t rows;
    double cell; /* width */
} heat_t;

static void heat_open(heat_t *heat, uint32_t rows, uint32_t columns)
{
    heat->rows = rows;
    heat->cell = fmin(WIDEST, (WIDTH - LEFT - 4.) / fmax(1, columns));
}

static int heat_height(uint32_t rows)
{
    return TOP + ROW * (int)rows + 24;
}

static void heat_name(const heat_t *heat, uint32_t row, const char *name)
{
    svg_text(heat->svg, LEFT - 8, TOP + ROW * row + 0.5 * ROW + 4, "end", 12, name);
}

/* A column's number, where there is room for it. */
static void heat_number(const heat_t *heat, uint32_t column, const char *text)
{
    const uint32_t step = (uint32_t)ceil(20 / heat->cell);
    if (column % step == 0)
        svg_text_in(heat->svg, LEFT + heat->cell * (column + 0.5), TOP - 8, "middle", 11, "var(--muted)", text);
}

static void heat_put(const heat_t *heat, uint32_t row, uint32_t column, double share, const char *title)
{
    if (!(share >= 0))
        return;
    const double x = LEFT + heat->cell * column, y = TOP + (double)ROW * row;
    svg_rect(heat->svg, x, y, fmax(0.5, heat->cell - 2), ROW - 2, heat->colour, 0.05 + 0.6 * fmin(1, share), title);
    if (heat->cell < 24)
        return;
    char text[16];
    snprintf(text, sizeof text, share > 0 && share < 0.005 ? "<1" : "%.0f", 100 * fmin(1, share));
    svg_text(heat->svg, x + 0.5 * heat->cell - 1, y + 0.5 * ROW + 3, "middle", 11, text);
}

static void heat_close(const heat_t *heat)
{
    svg_text_in(heat->svg, LEFT, TOP + ROW * (double)heat->rows + 15, "start", 11, "var(--muted)",
                "per cent, by path length");
}

/* ---- moves ---- */

typedef struct move_list {
    const char *names[REPORT_MAX_MOVES];
    uint32_t count;
} move_list_t;

static void list_moves(move_list_t *list, const report_length_t *length)
{
    for (uint32_t i = 0; i < length->move_count; i++) {
        uint32_t j = 0;
        while (j < list->count && strcmp(list->names[j], length->moves[i].name) != 0)
            j++;
        if (j == list->count && j < REPORT_MAX_MOVES)
            list->names[list->count++] = length->moves[i].name;
    }
}

static void moves_column(const heat_t *heat, const move_list_t *list, const report_length_t *length,
                         uint32_t column)
{
    char name[32];
    snprintf(name, sizeof name, length->length > 0 ? "%.0f" : "all", length->length);
    heat_number(heat, column, name);
    for (uint32_t row = 0; row < list->count; row++)
        for (uint32_t i = 0; i < length->move_count; i++) {
            const report_move_t *move = &length->moves[i];
            char title[200], share[PAGE_NUMBER_SIZE], count[PAGE_NUMBER_SIZE];
            if (strcmp(move->name, list->names[row]) != 0)
                continue;
            snprintf(title, sizeof title, "%.40s, length %s: %s of %s accepted", move->name, name,
                     page_number(share, PAGE_PERCENT, move->acceptance),
                     page_number(count, PAGE_COUNT, move->proposed));
            heat_put(heat, row, column, move->acceptance, title);
            break;
        }
}

static void put_moves_plot(page_t *page, const move_list_t *list)
{
    const report_t *report = page->report;
    heat_t heat = {.colour = "var(--c1)"};
    const bool all = report->all.move_count > 0;
    heat_open(&heat, list->count, all + (all ? 0 : report->length_count));
    heat.svg = svg_new_embedded(WIDTH, heat_height(list->count), "moves-plot", "Acceptance by move and path length",
                                "A row for each move, a column for each path length, a darker cell where more is "
                                "accepted; the table below has the numbers.");
    for (uint32_t i = 0; i < list->count; i++) {
        char name[24];
        snprintf(name, sizeof name, "%.12s", list->names[i]);
        heat_name(&heat, i, name);
    }
    if (all)
        moves_column(&heat, list, &report->all, 0);
    for (uint32_t i = 0; !all && i < report->length_count; i++)
        moves_column(&heat, list, &report->lengths[i], i);
    heat_close(&heat);
    page_plot(page, &heat.svg, "");
}

static void put_moves_rows(page_t *page, const report_length_t *length)
{
    for (uint32_t i = 0; i < length->move_count; i++) {
        page_row(page);
        if (length->length > 0)
            page_cell_number(page, PAGE_COUNT, length->length);
        else
            page_cell_text(page, "all");
        page_cell_text(page, length->moves[i].name);
        page_cell_number(page, PAGE_COUNT, length->moves[i].proposed);
        page_cell_number(page, PAGE_PERCENT, length->moves[i].acceptance);
        page_row_end(page);
    }
}

void page_moves(page_t *page)
{
    static const page_column_t columns[] = {
        {"Length", false}, {"Move", true}, {"Proposed", false}, {"Accepted", false}};
    const report_t *report = page->report;
    move_list_t list = {.count = 0};
    list_moves(&list, &report->all);
    for (uint32_t i = 0; i < report->length_count; i++)
        list_moves(&list, &report->lengths[i]);
    if (list.count == 0)
        return;
    page_section(page, "moves", "half", "Acceptance by move and length");
    page_put(page, "<p>The mean probability that a proposal is accepted.</p>\n");
    put_moves_plot(page, &list);
    page_table(page, "All moves", columns, sizeof columns / sizeof columns[0], true);
    put_moves_rows(page, &report->all);
    for (uint32_t i = 0; i < report->length_count; i++)
        put_moves_rows(page, &report->lengths[i]);
    page_table_end(page, true);
    page_section_end(page);
}

/* ---- techniques ---- */

static double techniques_sum(const report_length_t *length)
{
    double sum = 0;
    for (uint32_t i = 0; i < length->technique_count; i++)
        if (length->techniques[i].value > 0)
            sum += length->techniques[i].value;
    return sum;
}

/* Rows: as many as the largest s that brings anything needs. */
static uint32_t technique_rows(const report_t *report)
{
    double most = -1;
    for (uint32_t i = 0; i < report->length_count; i++)
        for (uint32_t j = 0; j < report->lengths[i].technique_count; j++) {
            const report_technique_t *technique = &report->lengths[i].techniques[j];
            if (technique->value > 0 && technique->s < MOST_ROWS)
                most = fmax(most, technique->s);
        }
    return (uint32_t)(most + 1);
}

static void techniques_column(const heat_t *heat, const report_length_t *length, uint32_t column)
{
    char name[32];
    const double sum = techniques_sum(length);
    snprintf(name, sizeof name, "%.0f", length->length);
    heat_number(heat, column, name);
    for (uint32_t i = 0; i < length->technique_count && sum > 0; i++) {
        const report_technique_t *technique = &length->techniques[i];
        char title[160], share[PAGE_NUMBER_SIZE];
        if (!(technique->s >= 0 && technique->s < heat->rows && technique->s == floor(technique->s)))
            continue;
        snprintf(title, sizeof title, "length %s, s = %.0f, t = %.0f: %s of the light", name, technique->s,
                 length->length + 1 - technique->s, page_number(share, PAGE_PERCENT, technique->value / sum));
        heat_put(heat, (uint32_t)technique->s, column, technique->value / sum, title);
    }
}

static void put_techniques_plot(page_t *page, uint32_t rows)
{
    const report_t *report = page->report;
    heat_t heat = {.colour = "var(--c3)"};
    heat_open(&heat, rows, report->length_count);
    heat.svg =
        svg_new_embedded(WIDTH, heat_height(rows), "techniques-plot", "Shares of techniques by path length",
                         "A row for each number s of vertices made from the light, a column for each path "
                         "length, a darker cell where the technique brings more of the length's light; the table "
                         "below has the numbers.");
    for (uint32_t s = 0; s < rows; s++) {
        char name[24];
        snprintf(name, sizeof name, "s = %u", s);
        heat_name(&heat, s, name);
    }
    for (uint32_t i = 0; i < report->length_count; i++)
        techniques_column(&heat, &report->lengths[i], i);
    heat_close(&heat);
    page_plot(page, &heat.svg, "");
}

static void put_techniques_table(page_t *page)
{
    static const page_column_t columns[] = {
        {"Length", false}, {"s, from the light", false}, {"t, from the camera", false},
        {"b", false},      {"Standard error", false},    {"Share", false}};
    const report_t *report = page->report;
    page_table(page, "All techniques", columns, sizeof columns / sizeof columns[0], true);
    for (uint32_t i = 0; i < report->length_count; i++) {
        const report_length_t *k = &report->lengths[i];
        const double sum = techniques_sum(k);
        for (uint32_t j = 0; j < k->technique_count; j++) {
            if (!(k->techniques[j].value > 0))
                continue; /* many of long paths bring nothing */
            page_row(page);
            page_cell_number(page, PAGE_COUNT, k->length);
            page_cell_number(page, PAGE_COUNT, k->techniques[j].s);
            page_cell_number(page, PAGE_COUNT, k->length + 1 - k->techniques[j].s);
            page_cell_number(page, PAGE_NUMBER, k->techniques[j].value);
            page_cell_number(page, PAGE_NUMBER, k->techniques[j].standard_error);
            page_cell_number(page, PAGE_PERCENT, k->techniques[j].value / sum);
            page_row_end(page);
        }
    }
    page_table_end(page, true);
}

void page_techniques(page_t *page)
{
    const uint32_t rows = technique_rows(page->report);
    if (rows == 0)
        return;
    page_section(page, "techniques", "half", "Techniques by length");
    page_put(page,
             "<p>What part of a length's light comes by paths of which s vertices were made from the light.</p>\n");
    put_techniques_plot(page, rows);
    put_techniques_table(page);
    page_section_end(page);
}
