/* Transport: master and peers in one process, each end used in turn, over ipc and tcp; hostile neighbours are raw
 * ZeroMQ and TCP sockets. */
#include <arpa/inet.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zmq.h>
#include <cmocka.h>

#include "base/clock.h"
#include "proto/transport.h"

enum { PATIENCE_MS = 5000 }; /* far beyond what an exchange within one machine takes */

static fault_t fault;
static transport_event_t event;
static char ipc_address[128];

static void ok(fault_code_t code)
{
    if (code)
        fail_msg("code %d: %s", code, fault.text);
}

static const message_hello_t WORKER_HELLO = {.garland_version = GARLAND_VERSION,
                                             .role = MESSAGE_ROLE_WORKER,
                                             .arch = GARLAND_ARCH,
                                             .host = "h",
                                             .threads = 2};

/* The next event of an end; fails the test if none comes. */
static transport_event_kind_t next(transport_t *t)
{
    const double end = clock_now() + 1e-3 * PATIENCE_MS;
    while (transport_receive(t, &event) == TRANSPORT_NOTHING) {
        if (clock_now() > end)
            fail_msg("nothing came within %d ms", PATIENCE_MS);
        ok(transport_wait(t, -1, 50, NULL, &fault));
    }
    return event.kind;
}

static transport_peer_t expect(transport_t *t, message_type_t type)
{
    if (next(t) != TRANSPORT_MESSAGE)
        fail_msg("malformed: %s", event.fault.text);
    assert_string_equal(message_type_name(event.message.type), message_type_name(type));
    return event.peer;
}

static void say_hello(transport_t *peer)
{
    const message_t hello = {.type = MESSAGE_HELLO, .hello = WORKER_HELLO};
    ok(transport_send(peer, TRANSPORT_MASTER, &hello, &fault));
}

static void say_welcome(transport_t *master, transport_peer_t peer)
{
    message_t welcome = {.type = MESSAGE_WELCOME};
    welcome.welcome = (message_welcome_t){GARLAND_VERSION, MESSAGE_HEARTBEAT_MS, MESSAGE_LEASE_MS, 77};
    ok(transport_send(master, peer, &welcome, &fault));
}

/* Both ways: HELLO, WELCOME, READY, WORK with a large record. */
static void exchange(transport_t *master, transport_t *peer)
{
    say_hello(peer);
    const transport_peer_t who = expect(master, MESSAGE_HELLO);
    assert_string_equal(event.message.hello.arch, GARLAND_ARCH);
    say_welcome(master, who);
    expect(peer, MESSAGE_WELCOME);
    assert_int_equal(event.peer, TRANSPORT_MASTER);
    assert_int_equal(event.message.welcome.session, 77);
    message_t message = {.type = MESSAGE_READY};
    message.ready.slots = 3;
    ok(transport_send(peer, TRANSPORT_MASTER, &message, &fault));
    assert_true(expect(master, MESSAGE_READY) == who);
    assert_int_equal(event.message.ready.slots, 3);
    uint8_t *record = malloc(MESSAGE_MAX_RECORD);
    for (size_t i = 0; i < MESSAGE_MAX_RECORD; i++)
        record[i] = (uint8_t)(i * 7 + i / 251);
    message = (message_t){.type = MESSAGE_WORK};
    message.work.lease = (message_lease_t){1, 2, 3};
    message.work.record = (message_bytes_t){record, MESSAGE_MAX_RECORD};
    ok(transport_send(master, who, &message, &fault));
    expect(peer, MESSAGE_WORK);
    assert_int_equal(event.message.work.lease.attempt, 3);
    assert_memory_equal(event.message.work.record.data, record, MESSAGE_MAX_RECORD);
    free(record);
}

static void exchange_at(const char *address)
{
    transport_t *master, *peer;
    ok(transport_bind(&master, address, NULL, &fault));
    ok(transport_connect(&peer, transport_address(master), NULL, &fault));
    exchange(master, peer);
    transport_destroy(&peer);
    assert_null(peer);
    transport_destroy(&peer);
    transport_destroy(&master);
}

static void messages_pass_over_tcp(void **state)
{
    (void)state;
    exchange_at("tcp://127.0.0.1:*");
    exchange_at("tcp://127.0.0.1:0");
}

static void messages_pass_over_ipc(void **state)
{
    (void)state;
    exchange_at(ipc_address);
}

static void addresses_are_checked(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "",      "127.0.0.1:5", "tcp://", "tcp://host", "udp://a:1", "tcp://127.0.0.1:x", "tcp://127.0.0.1:99999",
        "ipc://"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        transport_t *t;
        fault.text[0] = '\0';
        assert_int_equal(transport_bind(&t, bad[i], NULL, &fault), FAULT_USAGE);
        assert_null(t);
        assert_non_null(strstr(fault.text, bad[i]));
        assert_int_equal(transport_connect(&t, bad[i], NULL, &fault), FAULT_USAGE);
        assert_null(t);
    }
    transport_t *first, *second;
    ok(transport_bind(&first, "tcp://127.0.0.1:0", NULL, &fault));
    assert_int_equal(transport_bind(&second, transport_address(first), NULL, &fault), FAULT_IO);
    assert_non_null(strstr(fault.text, transport_address(first)));
    transport_destroy(&first);
}

static void silence_is_a_fault_that_says_so(void **state)
{
    (void)state;
    transport_t *master, *peer;
    ok(transport_bind(&master, "tcp://127.0.0.1:0", NULL, &fault));
    ok(transport_connect(&peer, transport_address(master), NULL, &fault));
    const double start = clock_now();
    assert_int_equal(transport_hello(peer, &WORKER_HELLO, 300, &event, &fault), FAULT_TIMEOUT);
    assert_true(clock_now() - start >= 0.299);
    assert_true(transport_silence(peer) >= 0.299);
    assert_non_null(strstr(fault.text, "no answer"));
    assert_non_null(strstr(fault.text, "0.3 s"));
    assert_non_null(strstr(fault.text, transport_address(master)));
    transport_destroy(&peer);
    transport_destroy(&master);
    /* nobody listens at all: connecting succeeds, the hello does not */
    ok(transport_connect(&peer, "tcp://127.0.0.1:1", &(transport_options_t){.linger_ms = -1}, &fault));
    assert_int_equal(transport_hello(peer, &WORKER_HELLO, 100, &event, &fault), FAULT_TIMEOUT);
    transport_destroy(&peer);
}

/* ---- hostile neighbours ---- */

typedef struct raw {
    void *context, *socket;
} raw_t;

static raw_t raw_connect(const char *address, const char *routing_id)
{
    raw_t raw = {.context = zmq_ctx_new()};
    raw.socket = zmq_socket(raw.context, ZMQ_DEALER);
    const int linger = 0, wait = PATIENCE_MS;
    zmq_setsockopt(raw.socket, ZMQ_LINGER, &linger, sizeof linger);
    zmq_setsockopt(raw.socket, ZMQ_RCVTIMEO, &wait, sizeof wait);
    if (routing_id)
        zmq_setsockopt(raw.socket, ZMQ_ROUTING_ID, routing_id, strlen(routing_id));
    assert_int_equal(zmq_connect(raw.socket, address), 0);
    return raw;
}

static void raw_close(raw_t *raw)
{
    zmq_close(raw->socket);
    zmq_ctx_term(raw->context);
}

/* What a peer of another version would see: the text, read with its own eyes (header 8 octets, length, text). */
static void read_refusal(raw_t *raw, char *text, size_t size)
{
    uint8_t frame[8192];
    const int length = zmq_recv(raw->socket, frame, sizeof frame, 0);
    assert_true(length > 12 && length <= (int)sizeof frame);
    assert_memory_equal(frame, "GRLD\1\0\3\0", 8);
    const size_t count = frame[8] | (size_t)frame[9] << 8;
    assert_true(count < size && 12 + count < (size_t)length);
    memcpy(text, frame + 12, count);
    text[count] = '\0';
}

static void another_version_is_refused_with_both_versions(void **state)
{
    (void)state;
    transport_t *master;
    ok(transport_bind(&master, ipc_address, NULL, &fault));
    raw_t raw = raw_connect(ipc_address, NULL);
    static const char hello[] = "GRLD\x2a\0\1\0\5\0\0\0"
                                "9.8.7\0"
                                "whatever comes in version 42";
    assert_int_equal(zmq_send(raw.socket, hello, sizeof hello - 1, 0), sizeof hello - 1);
    assert_int_equal(next(master), TRANSPORT_MALFORMED);
    assert_int_equal(event.fault.code, FAULT_VERSION);
    char text[4200];
    read_refusal(&raw, text, sizeof text);
    assert_non_null(strstr(text, "version 42"));
    assert_non_null(strstr(text, "9.8.7"));
    assert_non_null(strstr(text, "version 1"));
    assert_non_null(strstr(text, GARLAND_VERSION));
    raw_close(&raw);
    transport_destroy(&master);
}

static void a_peer_learns_of_a_newer_master(void **state)
{
    (void)state;
    void *context = zmq_ctx_new(), *router = zmq_socket(context, ZMQ_ROUTER);
    assert_int_equal(zmq_bind(router, ipc_address), 0);
    transport_t *peer;
    ok(transport_connect(&peer, ipc_address, NULL, &fault));
    say_hello(peer);
    char id[256], body[1024];
    const int id_size = zmq_recv(router, id, sizeof id, 0);
    assert_true(id_size > 0 && zmq_recv(router, body, sizeof body, 0) > 8);
    static const char refused[] = "GRLD\x07\0\3\0\x0e\0\0\0"
                                  "I am Garland 7\0new fields";
    zmq_send(router, id, (size_t)id_size, ZMQ_SNDMORE);
    zmq_send(router, refused, sizeof refused - 1, 0);
    assert_int_equal(transport_hello(peer, &WORKER_HELLO, PATIENCE_MS, &event, &fault), FAULT_VERSION);
    assert_non_null(strstr(fault.text, "I am Garland 7"));
    transport_destroy(&peer);
    zmq_close(router);
    zmq_ctx_term(context);
}

static void garbage_disturbs_nobody_else(void **state)
{
    (void)state;
    transport_t *master, *good;
    ok(transport_bind(&master, "tcp://127.0.0.1:0", NULL, &fault));
    const char *address = transport_address(master);
    ok(transport_connect(&good, address, NULL, &fault));
    raw_t raw = raw_connect(address, NULL), named = raw_connect(address, "i-chose-this");
    static const char *const garbage[] = {"", "G", "GRLD", "HTTP/1.1 400", "GRLD\1\0\2\0", "GRLD\1\0\x63\0"};
    for (size_t i = 0; i < sizeof garbage / sizeof *garbage; i++) {
        const size_t size = i < 4 ? strlen(garbage[i]) : 8;
        assert_int_equal(zmq_send(raw.socket, garbage[i], size, 0), size);
        assert_int_equal(next(master), TRANSPORT_MALFORMED);
        char text[4200];
        read_refusal(&raw, text, sizeof text);
        assert_true(text[0] != '\0');
    }
    /* two frames */
    zmq_send(raw.socket, "GRLD\1\0\5\0\0\0\0\0", 12, ZMQ_SNDMORE);
    zmq_send(raw.socket, "more", 4, 0);
    assert_int_equal(next(master), TRANSPORT_MALFORMED);
    assert_non_null(strstr(event.fault.text, "2 frames"));
    /* a peer with a routing id of its own is not heard */
    zmq_send(named.socket, "GRLD\1\0\5\0\0\0\0\0", 12, 0);
    usleep(50000);
    exchange(master, good);
    raw_close(&raw);
    raw_close(&named);
    transport_destroy(&good);
    transport_destroy(&master);
}

/* A plain TCP client that speaks no ZeroMQ. */
static void plain_tcp_disturbs_nobody(void **state)
{
    (void)state;
    transport_t *master, *good;
    ok(transport_bind(&master, "tcp://127.0.0.1:0", NULL, &fault));
    struct sockaddr_in to = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    to.sin_port = htons((uint16_t)atoi(strrchr(transport_address(master), ':') + 1));
    const int plain = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(connect(plain, (struct sockaddr *)&to, sizeof to), 0);
    assert_true(write(plain, "GET / HTTP/1.1\r\n\r\n", 18) == 18);
    ok(transport_connect(&good, transport_address(master), NULL, &fault));
    exchange(master, good);
    close(plain);
    transport_destroy(&good);
    transport_destroy(&master);
}

/* A peer that speaks ZMTP 3.0 (RFC 23) by hand and announces a frame of `size` octets without sending it. */
static int announce_frame(const char *address, uint64_t size)
{
    struct sockaddr_in to = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    to.sin_port = htons((uint16_t)atoi(strrchr(address, ':') + 1));
    const int peer = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(connect(peer, (struct sockaddr *)&to, sizeof to), 0);
    uint8_t greeting[64] = {[0] = 0xff, [9] = 0x7f, [10] = 3, 0, 'N', 'U', 'L', 'L'};
    static const char ready[] = "\4\x1c\5READY\x0bSocket-Type\0\0\0\6DEALER";
    uint8_t header[9] = {2};
    for (int i = 0; i < 8; i++)
        header[1 + i] = (uint8_t)(size >> (56 - 8 * i));
    assert_int_equal(write(peer, greeting, sizeof greeting), sizeof greeting);
    assert_int_equal(write(peer, ready, sizeof ready - 1), sizeof ready - 1);
    assert_int_equal(write(peer, header, sizeof header), sizeof header);
    return peer;
}

/* Whether the other side ends the connection within the time; what it says before is passed over. */
static bool is_ended(int peer, int timeout_ms)
{
    const double end = clock_now() + 1e-3 * timeout_ms;
    uint8_t data[256];
    struct pollfd poller = {.fd = peer, .events = POLLIN};
    while (clock_now() < end)
        if (poll(&poller, 1, 20) > 0 && read(peer, data, sizeof data) <= 0)
            return true;
    return false;
}

static void an_overlong_frame_ends_its_own_connection(void **state)
{
    (void)state;
    transport_t *master, *good;
    ok(transport_bind(&master, "tcp://127.0.0.1:0", NULL, &fault));
    ok(transport_connect(&good, transport_address(master), NULL, &fault));
    const int within = announce_frame(transport_address(master), 1 << 20);
    const int beyond = announce_frame(transport_address(master), (uint64_t)MESSAGE_MAX_FROM_PEER + 1);
    const int absurd = announce_frame(transport_address(master), UINT64_MAX >> 1);
    assert_true(is_ended(beyond, PATIENCE_MS));
    assert_true(is_ended(absurd, PATIENCE_MS));
    assert_false(is_ended(within, 100));
    exchange(master, good);
    close(within);
    close(beyond);
    close(absurd);
    transport_destroy(&good);
    transport_destroy(&master);
}

static void a_peer_does_not_take_an_overlong_frame(void **state)
{
    (void)state;
    void *context = zmq_ctx_new(), *router = zmq_socket(context, ZMQ_ROUTER);
    assert_int_equal(zmq_bind(router, ipc_address), 0);
    transport_t *peer;
    char id[256], body[1024];
    for (int round = 0; round < 2; round++) {
        ok(transport_connect(&peer, ipc_address, NULL, &fault));
        say_hello(peer);
        const int id_size = zmq_recv(router, id, sizeof id, 0);
        assert_true(id_size > 0 && zmq_recv(router, body, sizeof body, 0) > 8);
        /* a BYE, as long as it says and otherwise in order: of 16 MiB + 1, then short */
        const size_t text = round == 0 ? (size_t)MESSAGE_MAX_FROM_MASTER + 1 - 13 : 5, size = text + 13;
        char *bye = calloc(1, size);
        memcpy(bye, "GRLD\1\0\6\0", 8);
        for (int i = 0; i < 4; i++)
            bye[8 + i] = (char)(text >> (8 * i));
        memset(bye + 12, 'x', text);
        zmq_send(router, id, (size_t)id_size, ZMQ_SNDMORE);
        zmq_send(router, bye, size, 0);
        free(bye);
        if (round == 0)
            assert_int_equal(transport_receive_within(peer, 500, &event, &fault), FAULT_TIMEOUT);
        else
            expect(peer, MESSAGE_BYE);
        transport_destroy(&peer);
    }
    zmq_close(router);
    zmq_ctx_term(context);
}

/* ---- coming and going ---- */

static void a_peer_reconnects_after_the_master_restarts(void **state)
{
    (void)state;
    transport_t *master, *peer;
    ok(transport_bind(&master, "tcp://127.0.0.1:0", NULL, &fault));
    char address[128];
    snprintf(address, sizeof address, "%s", transport_address(master));
    ok(transport_connect(&peer, address, NULL, &fault));
    exchange(master, peer);
    transport_destroy(&master);
    ok(transport_bind(&master, address, NULL, &fault));
    /* the restarted master knows nobody, and says so to whatever comes first */
    const message_t heartbeat = {.type = MESSAGE_HEARTBEAT}, wanted = {.type = MESSAGE_HELLO_WANTED};
    ok(transport_send(peer, TRANSPORT_MASTER, &heartbeat, &fault));
    ok(transport_send(master, expect(master, MESSAGE_HEARTBEAT), &wanted, &fault));
    expect(peer, MESSAGE_HELLO_WANTED);
    exchange(master, peer);
    transport_destroy(&peer);
    transport_destroy(&master);
}

static void a_peer_that_left_is_not_found(void **state)
{
    (void)state;
    transport_t *master, *peer;
    ok(transport_bind(&master, ipc_address, NULL, &fault));
    ok(transport_connect(&peer, ipc_address, NULL, &fault));
    say_hello(peer);
    const transport_peer_t who = expect(master, MESSAGE_HELLO);
    transport_destroy(&peer);
    const message_t heartbeat = {.type = MESSAGE_HEARTBEAT};
    fault_code_t code = FAULT_NONE;
    for (int i = 0; i < 100 && code == FAULT_NONE; i++) {
        usleep(20000);
        transport_receive(master, &event);
        code = transport_send(master, who, &heartbeat, &fault);
    }
    assert_int_equal(code, FAULT_NOT_FOUND);
    assert_int_equal(transport_send(master, TRANSPORT_NOBODY, &heartbeat, &fault), FAULT_NOT_FOUND);
    assert_int_equal(transport_send(master, TRANSPORT_MASTER, &heartbeat, &fault), FAULT_NOT_FOUND);
    transport_destroy(&master);
}

static void a_full_queue_is_told(void **state)
{
    (void)state;
    transport_t *master, *peer;
    ok(transport_bind(&master, ipc_address, &(transport_options_t){.send_queue = 4, .linger_ms = -1}, &fault));
    ok(transport_connect(&peer, ipc_address, NULL, &fault));
    say_hello(peer);
    const transport_peer_t who = expect(master, MESSAGE_HELLO);
    uint8_t *bytes = calloc(1, MESSAGE_MAX_CHUNK);
    message_t data = {.type = MESSAGE_BUNDLE_DATA};
    data.chunk.total = data.chunk.bytes.size = MESSAGE_MAX_CHUNK;
    data.chunk.bytes.data = bytes;
    fault_code_t code = FAULT_NONE;
    int sent = 0; /* both queues and the kernel's buffers are far below 200 MiB */
    while (sent < 200 && (code = transport_send(master, who, &data, &fault)) == FAULT_NONE)
        sent++;
    assert_int_equal(code, FAULT_LIMIT);
    assert_non_null(strstr(fault.text, "full"));
    for (int i = 0; i < sent; i++) /* what was accepted arrives */
        expect(peer, MESSAGE_BUNDLE_DATA);
    free(bytes);
    transport_destroy(&peer);
    transport_destroy(&master);
}

/* ---- a connection that breaks while its receive queue is full ---- */

enum {
    UNREAD = 60, /* beyond the receive queue, within the send queue */
    SITTING_MS =
        MESSAGE_HEARTBEAT_MS + 500 /* in it a heartbeat of ZeroMQ's own, if there were one, would fall due */
};

/* Runs one side in a process of its own, where it may abort. */
static pid_t start_side(bool (*side)(const char *address), const char *address)
{
    const pid_t child = fork();
    if (child == 0)
        _exit(side(address) ? 0 : 1);
    assert_true(child > 0);
    return child;
}

static void expect_survival(pid_t child)
{
    int status = -1;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
}

static void send_unread(transport_t *t, transport_peer_t peer)
{
    const message_t heartbeat = {.type = MESSAGE_HEARTBEAT};
    for (int i = 0; i < UNREAD; i++)
        ok(transport_send(t, peer, &heartbeat, &fault));
    usleep(300000); /* they are on their way */
}

/* Reads nothing for a while, then greets the next master. */
static bool sit_as_a_client(const char *address)
{
    transport_t *peer;
    if (transport_connect(&peer, address, NULL, &fault))
        return false;
    const message_t hello = {.type = MESSAGE_HELLO, .hello = WORKER_HELLO};
    transport_send(peer, TRANSPORT_MASTER, &hello, &fault);
    usleep(1000 * SITTING_MS);
    int count = 0;
    while (transport_receive(peer, &event) == TRANSPORT_MESSAGE)
        count++;
    const fault_code_t code = transport_hello(peer, &WORKER_HELLO, PATIENCE_MS, &event, &fault);
    transport_destroy(&peer);
    return code == FAULT_NONE && count >= TRANSPORT_QUEUE_RECEIVE;
}

/* Reads nothing for a while, then answers each HELLO until a BYE. */
static bool sit_as_a_master(const char *address)
{
    transport_t *master;
    if (transport_bind(&master, address, NULL, &fault))
        return false;
    usleep(1000 * SITTING_MS);
    const double end = clock_now() + 1e-3 * PATIENCE_MS;
    int count = 0;
    for (bool bye = false; !bye && clock_now() < end; transport_wait(master, -1, 50, NULL, &fault))
        for (; transport_receive(master, &event) == TRANSPORT_MESSAGE; count++) {
            message_t welcome = {.type = MESSAGE_WELCOME};
            welcome.welcome = (message_welcome_t){GARLAND_VERSION, MESSAGE_HEARTBEAT_MS, MESSAGE_LEASE_MS, 78};
            bye |= event.message.type == MESSAGE_BYE;
            if (event.message.type == MESSAGE_HELLO)
                transport_send(master, event.peer, &welcome, &fault); /* the first to say so has left */
        }
    transport_destroy(&master);
    return clock_now() < end && count >= TRANSPORT_QUEUE_RECEIVE;
}

static void a_connection_that_breaks_with_a_full_queue_harms_neither_side(void **state)
{
    (void)state;
    char other_address[sizeof ipc_address + 2];
    snprintf(other_address, sizeof other_address, "%s-2", ipc_address);
    const pid_t client = start_side(sit_as_a_client, ipc_address);
    const pid_t server = start_side(sit_as_a_master, other_address);
    transport_t *master, *peer;
    ok(transport_bind(&master, ipc_address, NULL, &fault));
    send_unread(master, expect(master, MESSAGE_HELLO));
    transport_destroy(&master);
    ok(transport_connect(&peer, other_address, NULL, &fault));
    say_hello(peer);
    send_unread(peer, TRANSPORT_MASTER);
    transport_destroy(&peer);

    ok(transport_bind(&master, ipc_address, NULL, &fault));
    say_welcome(master, expect(master, MESSAGE_HELLO));
    ok(transport_connect(&peer, other_address, NULL, &fault));
    ok(transport_hello(peer, &WORKER_HELLO, PATIENCE_MS, &event, &fault));
    const message_t bye = {.type = MESSAGE_BYE};
    ok(transport_send(peer, TRANSPORT_MASTER, &bye, &fault));
    expect_survival(client);
    expect_survival(server);
    transport_destroy(&peer);
    transport_destroy(&master);
    unlink(other_address + strlen("ipc://"));
}

static void each_side_sends_only_what_is_its_own(void **state)
{
    (void)state;
    transport_t *master, *peer;
    ok(transport_bind(&master, ipc_address, NULL, &fault));
    ok(transport_connect(&peer, ipc_address, NULL, &fault));
    message_t message = {.type = MESSAGE_SHUTDOWN};
    assert_int_equal(transport_send(peer, TRANSPORT_MASTER, &message, &fault), FAULT_USAGE);
    message.type = MESSAGE_READY;
    assert_int_equal(transport_send(master, UINT64_C(1) << 32, &message, &fault), FAULT_USAGE);
    transport_destroy(&peer);
    transport_destroy(&master);
}

static void another_thread_can_wake_the_wait(void **state)
{
    (void)state;
    transport_t *master;
    ok(transport_bind(&master, ipc_address, NULL, &fault));
    const int wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    bool woken = true;
    ok(transport_wait(master, wake, 1, &woken, &fault));
    assert_false(woken);
    eventfd_write(wake, 1);
    const double start = clock_now();
    ok(transport_wait(master, wake, PATIENCE_MS, &woken, &fault));
    assert_true(woken);
    assert_true(clock_now() - start < 1e-3 * PATIENCE_MS);
    close(wake);
    transport_destroy(&master);
}

/* ---- keys ---- */

static void keys_admit_only_those_who_know_them(void **state)
{
    (void)state;
    char public_key[TRANSPORT_KEY_SIZE], secret_key[TRANSPORT_KEY_SIZE], other[TRANSPORT_KEY_SIZE],
        unused[TRANSPORT_KEY_SIZE];
    ok(transport_make_keys(public_key, secret_key, &fault));
    ok(transport_make_keys(other, unused, &fault));
    transport_t *master, *good, *wrong, *without;
    const transport_options_t none = {.linger_ms = -1};
    ok(transport_bind(&master, "tcp://127.0.0.1:0", &(transport_options_t){.secret_key = secret_key}, &fault));
    const char *address = transport_address(master);
    ok(transport_connect(&good, address, &(transport_options_t){.server_key = public_key}, &fault));
    ok(transport_connect(&wrong, address, &(transport_options_t){.server_key = other, .linger_ms = -1}, &fault));
    ok(transport_connect(&without, address, &none, &fault));
    assert_int_equal(transport_hello(wrong, &WORKER_HELLO, 200, &event, &fault), FAULT_TIMEOUT);
    assert_non_null(strstr(fault.text, "key"));
    assert_int_equal(transport_hello(without, &WORKER_HELLO, 200, &event, &fault), FAULT_TIMEOUT);
    exchange(master, good);
    assert_int_equal(transport_receive(master, &event), TRANSPORT_NOTHING);
    transport_t *bad;
    assert_int_equal(transport_connect(&bad, address, &(transport_options_t){.server_key = "short"}, &fault),
                     FAULT_USAGE);
    transport_destroy(&good);
    transport_destroy(&wrong);
    transport_destroy(&without);
    transport_destroy(&master);
}

static int make_folder(void **state)
{
    static char folder[] = "/tmp/garland-transport-XXXXXX";
    *state = mkdtemp(folder);
    snprintf(ipc_address, sizeof ipc_address, "ipc://%s/socket", folder);
    return *state ? 0 : -1;
}

static int remove_folder(void **state)
{
    unlink(ipc_address + strlen("ipc://"));
    return rmdir(*state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(messages_pass_over_tcp),
        cmocka_unit_test(messages_pass_over_ipc),
        cmocka_unit_test(addresses_are_checked),
        cmocka_unit_test(silence_is_a_fault_that_says_so),
        cmocka_unit_test(another_version_is_refused_with_both_versions),
        cmocka_unit_test(a_peer_learns_of_a_newer_master),
        cmocka_unit_test(garbage_disturbs_nobody_else),
        cmocka_unit_test(plain_tcp_disturbs_nobody),
        cmocka_unit_test(an_overlong_frame_ends_its_own_connection),
        cmocka_unit_test(a_peer_does_not_take_an_overlong_frame),
        cmocka_unit_test(a_peer_reconnects_after_the_master_restarts),
        cmocka_unit_test(a_peer_that_left_is_not_found),
        cmocka_unit_test(a_full_queue_is_told),
        cmocka_unit_test(a_connection_that_breaks_with_a_full_queue_harms_neither_side),
        cmocka_unit_test(each_side_sends_only_what_is_its_own),
        cmocka_unit_test(another_thread_can_wake_the_wait),
        cmocka_unit_test(keys_admit_only_those_who_know_them),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
