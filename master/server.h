/* server.h: the master's loop: one thread that owns the transport, the peers and the jobs.
 *
 *     TRY(server_new(&server, &options, fault));
 *     printf("listening on %s\n", server_address(server));
 *     TRY(server_run(server, fault));     until server_stop
 *     server_destroy(&server);
 *
 * Whatever a peer sends, the others are served: messages are checked by proto, requests are answered with REFUSED,
 * and work that takes long (setting up a job, writing outputs) happens in threads of the jobs.
 */
#ifndef MASTER_SERVER_H
#define MASTER_SERVER_H

#include <stdbool.h>

#include "base/fault.h"

typedef struct server server_t;

/* Strings are borrowed for the server's life. */
typedef struct server_options {
    const char *address;    /* to listen at */
    const char *state;      /* folder */
    const char *token;      /* that peers must send; null: none */
    const char *secret_key; /* CURVE, Z85; null: no encryption */
    double lease_seconds;   /* 0: MESSAGE_LEASE_MS */
    bool no_sync;           /* the state folder is temporary */
} server_options_t;

fault_code_t server_new(server_t **out, const server_options_t *options, fault_t *fault);
void server_destroy(server_t **server);
const char *server_address(const server_t *server);
/* Serves until server_stop, then saves a checkpoint of every job. */
fault_code_t server_run(server_t *server, fault_t *fault);
/* From any thread or signal handler. */
void server_stop(server_t *server);

#endif
