/* plan_image.c: the layers of the image (docs/images.md). */
#include <stdio.h>
#include <stdlib.h>

#include "plan/plan_estimate.h"
#include "plan/plan_left_out.h"
#include "plan/plan_state.h"

static const char *const plan_channels[] = {"R",        "G",       "B",        "stderr.R", "stderr.G",
                                            "stderr.B", "samples", "albedo.R", "albedo.G", "albedo.B",
                                            "N.X",      "N.Y",     "N.Z",      "Z"};
enum { PLAN_CHANNELS = sizeof plan_channels / sizeof *plan_channels };

/* Mutations (their weight) or samples that the pixel got. */
static double plan_samples_at(const plan_t *plan, size_t pixel)
{
    if (!plan_is_chains(plan))
        return (double)plan->lengths[0].merged / (double)plan->pixels;
    double samples = 0;
    for (uint32_t k = plan_is_whole(plan) ? 0 : 1; k <= plan_last(plan); k++) {
        const film_t *film = &plan->lengths[k].film;
        if (!film->sums)
            continue;
        const int64_t *sum = film->sums + FILM_CHANNELS * pixel;
        const rgb_t value = rgb((double)sum[0] / FILM_ONE, (double)sum[1] / FILM_ONE, (double)sum[2] / FILM_ONE);
        samples += (plan->settings.target == SETTINGS_TARGET_LUMINANCE ? rgb_luminance(value) : rgb_max(value)) *
                   ((double)plan->lengths[k].merged / plan_eras_counted(plan, k));
    }
    if (plan->has_importance) { /* films hold weights over it */
        const settings_t *s = &plan->settings;
        const importance_t importance = {plan->importance, s->width, s->height};
        samples *= importance_at(&importance,
                                 (vec2_t){(double)(pixel % s->width) + 0.5, (double)(pixel / s->width) + 0.5});
    }
    if (plan_splits(plan))
        samples += (double)plan->lengths[0].merged / (double)plan->pixels;
    return samples;
}

static fault_code_t plan_image_attributes(const plan_t *plan, image_t *image, fault_t *fault)
{
    char *job = job_print(&plan->job);
    fault_code_t code = image_set_attribute(image, "garland.job", job ? job : "", fault);
    free(job);
    if (!code)
        code = image_set_attribute(image, "garland.version", GARLAND_VERSION, fault);
    if (!code)
        code = image_set_attribute(image, "garland.instructions", GARLAND_ARCH, fault);
    if (!code && plan->settings.failures == SETTINGS_FAILURES_PUBLISHED)
        code = image_set_attribute(image, "garland.biased", PLAN_BIASED, fault);
    char left_out[256];
    plan_left_out_say(plan, left_out, sizeof left_out);
    if (!code && left_out[0])
        code = image_set_attribute(image, "garland.left_out", left_out, fault);
    return code;
}

fault_code_t plan_image(const plan_t *plan, image_t *image, fault_t *fault)
{
    TRY(image_init(image, plan->settings.width, plan->settings.height, PLAN_CHANNELS, plan_channels, fault));
    plan_pixels_t pixels;
    plan_pixels_init(&pixels, plan);
    for (size_t p = 0; p < plan->pixels; p++) {
        double value[3], variance[3];
        plan_pixel(&pixels, p, value, variance);
        for (uint32_t c = 0; c < 3; c++) {
            image_channel(image, c)[p] = (float)value[c];
            image_channel(image, 3 + c)[p] = (float)sqrt(variance[c]);
        }
        image_channel(image, 6)[p] = (float)plan_samples_at(plan, p);
        for (uint32_t c = 0; c < WORK_FEATURE_CHANNELS; c++)
            image_channel(image, 7 + c)[p] = plan->features[WORK_FEATURE_CHANNELS * p + c];
    }
    const fault_code_t code = plan_image_attributes(plan, image, fault);
    if (code)
        image_clear(image);
    return code;
}
