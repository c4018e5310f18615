/* report_page.h: a finished job's page (client/report/page.h), made here of the report and the preview that its
 * master has: masters know nothing of HTML. */
#ifndef CLIENT_REPORT_PAGE_FETCH_H
#define CLIENT_REPORT_PAGE_FETCH_H

#include "client/link.h"

/* Fetches both and writes the page. */
fault_code_t report_page_fetch(link_t *link, uint64_t job, const char *path, fault_t *fault);

#endif
