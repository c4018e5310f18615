/* peers.h: who said HELLO: workers and clients, by connection and by session. A session outlives its connection: a
 * worker that comes back within the lease takes up its leases. Pointers stay valid until the peer is removed. */
#ifndef MASTER_PEERS_H
#define MASTER_PEERS_H

#include "proto/message.h"
#include "proto/transport.h"

enum { PEERS_SUBSCRIPTIONS = 16, PEERS_NAME_SIZE = 128 };

typedef struct peer {
    transport_peer_t address; /* its latest connection */
    uint64_t session;         /* its number in ledgers */
    message_role_t role;
    char host[PEERS_NAME_SIZE], version[PEERS_NAME_SIZE];
    uint32_t threads, pid;
    double since, heard, beat; /* first HELLO, last message, last heartbeat to it */
    /* workers */
    uint32_t slots; /* units it would take now */
    uint64_t units_done, units_failed;
    uint32_t failures_in_row;
    double paused_until; /* gets nothing until then, after failures */
    /* clients */
    uint64_t subscriptions[PEERS_SUBSCRIPTIONS];
    uint32_t subscription_count;
} peer_t;

typedef struct peers peers_t;

peers_t *peers_new(void); /* null when out of memory */
void peers_destroy(peers_t **peers);

/* Takes a HELLO: a known session goes on under the new connection, others get a new session. FAULT_LIMIT beyond
 * MESSAGE_MAX_PEERS. */
fault_code_t peers_greet(peers_t *peers, transport_peer_t address, const message_hello_t *hello, double now,
                         peer_t **out, fault_t *fault);
peer_t *peers_find(const peers_t *peers, transport_peer_t address); /* null if unknown */
peer_t *peers_find_session(const peers_t *peers, uint64_t session); /* null if unknown */
size_t peers_count(const peers_t *peers);
peer_t *peers_at(const peers_t *peers, size_t index);
size_t peers_workers(const peers_t *peers);
void peers_remove(peers_t *peers, peer_t *peer);

#endif
