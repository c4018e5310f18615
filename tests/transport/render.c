#include "render.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <setjmp.h>
#include <cmocka.h>

#include "base/clock.h"

/* Rules of time and error are not for these jobs: whether one is met is asked when there is nothing left to do,
 * which leaves out the estimates of the error on the way. */
static void render_units(render_t *render, pilots_t *pilots)
{
    fault_t fault = {0};
    const settings_t *settings = renderer_settings(render->renderer);
    const double begin = clock_now();
    uint64_t unit;
    const work_record_t *record;
    while (!plan_finished(render->plan)) {
        if (!plan_next(render->plan, &unit, &record)) {
            plan_check_stop(render->plan, clock_now() - begin);
            continue;
        }
        uint8_t *data = NULL;
        size_t size;
        plan_absorbed_t how;
        if (pilots_run(pilots, render->space, settings, record, &data, &size, &fault) ||
            plan_absorb(render->plan, unit, data, size, &how, &fault))
            fail_msg("unit %llu: %s", (unsigned long long)unit, fault.text);
        free(data);
    }
}

void render_run(render_t *render, const scene_t *scene, const char *job_text)
{
    render_image(render, scene, job_text);
    render->report = plan_report(render->plan);
}

void render_image(render_t *render, const scene_t *scene, const char *job_text)
{
    render_image_with(render, scene, job_text, NULL);
}

void render_image_with(render_t *render, const scene_t *scene, const char *job_text, pilots_t *pilots)
{
    fault_t fault = {0};
    job_t job;
    *render = (render_t){0};
    if (job_parse(&job, job_text, strlen(job_text), "job", &fault))
        fail_msg("%s", fault.text);
    if (job.stop.seconds > 0 || job.stop.error > 0)
        fail_msg("a job that ends by time or error: %s", job_text);
    if (plan_new(&render->plan, &job, scene, &fault) ||
        renderer_new(&render->renderer, scene, &job.settings, &fault) ||
        work_space_new(&render->space, render->renderer, &fault))
        fail_msg("%s", fault.text);
    render_units(render, pilots);
    if (plan_image(render->plan, &render->image, &fault))
        fail_msg("%s", fault.text);
}

void render_clear(render_t *render)
{
    image_clear(&render->image);
    json_destroy(&render->report);
    work_space_destroy(&render->space);
    renderer_destroy(&render->renderer);
    plan_destroy(&render->plan);
}

static render_estimate_t estimate_of(const json_t *object)
{
    return (render_estimate_t){json_number(json_get(object, "value")),
                               json_number(json_get(object, "standard_error"))};
}

render_estimate_t render_length(const render_t *render, uint32_t k)
{
    return estimate_of(json_get(json_at(json_get(render->report, "lengths"), k - 1), "b"));
}

render_estimate_t render_technique(const render_t *render, uint32_t k, uint32_t s)
{
    const json_t *length = json_at(json_get(render->report, "lengths"), k - 1);
    return estimate_of(json_at(json_get(length, "techniques"), s));
}
