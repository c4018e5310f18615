/* results_table.h: a bench's results as text, JSON and CSV. */
#ifndef CLIENT_BENCH_RESULTS_TABLE_H
#define CLIENT_BENCH_RESULTS_TABLE_H

#include <stdio.h>

#include "client/bench/results.h"

/* A table a scene, a row for each variant and budget; failures below. */
void results_print(FILE *out, const results_t *results);
/* The same and every run; the caller destroys. */
json_t *results_json(const results_t *results);
/* The same as RFC 4180, a line of names first; nothing where a number is not known. */
void results_print_csv(FILE *out, const results_t *results);

#endif
