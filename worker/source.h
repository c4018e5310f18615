/* source.h: what a unit is a piece of: a job's canonical text and the digest of its bundle. Immutable, shared by
 * counting: the session, units in the queue and open scenes each hold a reference. Any thread. */
#ifndef WORKER_SOURCE_H
#define WORKER_SOURCE_H

#include <stdbool.h>

#include "base/digest.h"
#include "base/fault.h"

typedef struct source source_t;

/* One reference, the caller's; the digest of the text is taken. */
fault_code_t source_new(source_t **out, const char *text, const digest_t *bundle, fault_t *fault);
source_t *source_share(source_t *source); /* one more reference */
void source_release(source_t **source);   /* nulls the pointer, accepts null */

const char *source_text(const source_t *source);
const digest_t *source_digest(const source_t *source); /* of the text */
const digest_t *source_bundle(const source_t *source);
/* The same text and bundle: one scene serves both. */
bool source_equal(const source_t *a, const source_t *b);

#endif
