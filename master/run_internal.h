/* run_internal.h: a run's insides, shared by run.c (life), run_results.c (units and results) and run_record.c
 * (files and status). Nobody else includes it.
 *
 * While `task` is busy, bundle, plan, journal and ledger belong to the run's thread. */
#ifndef MASTER_RUN_INTERNAL_H
#define MASTER_RUN_INTERNAL_H

#include <pthread.h>
#include <stdatomic.h>

#include "master/journal.h"
#include "master/run.h"
#include "scene/bundle.h"

/* A result that is merged and not yet acknowledged. */
typedef struct run_waiting {
    uint64_t worker;
    message_lease_t lease;
    message_ack_t outcome;
    double seconds;
    uint8_t *data; /* null once it is in the journal */
    size_t size;
} run_waiting_t;

typedef enum run_task { RUN_TASK_NONE = 0, RUN_TASK_SETUP, RUN_TASK_OUTPUT } run_task_t;

struct run {
    uint64_t id;
    run_state_t state;
    store_t *store; /* borrowed */
    run_options_t options;
    bool started;

    job_t job;
    char *text;
    digest_t text_digest, bundle_digest;
    double submitted, ended; /* seconds since 1970; ended 0 while it runs */
    char failure[FAULT_TEXT_SIZE];
    char trouble[FAULT_TEXT_SIZE]; /* what holds it up at present, or "" */

    bundle_t *bundle;
    plan_t *plan;
    ledger_t *ledger;
    journal_t *journal;
    bool restored;      /* went on from files: results of attempts before the restart may come */
    uint64_t late_left; /* units that may still be handed out early for such results */

    /* the clock: seconds counts from the first unit on while a worker is connected */
    double seconds, last_tick, setup_seconds, pilot_seconds;
    double replayed_seconds, setup_took; /* written by the thread, taken over at its end */
    bool clock_runs;
    plan_progress_t progress; /* the latest; stopped_by points into stopped_by below */
    char stopped_by[64];

    run_waiting_t *waiting;
    size_t waiting_count, waiting_capacity, waiting_unwritten;
    double last_sync, last_snapshot, retry_at, retry_pause;
    bool need_snapshot; /* a sync failed: only a snapshot makes results durable */

    uint64_t *contributors;
    size_t contributor_count;
    uint64_t attempts_lost, attempts_failed;

    pthread_t thread;
    run_task_t task;
    atomic_bool task_done;
    fault_t task_fault;
    bool cancel_wanted;
    double output_retry_at, output_pause;
};

/* run.c */
void run_set_state(run_t *run, run_state_t state);
void run_fail(run_t *run, const char *text);
void run_release(run_t *run); /* plan, bundle, ledger, journal, what waits */

/* run_results.c */
fault_code_t run_open_journal(run_t *run, fault_t *fault);
bool run_draw_until(run_t *run, uint64_t unit, uint64_t *limit, fault_t *fault);
/* snapshot bytes and the clock they were taken at; *data null if there is no snapshot */
fault_code_t run_read_snapshot(run_t *run, uint8_t **data, size_t *size, size_t *offset, fault_t *fault);

/* run_record.c */
fault_code_t run_save_record(const run_t *run, fault_t *fault);
fault_code_t run_read_record(run_t *run, fault_t *fault);
void run_note_progress(run_t *run);

#endif
