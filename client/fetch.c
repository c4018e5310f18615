/* garland fetch: a job's outputs from a master. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "client/commands.h"
#include "client/interrupt.h"
#include "client/job_file.h"
#include "client/progress_bar.h"
#include "client/remote.h"

static const char usage[] =
    "usage: garland fetch ID --master ADDR [--out DIR] [--wait]\n"
    "\n"
    "Writes a finished job's outputs where the job says, relative to the current folder.\n"
    "\n" REMOTE_USAGE
    "  --out DIR          into DIR (made if missing), under the last part of the names that the job gives\n"
    "  --wait             until the job has ended; a master that is restarted meanwhile is waited for\n";

enum { LOOK_MS = 1000, PATIENCE = 30 /* connections in vain, of LINK_TIMEOUT_MS each, before giving up */ };

/* The state of the job: "running"; copied. */
static fault_code_t look(link_t *link, uint64_t job, progress_bar_t *bar, char *state, size_t size, fault_t *fault)
{
    json_t *json;
    TRY(link_status(link, job, &json, fault));
    const json_t *jobs = json_get(json, "jobs");
    const json_t *status = jobs && json_size(jobs) == 1 ? json_at(jobs, 0) : NULL;
    const json_t *value = status ? json_get(status, "state") : NULL;
    const char *text = value ? json_string(value) : NULL;
    snprintf(state, size, "%s", text ? text : "");
    if (status)
        progress_bar_show(bar, status);
    json_destroy(&json);
    return text ? FAULT_NONE : fault_set(fault, FAULT_PROTOCOL, "the master's status names no state");
}

static bool has_ended(const char *state)
{
    return strcmp(state, "done") == 0 || strcmp(state, "failed") == 0 || strcmp(state, "cancelled") == 0;
}

/* Connects again, as often as patience allows. */
static fault_code_t reconnect(remote_t *remote, fault_t *fault)
{
    const link_options_t options = {.token = remote->token, .server_key = remote->server_key};
    fault_code_t code = FAULT_TIMEOUT;
    for (int i = 0; i < PATIENCE && code != FAULT_NONE && !interrupt_happened(); i++) {
        link_close(&remote->link);
        usleep(LOOK_MS * 1000);
        code = link_open(&remote->link, remote->address, &options, fault);
    }
    return code;
}

static fault_code_t wait_for_end(remote_t *remote, uint64_t job, fault_t *fault)
{
    char state[32];
    progress_bar_t bar;
    fault_code_t code;
    progress_bar_begin(&bar, false);
    for (;;) {
        code = look(remote->link, job, &bar, state, sizeof state, fault);
        if (code == FAULT_NONE && has_ended(state))
            break;
        if (code == FAULT_TIMEOUT || code == FAULT_IO || code == FAULT_PROTOCOL)
            code = reconnect(remote, fault);
        if (code != FAULT_NONE)
            break;
        usleep(LOOK_MS * 1000);
        if (interrupt_happened()) {
            code = fault_set(fault, FAULT_CANCELLED, "interrupted");
            break;
        }
    }
    progress_bar_end(&bar);
    return code;
}

static fault_code_t fetch(remote_t *remote, uint64_t job, const char *folder, bool wait, fault_t *fault)
{
    if (wait)
        TRY(wait_for_end(remote, job, fault));
    char *text;
    TRY(link_job_text(remote->link, job, &text, fault));
    job_t *description = malloc(sizeof *description);
    fault_code_t code = description ? job_parse(description, text, strlen(text), "job", fault)
                                    : fault_set(fault, FAULT_MEMORY, "out of memory");
    free(text);
    if (code == FAULT_NONE)
        code = job_file_check_folders(description, folder, fault);
    if (code == FAULT_NONE)
        code = remote_fetch_outputs(remote->link, job, description, folder, true, fault);
    free(description);
    return code;
}

int command_fetch(int argc, char **argv)
{
    remote_t remote = {0};
    const char *id, *folder = NULL;
    bool wait = false;
    int status;
    fault_t fault = {0};
    const option_t list[] = {
        REMOTE_OPTIONS(remote), {"out", OPTION_TEXT, &folder}, {"wait", OPTION_FLAG, &wait}, {0}};
    if (!options_parse("fetch", usage, list, argc, argv, &id, 1, 1, &status))
        return status;
    const uint64_t job = remote_job("fetch", id);
    if (job == 0)
        return STATUS_USAGE;
    if (!remote_open(&remote, "fetch", &status))
        return status;
    status = STATUS_SUCCESS;
    if (fetch(&remote, job, folder, wait, &fault) != FAULT_NONE)
        status = remote_fail(&fault);
    remote_close(&remote);
    return status;
}
