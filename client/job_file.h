/* job_file.h: a job as a file: what it says, where its scene is, where its outputs go. */
#ifndef CLIENT_JOB_FILE_H
#define CLIENT_JOB_FILE_H

#include "plan/job.h"
#include "proto/message.h"

typedef struct job_file {
    job_t job;
    char scene[JOB_PATH_SIZE]; /* relative to the job file's folder, or absolute */
} job_file_t;

fault_code_t job_file_read(job_file_t *file, const char *path, fault_t *fault);

/* Where an output goes: the path that the job names; with a folder, that folder and the last part of the path.
 * *wanted is false if the job names none. */
fault_code_t job_file_output(const job_t *job, message_output_t output, const char *folder,
                             char path[JOB_PATH_SIZE], bool *wanted, fault_t *fault);
/* The same of the page, which is made of the report and the preview (report_page.h). */
fault_code_t job_file_page(const job_t *job, const char *folder, char path[JOB_PATH_SIZE], bool *wanted,
                           fault_t *fault);
/* "image", "preview", "report" */
const char *job_file_output_name(message_output_t output);
/* Makes the folder, if one is given, and sees that every wanted output's folder is there and can be written to. */
fault_code_t job_file_check_folders(const job_t *job, const char *folder, fault_t *fault);

#endif
