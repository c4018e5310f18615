/* garland render: a job from file to picture on this machine. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/clock.h"
#include "client/commands.h"
#include "client/interrupt.h"
#include "client/local_run.h"
#include "client/remote.h"

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

typedef struct render {
    local_run_t run;
    const char *out;
    bool quiet;
    double began;
} render_t;

static double number(const render_t *render, const char *name)
{
    const json_t *value = render->run.last ? json_get(render->run.last, name) : NULL;
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
    const fault_code_t code = remote_fetch_outputs(render->run.link, render->run.job, &render->run.file.job,
                                                   render->out, !render->quiet, fault);
    render->run.troubled = code != FAULT_NONE;
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
            local_service_state(render->run.service), (unsigned long long)render->run.job,
            local_service_state(render->run.service), (unsigned long long)render->run.job);
}

static int run(render_t *render)
{
    fault_t fault = {0};
    render->began = clock_now();
    progress_bar_begin(&render->run.bar, render->quiet);
    fault_code_t code = job_file_check_folders(&render->run.file.job, render->out, &fault);
    if (code == FAULT_NONE)
        code = local_run_start(&render->run, &fault);
    if (code == FAULT_NONE)
        code = local_run_watch(&render->run, &fault);
    progress_bar_end(&render->run.bar);
    if (code == FAULT_NONE)
        code = deliver(render, &fault);
    if (code != FAULT_NONE)
        remote_fail(&fault);
    const bool keep = code != FAULT_NONE && render->run.troubled && render->run.job != 0;
    if (keep)
        tell_kept(render);
    local_run_end(&render->run, keep);
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
    const option_t list[] = {{"workers", OPTION_COUNT, &render->run.workers},
                             {"out", OPTION_TEXT, &render->out},
                             {"quiet", OPTION_FLAG, &render->quiet},
                             {0}};
    if (options_parse("render", usage, list, argc, argv, &job, 1, 1, &status)) {
        interrupt_catch();
        if (render->run.workers == 0)
            render->run.workers = local_run_cores();
        if (job_file_read(&render->run.file, job, &fault) != FAULT_NONE)
            status = remote_fail(&fault);
        else
            status = run(render);
    }
    free(render);
    return status;
}
