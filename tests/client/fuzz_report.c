/* Reports of any bytes: read, shown as a page and as tables, all sizes bounded. */
#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "client/report/csv.h"
#include "client/report/page.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    report_t *report;
    fault_t fault = {0};
    if (report_read(&report, (const char *)data, size, "input", &fault) != FAULT_NONE) {
        assert(!report && fault.text[0]);
        return 0;
    }
    char *html;
    size_t length;
    assert(page_write(&html, &length, report, NULL, &fault) == FAULT_NONE);
    assert(strlen(html) == length && strstr(html, "</html>"));
    free(html);
    for (int table = 0; table < CSV_TABLES; table++) {
        char *text = csv_print(report, (csv_table_t)table);
        assert(text && strchr(text, '\n'));
        free(text);
    }
    report_destroy(&report);
    return 0;
}
