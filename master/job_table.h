/* job_table.h: all jobs of a master, oldest first. Some of them run at a time and share the workers: each unit goes
 * to the job that has the fewest with workers, in turn where they are equal. A job that fails or waits for the disk
 * leaves its share to the others. One thread at a time. */
#ifndef MASTER_JOB_TABLE_H
#define MASTER_JOB_TABLE_H

#include "master/run.h"

enum {
    JOB_TABLE_RUNNING = 8, /* jobs at a time: each holds its scene and film in memory */
    JOB_TABLE_MAX = 65536
};

typedef struct job_table job_table_t;

/* Loads what the store holds; unfinished jobs are queued again. One that cannot be read is left alone, with a
 * warning. `options`' first_attempt is made up here. */
fault_code_t job_table_new(job_table_t **out, store_t *store, const run_options_t *options, fault_t *fault);
void job_table_destroy(job_table_t **table);

/* A new job under a new number, queued; see run_new. */
fault_code_t job_table_add(job_table_t *table, const char *text, const digest_t *bundle, run_t **out,
                           fault_t *fault);
run_t *job_table_find(const job_table_t *table, uint64_t id); /* null if there is none */
size_t job_table_count(const job_table_t *table);
run_t *job_table_at(const job_table_t *table, size_t index); /* oldest first */
/* Started and not ended; the list changes only in job_table_poll. */
size_t job_table_active_count(const job_table_t *table);
run_t *job_table_active(const job_table_t *table, size_t index);

/* Called for each run whose state changed. */
typedef void (*job_table_change_t)(void *context, run_t *run);
/* Polls the active jobs, retires those that ended, starts queued ones. */
void job_table_poll(job_table_t *table, double now, bool working, job_table_change_t change, void *context);

/* The next unit for a worker, of any job; see run_issue. */
bool job_table_issue(job_table_t *table, uint64_t worker, size_t workers, double now, run_t **run,
                     message_lease_t *lease, const work_record_t **record);

#endif
