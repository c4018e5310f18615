/* link.h: a client's connection to a master: requests with their answers, jobs up, outputs down.
 *
 *     link_t *link;
 *     TRY(link_open(&link, address, &(link_options_t){0}, fault));
 *     TRY(link_submit(link, text, bundle, &job, fault));
 *     TRY(link_subscribe(link, job, fault));
 *     do TRY(link_next(link, 200, &event, fault)); while (...);
 *     TRY(link_fetch(link, job, MESSAGE_OUTPUT_IMAGE, &data, &size, fault));
 *     link_close(&link);
 *
 * A master that was restarted, or has not heard of this client for long, is greeted again. Every wait has a limit
 * (LINK_TIMEOUT_MS) and ends early with FAULT_CANCELLED after an interrupt (interrupt.h). One thread. */
#ifndef CLIENT_LINK_H
#define CLIENT_LINK_H

#include "base/json.h"
#include "proto/transport.h"

enum { LINK_TIMEOUT_MS = 10000, LINK_WINDOW = 8 /* pieces under way; the protocol allows 16 */ };

typedef struct link link_t;

typedef struct link_options {
    const char *token;      /* null: none */
    const char *server_key; /* CURVE; null: no encryption */
} link_options_t;

/* FAULT_TIMEOUT: no master answers. */
fault_code_t link_open(link_t **out, const char *address, const link_options_t *options, fault_t *fault);
void link_close(link_t **link);

/* Submits a job; the bundle (a file) is sent if the master has not got it. */
fault_code_t link_submit(link_t *link, const char *text, const char *bundle, uint64_t *job, fault_t *fault);
/* The state of a job, or of all (0); the caller destroys *out. */
fault_code_t link_status(link_t *link, uint64_t job, json_t **out, fault_t *fault);
fault_code_t link_cancel(link_t *link, uint64_t job, fault_t *fault);
/* The job's canonical text; the caller frees. */
fault_code_t link_job_text(link_t *link, uint64_t job, char **text, fault_t *fault);
/* A whole output; *data is the caller's to free(). */
fault_code_t link_fetch(link_t *link, uint64_t job, message_output_t output, uint8_t **data, size_t *size,
                        fault_t *fault);

fault_code_t link_subscribe(link_t *link, uint64_t job, fault_t *fault);
/* The next PROGRESS or JOB_END within `ms`; *got says whether there was one. FAULT_TIMEOUT: the master has been
 * silent for too long. */
fault_code_t link_next(link_t *link, int ms, transport_event_t *event, bool *got, fault_t *fault);

#endif
