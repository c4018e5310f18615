/* garland status: jobs and workers of a master. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "client/commands.h"
#include "client/progress_bar.h"
#include "client/remote.h"

static const char usage[] = "usage: garland status [ID] --master ADDR [--json]\n"
                            "\n"
                            "Shows the jobs of a master, or one, and its workers.\n"
                            "\n" REMOTE_USAGE "  --json             as JSON (docs/service.md)\n";

static const char *text_of(const json_t *object, const char *name)
{
    const json_t *value = json_get(object, name);
    const char *text = value ? json_string(value) : NULL;
    return text ? text : "";
}

static double number(const json_t *object, const char *name)
{
    const json_t *value = json_get(object, name);
    return value && json_is_number(value) ? json_number(value) : (double)NAN;
}

static void print_job(const json_t *job)
{
    char took[32], left[32], error[32] = "-";
    progress_bar_time(number(job, "seconds"), took, sizeof took);
    progress_bar_time(number(job, "seconds_left"), left, sizeof left);
    if (isfinite(number(job, "error")))
        snprintf(error, sizeof error, "%.2f %%", 100 * number(job, "error"));
    printf("%-16s %-10s %-7s %5.1f %%  %10.4g  %9s  %8s  %8s  %s\n", text_of(job, "id"), text_of(job, "state"),
           text_of(job, "phase"), 100 * number(job, "fraction"), number(job, "mutations_per_pixel"), error, took,
           left, text_of(job, "scene"));
    if (text_of(job, "failure")[0])
        printf("    failed: %s\n", text_of(job, "failure"));
    if (text_of(job, "trouble")[0])
        printf("    held up: %s\n", text_of(job, "trouble"));
}

static void print_worker(const json_t *worker)
{
    printf("%-32s %8.0f %8.0f  %-7s %10.0f  %6.0f  %8.1f s ago\n", text_of(worker, "host"), number(worker, "pid"),
           number(worker, "threads"), text_of(worker, "state"), number(worker, "units_done"),
           number(worker, "units_failed"), number(worker, "last_heard_seconds"));
}

static void print_status(const json_t *status)
{
    const json_t *jobs = json_get(status, "jobs"), *workers = json_get(status, "workers");
    const size_t job_count = jobs ? json_size(jobs) : 0, worker_count = workers ? json_size(workers) : 0;
    printf("%-16s %-10s %-7s %7s  %10s  %9s  %8s  %8s  %s\n", "JOB", "STATE", "PHASE", "DONE", "MUT/PIXEL", "ERROR",
           "TIME", "LEFT", "SCENE");
    for (size_t i = 0; i < job_count; i++)
        print_job(json_at(jobs, i));
    if (job_count == 0)
        printf("no jobs\n");
    printf("\n%-32s %8s %8s  %-7s %10s  %6s  %s\n", "WORKER", "PID", "THREADS", "STATE", "UNITS", "FAILED",
           "HEARD");
    for (size_t i = 0; i < worker_count; i++)
        print_worker(json_at(workers, i));
    if (worker_count == 0)
        printf("no workers\n");
}

int command_status(int argc, char **argv)
{
    remote_t remote = {0};
    const char *id;
    bool as_json = false;
    int status;
    const option_t list[] = {REMOTE_OPTIONS(remote), {"json", OPTION_FLAG, &as_json}, {0}};
    if (!options_parse("status", usage, list, argc, argv, &id, 0, 1, &status))
        return status;
    const uint64_t job = id ? remote_job("status", id) : 0;
    if (id && job == 0)
        return STATUS_USAGE;
    if (!remote_open(&remote, "status", &status))
        return status;
    json_t *json = NULL;
    fault_t fault = {0};
    status = STATUS_SUCCESS;
    if (link_status(remote.link, job, &json, &fault) != FAULT_NONE) {
        status = remote_fail(&fault);
    } else if (as_json) {
        char *text = json_print(json, true);
        puts(text);
        free(text);
    } else {
        print_status(json);
    }
    json_destroy(&json);
    remote_close(&remote);
    return status;
}
