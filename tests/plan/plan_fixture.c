#include "plan/plan_fixture.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void demand(fault_code_t code, const fault_t *fault)
{
    if (code == FAULT_NONE)
        return;
    fprintf(stderr, "a test's plan failed: %s\n", fault->text);
    abort();
}

job_t plan_fixture_job(const char *text)
{
    char *json = strdup(text);
    job_t job;
    fault_t fault = {0};
    for (char *c = json; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    demand(job_parse(&job, json, strlen(json), "job", &fault), &fault);
    free(json);
    return job;
}

void plan_worker_make(plan_worker_t *worker, const job_t *job, const scene_t *scene)
{
    fault_t fault = {0};
    demand(renderer_new(&worker->renderer, scene, &job->settings, &fault), &fault);
    demand(work_space_new(&worker->space, worker->renderer, &fault), &fault);
}

void plan_worker_clear(plan_worker_t *worker)
{
    work_space_destroy(&worker->space);
    renderer_destroy(&worker->renderer);
}

uint8_t *plan_worker_run(plan_worker_t *worker, const work_record_t *record, size_t *size)
{
    const atomic_bool cancel = false;
    work_result_t result;
    fault_t fault = {0};
    uint8_t *data = NULL;
    demand(work_run(worker->space, record, &cancel, &result, &fault), &fault);
    demand(work_result_encode(&result, &data, size, &fault), &fault);
    return data;
}

plan_t *plan_fixture_new(const job_t *job, const scene_t *scene)
{
    plan_t *plan = NULL;
    fault_t fault = {0};
    demand(plan_new(&plan, job, scene, &fault), &fault);
    return plan;
}

void plan_render_open(plan_render_t *render, const job_t *job)
{
    small_scene_diffuse(&render->small);
    plan_worker_make(&render->worker, job, &render->small.scene);
    render->plan = plan_fixture_new(job, &render->small.scene);
}

void plan_render_close(plan_render_t *render)
{
    plan_destroy(&render->plan);
    plan_worker_clear(&render->worker);
    small_scene_clear(&render->small);
}

bool plan_fixture_step(plan_t *plan, plan_worker_t *worker)
{
    const work_record_t *record;
    uint64_t unit;
    size_t size;
    fault_t fault = {0};
    plan_absorbed_t how;
    if (!plan_next(plan, &unit, &record))
        return false;
    uint8_t *data = plan_worker_run(worker, record, &size);
    demand(plan_absorb(plan, unit, data, size, &how, &fault), &fault);
    free(data);
    if (how != PLAN_MERGED)
        abort();
    return true;
}

void plan_fixture_run(plan_t *plan, plan_worker_t *worker, double seconds)
{
    for (double now = 0; !plan_finished(plan); now += seconds) {
        const bool more = plan_fixture_step(plan, worker);
        if (!plan_check_stop(plan, now) && !more && !plan_finished(plan))
            abort(); /* nothing to do, and not done */
    }
}
