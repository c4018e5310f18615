/* job.h: a job as people write it (docs/jobs.md) and as the service runs it.
 *
 *     {"scene": "x.pbrt", "film": {"width": 320, "height": 320, "filter": "box"}, "algorithm": "mmlt",
 *      "max_path_length": 12, "seed": "1", "stop": {"mutations_per_pixel": 100, "seconds": 60, "error": 0.02},
 *      "output": {"image": "o.exr", "preview": "o.png", "report": "o.json"}}
 *
 * Every field but "scene" has a default; unknown fields, wrong types and numbers out of range are refused with the
 * field's path and what was expected. */
#ifndef PLAN_JOB_H
#define PLAN_JOB_H

#include "base/json.h"
#include "chain/settings.h"

enum { JOB_PATH_SIZE = 4096 };

typedef struct job_stop {
    double mutations_per_pixel; /* 0: no such rule. For pt and bdpt: samples per pixel */
    double seconds;             /* of wall time since the job began; 0: none */
    double error;               /* sqrt(relMSE); 0: none */
} job_stop_t;

typedef struct job {
    char scene[JOB_PATH_SIZE]; /* as written; relative to the job file's folder */
    settings_t settings;
    bool automatic;  /* the algorithm is "auto", or none is named */
    job_stop_t stop; /* at least one rule; {"seconds": 30} if the job names none */
    char image[JOB_PATH_SIZE], preview[JOB_PATH_SIZE], report[JOB_PATH_SIZE], page[JOB_PATH_SIZE];
    /* of outputs; empty: not wanted. Default: image "image.exr" alone */
    double preview_exposure; /* in stops; 0 */
} job_t;

/* Parses and checks. `name` is used in messages (the file's name). */
fault_code_t job_parse(job_t *job, const char *text, size_t length, const char *name, fault_t *fault);
/* The job as canonical JSON text with every default filled in (no two spellings of one job); caller frees. */
char *job_print(const job_t *job);

#endif
