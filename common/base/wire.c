#include "base/wire.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

__attribute__((format(printf, 6, 0))) static fault_code_t fail(fault_t *fault, fault_code_t *sticky,
                                                               fault_code_t code, const char *what,
                                                               const char *field, const char *format,
                                                               va_list arguments)
{
    if (*sticky != FAULT_NONE)
        return *sticky;
    char detail[512];
    vsnprintf(detail, sizeof detail, format, arguments);
    *sticky = fault_set(fault, code, "%s.%s: %s", what, field, detail);
    return *sticky;
}

size_t wire_text_character(const uint8_t *text, size_t size)
{
    if (size == 0)
        return 0;
    const uint8_t first = text[0];
    if (first < 0x80)
        return (first >= 0x20 && first != 0x7f) || first == '\t' || first == '\n' ? 1 : 0;
    size_t count;
    uint32_t code, least;
    if (first >= 0xc2 && first <= 0xdf) {
        count = 2, code = first & 0x1f, least = 0xa0; /* U+0080 to U+009F are control characters */
    } else if (first >= 0xe0 && first <= 0xef) {
        count = 3, code = first & 0x0f, least = 0x800;
    } else if (first >= 0xf0 && first <= 0xf4) {
        count = 4, code = first & 0x07, least = 0x10000;
    } else {
        return 0;
    }
    if (size < count)
        return 0;
    for (size_t i = 1; i < count; i++) {
        if ((text[i] & 0xc0) != 0x80)
            return 0;
        code = code << 6 | (text[i] & 0x3f);
    }
    if (code < least || code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff))
        return 0;
    return count;
}

/* ---- reader ---- */

void wire_reader_init(wire_reader_t *in, const void *data, size_t size, const char *what, fault_t *fault)
{
    *in = (wire_reader_t){.data = data, .size = size, .what = what, .fault = fault};
}

fault_code_t wire_reader_fail(wire_reader_t *in, fault_code_t code, const char *field, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail(in->fault, &in->code, code, in->what, field, format, arguments);
    va_end(arguments);
    return in->code;
}

const uint8_t *wire_get_raw(wire_reader_t *in, const char *field, size_t count)
{
    if (in->code != FAULT_NONE)
        return NULL;
    const size_t left = in->size - in->at;
    if (count > left) {
        wire_reader_fail(in, FAULT_FORMAT, field, "%zu octets expected at offset %zu, %zu left", count, in->at,
                         left);
        return NULL;
    }
    static const uint8_t nothing[1];
    const uint8_t *data = in->data ? in->data + in->at : nothing;
    in->at += count;
    return data;
}

static uint64_t get_integer(wire_reader_t *in, const char *field, size_t size)
{
    const uint8_t *data = wire_get_raw(in, field, size);
    uint64_t value = 0;
    if (data)
        for (size_t i = 0; i < size; i++)
            value |= (uint64_t)data[i] << (8 * i);
    return value;
}

uint8_t wire_get_u8(wire_reader_t *in, const char *field)
{
    return (uint8_t)get_integer(in, field, 1);
}

uint16_t wire_get_u16(wire_reader_t *in, const char *field)
{
    return (uint16_t)get_integer(in, field, 2);
}

uint32_t wire_get_u32(wire_reader_t *in, const char *field)
{
    return (uint32_t)get_integer(in, field, 4);
}

uint64_t wire_get_u64(wire_reader_t *in, const char *field)
{
    return get_integer(in, field, 8);
}

double wire_get_f64(wire_reader_t *in, const char *field)
{
    const uint64_t bits = get_integer(in, field, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

void wire_get_digest(wire_reader_t *in, const char *field, digest_t *out)
{
    const uint8_t *data = wire_get_raw(in, field, DIGEST_SIZE);
    if (data)
        memcpy(out->bytes, data, DIGEST_SIZE);
    else
        memset(out->bytes, 0, DIGEST_SIZE);
}

const uint8_t *wire_get_bytes(wire_reader_t *in, const char *field, size_t max, size_t *size)
{
    *size = 0;
    const uint32_t count = wire_get_u32(in, field);
    if (in->code == FAULT_NONE && count > max)
        wire_reader_fail(in, FAULT_LIMIT, field, "%u octets, at most %zu are allowed", count, max);
    const uint8_t *data = wire_get_raw(in, field, count);
    if (data)
        *size = count;
    return data;
}

/* Offset of the first octet that is not text, or size. */
static size_t text_end(const uint8_t *text, size_t size)
{
    size_t at = 0;
    while (at < size) {
        const size_t step = wire_text_character(text + at, size - at);
        if (step == 0)
            return at;
        at += step;
    }
    return size;
}

const char *wire_get_string(wire_reader_t *in, const char *field, size_t max)
{
    size_t size;
    const uint8_t *text = wire_get_bytes(in, field, max, &size);
    const uint8_t *end = wire_get_raw(in, field, 1);
    if (!text || !end)
        return "";
    if (*end != 0) {
        wire_reader_fail(in, FAULT_FORMAT, field, "octet 0x%02x after the text, expected 0", *end);
        return "";
    }
    const size_t good = text_end(text, size);
    if (good != size) {
        wire_reader_fail(in, FAULT_FORMAT, field, "octet 0x%02x at %zu is not text", text[good], good);
        return "";
    }
    return (const char *)text;
}

fault_code_t wire_reader_end(wire_reader_t *in)
{
    if (in->code == FAULT_NONE && in->at != in->size)
        wire_reader_fail(in, FAULT_FORMAT, "end", "%zu octets after the last field", in->size - in->at);
    return in->code;
}

/* ---- writer ---- */

void wire_writer_init(wire_writer_t *out, void *data, size_t size, const char *what, fault_t *fault)
{
    *out = (wire_writer_t){.data = data, .size = data ? size : SIZE_MAX, .what = what, .fault = fault};
}

void wire_writer_init_growing(wire_writer_t *out, const char *what, fault_t *fault)
{
    *out = (wire_writer_t){.what = what, .fault = fault, .grows = true};
}

void wire_writer_clear(wire_writer_t *out)
{
    free(out->data);
    out->data = NULL;
    out->size = out->at = 0;
}

fault_code_t wire_writer_fail(wire_writer_t *out, fault_code_t code, const char *field, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail(out->fault, &out->code, code, out->what, field, format, arguments);
    va_end(arguments);
    return out->code;
}

/* Room for `count` octets more, at least half as much again as there was. */
static void writer_grow(wire_writer_t *out, size_t count)
{
    const size_t least = out->at + count, more = out->size + out->size / 2, size = least > more ? least : more;
    uint8_t *data = size >= count ? realloc(out->data, size) : NULL;
    if (!data) {
        wire_writer_fail(out, FAULT_MEMORY, "end", "no memory for %zu octets at %zu", count, out->at);
        return;
    }
    out->data = data;
    out->size = size;
}

void wire_put_raw(wire_writer_t *out, const void *data, size_t count)
{
    if (out->grows && out->code == FAULT_NONE && count > out->size - out->at)
        writer_grow(out, count);
    if (out->code != FAULT_NONE)
        return;
    if (count > out->size - out->at) {
        wire_writer_fail(out, FAULT_LIMIT, "end", "%zu octets at %zu do not fit into %zu", count, out->at,
                         out->size);
        return;
    }
    if (out->data && count)
        memcpy(out->data + out->at, data, count);
    out->at += count;
}

static void put_integer(wire_writer_t *out, uint64_t value, size_t size)
{
    uint8_t data[8];
    for (size_t i = 0; i < size; i++)
        data[i] = (uint8_t)(value >> (8 * i));
    wire_put_raw(out, data, size);
}

void wire_put_u8(wire_writer_t *out, uint8_t value)
{
    put_integer(out, value, 1);
}

void wire_put_u16(wire_writer_t *out, uint16_t value)
{
    put_integer(out, value, 2);
}

void wire_put_u32(wire_writer_t *out, uint32_t value)
{
    put_integer(out, value, 4);
}

void wire_put_u64(wire_writer_t *out, uint64_t value)
{
    put_integer(out, value, 8);
}

void wire_put_f64(wire_writer_t *out, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_integer(out, bits, 8);
}

void wire_put_digest(wire_writer_t *out, const digest_t *digest)
{
    wire_put_raw(out, digest->bytes, DIGEST_SIZE);
}

void wire_put_bytes(wire_writer_t *out, const char *field, const void *data, size_t count, size_t max)
{
    if (count > max || count > UINT32_MAX) {
        wire_writer_fail(out, FAULT_LIMIT, field, "%zu octets, at most %zu are allowed", count, max);
        return;
    }
    wire_put_u32(out, (uint32_t)count);
    wire_put_raw(out, data, count);
}

void wire_put_string(wire_writer_t *out, const char *field, const char *text, size_t max)
{
    const char *put = text ? text : "";
    const size_t size = strlen(put);
    const size_t good = text_end((const uint8_t *)put, size);
    if (good != size) {
        wire_writer_fail(out, FAULT_FORMAT, field, "octet 0x%02x at %zu is not text", (uint8_t)put[good], good);
        return;
    }
    wire_put_bytes(out, field, put, size, max);
    wire_put_u8(out, 0);
}

void wire_put_sentence(wire_writer_t *out, const char *text, size_t max)
{
    const uint8_t *put = (const uint8_t *)(text ? text : "");
    const size_t size = strlen((const char *)put);
    size_t at = 0, kept = 0; /* octets read and those that will stand on the wire */
    const size_t start = out->at;
    wire_put_u32(out, 0);
    while (at < size) {
        const size_t step = wire_text_character(put + at, size - at);
        const size_t take = step ? step : 1;
        if (kept + take > max)
            break;
        wire_put_raw(out, step ? (const void *)(put + at) : "?", take);
        at += take;
        kept += take;
    }
    wire_put_u8(out, 0);
    if (out->code != FAULT_NONE)
        return;
    const size_t end = out->at;
    out->at = start;
    wire_put_u32(out, (uint32_t)kept); /* over the zero that held its place */
    out->at = end;
}
