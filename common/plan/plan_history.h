/* plan_history.h: how the estimated error of a render fell: a series of what it was after how much work.
 *
 * At most PLAN_HISTORY points are kept. When a further one comes, one of the inner ones goes: that whose neighbours
 * are nearest to each other in the logarithm of time, so that the series stays even on a logarithmic axis. */
#ifndef PLAN_PLAN_HISTORY_H
#define PLAN_PLAN_HISTORY_H

#include <stdint.h>

#include "base/wire.h"

enum { PLAN_HISTORY = 256 };

typedef struct plan_point {
    double seconds;     /* wall time since the job began */
    double cpu_seconds; /* of all workers until then, pilot included */
    double mutations;
    double relmse, spread; /* the estimate, and the relative standard error of the outlook; NaN: not known, or
                              relmse unreliable */
    double outlook;        /* what it would be, were the points of samples as even as they are going to be */
} plan_point_t;

typedef struct plan_history {
    plan_point_t points[PLAN_HISTORY]; /* ascending in cpu_seconds */
    uint32_t count;
} plan_history_t;

/* Takes a point in; one that is not later than the last takes its place. Points that are not finite are passed over
 * (the spread may be). */
void plan_history_add(plan_history_t *history, const plan_point_t *point);

/* As bytes: u32 count, then of each point six f64 in the order above. */
void plan_history_put(wire_writer_t *out, const plan_history_t *history);
/* Hostile bytes, into an empty history. */
fault_code_t plan_history_get(wire_reader_t *in, plan_history_t *history);

#endif
