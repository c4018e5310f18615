/* toy_engine.h: an engine whose units are a moment's work. The first octet of a record says what it does:
 * 'r': the result is the digest of job text and record, repeated as often as the second octet says;
 * 'f': fails with FAULT_RANGE; 'w': waits until it is cancelled.
 * A source whose text begins with "bad" cannot be opened. */
#ifndef TESTS_WORKER_TOY_ENGINE_H
#define TESTS_WORKER_TOY_ENGINE_H

#include "worker/engine.h"

typedef struct toy {
    atomic_int opened, closed, most_open, spaces, waiting;
} toy_t;

engine_t toy_engine(toy_t *toy);
/* What the unit's result must be, computed here and now; *data is the caller's to free(). */
void toy_expected(const char *text, const uint8_t *record, size_t record_size, uint8_t **data, size_t *size);

#endif
