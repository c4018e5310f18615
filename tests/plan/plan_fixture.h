/* plan_fixture.h: runs plans in-process, for tests: a worker without sockets. What fails on the way ends the
 * process with its message. */
#ifndef TESTS_PLAN_PLAN_FIXTURE_H
#define TESTS_PLAN_PLAN_FIXTURE_H

#include "plan/plan.h"
#include "support/small_scenes.h"

/* A job from JSON text in which ' stands for ". */
job_t plan_fixture_job(const char *text);

/* A worker for one job and scene. */
typedef struct plan_worker {
    renderer_t *renderer;
    work_space_t *space;
} plan_worker_t;

void plan_worker_make(plan_worker_t *worker, const job_t *job, const scene_t *scene);
void plan_worker_clear(plan_worker_t *worker);

/* A unit's result as bytes; the caller frees. */
uint8_t *plan_worker_run(plan_worker_t *worker, const work_record_t *record, size_t *size);

plan_t *plan_fixture_new(const job_t *job, const scene_t *scene);
/* A plan for a job in the small diffuse box, with its scene and a worker. */
typedef struct plan_render {
    small_scene_t small;
    plan_worker_t worker;
    plan_t *plan;
} plan_render_t;

void plan_render_open(plan_render_t *render, const job_t *job);
void plan_render_close(plan_render_t *render);

/* Hands out, runs and absorbs one unit; false if there is none. */
bool plan_fixture_step(plan_t *plan, plan_worker_t *worker);
/* Steps in order until the plan has finished; `seconds` of pretended time pass with each unit. */
void plan_fixture_run(plan_t *plan, plan_worker_t *worker, double seconds);

#endif
