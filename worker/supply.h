/* supply.h: fetches from the master what units need before they can run: job texts and bundles. One bundle at a
 * time, in pieces, a few of them under way. For one thread, the session's. */
#ifndef WORKER_SUPPLY_H
#define WORKER_SUPPLY_H

#include "proto/transport.h"
#include "worker/cache.h"
#include "worker/held.h"
#include "worker/source.h"

typedef struct supply supply_t;

typedef enum supply_state {
    SUPPLY_PENDING, /* asked for, or about to be */
    SUPPLY_READY,
    SUPPLY_FAILED
} supply_state_t;

fault_code_t supply_new(supply_t **out, cache_t *cache, fault_t *fault); /* borrows the cache */
void supply_destroy(supply_t **supply);

/* What a unit needs: asks for it if need be. READY: *source is borrowed until the next call of any supply function.
 * FAILED: fault says why; it stays so until supply_forget_failures. */
supply_state_t supply_get(supply_t *supply, const held_t *held, source_t **source, fault_t *fault);
/* All units have been told; the next one that comes may try again. */
void supply_forget_failures(supply_t *supply);

/* Sends the requests that are due; those unanswered for retry_seconds are sent again. A full queue delays them. */
void supply_pump(supply_t *supply, transport_t *transport, double retry_seconds);
/* Answers. What was not asked for is ignored. */
void supply_take_job(supply_t *supply, const message_job_data_t *data);
void supply_take_chunk(supply_t *supply, const message_chunk_t *chunk);
void supply_take_refusal(supply_t *supply, const message_refused_t *refused);
/* A new connection: what was under way on the old one will not come; a bundle goes on where it stopped. */
void supply_restart(supply_t *supply);

#endif
