/* garland report: a report file as a page to look at, and as tables. */
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "client/commands.h"
#include "client/options.h"
#include "client/remote.h"
#include "client/report/csv.h"
#include "client/report/page.h"
#include "film/image_file.h"
#include "film/png.h"

static const char usage[] =
    "usage: garland report REPORT.json [--image FILE] [-o PAGE.html] [--csv FOLDER]\n"
    "\n"
    "Makes of a report (docs/reports.md), as a job's output.report names it, a page to look at and tables for "
    "other\n"
    "programs. One of -o and --csv is needed.\n"
    "\n"
    "  --image FILE             the image for the page: PNG as it is, OpenEXR or PFM as PNG\n"
    "  -o FILE, --output FILE   one HTML page with the picture and plots, which needs nothing else\n"
    "  --csv FOLDER             history.csv, lengths.csv, moves.csv, techniques.csv, regions.csv,\n"
    "                           effects.csv, into FOLDER (made if missing)\n";

/* A PNG file as it is, any other image as one. */
static fault_code_t read_picture(page_picture_t *picture, uint8_t **data, const char *path, fault_t *fault)
{
    const char *ending = strrchr(path, '.');
    if (ending && strcmp(ending, ".png") == 0) {
        TRY(file_read(path, PAGE_MAX_PICTURE, data, &picture->size, fault));
    } else {
        image_t image;
        TRY(image_file_read(&image, path, fault));
        const fault_code_t code = png_encode(&image, 1, data, &picture->size, fault);
        image_clear(&image);
        TRY(code);
    }
    picture->png = *data;
    return FAULT_NONE;
}

static fault_code_t write_page(const report_t *report, const char *image, const char *path, fault_t *fault)
{
    page_picture_t picture = {0};
    uint8_t *data = NULL;
    char *html = NULL;
    size_t size;
    fault_code_t code = image ? read_picture(&picture, &data, image, fault) : FAULT_NONE;
    if (code == FAULT_NONE)
        code = fault_prefix(fault, page_write(&html, &size, report, &picture, fault), "%s", image ? image : path);
    if (code == FAULT_NONE)
        code = file_write(path, html, size, fault);
    free(html);
    free(data);
    return code;
}

static fault_code_t run(const char *name, const char *image, const char *page, const char *csv, fault_t *fault)
{
    uint8_t *text;
    size_t size;
    report_t *report;
    TRY(file_read(name, REPORT_MAX_BYTES, &text, &size, fault));
    fault_code_t code = report_read(&report, (const char *)text, size, name, fault);
    free(text);
    TRY(code);
    if (page)
        code = write_page(report, image, page, fault);
    if (code == FAULT_NONE && csv)
        code = csv_write(report, csv, fault);
    report_destroy(&report);
    return code;
}

int command_report(int argc, char **argv)
{
    const char *name, *image = NULL, *page = NULL, *csv = NULL;
    int status;
    fault_t fault = {0};
    const option_t list[] = {
        {"image", OPTION_TEXT, &image}, {"output", OPTION_TEXT, &page}, {"csv", OPTION_TEXT, &csv}, {0}};
    if (!options_parse("report", usage, list, argc, argv, &name, 1, 1, &status))
        return status;
    if (!page && !csv)
        return options_refuse("report", "one of -o PAGE.html and --csv FOLDER is needed");
    if (image && !page)
        return options_refuse("report", "--image goes with -o");
    return run(name, image, page, csv, &fault) == FAULT_NONE ? STATUS_SUCCESS : remote_fail(&fault);
}
