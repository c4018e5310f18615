#include "client/job_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"

fault_code_t job_file_read(job_file_t *file, const char *path, fault_t *fault)
{
    uint8_t *text;
    size_t size;
    char folder[JOB_PATH_SIZE];
    TRY(file_read(path, MESSAGE_MAX_TEXT, &text, &size, fault));
    const fault_code_t code = job_parse(&file->job, (const char *)text, size, path, fault);
    free(text);
    TRY(code);
    TRY(file_folder_of(folder, sizeof folder, path, fault));
    return file_join(file->scene, sizeof file->scene, folder, file->job.scene, fault);
}

const char *job_file_output_name(message_output_t output)
{
    switch (output) {
    case MESSAGE_OUTPUT_IMAGE:
        return "image";
    case MESSAGE_OUTPUT_PREVIEW:
        return "preview";
    case MESSAGE_OUTPUT_REPORT:
        return "report";
    }
    return "output";
}

static fault_code_t place_of(const char *name, const char *folder, char path[JOB_PATH_SIZE], bool *wanted,
                             fault_t *fault)
{
    *wanted = name[0] != '\0';
    path[0] = '\0';
    if (!*wanted)
        return FAULT_NONE;
    if (!folder) {
        snprintf(path, JOB_PATH_SIZE, "%s", name);
        return FAULT_NONE;
    }
    const char *last = strrchr(name, '/');
    return file_join(path, JOB_PATH_SIZE, folder, last ? last + 1 : name, fault);
}

fault_code_t job_file_output(const job_t *job, message_output_t output, const char *folder,
                             char path[JOB_PATH_SIZE], bool *wanted, fault_t *fault)
{
    return place_of(output == MESSAGE_OUTPUT_IMAGE     ? job->image
                    : output == MESSAGE_OUTPUT_PREVIEW ? job->preview
                                                       : job->report,
                    folder, path, wanted, fault);
}

fault_code_t job_file_page(const job_t *job, const char *folder, char path[JOB_PATH_SIZE], bool *wanted,
                           fault_t *fault)
{
    return place_of(job->page, folder, path, wanted, fault);
}

/* Whether an output's folder can be written to. */
static fault_code_t check_folder(const char *path, const char *name, fault_t *fault)
{
    char place[JOB_PATH_SIZE];
    TRY(file_folder_of(place, sizeof place, path, fault));
    if (access(place, W_OK | X_OK) != 0)
        return fault_set(fault, errno == ENOENT ? FAULT_NOT_FOUND : FAULT_IO, "output.%s: the folder %s: %s", name,
                         place, strerror(errno));
    return FAULT_NONE;
}

fault_code_t job_file_check_folders(const job_t *job, const char *folder, fault_t *fault)
{
    char path[JOB_PATH_SIZE];
    bool wanted;
    if (folder)
        TRY(file_make_folder(folder, fault));
    for (int output = MESSAGE_OUTPUT_IMAGE; output <= MESSAGE_OUTPUT_REPORT; output++) {
        TRY(job_file_output(job, (message_output_t)output, folder, path, &wanted, fault));
        if (wanted)
            TRY(check_folder(path, job_file_output_name((message_output_t)output), fault));
    }
    TRY(job_file_page(job, folder, path, &wanted, fault));
    return wanted ? check_folder(path, "page", fault) : FAULT_NONE;
}
