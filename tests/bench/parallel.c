#include "parallel.h"

#include <pthread.h>
#include <stdlib.h>

#include "base/clock.h"

/* What the threads of a render share; `lock` guards plan, times and fault. */
typedef struct parallel {
    plan_t *plan;
    const renderer_t *renderer;
    double begin;
    double cpu_seconds, merge_seconds;
    bool plain; /* nobody reads the report: no estimates of the error on the way */
    fault_t fault;
    atomic_bool cancel;
    pthread_mutex_t lock;
    pthread_cond_t changed;
} parallel_t;

static void parallel_fail(parallel_t *p, const fault_t *fault)
{
    if (!p->fault.code)
        p->fault = *fault;
    p->cancel = true;
    pthread_cond_broadcast(&p->changed);
}

/* Waits for a unit; false when there are no more. Called with the lock held. The record is copied, as the plan may
 * move its own; the seeds stay where they are until the unit is absorbed. */
static bool parallel_take(parallel_t *p, uint64_t *unit, work_record_t *record)
{
    while (!p->cancel) {
        const work_record_t *next;
        if (plan_finished(p->plan))
            return false;
        if (plan_next(p->plan, unit, &next)) {
            *record = *next;
            return true;
        }
        if (p->plain && plan_check_stop(p->plan, clock_now() - p->begin))
            return false;
        pthread_cond_wait(&p->changed, &p->lock);
    }
    return false;
}

static void parallel_give(parallel_t *p, uint64_t unit, const uint8_t *data, size_t size)
{
    fault_t fault = {0};
    plan_absorbed_t how;
    if (plan_absorb(p->plan, unit, data, size, &how, &fault)) {
        parallel_fail(p, &fault);
        return;
    }
    if (!p->plain)
        plan_check_stop(p->plan, clock_now() - p->begin);
    if (plan_finished(p->plan))
        p->cancel = true;
    pthread_cond_broadcast(&p->changed);
}

static fault_code_t parallel_unit(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                                  uint8_t **data, size_t *size, fault_t *fault)
{
    work_result_t result;
    TRY(work_run(space, record, cancel, &result, fault));
    return work_result_encode(&result, data, size, fault);
}

static void parallel_loop(parallel_t *p, work_space_t *space)
{
    uint64_t unit;
    work_record_t record;
    while (parallel_take(p, &unit, &record)) {
        fault_t fault = {0};
        uint8_t *data = NULL;
        size_t size;
        pthread_mutex_unlock(&p->lock);
        const fault_code_t code = parallel_unit(space, &record, &p->cancel, &data, &size, &fault);
        pthread_mutex_lock(&p->lock);
        const double start = clock_thread_cpu();
        if (code && code != FAULT_CANCELLED)
            parallel_fail(p, &fault);
        else if (!code && !p->cancel)
            parallel_give(p, unit, data, size);
        p->merge_seconds += clock_thread_cpu() - start;
        free(data);
    }
}

static void *parallel_thread(void *user)
{
    parallel_t *p = user;
    fault_t fault = {0};
    work_space_t *space;
    const fault_code_t code = work_space_new(&space, p->renderer, &fault);
    pthread_mutex_lock(&p->lock);
    if (code)
        parallel_fail(p, &fault);
    else
        parallel_loop(p, space);
    p->cpu_seconds += clock_thread_cpu();
    pthread_mutex_unlock(&p->lock);
    work_space_destroy(&space);
    return NULL;
}

static fault_code_t parallel_threads(parallel_t *p, unsigned threads, fault_t *fault)
{
    pthread_t ids[PARALLEL_MAX_THREADS];
    unsigned started = 0;
    while (started < threads && !pthread_create(&ids[started], NULL, parallel_thread, p))
        started++;
    if (started < threads) {
        pthread_mutex_lock(&p->lock);
        parallel_fail(p, &(fault_t){FAULT_MEMORY, "cannot start a thread"});
        pthread_mutex_unlock(&p->lock);
    }
    for (unsigned i = 0; i < started; i++)
        pthread_join(ids[i], NULL);
    if (p->fault.code)
        *fault = p->fault;
    return p->fault.code;
}

static fault_code_t parallel_finish(parallel_run_t *run, const parallel_t *p, fault_t *fault)
{
    plan_progress_t progress;
    plan_progress(p->plan, &progress);
    run->mutations = progress.mutations;
    run->cpu_seconds = p->cpu_seconds;
    run->merge_seconds = p->merge_seconds;
    run->report = p->plain ? NULL : plan_report(p->plan);
    return plan_image(p->plan, &run->image, fault);
}

static fault_code_t parallel_job(parallel_run_t *run, const scene_t *scene, const job_t *job, unsigned threads,
                                 bool plain, fault_t *fault)
{
    renderer_t *renderer = NULL;
    *run = (parallel_run_t){0};
    if (threads < 1 || threads > PARALLEL_MAX_THREADS)
        return fault_set(fault, FAULT_RANGE, "%u threads, expected 1 to %d", threads, PARALLEL_MAX_THREADS);
    parallel_t p = {.begin = clock_now(),
                    .plain = plain,
                    .lock = PTHREAD_MUTEX_INITIALIZER,
                    .changed = PTHREAD_COND_INITIALIZER};
    fault_code_t code = plan_new(&p.plan, job, scene, fault);
    if (!code)
        code = renderer_new(&renderer, scene, &job->settings, fault);
    p.renderer = renderer;
    if (!code)
        code = parallel_threads(&p, threads, fault);
    run->wall_seconds = clock_now() - p.begin;
    if (!code)
        code = parallel_finish(run, &p, fault);
    renderer_destroy(&renderer);
    plan_destroy(&p.plan);
    if (code)
        parallel_clear(run);
    return code;
}

fault_code_t parallel_render(parallel_run_t *run, const scene_t *scene, const job_t *job, unsigned threads,
                             fault_t *fault)
{
    return parallel_job(run, scene, job, threads, false, fault);
}

void parallel_clear(parallel_run_t *run)
{
    image_clear(&run->image);
    json_destroy(&run->report);
}

/* ---- many seeds ---- */

typedef struct seeds {
    image_t *images;
    const scene_t *scene;
    const job_t *job;
    uint64_t first;
    unsigned count;
    atomic_uint next;
    pthread_mutex_t lock;
    fault_t fault;
} seeds_t;

static void *seeds_thread(void *user)
{
    seeds_t *seeds = user;
    const bool plain = seeds->job->stop.seconds == 0 && seeds->job->stop.error == 0;
    for (unsigned i = seeds->next++; i < seeds->count; i = seeds->next++) {
        fault_t fault = {0};
        parallel_run_t run;
        job_t job = *seeds->job;
        job.settings.seed = seeds->first + i;
        if (parallel_job(&run, seeds->scene, &job, 1, plain, &fault)) {
            pthread_mutex_lock(&seeds->lock);
            seeds->fault = fault;
            pthread_mutex_unlock(&seeds->lock);
            seeds->next = seeds->count;
            break;
        }
        seeds->images[i] = run.image;
        run.image = (image_t){0};
        parallel_clear(&run);
    }
    return NULL;
}

fault_code_t parallel_seeds(image_t *images, const scene_t *scene, const job_t *job, uint64_t first, unsigned count,
                            unsigned threads, fault_t *fault)
{
    pthread_t ids[PARALLEL_MAX_THREADS];
    unsigned started = 0;
    seeds_t seeds = {images, scene, job, first, count, 0, PTHREAD_MUTEX_INITIALIZER, {0}};
    for (unsigned i = 0; i < count; i++)
        images[i] = (image_t){0};
    while (started + 1 < threads && started < PARALLEL_MAX_THREADS &&
           !pthread_create(&ids[started], NULL, seeds_thread, &seeds))
        started++;
    seeds_thread(&seeds);
    for (unsigned i = 0; i < started; i++)
        pthread_join(ids[i], NULL);
    if (seeds.fault.code) {
        for (unsigned i = 0; i < count; i++)
            image_clear(&images[i]);
        *fault = seeds.fault;
    }
    return seeds.fault.code;
}
