/* run_results.c: units out, results in, and how they survive the master's death. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "master/run_internal.h"
#include "base/wire.h"

static const char snapshot_magic[8] = {'G', 'S', 'N', 'A', 'P', '0', '0', '1'};

enum { SNAPSHOT_HEADER = 8 + 8 + DIGEST_SIZE, STRAGGLER_FACTOR = 2, LATE_UNITS = 4096 };
#define SNAPSHOT_LIMIT (SIZE_MAX / 4)

static const double straggler_min_age = 1;           /* seconds */
static const double retry_min = 0.5, retry_max = 10; /* seconds between attempts on a full disk */

/* ---- units out ---- */

/* Hands out new units of the plan into the ledger's lost ones until `unit` is out; at most *limit of them, which is
 * counted down. */
bool run_draw_until(run_t *run, uint64_t unit, uint64_t *limit, fault_t *fault)
{
    uint64_t drawn;
    const work_record_t *record;
    while (*limit > 0 && plan_next(run->plan, &drawn, &record)) {
        --*limit;
        if (ledger_add_lost(run->ledger, drawn, fault) != FAULT_NONE)
            return false;
        if (drawn == unit)
            return true;
    }
    return false;
}

/* The unit to go to this worker next. */
static bool choose_unit(run_t *run, uint64_t worker, size_t workers, double now, uint64_t *unit)
{
    while (ledger_next_lost(run->ledger, worker, workers, unit)) {
        if (plan_record(run->plan, *unit))
            return true;
        ledger_finish(run->ledger, *unit); /* the plan has no more use for it */
    }
    const work_record_t *record;
    if (plan_next(run->plan, unit, &record))
        return true;
    const double age = fmax(straggler_min_age, STRAGGLER_FACTOR * ledger_mean_age(run->ledger));
    while (ledger_next_straggler(run->ledger, worker, now, age, unit)) {
        if (plan_record(run->plan, *unit))
            return true;
        ledger_finish(run->ledger, *unit);
    }
    return false;
}

bool run_issue(run_t *run, uint64_t worker, size_t workers, double now, message_lease_t *lease,
               const work_record_t **record)
{
    if (run->state != RUN_RUNNING || run->waiting_unwritten > 0 || run->need_snapshot)
        return false;
    uint64_t unit;
    if (!choose_unit(run, worker, workers, now, &unit))
        return false;
    fault_t fault = {0};
    *lease = (message_lease_t){.job = run->id, .unit = unit};
    *record = plan_record(run->plan, unit);
    if (!*record || ledger_issue(run->ledger, unit, worker, now, &lease->attempt, &fault) != FAULT_NONE) {
        log_warn("job %" PRIu64 ": unit %" PRIu64 " cannot be handed out: %s", run->id, unit, fault.text);
        return false;
    }
    if (!run->clock_runs) {
        run->clock_runs = true;
        run->last_tick = now;
    }
    return true;
}

void run_return(run_t *run, const message_lease_t *lease)
{
    if (run->ledger)
        ledger_return(run->ledger, lease->unit, lease->attempt);
}

size_t run_leases(const run_t *run)
{
    return run->state == RUN_RUNNING ? ledger_leases(run->ledger) : 0;
}

/* ---- results in ---- */

static void note_contributor(run_t *run, uint64_t worker)
{
    for (size_t i = 0; i < run->contributor_count; i++)
        if (run->contributors[i] == worker)
            return;
    uint64_t *grown = realloc(run->contributors, (run->contributor_count + 1) * sizeof *grown);
    if (!grown)
        return;
    run->contributors = grown;
    run->contributors[run->contributor_count++] = worker;
}

static void say_trouble(run_t *run, const char *what, const char *text)
{
    if (!run->trouble[0])
        log_warn("job %" PRIu64 ": %s, will try again: %s", run->id, what, text);
    snprintf(run->trouble, sizeof run->trouble, "%s: %.900s", what, text);
}

static void end_trouble(run_t *run)
{
    if (run->trouble[0])
        log_warn("job %" PRIu64 ": goes on", run->id);
    run->trouble[0] = '\0';
    run->retry_pause = 0;
}

static void pause_after_trouble(run_t *run, double now)
{
    run->retry_pause = fmin(retry_max, fmax(retry_min, 2 * run->retry_pause));
    run->retry_at = now + run->retry_pause;
}

static fault_code_t push_waiting(run_t *run, const run_waiting_t *waiting, fault_t *fault)
{
    if (run->waiting_count == run->waiting_capacity) {
        const size_t capacity = run->waiting_capacity ? 2 * run->waiting_capacity : 64;
        run_waiting_t *grown = realloc(run->waiting, capacity * sizeof *grown);
        if (!grown)
            return fault_set(fault, FAULT_MEMORY, "no memory for %zu results that wait", capacity);
        run->waiting = grown;
        run->waiting_capacity = capacity;
    }
    run->waiting[run->waiting_count++] = *waiting;
    return FAULT_NONE;
}

/* Journal, or memory when the disk does not take it. Order is kept: nothing passes by what waits. */
static fault_code_t keep_result(run_t *run, run_waiting_t *waiting, const uint8_t *data, size_t size, double now,
                                fault_t *fault)
{
    fault_t trouble = {0};
    if (run->waiting_unwritten == 0) {
        if (journal_append(run->journal, waiting->lease.unit, run->seconds, data, size, &trouble) == FAULT_NONE)
            return push_waiting(run, waiting, fault);
        say_trouble(run, "results cannot be written to the journal", trouble.text);
        pause_after_trouble(run, now);
    }
    waiting->data = malloc(size ? size : 1);
    if (!waiting->data)
        return fault_set(fault, FAULT_MEMORY, "no memory to keep a result of %zu bytes", size);
    memcpy(waiting->data, data, size);
    waiting->size = size;
    const fault_code_t code = push_waiting(run, waiting, fault);
    if (code == FAULT_NONE)
        run->waiting_unwritten++;
    else
        free(waiting->data);
    return code;
}

/* plan_absorb; after a restart also of units that were out before it. */
static fault_code_t absorb(run_t *run, uint64_t unit, const uint8_t *data, size_t size, plan_absorbed_t *how,
                           fault_t *fault)
{
    const double begin = clock_thread_cpu();
    fault_code_t code = plan_absorb(run->plan, unit, data, size, how, fault);
    if (code == FAULT_NONE && *how == PLAN_UNKNOWN && run->restored &&
        run_draw_until(run, unit, &run->late_left, fault))
        code = plan_absorb(run->plan, unit, data, size, how, fault);
    plan_note_merging(run->plan, clock_thread_cpu() - begin);
    return code;
}

fault_code_t run_absorb(run_t *run, uint64_t worker, const message_lease_t *lease, const uint8_t *data, size_t size,
                        double now, bool *merged, bool *later, message_ack_t *outcome, fault_t *fault)
{
    *later = *merged = false;
    *outcome = MESSAGE_ACK_UNKNOWN;
    if (run->state != RUN_RUNNING)
        return FAULT_NONE;
    plan_absorbed_t how = PLAN_UNKNOWN;
    fault_code_t code = absorb(run, lease->unit, data, size, &how, fault);
    if (code != FAULT_NONE && !plan_record(run->plan, lease->unit)) {
        run_fail(run, fault->text); /* the result was good, what follows from it is not: no light, say */
        return code;
    }
    if (code != FAULT_NONE) {
        run_fail_attempt(run, lease, code, fault->text);
        return code;
    }
    if (how == PLAN_UNKNOWN)
        return FAULT_NONE;
    run_waiting_t waiting = {
        .worker = worker, .lease = *lease, .outcome = MESSAGE_ACK_DUPLICATE, .seconds = run->seconds};
    if (how == PLAN_MERGED) {
        *merged = true;
        waiting.outcome = MESSAGE_ACK_MERGED;
        ledger_note_age(run->ledger, lease->unit, now);
        ledger_finish(run->ledger, lease->unit);
        note_contributor(run, worker);
        code = keep_result(run, &waiting, data, size, now, fault);
    } else {
        code = push_waiting(run, &waiting, fault);
    }
    if (code != FAULT_NONE) {
        /* merged and not kept: only a snapshot can make it last */
        run->need_snapshot = true;
        return FAULT_NONE;
    }
    *later = true;
    return FAULT_NONE;
}

void run_fail_attempt(run_t *run, const message_lease_t *lease, fault_code_t code, const char *text)
{
    if (run->state != RUN_RUNNING)
        return;
    if (code == FAULT_CANCELLED) {
        ledger_return(run->ledger, lease->unit, lease->attempt);
        return;
    }
    const uint32_t failures = ledger_fail(run->ledger, lease->unit, lease->attempt);
    if (failures == 0)
        return;
    run->attempts_failed++;
    log_warn("job %" PRIu64 ": unit %" PRIu64 " failed (%" PRIu32 " of %d): %s", run->id, lease->unit, failures,
             LEDGER_MAX_FAILURES, text);
    if (failures >= LEDGER_MAX_FAILURES) {
        char reason[FAULT_TEXT_SIZE];
        snprintf(reason, sizeof reason, "unit %" PRIu64 " failed %" PRIu32 " times, at last with: %.900s",
                 lease->unit, failures, text);
        run_fail(run, reason);
    }
}

void run_renew(run_t *run, uint64_t worker, const message_leases_t *leases, double now, double before)
{
    if (run->state != RUN_RUNNING)
        return;
    for (uint32_t i = 0; i < leases->count; i++) {
        const message_lease_t lease = message_lease_at(leases, i);
        if (lease.job == run->id)
            ledger_renew(run->ledger, lease.unit, lease.attempt, worker, now);
    }
    run->attempts_lost += ledger_drop_unnamed(run->ledger, worker, now, before);
}

size_t run_drop_worker(run_t *run, uint64_t worker)
{
    if (run->state != RUN_RUNNING)
        return 0;
    const size_t lost = ledger_drop_worker(run->ledger, worker);
    run->attempts_lost += lost;
    return lost;
}

size_t run_expire(run_t *run, double now)
{
    if (run->state != RUN_RUNNING)
        return 0;
    const size_t lost = ledger_expire(run->ledger, now);
    run->attempts_lost += lost;
    return lost;
}

/* ---- durability ---- */

static void forget_written(run_t *run)
{
    for (size_t i = 0; i < run->waiting_count; i++) {
        free(run->waiting[i].data);
        run->waiting[i].data = NULL;
    }
    run->waiting_unwritten = 0;
}

/* The snapshot holds everything merged, so whatever waits is durable with it. */
static fault_code_t save_snapshot(run_t *run, fault_t *fault)
{
    uint8_t *plan = NULL;
    size_t size = 0;
    TRY(plan_save(run->plan, &plan, &size, fault));
    uint8_t *data = malloc(SNAPSHOT_HEADER + size);
    if (!data) {
        free(plan);
        return fault_set(fault, FAULT_MEMORY, "no memory for a snapshot of %zu bytes", size);
    }
    memcpy(data + SNAPSHOT_HEADER, plan, size);
    free(plan);
    digest_t checksum;
    wire_writer_t out;
    wire_writer_init(&out, data, SNAPSHOT_HEADER, "snapshot", NULL);
    wire_put_raw(&out, snapshot_magic, sizeof snapshot_magic);
    wire_put_f64(&out, run->seconds);
    digest_of(&checksum, data + SNAPSHOT_HEADER, size);
    wire_put_digest(&out, &checksum);
    fault_code_t code = store_write(run->store, run->id, "snapshot", data, SNAPSHOT_HEADER + size, fault);
    free(data);
    TRY(code);
    TRY(store_sync_job(run->store, run->id, fault));
    TRY(journal_reset(run->journal, fault));
    forget_written(run);
    run->need_snapshot = false;
    return FAULT_NONE;
}

fault_code_t run_checkpoint(run_t *run, fault_t *fault)
{
    if (run->state != RUN_RUNNING && !(run->state == RUN_FINISHING && run->task == RUN_TASK_NONE))
        return FAULT_NONE;
    return save_snapshot(run, fault);
}

fault_code_t run_read_snapshot(run_t *run, uint8_t **data, size_t *size, size_t *offset, fault_t *fault)
{
    fault_t missing = {0};
    const fault_code_t code = store_read(run->store, run->id, "snapshot", SNAPSHOT_LIMIT, data, size, &missing);
    if (code == FAULT_NOT_FOUND) {
        *data = NULL;
        return FAULT_NONE;
    }
    if (code != FAULT_NONE)
        return fault_set(fault, code, "%s", missing.text);
    wire_reader_t in;
    wire_reader_init(&in, *data, *size < SNAPSHOT_HEADER ? *size : SNAPSHOT_HEADER, "snapshot", fault);
    const uint8_t *magic = wire_get_raw(&in, "magic", sizeof snapshot_magic);
    const double seconds = wire_get_f64(&in, "seconds");
    digest_t expected, checksum;
    wire_get_digest(&in, "checksum", &expected);
    fault_code_t end = wire_reader_end(&in);
    if (end == FAULT_NONE) {
        digest_of(&checksum, *data + SNAPSHOT_HEADER, *size - SNAPSHOT_HEADER);
        if (memcmp(magic, snapshot_magic, sizeof snapshot_magic) != 0 || !digest_equal(&expected, &checksum) ||
            !(seconds >= 0) || !isfinite(seconds))
            end = fault_set(fault, FAULT_FORMAT, "the job's snapshot is damaged");
    }
    if (end != FAULT_NONE) {
        free(*data);
        *data = NULL;
        return end;
    }
    *offset = SNAPSHOT_HEADER;
    run->replayed_seconds = seconds;
    run->restored = true;
    return FAULT_NONE;
}

static fault_code_t replay(void *context, uint64_t unit, double seconds, const uint8_t *data, size_t size,
                           fault_t *fault)
{
    run_t *run = context;
    plan_absorbed_t how = PLAN_UNKNOWN;
    run->restored = true;
    if (seconds > run->replayed_seconds && isfinite(seconds))
        run->replayed_seconds = seconds;
    TRY(plan_absorb(run->plan, unit, data, size, &how, fault));
    uint64_t limit = UINT64_MAX;
    if (how == PLAN_UNKNOWN && run_draw_until(run, unit, &limit, fault))
        TRY(plan_absorb(run->plan, unit, data, size, &how, fault));
    if (how == PLAN_UNKNOWN)
        return fault_set(fault, FAULT_FORMAT, "the journal names unit %" PRIu64 ", which the job does not have",
                         unit);
    ledger_finish(run->ledger, unit);
    return FAULT_NONE;
}

fault_code_t run_open_journal(run_t *run, fault_t *fault)
{
    char path[STORE_PATH_SIZE];
    uint64_t cut = 0;
    TRY(store_job_path(run->store, run->id, "journal", path, fault));
    TRY(journal_open(&run->journal, path, store_syncs(run->store), replay, run, &cut, fault));
    if (cut > 0)
        log_info("job %" PRIu64 ": %" PRIu64 " bytes of an unfinished record were cut off its journal", run->id,
                 cut);
    run->clock_runs = run->restored;
    run->late_left = LATE_UNITS;
    return FAULT_NONE;
}

/* Appends what is in memory only, in order. */
static fault_code_t append_waiting(run_t *run, fault_t *fault)
{
    for (size_t i = 0; i < run->waiting_count && run->waiting_unwritten > 0; i++) {
        run_waiting_t *waiting = &run->waiting[i];
        if (!waiting->data)
            continue;
        TRY(journal_append(run->journal, waiting->lease.unit, waiting->seconds, waiting->data, waiting->size,
                           fault));
        free(waiting->data);
        waiting->data = NULL;
        run->waiting_unwritten--;
    }
    return FAULT_NONE;
}

/* Makes everything that waits durable, by the journal or, after a failed sync, by a snapshot. */
static fault_code_t make_durable(run_t *run, double now, fault_t *fault)
{
    const bool due = run->need_snapshot || journal_bytes(run->journal) >= RUN_SNAPSHOT_BYTES ||
                     (now >= run->last_snapshot + RUN_SNAPSHOT_SECONDS && journal_bytes(run->journal) > 0);
    if (due) {
        const fault_code_t code = save_snapshot(run, fault);
        run->last_snapshot = now; /* also after a failure: the next attempt is not at once */
        if (code == FAULT_NONE || run->need_snapshot)
            return code;
        log_warn("job %" PRIu64 ": no snapshot: %s", run->id, fault->text);
    }
    TRY(append_waiting(run, fault));
    const fault_code_t code = journal_sync(run->journal, fault);
    if (code != FAULT_NONE)
        run->need_snapshot = true;
    return code;
}

double run_flush(run_t *run, double now, bool force, run_ack_t ack, void *context)
{
    if (run->state != RUN_RUNNING && run->state != RUN_FINISHING)
        return INFINITY;
    if (!run->journal || run->task != RUN_TASK_NONE)
        return INFINITY;
    if (run->waiting_count == 0 && !run->need_snapshot)
        return INFINITY;
    const bool pause = run->trouble[0] != '\0' && now < run->retry_at;
    const double due = store_syncs(run->store) ? run->last_sync + RUN_SYNC_SECONDS : now;
    if (!force && (pause || now < due))
        return pause ? run->retry_at : due;
    fault_t fault = {0};
    run->last_sync = now;
    if (make_durable(run, now, &fault) != FAULT_NONE) {
        say_trouble(run, "results cannot be written", fault.text);
        pause_after_trouble(run, now);
        return run->retry_at;
    }
    end_trouble(run);
    for (size_t i = 0; i < run->waiting_count; i++)
        ack(context, run->waiting[i].worker, &run->waiting[i].lease, run->waiting[i].outcome);
    run->waiting_count = 0;
    return INFINITY;
}
