/* garland submit: a job to a master that runs. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "client/commands.h"
#include "client/job_file.h"
#include "client/remote.h"
#include "client/scene_source.h"
#include "client/temp_folder.h"
#include "scene/bundle.h"

static const char usage[] =
    "usage: garland submit JOB.json --master ADDR\n"
    "\n"
    "Packs the job's scene, sends it unless the master has it, and prints the job's number.\n"
    "\n" REMOTE_USAGE;

static fault_code_t submit(remote_t *remote, const job_file_t *file, const char *bundle, uint64_t *job,
                           fault_t *fault)
{
    char *text = job_print(&file->job);
    if (!text)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job's text");
    const fault_code_t code = link_submit(remote->link, text, bundle, job, fault);
    free(text);
    return code;
}

/* A bundle goes as it is; another scene is packed into a folder that is gone afterwards. */
static fault_code_t pack_and_submit(remote_t *remote, const job_file_t *file, uint64_t *job, fault_t *fault)
{
    if (bundle_probe(file->scene))
        return submit(remote, file, file->scene, job, fault);
    char folder[TEMP_FOLDER_SIZE], bundle[TEMP_FOLDER_SIZE + 16];
    digest_t digest;
    TRY(temp_folder_make(folder, fault));
    snprintf(bundle, sizeof bundle, "%s/scene.bundle", folder);
    fault_code_t code = scene_source_bundle(file->scene, bundle, stderr, &digest, NULL, fault);
    if (code == FAULT_NONE)
        code = submit(remote, file, bundle, job, fault);
    temp_folder_remove(folder);
    return code;
}

int command_submit(int argc, char **argv)
{
    remote_t remote = {0};
    const char *path;
    int status;
    uint64_t job = 0;
    fault_t fault = {0};
    const option_t list[] = {REMOTE_OPTIONS(remote), {0}};
    if (!options_parse("submit", usage, list, argc, argv, &path, 1, 1, &status))
        return status;
    job_file_t *file = malloc(sizeof *file);
    if (!file || job_file_read(file, path, &fault) != FAULT_NONE) {
        status = file ? remote_fail(&fault) : STATUS_FAILURE;
    } else if (remote_open(&remote, "submit", &status)) {
        status = STATUS_SUCCESS;
        if (pack_and_submit(&remote, file, &job, &fault) != FAULT_NONE)
            status = remote_fail(&fault);
        else
            printf("%" PRIu64 "\n", job);
        remote_close(&remote);
    }
    free(file);
    return status;
}
