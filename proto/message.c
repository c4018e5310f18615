#include "proto/message.h"

#include <stdlib.h>
#include <string.h>

#include "base/wire.h"

/* ---- types ---- */

const char *message_type_name(unsigned type)
{
    switch (type) {
#define MESSAGE_CASE(name, number, senders)                                                                        \
    case number:                                                                                                   \
        return #name;
        MESSAGE_TYPES(MESSAGE_CASE)
#undef MESSAGE_CASE
    }
    return "unknown type";
}

unsigned message_senders(unsigned type)
{
    switch (type) {
#define MESSAGE_CASE(name, number, senders)                                                                        \
    case number:                                                                                                   \
        return senders;
        MESSAGE_TYPES(MESSAGE_CASE)
#undef MESSAGE_CASE
    }
    return 0;
}

fault_code_t message_fault_code(unsigned code)
{
    return code < FAULT_COUNT ? (fault_code_t)code : FAULT_PROTOCOL;
}

/* ---- fields ---- */

#define AT(member) offsetof(message_t, member)
#define U8(name, member, lo, hi)                                                                                   \
    {                                                                                                              \
        name, MESSAGE_FIELD_U8, AT(member), lo, hi                                                                 \
    }
#define U16(name, member)                                                                                          \
    {                                                                                                              \
        name, MESSAGE_FIELD_U16, AT(member), 0, UINT16_MAX                                                         \
    }
#define U32(name, member, lo, hi)                                                                                  \
    {                                                                                                              \
        name, MESSAGE_FIELD_U32, AT(member), lo, hi                                                                \
    }
#define U64(name, member, lo, hi)                                                                                  \
    {                                                                                                              \
        name, MESSAGE_FIELD_U64, AT(member), lo, hi                                                                \
    }
#define ANY64(name, member) U64(name, member, 0, UINT64_MAX)
#define JOB(member) U64("job", member, 1, UINT64_MAX)
#define DIGEST(name, member)                                                                                       \
    {                                                                                                              \
        name, MESSAGE_FIELD_DIGEST, AT(member), 0, 0                                                               \
    }
#define STRING(name, member, lo, hi)                                                                               \
    {                                                                                                              \
        name, MESSAGE_FIELD_STRING, AT(member), lo, hi                                                             \
    }
#define SENTENCE(member)                                                                                           \
    {                                                                                                              \
        "text", MESSAGE_FIELD_SENTENCE, AT(member), 0, MESSAGE_MAX_STRING                                          \
    }
#define BYTES(name, member, hi)                                                                                    \
    {                                                                                                              \
        name, MESSAGE_FIELD_BYTES, AT(member), 0, hi                                                               \
    }
#define LEASE(member) JOB(member.job), ANY64("unit", member.unit), ANY64("attempt", member.attempt)

static const message_field_t HELLO_FIELDS[] = {
    STRING("garland_version", hello.garland_version, 1, MESSAGE_MAX_STRING),
    U8("role", hello.role, MESSAGE_ROLE_WORKER, MESSAGE_ROLE_CLIENT),
    STRING("arch", hello.arch, 0, MESSAGE_MAX_STRING),
    STRING("host", hello.host, 0, MESSAGE_MAX_STRING),
    U32("pid", hello.pid, 0, UINT32_MAX),
    U32("threads", hello.threads, 0, MESSAGE_MAX_THREADS),
    ANY64("session", hello.session),
    STRING("token", hello.token, 0, MESSAGE_MAX_TOKEN),
};
static const message_field_t WELCOME_FIELDS[] = {
    STRING("garland_version", welcome.garland_version, 1, MESSAGE_MAX_STRING),
    U32("heartbeat_ms", welcome.heartbeat_ms, MESSAGE_MIN_INTERVAL_MS, MESSAGE_MAX_INTERVAL_MS),
    U32("lease_ms", welcome.lease_ms, MESSAGE_MIN_INTERVAL_MS, MESSAGE_MAX_INTERVAL_MS),
    U64("session", welcome.session, 1, UINT64_MAX),
};
static const message_field_t REFUSED_FIELDS[] = {
    SENTENCE(refused.text),
    U16("code", refused.code),
    U16("request", refused.request),
    ANY64("job", refused.job),
};
static const message_field_t HEARTBEAT_FIELDS[] = {
    {"leases", MESSAGE_FIELD_LEASES, AT(heartbeat.leases), 0, MESSAGE_MAX_LEASES},
};
static const message_field_t FAREWELL_FIELDS[] = {SENTENCE(farewell.text)};
static const message_field_t READY_FIELDS[] = {U32("slots", ready.slots, 1, MESSAGE_MAX_SLOTS)};
static const message_field_t WORK_FIELDS[] = {
    LEASE(work.lease),
    DIGEST("job_digest", work.job_digest),
    DIGEST("bundle_digest", work.bundle_digest),
    BYTES("record", work.record, MESSAGE_MAX_RECORD),
};
static const message_field_t JOB_FIELDS[] = {JOB(job.job)};
static const message_field_t STATUS_FIELDS[] = {ANY64("job", job.job)};
static const message_field_t JOB_DATA_FIELDS[] = {
    JOB(job_data.job),
    DIGEST("bundle_digest", job_data.bundle_digest),
    STRING("text", job_data.text, 0, MESSAGE_MAX_TEXT),
};
static const message_field_t BUNDLE_GET_FIELDS[] = {
    DIGEST("digest", bundle_get.digest),
    U64("offset", bundle_get.offset, 0, MESSAGE_MAX_BUNDLE),
    U32("length", bundle_get.length, 1, MESSAGE_MAX_CHUNK),
};
static const message_field_t CHUNK_FIELDS[] = {
    DIGEST("digest", chunk.digest),
    U64("total", chunk.total, 0, MESSAGE_MAX_BUNDLE),
    U64("offset", chunk.offset, 0, MESSAGE_MAX_BUNDLE),
    BYTES("bytes", chunk.bytes, MESSAGE_MAX_CHUNK),
};
static const message_field_t RESULT_FIELDS[] = {
    LEASE(result.lease),
    BYTES("bytes", result.bytes, MESSAGE_MAX_RESULT),
};
static const message_field_t FAILED_FIELDS[] = {
    LEASE(failed.lease),
    U16("code", failed.code),
    SENTENCE(failed.text),
};
static const message_field_t ACK_FIELDS[] = {
    LEASE(ack.lease),
    U8("outcome", ack.outcome, MESSAGE_ACK_MERGED, MESSAGE_ACK_UNKNOWN),
};
static const message_field_t SUBMIT_FIELDS[] = {
    STRING("text", submit.text, 0, MESSAGE_MAX_TEXT),
    DIGEST("bundle_digest", submit.bundle_digest),
    U64("bundle_size", submit.bundle_size, 0, MESSAGE_MAX_BUNDLE),
};
static const message_field_t BUNDLE_WANTED_FIELDS[] = {
    DIGEST("digest", bundle_wanted.digest),
    U64("offset", bundle_wanted.offset, 0, MESSAGE_MAX_BUNDLE),
};
static const message_field_t STATUS_DATA_FIELDS[] = {
    ANY64("job", report.job),
    STRING("text", report.text, 0, MESSAGE_MAX_STATUS),
};
static const message_field_t FETCH_FIELDS[] = {
    JOB(fetch.job),
    U8("output", fetch.output, MESSAGE_OUTPUT_IMAGE, MESSAGE_OUTPUT_REPORT),
    U64("offset", fetch.offset, 0, MESSAGE_MAX_OUTPUT),
    U32("length", fetch.length, 1, MESSAGE_MAX_CHUNK),
};
static const message_field_t FETCH_DATA_FIELDS[] = {
    JOB(fetch_data.job),
    U8("output", fetch_data.output, MESSAGE_OUTPUT_IMAGE, MESSAGE_OUTPUT_REPORT),
    ANY64("revision", fetch_data.revision),
    U64("total", fetch_data.total, 0, MESSAGE_MAX_OUTPUT),
    U64("offset", fetch_data.offset, 0, MESSAGE_MAX_OUTPUT),
    BYTES("bytes", fetch_data.bytes, MESSAGE_MAX_CHUNK),
};
static const message_field_t DONE_FIELDS[] = {
    U16("request", done.request),
    ANY64("job", done.job),
};
static const message_field_t PROGRESS_FIELDS[] = {
    JOB(report.job),
    STRING("text", report.text, 0, MESSAGE_MAX_TEXT),
};
static const message_field_t JOB_END_FIELDS[] = {
    JOB(job_end.job),
    U8("state", job_end.state, MESSAGE_END_FINISHED, MESSAGE_END_CANCELLED),
    SENTENCE(job_end.text),
};

#define FIELDS(list)                                                                                               \
    *count = sizeof(list) / sizeof *(list);                                                                        \
    return list

const message_field_t *message_fields(unsigned type, size_t *count)
{
    switch (type) {
    case MESSAGE_HELLO:
        FIELDS(HELLO_FIELDS);
    case MESSAGE_WELCOME:
        FIELDS(WELCOME_FIELDS);
    case MESSAGE_REFUSED:
        FIELDS(REFUSED_FIELDS);
    case MESSAGE_HEARTBEAT:
        FIELDS(HEARTBEAT_FIELDS);
    case MESSAGE_BYE:
    case MESSAGE_SHUTDOWN:
        FIELDS(FAREWELL_FIELDS);
    case MESSAGE_READY:
        FIELDS(READY_FIELDS);
    case MESSAGE_WORK:
        FIELDS(WORK_FIELDS);
    case MESSAGE_JOB_QUERY:
    case MESSAGE_CANCEL:
    case MESSAGE_SUBMITTED:
    case MESSAGE_CANCEL_JOB:
    case MESSAGE_SUBSCRIBE:
        FIELDS(JOB_FIELDS);
    case MESSAGE_STATUS:
        FIELDS(STATUS_FIELDS);
    case MESSAGE_JOB_DATA:
        FIELDS(JOB_DATA_FIELDS);
    case MESSAGE_BUNDLE_GET:
        FIELDS(BUNDLE_GET_FIELDS);
    case MESSAGE_BUNDLE_DATA:
    case MESSAGE_BUNDLE_PUT:
        FIELDS(CHUNK_FIELDS);
    case MESSAGE_RESULT:
        FIELDS(RESULT_FIELDS);
    case MESSAGE_FAILED:
        FIELDS(FAILED_FIELDS);
    case MESSAGE_ACK:
        FIELDS(ACK_FIELDS);
    case MESSAGE_SUBMIT:
        FIELDS(SUBMIT_FIELDS);
    case MESSAGE_BUNDLE_WANTED:
    case MESSAGE_BUNDLE_PUT_OK:
        FIELDS(BUNDLE_WANTED_FIELDS);
    case MESSAGE_STATUS_DATA:
        FIELDS(STATUS_DATA_FIELDS);
    case MESSAGE_FETCH:
        FIELDS(FETCH_FIELDS);
    case MESSAGE_FETCH_DATA:
        FIELDS(FETCH_DATA_FIELDS);
    case MESSAGE_DONE:
        FIELDS(DONE_FIELDS);
    case MESSAGE_PROGRESS:
        FIELDS(PROGRESS_FIELDS);
    case MESSAGE_JOB_END:
        FIELDS(JOB_END_FIELDS);
    }
    *count = 0; /* HELLO_WANTED, and numbers that are no type */
    return NULL;
}

const char *message_field_kind_name(message_field_kind_t kind)
{
    static const char *const names[] = {"u8",     "u16",      "u32",   "u64",   "digest",
                                        "string", "sentence", "bytes", "leases"};
    return names[kind];
}

/* ---- encoding ---- */

static void put_number(wire_writer_t *out, const message_field_t *field, uint64_t value)
{
    if (value < field->min || value > field->max) {
        wire_writer_fail(out, FAULT_RANGE, field->name, "%llu, expected %llu to %llu", (unsigned long long)value,
                         (unsigned long long)field->min, (unsigned long long)field->max);
        return;
    }
    switch (field->kind) {
    case MESSAGE_FIELD_U8:
        wire_put_u8(out, (uint8_t)value);
        break;
    case MESSAGE_FIELD_U16:
        wire_put_u16(out, (uint16_t)value);
        break;
    case MESSAGE_FIELD_U32:
        wire_put_u32(out, (uint32_t)value);
        break;
    default:
        wire_put_u64(out, value);
    }
}

static void put_string(wire_writer_t *out, const message_field_t *field, const char *text)
{
    if (field->min > 0 && (!text || strlen(text) < field->min))
        wire_writer_fail(out, FAULT_RANGE, field->name, "empty");
    else
        wire_put_string(out, field->name, text, field->max);
}

static void put_leases(wire_writer_t *out, const message_field_t *field, const message_leases_t *leases)
{
    put_number(out, &(message_field_t){field->name, MESSAGE_FIELD_U32, 0, field->min, field->max}, leases->count);
    wire_put_raw(out, leases->packed, (size_t)leases->count * MESSAGE_LEASE_SIZE);
}

static void put_field(wire_writer_t *out, const message_field_t *field, const message_t *message)
{
    const void *at = (const char *)message + field->offset;
    switch (field->kind) {
    case MESSAGE_FIELD_U8:
        put_number(out, field, *(const uint8_t *)at);
        break;
    case MESSAGE_FIELD_U16:
        put_number(out, field, *(const uint16_t *)at);
        break;
    case MESSAGE_FIELD_U32:
        put_number(out, field, *(const uint32_t *)at);
        break;
    case MESSAGE_FIELD_U64:
        put_number(out, field, *(const uint64_t *)at);
        break;
    case MESSAGE_FIELD_DIGEST:
        wire_put_digest(out, at);
        break;
    case MESSAGE_FIELD_STRING:
        put_string(out, field, *(const char *const *)at);
        break;
    case MESSAGE_FIELD_SENTENCE:
        wire_put_sentence(out, *(const char *const *)at, field->max);
        break;
    case MESSAGE_FIELD_BYTES: {
        const message_bytes_t *bytes = at;
        wire_put_bytes(out, field->name, bytes->data, bytes->size, field->max);
        break;
    }
    case MESSAGE_FIELD_LEASES:
        put_leases(out, field, at);
        break;
    }
}

static bool is_chunk(unsigned type)
{
    return type == MESSAGE_BUNDLE_DATA || type == MESSAGE_BUNDLE_PUT || type == MESSAGE_FETCH_DATA;
}

/* What one field alone cannot say: a chunk lies inside its whole. Totals are below 2^41: no overflow. */
static fault_code_t check_whole(const message_t *message, fault_t *fault)
{
    if (!is_chunk(message->type))
        return FAULT_NONE;
    const bool fetch = message->type == MESSAGE_FETCH_DATA;
    const uint64_t total = fetch ? message->fetch_data.total : message->chunk.total;
    const uint64_t offset = fetch ? message->fetch_data.offset : message->chunk.offset;
    const uint64_t size = fetch ? message->fetch_data.bytes.size : message->chunk.bytes.size;
    if (offset + size > total)
        return fault_set(fault, FAULT_RANGE, "%s.bytes: %llu octets at offset %llu end beyond the total of %llu",
                         message_type_name(message->type), (unsigned long long)size, (unsigned long long)offset,
                         (unsigned long long)total);
    return FAULT_NONE;
}

static fault_code_t put_message(wire_writer_t *out, const message_t *message)
{
    wire_put_raw(out, MESSAGE_SIGNATURE, 4);
    wire_put_u16(out, MESSAGE_PROTOCOL_VERSION);
    wire_put_u16(out, (uint16_t)message->type);
    size_t count;
    const message_field_t *fields = message_fields(message->type, &count);
    for (size_t i = 0; i < count; i++)
        put_field(out, &fields[i], message);
    return out->code;
}

fault_code_t message_encode(const message_t *message, uint8_t **data, size_t *size, fault_t *fault)
{
    const char *name = message_type_name(message->type);
    if (message_senders(message->type) == 0)
        return fault_set(fault, FAULT_USAGE, "message type %u does not exist", (unsigned)message->type);
    wire_writer_t out;
    wire_writer_init(&out, NULL, 0, name, fault);
    TRY(put_message(&out, message));
    TRY(check_whole(message, fault));
    uint8_t *frame = malloc(out.at);
    if (!frame)
        return fault_set(fault, FAULT_MEMORY, "%s: no memory for a frame of %zu octets", name, out.at);
    const size_t total = out.at;
    wire_writer_init(&out, frame, total, name, fault);
    if (put_message(&out, message)) {
        free(frame);
        return out.code;
    }
    *data = frame;
    *size = total;
    return FAULT_NONE;
}

/* ---- decoding ---- */

static uint64_t get_number(wire_reader_t *in, const message_field_t *field)
{
    uint64_t value;
    switch (field->kind) {
    case MESSAGE_FIELD_U8:
        value = wire_get_u8(in, field->name);
        break;
    case MESSAGE_FIELD_U16:
        value = wire_get_u16(in, field->name);
        break;
    case MESSAGE_FIELD_U64:
        value = wire_get_u64(in, field->name);
        break;
    default:
        value = wire_get_u32(in, field->name);
    }
    if (in->code == FAULT_NONE && (value < field->min || value > field->max))
        wire_reader_fail(in, FAULT_RANGE, field->name, "%llu, expected %llu to %llu", (unsigned long long)value,
                         (unsigned long long)field->min, (unsigned long long)field->max);
    return value;
}

static void get_leases(wire_reader_t *in, const message_field_t *field, message_leases_t *out)
{
    const uint64_t count = get_number(in, field);
    if (in->code != FAULT_NONE)
        return;
    out->packed = wire_get_raw(in, field->name, (size_t)count * MESSAGE_LEASE_SIZE);
    out->count = out->packed ? (uint32_t)count : 0;
}

static const char *get_string(wire_reader_t *in, const message_field_t *field)
{
    const char *text = wire_get_string(in, field->name, field->max);
    if (field->min > 0 && *text == '\0')
        wire_reader_fail(in, FAULT_RANGE, field->name, "empty");
    return text;
}

static void get_field(wire_reader_t *in, const message_field_t *field, message_t *message)
{
    void *at = (char *)message + field->offset;
    switch (field->kind) {
    case MESSAGE_FIELD_U8:
        *(uint8_t *)at = (uint8_t)get_number(in, field);
        break;
    case MESSAGE_FIELD_U16:
        *(uint16_t *)at = (uint16_t)get_number(in, field);
        break;
    case MESSAGE_FIELD_U32:
        *(uint32_t *)at = (uint32_t)get_number(in, field);
        break;
    case MESSAGE_FIELD_U64:
        *(uint64_t *)at = get_number(in, field);
        break;
    case MESSAGE_FIELD_DIGEST:
        wire_get_digest(in, field->name, at);
        break;
    case MESSAGE_FIELD_STRING:
    case MESSAGE_FIELD_SENTENCE:
        *(const char **)at = get_string(in, field);
        break;
    case MESSAGE_FIELD_BYTES: {
        message_bytes_t *bytes = at;
        bytes->data = wire_get_bytes(in, field->name, field->max, &bytes->size);
        break;
    }
    case MESSAGE_FIELD_LEASES:
        get_leases(in, field, at);
        break;
    }
}

/* The fault for a frame of another version; what is the same in all versions is read into *out. */
static fault_code_t other_version(message_t *out, wire_reader_t *in, unsigned version, unsigned type,
                                  fault_t *fault)
{
    const char *sender = "";
    if (type == MESSAGE_HELLO) {
        wire_reader_t quiet = *in;
        quiet.fault = NULL;
        sender = wire_get_string(&quiet, "garland_version", MESSAGE_MAX_STRING);
        out->type = MESSAGE_HELLO;
        out->hello.garland_version = sender;
    }
    return fault_set(fault, FAULT_VERSION,
                     "protocol version %u%s%.64s%s found, but this is Garland %s with protocol version %d", version,
                     *sender ? " (of Garland " : "", sender, *sender ? ")" : "", GARLAND_VERSION,
                     MESSAGE_PROTOCOL_VERSION);
}

static fault_code_t decode(message_t *out, const void *data, size_t size, fault_t *fault)
{
    wire_reader_t in;
    wire_reader_init(&in, data, size, "message", fault);
    const uint8_t *signature = wire_get_raw(&in, "signature", 4);
    if (!signature || memcmp(signature, MESSAGE_SIGNATURE, 4) != 0)
        return fault_set(fault, FAULT_PROTOCOL, "a frame of %zu octets does not begin with \"%s\"", size,
                         MESSAGE_SIGNATURE);
    const unsigned version = wire_get_u16(&in, "version");
    const unsigned type = wire_get_u16(&in, "type");
    if (in.code)
        return fault_set(fault, FAULT_PROTOCOL, "a frame of %zu octets is shorter than a message's header", size);
    if (version != MESSAGE_PROTOCOL_VERSION && type != MESSAGE_REFUSED)
        return other_version(out, &in, version, type, fault);
    if (message_senders(type) == 0)
        return fault_set(fault, FAULT_PROTOCOL, "message type %u does not exist", type);
    out->type = type;
    in.what = message_type_name(type);
    size_t count;
    const message_field_t *fields = message_fields(type, &count);
    if (version != MESSAGE_PROTOCOL_VERSION) { /* REFUSED: its text, and what that says of itself */
        get_field(&in, &fields[0], out);
        out->refused.code = FAULT_VERSION;
        return in.code;
    }
    for (size_t i = 0; i < count; i++)
        get_field(&in, &fields[i], out);
    TRY(wire_reader_end(&in));
    return check_whole(out, fault);
}

fault_code_t message_decode(message_t *out, const void *data, size_t size, fault_t *fault)
{
    memset(out, 0, sizeof *out);
    const fault_code_t code = decode(out, data, size, fault);
    if (code != FAULT_NONE && code != FAULT_VERSION)
        memset(out, 0, sizeof *out);
    return code;
}

/* ---- leases ---- */

static void pack_u64(uint8_t *at, uint64_t value)
{
    for (int i = 0; i < 8; i++)
        at[i] = (uint8_t)(value >> (8 * i));
}

static uint64_t unpack_u64(const uint8_t *at)
{
    uint64_t value = 0;
    for (int i = 0; i < 8; i++)
        value |= (uint64_t)at[i] << (8 * i);
    return value;
}

void message_lease_pack(uint8_t *packed, uint32_t index, const message_lease_t *lease)
{
    uint8_t *at = packed + (size_t)index * MESSAGE_LEASE_SIZE;
    pack_u64(at, lease->job);
    pack_u64(at + 8, lease->unit);
    pack_u64(at + 16, lease->attempt);
}

message_lease_t message_lease_at(const message_leases_t *leases, uint32_t index)
{
    const uint8_t *at = leases->packed + (size_t)index * MESSAGE_LEASE_SIZE;
    return (message_lease_t){unpack_u64(at), unpack_u64(at + 8), unpack_u64(at + 16)};
}

bool message_lease_equal(const message_lease_t *a, const message_lease_t *b)
{
    return a->job == b->job && a->unit == b->unit && a->attempt == b->attempt;
}
