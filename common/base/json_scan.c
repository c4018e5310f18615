#include "base/json_scan.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"

typedef struct scan {
    const char *text;
    size_t length, at;
    size_t values;
    fault_t *fault;
} scan_t;

size_t json_utf8_length(const char *text, size_t length)
{
    const uint8_t *b = (const uint8_t *)text;
    if (b[0] < 0x80)
        return 1;
    const size_t n = b[0] >= 0xc2 && b[0] < 0xe0   ? 2
                     : b[0] >= 0xe0 && b[0] < 0xf0 ? 3
                     : b[0] >= 0xf0 && b[0] < 0xf5 ? 4
                                                   : 0;
    if (n == 0 || n > length)
        return 0;
    for (size_t i = 1; i < n; i++)
        if ((b[i] & 0xc0) != 0x80)
            return 0;
    const bool overlong = (b[0] == 0xe0 && b[1] < 0xa0) || (b[0] == 0xf0 && b[1] < 0x90);
    const bool surrogate = b[0] == 0xed && b[1] >= 0xa0;
    const bool beyond = b[0] == 0xf4 && b[1] >= 0x90;
    return overlong || surrogate || beyond ? 0 : n;
}

/* The fault for the place that the scan has reached. */
static fault_code_t fail(scan_t *s, fault_code_t code, const char *expected)
{
    size_t line = 1, column = 1;
    for (size_t i = 0; i < s->at; i++) {
        const uint8_t c = (uint8_t)s->text[i];
        if (c == '\n') {
            line++;
            column = 1;
        } else if ((c & 0xc0) != 0x80) {
            column++;
        }
    }
    if (s->at >= s->length)
        return fault_set(s->fault, code, "line %zu, column %zu: %s; found the end of the text", line, column,
                         expected);
    const uint8_t found = (uint8_t)s->text[s->at];
    if (found > ' ' && found < 0x7f)
        return fault_set(s->fault, code, "line %zu, column %zu: %s; found '%c'", line, column, expected, found);
    return fault_set(s->fault, code, "line %zu, column %zu: %s; found byte 0x%02x", line, column, expected, found);
}

static int peek(const scan_t *s)
{
    return s->at < s->length ? (uint8_t)s->text[s->at] : -1;
}

static bool is_digit(int c)
{
    return c >= '0' && c <= '9';
}

static void skip_space(scan_t *s)
{
    for (int c = peek(s); c == ' ' || c == '\t' || c == '\n' || c == '\r'; c = peek(s))
        s->at++;
}

/* Four hexadecimal digits; -1 if they are not there. */
static int32_t scan_hex4(scan_t *s)
{
    int32_t value = 0;
    for (int i = 0; i < 4; i++, s->at++) {
        const int c = peek(s), lower = c | 0x20;
        if (is_digit(c))
            value = value << 4 | (c - '0');
        else if (c >= 0 && lower >= 'a' && lower <= 'f')
            value = value << 4 | (lower - 'a' + 10);
        else
            return -1;
    }
    return value;
}

/* After "\u". */
static fault_code_t scan_unicode(scan_t *s)
{
    const int32_t first = scan_hex4(s);
    if (first < 0)
        return fail(s, FAULT_SYNTAX, "expected four hexadecimal digits");
    if (first == 0)
        return fail(s, FAULT_SYNTAX, "the character \\u0000 is not allowed");
    if (first >= 0xdc00 && first < 0xe000)
        return fail(s, FAULT_SYNTAX, "a low surrogate without a high one");
    if (first < 0xd800 || first >= 0xdc00)
        return FAULT_NONE;
    if (s->length - s->at < 6 || s->text[s->at] != '\\' || s->text[s->at + 1] != 'u')
        return fail(s, FAULT_SYNTAX, "expected a low surrogate after a high one");
    s->at += 2;
    const int32_t second = scan_hex4(s);
    if (second < 0xdc00 || second >= 0xe000)
        return fail(s, FAULT_SYNTAX, "expected a low surrogate after a high one");
    return FAULT_NONE;
}

static fault_code_t scan_escape(scan_t *s)
{
    s->at++;
    const int c = peek(s);
    if (c < 0 || c == 0 || !strchr("\"\\/bfnrtu", c))
        return fail(s, FAULT_SYNTAX, "expected one of \"\\/bfnrtu after a backslash");
    s->at++;
    return c == 'u' ? scan_unicode(s) : FAULT_NONE;
}

static fault_code_t scan_string(scan_t *s)
{
    s->at++;
    for (;;) {
        const int c = peek(s);
        if (c < 0)
            return fail(s, FAULT_SYNTAX, "a string is not closed");
        if (c == '"') {
            s->at++;
            return FAULT_NONE;
        }
        if (c < ' ')
            return fail(s, FAULT_SYNTAX, "a control character in a string must be escaped");
        if (c == '\\') {
            TRY(scan_escape(s));
            continue;
        }
        const size_t n = json_utf8_length(s->text + s->at, s->length - s->at);
        if (n == 0)
            return fail(s, FAULT_SYNTAX, "expected UTF-8");
        s->at += n;
    }
}

static bool scan_digits(scan_t *s)
{
    const size_t start = s->at;
    while (is_digit(peek(s)))
        s->at++;
    return s->at > start;
}

static fault_code_t scan_number(scan_t *s)
{
    const size_t start = s->at;
    if (peek(s) == '-')
        s->at++;
    if (peek(s) == '0')
        s->at++;
    else if (!scan_digits(s))
        return fail(s, FAULT_SYNTAX, "expected a digit");
    if (is_digit(peek(s)))
        return fail(s, FAULT_SYNTAX, "a number must not begin with 0");
    if (peek(s) == '.') {
        s->at++;
        if (!scan_digits(s))
            return fail(s, FAULT_SYNTAX, "expected a digit after the point");
    }
    if (peek(s) == 'e' || peek(s) == 'E') {
        s->at++;
        if (peek(s) == '+' || peek(s) == '-')
            s->at++;
        if (!scan_digits(s))
            return fail(s, FAULT_SYNTAX, "expected a digit in the exponent");
    }
    char copy[JSON_MAX_NUMBER + 1];
    const size_t length = s->at - start;
    s->at = start; /* faults name the number's first character */
    if (length > JSON_MAX_NUMBER)
        return fail(s, FAULT_LIMIT, "a number has more than 60 characters");
    memcpy(copy, s->text + start, length);
    copy[length] = '\0';
    if (!isfinite(strtod(copy, NULL)))
        return fail(s, FAULT_SYNTAX, "a number is too large for a double");
    s->at = start + length;
    return FAULT_NONE;
}

static fault_code_t scan_word(scan_t *s, const char *word)
{
    for (; *word; word++, s->at++)
        if (peek(s) != *word)
            return fail(s, FAULT_SYNTAX, "expected a value");
    return FAULT_NONE;
}

static fault_code_t scan_value(scan_t *s, int depth);

static fault_code_t scan_member(scan_t *s, int depth)
{
    if (peek(s) != '"')
        return fail(s, FAULT_SYNTAX, "expected a name in quotes");
    TRY(scan_string(s));
    skip_space(s);
    if (peek(s) != ':')
        return fail(s, FAULT_SYNTAX, "expected ':' after a name");
    s->at++;
    return scan_value(s, depth);
}

/* An array or object from its opening bracket on. */
static fault_code_t scan_container(scan_t *s, int depth, bool object)
{
    const char close = object ? '}' : ']';
    if (depth >= JSON_MAX_DEPTH)
        return fail(s, FAULT_LIMIT, "nested more than 32 deep");
    s->at++;
    skip_space(s);
    if (peek(s) == close) {
        s->at++;
        return FAULT_NONE;
    }
    for (;;) {
        skip_space(s);
        TRY(object ? scan_member(s, depth + 1) : scan_value(s, depth + 1));
        if (peek(s) == close) {
            s->at++;
            return FAULT_NONE;
        }
        if (peek(s) != ',')
            return fail(s, FAULT_SYNTAX, object ? "expected ',' or '}'" : "expected ',' or ']'");
        s->at++;
    }
}

/* A value with the white space around it. */
static fault_code_t scan_value(scan_t *s, int depth)
{
    skip_space(s);
    if (++s->values > JSON_MAX_VALUES)
        return fail(s, FAULT_LIMIT, "more than 2^20 values");
    const int c = peek(s);
    fault_code_t code;
    if (c == '{' || c == '[')
        code = scan_container(s, depth, c == '{');
    else if (c == '"')
        code = scan_string(s);
    else if (c == '-' || is_digit(c))
        code = scan_number(s);
    else
        code = scan_word(s, c == 't' ? "true" : c == 'f' ? "false" : "null");
    if (code == FAULT_NONE)
        skip_space(s);
    return code;
}

fault_code_t json_scan(const char *text, size_t length, fault_t *fault)
{
    scan_t s = {.text = text, .length = length, .fault = fault};
    if (length > JSON_MAX_BYTES)
        return fault_set(fault, FAULT_LIMIT, "%zu bytes of JSON, more than the %d allowed", length, JSON_MAX_BYTES);
    TRY(scan_value(&s, 0));
    return s.at == s.length ? FAULT_NONE : fail(&s, FAULT_SYNTAX, "expected the end of the text");
}
