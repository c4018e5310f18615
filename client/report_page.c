#include "client/report_page.h"

#include <stdlib.h>

#include "base/file.h"
#include "client/report/page.h"

static fault_code_t write_page(const uint8_t *text, size_t size, const page_picture_t *picture, const char *path,
                               fault_t *fault)
{
    report_t *report;
    char *html = NULL;
    size_t html_size;
    TRY(report_read(&report, (const char *)text, size, "the job's report", fault));
    fault_code_t code = page_write(&html, &html_size, report, picture, fault);
    report_destroy(&report);
    if (code == FAULT_NONE)
        code = file_write(path, html, html_size, fault);
    free(html);
    return code;
}

fault_code_t report_page_fetch(link_t *link, uint64_t job, const char *path, fault_t *fault)
{
    uint8_t *text, *png;
    size_t size;
    page_picture_t picture = {0};
    TRY(link_fetch(link, job, MESSAGE_OUTPUT_REPORT, &text, &size, fault));
    fault_code_t code = link_fetch(link, job, MESSAGE_OUTPUT_PREVIEW, &png, &picture.size, fault);
    if (code == FAULT_NONE) {
        picture.png = png;
        code = write_page(text, size, &picture, path, fault);
        free(png);
    }
    free(text);
    return code;
}
