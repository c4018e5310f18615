/* engine.h: what a runner's threads do with a unit, as functions: the renderer in service, something small in
 * tests. All functions are called by the runner's threads; `open` and `close` of different scenes may run at once.
 */
#ifndef WORKER_ENGINE_H
#define WORKER_ENGINE_H

#include <stdatomic.h>
#include <stddef.h>

#include "worker/source.h"

typedef struct engine {
    void *context; /* borrowed, passed to `open` */
    /* A scene that any thread may use; may take long. */
    fault_code_t (*open)(void *context, const source_t *source, void **scene, fault_t *fault);
    void (*close)(void *scene);
    /* One thread's workspace for a scene. */
    fault_code_t (*space_new)(void *scene, void **space, fault_t *fault);
    void (*space_destroy)(void *space);
    /* Runs a unit; *result is the caller's to free(). FAULT_CANCELLED soon after *cancel is true. */
    fault_code_t (*run)(void *space, const uint8_t *record, size_t size, const atomic_bool *cancel,
                        uint8_t **result, size_t *result_size, fault_t *fault);
} engine_t;

#endif
