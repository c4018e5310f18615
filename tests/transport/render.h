/* render.h: a whole job in this process, for tests: the plan's units run one after the other. */
#ifndef TESTS_TRANSPORT_RENDER_H
#define TESTS_TRANSPORT_RENDER_H

#include "pilots.h"
#include "plan/plan.h"

typedef struct render_estimate {
    double value, error;
} render_estimate_t;

typedef struct render {
    plan_t *plan;
    renderer_t *renderer;
    work_space_t *space;
    image_t image;
    json_t *report; /* null after render_image */
} render_t;

/* Runs the job, whose stop rule is a number of mutations; fails the test if it cannot. The report has a history of
 * one point. */
void render_run(render_t *render, const scene_t *scene, const char *job_text);
/* The same for the image alone. */
void render_image(render_t *render, const scene_t *scene, const char *job_text);
/* Likewise, with results of the pilot from other renders of the scene. */
void render_image_with(render_t *render, const scene_t *scene, const char *job_text, pilots_t *pilots);
void render_clear(render_t *render);

/* b_k and b_{k,s} as the report states them. */
render_estimate_t render_length(const render_t *render, uint32_t k);
render_estimate_t render_technique(const render_t *render, uint32_t k, uint32_t s);

#endif
