/* run.h: one run of a bench: for each budget a job of its own on one thread, one after another, their figures as a
 * file. A file whose key is another's (job, scene, references, budgets or program differ) is as good as none.
 *
 * Read-only context: any process may use it after a fork. */
#ifndef CLIENT_BENCH_RUN_H
#define CLIENT_BENCH_RUN_H

#include "base/digest.h"
#include "base/json.h"
#include "client/bench/matrix.h"
#include "film/image.h"
#include "scene/scene.h"

/* What the job of one budget came to; NaN where not known. */
typedef struct run_point {
    double cpu_seconds, mutations_per_pixel;
    double relmse, trimmed, bias; /* against the reference; with two halves they may be negative near its noise */
    double estimate;              /* of relMSE, the render's own */
} run_point_t;

/* As files of runs and results hold it; the caller's. */
json_t *run_point_json(const run_point_t *point);

typedef struct run_figures {
    bool made;
    char failure[256]; /* why it is not; empty: it was not tried */
    run_point_t points[MATRIX_BUDGETS];
} run_figures_t;

/* What the runs on one scene have in common. */
typedef struct run_context {
    const matrix_t *matrix;
    size_t index; /* of the scene */
    const scene_t *scene;
    digest_t digest;       /* of its bundle */
    image_t references[2]; /* cleared by run_context_clear */
    size_t reference_count;
} run_context_t;

/* Reads the reference images. */
fault_code_t run_context_references(run_context_t *context, const char *const *paths, size_t count, fault_t *fault);
void run_context_clear(run_context_t *context);

/* Whether chains have come to all path lengths but for 3 % of the light, where samples stand beside them of the
 * light left to chains: else the image is no estimate yet, and has no figures. */
bool run_is_whole(const json_t *report);

/* Renders and writes the file. */
fault_code_t run_render(const run_context_t *context, size_t variant, uint64_t seed, const char *path,
                        fault_t *fault);
/* Figures from the file; false if it is not there, or not of this very run. */
bool run_load(run_figures_t *figures, const run_context_t *context, size_t variant, uint64_t seed,
              const char *path);

/* Renders a reference's half into a PFM file. */
fault_code_t run_render_reference(const run_context_t *context, int half, const char *path, fault_t *fault);
/* "NAME-a-0123456789ab.pfm": the digits are the job's and the scene's, so that another recipe is another file. */
fault_code_t run_reference_name(const run_context_t *context, int half, char *name, size_t size, fault_t *fault);

#endif
