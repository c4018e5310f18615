#include "worker/render.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "chain/work.h"
#include "plan/job.h"
#include "proto/message.h"

typedef struct render_scene {
    bundle_t *bundle;
    renderer_t *renderer;
} render_scene_t;

static void render_close(void *scene)
{
    render_scene_t *s = scene;
    renderer_destroy(&s->renderer);
    bundle_destroy(&s->bundle);
    free(s);
}

static fault_code_t make_renderer(render_scene_t *scene, cache_t *cache, const source_t *source, fault_t *fault)
{
    job_t *job = calloc(1, sizeof *job);
    if (!job)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job");
    const char *text = source_text(source);
    fault_code_t code = job_parse(job, text, strlen(text), "job", fault);
    if (code == FAULT_NONE)
        code = cache_admit(cache, source_bundle(source), &scene->bundle, fault);
    if (code == FAULT_NONE)
        code = renderer_new(&scene->renderer, bundle_scene(scene->bundle), &job->settings, fault);
    free(job);
    return code;
}

static fault_code_t render_open(void *context, const source_t *source, void **out, fault_t *fault)
{
    render_scene_t *scene = calloc(1, sizeof *scene);
    if (!scene)
        return fault_set(fault, FAULT_MEMORY, "no memory for a scene");
    const fault_code_t code = make_renderer(scene, context, source, fault);
    if (code) {
        render_close(scene);
        scene = NULL;
    }
    *out = scene;
    return code;
}

/* A thread's space, and what the next unit's timing figures tell of the time since the last. */
typedef struct render_space {
    work_space_t *work;
    double ended, packing; /* when the last unit's result was packed, and the processor time it took; 0: none yet */
} render_space_t;

static fault_code_t render_space_new(void *scene, void **out, fault_t *fault)
{
    render_space_t *space = calloc(1, sizeof *space);
    if (!space)
        return fault_set(fault, FAULT_MEMORY, "no memory for a work space");
    const fault_code_t code = work_space_new(&space->work, ((render_scene_t *)scene)->renderer, fault);
    if (code) {
        free(space);
        space = NULL;
    }
    *out = space;
    return code;
}

static void render_space_destroy(void *space)
{
    render_space_t *s = space;
    work_space_destroy(&s->work);
    free(s);
}

static fault_code_t pack_result(render_space_t *space, work_result_t *result, double waiting, uint8_t **out,
                                size_t *out_size, fault_t *fault)
{
    const double begin = clock_thread_cpu();
    result->stats.merging_seconds = space->packing;
    result->stats.waiting_seconds = waiting;
    const fault_code_t code = work_result_encode(result, out, out_size, fault);
    space->packing = clock_thread_cpu() - begin;
    space->ended = clock_now();
    return code;
}

static fault_code_t render_run(void *space, const uint8_t *bytes, size_t size, const atomic_bool *cancel,
                               uint8_t **out, size_t *out_size, fault_t *fault)
{
    render_space_t *s = space;
    const double waiting = s->ended > 0 ? clock_now() - s->ended : 0;
    work_record_t record = {0};
    work_result_t result = {0};
    TRY(work_record_decode(&record, bytes, size, fault));
    fault_code_t code = work_run(s->work, &record, cancel, &result, fault);
    if (code == FAULT_NONE)
        code = pack_result(s, &result, waiting, out, out_size, fault);
    work_record_clear(&record);
    if (code == FAULT_NONE && *out_size > MESSAGE_MAX_RESULT)
        code = fault_set(fault, FAULT_LIMIT, "a result of %zu octets, at most %d are allowed", *out_size,
                         MESSAGE_MAX_RESULT);
    return code;
}

engine_t render_engine(cache_t *cache)
{
    return (engine_t){.context = cache,
                      .open = render_open,
                      .close = render_close,
                      .space_new = render_space_new,
                      .space_destroy = render_space_destroy,
                      .run = render_run};
}
