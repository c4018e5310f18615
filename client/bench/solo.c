#include "client/bench/solo.h"

#include <stdlib.h>

#include "base/clock.h"

static const atomic_bool never = false;

typedef struct solo {
    plan_t *plan;
    work_space_t *space;
    const double *times; /* or mutations a pixel */
    bool by_mutations;
    size_t count, looked;
    solo_look_t *look;
    void *user;
    double begin; /* of the thread's clock, moved on by what is not counted */
} solo_t;

static fault_code_t solo_unit(solo_t *solo, uint64_t unit, const work_record_t *record, fault_t *fault)
{
    work_result_t result;
    uint8_t *data;
    size_t size;
    plan_absorbed_t how;
    TRY(work_run(solo->space, record, &never, &result, fault));
    TRY(work_result_encode(&result, &data, &size, fault));
    const fault_code_t code = plan_absorb(solo->plan, unit, data, size, &how, fault);
    free(data);
    return code;
}

/* Whether the next of the times has come. */
static bool solo_due(const solo_t *solo, double seconds)
{
    plan_progress_t progress;
    if (solo->looked == solo->count)
        return false;
    plan_progress(solo->plan, &progress);
    const bool reached =
        solo->by_mutations ? plan_finished(solo->plan) || progress.mutations_per_pixel >= solo->times[solo->looked]
                           : seconds >= solo->times[solo->looked];
    if (!reached)
        return false;
    if (solo->looked + 1 == solo->count)
        return plan_finished(solo->plan);
    return progress.phase != PLAN_PILOT && progress.mutations > 0;
}

static fault_code_t solo_after_unit(solo_t *solo, fault_t *fault)
{
    plan_check_stop(solo->plan, clock_thread_cpu() - solo->begin);
    const double seconds = clock_thread_cpu() - solo->begin;
    while (solo_due(solo, seconds))
        TRY(solo->look(solo->user, solo->looked++, seconds, solo->plan, fault));
    solo->begin = clock_thread_cpu() - seconds;
    return FAULT_NONE;
}

static fault_code_t solo_loop(solo_t *solo, fault_t *fault)
{
    while (!plan_finished(solo->plan)) {
        uint64_t unit;
        const work_record_t *next;
        if (!plan_next(solo->plan, &unit, &next))
            return fault_set(fault, FAULT_RANGE, "the plan hands out nothing and is not finished");
        TRY(solo_unit(solo, unit, next, fault));
        TRY(solo_after_unit(solo, fault));
    }
    if (solo->looked < solo->count)
        return fault_set(fault, FAULT_RANGE,
                         "the render ended after %zu of %zu times: the job's rule is not seconds", solo->looked,
                         solo->count);
    return FAULT_NONE;
}

static fault_code_t solo_run(solo_t *solo, const scene_t *scene, const job_t *job, fault_t *fault)
{
    renderer_t *renderer = NULL;
    fault_code_t code = renderer_new(&renderer, scene, &job->settings, fault);
    solo->begin = clock_thread_cpu();
    if (!code)
        code = plan_new(&solo->plan, job, scene, fault);
    if (!code)
        code = work_space_new(&solo->space, renderer, fault);
    if (!code)
        code = solo_loop(solo, fault);
    work_space_destroy(&solo->space);
    plan_destroy(&solo->plan);
    renderer_destroy(&renderer);
    return code;
}

fault_code_t solo_render(const scene_t *scene, const job_t *job, const double *times, size_t count,
                         solo_look_t *look, void *user, fault_t *fault)
{
    solo_t solo = {.times = times, .count = count, .look = look, .user = user};
    return solo_run(&solo, scene, job, fault);
}

fault_code_t solo_render_mutations(const scene_t *scene, const job_t *job, const double *mutations, size_t count,
                                   solo_look_t *look, void *user, fault_t *fault)
{
    solo_t solo = {.times = mutations, .by_mutations = true, .count = count, .look = look, .user = user};
    return solo_run(&solo, scene, job, fault);
}
