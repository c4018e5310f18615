#include "master/peers.h"

#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "master/text.h"

struct peers {
    peer_t *list[MESSAGE_MAX_PEERS];
    size_t count, workers;
};

peers_t *peers_new(void)
{
    return calloc(1, sizeof(peers_t));
}

void peers_destroy(peers_t **peers)
{
    if (!*peers)
        return;
    for (size_t i = 0; i < (*peers)->count; i++)
        free((*peers)->list[i]);
    free(*peers);
    *peers = NULL;
}

/* Not to be guessed: whoever names a session takes its place. */
static fault_code_t draw_session(uint64_t *session, fault_t *fault)
{
    do
        if (getrandom(session, sizeof *session, 0) != sizeof *session)
            return fault_set(fault, FAULT_IO, "no random numbers to be had");
    while (*session == 0);
    return FAULT_NONE;
}

static fault_code_t add(peers_t *peers, const message_hello_t *hello, double now, peer_t **out, fault_t *fault)
{
    if (peers->count == MESSAGE_MAX_PEERS)
        return fault_set(fault, FAULT_LIMIT, "the master has %d peers already", MESSAGE_MAX_PEERS);
    peer_t *peer = calloc(1, sizeof *peer);
    if (!peer)
        return fault_set(fault, FAULT_MEMORY, "no memory for one more peer");
    const fault_code_t code = draw_session(&peer->session, fault);
    if (code != FAULT_NONE) {
        free(peer);
        return code;
    }
    peer->role = (message_role_t)hello->role;
    peer->since = now;
    peers->list[peers->count++] = peer;
    peers->workers += peer->role == MESSAGE_ROLE_WORKER;
    *out = peer;
    return FAULT_NONE;
}

fault_code_t peers_greet(peers_t *peers, transport_peer_t address, const message_hello_t *hello, double now,
                         peer_t **out, fault_t *fault)
{
    peer_t *peer = hello->session ? peers_find_session(peers, hello->session) : NULL;
    if (peer && peer->role != (message_role_t)hello->role)
        peer = NULL;
    peer_t *same = peers_find(peers, address);
    if (!peer && same && same->role == (message_role_t)hello->role)
        peer = same;
    if (same && same != peer)
        same->address = TRANSPORT_NOBODY; /* one connection, one peer: the earlier one falls silent */
    if (!peer)
        TRY(add(peers, hello, now, &peer, fault));
    peer->address = address;
    peer->heard = peer->beat = now;
    peer->threads = hello->threads;
    peer->pid = hello->pid;
    peer->slots = 0;
    text_clean(peer->host, sizeof peer->host, hello->host);
    text_clean(peer->version, sizeof peer->version, hello->garland_version);
    *out = peer;
    return FAULT_NONE;
}

peer_t *peers_find(const peers_t *peers, transport_peer_t address)
{
    for (size_t i = 0; i < peers->count; i++)
        if (peers->list[i]->address == address && address != TRANSPORT_NOBODY)
            return peers->list[i];
    return NULL;
}

peer_t *peers_find_session(const peers_t *peers, uint64_t session)
{
    for (size_t i = 0; i < peers->count; i++)
        if (peers->list[i]->session == session)
            return peers->list[i];
    return NULL;
}

size_t peers_count(const peers_t *peers)
{
    return peers->count;
}

peer_t *peers_at(const peers_t *peers, size_t index)
{
    return peers->list[index];
}

size_t peers_workers(const peers_t *peers)
{
    return peers->workers;
}

void peers_remove(peers_t *peers, peer_t *peer)
{
    for (size_t i = 0; i < peers->count; i++)
        if (peers->list[i] == peer) {
            peers->workers -= peer->role == MESSAGE_ROLE_WORKER;
            peers->list[i] = peers->list[--peers->count];
            free(peer);
            return;
        }
}
