/* page.h: a report (report.h) as one HTML page to look at: picture, plots, tables, nothing from elsewhere.
 *
 *     const page_picture_t picture = {png, png_size, "room.png"};
 *     char *html;
 *     size_t size;
 *     TRY(page_write(&html, &size, report, &picture, fault));
 *
 * The page holds its picture and style, runs no scripts and asks the network for nothing (its content policy says
 * so); it is well-formed XML too. Plots are SVG with a title and a description, and the tables below them hold the
 * same numbers. A part of the report that is missing leaves its section out, or the section says so.
 */
#ifndef CLIENT_REPORT_PAGE_H
#define CLIENT_REPORT_PAGE_H

#include <stddef.h>
#include <stdint.h>

#include "client/report/report.h"

enum { PAGE_MAX_PICTURE = 24 << 20 }; /* octets of a PNG file that a page takes in */

typedef struct page_picture {
    const uint8_t *png; /* a PNG file; null: no picture */
    size_t size;
} page_picture_t;

/* *html is the caller's to free(); it ends with a zero byte. A picture that is too large is left out, and the page
 * says so. Faults: FAULT_FORMAT if the picture is no PNG, FAULT_MEMORY. */
fault_code_t page_write(char **html, size_t *size, const report_t *report, const page_picture_t *picture,
                        fault_t *fault);

#endif
