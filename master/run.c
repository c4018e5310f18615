#include "master/run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "master/run_internal.h"

static const double output_pause_min = 1, output_pause_max = 30;

const char *run_state_name(run_state_t state)
{
    static const char *const names[RUN_STATES] = {"queued", "running", "finishing", "done", "failed", "cancelled"};
    return (unsigned)state < RUN_STATES ? names[state] : "unknown";
}

static double wall_clock(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Takes the job's text and makes it canonical. */
static fault_code_t take_text(run_t *run, const char *text, fault_t *fault)
{
    TRY(job_parse(&run->job, text, strlen(text), "job", fault));
    run->text = job_print(&run->job);
    if (!run->text)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job's text");
    digest_of(&run->text_digest, run->text, strlen(run->text));
    return FAULT_NONE;
}

static run_t *run_allocate(store_t *store, uint64_t id)
{
    run_t *run = calloc(1, sizeof *run);
    if (!run)
        return NULL;
    run->id = id;
    run->store = store;
    run->options.wake_fd = -1;
    run->progress.error = run->progress.seconds_left = NAN;
    atomic_init(&run->task_done, false);
    return run;
}

fault_code_t run_new(run_t **out, store_t *store, uint64_t id, const char *text, const digest_t *bundle,
                     double submitted, fault_t *fault)
{
    *out = NULL;
    run_t *run = run_allocate(store, id);
    if (!run)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job");
    run->bundle_digest = *bundle;
    run->submitted = submitted;
    fault_code_t code = take_text(run, text, fault);
    if (code == FAULT_NONE)
        code = store_make_job(store, id, fault);
    if (code == FAULT_NONE) {
        code = store_write(store, id, "job.json", run->text, strlen(run->text), fault);
        if (code == FAULT_NONE)
            code = run_save_record(run, fault);
        if (code == FAULT_NONE)
            code = store_sync_job(store, id, fault);
        if (code != FAULT_NONE)
            store_remove_job(store, id);
    }
    if (code != FAULT_NONE) {
        run_destroy(&run);
        return code;
    }
    *out = run;
    return FAULT_NONE;
}

fault_code_t run_load(run_t **out, store_t *store, uint64_t id, fault_t *fault)
{
    *out = NULL;
    run_t *run = run_allocate(store, id);
    if (!run)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job");
    uint8_t *text = NULL;
    size_t size = 0;
    fault_code_t code = run_read_record(run, fault);
    if (code == FAULT_NONE)
        code = store_read(store, id, "job.json", MESSAGE_MAX_TEXT, &text, &size, fault);
    if (code == FAULT_NONE && strlen((const char *)text) != size)
        code = fault_set(fault, FAULT_FORMAT, "job.json: a zero byte");
    if (code == FAULT_NONE)
        code = take_text(run, (const char *)text, fault);
    free(text);
    if (code != FAULT_NONE) {
        run_destroy(&run);
        return code;
    }
    if (run->state == RUN_RUNNING || run->state == RUN_FINISHING)
        run->state = RUN_QUEUED;
    *out = run;
    return FAULT_NONE;
}

void run_release(run_t *run)
{
    journal_close(&run->journal);
    ledger_destroy(&run->ledger);
    plan_destroy(&run->plan);
    bundle_destroy(&run->bundle);
    for (size_t i = 0; i < run->waiting_count; i++)
        free(run->waiting[i].data);
    free(run->waiting);
    run->waiting = NULL;
    run->waiting_count = run->waiting_capacity = run->waiting_unwritten = 0;
    free(run->contributors);
    run->contributors = NULL;
}

void run_destroy(run_t **pointer)
{
    run_t *run = *pointer;
    if (!run)
        return;
    if (run->task != RUN_TASK_NONE)
        pthread_join(run->thread, NULL);
    run_release(run);
    free(run->text);
    free(run);
    *pointer = NULL;
}

uint64_t run_id(const run_t *run)
{
    return run->id;
}

run_state_t run_get_state(const run_t *run)
{
    return run->state;
}

bool run_is_started(const run_t *run)
{
    return run->started && !run_has_ended(run);
}

bool run_has_ended(const run_t *run)
{
    return run->state >= RUN_DONE;
}

double run_submitted(const run_t *run)
{
    return run->submitted;
}

const job_t *run_job(const run_t *run)
{
    return &run->job;
}

const char *run_text(const run_t *run)
{
    return run->text;
}

const digest_t *run_text_digest(const run_t *run)
{
    return &run->text_digest;
}

const digest_t *run_bundle_digest(const run_t *run)
{
    return &run->bundle_digest;
}

const char *run_failure(const run_t *run)
{
    return run->failure;
}

/* ---- background work ---- */

/* Bundle, plan (new, or from the snapshot) and the journal's results. */
static fault_code_t set_up(run_t *run, fault_t *fault)
{
    const double began = clock_now();
    char path[STORE_PATH_SIZE];
    TRY(store_bundle_path(run->store, &run->bundle_digest, path, fault));
    TRY(bundle_open(&run->bundle, path, fault));
    const scene_t *scene = bundle_scene(run->bundle);
    run->ledger = ledger_new(run->options.first_attempt, run->options.lease_seconds);
    if (!run->ledger)
        return fault_set(fault, FAULT_MEMORY, "no memory for a ledger");
    uint8_t *data = NULL;
    size_t size = 0, offset = 0;
    TRY(run_read_snapshot(run, &data, &size, &offset, fault));
    fault_code_t code;
    if (data)
        code = plan_restore(&run->plan, &run->job, scene, data + offset, size - offset, fault);
    else
        code = plan_new(&run->plan, &run->job, scene, fault);
    free(data);
    TRY(code);
    TRY(run_open_journal(run, fault));
    run->setup_took = clock_now() - began;
    return FAULT_NONE;
}

static fault_code_t write_outputs(run_t *run, fault_t *fault)
{
    const output_service_t service = {.setup_seconds = run->setup_seconds,
                                      .pilot_seconds = run->pilot_seconds,
                                      .render_seconds = run->seconds - run->pilot_seconds,
                                      .submitted = run->submitted,
                                      .workers = run->contributor_count,
                                      .attempts_lost = run->attempts_lost,
                                      .attempts_failed = run->attempts_failed};
    return output_write(run->store, run->id, &run->job, run->text, run->plan, &service, fault);
}

static void *task_main(void *argument)
{
    run_t *run = argument;
    memset(&run->task_fault, 0, sizeof run->task_fault);
    if (run->task == RUN_TASK_SETUP)
        set_up(run, &run->task_fault);
    else
        write_outputs(run, &run->task_fault);
    atomic_store_explicit(&run->task_done, true, memory_order_release);
    const uint64_t one = 1;
    if (run->options.wake_fd >= 0 && write(run->options.wake_fd, &one, sizeof one) != sizeof one)
        log_debug("job %llu: the loop was awake already", (unsigned long long)run->id);
    return NULL;
}

static void begin_task(run_t *run, run_task_t task)
{
    run->task = task;
    atomic_store_explicit(&run->task_done, false, memory_order_relaxed);
    if (pthread_create(&run->thread, NULL, task_main, run) != 0) {
        run->task = RUN_TASK_NONE;
        run_fail(run, "cannot start a thread");
    }
}

void run_start(run_t *run, const run_options_t *options)
{
    run->options = *options;
    run->started = true;
    begin_task(run, RUN_TASK_SETUP);
}

/* ---- states ---- */

void run_set_state(run_t *run, run_state_t state)
{
    run->state = state;
    if (run_has_ended(run)) {
        run->ended = wall_clock();
        run->trouble[0] = '\0';
    }
    fault_t fault = {0};
    if (run_save_record(run, &fault))
        log_warn("job %llu: cannot note that it is %s: %s", (unsigned long long)run->id, run_state_name(state),
                 fault.text);
}

/* The end of a job: its outputs and its record stay. What a set-up could not read stays too, for people to look at.
 */
static void end_run(run_t *run, run_state_t state)
{
    const bool unread = state == RUN_FAILED && run->last_tick == 0;
    if (run->plan)
        run_note_progress(run);
    run_release(run);
    run_set_state(run, state);
    if (!unread) {
        store_remove(run->store, run->id, "snapshot");
        store_remove(run->store, run->id, "journal");
    }
    log_info("job %llu: %s%s%s", (unsigned long long)run->id, run_state_name(state), run->failure[0] ? ": " : "",
             run->failure);
}

void run_fail(run_t *run, const char *text)
{
    snprintf(run->failure, sizeof run->failure, "%s", text);
    end_run(run, RUN_FAILED);
}

void run_cancel(run_t *run)
{
    if (run_has_ended(run))
        return;
    if (run->task != RUN_TASK_NONE)
        run->cancel_wanted = true;
    else
        end_run(run, RUN_CANCELLED);
}

static void end_setup(run_t *run, double now)
{
    if (run->task_fault.code != FAULT_NONE) {
        run_fail(run, run->task_fault.text);
        return;
    }
    run->setup_seconds = run->setup_took;
    run->seconds = run->replayed_seconds;
    run->last_tick = run->last_snapshot = run->last_sync = now;
    run_note_progress(run);
    run_set_state(run, RUN_RUNNING);
}

static void end_output(run_t *run, double now)
{
    if (run->task_fault.code == FAULT_NONE) {
        end_run(run, RUN_DONE);
        return;
    }
    if (run->task_fault.code != FAULT_IO) {
        run_fail(run, run->task_fault.text);
        return;
    }
    if (!run->trouble[0])
        log_warn("job %llu: cannot write its outputs, will try again: %s", (unsigned long long)run->id,
                 run->task_fault.text);
    snprintf(run->trouble, sizeof run->trouble, "cannot write the outputs: %.900s", run->task_fault.text);
    run->output_pause = fmin(output_pause_max, fmax(output_pause_min, 2 * run->output_pause));
    run->output_retry_at = now + run->output_pause;
}

/* Takes note of the thread's end. */
static void collect_task(run_t *run, double now)
{
    if (!atomic_load_explicit(&run->task_done, memory_order_acquire))
        return;
    pthread_join(run->thread, NULL);
    const run_task_t task = run->task;
    run->task = RUN_TASK_NONE;
    if (run->cancel_wanted)
        end_run(run, RUN_CANCELLED);
    else if (task == RUN_TASK_SETUP)
        end_setup(run, now);
    else
        end_output(run, now);
}

static void tick(run_t *run, double now, bool working)
{
    if (run->clock_runs && working)
        run->seconds += now - run->last_tick;
    run->last_tick = now;
    plan_check_stop(run->plan, run->seconds);
    run_note_progress(run);
    if (plan_finished(run->plan))
        run_set_state(run, RUN_FINISHING);
}

bool run_poll(run_t *run, double now, bool working)
{
    const run_state_t before = run->state;
    if (run->task != RUN_TASK_NONE)
        collect_task(run, now);
    if (run->state == RUN_RUNNING)
        tick(run, now, working);
    if (run->state == RUN_FINISHING && run->task == RUN_TASK_NONE && now >= run->output_retry_at &&
        run->waiting_count == 0)
        begin_task(run, RUN_TASK_OUTPUT);
    return run->state != before;
}
