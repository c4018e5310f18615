/* garland render: a job from file to picture on this machine. */
#include <math.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "client/commands.h"
#include "client/interrupt.h"
#include "client/job_file.h"
#include "client/local_service.h"
#include "client/progress_bar.h"
#include "client/remote.h"
#include "client/scene_source.h"

static const char usage[] =
    "usage: garland render JOB.json [--workers N] [--out DIR] [--quiet]\n"
    "\n"
    "Renders a job on this machine: packs its scene, starts a master and workers of its own, shows the progress, "
    "writes\n"
    "the outputs. Nothing of it is left running, nor are temporary files, however it ends.\n"
    "\n"
    "  --workers N   worker processes, each with one thread (default: one a core)\n"
    "  --out DIR     write the outputs into DIR (made if missing), under the last part of the names that the job "
    "gives;\n"
    "                else they go where the job says, relative to the current folder\n"
    "  --quiet       no progress, no summary\n"
    "\n"
    "Exit status: 0 the outputs are written, 1 they are not, 2 wrong usage.\n";

enum { CARE_MS = 200 };

typedef struct render {
    job_file_t file;
    const char *out;
    int workers;
    bool quiet;
    double began;
    local_service_t *service;
    link_t *link;
    uint64_t job;
    progress_bar_t bar;
    json_t *last;  /* the latest status */
    bool troubled; /* outputs could not be written: what there is, is kept */
} render_t;

static int cores(void)
{
    cpu_set_t set;
    return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

static fault_code_t check_interrupt(fault_t *fault)
{
    return interrupt_happened() ? fault_set(fault, FAULT_CANCELLED, "interrupted") : FAULT_NONE;
}

static fault_code_t start(render_t *render, fault_t *fault)
{
    digest_t digest;
    TRY(job_file_check_folders(&render->file.job, render->out, fault));
    TRY(local_service_new(&render->service, fault));
    TRY(scene_source_bundle(render->file.scene, local_service_bundle(render->service), stderr, &digest, NULL,
                            fault));
    TRY(check_interrupt(fault));
    TRY(local_service_adopt_bundle(render->service, &digest, fault));
    TRY(local_service_start(render->service, render->workers, fault));
    TRY(link_open(&render->link, local_service_address(render->service), &(link_options_t){0}, fault));
    char *text = job_print(&render->file.job);
    if (!text)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job's text");
    const fault_code_t code =
        link_submit(render->link, text, local_service_adopted(render->service), &render->job, fault);
    free(text);
    TRY(code);
    return link_subscribe(render->link, render->job, fault);
}

static void take_progress(render_t *render, const char *text)
{
    json_t *status = NULL;
    if (json_parse(&status, text, strlen(text), NULL) != FAULT_NONE)
        return;
    json_destroy(&render->last);
    render->last = status;
    const json_t *trouble = json_get(status, "trouble");
    const char *words = trouble ? json_string(trouble) : NULL;
    render->troubled = words && words[0];
    progress_bar_show(&render->bar, status);
}

/* Until the job has ended. */
static fault_code_t watch(render_t *render, fault_t *fault)
{
    for (;;) {
        transport_event_t event;
        bool got;
        const fault_code_t heard = link_next(render->link, CARE_MS, &event, &got, fault);
        if (heard == FAULT_CANCELLED)
            return heard;
        TRY(local_service_care(render->service, fault)); /* its words say more than those of a broken connection */
        TRY(heard);
        if (!got)
            continue;
        if (event.message.type == MESSAGE_PROGRESS) {
            take_progress(render, event.message.report.text);
            continue;
        }
        if (event.message.job_end.state == MESSAGE_END_FINISHED)
            return FAULT_NONE;
        return fault_set(fault, FAULT_IO, "the job %s: %s",
                         event.message.job_end.state == MESSAGE_END_FAILED ? "failed" : "was cancelled",
                         event.message.job_end.text);
    }
}

static double number(const render_t *render, const char *name)
{
    const json_t *value = render->last ? json_get(render->last, name) : NULL;
    return value && json_is_number(value) ? json_number(value) : (double)NAN;
}

static void summarise(const render_t *render)
{
    char took[32], error[48] = "";
    progress_bar_time(clock_now() - render->began, took, sizeof took);
    if (isfinite(number(render, "error")))
        snprintf(error, sizeof error, ", estimated error %.2f %%", 100 * number(render, "error"));
    printf("Rendered in %s: %.4g mutations per pixel%s\n", took, number(render, "mutations_per_pixel"), error);
}

static fault_code_t deliver(render_t *render, fault_t *fault)
{
    if (!render->quiet)
        summarise(render);
    const fault_code_t code =
        remote_fetch_outputs(render->link, render->job, &render->file.job, render->out, !render->quiet, fault);
    render->troubled = code != FAULT_NONE;
    return code;
}

/* What a failed render leaves behind, if there is anything worth keeping. */
static void tell_kept(const render_t *render)
{
    fprintf(stderr,
            "garland: what is rendered is kept in %s/jobs/%llu\n"
            "garland: to finish or fetch it: garland-master --listen tcp://127.0.0.1:* --state %s, and garland "
            "fetch %llu "
            "--master ADDR\n",
            local_service_state(render->service), (unsigned long long)render->job,
            local_service_state(render->service), (unsigned long long)render->job);
}

static int run(render_t *render)
{
    fault_t fault = {0};
    render->began = clock_now();
    progress_bar_begin(&render->bar, render->quiet);
    fault_code_t code = start(render, &fault);
    if (code == FAULT_NONE)
        code = watch(render, &fault);
    progress_bar_end(&render->bar);
    if (code == FAULT_NONE)
        code = deliver(render, &fault);
    if (code != FAULT_NONE)
        remote_fail(&fault);
    const bool keep = code != FAULT_NONE && render->troubled && render->job != 0;
    if (keep)
        tell_kept(render);
    link_close(&render->link);
    local_service_stop(&render->service, keep);
    json_destroy(&render->last);
    return code == FAULT_NONE ? STATUS_SUCCESS : STATUS_FAILURE;
}

int command_render(int argc, char **argv)
{
    render_t *render = calloc(1, sizeof *render);
    const char *job = NULL;
    fault_t fault = {0};
    int status = STATUS_FAILURE;
    if (!render) {
        fprintf(stderr, "garland: out of memory\n");
        return status;
    }
    const option_t list[] = {{"workers", OPTION_COUNT, &render->workers},
                             {"out", OPTION_TEXT, &render->out},
                             {"quiet", OPTION_FLAG, &render->quiet},
                             {0}};
    if (options_parse("render", usage, list, argc, argv, &job, 1, 1, &status)) {
        interrupt_catch();
        if (render->workers == 0)
            render->workers = cores();
        if (job_file_read(&render->file, job, &fault) != FAULT_NONE)
            status = remote_fail(&fault);
        else
            status = run(render);
    }
    free(render);
    return status;
}
