/* local_service.h: a master and workers on this machine, for one render: separate processes in a private folder,
 * all gone when it ends.
 *
 *     TRY(local_service_start(&service, workers, fault));
 *     link_open(&link, local_service_address(service), ...)
 *     ... local_service_care(service, fault) now and then ...
 *     local_service_stop(&service, keep);
 *
 * A worker that dies is started anew, a bounded number of times; a master that dies is a fault. One thread. */
#ifndef CLIENT_LOCAL_SERVICE_H
#define CLIENT_LOCAL_SERVICE_H

#include <stdbool.h>

#include "base/digest.h"
#include "base/fault.h"

typedef struct local_service local_service_t;

/* Makes the private folder; nothing runs yet. */
fault_code_t local_service_new(local_service_t **out, fault_t *fault);
/* Where a bundle may be written before the master starts, and where the master then finds it under its digest. */
const char *local_service_bundle(const local_service_t *service);
fault_code_t local_service_adopt_bundle(local_service_t *service, const digest_t *digest, fault_t *fault);
/* Starts the master and, when it listens, the workers (each with one thread). */
fault_code_t local_service_start(local_service_t *service, int workers, fault_t *fault);
const char *local_service_address(const local_service_t *service);
/* The adopted bundle's path. */
const char *local_service_adopted(const local_service_t *service);
/* The master's state folder. */
const char *local_service_state(const local_service_t *service);
/* Looks after the processes; to be called a few times a second. */
fault_code_t local_service_care(local_service_t *service, fault_t *fault);
/* Stops the processes. Removes the folder, unless `keep`. */
void local_service_stop(local_service_t **service, bool keep);

#endif
