/* server_internal.h: the server's insides, shared by server.c (the loop), serve_worker.c and serve_client.c (what
 * workers and clients ask for). Nobody else includes it. */
#ifndef MASTER_SERVER_INTERNAL_H
#define MASTER_SERVER_INTERNAL_H

#include <stdatomic.h>

#include "master/job_table.h"
#include "master/peers.h"
#include "master/server.h"

struct server {
    server_options_t options;
    store_t *store;
    job_table_t *jobs;
    peers_t *peers;
    transport_t *transport;
    int wake_fd;                    /* eventfd: a job's thread has ended, or server_stop */
    atomic_bool stop;               /* lock-free: set by signal handlers and other threads */
    double began, heartbeat, lease; /* seconds */
    double next_care, next_progress;
    size_t turn;    /* of workers */
    uint8_t *chunk; /* MESSAGE_MAX_CHUNK bytes */
};

/* server.c */
/* Sends; what cannot be sent is logged and forgotten: the peer will ask again. */
fault_code_t server_send(server_t *server, const peer_t *peer, const message_t *message);
void server_refuse(server_t *server, const peer_t *peer, message_type_t request, uint64_t job, fault_code_t code,
                   const char *text);
/* Removes a peer; a worker's units go to others. */
void server_forget_peer(server_t *server, peer_t *peer, const char *why);

/* serve_worker.c */
void serve_worker(server_t *server, peer_t *peer, const message_t *message, double now);
/* Answers results that are durable now; context is the server. */
void serve_ack(void *context, uint64_t session, const message_lease_t *lease, message_ack_t outcome);
/* Hands units to whoever has room. */
void serve_dispatch(server_t *server, double now);
/* The job will take no more results: workers may drop what they hold of it. */
void serve_cancel_work(server_t *server, uint64_t job);

/* serve_client.c */
void serve_client(server_t *server, peer_t *peer, const message_t *message, double now);
/* JOB_QUERY, of workers too. */
void serve_job_query(server_t *server, const peer_t *peer, uint64_t job);
/* Progress to those who subscribed, and ends until they are sent. */
void serve_subscribers(server_t *server, bool progress);

#endif
