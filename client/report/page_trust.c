/* page_trust.c: how sure the brightness of parts of the image is, and how far an image is off whose law is another.
 */
#include <math.h>

#include "client/report/page_parts.h"

enum { WIDTH = 520, MOST_SIDE = 16 /* of a picture; more regions are in the table alone */ };

/* ---- regions ---- */

/* Half of the interval, of the region's own brightness; NaN: not known. */
static double region_doubt(const report_region_t *region)
{
    const double half = 0.5 * (region->high - region->low);
    const double doubt = region->luminance > 0 && half >= 0 ? half / region->luminance : (double)NAN;
    return isfinite(doubt) ? doubt : (double)NAN;
}

/* As the image lies: a darker cell is less sure. */
static void put_regions_plot(page_t *page, double most)
{
    const report_t *report = page->report;
    const double width = report_number(report, "", "width"), height = report_number(report, "", "height"),
                 aspect = width > 0 && height > 0 ? fmin(fmax(height / width, 0.25), 1) : 0.75,
                 cell_x = WIDTH / (double)report->region_columns, cell_y = WIDTH * aspect / report->region_rows;
    svg_t *svg =
        svg_new_embedded(WIDTH, (int)(WIDTH * aspect), "regions-plot", "How sure the image's regions are",
                         "The image cut into regions, each with half the 95 % interval of its brightness in "
                         "per cent, darker where that is more; the table below has the numbers.");
    for (uint32_t row = 0; row < report->region_rows; row++)
        for (uint32_t column = 0; column < report->region_columns; column++) {
            const report_region_t *region = &report->regions[row * report->region_columns + column];
            const double doubt = region_doubt(region);
            char number[PAGE_NUMBER_SIZE], title[128];
            page_number(number, PAGE_PERCENT, doubt);
            snprintf(title, sizeof title, "row %u, column %u: %.4g (%.4g to %.4g)", row + 1, column + 1,
                     region->luminance, region->low, region->high);
            svg_rect(svg, cell_x * column + 1, cell_y * row + 1, cell_x - 2, cell_y - 2, "var(--c2)",
                     doubt >= 0 ? 0.05 + 0.6 * doubt / most : 0, title);
            if (cell_x > 60)
                svg_text(svg, cell_x * (column + 0.5), cell_y * (row + 0.5) + 4, "middle", 12, number);
        }
    page_plot(page, &svg, "");
}

static void put_regions_table(page_t *page)
{
    static const page_column_t columns[] = {
        {"Row", false}, {"Column", false}, {"Luminance", false}, {"Not below", false}, {"Not above", false}};
    const report_t *report = page->report;
    page_table(page, "Luminance by region", columns, sizeof columns / sizeof columns[0], true);
    for (uint32_t i = 0; i < report->region_columns * report->region_rows; i++) {
        page_row(page);
        page_cell_number(page, PAGE_COUNT, i / report->region_columns + 1);
        page_cell_number(page, PAGE_COUNT, i % report->region_columns + 1);
        page_cell_number(page, PAGE_NUMBER, report->regions[i].luminance);
        page_cell_number(page, PAGE_NUMBER, report->regions[i].low);
        page_cell_number(page, PAGE_NUMBER, report->regions[i].high);
        page_row_end(page);
    }
    page_table_end(page, true);
}

void page_regions(page_t *page)
{
    const report_t *report = page->report;
    double most = 0;
    for (uint32_t i = 0; i < report->region_columns * report->region_rows; i++)
        most = fmax(most, region_doubt(&report->regions[i])); /* fmax passes over NaN */
    if (!(most > 0))
        return; /* none is known yet */
    page_section(page, "regions", "half", "How sure the image's regions are");
    page_put(page, "<p>Half the 95\xc2\xa0%% interval of each region's mean brightness, relative to it.</p>\n");
    if (report->region_columns <= MOST_SIDE && report->region_rows <= MOST_SIDE)
        put_regions_plot(page, most);
    put_regions_table(page);
    page_section_end(page);
}

/* ---- bias ---- */

void page_bias(page_t *page)
{
    static const page_column_t columns[] = {
        {"Length", false}, {"Failed proposals", false}, {"Total variation", false}, {"Largest block", false}};
    const report_t *report = page->report;
    uint32_t known = 0;
    for (uint32_t i = 0; i < report->length_count; i++)
        known += isfinite(report->lengths[i].bias_failures);
    if (known == 0)
        return;
    page_section(page, "bias", "half", "Bias by path length");
    page_put(page,
             "<p>How far the light of each length is from what it should be, over blocks of the image: half the "
             "sum of their differences, and the largest. Upper estimates, noise adds to them.</p>\n");
    page_table(page, "Bias of failures that are left out", columns, sizeof columns / sizeof columns[0], false);
    for (uint32_t i = 0; i < report->length_count; i++) {
        const report_length_t *k = &report->lengths[i];
        if (!isfinite(k->bias_failures))
            continue;
        page_row(page);
        page_cell_number(page, PAGE_COUNT, k->length);
        page_cell_number(page, PAGE_PERCENT, k->bias_failures);
        page_cell_number(page, PAGE_PERCENT, k->bias_variation);
        page_cell_number(page, PAGE_PERCENT, k->bias_block);
        page_row_end(page);
    }
    page_table_end(page, false);
    page_section_end(page);
}
