/* history.h: how the estimated error of a render fell: a series of what it was after how much work.
 *
 * At most HISTORY_POINTS points are kept. When a further one comes, one of the inner ones goes: that whose
 * neighbours are nearest to each other in the logarithm of time, so that the series stays even on a logarithmic
 * axis. */
#ifndef STATS_HISTORY_H
#define STATS_HISTORY_H

#include <stdint.h>

#include "base/wire.h"

enum { HISTORY_POINTS = 256 };

typedef struct history_point {
    double seconds;     /* wall time since the job began */
    double cpu_seconds; /* of all workers until then, pilot included */
    double mutations;
    double relmse, spread; /* the estimate, and the relative standard error of the outlook; NaN: not known, or
                              relmse unreliable */
    double outlook;        /* what it would be, were the points of samples as even as they are going to be */
} history_point_t;

typedef struct history {
    history_point_t points[HISTORY_POINTS]; /* ascending in cpu_seconds */
    uint32_t count;
} history_t;

/* Takes a point in; one that is not later than the last takes its place. Points that are not finite are passed over
 * (the spread may be). */
void history_add(history_t *history, const history_point_t *point);

/* As bytes: u32 count, then of each point six f64 in the order above. */
void history_put(wire_writer_t *out, const history_t *history);
/* Hostile bytes, into an empty history. */
fault_code_t history_get(wire_reader_t *in, history_t *history);

#endif
