/* transport.h: messages between processes. The only place that knows ZeroMQ.
 *
 * A master binds, workers and clients connect. Every send and receive is of a whole message_t; nothing blocks
 * except transport_wait and the calls built on it, and these have a time limit. Queues are bounded: a send that
 * finds its queue full fails with FAULT_LIMIT and the message is not sent.
 *
 *     TRY(transport_bind(&t, "tcp://127.0.0.1:0", &(transport_options_t){0}, fault));
 *     for (;;) {
 *         bool woken;
 *         TRY(transport_wait(t, wake_fd, 500, &woken, fault));
 *         transport_event_t event;
 *         while (transport_receive(t, &event) != TRANSPORT_NOTHING)
 *             if (event.kind == TRANSPORT_MESSAGE)
 *                 handle(event.peer, &event.message);
 *     }
 *
 * Thread rule: a transport belongs to the thread that made it. Other threads wake that thread through wake_fd (an
 * eventfd or pipe) and hand it their messages in a queue of their own.
 *
 * Addresses: tcp://host:port (host may be * or a name; port 0 or * when binding: any free one) and ipc://path.
 */
#ifndef PROTO_TRANSPORT_H
#define PROTO_TRANSPORT_H

#include "proto/message.h"

typedef struct transport transport_t;

/* A connection as the master sees it: a number that is never used again for another one within the life of the
 * transport's process in practice (32 bits, counted up). A peer that reconnects gets a new number. 0 is nobody; on
 * the connecting side there is one peer, the master, and its number is TRANSPORT_MASTER. */
typedef uint64_t transport_peer_t;

enum { TRANSPORT_NOBODY = 0, TRANSPORT_MASTER = 1 };

enum {
    TRANSPORT_QUEUE_SEND = 64,    /* messages queued per peer on their way out */
    TRANSPORT_QUEUE_RECEIVE = 16, /* and in; beyond it the network holds the sender back */
    TRANSPORT_SILENCES = 4,       /* a receiver that is slow for a lease or two keeps its connection */
    TRANSPORT_KEY_SIZE = 41       /* a key's text (Z85) with its zero */
};

/* All zero means the defaults. Keys are CURVE keys as 40 characters of Z85, borrowed during the call; a master with
 * secret_key encrypts and admits only peers that know its public key; a peer gives that as server_key (a key pair
 * of its own is made up). */
typedef struct transport_options {
    int silence_ms; /* the network probes a connection that is idle for so long, and ends one whose other host has
                       answered nothing for TRANSPORT_SILENCES times that; default MESSAGE_LEASE_MS */
    int linger_ms;  /* how long destroy waits for queued messages to leave; default 1000, negative: not at all */
    int send_queue; /* messages; default TRANSPORT_QUEUE_SEND */
    const char *secret_key; /* master's */
    const char *server_key; /* peer's: the master's public key */
} transport_options_t;

typedef enum transport_event_kind {
    TRANSPORT_NOTHING = 0,  /* no more for now */
    TRANSPORT_MESSAGE = 1,  /* peer and message */
    TRANSPORT_MALFORMED = 2 /* peer sent what is no message, or none that its side may send: fault says what. On a
                               master the peer has been answered REFUSED already. */
} transport_event_kind_t;

typedef struct transport_event {
    transport_event_kind_t kind;
    transport_peer_t peer;
    message_t message; /* borrows from the transport until the next transport_receive or destroy */
    fault_t fault;
} transport_event_t;

/* A master's end. FAULT_USAGE: an address it cannot read; FAULT_IO: address in use and the like. */
fault_code_t transport_bind(transport_t **out, const char *address, const transport_options_t *options,
                            fault_t *fault);
/* A worker's or client's end. Succeeds though nobody is there yet: ZeroMQ goes on trying; see transport_hello. */
fault_code_t transport_connect(transport_t **out, const char *address, const transport_options_t *options,
                               fault_t *fault);
/* Sends what is queued (at most linger_ms), closes. Nulls the pointer, accepts null. */
void transport_destroy(transport_t **transport);

/* The address as one would connect to it, with the port that was chosen; borrowed. (A master bound to tcp://0.0.0.0
 * says so.) */
const char *transport_address(const transport_t *transport);

/* Sends to a peer (a master) or to TRANSPORT_MASTER (a peer). FAULT_NOT_FOUND: that connection is gone.
 * FAULT_LIMIT: its queue is full, or a field is beyond its limit. The message's memory is the caller's own again on
 * return. */
fault_code_t transport_send(transport_t *transport, transport_peer_t peer, const message_t *message,
                            fault_t *fault);

/* Waits until a message can be received, wake_fd (-1: none) is readable, or timeout_ms (-1: for ever) have passed.
 * A signal ends the wait early. *woken (may be null) says whether wake_fd is readable. */
fault_code_t transport_wait(transport_t *transport, int wake_fd, int timeout_ms, bool *woken, fault_t *fault);

/* The next event without waiting; also returned. */
transport_event_kind_t transport_receive(transport_t *transport, transport_event_t *event);

/* Seconds since the last message came in (since the transport was made, if none has). */
double transport_silence(const transport_t *transport);

/* For clients that wait for one thing: the next message within timeout_ms. FAULT_TIMEOUT: silence, and the text
 * says how long and whom one waited for; FAULT_PROTOCOL: something malformed came instead. Heartbeats are passed
 * over. */
fault_code_t transport_receive_within(transport_t *transport, int timeout_ms, transport_event_t *event,
                                      fault_t *fault);

/* Says HELLO and waits for the answer. On success event->message is the WELCOME. A REFUSED becomes a fault with the
 * master's words (FAULT_VERSION if versions differ); silence becomes FAULT_TIMEOUT with what that may mean. */
fault_code_t transport_hello(transport_t *transport, const message_hello_t *hello, int timeout_ms,
                             transport_event_t *event, fault_t *fault);

/* A new CURVE key pair as text. FAULT_UNSUPPORTED if the library was built without. */
fault_code_t transport_make_keys(char public_key[TRANSPORT_KEY_SIZE], char secret_key[TRANSPORT_KEY_SIZE],
                                 fault_t *fault);

#endif
