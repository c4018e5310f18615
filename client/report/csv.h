/* csv.h: a report (report.h) as tables for other programs: RFC 4180, a line of names first, numbers with all their
 * digits, nothing where a number is not known.
 *
 *     history.csv     seconds,cpu_seconds,mutations,relmse,error
 *     lengths.csv
 * length,b,b_standard_error,relmse,share,mutations,chains,cpu_seconds,zero_contribution,longest_stay moves.csv
 * length,move,proposed,acceptance          length 0: chains of all lengths at once techniques.csv
 * length,s,t,value,standard_error effects.csv     name,state,reason,energy,consequence
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
