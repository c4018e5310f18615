/* message.h: what is said between master, workers and clients. PROTOCOL.md is the specification; this file is its
 * constants and structures, and a test holds the two together.
 *
 * A message is one frame: signature, protocol version, type, fields. Encoding and decoding follow one table of
 * fields (message_fields), so that a limit stands in one place.
 *
 *     message_t hello = {.type = MESSAGE_HELLO};
 *     hello.hello.role = MESSAGE_ROLE_WORKER;
 *     hello.hello.garland_version = GARLAND_VERSION;
 *     ...
 *     TRY(message_encode(&hello, &data, &size, fault));
 *
 * A decoded message borrows: its strings, bytes and leases point into the frame and live as long as it does.
 * Strings are never null after decoding, are valid UTF-8 and hold no control characters but tab and line feed.
 *
 * Thread rule: pure functions, any thread.
 */
#ifndef PROTO_MESSAGE_H
#define PROTO_MESSAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/digest.h"
#include "base/fault.h"

#define MESSAGE_SIGNATURE "GRLD"

enum { MESSAGE_PROTOCOL_VERSION = 1, MESSAGE_HEADER_SIZE = 8 };

/* Limits; the reasons are in PROTOCOL.md. Octets unless named otherwise. */
enum {
    MESSAGE_MAX_STRING = 4096,                       /* names, reasons */
    MESSAGE_MAX_TOKEN = 256,                         /* the shared secret in HELLO */
    MESSAGE_MAX_TEXT = 1 << 20,                      /* a job, a progress report */
    MESSAGE_MAX_STATUS = 8 << 20,                    /* the state of all jobs */
    MESSAGE_MAX_RECORD = 1 << 20,                    /* a unit's record */
    MESSAGE_MAX_CHUNK = 1 << 20,                     /* a piece of a bundle or of an output */
    MESSAGE_MAX_RESULT = 512 << 20,                  /* a unit's result */
    MESSAGE_MAX_FROM_MASTER = 16 << 20,              /* a frame that a master sends */
    MESSAGE_MAX_FROM_PEER = (512 << 20) + (1 << 16), /* a frame that a worker or client sends */
    MESSAGE_MAX_LEASES = 4096,                       /* leases in one heartbeat, and so of one worker */
    MESSAGE_MAX_SLOTS = 4096,                        /* units in one READY */
    MESSAGE_MAX_PEERS = 4096,                        /* peers of a master */
    MESSAGE_MAX_THREADS = 1 << 16,                   /* threads a worker may claim */
    MESSAGE_MIN_INTERVAL_MS = 50,                    /* heartbeat interval and lease, milliseconds */
    MESSAGE_MAX_INTERVAL_MS = 3600000,
    MESSAGE_LEASE_SIZE = 24 /* a lease in a heartbeat */
};
#define MESSAGE_MAX_BUNDLE (UINT64_C(1) << 40) /* bytes of a bundle */
#define MESSAGE_MAX_OUTPUT (UINT64_C(1) << 40) /* bytes of an output */

/* Times in milliseconds; a master may announce others. The lease is some heartbeats long: one lost is no loss. */
enum {
    MESSAGE_HEARTBEAT_MS = 2000,
    MESSAGE_LEASE_MS = 15000,
    MESSAGE_HANDSHAKE_MS = 30000, /* HELLO unanswered so long is a fault */
    MESSAGE_BACKOFF_MIN_MS = 250, /* first pause before a new attempt to connect; doubles */
    MESSAGE_BACKOFF_MAX_MS = 10000
};

typedef enum message_role { MESSAGE_ROLE_WORKER = 1, MESSAGE_ROLE_CLIENT = 2 } message_role_t;

/* Who sends a type. */
typedef enum message_sender {
    MESSAGE_FROM_MASTER = 1,
    MESSAGE_FROM_WORKER = 2,
    MESSAGE_FROM_CLIENT = 4,
    MESSAGE_FROM_PEER = MESSAGE_FROM_WORKER | MESSAGE_FROM_CLIENT,
    MESSAGE_FROM_ANYONE = MESSAGE_FROM_MASTER | MESSAGE_FROM_PEER
} message_sender_t;

/* X(name, number, senders) */
#define MESSAGE_TYPES(X)                                                                                           \
    X(HELLO, 1, MESSAGE_FROM_PEER)                                                                                 \
    X(WELCOME, 2, MESSAGE_FROM_MASTER)                                                                             \
    X(REFUSED, 3, MESSAGE_FROM_MASTER)                                                                             \
    X(HELLO_WANTED, 4, MESSAGE_FROM_MASTER)                                                                        \
    X(HEARTBEAT, 5, MESSAGE_FROM_ANYONE)                                                                           \
    X(BYE, 6, MESSAGE_FROM_ANYONE)                                                                                 \
    X(SHUTDOWN, 7, MESSAGE_FROM_MASTER)                                                                            \
    X(READY, 16, MESSAGE_FROM_WORKER)                                                                              \
    X(WORK, 17, MESSAGE_FROM_MASTER)                                                                               \
    X(JOB_QUERY, 18, MESSAGE_FROM_PEER)                                                                            \
    X(JOB_DATA, 19, MESSAGE_FROM_MASTER)                                                                           \
    X(BUNDLE_GET, 20, MESSAGE_FROM_WORKER)                                                                         \
    X(BUNDLE_DATA, 21, MESSAGE_FROM_MASTER)                                                                        \
    X(RESULT, 22, MESSAGE_FROM_WORKER)                                                                             \
    X(FAILED, 23, MESSAGE_FROM_WORKER)                                                                             \
    X(ACK, 24, MESSAGE_FROM_MASTER)                                                                                \
    X(CANCEL, 25, MESSAGE_FROM_MASTER)                                                                             \
    X(SUBMIT, 32, MESSAGE_FROM_CLIENT)                                                                             \
    X(BUNDLE_WANTED, 33, MESSAGE_FROM_MASTER)                                                                      \
    X(BUNDLE_PUT, 34, MESSAGE_FROM_CLIENT)                                                                         \
    X(BUNDLE_PUT_OK, 35, MESSAGE_FROM_MASTER)                                                                      \
    X(SUBMITTED, 36, MESSAGE_FROM_MASTER)                                                                          \
    X(STATUS, 37, MESSAGE_FROM_CLIENT)                                                                             \
    X(STATUS_DATA, 38, MESSAGE_FROM_MASTER)                                                                        \
    X(FETCH, 39, MESSAGE_FROM_CLIENT)                                                                              \
    X(FETCH_DATA, 40, MESSAGE_FROM_MASTER)                                                                         \
    X(CANCEL_JOB, 41, MESSAGE_FROM_CLIENT)                                                                         \
    X(DONE, 42, MESSAGE_FROM_MASTER)                                                                               \
    X(SUBSCRIBE, 43, MESSAGE_FROM_CLIENT)                                                                          \
    X(PROGRESS, 44, MESSAGE_FROM_MASTER)                                                                           \
    X(JOB_END, 45, MESSAGE_FROM_MASTER)

typedef enum message_type {
#define MESSAGE_ENUM(name, number, senders) MESSAGE_##name = number,
    MESSAGE_TYPES(MESSAGE_ENUM)
#undef MESSAGE_ENUM
} message_type_t;

typedef enum message_ack {
    MESSAGE_ACK_MERGED = 1,    /* counted: this attempt brought the unit first */
    MESSAGE_ACK_DUPLICATE = 2, /* the unit was counted before */
    MESSAGE_ACK_UNKNOWN = 3    /* no such job or unit, or the job has ended; drop the result */
} message_ack_t;

typedef enum message_output {
    MESSAGE_OUTPUT_IMAGE = 1,   /* EXR */
    MESSAGE_OUTPUT_PREVIEW = 2, /* PNG */
    MESSAGE_OUTPUT_REPORT = 3   /* JSON */
} message_output_t;

typedef enum message_end {
    MESSAGE_END_FINISHED = 1,
    MESSAGE_END_FAILED = 2,
    MESSAGE_END_CANCELLED = 3
} message_end_t;

typedef struct message_bytes {
    const uint8_t *data;
    size_t size;
} message_bytes_t;

/* A unit of a job in a worker's hands. */
typedef struct message_lease {
    uint64_t job, unit, attempt;
} message_lease_t;

/* Leases as they travel; message_lease_pack and message_lease_at go between the two. */
typedef struct message_leases {
    const uint8_t *packed; /* MESSAGE_LEASE_SIZE octets each */
    uint32_t count;
} message_leases_t;

typedef struct message_hello {
    const char *garland_version; /* GARLAND_VERSION; first, and so in every protocol version */
    uint8_t role;                /* message_role_t */
    const char *arch;            /* instruction set: GARLAND_ARCH */
    const char *host;
    uint32_t pid;
    uint32_t threads;  /* that render; 0 for a client */
    uint64_t session;  /* of an earlier WELCOME, 0 at first: a worker that comes back keeps its leases */
    const char *token; /* shared secret, "" if none */
} message_hello_t;

typedef struct message_welcome {
    const char *garland_version;
    uint32_t heartbeat_ms, lease_ms;
    uint64_t session; /* of this peer; never 0 */
} message_welcome_t;

typedef struct message_refused {
    const char *text; /* first, and so in every protocol version */
    uint16_t code;    /* fault_code_t */
    uint16_t request; /* message_type_t that is refused, 0 if it could not be read */
    uint64_t job;     /* it concerns, or 0 */
} message_refused_t;

typedef struct message_heartbeat {
    message_leases_t leases; /* that the worker holds: queued, running, or done and not acknowledged */
} message_heartbeat_t;

typedef struct message_farewell { /* BYE, SHUTDOWN */
    const char *text;
} message_farewell_t;

typedef struct message_ready {
    uint32_t
        slots; /* credits: so many more units than it said before; HELLO sets them to none, each WORK uses one */
} message_ready_t;

typedef struct message_work {
    message_lease_t lease;
    digest_t job_digest; /* of the job's canonical JSON text */
    digest_t bundle_digest;
    message_bytes_t record;
} message_work_t;

typedef struct message_job { /* JOB_QUERY, CANCEL, SUBMITTED, STATUS, CANCEL_JOB, SUBSCRIBE */
    uint64_t job;
} message_job_t;

typedef struct message_job_data {
    uint64_t job;
    digest_t bundle_digest;
    const char *text; /* canonical JSON */
} message_job_data_t;

typedef struct message_bundle_get {
    digest_t digest;
    uint64_t offset;
    uint32_t length;
} message_bundle_get_t;

typedef struct message_chunk { /* BUNDLE_DATA, BUNDLE_PUT: offset + bytes.size <= total (checked) */
    digest_t digest;
    uint64_t total, offset;
    message_bytes_t bytes;
} message_chunk_t;

typedef struct message_result {
    message_lease_t lease;
    message_bytes_t bytes;
} message_result_t;

typedef struct message_failed {
    message_lease_t lease;
    uint16_t code; /* fault_code_t */
    const char *text;
} message_failed_t;

typedef struct message_acknowledge {
    message_lease_t lease;
    uint8_t outcome; /* message_ack_t */
} message_acknowledge_t;

typedef struct message_submit {
    const char *text; /* the job's JSON */
    digest_t bundle_digest;
    uint64_t bundle_size;
} message_submit_t;

typedef struct message_bundle_wanted {
    digest_t digest;
    uint64_t offset;       /* from where: a master may hold the beginning already */
} message_bundle_wanted_t; /* BUNDLE_WANTED, BUNDLE_PUT_OK (offset: the next) */

typedef struct message_report { /* STATUS_DATA, PROGRESS */
    uint64_t job;
    const char *text; /* JSON */
} message_report_t;

typedef struct message_fetch {
    uint64_t job;
    uint8_t output; /* message_output_t */
    uint64_t offset;
    uint32_t length;
} message_fetch_t;

typedef struct message_fetch_data {
    uint64_t job;
    uint8_t output;
    uint64_t revision; /* differs when the output has changed since: begin again at 0 */
    uint64_t total, offset;
    message_bytes_t bytes;
} message_fetch_data_t;

typedef struct message_done {
    uint16_t request; /* message_type_t that is done */
    uint64_t job;
} message_done_t;

typedef struct message_job_end {
    uint64_t job;
    uint8_t state; /* message_end_t */
    const char *text;
} message_job_end_t;

typedef struct message {
    message_type_t type;
    union {
        message_hello_t hello;
        message_welcome_t welcome;
        message_refused_t refused;
        message_heartbeat_t heartbeat;
        message_farewell_t farewell; /* BYE, SHUTDOWN */
        message_ready_t ready;
        message_work_t work;
        message_job_t job; /* JOB_QUERY, CANCEL, SUBMITTED, STATUS, CANCEL_JOB, SUBSCRIBE */
        message_job_data_t job_data;
        message_bundle_get_t bundle_get;
        message_chunk_t chunk; /* BUNDLE_DATA, BUNDLE_PUT */
        message_result_t result;
        message_failed_t failed;
        message_acknowledge_t ack;
        message_submit_t submit;
        message_bundle_wanted_t bundle_wanted; /* BUNDLE_WANTED, BUNDLE_PUT_OK */
        message_report_t report;               /* STATUS_DATA, PROGRESS */
        message_fetch_t fetch;
        message_fetch_data_t fetch_data;
        message_done_t done;
        message_job_end_t job_end;
    };
} message_t;

/* The frame of a message; *data is the caller's to free(). A field beyond its limit is a fault (FAULT_LIMIT,
 * FAULT_RANGE, FAULT_FORMAT) that names it; sentences for people are cut and cleaned instead. */
fault_code_t message_encode(const message_t *message, uint8_t **data, size_t *size, fault_t *fault);

/* Reads a frame into *out, which borrows from it. FAULT_PROTOCOL: not a Garland frame, or an unknown type.
 * FAULT_VERSION: another protocol version; the text names both. Other faults name the field.
 * HELLO and REFUSED of other versions: a REFUSED is read whatever its version (its text comes first for ever);
 * a HELLO gives FAULT_VERSION with out->type and out->hello.garland_version set. After other faults *out is empty.
 */
fault_code_t message_decode(message_t *out, const void *data, size_t size, fault_t *fault);

/* "RESULT"; "unknown type" for a number that is none. */
const char *message_type_name(unsigned type);
/* message_sender_t bits of who may send the type; 0 for a number that is none. */
unsigned message_senders(unsigned type);

/* A code as it came in REFUSED or FAILED; FAULT_PROTOCOL for one that this version does not know. */
fault_code_t message_fault_code(unsigned code);

void message_lease_pack(uint8_t *packed, uint32_t index, const message_lease_t *lease);
message_lease_t message_lease_at(const message_leases_t *leases, uint32_t index);
bool message_lease_equal(const message_lease_t *a, const message_lease_t *b);

/* ---- the table of fields, for encoding, tests and fuzzing ---- */

typedef enum message_field_kind {
    MESSAGE_FIELD_U8,
    MESSAGE_FIELD_U16,
    MESSAGE_FIELD_U32,
    MESSAGE_FIELD_U64,
    MESSAGE_FIELD_DIGEST,
    MESSAGE_FIELD_STRING,   /* strict text */
    MESSAGE_FIELD_SENTENCE, /* on the wire a string; the encoder cuts and cleans it */
    MESSAGE_FIELD_BYTES,
    MESSAGE_FIELD_LEASES
} message_field_kind_t;

typedef struct message_field {
    const char *name;
    message_field_kind_t kind;
    size_t offset;     /* in message_t */
    uint64_t min, max; /* value of a number; octets of text and bytes; count of leases */
} message_field_t;

/* The fields of a type in wire order; null and 0 for a number that is none. */
const message_field_t *message_fields(unsigned type, size_t *count);
const char *message_field_kind_name(message_field_kind_t kind); /* as PROTOCOL.md writes it: "u16", "string" */

#endif
