#include "worker/session.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/random.h"
#include "worker/held.h"
#include "worker/pace.h"
#include "worker/supply.h"

enum {
    TICK_MS = 200,           /* longest wait: how late a time limit may be noticed */
    RETRY_MS = 20,           /* the same, while something waits for room in the queue */
    HELLO_AGAIN_SECONDS = 1, /* HELLO_WANTED while a HELLO is under way: so long it is taken for an echo */
    EVENTS_PER_ROUND = 256   /* messages handled before timers get their turn */
};

/* In order of a connection's life. */
typedef enum session_state {
    SESSION_LOST,     /* no connection; one is made at `reconnect_at` */
    SESSION_GREETING, /* HELLO is under way */
    SESSION_WORKING   /* WELCOME has come */
} session_state_t;

struct session {
    session_options_t options;
    runner_t *runner;
    supply_t *supply;
    transport_t *transport; /* null when lost */
    int events;             /* epoll: runner's wake_fd and the caller's stop_fd */
    session_state_t state;
    bool welcomed;  /* ever */
    bool finishing; /* SHUTDOWN has come */
    bool finished;
    held_list_t held;
    pace_t pace;
    unsigned credits;        /* units the master may still send without further READY */
    bool congested;          /* something could not be sent */
    uint64_t number;         /* of this session, from WELCOME */
    double heartbeat, lease; /* seconds */
    double heard, heartbeat_at, hello_at, reconnect_at, backoff;
    uint64_t attempts; /* to connect, for the jitter */
    uint8_t *packed;   /* MESSAGE_MAX_LEASES leases */
};

/* ---- making ---- */

static fault_code_t watch(session_t *session, int fd, fault_t *fault)
{
    struct epoll_event event = {.events = EPOLLIN, .data = {.fd = fd}};
    if (fd >= 0 && epoll_ctl(session->events, EPOLL_CTL_ADD, fd, &event) != 0)
        return fault_set(fault, FAULT_IO, "cannot watch a descriptor: %s", strerror(errno));
    return FAULT_NONE;
}

static fault_code_t set_up(session_t *session, cache_t *cache, fault_t *fault)
{
    session->packed = malloc((size_t)MESSAGE_MAX_LEASES * MESSAGE_LEASE_SIZE);
    if (!session->packed)
        return fault_set(fault, FAULT_MEMORY, "no memory for heartbeats");
    session->events = epoll_create1(EPOLL_CLOEXEC);
    if (session->events < 0)
        return fault_set(fault, FAULT_IO, "cannot make an epoll descriptor: %s", strerror(errno));
    TRY(supply_new(&session->supply, cache, fault));
    return watch(session, runner_wake_fd(session->runner), fault);
}

fault_code_t session_new(session_t **out, const session_options_t *options, runner_t *runner, cache_t *cache,
                         fault_t *fault)
{
    session_t *session = *out = calloc(1, sizeof *session);
    if (!session)
        return fault_set(fault, FAULT_MEMORY, "no memory for a session");
    session->options = *options;
    session->runner = runner;
    session->events = -1;
    session->heartbeat = 1e-3 * MESSAGE_HEARTBEAT_MS;
    session->lease = 1e-3 * MESSAGE_LEASE_MS;
    session->backoff = 1e-3 * MESSAGE_BACKOFF_MIN_MS;
    session->heard = session->reconnect_at = clock_now();
    held_init(&session->held);
    const fault_code_t code = set_up(session, cache, fault);
    if (code)
        session_destroy(out);
    return code;
}

void session_destroy(session_t **session)
{
    session_t *s = *session;
    *session = NULL;
    if (!s)
        return;
    transport_destroy(&s->transport);
    supply_destroy(&s->supply);
    held_clear(&s->held);
    if (s->events >= 0)
        close(s->events);
    free(s->packed);
    free(s);
}

/* ---- sending ---- */

/* False: not now (the queue is full) or not ever (the message is beyond a limit, which is logged). */
static bool send_message(session_t *session, const message_t *message)
{
    fault_t fault = {0};
    if (!session->transport)
        return false;
    if (transport_send(session->transport, TRANSPORT_MASTER, message, &fault) == FAULT_NONE)
        return true;
    session->congested = true;
    if (fault.code != FAULT_LIMIT)
        log_warn("%s: %s", message_type_name(message->type), fault.text);
    return false;
}

static void say_hello(session_t *session)
{
    message_t hello = {.type = MESSAGE_HELLO};
    hello.hello = (message_hello_t){.garland_version = GARLAND_VERSION,
                                    .role = MESSAGE_ROLE_WORKER,
                                    .arch = GARLAND_ARCH,
                                    .host = session->options.host,
                                    .pid = (uint32_t)getpid(),
                                    .threads = runner_threads(session->runner),
                                    .session = session->number,
                                    .token = session->options.token};
    session->state = SESSION_GREETING;
    session->hello_at = clock_now();
    session->credits = 0;
    send_message(session, &hello);
}

static void say_bye(session_t *session, const char *text)
{
    message_t bye = {.type = MESSAGE_BYE};
    bye.farewell.text = text;
    send_message(session, &bye);
}

static void send_heartbeat(session_t *session)
{
    message_t heartbeat = {.type = MESSAGE_HEARTBEAT};
    uint32_t count = 0;
    for (const held_t *held = session->held.first; held; held = held->next)
        if (!held->cancelled)
            message_lease_pack(session->packed, count++, &held->lease);
    heartbeat.heartbeat.leases = (message_leases_t){session->packed, count};
    session->heartbeat_at = clock_now() + session->heartbeat;
    send_message(session, &heartbeat);
}

static bool send_result(session_t *session, const held_t *held)
{
    message_t message = {.type = held->code == FAULT_NONE ? MESSAGE_RESULT : MESSAGE_FAILED};
    if (held->code == FAULT_NONE) {
        message.result.lease = held->lease;
        message.result.bytes = (message_bytes_t){held->result, held->result_size};
    } else {
        message.failed.lease = held->lease;
        message.failed.code = (uint16_t)held->code;
        message.failed.text = held->text;
    }
    return send_message(session, &message);
}

static void send_results(session_t *session)
{
    for (held_t *held = session->held.first; held; held = held->next) {
        if (held->state != HELD_DONE || held->sent)
            continue;
        if (!send_result(session, held))
            return;
        held->sent = true;
    }
}

/* Credits for what there is room for: a unit a thread and those ahead, less what is at hand or promised. */
static void send_ready(session_t *session)
{
    const unsigned fixed = session->options.prefetch,
                   room = runner_threads(session->runner) + (fixed > 0 ? fixed : pace_ahead(&session->pace));
    const unsigned active = session->held.count - session->held.done + session->credits;
    if (session->finishing || active >= room || session->held.count + room > MESSAGE_MAX_LEASES ||
        session->held.done_bytes > SESSION_UNACKNOWLEDGED_BYTES)
        return;
    message_t ready = {.type = MESSAGE_READY};
    ready.ready.slots = room - active;
    if (send_message(session, &ready))
        session->credits += ready.ready.slots;
}

/* ---- connection ---- */

static void lose(session_t *session, const char *why)
{
    /* Jitter of half the pause, so that a cluster does not come back in step. */
    const uint64_t key = random_key((uint64_t)getpid(), RANDOM_PURPOSE_TEST, 0, session->attempts++);
    const double pause = session->backoff * (0.75 + 0.5 * random_double(key, 0));
    const double longest = 1e-3 * MESSAGE_BACKOFF_MAX_MS;
    log_info("%s: %s; trying again in %.1f s", session->options.address, why, pause);
    transport_destroy(&session->transport);
    session->state = SESSION_LOST;
    session->reconnect_at = clock_now() + pause;
    session->backoff = session->backoff * 2 < longest ? session->backoff * 2 : longest;
}

static fault_code_t connect_again(session_t *session, fault_t *fault)
{
    const transport_options_t options = {.server_key = session->options.server_key};
    TRY(transport_connect(&session->transport, session->options.address, &options, fault));
    supply_restart(session->supply);
    for (held_t *held = session->held.first; held; held = held->next)
        held->sent = false;
    say_hello(session);
    return FAULT_NONE;
}

/* ---- messages ---- */

static void take_welcome(session_t *session, const message_welcome_t *welcome)
{
    if (session->state != SESSION_GREETING)
        return;
    log_info("working for %s (Garland %s), session %llu", session->options.address, welcome->garland_version,
             (unsigned long long)welcome->session);
    session->state = SESSION_WORKING;
    session->welcomed = true;
    session->number = welcome->session;
    session->heartbeat = 1e-3 * welcome->heartbeat_ms;
    session->lease = 1e-3 * welcome->lease_ms;
    session->backoff = 1e-3 * MESSAGE_BACKOFF_MIN_MS;
    session->credits = 0;
    supply_restart(session->supply);
    for (held_t *held = session->held.first; held; held = held->next)
        held->sent = false;
    send_heartbeat(session);
}

static fault_code_t take_refusal(session_t *session, const message_refused_t *refused, fault_t *fault)
{
    const fault_code_t code = message_fault_code(refused->code);
    if (refused->request == MESSAGE_HELLO || code == FAULT_VERSION)
        return fault_set(fault, code ? code : FAULT_PROTOCOL, "the master at %s refused: %.900s",
                         session->options.address, refused->text);
    log_warn("the master refused %s: %s", message_type_name(refused->request), refused->text);
    supply_take_refusal(session->supply, refused);
    return FAULT_NONE;
}

static void take_work(session_t *session, const message_work_t *work)
{
    if (session->credits > 0)
        session->credits--;
    if (held_find(&session->held, &work->lease))
        return; /* sent twice */
    if (session->held.count >= MESSAGE_MAX_LEASES) {
        log_warn("more than %d units at once: one is not taken", MESSAGE_MAX_LEASES);
        return;
    }
    if (!held_add(&session->held, work))
        log_warn("no memory for a unit of %zu octets: it is not taken", work->record.size);
}

static void take_ack(session_t *session, const message_acknowledge_t *ack)
{
    held_t *held = held_find(&session->held, &ack->lease);
    if (held && held->state == HELD_DONE)
        held_remove(&session->held, held);
}

static void take_cancel(session_t *session, uint64_t job)
{
    for (held_t *held = session->held.first, *next; held; held = next) {
        next = held->next;
        if (held->lease.job != job)
            continue;
        if (held->state == HELD_RUNNING)
            held->cancelled = true; /* until the runner lets go of it */
        else
            held_remove(&session->held, held);
    }
    runner_cancel(session->runner, job);
}

static fault_code_t take_message(session_t *session, const message_t *message, fault_t *fault)
{
    switch (message->type) {
    case MESSAGE_WELCOME:
        take_welcome(session, &message->welcome);
        break;
    case MESSAGE_REFUSED:
        return take_refusal(session, &message->refused, fault);
    case MESSAGE_HELLO_WANTED:
        if (session->state == SESSION_WORKING || clock_now() - session->hello_at > HELLO_AGAIN_SECONDS)
            say_hello(session);
        break;
    case MESSAGE_BYE:
        lose(session, "the master left");
        break;
    case MESSAGE_SHUTDOWN:
        log_info("told to finish: %s", message->farewell.text);
        session->finishing = true;
        break;
    case MESSAGE_WORK:
        take_work(session, &message->work);
        break;
    case MESSAGE_JOB_DATA:
        supply_take_job(session->supply, &message->job_data);
        break;
    case MESSAGE_BUNDLE_DATA:
        supply_take_chunk(session->supply, &message->chunk);
        break;
    case MESSAGE_ACK:
        take_ack(session, &message->ack);
        break;
    case MESSAGE_CANCEL:
        take_cancel(session, message->job.job);
        break;
    default: /* heartbeats, and what clients get */
        break;
    }
    return FAULT_NONE;
}

static fault_code_t receive(session_t *session, fault_t *fault)
{
    transport_event_t event;
    for (int i = 0; i < EVENTS_PER_ROUND && session->transport; i++) {
        const transport_event_kind_t kind = transport_receive(session->transport, &event);
        if (kind == TRANSPORT_NOTHING)
            return FAULT_NONE;
        session->heard = clock_now();
        if (kind == TRANSPORT_MESSAGE)
            TRY(take_message(session, &event.message, fault));
        else if (event.fault.code == FAULT_VERSION)
            return fault_set(fault, FAULT_VERSION, "the master at %s: %.900s", session->options.address,
                             event.fault.text);
        else
            log_warn("from the master: %s", event.fault.text);
    }
    return FAULT_NONE;
}

/* ---- units ---- */

/* Hands waiting units over to the runner as soon as their job and bundle are there. */
static void start_units(session_t *session)
{
    bool failures = false;
    for (held_t *held = session->held.first, *next; held; held = next) {
        next = held->next;
        if (held->state != HELD_WAITING)
            continue;
        source_t *source;
        fault_t fault = {0};
        const supply_state_t state = supply_get(session->supply, held, &source, &fault);
        if (state == SUPPLY_PENDING)
            continue;
        const runner_unit_t unit = {held->lease, source, {held->record, held->record_size}};
        if (state == SUPPLY_READY && runner_submit(session->runner, &unit, &fault) == FAULT_NONE) {
            held->state = HELD_RUNNING;
            held_drop_record(held);
            continue;
        }
        failures |= state == SUPPLY_FAILED;
        held_finish(&session->held, held, NULL, 0, &fault);
    }
    if (failures)
        supply_forget_failures(session->supply);
}

static void take_outcomes(session_t *session)
{
    runner_outcome_t outcome;
    while (runner_take(session->runner, &outcome)) {
        pace_note(&session->pace, clock_now());
        held_t *held = held_find(&session->held, &outcome.lease);
        if (!held || held->cancelled || outcome.fault.code == FAULT_CANCELLED) {
            if (held)
                held_remove(&session->held, held);
            free(outcome.result);
            continue;
        }
        if (outcome.fault.code)
            log_warn("unit %llu of job %llu: %s", (unsigned long long)outcome.lease.unit,
                     (unsigned long long)outcome.lease.job, outcome.fault.text);
        held_finish(&session->held, held, outcome.result, outcome.size, &outcome.fault);
    }
}

/* ---- the loop ---- */

/* Time limits of the present state. */
static fault_code_t check_time(session_t *session, fault_t *fault)
{
    const double now = clock_now(), silence = now - session->heard;
    const double first = 1e-3 * MESSAGE_HANDSHAKE_MS;
    const double patience = session->options.patience > 0 ? session->options.patience
                            : session->welcomed           ? 0
                                                          : first;
    if (patience > 0 && silence > patience)
        return fault_set(
            fault, FAULT_TIMEOUT, "the master at %s %s for %.0f s%s", session->options.address,
            session->welcomed ? "has been silent" : "has not answered", silence,
            session->welcomed ? "" : ": none listens there, the network drops it, or the server key differs");
    if (session->finishing && silence > SESSION_FINISH_SECONDS) {
        log_warn("told to finish, but the master is gone: %u results are not delivered", session->held.done);
        session->finished = true;
        return FAULT_NONE;
    }
    const double hello_silence = now - (session->heard > session->hello_at ? session->heard : session->hello_at);
    if (session->state == SESSION_LOST && now >= session->reconnect_at)
        return connect_again(session, fault);
    if (session->state == SESSION_WORKING && silence > session->lease)
        lose(session, "the master is silent");
    else if (session->state == SESSION_GREETING && hello_silence > session->lease)
        lose(session, "nobody answers");
    return FAULT_NONE;
}

/* Everything that may be due to be said. */
static void speak(session_t *session)
{
    session->congested = false;
    if (session->state != SESSION_WORKING)
        return;
    if (clock_now() >= session->heartbeat_at)
        send_heartbeat(session);
    send_results(session);
    supply_pump(session->supply, session->transport, session->lease);
    send_ready(session);
    if (session->finishing && session->held.count == 0) {
        say_bye(session, "finished");
        session->finished = true;
    }
}

static int time_to_wait(const session_t *session)
{
    const double now = clock_now();
    const double next = session->state == SESSION_WORKING ? session->heartbeat_at
                        : session->state == SESSION_LOST  ? session->reconnect_at
                                                          : now + 1;
    const double limit = 1e-3 * (session->congested ? RETRY_MS : TICK_MS);
    const double wait = next - now < limit ? next - now : limit;
    return wait > 0 ? (int)(1e3 * wait) + 1 : 0;
}

static fault_code_t wait_for_something(session_t *session, fault_t *fault)
{
    const int timeout = time_to_wait(session);
    if (session->transport)
        return transport_wait(session->transport, session->events, timeout, NULL, fault);
    struct epoll_event event;
    epoll_wait(session->events, &event, 1, timeout); /* a signal ends it early, which does no harm */
    return FAULT_NONE;
}

static bool is_readable(int fd)
{
    struct pollfd poller = {.fd = fd, .events = POLLIN}; /* poll passes over a negative descriptor */
    return poll(&poller, 1, 0) > 0;
}

static fault_code_t run_round(session_t *session, fault_t *fault)
{
    TRY(check_time(session, fault));
    TRY(receive(session, fault));
    take_outcomes(session);
    start_units(session);
    speak(session);
    return session->finished ? FAULT_NONE : wait_for_something(session, fault);
}

fault_code_t session_run(session_t *session, int stop_fd, fault_t *fault)
{
    TRY(watch(session, stop_fd, fault));
    while (!session->finished) {
        const fault_code_t code = run_round(session, fault);
        if (code) {
            say_bye(session, fault ? fault->text : "failed");
            return code;
        }
        if (is_readable(stop_fd)) {
            log_info("stopping: %u units are given back", session->held.count - session->held.done);
            say_bye(session, "stopped");
            return FAULT_NONE;
        }
    }
    return FAULT_NONE;
}
