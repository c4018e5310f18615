/* Messages: what is encoded is decoded; everything else is refused, with a reason. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "proto/random_message.h"

enum { VARIANTS = 40, TYPES = 31 };

static random_message_t sample;

/* The frame in an allocation of exactly its size: the address sanitizer sees a read beyond. */
static uint8_t *frame_of(unsigned type, uint64_t index, size_t *size)
{
    uint8_t *data;
    fault_t fault = {0};
    random_message_fill(&sample, type, index);
    if (message_encode(&sample.message, &data, size, &fault))
        fail_msg("%s: %s", message_type_name(type), fault.text);
    return data;
}

static fault_code_t decode_copy(const uint8_t *data, size_t size, fault_t *fault)
{
    uint8_t *copy = malloc(size ? size : 1);
    memcpy(copy, data, size);
    message_t message;
    const fault_code_t code = message_decode(&message, copy, size, fault);
    free(copy);
    return code;
}

static void assert_fields_equal(const message_t *a, const message_t *b, const message_field_t *field)
{
    const void *x = (const char *)a + field->offset, *y = (const char *)b + field->offset;
    static const size_t sizes[] = {1, 2, 4, 8, DIGEST_SIZE};
    if (field->kind <= MESSAGE_FIELD_DIGEST) {
        assert_memory_equal(x, y, sizes[field->kind]);
    } else if (field->kind == MESSAGE_FIELD_BYTES) {
        const message_bytes_t *p = x, *q = y;
        assert_int_equal(p->size, q->size);
        if (p->size)
            assert_memory_equal(p->data, q->data, p->size);
    } else if (field->kind == MESSAGE_FIELD_LEASES) {
        const message_leases_t *p = x, *q = y;
        assert_int_equal(p->count, q->count);
        for (uint32_t i = 0; i < p->count; i++) {
            const message_lease_t l = message_lease_at(p, i), m = message_lease_at(q, i);
            assert_true(message_lease_equal(&l, &m));
        }
    } else {
        assert_string_equal(*(const char *const *)x, *(const char *const *)y);
    }
}

static void every_message_round_trips(void **state)
{
    (void)state;
    int types = 0;
    for (unsigned type = 0; type < 1u << 16; type++) {
        if (!message_senders(type))
            continue;
        types++;
        for (uint64_t index = 0; index < VARIANTS; index++) {
            size_t size, count;
            uint8_t *data = frame_of(type, index, &size);
            message_t message;
            fault_t fault = {0};
            if (message_decode(&message, data, size, &fault))
                fail_msg("%s: %s", message_type_name(type), fault.text);
            assert_int_equal(message.type, type);
            const message_field_t *fields = message_fields(type, &count);
            for (size_t i = 0; i < count; i++)
                assert_fields_equal(&sample.message, &message, &fields[i]);
            free(data);
        }
    }
    assert_int_equal(types, TYPES);
}

static void every_truncation_is_refused(void **state)
{
    (void)state;
    for (unsigned type = 0; type < RANDOM_MESSAGE_TYPES; type++)
        for (uint64_t index = 0; message_senders(type) && index < 4; index++) {
            size_t size;
            uint8_t *data = frame_of(type, index, &size);
            for (size_t cut = 0; cut < size; cut++) {
                fault_t fault = {0};
                const fault_code_t code = decode_copy(data, cut, &fault);
                if (code != FAULT_FORMAT && code != FAULT_PROTOCOL)
                    fail_msg("%s cut from %zu to %zu: code %d", message_type_name(type), size, cut, code);
                assert_true(fault.text[0] != '\0');
            }
            free(data);
        }
}

static void trailing_octets_are_refused(void **state)
{
    (void)state;
    for (unsigned type = 0; type < RANDOM_MESSAGE_TYPES; type++) {
        if (!message_senders(type))
            continue;
        size_t size;
        uint8_t *data = frame_of(type, 1, &size);
        uint8_t *longer = calloc(1, size + 1);
        memcpy(longer, data, size);
        fault_t fault = {0};
        assert_int_equal(decode_copy(longer, size + 1, &fault), FAULT_FORMAT);
        assert_non_null(strstr(fault.text, message_type_name(type)));
        free(longer);
        free(data);
    }
}

/* ---- limits ---- */

static uint64_t number_at(const uint8_t *data, size_t size)
{
    uint64_t value = 0;
    for (size_t i = 0; i < size; i++)
        value |= (uint64_t)data[i] << (8 * i);
    return value;
}

static void patch(uint8_t *data, size_t size, uint64_t value)
{
    for (size_t i = 0; i < size; i++)
        data[i] = (uint8_t)(value >> (8 * i));
}

/* Octets of a field at data, by the grammar and not by the code under test. */
static size_t field_size(const uint8_t *data, message_field_kind_t kind)
{
    static const size_t sizes[] = {1, 2, 4, 8, DIGEST_SIZE};
    if (kind <= MESSAGE_FIELD_DIGEST)
        return sizes[kind];
    const size_t count = number_at(data, 4);
    if (kind == MESSAGE_FIELD_LEASES)
        return 4 + count * MESSAGE_LEASE_SIZE;
    return 4 + count + (kind != MESSAGE_FIELD_BYTES);
}

static uint64_t kind_max(message_field_kind_t kind)
{
    static const uint64_t most[] = {UINT8_MAX, UINT16_MAX, UINT32_MAX, UINT64_MAX};
    return kind <= MESSAGE_FIELD_U64 ? most[kind] : UINT32_MAX;
}

static void expect_code(const uint8_t *data, size_t size, const message_field_t *field, fault_code_t expected)
{
    fault_t fault = {0};
    const fault_code_t code = decode_copy(data, size, &fault);
    if (code != expected || !strstr(fault.text, field->name))
        fail_msg("%s: code %d, expected %d: %s", field->name, code, expected, fault.text);
}

/* Beyond a bound a field is refused as such, at the bound it is not (a length then lacks its octets). */
static int check_field_limits(uint8_t *data, size_t size, size_t at, const message_field_t *field)
{
    static const size_t sizes[] = {1, 2, 4, 8, 0, 4, 4, 4, 4};
    const size_t width = sizes[field->kind];
    const bool number = field->kind <= MESSAGE_FIELD_U64;
    const uint64_t good = number_at(data + at, width);
    int checks = 0;
    if (width == 0)
        return 0;
    if (field->max < kind_max(field->kind)) {
        patch(data + at, width, field->max + 1);
        expect_code(data, size, field, number || field->kind == MESSAGE_FIELD_LEASES ? FAULT_RANGE : FAULT_LIMIT);
        checks++;
    }
    if (!number) {
        patch(data + at, 4, field->max);
        expect_code(data, size, field, FAULT_FORMAT);
        checks++;
    }
    if (number && field->min > 0) {
        patch(data + at, width, field->min - 1);
        expect_code(data, size, field, FAULT_RANGE);
        checks++;
    }
    patch(data + at, width, good);
    return checks;
}

static void limits_hold_when_decoding(void **state)
{
    (void)state;
    int checks = 0;
    for (unsigned type = 0; type < RANDOM_MESSAGE_TYPES; type++) {
        if (!message_senders(type))
            continue;
        size_t size, count, at = MESSAGE_HEADER_SIZE;
        uint8_t *data = frame_of(type, 2, &size);
        const message_field_t *fields = message_fields(type, &count);
        for (size_t i = 0; i < count; i++) {
            checks += check_field_limits(data, size, at, &fields[i]);
            at += field_size(data + at, fields[i].kind);
        }
        assert_int_equal(at, size);
        free(data);
    }
    assert_true(checks > 60); /* the loop did run */
}

static void limits_hold_when_encoding(void **state)
{
    (void)state;
    for (unsigned type = 0; type < RANDOM_MESSAGE_TYPES; type++) {
        size_t count, size;
        const message_field_t *fields = message_fields(type, &count);
        for (size_t i = 0; i < count; i++) {
            if (fields[i].kind > MESSAGE_FIELD_U64 || fields[i].max == kind_max(fields[i].kind))
                continue;
            random_message_fill(&sample, type, 3);
            uint64_t beyond = fields[i].max + 1;
            memcpy((char *)&sample.message + fields[i].offset, &beyond, (size_t)1 << fields[i].kind);
            uint8_t *data;
            fault_t fault = {0};
            assert_int_equal(message_encode(&sample.message, &data, &size, &fault), FAULT_RANGE);
            assert_non_null(strstr(fault.text, fields[i].name));
        }
    }
    message_t message = {.type = MESSAGE_SUBMIT};
    char *text = malloc(MESSAGE_MAX_TEXT + 2);
    memset(text, 'x', MESSAGE_MAX_TEXT + 1);
    text[MESSAGE_MAX_TEXT + 1] = '\0';
    message.submit.text = text;
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    assert_int_equal(message_encode(&message, &data, &size, &fault), FAULT_LIMIT);
    text[MESSAGE_MAX_TEXT] = '\0';
    assert_int_equal(message_encode(&message, &data, &size, &fault), FAULT_NONE);
    assert_int_equal(decode_copy(data, size, &fault), FAULT_NONE);
    free(data);
    free(text);
    message = (message_t){.type = MESSAGE_RESULT};
    message.result.lease.job = 1;
    message.result.bytes = (message_bytes_t){(const uint8_t *)"", (size_t)MESSAGE_MAX_RESULT + 1};
    assert_int_equal(message_encode(&message, &data, &size, &fault), FAULT_LIMIT);
    message = (message_t){.type = 99};
    assert_int_equal(message_encode(&message, &data, &size, &fault), FAULT_USAGE);
}

/* ---- the header ---- */

static void wrong_signature_and_type_are_refused(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = frame_of(MESSAGE_RESULT, 0, &size);
    fault_t fault = {0};
    for (int i = 0; i < 4; i++) {
        data[i] ^= 0x20;
        assert_int_equal(decode_copy(data, size, &fault), FAULT_PROTOCOL);
        data[i] ^= 0x20;
    }
    int refused = 0;
    for (unsigned type = 0; type < 1u << 16; type++) {
        if (message_senders(type))
            continue;
        patch(data + 6, 2, type);
        refused += decode_copy(data, size, &fault) == FAULT_PROTOCOL;
    }
    assert_int_equal(refused, (1 << 16) - TYPES);
    free(data);
}

static void another_version_is_named(void **state)
{
    (void)state;
    message_t hello = {.type = MESSAGE_HELLO}, out;
    hello.hello = (message_hello_t){.garland_version = "7.6.5", .role = MESSAGE_ROLE_WORKER};
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    assert_int_equal(message_encode(&hello, &data, &size, &fault), FAULT_NONE);
    patch(data + 4, 2, 999);
    const size_t prefix = MESSAGE_HEADER_SIZE + 4 + 5 + 1; /* what is the same in every version */
    for (size_t cut = prefix; cut <= size; cut++) {
        assert_int_equal(message_decode(&out, data, cut, &fault), FAULT_VERSION);
        assert_int_equal(out.type, MESSAGE_HELLO);
        assert_string_equal(out.hello.garland_version, "7.6.5");
        assert_non_null(strstr(fault.text, "999"));
        assert_non_null(strstr(fault.text, "7.6.5"));
        assert_non_null(strstr(fault.text, GARLAND_VERSION));
        assert_non_null(strstr(fault.text, "protocol version 1"));
    }
    patch(data + 6, 2, MESSAGE_RESULT);
    assert_int_equal(message_decode(&out, data, size, &fault), FAULT_VERSION);
    free(data);
}

static void a_refusal_of_another_version_is_readable(void **state)
{
    (void)state;
    message_t refused = {.type = MESSAGE_REFUSED}, out;
    refused.refused.text = "too old";
    refused.refused.code = FAULT_USAGE;
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    assert_int_equal(message_encode(&refused, &data, &size, &fault), FAULT_NONE);
    patch(data + 4, 2, 2);
    for (size_t cut = MESSAGE_HEADER_SIZE + 4 + 7 + 1; cut <= size; cut++) {
        assert_int_equal(message_decode(&out, data, cut, &fault), FAULT_NONE);
        assert_string_equal(out.refused.text, "too old");
        assert_int_equal(out.refused.code, FAULT_VERSION);
    }
    free(data);
}

static void a_chunk_must_lie_inside_its_whole(void **state)
{
    (void)state;
    message_t put = {.type = MESSAGE_BUNDLE_PUT};
    put.chunk.total = 10;
    put.chunk.offset = 7;
    put.chunk.bytes = (message_bytes_t){(const uint8_t *)"abcd", 3};
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    assert_int_equal(message_encode(&put, &data, &size, &fault), FAULT_NONE);
    patch(data + MESSAGE_HEADER_SIZE + DIGEST_SIZE + 8, 8, 8);
    assert_int_equal(decode_copy(data, size, &fault), FAULT_RANGE);
    assert_non_null(strstr(fault.text, "total of 10"));
    free(data);
    put.chunk.bytes.size = 4;
    assert_int_equal(message_encode(&put, &data, &size, &fault), FAULT_RANGE);
}

static void texts_that_are_none_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"\x01", "\x7f", "\xff", "\xc0\x80", "\xed\xa0\x80", "\xc2\x9b", "\x1b[2J"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        message_t message = {.type = MESSAGE_JOB_DATA};
        message.job_data.job = 1;
        message.job_data.text = bad[i];
        uint8_t *data;
        size_t size;
        fault_t fault = {0};
        assert_int_equal(message_encode(&message, &data, &size, &fault), FAULT_FORMAT);
        char filler[8];
        snprintf(filler, sizeof filler, "%.*s", (int)strlen(bad[i]), "xxxxxxx");
        message.job_data.text = filler;
        assert_int_equal(message_encode(&message, &data, &size, &fault), FAULT_NONE);
        assert_int_equal(decode_copy(data, size, &fault), FAULT_NONE);
        memcpy(data + size - 1 - strlen(bad[i]), bad[i], strlen(bad[i]));
        assert_int_equal(decode_copy(data, size, &fault), FAULT_FORMAT);
        free(data);
    }
}

static void unknown_fault_codes_become_protocol(void **state)
{
    (void)state;
    assert_int_equal(message_fault_code(FAULT_TIMEOUT), FAULT_TIMEOUT);
    assert_int_equal(message_fault_code(FAULT_COUNT), FAULT_PROTOCOL);
    assert_int_equal(message_fault_code(65535), FAULT_PROTOCOL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_message_round_trips),
        cmocka_unit_test(every_truncation_is_refused),
        cmocka_unit_test(trailing_octets_are_refused),
        cmocka_unit_test(limits_hold_when_decoding),
        cmocka_unit_test(limits_hold_when_encoding),
        cmocka_unit_test(wrong_signature_and_type_are_refused),
        cmocka_unit_test(another_version_is_named),
        cmocka_unit_test(a_refusal_of_another_version_is_readable),
        cmocka_unit_test(a_chunk_must_lie_inside_its_whole),
        cmocka_unit_test(texts_that_are_none_are_refused),
        cmocka_unit_test(unknown_fault_codes_become_protocol),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
