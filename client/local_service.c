#include "client/local_service.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/file.h"
#include "client/child.h"
#include "client/temp_folder.h"

enum { SERVICE_PATH = 256, RESTARTS_PER_WORKER = 8 };

static const double ready_seconds = 30, stop_seconds = 10, quick_death_seconds = 2, restart_pause = 0.5;

typedef struct local_worker {
    child_t child;
    double began, restart_at;
} local_worker_t;

struct local_service {
    char folder[TEMP_FOLDER_SIZE], address[SERVICE_PATH], state[SERVICE_PATH], bundle[SERVICE_PATH],
        adopted[SERVICE_PATH], cache[SERVICE_PATH];
    child_t master;
    local_worker_t *workers;
    int worker_count, restarts_left, quick_deaths;
};

fault_code_t local_service_new(local_service_t **out, fault_t *fault)
{
    *out = NULL;
    local_service_t *service = calloc(1, sizeof *service);
    if (!service)
        return fault_set(fault, FAULT_MEMORY, "no memory for a service");
    service->master.output = -1;
    const fault_code_t code = temp_folder_make(service->folder, fault);
    if (code != FAULT_NONE) {
        free(service);
        return code;
    }
    snprintf(service->address, sizeof service->address, "ipc://%s/socket", service->folder);
    snprintf(service->state, sizeof service->state, "%s/state", service->folder);
    snprintf(service->bundle, sizeof service->bundle, "%s/scene.bundle", service->folder);
    snprintf(service->cache, sizeof service->cache, "%s/cache", service->folder);
    *out = service;
    return FAULT_NONE;
}

const char *local_service_bundle(const local_service_t *service)
{
    return service->bundle;
}

fault_code_t local_service_adopt_bundle(local_service_t *service, const digest_t *digest, fault_t *fault)
{
    char folder[SERVICE_PATH + 16], text[DIGEST_TEXT_SIZE];
    digest_print(digest, text);
    snprintf(folder, sizeof folder, "%s/bundles", service->state);
    TRY(file_make_folder(folder, fault));
    TRY(file_join(service->adopted, sizeof service->adopted, folder, text, fault));
    if (rename(service->bundle, service->adopted) != 0)
        return fault_set(fault, FAULT_IO, "%s: %s", service->adopted, strerror(errno));
    return FAULT_NONE;
}

static fault_code_t start_master(local_service_t *service, fault_t *fault)
{
    char listen[] = "--listen", state[] = "--state", no_sync[] = "--no-sync", quiet[] = "--quiet", line[512];
    char *argv[] = {NULL, listen, service->address, state, service->state, no_sync, quiet, NULL};
    TRY(child_start(&service->master, "garland-master", argv, true, fault));
    const fault_code_t code = child_read_line(&service->master, ready_seconds, line, sizeof line, fault);
    return fault_prefix(fault, code, "garland-master");
}

static fault_code_t start_worker(local_service_t *service, local_worker_t *worker, fault_t *fault)
{
    char master[] = "--master", threads[] = "--threads", one[] = "1", cache[] = "--cache", quiet[] = "--quiet";
    char *argv[] = {NULL, master, service->address, threads, one, cache, service->cache, quiet, NULL};
    worker->began = clock_now();
    worker->restart_at = 0;
    return child_start(&worker->child, "garland-worker", argv, false, fault);
}

fault_code_t local_service_start(local_service_t *service, int workers, fault_t *fault)
{
    TRY(start_master(service, fault));
    service->workers = calloc((size_t)workers, sizeof *service->workers);
    if (!service->workers)
        return fault_set(fault, FAULT_MEMORY, "no memory for %d workers", workers);
    service->restarts_left = RESTARTS_PER_WORKER * workers;
    for (int i = 0; i < workers; i++) {
        service->worker_count = i + 1;
        TRY(start_worker(service, &service->workers[i], fault));
    }
    return FAULT_NONE;
}

const char *local_service_address(const local_service_t *service)
{
    return service->address;
}

const char *local_service_adopted(const local_service_t *service)
{
    return service->adopted;
}

const char *local_service_state(const local_service_t *service)
{
    return service->state;
}

/* One that died: started anew after a pause, unless too many have died. */
static fault_code_t care_for_worker(local_service_t *service, local_worker_t *worker, double now, fault_t *fault)
{
    if (child_is_running(&worker->child))
        return FAULT_NONE;
    if (worker->restart_at == 0) {
        char end[128];
        child_describe_end(&worker->child, end, sizeof end);
        service->quick_deaths = now - worker->began < quick_death_seconds ? service->quick_deaths + 1 : 0;
        if (service->restarts_left-- <= 0 || service->quick_deaths > 2 * service->worker_count + 2)
            return fault_set(fault, FAULT_IO, "workers keep dying; the last one %s", end);
        fprintf(stderr, "garland: a worker %s; it is started anew\n", end);
        worker->restart_at = now + restart_pause;
    }
    return now >= worker->restart_at ? start_worker(service, worker, fault) : FAULT_NONE;
}

fault_code_t local_service_care(local_service_t *service, fault_t *fault)
{
    if (!child_is_running(&service->master)) {
        char end[128];
        child_describe_end(&service->master, end, sizeof end);
        return fault_set(fault, FAULT_IO, "the master %s", end);
    }
    const double now = clock_now();
    for (int i = 0; i < service->worker_count; i++)
        TRY(care_for_worker(service, &service->workers[i], now, fault));
    return FAULT_NONE;
}

void local_service_stop(local_service_t **pointer, bool keep)
{
    local_service_t *service = *pointer;
    if (!service)
        return;
    const size_t count = (size_t)service->worker_count;
    child_t **children = calloc(count + 1, sizeof(child_t *));
    for (size_t i = 0; i < count && children; i++)
        children[i] = &service->workers[i].child;
    if (children) {
        child_stop_all(children, count, stop_seconds); /* workers first: a worker without a master waits for one */
        children[0] = &service->master;
        child_stop_all(children, 1, stop_seconds);
    }
    if (keep)
        temp_folder_remove(service->cache);
    else
        temp_folder_remove(service->folder);
    free(children);
    free(service->workers);
    free(service);
    *pointer = NULL;
}
