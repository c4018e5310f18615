#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/random.h"

static json_t *parse(const char *text)
{
    json_t *json = NULL;
    fault_t fault = {0};
    if (json_parse(&json, text, strlen(text), &fault) != FAULT_NONE)
        fail_msg("%s: %s", text, fault.text);
    return json;
}

static void assert_refused(const char *text, size_t length, fault_code_t code, const char *part)
{
    json_t *json = NULL;
    fault_t fault = {0};
    const fault_code_t got = json_parse(&json, text, length, &fault);
    if (got != code || !strstr(fault.text, part) || json)
        fail_msg("%.80s: got %d \"%s\", expected %d with \"%s\"", text, (int)got, fault.text, (int)code, part);
}

/* ---- parsing ---- */

static void what_is_not_json_is_refused_with_its_place(void **state)
{
    (void)state;
    static const struct {
        const char *text, *part;
    } cases[] = {
        {"", "line 1, column 1: expected a value; found the end"},
        {"{\"a\": 1,\n \"b\" 2}", "line 2, column 6: expected ':' after a name; found '2'"},
        {"\"\xc3\xa9\xc3\xa9\" x", "line 1, column 6: expected the end of the text; found 'x'"},
        {"{} {}", "expected the end"},
        {"[1,]", "expected a value; found ']'"},
        {"[1 2]", "expected ',' or ']'"},
        {"{\"a\":1,}", "expected a name in quotes"},
        {"{a:1}", "expected a name in quotes"},
        {"{\"a\":1", "expected ',' or '}'"},
        {"{\"a\" 1}", "expected ':'"},
        {"[", "found the end"},
        {"tru", "expected a value"},
        {"truE", "expected a value"},
        {"NaN", "expected a value"},
        {"Infinity", "expected a value"},
        {"+1", "expected a value"},
        {".5", "expected a value"},
        {"-", "expected a digit"},
        {"-a", "expected a digit"},
        {"01", "must not begin with 0"},
        {"-00", "must not begin with 0"},
        {"1.", "expected a digit after the point"},
        {"1.e5", "expected a digit after the point"},
        {"1e", "expected a digit in the exponent"},
        {"1e+", "expected a digit in the exponent"},
        {"0x10", "expected the end"},
        {"1e400", "too large for a double"},
        {"[-1e309]", "column 2: a number is too large"},
        {"\"abc", "a string is not closed"},
        {"\"abc\\", "after a backslash"},
        {"\"\\x41\"", "after a backslash"},
        {"\"a\nb\"", "control character"},
        {"\"\\u12g4\"", "four hexadecimal digits"},
        {"\"\\u0000\"", "\\u0000 is not allowed"},
        {"{\"a\\u0000b\": 1}", "\\u0000 is not allowed"},
        {"\"\\ud800\"", "low surrogate after a high one"},
        {"\"\\ud800\\u0041\"", "low surrogate after a high one"},
        {"\"\\udc00\"", "low surrogate without"},
        {"\xef\xbb\xbf{}", "expected a value; found byte 0xef"},
        {"// x\n1", "expected a value"},
        {"'a'", "expected a value"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_refused(cases[i].text, strlen(cases[i].text), FAULT_SYNTAX, cases[i].part);
    assert_refused("1\0", 2, FAULT_SYNTAX, "found byte 0x00");
    assert_refused("\"a\0b\"", 5, FAULT_SYNTAX, "control character");
}

static void what_is_not_utf8_is_refused(void **state)
{
    (void)state;
    static const char *const wrong[] = {"\x80",
                                        "\xc0\xaf",
                                        "\xc1\xbf",
                                        "\xc3",
                                        "\xc3(",
                                        "\xe0\x9f\xbf",
                                        "\xed\xa0\x80",
                                        "\xe2\x82",
                                        "\xf0\x8f\xbf\xbf",
                                        "\xf4\x90\x80\x80",
                                        "\xf5\x80\x80\x80",
                                        "\xff"};
    static const char *const right[] = {"\xc2\x80",     "\xdf\xbf",     "\xe0\xa0\x80",     "\xed\x9f\xbf",
                                        "\xee\x80\x80", "\xef\xbf\xbf", "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf"};
    char text[16];
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        snprintf(text, sizeof text, "\"%s\"", wrong[i]);
        assert_refused(text, strlen(text), FAULT_SYNTAX, "expected UTF-8");
    }
    for (size_t i = 0; i < sizeof right / sizeof *right; i++) {
        snprintf(text, sizeof text, "\"%s\"", right[i]);
        json_t *json = parse(text);
        assert_string_equal(json_string(json), right[i]);
        json_destroy(&json);
    }
}

static void names_must_differ_and_not_only_in_case(void **state)
{
    (void)state;
    static const struct {
        const char *text, *part;
    } cases[] = {
        {"{\"a\":1,\"b\":2,\"a\":3}", "a: this name appears twice"},
        {"{\"film\":{\"width\":1,\"Width\":2}}", "differs from it only in case"},
        {"{\"list\":[0,{\"x\":1,\"x\":2}]}", "list[1].x: this name appears twice"},
        {"{\"a\":1,\"\\u0061\":2}", "a: this name appears twice"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_refused(cases[i].text, strlen(cases[i].text), FAULT_SYNTAX, cases[i].part);
    json_t *json = parse("{\"a\":{\"x\":1},\"b\":{\"x\":2}}"); /* the same name in two objects */
    json_destroy(&json);
}

static void nesting_ends_at_its_limit(void **state)
{
    (void)state;
    char text[200];
    for (int depth = JSON_MAX_DEPTH; depth <= JSON_MAX_DEPTH + 1; depth++) {
        memset(text, '[', (size_t)depth);
        memset(text + depth, ']', (size_t)depth);
        if (depth > JSON_MAX_DEPTH) {
            assert_refused(text, 2 * (size_t)depth, FAULT_LIMIT, "column 33: nested more than 32 deep");
            continue;
        }
        json_t *json = NULL;
        assert_int_equal(json_parse(&json, text, 2 * (size_t)depth, NULL), FAULT_NONE);
        json_destroy(&json);
    }
}

static void values_and_digits_are_limited(void **state)
{
    (void)state;
    const size_t count = JSON_MAX_VALUES; /* with the array itself one too many */
    char *text = malloc(2 * count + 2), number[80];
    for (size_t i = 0; i < count; i++) {
        text[2 * i] = i ? ',' : '[';
        text[2 * i + 1] = '0';
    }
    text[2 * count] = ']';
    assert_refused(text, 2 * count + 1, FAULT_LIMIT, "more than 2^20 values");
    text[2 * count - 2] = ']';
    json_t *json = NULL;
    assert_int_equal(json_parse(&json, text, 2 * count - 1, NULL), FAULT_NONE);
    assert_int_equal(json_size(json), count - 1);
    json_destroy(&json);
    free(text);
    memset(number, '1', sizeof number);
    number[JSON_MAX_NUMBER] = '\0';
    json = parse(number);
    assert_true(json_number(json) == strtod(number, NULL));
    json_destroy(&json);
    number[JSON_MAX_NUMBER] = '1';
    assert_refused(number, JSON_MAX_NUMBER + 1, FAULT_LIMIT, "more than 60 characters");
    assert_refused("", (size_t)JSON_MAX_BYTES + 1, FAULT_LIMIT, "more than the 67108864 allowed");
}

static void escapes_are_decoded(void **state)
{
    (void)state;
    json_t *json = parse(" \"\\u00e9\\ud83d\\ude00\\n\\t\\\"\\\\\\/\\b\\f\\r\" ");
    assert_string_equal(json_string(json), "\xc3\xa9\xf0\x9f\x98\x80\n\t\"\\/\b\f\r");
    json_destroy(&json);
}

static void members_are_walked_in_order(void **state)
{
    (void)state;
    static const char *const names[] = {"z", "a", "m"};
    json_t *json = parse("{\"z\":[5,6],\"a\":2,\"m\":3}");
    size_t i = 0;
    for (const json_t *m = json_first(json); m; m = json_next(m), i++) {
        assert_string_equal(json_name(m), names[i]);
        assert_ptr_equal(m, json_at(json, i));
    }
    assert_int_equal(i, 3);
    assert_int_equal(json_size(json), 3);
    assert_null(json_at(json, 3));
    assert_null(json_get(json, "A"));
    assert_null(json_name(json_at(json_get(json, "z"), 1)));
    assert_true(json_number(json_at(json_get(json, "z"), 1)) == 6);
    assert_null(json_first(json_get(json, "a"))); /* not a container */
    json_destroy(&json);
    assert_null(json);
    json_destroy(&json);
}

/* ---- getters ---- */

static const char sample[] = "{\"width\": 640, \"gain\": 2.385, \"name\": \"hall\", \"on\": true, \"none\": null,"
                             " \"list\": [1], \"inner\": {\"x\": 1}, \"seed\": \"18446744073709551615\"}";

static void fields_are_read(void **state)
{
    (void)state;
    json_t *json = parse(sample);
    fault_t fault = {0};
    int64_t width = 0;
    double gain = 0;
    bool on = false;
    const char *name = NULL;
    const json_t *inner = NULL;
    uint64_t seed = 0, small = 0;
    assert_int_equal(json_read_int_or(json, "", "width", 1, 640, &width, &fault), FAULT_NONE);
    assert_int_equal(width, 640);
    assert_int_equal(json_read_double_or(json, "", "gain", 2.385, 2.385, &gain, &fault), FAULT_NONE);
    assert_true(gain == 2.385);
    assert_int_equal(json_read_bool_or(json, "", "on", &on, &fault), FAULT_NONE);
    assert_true(on);
    assert_int_equal(json_read_string_or(json, "", "name", &name, &fault), FAULT_NONE);
    assert_string_equal(name, "hall");
    assert_int_equal(json_read_object(json, "", "inner", &inner, &fault), FAULT_NONE);
    assert_ptr_equal(inner, json_get(json, "inner"));
    assert_int_equal(json_read_u64_or(json, "", "seed", &seed, &fault), FAULT_NONE);
    assert_true(seed == UINT64_MAX);
    assert_int_equal(json_read_u64_or(json, "", "width", &small, &fault), FAULT_NONE);
    assert_int_equal(small, 640);
    json_destroy(&json);
}

static void absent_and_null_fields_change_nothing(void **state)
{
    (void)state;
    json_t *json = parse(sample);
    static const char *const names[] = {"absent", "none"};
    for (int i = 0; i < 3; i++) {
        const json_t *object = i < 2 ? json : NULL; /* an absent object has no fields */
        const char *field = i < 2 ? names[i] : "width";
        int64_t whole = 11;
        double number = 2.5;
        bool flag = true;
        uint64_t seed = 7;
        const char *text = "kept";
        const json_t *inner = json;
        assert_int_equal(json_read_int_or(object, "", field, 0, 1, &whole, NULL), FAULT_NONE);
        assert_int_equal(json_read_double_or(object, "", field, 0, 1, &number, NULL), FAULT_NONE);
        assert_int_equal(json_read_bool_or(object, "", field, &flag, NULL), FAULT_NONE);
        assert_int_equal(json_read_u64_or(object, "", field, &seed, NULL), FAULT_NONE);
        assert_int_equal(json_read_string_or(object, "", field, &text, NULL), FAULT_NONE);
        assert_int_equal(json_read_object(object, "", field, &inner, NULL), FAULT_NONE);
        assert_int_equal(whole, 11);
        assert_true(number == 2.5 && flag && seed == 7);
        assert_string_equal(text, "kept");
        assert_null(inner);
    }
    json_destroy(&json);
}

static void wrong_types_name_field_found_and_expected(void **state)
{
    (void)state;
    json_t *json = parse(sample);
    fault_t fault = {0};
    int64_t whole = 0;
    double number = 0;
    bool flag = false;
    uint64_t seed = 0;
    const char *text = NULL;
    const json_t *inner = NULL;
    assert_int_equal(json_read_int_or(json, "film", "name", 1, 9, &whole, &fault), FAULT_TYPE);
    assert_string_equal(fault.text, "film.name: expected a whole number from 1 to 9, found the text \"hall\"");
    assert_int_equal(json_read_double_or(json, "", "list", 0, 1, &number, &fault), FAULT_TYPE);
    assert_string_equal(fault.text, "list: expected a number from 0 to 1, found an array");
    assert_int_equal(json_read_bool_or(json, "a.b", "width", &flag, &fault), FAULT_TYPE);
    assert_string_equal(fault.text, "a.b.width: expected true or false, found 640");
    assert_int_equal(json_read_string_or(json, "", "inner", &text, &fault), FAULT_TYPE);
    assert_string_equal(fault.text, "inner: expected a text, found an object");
    assert_int_equal(json_read_object(json, "", "on", &inner, &fault), FAULT_TYPE);
    assert_string_equal(fault.text, "on: expected an object, found true");
    assert_int_equal(json_read_u64_or(json, "", "on", &seed, &fault), FAULT_TYPE);
    assert_int_equal(json_read_int_or(json_get(json, "list"), "list", "x", 0, 1, &whole, &fault), FAULT_TYPE);
    assert_string_equal(fault.text, "list: expected an object, found an array");
    json_destroy(&json);
}

static void ranges_are_inclusive_and_whole_numbers_whole(void **state)
{
    (void)state;
    json_t *json = parse("{\"a\": 10, \"b\": 10.5, \"c\": -1, \"d\": 9007199254740993, \"e\": 1e300}");
    fault_t fault = {0};
    int64_t whole = 5;
    double number = 5;
    assert_int_equal(json_read_int_or(json, "", "a", 0, 9, &whole, &fault), FAULT_RANGE);
    assert_string_equal(fault.text, "a: expected a whole number from 0 to 9, found 10");
    assert_int_equal(json_read_int_or(json, "", "a", 11, 20, &whole, &fault), FAULT_RANGE);
    assert_int_equal(json_read_int_or(json, "", "b", 0, 99, &whole, &fault), FAULT_RANGE);
    assert_int_equal(json_read_int_or(json, "", "e", INT64_MIN, INT64_MAX, &whole, &fault), FAULT_RANGE);
    assert_int_equal(json_read_double_or(json, "", "c", 0, 1, &number, &fault), FAULT_RANGE);
    assert_true(whole == 5 && number == 5);
    assert_int_equal(json_read_int_or(json, "", "a", 10, 10, &whole, &fault), FAULT_NONE);
    assert_int_equal(json_read_int_or(json, "", "c", -1, 0, &whole, &fault), FAULT_NONE);
    assert_int_equal(whole, -1);
    json_destroy(&json);
}

static void seeds_keep_all_their_bits(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        bool good;
        uint64_t value;
    } cases[] = {
        {"\"0\"", true, 0},
        {"\"00017\"", true, 17},
        {"\"18446744073709551615\"", true, UINT64_MAX},
        {"\"18446744073709551616\"", false, 0},
        {"\"99999999999999999999999\"", false, 0},
        {"\"\"", false, 0},
        {"\"-1\"", false, 0},
        {"\"+1\"", false, 0},
        {"\" 1\"", false, 0},
        {"\"0x1\"", false, 0},
        {"\"1.0\"", false, 0},
        {"9007199254740991", true, UINT64_C(9007199254740991)},
        {"9007199254740992", false, 0},
        {"-1", false, 0},
        {"1.5", false, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[64];
        uint64_t value = 0;
        snprintf(text, sizeof text, "{\"seed\": %s}", cases[i].text);
        json_t *json = parse(text);
        const fault_code_t code = json_read_u64_or(json, "", "seed", &value, NULL);
        if (code != (cases[i].good ? FAULT_NONE : FAULT_RANGE) || value != cases[i].value)
            fail_msg("%s: code %d, value %llu", cases[i].text, (int)code, (unsigned long long)value);
        json_destroy(&json);
    }
}

static void unknown_fields_are_found(void **state)
{
    (void)state;
    static const char *const names[] = {"width", "height", NULL};
    fault_t fault = {0};
    json_t *json = parse("{\"width\": 1, \"heigth\": 2}");
    assert_int_equal(json_expect_fields(json, "film", names, &fault), FAULT_UNKNOWN);
    assert_string_equal(fault.text, "film.heigth: unknown field; known here: width, height");
    json_destroy(&json);
    json = parse("{\"Width\": 1}");
    assert_int_equal(json_expect_fields(json, "", names, &fault), FAULT_UNKNOWN);
    json_destroy(&json);
    json = parse("{\"height\": 1}");
    assert_int_equal(json_expect_fields(json, "", names, &fault), FAULT_NONE);
    json_destroy(&json);
    assert_int_equal(json_expect_fields(NULL, "", names, &fault), FAULT_NONE);
    json = parse("[]");
    assert_int_equal(json_expect_fields(json, "", names, &fault), FAULT_TYPE);
    assert_string_equal(fault.text, "the document: expected an object, found an array");
    json_destroy(&json);
}

static void messages_hold_no_control_characters(void **state)
{
    (void)state;
    static const char *const names[] = {"width", NULL};
    fault_t fault = {0};
    int64_t whole = 0;
    json_t *json = parse("{\"\\u001b[2J\": 1, \"width\": \"\\u001b]0;x\\u0007\"}");
    assert_int_equal(json_expect_fields(json, "", names, &fault), FAULT_UNKNOWN);
    assert_null(strchr(fault.text, 0x1b));
    assert_int_equal(json_read_int_or(json, "", "width", 0, 1, &whole, &fault), FAULT_TYPE);
    assert_null(strchr(fault.text, 0x1b));
    assert_null(strchr(fault.text, 0x07));
    json_destroy(&json);
}

/* ---- writing ---- */

static void assert_prints(json_t *json, bool indented, const char *expected)
{
    char *text = json_print(json, indented);
    assert_string_equal(text, expected);
    free(text);
    json_destroy(&json);
}

static void values_print_as_expected(void **state)
{
    (void)state;
    json_t *json = json_new_object(), *list = json_new_array();
    json_append(list, json_new_number(1));
    json_append(list, json_new_number(0.1));
    json_append(list, json_new_number(NAN));
    json_append(list, json_new_number(-INFINITY));
    json_append(list, json_new_null());
    json_add(json, "list", list);
    json_add_string(json, "text", "a\"\\\n\x01\xc3\xa9");
    json_add_bool(json, "yes", true);
    json_add(json, "no", json_new_bool(false));
    json_add_u64(json, "seed", UINT64_MAX);
    json_add_number(json, "third", 1.0 / 3);
    assert_prints(json_copy(json), false,
                  "{\"list\":[1,0.1,null,null,null],\"text\":\"a\\\"\\\\\\n\\u0001\xc3\xa9\",\"yes\":true,"
                  "\"no\":false,\"seed\":\"18446744073709551615\",\"third\":0.3333333333333333}");
    assert_true(json_number(json_get(json, "third")) == 1.0 / 3); /* printing leaves the value alone */
    json_destroy(&json);
    assert_prints(json_new_string("bad \xff\xc3 bytes"), false, "\"bad ?? bytes\"");
    assert_prints(json_new_array(), true, "[]");
}

/* Of random bit patterns cJSON's own printing loses one in eight. */
static void every_double_reads_back_to_its_bits(void **state)
{
    (void)state;
    enum { COUNT = 20000 };
    static const double odd[] = {
        -0.0, 5e-324, -5e-324, 0x1p-1022, 1.7976931348623157e308, 1e23, 0x1.fffffffffffffp-1, 9007199254740993.0};
    double values[COUNT];
    json_t *list = json_new_array(), *back = NULL;
    for (size_t i = 0; i < COUNT; i++) {
        const uint64_t bits = random_u64(random_key(1, RANDOM_PURPOSE_TEST, 0, 0), i);
        memcpy(&values[i], &bits, sizeof bits);
        if (i < sizeof odd / sizeof *odd)
            values[i] = odd[i];
        if (!isfinite(values[i]))
            values[i] = random_double_of(bits);
        json_append(list, json_new_number(values[i]));
    }
    char *text = json_print(list, true);
    assert_int_equal(json_parse(&back, text, strlen(text), NULL), FAULT_NONE);
    size_t i = 0;
    for (const json_t *m = json_first(back); m; m = json_next(m), i++) {
        const double value = json_number(m);
        if (memcmp(&value, &values[i], sizeof value) != 0)
            fail_msg("%a became %a", values[i], value);
    }
    assert_int_equal(i, COUNT);
    free(text);
    json_destroy(&list);
    json_destroy(&back);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_not_json_is_refused_with_its_place),
        cmocka_unit_test(what_is_not_utf8_is_refused),
        cmocka_unit_test(names_must_differ_and_not_only_in_case),
        cmocka_unit_test(nesting_ends_at_its_limit),
        cmocka_unit_test(values_and_digits_are_limited),
        cmocka_unit_test(escapes_are_decoded),
        cmocka_unit_test(members_are_walked_in_order),
        cmocka_unit_test(fields_are_read),
        cmocka_unit_test(absent_and_null_fields_change_nothing),
        cmocka_unit_test(wrong_types_name_field_found_and_expected),
        cmocka_unit_test(ranges_are_inclusive_and_whole_numbers_whole),
        cmocka_unit_test(seeds_keep_all_their_bits),
        cmocka_unit_test(unknown_fields_are_found),
        cmocka_unit_test(messages_hold_no_control_characters),
        cmocka_unit_test(values_print_as_expected),
        cmocka_unit_test(every_double_reads_back_to_its_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
