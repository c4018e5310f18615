/* local_run.h: one job on a service of its own on this machine, from start to end: what `garland render` and
 * `garland plan` have in common.
 *
 *     local_run_t run = {.file = ..., .workers = local_run_cores()};
 *     progress_bar_begin(&run.bar, quiet);
 *     code = local_run_start(&run, fault);
 *     if (!code) code = local_run_watch(&run, fault);
 *     progress_bar_end(&run.bar);
 *     ... outputs from run.link ...
 *     local_run_end(&run, keep);
 *
 * One thread. interrupt_catch is the caller's to call first. */
#ifndef CLIENT_LOCAL_RUN_H
#define CLIENT_LOCAL_RUN_H

#include "client/job_file.h"
#include "client/link.h"
#include "client/local_service.h"
#include "client/progress_bar.h"

typedef struct local_run {
    job_file_t file;
    int workers;
    local_service_t *service;
    link_t *link;
    uint64_t job; /* 0: not submitted */
    progress_bar_t bar;
    json_t *last;  /* the latest status */
    bool troubled; /* outputs could not be written: what there is, is kept */
} local_run_t;

/* Processors that this process may use. */
int local_run_cores(void);

/* Packs the scene, starts master and workers, submits the job and follows it. */
fault_code_t local_run_start(local_run_t *run, fault_t *fault);
/* Returns when the job has ended; a fault unless it finished. */
fault_code_t local_run_watch(local_run_t *run, fault_t *fault);
/* Stops all that was started; removes the private folder unless `keep`. Also after a start that failed. */
void local_run_end(local_run_t *run, bool keep);

#endif
