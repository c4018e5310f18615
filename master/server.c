#include "master/server.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "master/server_internal.h"

static const double progress_interval = 0.5; /* seconds between PROGRESS messages */
static const double slice = 0.25;            /* seconds of messages between two looks at everything else */
enum { WAIT_IDLE_MS = 500, WAIT_BUSY_MS = 100 };

/* ---- making ---- */

static fault_code_t open_parts(server_t *server, fault_t *fault)
{
    const server_options_t *options = &server->options;
    TRY(store_open(&server->store, options->state, !options->no_sync, fault));
    server->peers = peers_new();
    server->chunk = malloc(MESSAGE_MAX_CHUNK);
    server->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (!server->peers || !server->chunk || server->wake_fd < 0)
        return fault_set(fault, FAULT_MEMORY, "no memory for a server");
    const run_options_t runs = {.wake_fd = server->wake_fd, .lease_seconds = server->lease};
    TRY(job_table_new(&server->jobs, server->store, &runs, fault));
    const transport_options_t transport = {.secret_key = options->secret_key,
                                           .silence_ms = (int)(1000 * server->lease)};
    return transport_bind(&server->transport, options->address, &transport, fault);
}

fault_code_t server_new(server_t **out, const server_options_t *options, fault_t *fault)
{
    *out = NULL;
    server_t *server = calloc(1, sizeof *server);
    if (!server)
        return fault_set(fault, FAULT_MEMORY, "no memory for a server");
    server->options = *options;
    server->wake_fd = -1;
    server->began = clock_now();
    server->lease = options->lease_seconds > 0 ? options->lease_seconds : MESSAGE_LEASE_MS / 1000.0;
    server->heartbeat =
        fmin(MESSAGE_HEARTBEAT_MS / 1000.0, fmax(MESSAGE_MIN_INTERVAL_MS / 1000.0, server->lease / 5));
    const fault_code_t code = open_parts(server, fault);
    if (code != FAULT_NONE) {
        server_destroy(&server);
        return code;
    }
    *out = server;
    return FAULT_NONE;
}

void server_destroy(server_t **pointer)
{
    server_t *server = *pointer;
    if (!server)
        return;
    transport_destroy(&server->transport);
    job_table_destroy(&server->jobs);
    peers_destroy(&server->peers);
    store_close(&server->store);
    if (server->wake_fd >= 0)
        close(server->wake_fd);
    free(server->chunk);
    free(server);
    *pointer = NULL;
}

const char *server_address(const server_t *server)
{
    return transport_address(server->transport);
}

void server_stop(server_t *server)
{
    const int error = errno;
    const uint64_t one = 1;
    atomic_store(&server->stop, true);
    const ssize_t written = write(server->wake_fd, &one, sizeof one);
    (void)written; /* full: the loop is awake already */
    errno = error;
}

/* ---- sending ---- */

fault_code_t server_send(server_t *server, const peer_t *peer, const message_t *message)
{
    fault_t fault = {0};
    if (peer->address == TRANSPORT_NOBODY)
        return FAULT_NOT_FOUND;
    const fault_code_t code = transport_send(server->transport, peer->address, message, &fault);
    if (code != FAULT_NONE)
        log_debug("%s to %s (%" PRIu32 "): %s", message_type_name(message->type), peer->host, peer->pid,
                  fault.text);
    return code;
}

static void refuse_address(server_t *server, transport_peer_t address, message_type_t request, uint64_t job,
                           fault_code_t code, const char *text)
{
    message_t refused = {.type = MESSAGE_REFUSED};
    refused.refused =
        (message_refused_t){.text = text, .code = (uint16_t)code, .request = (uint16_t)request, .job = job};
    fault_t fault = {0};
    if (transport_send(server->transport, address, &refused, &fault) != FAULT_NONE)
        log_debug("REFUSED: %s", fault.text);
}

void server_refuse(server_t *server, const peer_t *peer, message_type_t request, uint64_t job, fault_code_t code,
                   const char *text)
{
    refuse_address(server, peer->address, request, job, code, text);
}

/* ---- peers ---- */

void server_forget_peer(server_t *server, peer_t *peer, const char *why)
{
    if (peer->role == MESSAGE_ROLE_WORKER) {
        size_t lost = 0;
        for (size_t i = 0; i < job_table_active_count(server->jobs); i++)
            lost += run_drop_worker(job_table_active(server->jobs, i), peer->session);
        log_info("worker %s (%" PRIu32 ") %s; %zu units go to others", peer->host, peer->pid, why, lost);
    }
    peers_remove(server->peers, peer);
}

/* In a time that tells nothing of where they differ. */
static bool same_secret(const char *a, const char *b)
{
    const size_t length = strlen(a);
    if (strlen(b) != length)
        return false;
    unsigned difference = 0;
    for (size_t i = 0; i < length; i++)
        difference |= (unsigned char)a[i] ^ (unsigned char)b[i];
    return difference == 0;
}

/* Why a HELLO is turned down, or null. */
static const char *objection(const server_t *server, const message_hello_t *hello, fault_code_t *code, char *text,
                             size_t size)
{
    const char *token = server->options.token;
    if (token && !same_secret(token, hello->token)) {
        *code = FAULT_USAGE;
        return "the token is wrong or missing";
    }
    if (hello->role != MESSAGE_ROLE_WORKER)
        return NULL;
    *code = FAULT_VERSION;
    if (strcmp(hello->garland_version, GARLAND_VERSION) != 0) {
        snprintf(text, size, "the worker is Garland %.64s, the master %s: their results may differ",
                 hello->garland_version, GARLAND_VERSION);
        return text;
    }
    if (strcmp(hello->arch, GARLAND_ARCH) != 0) {
        snprintf(text, size, "the worker was built for %.64s, the master for %s: their results may differ",
                 hello->arch, GARLAND_ARCH);
        return text;
    }
    return NULL;
}

static void greet(server_t *server, transport_peer_t address, const message_hello_t *hello, double now)
{
    char text[256];
    fault_code_t code = FAULT_NONE;
    fault_t fault = {0};
    peer_t *peer;
    const char *why = objection(server, hello, &code, text, sizeof text);
    if (!why && peers_greet(server->peers, address, hello, now, &peer, &fault) != FAULT_NONE) {
        why = fault.text;
        code = fault.code;
    }
    if (why) {
        refuse_address(server, address, MESSAGE_HELLO, 0, code, why);
        return;
    }
    if (peer->role == MESSAGE_ROLE_WORKER)
        log_info("worker %s (%" PRIu32 ") with %" PRIu32 " threads", peer->host, peer->pid, peer->threads);
    message_t welcome = {.type = MESSAGE_WELCOME};
    welcome.welcome = (message_welcome_t){.garland_version = GARLAND_VERSION,
                                          .heartbeat_ms = (uint32_t)lround(1000 * server->heartbeat),
                                          .lease_ms = (uint32_t)lround(1000 * server->lease),
                                          .session = peer->session};
    server_send(server, peer, &welcome);
}

static void handle(server_t *server, const transport_event_t *event, double now)
{
    if (event->kind == TRANSPORT_MALFORMED) {
        log_debug("malformed message: %s", event->fault.text);
        return;
    }
    const message_t *message = &event->message;
    if (message->type == MESSAGE_HELLO) {
        greet(server, event->peer, &message->hello, now);
        return;
    }
    peer_t *peer = peers_find(server->peers, event->peer);
    if (!peer) {
        const message_t wanted = {.type = MESSAGE_HELLO_WANTED};
        fault_t fault = {0};
        if (message->type != MESSAGE_BYE && transport_send(server->transport, event->peer, &wanted, &fault))
            log_debug("HELLO_WANTED: %s", fault.text);
        return;
    }
    peer->heard = now;
    if (message->type == MESSAGE_BYE)
        server_forget_peer(server, peer, "leaves");
    else if (peer->role == MESSAGE_ROLE_WORKER)
        serve_worker(server, peer, message, now);
    else
        serve_client(server, peer, message, now);
}

/* ---- the loop ---- */

/* Takes what has come in; false if there is more. */
static bool receive_all(server_t *server)
{
    const double end = clock_now() + slice;
    transport_event_t event;
    while (transport_receive(server->transport, &event) != TRANSPORT_NOTHING) {
        const double now = clock_now();
        handle(server, &event, now);
        if (now > end)
            return false;
    }
    return true;
}

static void send_heartbeats(server_t *server, double now)
{
    const message_t beat = {.type = MESSAGE_HEARTBEAT};
    for (size_t i = 0; i < peers_count(server->peers); i++) {
        peer_t *peer = peers_at(server->peers, i);
        if (now < peer->beat + server->heartbeat)
            continue;
        peer->beat = now;
        server_send(server, peer, &beat);
    }
}

static void drop_silent(server_t *server, double now)
{
    for (size_t i = peers_count(server->peers); i-- > 0;) {
        peer_t *peer = peers_at(server->peers, i);
        if (now - peer->heard > server->lease)
            server_forget_peer(server, peer, "has fallen silent");
    }
    for (size_t i = 0; i < job_table_active_count(server->jobs); i++)
        run_expire(job_table_active(server->jobs, i), now);
}

static void on_change(void *context, run_t *run)
{
    server_t *server = context;
    if (run_get_state(run) == RUN_FINISHING || run_has_ended(run)) {
        serve_cancel_work(server, run_id(run));
        server->next_progress = 0;
    }
}

/* Everything but messages. Returns how long to wait for the next one, in milliseconds. */
static int care(server_t *server, bool heard_all)
{
    const double now = clock_now();
    double next = INFINITY;
    /* Before the disk is waited for and errors are estimated, so that workers go on meanwhile; and after, as what
     * was learned may free units. */
    serve_dispatch(server, now);
    for (size_t i = 0; i < job_table_active_count(server->jobs); i++)
        next = fmin(next, run_flush(job_table_active(server->jobs, i), now, false, serve_ack, server));
    job_table_poll(server->jobs, now, peers_workers(server->peers) > 0, on_change, server);
    serve_dispatch(server, now);
    if (now >= server->next_care) {
        server->next_care = now + server->heartbeat / 4;
        send_heartbeats(server, now);
        if (heard_all)
            drop_silent(server, now);
    }
    if (now >= server->next_progress) {
        server->next_progress = now + progress_interval;
        serve_subscribers(server, true);
    }
    if (!heard_all)
        return 0;
    const double longest = job_table_active_count(server->jobs) ? WAIT_BUSY_MS : WAIT_IDLE_MS;
    return (int)ceil(fmax(0, fmin(fmin(longest, 1000 * (next - now)), 250 * server->heartbeat)));
}

/* What a restarted master needs is on the disk, and peers know that they need not wait. */
static fault_code_t close_down(server_t *server, fault_t *fault)
{
    fault_code_t code = FAULT_NONE;
    for (size_t i = 0; i < job_table_active_count(server->jobs); i++) {
        run_t *run = job_table_active(server->jobs, i);
        fault_t own = {0};
        if (run_checkpoint(run, &own) != FAULT_NONE)
            code = fault_set(fault, own.code, "job %" PRIu64 ": no checkpoint: %s", run_id(run), own.text);
        run_flush(run, clock_now(), true, serve_ack, server);
    }
    message_t bye = {.type = MESSAGE_BYE};
    bye.farewell.text = "the master closes down";
    for (size_t i = 0; i < peers_count(server->peers); i++)
        server_send(server, peers_at(server->peers, i), &bye);
    return code;
}

fault_code_t server_run(server_t *server, fault_t *fault)
{
    int wait = 0;
    while (!atomic_load(&server->stop)) {
        bool woken = false;
        TRY(transport_wait(server->transport, server->wake_fd, wait, &woken, fault));
        uint64_t count;
        if (woken && read(server->wake_fd, &count, sizeof count) < 0)
            log_debug("eventfd: %s", strerror(errno));
        const bool heard_all = receive_all(server);
        wait = care(server, heard_all);
    }
    return close_down(server, fault);
}
