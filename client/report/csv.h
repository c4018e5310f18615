/* csv.h: a report (report.h) as tables for other programs: RFC 4180, a line of names first, numbers with all their
 * digits, nothing where a number is not known.
 * The tables and their columns are in docs/reports.md.
 */
#ifndef CLIENT_REPORT_CSV_H
#define CLIENT_REPORT_CSV_H

#include "client/report/report.h"

typedef enum csv_table {
    CSV_HISTORY = 0,
    CSV_LENGTHS,
    CSV_MOVES,
    CSV_TECHNIQUES,
    CSV_REGIONS,
    CSV_EFFECTS,
    CSV_TABLES
} csv_table_t;

/* "history.csv" */
const char *csv_name(csv_table_t table);

/* The table as text, which the caller frees; null when out of memory. */
char *csv_print(const report_t *report, csv_table_t table);

/* All of them into a folder, which is made if missing. */
fault_code_t csv_write(const report_t *report, const char *folder, fault_t *fault);

#endif
