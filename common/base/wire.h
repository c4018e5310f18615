/* wire.h: fields as bytes. A bounded writer and a bounded reader of little-endian fields; neither ever touches a
 * byte outside its buffer, and both carry a sticky fault: after the first failure every call does nothing (a reader
 * returns zeros), so that a record is read straight through and checked once at the end.
 *
 *     wire_reader_t in;
 *     wire_reader_init(&in, data, size, "unit record", fault);
 *     const uint64_t first = wire_get_u64(&in, "first");
 *     const double b = wire_get_f64(&in, "b");
 *     TRY(wire_reader_end(&in));
 *
 * A writer has a buffer of the caller's, counts only, or grows a buffer of its own.
 *
 * Thread rule: a reader or writer belongs to one caller.
 */
#ifndef BASE_WIRE_H
#define BASE_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/digest.h"
#include "base/fault.h"

typedef struct wire_reader {
    const uint8_t *data; /* borrowed */
    size_t size, at;
    const char *what;  /* borrowed: what is read, for messages */
    fault_code_t code; /* sticky */
    fault_t *fault;    /* borrowed; may be null */
} wire_reader_t;

void wire_reader_init(wire_reader_t *in, const void *data, size_t size, const char *what, fault_t *fault);
uint8_t wire_get_u8(wire_reader_t *in, const char *field);
uint16_t wire_get_u16(wire_reader_t *in, const char *field);
uint32_t wire_get_u32(wire_reader_t *in, const char *field);
uint64_t wire_get_u64(wire_reader_t *in, const char *field);
double wire_get_f64(wire_reader_t *in, const char *field); /* IEEE 754 binary64, any bits */
void wire_get_digest(wire_reader_t *in, const char *field, digest_t *out);
/* `count` octets as they are; borrowed from the reader's data; null after a fault. */
const uint8_t *wire_get_raw(wire_reader_t *in, const char *field, size_t count);
/* A u32 length and that many octets; borrowed. A length beyond max is refused. */
const uint8_t *wire_get_bytes(wire_reader_t *in, const char *field, size_t max, size_t *size);
/* A u32 length, that many octets of text and a zero octet: a C string borrowed from the reader's data, "" after a
 * fault. Refused: a length beyond max, invalid UTF-8, control characters other than tab and line feed. */
const char *wire_get_string(wire_reader_t *in, const char *field, size_t max);
/* Sets the sticky fault unless there is one already; for checks of the caller's own. */
fault_code_t wire_reader_fail(wire_reader_t *in, fault_code_t code, const char *field, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* The sticky fault, or FAULT_FORMAT if octets are left. */
fault_code_t wire_reader_end(wire_reader_t *in);

typedef struct wire_writer {
    uint8_t *data;   /* borrowed; null: only counts; growing: allocated */
    size_t size, at; /* capacity (ignored when counting), octets so far */
    bool grows;
    const char *what;
    fault_code_t code; /* sticky */
    fault_t *fault;
} wire_writer_t;

/* data == null counts octets: run the same calls twice, first to count, then to write. */
void wire_writer_init(wire_writer_t *out, void *data, size_t size, const char *what, fault_t *fault);
/* A buffer that grows with what is put: out->data, out->at octets, is the caller's to free(), with
 * wire_writer_clear or without. FAULT_MEMORY if there is none. */
void wire_writer_init_growing(wire_writer_t *out, const char *what, fault_t *fault);
void wire_writer_clear(wire_writer_t *out);
void wire_put_u8(wire_writer_t *out, uint8_t value);
void wire_put_u16(wire_writer_t *out, uint16_t value);
void wire_put_u32(wire_writer_t *out, uint32_t value);
void wire_put_u64(wire_writer_t *out, uint64_t value);
void wire_put_f64(wire_writer_t *out, double value);
void wire_put_digest(wire_writer_t *out, const digest_t *digest);
void wire_put_raw(wire_writer_t *out, const void *data, size_t count);
/* FAULT_LIMIT beyond max. */
void wire_put_bytes(wire_writer_t *out, const char *field, const void *data, size_t count, size_t max);
/* Null counts as "". FAULT_LIMIT beyond max, FAULT_FORMAT for text that wire_get_string would refuse. */
void wire_put_string(wire_writer_t *out, const char *field, const char *text, size_t max);
/* For sentences that people read: cut at max octets, and what wire_get_string would refuse becomes '?'. */
void wire_put_sentence(wire_writer_t *out, const char *text, size_t max);
fault_code_t wire_writer_fail(wire_writer_t *out, fault_code_t code, const char *field, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Octets of the valid character at text[0..size), 0 if there is none: UTF-8 (RFC 3629: no surrogates, nothing
 * overlong), no control characters but tab and line feed. */
size_t wire_text_character(const uint8_t *text, size_t size);

#endif
