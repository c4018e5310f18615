/* spread.h: what repeated measurements of one quantity say: median, least, most. */
#ifndef CLIENT_BENCH_SPREAD_H
#define CLIENT_BENCH_SPREAD_H

#include <stddef.h>

#include "base/json.h"

typedef struct spread {
    double median, min, max;
} spread_t;

/* Sorts the values in place; all NaN if there are none. */
spread_t spread_of(double *values, size_t count);
/* {"median": m, "min": a, "max": b} */
json_t *spread_json(spread_t spread);

#endif
