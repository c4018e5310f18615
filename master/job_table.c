#include "master/job_table.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>

#include "base/log.h"

struct job_table {
    store_t *store;
    run_options_t options;
    run_t **runs;
    size_t count, capacity;
    run_t *active[JOB_TABLE_RUNNING];
    size_t active_count, turn;
};

static fault_code_t push(job_table_t *table, run_t *run, fault_t *fault)
{
    if (table->count == table->capacity) {
        const size_t capacity = table->capacity ? 2 * table->capacity : 64;
        run_t **grown = realloc(table->runs, capacity * sizeof *grown);
        if (!grown)
            return fault_set(fault, FAULT_MEMORY, "no memory for %zu jobs", capacity);
        table->runs = grown;
        table->capacity = capacity;
    }
    table->runs[table->count++] = run;
    return FAULT_NONE;
}

static int by_submission(const void *a, const void *b)
{
    const double x = run_submitted(*(run_t *const *)a), y = run_submitted(*(run_t *const *)b);
    return (x > y) - (x < y);
}

static fault_code_t load(job_table_t *table, fault_t *fault)
{
    uint64_t *ids = NULL;
    size_t count = 0;
    TRY(store_list_jobs(table->store, &ids, &count, fault));
    fault_code_t code = FAULT_NONE;
    for (size_t i = 0; i < count && code == FAULT_NONE; i++) {
        run_t *run = NULL;
        fault_t why = {0};
        const fault_code_t loaded = run_load(&run, table->store, ids[i], &why);
        if (loaded == FAULT_NOT_FOUND)
            store_remove_job(table->store, ids[i]); /* a submission that was cut off: nobody was told its number */
        else if (loaded != FAULT_NONE)
            log_warn("job %" PRIu64 " is left alone: %s", ids[i], why.text);
        else if ((code = push(table, run, fault)) != FAULT_NONE)
            run_destroy(&run);
    }
    free(ids);
    if (table->count > 0)
        qsort(table->runs, table->count, sizeof(run_t *), by_submission);
    return code;
}

fault_code_t job_table_new(job_table_t **out, store_t *store, const run_options_t *options, fault_t *fault)
{
    *out = NULL;
    job_table_t *table = calloc(1, sizeof *table);
    if (!table)
        return fault_set(fault, FAULT_MEMORY, "no memory for the table of jobs");
    table->store = store;
    table->options = *options;
    const fault_code_t code = load(table, fault);
    if (code != FAULT_NONE) {
        job_table_destroy(&table);
        return code;
    }
    *out = table;
    return FAULT_NONE;
}

void job_table_destroy(job_table_t **table)
{
    if (!*table)
        return;
    for (size_t i = 0; i < (*table)->count; i++)
        run_destroy(&(*table)->runs[i]);
    free((*table)->runs);
    free(*table);
    *table = NULL;
}

/* Numbers are drawn at random, so that two masters hardly ever give the same one. 48 bits are short enough to type.
 */
static fault_code_t draw_id(const job_table_t *table, uint64_t *id, fault_t *fault)
{
    do {
        if (getrandom(id, sizeof *id, 0) != sizeof *id)
            return fault_set(fault, FAULT_IO, "no random numbers to be had");
        *id &= UINT64_C(0xffffffffffff);
    } while (*id == 0 || job_table_find(table, *id));
    return FAULT_NONE;
}

fault_code_t job_table_add(job_table_t *table, const char *text, const digest_t *bundle, run_t **out,
                           fault_t *fault)
{
    *out = NULL;
    if (table->count >= JOB_TABLE_MAX)
        return fault_set(fault, FAULT_LIMIT, "%d jobs are known already, ended ones included", JOB_TABLE_MAX);
    uint64_t id;
    TRY(draw_id(table, &id, fault));
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    run_t *run;
    TRY(run_new(&run, table->store, id, text, bundle, (double)now.tv_sec + 1e-9 * (double)now.tv_nsec, fault));
    const fault_code_t code = push(table, run, fault);
    if (code != FAULT_NONE) {
        store_remove_job(table->store, id);
        run_destroy(&run);
        return code;
    }
    *out = run;
    return FAULT_NONE;
}

run_t *job_table_find(const job_table_t *table, uint64_t id)
{
    for (size_t i = 0; i < table->active_count; i++)
        if (run_id(table->active[i]) == id)
            return table->active[i];
    for (size_t i = 0; i < table->count; i++)
        if (run_id(table->runs[i]) == id)
            return table->runs[i];
    return NULL;
}

size_t job_table_count(const job_table_t *table)
{
    return table->count;
}

run_t *job_table_at(const job_table_t *table, size_t index)
{
    return table->runs[index];
}

size_t job_table_active_count(const job_table_t *table)
{
    return table->active_count;
}

run_t *job_table_active(const job_table_t *table, size_t index)
{
    return table->active[index];
}

/* A number greater than any attempt of an earlier master: no one makes an attempt each nanosecond. */
static uint64_t first_attempt(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (uint64_t)now.tv_sec * UINT64_C(1000000000) + (uint64_t)now.tv_nsec;
}

static void start_queued(job_table_t *table)
{
    for (size_t i = 0; i < table->count && table->active_count < JOB_TABLE_RUNNING; i++) {
        run_t *run = table->runs[i];
        if (run_get_state(run) != RUN_QUEUED || run_is_started(run))
            continue;
        run_options_t options = table->options;
        options.first_attempt = first_attempt();
        table->active[table->active_count++] = run;
        run_start(run, &options);
    }
}

void job_table_poll(job_table_t *table, double now, bool working, job_table_change_t change, void *context)
{
    size_t kept = 0;
    for (size_t i = 0; i < table->active_count; i++) {
        run_t *run = table->active[i];
        if (run_poll(run, now, working) || run_has_ended(run))
            change(context, run);
        if (!run_has_ended(run))
            table->active[kept++] = run;
    }
    table->active_count = kept;
    if (kept < JOB_TABLE_RUNNING)
        start_queued(table);
}

bool job_table_issue(job_table_t *table, uint64_t worker, size_t workers, double now, run_t **run,
                     message_lease_t *lease, const work_record_t **record)
{
    bool tried[JOB_TABLE_RUNNING] = {false};
    for (size_t round = 0; round < table->active_count; round++) {
        size_t best = table->active_count;
        for (size_t i = 0; i < table->active_count; i++) {
            const size_t at = (table->turn + i) % table->active_count;
            if (!tried[at] &&
                (best == table->active_count || run_leases(table->active[at]) < run_leases(table->active[best])))
                best = at;
        }
        tried[best] = true;
        if (run_issue(table->active[best], worker, workers, now, lease, record)) {
            *run = table->active[best];
            table->turn = (best + 1) % table->active_count;
            return true;
        }
    }
    return false;
}
