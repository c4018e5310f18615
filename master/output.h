/* output.h: a finished plan as files in the job's folder: image.exr, preview.png, report.json, as far as the job
 * wants them. The image's header carries the job and the report. */
#ifndef MASTER_OUTPUT_H
#define MASTER_OUTPUT_H

#include "master/store.h"
#include "plan/plan.h"

/* What the master knows of a job and the plan does not. */
typedef struct output_service {
    double setup_seconds, pilot_seconds, render_seconds; /* wall time by phase */
    double submitted;                                    /* seconds since 1970 */
    uint64_t workers;                                    /* processes that contributed */
    uint64_t attempts_lost, attempts_failed;
} output_service_t;

/* The file in the job's folder, "image.exr"; null for a number that is no message_output_t. */
const char *output_file(unsigned output);
/* Whether the job asks for it: by name, or for a page, which clients make of preview and report. */
bool output_wanted(const job_t *job, unsigned output);

/* Writes all that is wanted; files that an earlier call has written are written again. Any thread that owns the
 * plan. */
fault_code_t output_write(const store_t *store, uint64_t id, const job_t *job, const char *job_text,
                          const plan_t *plan, const output_service_t *service, fault_t *fault);

#endif
