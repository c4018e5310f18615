/* held.h: the units in a worker's hands, from WORK to ACK: those that wait for their job or bundle, those in the
 * runner, and the results that the master has not acknowledged. For one thread. */
#ifndef WORKER_HELD_H
#define WORKER_HELD_H

#include "proto/message.h"

typedef enum held_state {
    HELD_WAITING, /* for the job's text or its bundle */
    HELD_RUNNING, /* in the runner */
    HELD_DONE     /* kept until acknowledged */
} held_state_t;

typedef struct held {
    struct held *next;
    message_lease_t lease;
    held_state_t state;
    digest_t job_digest, bundle_digest;
    uint8_t *record; /* while waiting */
    size_t record_size;
    uint8_t *result; /* done without fault */
    size_t result_size;
    fault_code_t code; /* done with fault: code and text */
    char *text;
    bool sent;      /* over the present connection */
    bool cancelled; /* its outcome will be dropped */
} held_t;

typedef struct held_list {
    held_t *first, **last;
    unsigned count, done;
    size_t done_bytes; /* of results not acknowledged */
} held_list_t;

void held_init(held_list_t *list);
void held_clear(held_list_t *list);
/* Copies the record. Null when out of memory. */
held_t *held_add(held_list_t *list, const message_work_t *work);
held_t *held_find(const held_list_t *list, const message_lease_t *lease);
void held_remove(held_list_t *list, held_t *held);
/* Done: takes result (null after a fault) and stands last in the list: results are in the order they were made. */
void held_finish(held_list_t *list, held_t *held, uint8_t *result, size_t size, const fault_t *fault);
/* Gives up the record, once the runner has its own. */
void held_drop_record(held_t *held);

#endif
