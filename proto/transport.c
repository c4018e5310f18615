#include "proto/transport.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

#include "base/clock.h"

enum {
    ADDRESS_SIZE = 512,
    ROUTING_ID_SIZE = 5, /* of one that ZeroMQ made: a zero octet and a counter of 32 bits */
    LINGER_MS = 1000,
    HELLO_RETRY_MS = 5, /* between attempts at a queue that is not there yet */
    BACKLOG = 1024,     /* connections that wait for accept: all workers of a cluster at once */
    RECEIVE_BURST = 64  /* frames that are no message at all, passed over in one transport_receive */
};

struct transport {
    void *context, *socket;
    bool master;
    char address[ADDRESS_SIZE];
    zmq_msg_t frame; /* that the last event borrows from */
    double heard;    /* clock_now() of the last message */
};

/* ---- making ---- */

/* Digits from 0 (any free port, when binding) or 1 to 65535, or * when binding. */
static bool is_port(const char *text, bool master)
{
    if (master && strcmp(text, "*") == 0)
        return true;
    const size_t digits = strspn(text, "0123456789");
    if (digits == 0 || digits > 5 || text[digits] != '\0')
        return false;
    const long port = strtol(text, NULL, 10);
    return port <= UINT16_MAX && (port > 0 || master);
}

static fault_code_t check_address(const char *address, bool master, fault_t *fault)
{
    const bool tcp = strncmp(address, "tcp://", 6) == 0;
    if ((!tcp && strncmp(address, "ipc://", 6) != 0) || address[6] == '\0')
        return fault_set(fault, FAULT_USAGE, "address \"%s\": expected tcp://host:port or ipc://path", address);
    const char *colon = strrchr(address + 6, ':');
    if (tcp && (!colon || colon == address + 6 || !is_port(colon + 1, master)))
        return fault_set(fault, FAULT_USAGE,
                         "address \"%s\": expected tcp://host:port with a port from %d to 65535", address, !master);
    if (strlen(address) >= ADDRESS_SIZE)
        return fault_set(fault, FAULT_USAGE, "address of %zu octets, at most %d are allowed", strlen(address),
                         ADDRESS_SIZE - 1);
    return FAULT_NONE;
}

static fault_code_t set_int(transport_t *t, int option, int value, fault_t *fault)
{
    if (zmq_setsockopt(t->socket, option, &value, sizeof value) != 0)
        return fault_set(fault, FAULT_IO, "socket option %d = %d: %s", option, value, zmq_strerror(errno));
    return FAULT_NONE;
}

static fault_code_t set_key(transport_t *t, int option, const char *key, const char *which, fault_t *fault)
{
    uint8_t binary[32];
    if (strlen(key) != TRANSPORT_KEY_SIZE - 1 || !zmq_z85_decode(binary, key))
        return fault_set(fault, FAULT_USAGE, "%s key: expected 40 characters of Z85", which);
    const int result = zmq_setsockopt(t->socket, option, key, TRANSPORT_KEY_SIZE);
    memset(binary, 0, sizeof binary);
    if (result != 0)
        return fault_set(fault, FAULT_UNSUPPORTED, "%s key: %s", which, zmq_strerror(errno));
    return FAULT_NONE;
}

static fault_code_t set_security(transport_t *t, const transport_options_t *options, fault_t *fault)
{
    if (t->master && options->secret_key) {
        TRY(set_int(t, ZMQ_CURVE_SERVER, 1, fault));
        TRY(set_key(t, ZMQ_CURVE_SECRETKEY, options->secret_key, "secret", fault));
    }
    if (!t->master && options->server_key) {
        char public_key[TRANSPORT_KEY_SIZE], secret_key[TRANSPORT_KEY_SIZE];
        TRY(set_key(t, ZMQ_CURVE_SERVERKEY, options->server_key, "server", fault));
        TRY(transport_make_keys(public_key, secret_key, fault));
        TRY(set_key(t, ZMQ_CURVE_PUBLICKEY, public_key, "public", fault));
        TRY(set_key(t, ZMQ_CURVE_SECRETKEY, secret_key, "secret", fault));
    }
    return FAULT_NONE;
}

/* Dead connections are found by TCP. ZeroMQ's own heartbeats stay off: a heartbeat that falls due on a connection
 * which broke while its receive queue was full aborts the process (libzmq 4.3.4, stream_engine_base.cpp,
 * out_event: assertion !_io_error). Whether a peer lives is for the HEARTBEAT message to say. */
static fault_code_t set_liveness(transport_t *t, int silence_ms, fault_t *fault)
{
    const int64_t longest = (int64_t)TRANSPORT_SILENCES * silence_ms;
    TRY(set_int(t, ZMQ_HEARTBEAT_IVL, 0, fault));
    TRY(set_int(t, ZMQ_TCP_KEEPALIVE, 1, fault));
    TRY(set_int(t, ZMQ_TCP_KEEPALIVE_IDLE, silence_ms / 1000 + 1, fault));
    TRY(set_int(t, ZMQ_TCP_KEEPALIVE_INTVL, silence_ms / 3000 + 1, fault));
    return set_int(t, ZMQ_TCP_MAXRT, longest < INT_MAX ? (int)longest : INT_MAX, fault);
}

static fault_code_t set_options(transport_t *t, const transport_options_t *options, fault_t *fault)
{
    const int linger = options->linger_ms == 0 ? LINGER_MS : options->linger_ms < 0 ? 0 : options->linger_ms;
    const int queue = options->send_queue > 0 ? options->send_queue : TRANSPORT_QUEUE_SEND;
    const int64_t longest = t->master ? MESSAGE_MAX_FROM_PEER : MESSAGE_MAX_FROM_MASTER;
    if (zmq_setsockopt(t->socket, ZMQ_MAXMSGSIZE, &longest, sizeof longest) != 0)
        return fault_set(fault, FAULT_IO, "message size limit: %s", zmq_strerror(errno));
    TRY(set_int(t, ZMQ_LINGER, linger, fault));
    TRY(set_int(t, ZMQ_SNDHWM, queue, fault));
    TRY(set_int(t, ZMQ_RCVHWM, TRANSPORT_QUEUE_RECEIVE, fault));
    TRY(set_liveness(t, options->silence_ms > 0 ? options->silence_ms : MESSAGE_LEASE_MS, fault));
    TRY(set_int(t, ZMQ_HANDSHAKE_IVL, MESSAGE_HANDSHAKE_MS, fault));
    TRY(set_int(t, ZMQ_IPV6, strchr(t->address, '[') != NULL, fault));
    if (t->master) {
        TRY(set_int(t, ZMQ_ROUTER_MANDATORY, 1, fault));
        TRY(set_int(t, ZMQ_BACKLOG, BACKLOG, fault));
    } else {
        TRY(set_int(t, ZMQ_RECONNECT_IVL, MESSAGE_BACKOFF_MIN_MS, fault));
        TRY(set_int(t, ZMQ_RECONNECT_IVL_MAX, MESSAGE_BACKOFF_MAX_MS, fault));
    }
    return set_security(t, options, fault);
}

static fault_code_t open_end(transport_t *t, fault_t *fault)
{
    if (!t->master) {
        if (zmq_connect(t->socket, t->address) != 0)
            return fault_set(fault, errno == EINVAL ? FAULT_USAGE : FAULT_IO, "cannot connect to %s: %s",
                             t->address, zmq_strerror(errno));
        return FAULT_NONE;
    }
    if (zmq_bind(t->socket, t->address) != 0)
        return fault_set(fault, errno == EINVAL ? FAULT_USAGE : FAULT_IO, "cannot listen at %s: %s", t->address,
                         zmq_strerror(errno));
    size_t size = sizeof t->address;
    if (zmq_getsockopt(t->socket, ZMQ_LAST_ENDPOINT, t->address, &size) != 0)
        return fault_set(fault, FAULT_IO, "address of the socket: %s", zmq_strerror(errno));
    return FAULT_NONE;
}

static fault_code_t make(transport_t **out, const char *address, const transport_options_t *options, bool master,
                         fault_t *fault)
{
    *out = NULL;
    TRY(check_address(address, master, fault));
    transport_t *t = calloc(1, sizeof *t);
    if (!t)
        return fault_set(fault, FAULT_MEMORY, "no memory for a connection");
    zmq_msg_init(&t->frame);
    t->master = master;
    t->heard = clock_now();
    snprintf(t->address, sizeof t->address, "%s", address);
    t->context = zmq_ctx_new();
    t->socket = t->context ? zmq_socket(t->context, master ? ZMQ_ROUTER : ZMQ_DEALER) : NULL;
    static const transport_options_t defaults = {0};
    fault_code_t code;
    if (!t->socket)
        code = fault_set(fault, FAULT_IO, "cannot make a socket: %s", zmq_strerror(errno));
    else if ((code = set_options(t, options ? options : &defaults, fault)) == FAULT_NONE)
        code = open_end(t, fault);
    if (code)
        transport_destroy(&t);
    *out = t;
    return code;
}

fault_code_t transport_bind(transport_t **out, const char *address, const transport_options_t *options,
                            fault_t *fault)
{
    return make(out, address, options, true, fault);
}

fault_code_t transport_connect(transport_t **out, const char *address, const transport_options_t *options,
                               fault_t *fault)
{
    return make(out, address, options, false, fault);
}

void transport_destroy(transport_t **transport)
{
    transport_t *t = *transport;
    *transport = NULL;
    if (!t)
        return;
    zmq_msg_close(&t->frame);
    if (t->socket)
        zmq_close(t->socket);
    while (t->context && zmq_ctx_term(t->context) != 0 && errno == EINTR)
        ;
    free(t);
}

const char *transport_address(const transport_t *transport)
{
    return transport->address;
}

/* ---- sending ---- */

static void free_frame(void *data, void *hint)
{
    (void)hint;
    free(data);
}

static fault_code_t send_fault(const transport_t *t, fault_t *fault)
{
    if (errno == EHOSTUNREACH)
        return fault_set(fault, FAULT_NOT_FOUND, "the peer is no longer connected");
    if (errno == EAGAIN)
        return fault_set(fault, FAULT_LIMIT, "the queue to %s is full, or it broke the connection",
                         t->master ? "the peer" : t->address);
    return fault_set(fault, FAULT_IO, "sending: %s", zmq_strerror(errno));
}

/* Bits 32.. are 1, so that no peer is 0. */
static transport_peer_t peer_of(const uint8_t *id)
{
    return (transport_peer_t)1 << 32 | (uint64_t)id[1] << 24 | (uint64_t)id[2] << 16 | (uint64_t)id[3] << 8 | id[4];
}

static fault_code_t send_route(transport_t *t, transport_peer_t peer, fault_t *fault)
{
    if (peer >> 32 != 1)
        return fault_set(fault, FAULT_NOT_FOUND, "there is no peer %llu", (unsigned long long)peer);
    const uint8_t id[ROUTING_ID_SIZE] = {0, (uint8_t)(peer >> 24), (uint8_t)(peer >> 16), (uint8_t)(peer >> 8),
                                         (uint8_t)peer};
    while (zmq_send(t->socket, id, sizeof id, ZMQ_SNDMORE | ZMQ_DONTWAIT) < 0)
        if (errno != EINTR)
            return send_fault(t, fault);
    return FAULT_NONE;
}

fault_code_t transport_send(transport_t *t, transport_peer_t peer, const message_t *message, fault_t *fault)
{
    if (!(message_senders(message->type) & (unsigned)(t->master ? MESSAGE_FROM_MASTER : MESSAGE_FROM_PEER)))
        return fault_set(fault, FAULT_USAGE, "%s is not for this side to send", message_type_name(message->type));
    uint8_t *data;
    size_t size;
    TRY(message_encode(message, &data, &size, fault));
    zmq_msg_t frame;
    if (zmq_msg_init_data(&frame, data, size, free_frame, NULL) != 0) {
        free(data);
        return fault_set(fault, FAULT_MEMORY, "no memory for a frame of %zu octets", size);
    }
    fault_code_t code = t->master ? send_route(t, peer, fault) : FAULT_NONE;
    while (code == FAULT_NONE && zmq_msg_send(&frame, t->socket, ZMQ_DONTWAIT) < 0)
        if (errno != EINTR)
            code = send_fault(t, fault);
    if (code)
        zmq_msg_close(&frame);
    return code;
}

/* ---- receiving ---- */

fault_code_t transport_wait(transport_t *t, int wake_fd, int timeout_ms, bool *woken, fault_t *fault)
{
    zmq_pollitem_t items[2] = {{.socket = t->socket, .events = ZMQ_POLLIN}, {.fd = wake_fd, .events = ZMQ_POLLIN}};
    if (woken)
        *woken = false;
    const int count = zmq_poll(items, wake_fd >= 0 ? 2 : 1, timeout_ms);
    if (count < 0 && errno != EINTR)
        return fault_set(fault, FAULT_IO, "waiting for messages: %s", zmq_strerror(errno));
    if (woken && count > 0)
        *woken = items[1].revents != 0;
    return FAULT_NONE;
}

/* Reads one ZeroMQ message: its sender, its only body frame into t->frame. False: there is none. *frames counts the
 * body's frames, of which the first is kept; *peer is TRANSPORT_NOBODY if the sender chose its own routing id. */
static bool read_frames(transport_t *t, transport_peer_t *peer, int *frames)
{
    zmq_msg_t part;
    bool first = true;
    int more = 1;
    *peer = t->master ? TRANSPORT_NOBODY : TRANSPORT_MASTER;
    *frames = 0;
    while (more) {
        zmq_msg_init(&part);
        int result;
        do
            result = zmq_msg_recv(&part, t->socket, ZMQ_DONTWAIT);
        while (result < 0 && errno == EINTR);
        if (result < 0) { /* only before the first part: ZeroMQ delivers whole messages */
            zmq_msg_close(&part);
            return !first;
        }
        more = zmq_msg_more(&part);
        const uint8_t *data = zmq_msg_data(&part);
        if (first && t->master) {
            if (zmq_msg_size(&part) == ROUTING_ID_SIZE && data[0] == 0)
                *peer = peer_of(data);
        } else if ((*frames)++ == 0) {
            zmq_msg_move(&t->frame, &part);
        }
        first = false;
        zmq_msg_close(&part);
    }
    return true;
}

static void answer_malformed(transport_t *t, const transport_event_t *event)
{
    message_t refused = {.type = MESSAGE_REFUSED};
    refused.refused.text = event->fault.text;
    refused.refused.code = (uint16_t)event->fault.code;
    refused.refused.request = (uint16_t)event->message.type;
    transport_send(t, event->peer, &refused, NULL); /* a peer that cannot take it has had its chance */
}

static fault_code_t read_message(transport_t *t, int frames, transport_event_t *event)
{
    fault_t *fault = &event->fault;
    if (frames != 1)
        return fault_set(fault, FAULT_PROTOCOL, "a message of %d frames, expected one", frames);
    TRY(message_decode(&event->message, zmq_msg_data(&t->frame), zmq_msg_size(&t->frame), fault));
    const unsigned side = t->master ? MESSAGE_FROM_PEER : MESSAGE_FROM_MASTER;
    if (!(message_senders(event->message.type) & side))
        return fault_set(fault, FAULT_PROTOCOL, "%s is not for a %s to send",
                         message_type_name(event->message.type), t->master ? "peer" : "master");
    return FAULT_NONE;
}

transport_event_kind_t transport_receive(transport_t *t, transport_event_t *event)
{
    memset(event, 0, offsetof(transport_event_t, fault));
    event->fault.code = FAULT_NONE;
    event->fault.text[0] = '\0';
    for (int i = 0; i < RECEIVE_BURST; i++) {
        zmq_msg_close(&t->frame);
        zmq_msg_init(&t->frame);
        int frames;
        if (!read_frames(t, &event->peer, &frames))
            return event->kind = TRANSPORT_NOTHING;
        if (event->peer == TRANSPORT_NOBODY)
            continue; /* it set a routing id: there is nobody to answer */
        if (read_message(t, frames, event) == FAULT_NONE) {
            t->heard = clock_now();
            return event->kind = TRANSPORT_MESSAGE;
        }
        if (t->master)
            answer_malformed(t, event);
        return event->kind = TRANSPORT_MALFORMED;
    }
    return event->kind = TRANSPORT_NOTHING;
}

double transport_silence(const transport_t *transport)
{
    return clock_now() - transport->heard;
}

/* ---- waiting for one thing ---- */

fault_code_t transport_receive_within(transport_t *t, int timeout_ms, transport_event_t *event, fault_t *fault)
{
    const double end = clock_now() + 1e-3 * timeout_ms;
    for (;;) {
        const transport_event_kind_t kind = transport_receive(t, event);
        if (kind == TRANSPORT_MALFORMED)
            return fault_set(fault, event->fault.code, "from %s: %s", t->address, event->fault.text);
        if (kind == TRANSPORT_MESSAGE && event->message.type != MESSAGE_HEARTBEAT)
            return FAULT_NONE;
        if (kind == TRANSPORT_MESSAGE)
            continue;
        const double left = end - clock_now();
        if (left <= 0)
            return fault_set(fault, FAULT_TIMEOUT, "no answer from %s within %g s", t->address, 1e-3 * timeout_ms);
        TRY(transport_wait(t, -1, (int)(1e3 * left) + 1, NULL, fault));
    }
}

static fault_code_t refused_fault(const transport_t *t, const message_refused_t *refused, fault_t *fault)
{
    const fault_code_t code = message_fault_code(refused->code);
    return fault_set(fault, code == FAULT_NONE ? FAULT_PROTOCOL : code, "the master at %s refused: %s", t->address,
                     refused->text);
}

static int left_ms(double end)
{
    const double left = end - clock_now();
    return left > 0 ? (int)(1e3 * left) + 1 : 0;
}

static fault_code_t silence_fault(const transport_t *t, int timeout_ms, fault_t *fault)
{
    return fault_set(fault, FAULT_TIMEOUT,
                     "no answer from %s within %g s: no master listens there, the network drops it, or the "
                     "server key differs",
                     t->address, 1e-3 * timeout_ms);
}

/* A connection that the master broke has no queue until it is made anew: tries again until `end`, then FAULT_LIMIT
 * as transport_send. */
static fault_code_t send_hello(transport_t *t, const message_hello_t *hello, double end, fault_t *fault)
{
    const message_t message = {.type = MESSAGE_HELLO, .hello = *hello};
    for (;;) {
        const fault_code_t code = transport_send(t, TRANSPORT_MASTER, &message, fault);
        const int left = left_ms(end);
        if (code != FAULT_LIMIT || left == 0)
            return code;
        zmq_poll(NULL, 0, left < HELLO_RETRY_MS ? left : HELLO_RETRY_MS);
    }
}

fault_code_t transport_hello(transport_t *t, const message_hello_t *hello, int timeout_ms, transport_event_t *event,
                             fault_t *fault)
{
    const double end = clock_now() + 1e-3 * timeout_ms;
    const fault_code_t sent = send_hello(t, hello, end, fault);
    if (sent == FAULT_LIMIT)
        return silence_fault(t, timeout_ms, fault);
    if (sent)
        return sent;
    for (;;) {
        const fault_code_t code = transport_receive_within(t, left_ms(end), event, fault);
        if (code == FAULT_TIMEOUT)
            return silence_fault(t, timeout_ms, fault);
        if (code)
            return code;
        if (event->message.type == MESSAGE_WELCOME)
            return FAULT_NONE;
        if (event->message.type == MESSAGE_REFUSED)
            return refused_fault(t, &event->message.refused, fault);
    }
}

fault_code_t transport_make_keys(char public_key[TRANSPORT_KEY_SIZE], char secret_key[TRANSPORT_KEY_SIZE],
                                 fault_t *fault)
{
    if (zmq_curve_keypair(public_key, secret_key) != 0)
        return fault_set(fault, FAULT_UNSUPPORTED, "cannot make keys: %s", zmq_strerror(errno));
    return FAULT_NONE;
}
