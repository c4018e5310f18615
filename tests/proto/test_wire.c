/* Fields as bytes: the layout by hand, bounds, sticky faults, and which octets are text. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "base/wire.h"

static void layout_is_little_endian(void **state)
{
    (void)state;
    uint8_t buffer[64];
    wire_writer_t out;
    wire_writer_init(&out, buffer, sizeof buffer, "test", NULL);
    wire_put_u8(&out, 0x12);
    wire_put_u16(&out, 0x3456);
    wire_put_u32(&out, 0x789abcde);
    wire_put_u64(&out, UINT64_C(0x0123456789abcdef));
    wire_put_f64(&out, -2.385); /* 0xc003147ae147ae14: sign, exponent 1024, 0.1925 * 2^52 */
    wire_put_bytes(&out, "bytes", "\xff\x00", 2, 2);
    wire_put_string(&out, "string", "a\xc3\xa4", 3);
    static const uint8_t expected[] = {0x12, 0x56, 0x34, 0xde, 0xbc, 0x9a, 0x78, 0xef, 0xcd, 0xab, 0x89, 0x67, 0x45,
                                       0x23, 0x01, 0x14, 0xae, 0x47, 0xe1, 0x7a, 0x14, 0x03, 0xc0, 2,    0,    0,
                                       0,    0xff, 0,    3,    0,    0,    0,    'a',  0xc3, 0xa4, 0};
    assert_int_equal(out.code, FAULT_NONE);
    assert_int_equal(out.at, sizeof expected);
    assert_memory_equal(buffer, expected, sizeof expected);

    wire_reader_t in;
    fault_t fault = {0};
    size_t size;
    wire_reader_init(&in, buffer, out.at, "test", &fault);
    assert_int_equal(wire_get_u8(&in, "a"), 0x12);
    assert_int_equal(wire_get_u16(&in, "b"), 0x3456);
    assert_int_equal(wire_get_u32(&in, "c"), 0x789abcde);
    assert_true(wire_get_u64(&in, "d") == UINT64_C(0x0123456789abcdef));
    const double f64 = wire_get_f64(&in, "e"), expected_f64 = -2.385;
    assert_memory_equal(&f64, &expected_f64, sizeof f64); /* every bit */
    assert_memory_equal(wire_get_bytes(&in, "f", 2, &size), "\xff\x00", 2);
    assert_int_equal(size, 2);
    assert_string_equal(wire_get_string(&in, "g", 3), "a\xc3\xa4");
    assert_int_equal(wire_reader_end(&in), FAULT_NONE);
}

static void doubles_keep_every_bit(void **state)
{
    (void)state;
    const uint64_t patterns[] = {0,
                                 UINT64_C(1) << 63,
                                 1,
                                 UINT64_C(0x7ff0000000000000),
                                 UINT64_C(0xfff8000000000123),
                                 UINT64_C(0x7ff0000000000001)};
    for (size_t i = 0; i < sizeof patterns / sizeof *patterns; i++) {
        uint8_t buffer[8];
        double value;
        wire_writer_t out;
        wire_reader_t in;
        memcpy(&value, &patterns[i], sizeof value);
        wire_writer_init(&out, buffer, sizeof buffer, "test", NULL);
        wire_put_f64(&out, value);
        wire_reader_init(&in, buffer, sizeof buffer, "test", NULL);
        value = wire_get_f64(&in, "value");
        assert_memory_equal(&value, &patterns[i], sizeof value);
    }
}

static void reader_stops_at_its_end(void **state)
{
    (void)state;
    for (size_t size = 0; size < 8; size++) {
        uint8_t *data = malloc(size + 1);
        memset(data, 0xff, size + 1);
        wire_reader_t in;
        fault_t fault = {0};
        wire_reader_init(&in, data, size, "record", &fault);
        assert_true(wire_get_u64(&in, "first") == 0);
        assert_int_equal(in.code, FAULT_FORMAT);
        assert_non_null(strstr(fault.text, "record.first"));
        assert_int_equal(in.at, 0);
        free(data);
    }
}

static void reader_fault_is_sticky(void **state)
{
    (void)state;
    const uint8_t data[16] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    wire_reader_t in;
    fault_t fault = {0};
    wire_reader_init(&in, data, sizeof data, "record", &fault);
    assert_int_equal(wire_get_u16(&in, "first"), 0x0201);
    assert_null(wire_get_raw(&in, "second", SIZE_MAX)); /* would wrap in a careless sum */
    assert_int_equal(wire_get_u8(&in, "third"), 0);
    assert_string_equal(wire_get_string(&in, "fourth", 100), "");
    digest_t digest;
    wire_get_digest(&in, "fifth", &digest);
    for (int i = 0; i < DIGEST_SIZE; i++)
        assert_int_equal(digest.bytes[i], 0);
    assert_int_equal(wire_reader_fail(&in, FAULT_RANGE, "sixth", "late"), FAULT_FORMAT);
    assert_int_equal(wire_reader_end(&in), FAULT_FORMAT);
    assert_non_null(strstr(fault.text, "record.second"));
}

static void octets_left_are_a_fault(void **state)
{
    (void)state;
    wire_reader_t in;
    fault_t fault = {0};
    wire_reader_init(&in, "abc", 3, "record", &fault);
    wire_get_u16(&in, "first");
    assert_int_equal(wire_reader_end(&in), FAULT_FORMAT);
    assert_non_null(strstr(fault.text, "1 octets after the last field"));
}

static void lengths_are_held_to_their_limits(void **state)
{
    (void)state;
    const uint8_t data[] = {5, 0, 0, 0, 'a', 'b', 'c', 'd', 'e', 0};
    const uint8_t huge[] = {0xff, 0xff, 0xff, 0xff, 'a', 0};
    wire_reader_t in;
    size_t size;
    wire_reader_init(&in, data, sizeof data, "record", NULL);
    assert_non_null(wire_get_bytes(&in, "bytes", 5, &size));
    wire_reader_init(&in, data, sizeof data, "record", NULL);
    assert_null(wire_get_bytes(&in, "bytes", 4, &size));
    assert_int_equal(in.code, FAULT_LIMIT);
    assert_int_equal(size, 0);
    wire_reader_init(&in, huge, sizeof huge, "record", NULL);
    assert_string_equal(wire_get_string(&in, "text", SIZE_MAX), "");
    assert_int_equal(in.code, FAULT_FORMAT);
}

static void string_needs_its_zero(void **state)
{
    (void)state;
    const uint8_t bad[] = {1, 0, 0, 0, 'a', 'b'};
    const uint8_t inside[] = {2, 0, 0, 0, 'a', 0, 0};
    wire_reader_t in;
    wire_reader_init(&in, bad, sizeof bad, "record", NULL);
    assert_string_equal(wire_get_string(&in, "text", 10), "");
    assert_int_equal(in.code, FAULT_FORMAT);
    wire_reader_init(&in, inside, sizeof inside, "record", NULL);
    assert_string_equal(wire_get_string(&in, "text", 10), "");
    assert_int_equal(in.code, FAULT_FORMAT);
}

static void writer_stays_in_its_buffer(void **state)
{
    (void)state;
    uint8_t buffer[8] = {[7] = 0x5a};
    wire_writer_t out;
    fault_t fault = {0};
    wire_writer_init(&out, buffer, 7, "record", &fault);
    wire_put_u32(&out, 1);
    wire_put_u32(&out, 2);
    wire_put_u8(&out, 3);
    assert_int_equal(out.code, FAULT_LIMIT);
    assert_int_equal(out.at, 4);
    assert_int_equal(buffer[7], 0x5a);
    assert_int_equal(buffer[4], 0);
}

/* The same bytes as in a buffer of their size; a sentence's length is put in its place after its buffer has moved.
 */
static void a_growing_writer_takes_all_that_is_put(void **state)
{
    (void)state;
    uint8_t buffer[1 << 12];
    wire_writer_t out, grown;
    wire_writer_init(&out, buffer, sizeof buffer, "record", NULL);
    wire_writer_init_growing(&grown, "record", NULL);
    char text[300];
    for (unsigned i = 0; i < 10; i++) {
        memset(text, 'a' + (int)i, sizeof text);
        text[31 * i] = 0;
        wire_put_sentence(&out, text, sizeof text);
        wire_put_sentence(&grown, text, sizeof text);
        wire_put_f64(&out, i);
        wire_put_f64(&grown, i);
    }
    assert_int_equal(out.code, FAULT_NONE);
    assert_int_equal(grown.code, FAULT_NONE);
    assert_true(grown.at == out.at && grown.size < 2 * grown.at);
    assert_memory_equal(grown.data, buffer, out.at);
    wire_writer_clear(&grown);
    assert_null(grown.data);
}

static void counting_gives_the_size_that_writing_needs(void **state)
{
    (void)state;
    uint8_t buffer[200];
    size_t counted = 0;
    for (int pass = 0; pass < 2; pass++) {
        wire_writer_t out;
        wire_writer_init(&out, pass ? buffer : NULL, counted, "record", NULL);
        wire_put_sentence(&out, "a\x01\xff z", 4);
        wire_put_string(&out, "s", NULL, 0);
        wire_put_raw(&out, "xyz", 3);
        assert_int_equal(out.code, FAULT_NONE);
        if (pass)
            assert_int_equal(out.at, counted);
        counted = out.at;
    }
    assert_memory_equal(buffer, "\4\0\0\0a?? \0\0\0\0\0\0xyz", counted);
}

static void strings_are_strict_and_sentences_are_mended(void **state)
{
    (void)state;
    uint8_t buffer[100];
    wire_writer_t out;
    wire_writer_init(&out, buffer, sizeof buffer, "record", NULL);
    wire_put_string(&out, "text", "a\x1b[2J", 50);
    assert_int_equal(out.code, FAULT_FORMAT);
    wire_writer_init(&out, buffer, sizeof buffer, "record", NULL);
    wire_put_string(&out, "text", "abcd", 3);
    assert_int_equal(out.code, FAULT_LIMIT);
    /* cut before a character that does not fit whole */
    wire_reader_t in;
    wire_writer_init(&out, buffer, sizeof buffer, "record", NULL);
    wire_put_sentence(&out, "\x1b[2Jab\xe2\x82\xac", 8);
    wire_reader_init(&in, buffer, out.at, "record", NULL);
    assert_string_equal(wire_get_string(&in, "text", 8), "?[2Jab");
    assert_int_equal(wire_reader_end(&in), FAULT_NONE);
}

/* Counts the octet sequences of one length that are accepted whole, over all of them; the numbers follow from the
 * definition: U+0020..U+007E, tab, line feed; U+00A0..U+07FF; U+0800..U+FFFF without 2048 surrogates;
 * U+10000..U+10FFFF. */
static void text_is_utf8_without_controls(void **state)
{
    (void)state;
    uint64_t accepted[5] = {0};
    for (uint32_t a = 0; a < 256; a++) {
        uint8_t text[4] = {(uint8_t)a};
        accepted[1] += wire_text_character(text, 1) == 1;
        for (uint32_t b = 0; a >= 0x80 && b < 256; b++) {
            text[1] = (uint8_t)b;
            accepted[2] += wire_text_character(text, 2) == 2;
            for (uint32_t c = 0; a >= 0xe0 && c < 256; c++) {
                text[2] = (uint8_t)c;
                accepted[3] += wire_text_character(text, 3) == 3;
                for (uint32_t d = 0; a >= 0xf0 && a < 0xf6 && d < 256; d++) {
                    text[3] = (uint8_t)d;
                    accepted[4] += wire_text_character(text, 4) == 4;
                }
            }
        }
    }
    assert_int_equal(accepted[1], 97);
    assert_int_equal(accepted[2], 0x800 - 0xa0);
    assert_int_equal(accepted[3], 0x10000 - 0x800 - 0x800);
    assert_int_equal(accepted[4], 0x100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layout_is_little_endian),
        cmocka_unit_test(doubles_keep_every_bit),
        cmocka_unit_test(reader_stops_at_its_end),
        cmocka_unit_test(reader_fault_is_sticky),
        cmocka_unit_test(octets_left_are_a_fault),
        cmocka_unit_test(lengths_are_held_to_their_limits),
        cmocka_unit_test(string_needs_its_zero),
        cmocka_unit_test(writer_stays_in_its_buffer),
        cmocka_unit_test(a_growing_writer_takes_all_that_is_put),
        cmocka_unit_test(counting_gives_the_size_that_writing_needs),
        cmocka_unit_test(strings_are_strict_and_sentences_are_mended),
        cmocka_unit_test(text_is_utf8_without_controls),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
