/* local_run.c: start, watch and end of a job on a service of its own. */
#include "client/local_run.h"

#include <sched.h>
#include <stdlib.h>
#include <string.h>

#include "client/interrupt.h"
#include "client/scene_source.h"

enum { CARE_MS = 200 };

int local_run_cores(void)
{
    cpu_set_t set;
    return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

static fault_code_t check_interrupt(fault_t *fault)
{
    return interrupt_happened() ? fault_set(fault, FAULT_CANCELLED, "interrupted") : FAULT_NONE;
}

fault_code_t local_run_start(local_run_t *run, fault_t *fault)
{
    digest_t digest;
    TRY(local_service_new(&run->service, fault));
    TRY(scene_source_bundle(run->file.scene, local_service_bundle(run->service), stderr, &digest, NULL, fault));
    TRY(check_interrupt(fault));
    TRY(local_service_adopt_bundle(run->service, &digest, fault));
    TRY(local_service_start(run->service, run->workers, fault));
    TRY(link_open(&run->link, local_service_address(run->service), &(link_options_t){0}, fault));
    char *text = job_print(&run->file.job);
    if (!text)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job's text");
    const fault_code_t code = link_submit(run->link, text, local_service_adopted(run->service), &run->job, fault);
    free(text);
    TRY(code);
    return link_subscribe(run->link, run->job, fault);
}

static void take_progress(local_run_t *run, const char *text)
{
    json_t *status = NULL;
    if (json_parse(&status, text, strlen(text), NULL) != FAULT_NONE)
        return;
    json_destroy(&run->last);
    run->last = status;
    const json_t *trouble = json_get(status, "trouble");
    const char *words = trouble ? json_string(trouble) : NULL;
    run->troubled = words && words[0];
    progress_bar_show(&run->bar, status);
}

fault_code_t local_run_watch(local_run_t *run, fault_t *fault)
{
    for (;;) {
        transport_event_t event;
        bool got;
        const fault_code_t heard = link_next(run->link, CARE_MS, &event, &got, fault);
        if (heard == FAULT_CANCELLED)
            return heard;
        TRY(local_service_care(run->service, fault)); /* its words say more than those of a broken connection */
        TRY(heard);
        if (!got)
            continue;
        if (event.message.type == MESSAGE_PROGRESS) {
            take_progress(run, event.message.report.text);
            continue;
        }
        if (event.message.job_end.state == MESSAGE_END_FINISHED)
            return FAULT_NONE;
        return fault_set(fault, FAULT_IO, "the job %s: %s",
                         event.message.job_end.state == MESSAGE_END_FAILED ? "failed" : "was cancelled",
                         event.message.job_end.text);
    }
}

void local_run_end(local_run_t *run, bool keep)
{
    link_close(&run->link);
    local_service_stop(&run->service, keep);
    json_destroy(&run->last);
}
