#include "client/report/page.h"

#include <stdlib.h>
#include <string.h>

#include "client/report/page_parts.h"

static void page_begin(page_t *page)
{
    const char *scene = report_text_of(report_member(page->report, "job"), "scene");
    page_put(
        page,
        "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n"
        "<meta charset=\"utf-8\"/>\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
        "<meta name=\"color-scheme\" content=\"light dark\"/>\n"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
        "img-src data:\"/>\n<title>");
    page_say(page, scene ? scene : "A render");
    page_put(page, " - Garland report</title>\n<style>\n");
    for (size_t i = 0; page_style[i]; i++)
        fputs(page_style[i], page->out);
    page_put(page, "</style>\n</head>\n<body>\n");
}

static void page_end(page_t *page)
{
    const char *version = report_text(page->report, "", "garland"),
               *instructions = report_text(page->report, "", "instructions");
    page_put(page, "<footer>Garland");
    if (version) {
        page_put(page, " ");
        page_say(page, version);
    }
    if (instructions) {
        page_put(page, ", ");
        page_say(page, instructions);
    }
    page_put(page, ". What each figure means: docs/reports.md.</footer>\n</body>\n</html>\n");
}

static void page_sections(page_t *page)
{
    page_begin(page);
    page_head(page);
    page_put(page, "<main>\n");
    page_error(page);
    page_lengths(page);
    page_light(page);
    page_time(page);
    page_groups(page);
    page_regions(page);
    page_bias(page);
    page_moves(page);
    page_techniques(page);
    page_effects(page);
    page_trouble(page);
    page_service(page);
    page_rest(page);
    page_job(page);
    page_put(page, "</main>\n");
    page_end(page);
}

fault_code_t page_write(char **html, size_t *size, const report_t *report, const page_picture_t *picture,
                        fault_t *fault)
{
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    *html = NULL;
    if (picture && picture->png &&
        (picture->size < sizeof signature || memcmp(picture->png, signature, sizeof signature) != 0))
        return fault_set(fault, FAULT_FORMAT, "the picture is no PNG file");
    page_t page = {.report = report, .picture = picture && picture->png ? picture : NULL};
    page.out = open_memstream(html, size);
    if (!page.out)
        return fault_set(fault, FAULT_MEMORY, "no memory for a page");
    page_sections(&page);
    const int failed = ferror(page.out);
    if (fclose(page.out) == 0 && !failed)
        return FAULT_NONE;
    free(*html);
    *html = NULL;
    return fault_set(fault, FAULT_MEMORY, "no memory for a page");
}
