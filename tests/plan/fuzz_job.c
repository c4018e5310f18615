/* Hostile job texts: as they come, and as edits of a valid one. What is accepted must print, parse and print the
 * same. */
#include <stdlib.h>
#include <string.h>

#include "film/fuzz_edit.h"
#include "plan/job.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const char valid[] =
    "{\"scene\":\"s.glb\",\"film\":{\"width\":640,\"height\":360,\"filter\":\"gaussian\",\"filter_radius\":2.25},"
    "\"algorithm\":\"bdpt\",\"max_path_length\":31,\"seed\":\"18446744073709551615\",\"target\":\"maximum\","
    "\"chains\":{\"large_step\":0.125,\"technique_step\":0.375,\"kernel\":\"gaussian\",\"step_min\":0.002,"
    "\"step_max\":0.04,\"length\":4294967296,\"pilot_samples\":1073741824},"
    "\"stop\":{\"mutations_per_pixel\":12.5,\"seconds\":3600.5,\"error\":0.03},"
    "\"output\":{\"image\":\"o.exr\",\"preview\":\"o.png\",\"report\":\"o.json\",\"preview_exposure\":-1.5}}";

static void try_job(const char *text, size_t size)
{
    static job_t job, back; /* large */
    fault_t fault = {0};
    if (job_parse(&job, text, size, "job", &fault) != FAULT_NONE) {
        if (strncmp(fault.text, "job: ", 5) != 0)
            abort();
        return;
    }
    char *once = job_print(&job), *twice = NULL;
    if (!once || job_parse(&back, once, strlen(once), "job", &fault) != FAULT_NONE)
        abort();
    twice = job_print(&back);
    if (!twice || strcmp(once, twice) != 0)
        abort();
    free(once);
    free(twice);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t *edited = malloc(sizeof valid);
    try_job((const char *)data, size);
    memcpy(edited, valid, sizeof valid);
    try_job((const char *)edited, fuzz_edit(edited, sizeof valid - 1, data, size));
    free(edited);
    return 0;
}
