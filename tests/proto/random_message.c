#include "proto/random_message.h"

#include <string.h>

#include "base/random.h"

typedef struct source {
    uint64_t key, counter;
} source_t;

static uint64_t draw(source_t *source)
{
    return random_u64(source->key, source->counter++);
}

/* Often a bound, else anything between. */
static uint64_t draw_between(source_t *source, uint64_t lo, uint64_t hi)
{
    const uint64_t choice = draw(source) % 8;
    if (choice < 2)
        return choice == 0 ? lo : hi;
    const uint64_t span = hi - lo;
    return lo + (span == UINT64_MAX ? draw(source) : draw(source) % (span + 1));
}

static uint8_t *take(random_message_t *out, size_t size)
{
    uint8_t *memory = out->memory + out->used;
    out->used += size;
    return memory;
}

static const char *draw_text(source_t *source, random_message_t *out, uint64_t min, uint64_t max)
{
    static const char *const characters[] = {
        "a", "Z", "~", " ", "\n", "\t", "\xc3\xa4", "\xe2\x82\xac", "\xf0\x9f\x8c\xbf"};
    const uint64_t most = max < RANDOM_MESSAGE_LENGTH ? max : RANDOM_MESSAGE_LENGTH;
    const uint64_t wanted = draw_between(source, min, most);
    char *text = (char *)take(out, RANDOM_MESSAGE_LENGTH + 1);
    size_t size = 0;
    while (size < wanted) {
        const char *add = characters[draw(source) % 9];
        if (size + strlen(add) > wanted)
            add = "x";
        memcpy(text + size, add, strlen(add));
        size += strlen(add);
    }
    text[size] = '\0';
    return text;
}

static message_bytes_t draw_bytes(source_t *source, random_message_t *out)
{
    message_bytes_t bytes = {.size = draw(source) % (RANDOM_MESSAGE_LENGTH + 1)};
    uint8_t *data = take(out, bytes.size);
    for (size_t i = 0; i < bytes.size; i++)
        data[i] = (uint8_t)draw(source);
    bytes.data = data;
    return bytes;
}

static message_leases_t draw_leases(source_t *source, random_message_t *out)
{
    message_leases_t leases = {.count = (uint32_t)(draw(source) % 6)};
    uint8_t *packed = take(out, (size_t)leases.count * MESSAGE_LEASE_SIZE);
    for (uint32_t i = 0; i < leases.count; i++)
        message_lease_pack(packed, i, &(message_lease_t){draw(source), draw(source), draw(source)});
    leases.packed = packed;
    return leases;
}

static void fill_field(source_t *source, random_message_t *out, const message_field_t *field)
{
    void *at = (char *)&out->message + field->offset;
    switch (field->kind) {
    case MESSAGE_FIELD_U8:
        *(uint8_t *)at = (uint8_t)draw_between(source, field->min, field->max);
        break;
    case MESSAGE_FIELD_U16:
        *(uint16_t *)at = (uint16_t)draw_between(source, field->min, field->max);
        break;
    case MESSAGE_FIELD_U32:
        *(uint32_t *)at = (uint32_t)draw_between(source, field->min, field->max);
        break;
    case MESSAGE_FIELD_U64:
        *(uint64_t *)at = draw_between(source, field->min, field->max);
        break;
    case MESSAGE_FIELD_DIGEST:
        for (int i = 0; i < DIGEST_SIZE; i++)
            ((digest_t *)at)->bytes[i] = (uint8_t)draw(source);
        break;
    case MESSAGE_FIELD_STRING:
    case MESSAGE_FIELD_SENTENCE:
        *(const char **)at = draw_text(source, out, field->min, field->max);
        break;
    case MESSAGE_FIELD_BYTES:
        *(message_bytes_t *)at = draw_bytes(source, out);
        break;
    case MESSAGE_FIELD_LEASES:
        *(message_leases_t *)at = draw_leases(source, out);
        break;
    }
}

/* Offsets and totals are bound to each other. */
static void mend_chunk(message_t *message)
{
    const bool fetch = message->type == MESSAGE_FETCH_DATA;
    if (!fetch && message->type != MESSAGE_BUNDLE_DATA && message->type != MESSAGE_BUNDLE_PUT)
        return;
    uint64_t *total = fetch ? &message->fetch_data.total : &message->chunk.total;
    uint64_t *offset = fetch ? &message->fetch_data.offset : &message->chunk.offset;
    const uint64_t size = fetch ? message->fetch_data.bytes.size : message->chunk.bytes.size;
    if (*total < size)
        *total = size;
    if (*offset > *total - size)
        *offset = *total - size;
}

void random_message_fill(random_message_t *out, unsigned type, uint64_t index)
{
    source_t source = {.key = random_key(0x77697265, RANDOM_PURPOSE_TEST, type, index)};
    memset(&out->message, 0, sizeof out->message);
    out->used = 0;
    out->message.type = type;
    size_t count;
    const message_field_t *fields = message_fields(type, &count);
    for (size_t i = 0; i < count; i++)
        fill_field(&source, out, &fields[i]);
    mend_chunk(&out->message);
}
