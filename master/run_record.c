/* run_record.c: a run's state.json, and its state as told to people. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "master/run_internal.h"
#include "master/text.h"

enum { RECORD_LIMIT = 1 << 20 };

void run_note_progress(run_t *run)
{
    const plan_phase_t before = run->progress.phase;
    plan_progress(run->plan, &run->progress);
    snprintf(run->stopped_by, sizeof run->stopped_by, "%s",
             run->progress.stopped_by ? run->progress.stopped_by : "");
    if (before == PLAN_PILOT && run->progress.phase != PLAN_PILOT && run->pilot_seconds == 0)
        run->pilot_seconds = run->seconds;
    run->progress.stopped_by = run->stopped_by[0] ? run->stopped_by : NULL;
}

static const char *phase_name(plan_phase_t phase)
{
    switch (phase) {
    case PLAN_PILOT:
        return "pilot";
    case PLAN_RENDER:
        return "render";
    case PLAN_DONE:
        return "done";
    }
    return "unknown";
}

static void add_progress(json_t *json, const run_t *run)
{
    const plan_progress_t *progress = &run->progress;
    json_add_string(json, "phase", phase_name(progress->phase));
    json_add_number(json, "fraction", progress->fraction);
    json_add_number(json, "mutations", progress->mutations);
    json_add_number(json, "mutations_per_pixel", progress->mutations_per_pixel);
    json_add_number(json, "error", progress->error);
    json_add_number(json, "seconds", run->seconds);
    json_add_number(json, "seconds_left", progress->seconds_left);
    json_add_number(json, "units_out", (double)run_leases(run));
    json_add_number(json, "units_in", (double)progress->units_in);
    json_add_string(json, "stopped_by", run->stopped_by);
}

json_t *run_status(const run_t *run)
{
    char bundle[DIGEST_TEXT_SIZE];
    digest_print(&run->bundle_digest, bundle);
    json_t *json = json_new_object();
    json_add_u64(json, "id", run->id);
    json_add_string(json, "state", run_state_name(run->state));
    json_add_string(json, "scene", run->job.scene);
    json_add_string(json, "algorithm", settings_algorithm_name(run->job.settings.algorithm));
    json_add_string(json, "bundle", bundle);
    json_add_number(json, "submitted", run->submitted);
    json_add_number(json, "ended", run->ended > 0 ? run->ended : (double)NAN);
    add_progress(json, run);
    char text[FAULT_TEXT_SIZE];
    text_clean(text, sizeof text, run->failure);
    json_add_string(json, "failure", text);
    text_clean(text, sizeof text, run->trouble);
    json_add_string(json, "trouble", text);
    return json;
}

fault_code_t run_save_record(const run_t *run, fault_t *fault)
{
    json_t *json = run_status(run);
    json_add_number(json, "setup_seconds", run->setup_seconds);
    json_add_number(json, "pilot_seconds", run->pilot_seconds);
    char *text = json_print(json, true);
    json_destroy(&json);
    const fault_code_t code = store_write(run->store, run->id, "state.json", text, strlen(text), fault);
    free(text);
    return code;
}

static fault_code_t read_state(run_t *run, const json_t *json, fault_t *fault)
{
    const char *state = NULL, *bundle = NULL, *failure = "", *stopped_by = "";
    TRY(json_read_string_or(json, "", "state", &state, fault));
    TRY(json_read_string_or(json, "", "bundle", &bundle, fault));
    TRY(json_read_string_or(json, "", "failure", &failure, fault));
    TRY(json_read_string_or(json, "", "stopped_by", &stopped_by, fault));
    if (!bundle || !digest_parse(&run->bundle_digest, bundle))
        return fault_set(fault, FAULT_FORMAT, "bundle: expected 64 hexadecimal digits");
    for (int i = 0; state && i < RUN_STATES; i++)
        if (strcmp(state, run_state_name((run_state_t)i)) == 0) {
            run->state = (run_state_t)i;
            snprintf(run->failure, sizeof run->failure, "%s", failure);
            snprintf(run->stopped_by, sizeof run->stopped_by, "%s", stopped_by);
            return FAULT_NONE;
        }
    return fault_set(fault, FAULT_FORMAT, "state: found \"%s\", which is none", state ? state : "");
}

static fault_code_t read_progress(run_t *run, const json_t *json, fault_t *fault)
{
    plan_progress_t *progress = &run->progress;
    double units = 0;
    TRY(json_read_double_or(json, "", "submitted", 0, 1e12, &run->submitted, fault));
    TRY(json_read_double_or(json, "", "ended", 0, 1e12, &run->ended, fault));
    TRY(json_read_double_or(json, "", "pilot_seconds", 0, 1e12, &run->pilot_seconds, fault));
    TRY(json_read_double_or(json, "", "fraction", 0, 1, &progress->fraction, fault));
    TRY(json_read_double_or(json, "", "mutations", 0, 1e300, &progress->mutations, fault));
    TRY(json_read_double_or(json, "", "mutations_per_pixel", 0, 1e300, &progress->mutations_per_pixel, fault));
    TRY(json_read_double_or(json, "", "error", 0, 1e300, &progress->error, fault));
    TRY(json_read_double_or(json, "", "units_in", 0, 1e15, &units, fault));
    progress->units_in = (uint64_t)units;
    if (run_has_ended(run)) {
        TRY(json_read_double_or(json, "", "seconds", 0, 1e12, &run->seconds, fault));
        progress->phase = PLAN_DONE;
    }
    return FAULT_NONE;
}

fault_code_t run_read_record(run_t *run, fault_t *fault)
{
    uint8_t *text = NULL;
    size_t size = 0;
    json_t *json = NULL;
    TRY(store_read(run->store, run->id, "state.json", RECORD_LIMIT, &text, &size, fault));
    fault_code_t code = json_parse(&json, (const char *)text, size, fault);
    if (code == FAULT_NONE)
        code = read_state(run, json, fault);
    if (code == FAULT_NONE)
        code = read_progress(run, json, fault);
    json_destroy(&json);
    free(text);
    return fault_prefix(fault, code, "job %" PRIu64 ": state.json", run->id);
}
