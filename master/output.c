#include "master/output.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "film/exr.h"
#include "film/png.h"
#include "proto/message.h"

const char *output_file(unsigned output)
{
    switch (output) {
    case MESSAGE_OUTPUT_IMAGE:
        return "image.exr";
    case MESSAGE_OUTPUT_PREVIEW:
        return "preview.png";
    case MESSAGE_OUTPUT_REPORT:
        return "report.json";
    default:
        return NULL;
    }
}

bool output_wanted(const job_t *job, unsigned output)
{
    switch (output) {
    case MESSAGE_OUTPUT_IMAGE:
        return job->image[0] != '\0';
    case MESSAGE_OUTPUT_PREVIEW:
        return job->preview[0] != '\0' || job->page[0] != '\0';
    case MESSAGE_OUTPUT_REPORT:
        return job->report[0] != '\0' || job->page[0] != '\0';
    default:
        return false;
    }
}

static char *report_text(const plan_t *plan, const output_service_t *service)
{
    json_t *report = plan_report(plan);
    json_t *own = json_new_object();
    json_add_string(own, "version", GARLAND_VERSION);
    json_add_string(own, "instruction_set", GARLAND_ARCH);
    json_add_number(own, "submitted", service->submitted);
    json_add_number(own, "setup_seconds", service->setup_seconds);
    json_add_number(own, "pilot_seconds", service->pilot_seconds);
    json_add_number(own, "render_seconds", service->render_seconds);
    json_add_number(own, "workers", (double)service->workers);
    json_add_number(own, "attempts_lost", (double)service->attempts_lost);
    json_add_number(own, "attempts_failed", (double)service->attempts_failed);
    json_add(report, "service", own);
    char *text = json_print(report, true);
    json_destroy(&report);
    return text;
}

static fault_code_t write_image(const store_t *store, uint64_t id, const image_t *image, fault_t *fault)
{
    uint8_t *data = NULL;
    size_t size = 0;
    TRY(exr_encode(image, &data, &size, fault));
    const fault_code_t code = store_write(store, id, output_file(MESSAGE_OUTPUT_IMAGE), data, size, fault);
    free(data);
    return code;
}

static fault_code_t write_preview(const store_t *store, uint64_t id, const image_t *image, double stops,
                                  fault_t *fault)
{
    uint8_t *data = NULL;
    size_t size = 0;
    TRY(png_encode(image, exp2(stops), &data, &size, fault));
    const fault_code_t code = store_write(store, id, output_file(MESSAGE_OUTPUT_PREVIEW), data, size, fault);
    free(data);
    return code;
}

fault_code_t output_write(const store_t *store, uint64_t id, const job_t *job, const char *job_text,
                          const plan_t *plan, const output_service_t *service, fault_t *fault)
{
    image_t image = {0};
    char *report = NULL;
    fault_code_t code = plan_image(plan, &image, fault);
    if (code != FAULT_NONE)
        return code;
    report = report_text(plan, service);
    if ((code = image_set_attribute(&image, "garland.job", job_text, fault)) != FAULT_NONE ||
        (code = image_set_attribute(&image, "garland.report", report, fault)) != FAULT_NONE)
        goto cleanup;
    if (output_wanted(job, MESSAGE_OUTPUT_IMAGE) && (code = write_image(store, id, &image, fault)) != FAULT_NONE)
        goto cleanup;
    if (output_wanted(job, MESSAGE_OUTPUT_PREVIEW) &&
        (code = write_preview(store, id, &image, job->preview_exposure, fault)) != FAULT_NONE)
        goto cleanup;
    if (output_wanted(job, MESSAGE_OUTPUT_REPORT))
        code = store_write(store, id, output_file(MESSAGE_OUTPUT_REPORT), report, strlen(report), fault);
cleanup:
    free(report);
    image_clear(&image);
    return code;
}
