/* page_parts.h: what the sections of a page (page.h) have in common: writing, numbers for people, tables, plots.
 * Everything that comes from the report goes through page_say or a cell, which escape it. */
#ifndef CLIENT_REPORT_PAGE_PARTS_H
#define CLIENT_REPORT_PAGE_PARTS_H

#include <stdbool.h>
#include <stdio.h>

#include "client/report/page.h"
#include "draw/svg.h"

typedef struct page {
    FILE *out;
    const report_t *report;
    const page_picture_t *picture;
} page_t;

/* ---- words and numbers ---- */

typedef enum page_kind {
    PAGE_NUMBER,  /* four digits */
    PAGE_PERCENT, /* of a fraction */
    PAGE_SECONDS, /* "3 min 20 s" */
    PAGE_COUNT    /* whole, or in millions */
} page_kind_t;

enum { PAGE_NUMBER_SIZE = 48 };

/* As text; what is not known is a dash. Returns `text`. */
const char *page_number(char text[PAGE_NUMBER_SIZE], page_kind_t kind, double value);

/* Markup of ours. */
void page_put(page_t *page, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Text from the report, escaped and cut to REPORT_MAX_TEXT; null: nothing. */
void page_say(page_t *page, const char *text);
void page_say_number(page_t *page, page_kind_t kind, double value);
/* A fraction with its standard error, in per cent, "12.34 +- 0.41 %"; without one (NaN) as a number. */
void page_say_measured(page_t *page, double value, double error);

/* ---- what to doubt (page_doubt.c): a sentence each, or nothing ---- */

void page_say_trust(page_t *page);     /* whether the error's estimate is reliable */
void page_warn_left_out(page_t *page); /* what light the image lacks as the job says so: a warning */
void page_say_left_out(page_t *page);  /* and how that was measured */
void page_say_missed(page_t *page);    /* lengths without chains, and what they may bring at most */

/* ---- sections ---- */

/* width: "wide" or "half" of the page where there is room. */
void page_section(page_t *page, const char *id, const char *width, const char *title);
void page_section_end(page_t *page);
/* Takes the plot; `when` is a class: "" or "for-wide", "for-narrow" screens. */
void page_plot(page_t *page, svg_t **svg, const char *when);

/* ---- tables: begin, then rows of cells ---- */

typedef struct page_column {
    const char *name;
    bool words; /* else numbers, to the right */
} page_column_t;

/* folded: behind a line that opens it. */
void page_table(page_t *page, const char *caption, const page_column_t *columns, size_t count, bool folded);
void page_table_end(page_t *page, bool folded);
void page_row(page_t *page);
void page_row_end(page_t *page);
void page_cell_text(page_t *page, const char *text);
void page_cell_head(page_t *page, const char *text); /* the row's name */
void page_cell_number(page_t *page, page_kind_t kind, double value);
void page_cell_measured(page_t *page, double value, double error);

/* ---- the sections, in the page's order ---- */

void page_head(page_t *page);       /* picture and headline (page_head.c) */
void page_error(page_t *page);      /* over time (page_error.c) */
void page_lengths(page_t *page);    /* error, time and light by path length (page_lengths.c) */
void page_light(page_t *page);      /* b_k */
void page_time(page_t *page);       /* where it went (page_time.c) */
void page_groups(page_t *page);     /* groups of chains */
void page_regions(page_t *page);    /* how sure parts of the image are (page_trust.c) */
void page_bias(page_t *page);       /* of failures that are left out */
void page_moves(page_t *page);      /* acceptance (page_moves.c) */
void page_techniques(page_t *page); /* shares */
void page_effects(page_t *page);    /* what was switched off (page_lists.c) */
void page_trouble(page_t *page);    /* stuck chains, rejected paths */
void page_service(page_t *page);    /* what the master adds */
void page_rest(page_t *page);       /* what else the report holds */
void page_job(page_t *page);        /* the canonical job */

/* The style sheet in pieces, null after the last (page_style.c). */
extern const char *const page_style[];

#endif
