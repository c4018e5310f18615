/* run.h: one job's course in this master: its plan, bundle, ledger and journal, from submission to outputs.
 *
 * States:
 *
 *     queued --run_start--> (set-up in a thread of its own) --> running --plan finished--> finishing --> done
 *        \____________________________\__________________________\____________________\--> failed, cancelled
 *
 * Set-up (bundle, plan, replay of the journal) and the writing of outputs happen in the run's own thread, while the
 * caller's loop goes on; run_poll notes their end. All functions are for the loop's thread.
 *
 * Durability: run_absorb merges a result and appends it to the journal; run_flush syncs the journal at most every
 * RUN_SYNC_SECONDS and only then reports the results as durable, to be acknowledged. When the disk is full the
 * results are kept in memory, unacknowledged; nothing more is handed out, and run_flush tries again with growing
 * pauses.
 */
#ifndef MASTER_RUN_H
#define MASTER_RUN_H

#include "master/ledger.h"
#include "master/output.h"
#include "master/store.h"
#include "plan/plan.h"
#include "proto/message.h"

#define RUN_SYNC_SECONDS 0.2
#define RUN_SNAPSHOT_SECONDS 60.0
#define RUN_SNAPSHOT_BYTES (UINT64_C(256) << 20)

typedef enum run_state {
    RUN_QUEUED = 0,    /* waits, or is being set up */
    RUN_RUNNING = 1,   /* units are handed out */
    RUN_FINISHING = 2, /* outputs are being written */
    RUN_DONE = 3,
    RUN_FAILED = 4,
    RUN_CANCELLED = 5,
    RUN_STATES
} run_state_t;

typedef struct run run_t;

typedef struct run_options {
    int wake_fd; /* an eventfd that the run's thread writes to when it ends; -1: none */
    double lease_seconds;
    uint64_t first_attempt; /* greater than any attempt of earlier runs of the master */
} run_options_t;

const char *run_state_name(run_state_t state); /* "queued" */

/* A new job: `text` is checked and made canonical, the job's folder is written. The bundle must be in the store.
 * The store is borrowed for the run's life. */
fault_code_t run_new(run_t **out, store_t *store, uint64_t id, const char *text, const digest_t *bundle,
                     double submitted, fault_t *fault);
/* A job found in the store after a restart. Ended ones keep their state; others are queued. */
fault_code_t run_load(run_t **out, store_t *store, uint64_t id, fault_t *fault);
/* Waits for the run's thread. A running plan is not saved: see run_checkpoint. */
void run_destroy(run_t **run);

uint64_t run_id(const run_t *run);
run_state_t run_get_state(const run_t *run);
bool run_is_started(const run_t *run); /* run_start was called and the run has not ended */
bool run_has_ended(const run_t *run);  /* done, failed or cancelled */
double run_submitted(const run_t *run);
const job_t *run_job(const run_t *run);
const char *run_text(const run_t *run); /* the canonical job */
const digest_t *run_text_digest(const run_t *run);
const digest_t *run_bundle_digest(const run_t *run);
/* Why it failed, or "". */
const char *run_failure(const run_t *run);

/* Begins set-up. */
void run_start(run_t *run, const run_options_t *options);
/* Notes the end of background work, advances the clock, tests the stop rules. `working`: a worker is connected, so
 * time counts. True if the state changed. */
bool run_poll(run_t *run, double now, bool working);

/* Leases a unit to the worker: a lost one first, then a new one, then a copy of a straggler. `workers` of
 * them are connected (see ledger_next_lost). *record is the plan's. False: nothing to do. */
bool run_issue(run_t *run, uint64_t worker, size_t workers, double now, message_lease_t *lease,
               const work_record_t **record);
/* The lease could not be sent. */
void run_return(run_t *run, const message_lease_t *lease);
size_t run_leases(const run_t *run);

/* Merges a result of a worker. *later: the answer comes by run_flush; else *outcome is the answer. *merged: it
 * counts, the first of its unit. A fault (FAULT_FORMAT and the like) means that the attempt failed; the run may
 * have failed with it. */
fault_code_t run_absorb(run_t *run, uint64_t worker, const message_lease_t *lease, const uint8_t *data, size_t size,
                        double now, bool *merged, bool *later, message_ack_t *outcome, fault_t *fault);
/* An attempt ended with a fault at the worker. */
void run_fail_attempt(run_t *run, const message_lease_t *lease, fault_code_t code, const char *text);
/* A heartbeat: renews the leases of this job among those named, ends those handed out before `before` and not
 * named. */
void run_renew(run_t *run, uint64_t worker, const message_leases_t *leases, double now, double before);
size_t run_drop_worker(run_t *run, uint64_t worker);
size_t run_expire(run_t *run, double now);

/* Called for each result that is now durable. */
typedef void (*run_ack_t)(void *context, uint64_t worker, const message_lease_t *lease, message_ack_t outcome);
/* Appends what waits, syncs when due (or when `force`), snapshots when due. Returns the time by which it wants to
 * be called again, infinity if it does not. */
double run_flush(run_t *run, double now, bool force, run_ack_t ack, void *context);
/* Saves a snapshot now, if the run is running. */
fault_code_t run_checkpoint(run_t *run, fault_t *fault);

/* Ends the job as cancelled (soon, if its thread is busy). */
void run_cancel(run_t *run);

/* The job as JSON for status and progress; the caller destroys. */
json_t *run_status(const run_t *run);

#endif
