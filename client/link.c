#include "client/link.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/clock.h"
#include "client/interrupt.h"
#include "scene/bundle.h"

enum {
    ATTEMPTS = 3, /* at a request, with a HELLO before each further one */
    SLICE_MS = 200,
    FULL_QUEUE_US = 5000,
    BUNDLE_TIMEOUT_MS = 120000 /* a large scene takes time to be checked */
};

struct link {
    transport_t *transport;
    char *address, *token;
    double heartbeat, lease, beat; /* seconds */
    bool forgotten;      /* the master does not know us (any more): it was restarted, or we were silent for long */
    uint64_t subscribed; /* job, or 0 */
};

/* ---- opening ---- */

static fault_code_t say_hello(link_t *link, fault_t *fault)
{
    char host[256] = "";
    gethostname(host, sizeof host - 1);
    const message_hello_t hello = {.garland_version = GARLAND_VERSION,
                                   .role = MESSAGE_ROLE_CLIENT,
                                   .arch = GARLAND_ARCH,
                                   .host = host,
                                   .pid = (uint32_t)getpid(),
                                   .token = link->token};
    transport_event_t *event = malloc(sizeof *event);
    if (!event)
        return fault_set(fault, FAULT_MEMORY, "no memory for a message");
    const fault_code_t code = transport_hello(link->transport, &hello, LINK_TIMEOUT_MS, event, fault);
    if (code == FAULT_TIMEOUT)
        fault_set(fault, code, "no master answers at %s (waited %d s)", link->address, LINK_TIMEOUT_MS / 1000);
    if (code == FAULT_NONE) {
        link->heartbeat = 1e-3 * event->message.welcome.heartbeat_ms;
        link->lease = 1e-3 * event->message.welcome.lease_ms;
        link->beat = clock_now();
    }
    free(event);
    return code;
}

fault_code_t link_open(link_t **out, const char *address, const link_options_t *options, fault_t *fault)
{
    *out = NULL;
    link_t *link = calloc(1, sizeof *link);
    if (!link || !(link->address = strdup(address)) ||
        !(link->token = strdup(options->token ? options->token : ""))) {
        link_close(&link);
        return fault_set(fault, FAULT_MEMORY, "no memory for a connection");
    }
    const transport_options_t transport = {.server_key = options->server_key};
    fault_code_t code = transport_connect(&link->transport, address, &transport, fault);
    if (code == FAULT_NONE)
        code = say_hello(link, fault);
    if (code != FAULT_NONE) {
        link_close(&link);
        return code;
    }
    *out = link;
    return FAULT_NONE;
}

void link_close(link_t **link)
{
    if (!*link)
        return;
    if ((*link)->transport && (*link)->beat > 0) {
        message_t bye = {.type = MESSAGE_BYE};
        bye.farewell.text = "";
        transport_send((*link)->transport, TRANSPORT_MASTER, &bye, NULL);
    }
    transport_destroy(&(*link)->transport);
    free((*link)->address);
    free((*link)->token);
    free(*link);
    *link = NULL;
}

/* ---- messages ---- */

static fault_code_t check_interrupt(fault_t *fault)
{
    return interrupt_happened() ? fault_set(fault, FAULT_CANCELLED, "interrupted") : FAULT_NONE;
}

/* Sends; a full queue is waited for. */
static fault_code_t put(link_t *link, const message_t *message, fault_t *fault)
{
    const double end = clock_now() + 1e-3 * LINK_TIMEOUT_MS;
    for (;;) {
        const fault_code_t code = transport_send(link->transport, TRANSPORT_MASTER, message, fault);
        if (code != FAULT_LIMIT || clock_now() > end)
            return code;
        TRY(check_interrupt(fault));
        usleep(FULL_QUEUE_US);
    }
}

static void keep_alive(link_t *link)
{
    const double now = clock_now();
    if (now < link->beat + link->heartbeat)
        return;
    const message_t beat = {.type = MESSAGE_HEARTBEAT};
    transport_send(link->transport, TRANSPORT_MASTER, &beat, NULL);
    link->beat = now;
}

/* The next message within `ms` that is not of the connection's own business; *got says whether there was one. */
static fault_code_t get(link_t *link, int ms, transport_event_t *event, bool *got, fault_t *fault)
{
    const double end = clock_now() + 1e-3 * ms;
    *got = false;
    for (;;) {
        TRY(check_interrupt(fault));
        keep_alive(link);
        while (transport_receive(link->transport, event) != TRANSPORT_NOTHING) {
            if (event->kind == TRANSPORT_MALFORMED)
                return fault_set(fault, event->fault.code, "from %s: %s", link->address, event->fault.text);
            switch (event->message.type) {
            case MESSAGE_HEARTBEAT:
            case MESSAGE_WELCOME:
            case MESSAGE_BYE: /* it may be back soon; if it is not, waiting has its limits */
                break;
            case MESSAGE_HELLO_WANTED:
                link->forgotten = true;
                return fault_set(fault, FAULT_PROTOCOL, "the master at %s does not know this client",
                                 link->address);
            default:
                *got = true;
                return FAULT_NONE;
            }
        }
        const double left = 1e3 * (end - clock_now());
        if (left <= 0)
            return FAULT_NONE;
        TRY(transport_wait(link->transport, -1, left < SLICE_MS ? (int)left + 1 : SLICE_MS, NULL, fault));
    }
}

static fault_code_t refused(const message_refused_t *refusal, fault_t *fault)
{
    const fault_code_t code =
        refusal->code > FAULT_NONE && refusal->code < FAULT_COUNT ? (fault_code_t)refusal->code : FAULT_PROTOCOL;
    return fault_set(fault, code, "the master refuses: %s", refusal->text);
}

/* The next message that answers something: progress of subscriptions is passed over. A refusal is a fault. */
static fault_code_t answer(link_t *link, int ms, transport_event_t *event, fault_t *fault)
{
    bool got;
    do {
        TRY(get(link, ms, event, &got, fault));
        if (!got)
            return fault_set(fault, FAULT_TIMEOUT, "no master answers at %s (waited %d s)", link->address,
                             ms / 1000);
    } while (event->message.type == MESSAGE_PROGRESS || event->message.type == MESSAGE_JOB_END);
    return event->message.type == MESSAGE_REFUSED ? refused(&event->message.refused, fault) : FAULT_NONE;
}

static fault_code_t unexpected(const transport_event_t *event, fault_t *fault)
{
    return fault_set(fault, FAULT_PROTOCOL, "unexpected answer %s of the master",
                     message_type_name(event->message.type));
}

/* A request and its answer. A master that has forgotten us is greeted again, and asked again. */
static fault_code_t ask_any(link_t *link, const message_t *request, transport_event_t *event, fault_t *fault)
{
    fault_code_t code = FAULT_NONE;
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        link->forgotten = false;
        code = put(link, request, fault);
        if (code == FAULT_NONE)
            code = answer(link, LINK_TIMEOUT_MS, event, fault);
        if (code == FAULT_NONE || !link->forgotten)
            return code;
        TRY(say_hello(link, fault));
    }
    return code;
}

static fault_code_t ask(link_t *link, const message_t *request, message_type_t expected, transport_event_t *event,
                        fault_t *fault)
{
    TRY(ask_any(link, request, event, fault));
    return event->message.type == expected ? FAULT_NONE : unexpected(event, fault);
}

/* ---- jobs up ---- */

/* Sends the bundle from `at` on, with a few pieces under way, until the master has it whole. */
static fault_code_t send_bundle(link_t *link, const digest_t *digest, const uint8_t *data, uint64_t size,
                                uint64_t at, transport_event_t *event, fault_t *fault)
{
    uint64_t acknowledged = at;
    int under_way = 0;
    while (acknowledged < size) {
        while (under_way < LINK_WINDOW && at < size) {
            message_t piece = {.type = MESSAGE_BUNDLE_PUT};
            const size_t length = size - at < MESSAGE_MAX_CHUNK ? (size_t)(size - at) : MESSAGE_MAX_CHUNK;
            piece.chunk =
                (message_chunk_t){.digest = *digest, .total = size, .offset = at, .bytes = {data + at, length}};
            TRY(put(link, &piece, fault));
            at += length;
            under_way++;
        }
        TRY(answer(link, BUNDLE_TIMEOUT_MS, event, fault));
        if (event->message.type != MESSAGE_BUNDLE_PUT_OK)
            return unexpected(event, fault);
        acknowledged = event->message.bundle_wanted.offset;
        under_way--;
        if (under_way == 0 && acknowledged < at)
            return fault_set(fault, FAULT_PROTOCOL, "the master lost pieces of the scene");
    }
    return FAULT_NONE;
}

static fault_code_t submit_bytes(link_t *link, const char *text, const digest_t *digest, const uint8_t *data,
                                 uint64_t size, uint64_t *job, transport_event_t *event, fault_t *fault)
{
    message_t submit = {.type = MESSAGE_SUBMIT};
    submit.submit = (message_submit_t){.text = text, .bundle_digest = *digest, .bundle_size = size};
    for (int attempt = 0; attempt < 2; attempt++) {
        TRY(ask_any(link, &submit, event, fault));
        if (event->message.type == MESSAGE_SUBMITTED) {
            *job = event->message.job.job;
            return FAULT_NONE;
        }
        if (event->message.type != MESSAGE_BUNDLE_WANTED || attempt > 0)
            break;
        TRY(send_bundle(link, digest, data, size, event->message.bundle_wanted.offset, event, fault));
    }
    return unexpected(event, fault);
}

fault_code_t link_submit(link_t *link, const char *text, const char *path, uint64_t *job, fault_t *fault)
{
    bundle_t *bundle;
    TRY(bundle_open(&bundle, path, fault));
    transport_event_t *event = malloc(sizeof *event);
    size_t size;
    const uint8_t *data = bundle_bytes(bundle, &size);
    const fault_code_t code = event ? submit_bytes(link, text, bundle_digest(bundle), data, size, job, event, fault)
                                    : fault_set(fault, FAULT_MEMORY, "no memory for a message");
    free(event);
    bundle_destroy(&bundle);
    return code;
}

/* ---- questions ---- */

fault_code_t link_status(link_t *link, uint64_t job, json_t **out, fault_t *fault)
{
    *out = NULL;
    message_t request = {.type = MESSAGE_STATUS};
    request.job.job = job;
    transport_event_t event;
    TRY(ask(link, &request, MESSAGE_STATUS_DATA, &event, fault));
    const char *text = event.message.report.text;
    return json_parse(out, text, strlen(text), fault);
}

static fault_code_t ask_done(link_t *link, message_type_t type, uint64_t job, fault_t *fault)
{
    message_t request = {.type = type};
    request.job.job = job;
    transport_event_t event;
    return ask(link, &request, MESSAGE_DONE, &event, fault);
}

fault_code_t link_cancel(link_t *link, uint64_t job, fault_t *fault)
{
    return ask_done(link, MESSAGE_CANCEL_JOB, job, fault);
}

fault_code_t link_job_text(link_t *link, uint64_t job, char **text, fault_t *fault)
{
    message_t request = {.type = MESSAGE_JOB_QUERY};
    request.job.job = job;
    transport_event_t event;
    TRY(ask(link, &request, MESSAGE_JOB_DATA, &event, fault));
    *text = strdup(event.message.job_data.text);
    return *text ? FAULT_NONE : fault_set(fault, FAULT_MEMORY, "no memory for a job's text");
}

/* ---- outputs down ---- */

/* Takes one piece; begins again at 0 if the output has changed since. */
static fault_code_t take_piece(const message_fetch_data_t *piece, uint64_t *revision, uint8_t **data, size_t *size,
                               uint64_t *at, fault_t *fault)
{
    if (*at > 0 && piece->revision != *revision) {
        *at = 0;
        return FAULT_NONE;
    }
    if (piece->offset != *at || (piece->bytes.size == 0 && piece->total > *at))
        return fault_set(fault, FAULT_PROTOCOL, "the master sent the wrong piece of an output");
    if (*at == 0) {
        *revision = piece->revision;
        uint8_t *grown = realloc(*data, piece->total ? piece->total : 1);
        if (!grown)
            return fault_set(fault, FAULT_MEMORY, "no memory for an output of %" PRIu64 " bytes", piece->total);
        *data = grown;
        *size = piece->total;
    }
    if (piece->total != *size || piece->bytes.size > *size - *at)
        return fault_set(fault, FAULT_PROTOCOL, "the master sent an output of changing size");
    memcpy(*data + *at, piece->bytes.data, piece->bytes.size);
    *at += piece->bytes.size;
    return FAULT_NONE;
}

fault_code_t link_fetch(link_t *link, uint64_t job, message_output_t output, uint8_t **data, size_t *size,
                        fault_t *fault)
{
    *data = NULL;
    *size = 0;
    uint64_t at = 0, revision = 0;
    fault_code_t code;
    do {
        message_t request = {.type = MESSAGE_FETCH};
        request.fetch =
            (message_fetch_t){.job = job, .output = (uint8_t)output, .offset = at, .length = MESSAGE_MAX_CHUNK};
        transport_event_t event;
        code = ask(link, &request, MESSAGE_FETCH_DATA, &event, fault);
        if (code == FAULT_NONE)
            code = take_piece(&event.message.fetch_data, &revision, data, size, &at, fault);
    } while (code == FAULT_NONE && (at == 0 ? *size > 0 || !*data : at < *size));
    if (code != FAULT_NONE) {
        free(*data);
        *data = NULL;
    }
    return code;
}

/* ---- subscriptions ---- */

fault_code_t link_subscribe(link_t *link, uint64_t job, fault_t *fault)
{
    link->subscribed = job;
    return ask_done(link, MESSAGE_SUBSCRIBE, job, fault);
}

/* To a master that has forgotten us: who we are and what we wait for. */
static fault_code_t return_to_master(link_t *link, fault_t *fault)
{
    link->forgotten = false;
    TRY(say_hello(link, fault));
    return link->subscribed ? link_subscribe(link, link->subscribed, fault) : FAULT_NONE;
}

fault_code_t link_next(link_t *link, int ms, transport_event_t *event, bool *got, fault_t *fault)
{
    const fault_code_t code = get(link, ms, event, got, fault);
    if (code != FAULT_NONE && link->forgotten)
        return return_to_master(link, fault);
    TRY(code);
    if (!*got && transport_silence(link->transport) > link->lease)
        return fault_set(fault, FAULT_TIMEOUT, "the master at %s has been silent for %.0f s", link->address,
                         transport_silence(link->transport));
    if (*got && event->message.type != MESSAGE_PROGRESS && event->message.type != MESSAGE_JOB_END)
        return event->message.type == MESSAGE_REFUSED ? refused(&event->message.refused, fault)
                                                      : unexpected(event, fault);
    return FAULT_NONE;
}
