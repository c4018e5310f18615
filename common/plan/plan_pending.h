/* plan_pending.h: results of units that are in, but must not be added up yet (plan_eras.h says why). They are kept
 * as the bytes they came as.
 *
 * One thread at a time, as all of a plan. */
#ifndef PLAN_PLAN_PENDING_H
#define PLAN_PLAN_PENDING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"
#include "base/wire.h"

typedef struct plan_pending_result {
    uint64_t unit;
    uint8_t *data; /* owned */
    size_t size;
} plan_pending_result_t;

enum { PLAN_PENDING_MOST = 1024 };

/* All zero: none. */
typedef struct plan_pending {
    plan_pending_result_t *results;
    size_t count, room;
} plan_pending_t;

void plan_pending_clear(plan_pending_t *pending);
/* Keeps a copy of the bytes. At most PLAN_PENDING_MOST. */
fault_code_t plan_pending_add(plan_pending_t *pending, uint64_t unit, const uint8_t *data, size_t size,
                              fault_t *fault);
bool plan_pending_has(const plan_pending_t *pending, uint64_t unit);
/* Takes result `i` out: the caller frees its data. The last one takes its place. */
plan_pending_result_t plan_pending_take(plan_pending_t *pending, size_t i);

/* As bytes: u64 count; of each u64 unit and its result. Hostile bytes back: units must be below `units` and differ;
 * what the results hold is the caller's to look at. */
void plan_pending_put(wire_writer_t *out, const plan_pending_t *pending);
fault_code_t plan_pending_get(wire_reader_t *in, plan_pending_t *pending, uint64_t units);

#endif
