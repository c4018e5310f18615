/* PROTOCOL.md against message.h: types, senders, fields, bounds, limits, small values, codes; none missing on
 * either side. The document's tables are read by their header rows. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "proto/message.h"

enum { MAX_ROWS = 256, MAX_CELLS = 5, CELL_SIZE = 64 };

typedef struct table {
    size_t rows;
    char cells[MAX_ROWS][MAX_CELLS][CELL_SIZE];
} table_t;

static table_t table;

/* Splits "| a | b |" into trimmed cells; the last ones may be cut short. False: no row of a table. */
static int split_row(const char *line, char cells[MAX_CELLS][CELL_SIZE])
{
    if (*line != '|')
        return 0;
    memset(cells, 0, MAX_CELLS * CELL_SIZE);
    for (int i = 0; i < MAX_CELLS && *line == '|'; i++) {
        line++;
        while (*line == ' ')
            line++;
        size_t length = strcspn(line, "|\n");
        const char *next = line + length;
        while (length && line[length - 1] == ' ')
            length--;
        if (next[0] == '|')
            snprintf(cells[i], CELL_SIZE, "%.*s", (int)(length < CELL_SIZE - 1 ? length : CELL_SIZE - 1), line);
        line = next;
    }
    return 1;
}

/* Reads the rows of the table whose header begins with these two cells. */
static void read_table(const char *first, const char *second)
{
    FILE *file = fopen(PROTOCOL_DOCUMENT, "r");
    assert_non_null(file);
    char line[1024], cells[MAX_CELLS][CELL_SIZE];
    int inside = 0;
    table.rows = 0;
    while (fgets(line, sizeof line, file)) {
        const int row = split_row(line, cells);
        if (inside && !row)
            break;
        if (inside && strspn(cells[0], "-:") != strlen(cells[0])) {
            assert_true(table.rows < MAX_ROWS);
            memcpy(table.cells[table.rows++], cells, sizeof cells);
        }
        inside |= row && strcmp(cells[0], first) == 0 && strcmp(cells[1], second) == 0;
    }
    fclose(file);
    if (table.rows == 0)
        fail_msg("PROTOCOL.md has no table | %s | %s |", first, second);
}

static uint64_t number(const char *text)
{
    char *end;
    const uint64_t value = strtoull(text, &end, 10);
    if (end == text || *end)
        fail_msg("\"%s\" is no number", text);
    return value;
}

static void types_and_senders_agree(void **state)
{
    (void)state;
    read_table("number", "type");
    size_t types = 0;
    for (unsigned type = 0; type < 1u << 16; type++)
        types += message_senders(type) != 0;
    assert_int_equal(table.rows, types);
    for (size_t i = 0; i < table.rows; i++) {
        const unsigned type = (unsigned)number(table.cells[i][0]);
        assert_string_equal(table.cells[i][1], message_type_name(type));
        unsigned senders = 0;
        for (const char *c = table.cells[i][2]; *c; c++)
            senders |= *c == 'M'   ? MESSAGE_FROM_MASTER
                       : *c == 'W' ? MESSAGE_FROM_WORKER
                       : *c == 'C' ? MESSAGE_FROM_CLIENT
                                   : 0u;
        assert_int_equal(senders, message_senders(type));
    }
}

static uint64_t kind_max(message_field_kind_t kind)
{
    static const uint64_t most[] = {UINT8_MAX, UINT16_MAX, UINT32_MAX, UINT64_MAX};
    return kind <= MESSAGE_FIELD_U64 ? most[kind] : 0;
}

static void check_field(char row[MAX_CELLS][CELL_SIZE], const message_field_t *field)
{
    assert_string_equal(row[1], field->name);
    assert_string_equal(row[2], message_field_kind_name(field->kind));
    const uint64_t min = strcmp(row[3], "-") ? number(row[3]) : 0;
    const uint64_t max = strcmp(row[4], "-") ? number(row[4]) : kind_max(field->kind);
    if (min != field->min || max != field->max)
        fail_msg("%s.%s: document %s to %s, code %llu to %llu", row[0], row[1], row[3], row[4],
                 (unsigned long long)field->min, (unsigned long long)field->max);
}

static void fields_agree(void **state)
{
    (void)state;
    read_table("message", "field");
    size_t row = 0;
    for (unsigned type = 0; type < 1u << 16; type++) {
        size_t count;
        const message_field_t *fields = message_fields(type, &count);
        for (size_t i = 0; i < count; i++, row++) {
            /* rows of one message stand together; find where they begin */
            if (i == 0)
                for (row = 0; row < table.rows && strcmp(table.cells[row][0], message_type_name(type)); row++)
                    ;
            assert_true(row < table.rows);
            assert_string_equal(table.cells[row][0], message_type_name(type));
            check_field(table.cells[row], &fields[i]);
        }
    }
    size_t fields_in_code = 0;
    for (unsigned type = 0; type < 1u << 16; type++) {
        size_t count;
        message_fields(type, &count);
        fields_in_code += count;
    }
    assert_int_equal(table.rows, fields_in_code);
}

typedef struct constant {
    const char *name;
    uint64_t value;
} constant_t;

static void compare_constants(const constant_t *constants, size_t count, int name_cell, int value_cell)
{
    assert_int_equal(table.rows, count);
    for (size_t i = 0; i < count; i++) {
        size_t row = 0;
        while (row < table.rows && strcmp(table.cells[row][name_cell], constants[i].name))
            row++;
        if (row == table.rows)
            fail_msg("the document has no %s", constants[i].name);
        if (number(table.cells[row][value_cell]) != constants[i].value)
            fail_msg("%s: document %s, code %llu", constants[i].name, table.cells[row][value_cell],
                     (unsigned long long)constants[i].value);
    }
}

static void limits_agree(void **state)
{
    (void)state;
#define CONSTANT(name)                                                                                             \
    {                                                                                                              \
#name, MESSAGE_##name                                                                                      \
    }
    static const constant_t constants[] = {
        CONSTANT(MAX_STRING),      CONSTANT(MAX_TOKEN),       CONSTANT(MAX_TEXT),        CONSTANT(MAX_STATUS),
        CONSTANT(MAX_RECORD),      CONSTANT(MAX_CHUNK),       CONSTANT(MAX_RESULT),      CONSTANT(MAX_FROM_MASTER),
        CONSTANT(MAX_FROM_PEER),   CONSTANT(MAX_LEASES),      CONSTANT(MAX_SLOTS),       CONSTANT(MAX_PEERS),
        CONSTANT(MAX_THREADS),     CONSTANT(MIN_INTERVAL_MS), CONSTANT(MAX_INTERVAL_MS), CONSTANT(LEASE_SIZE),
        CONSTANT(MAX_BUNDLE),      CONSTANT(MAX_OUTPUT),      CONSTANT(HEARTBEAT_MS),    CONSTANT(LEASE_MS),
        CONSTANT(HANDSHAKE_MS),    CONSTANT(BACKOFF_MIN_MS),  CONSTANT(BACKOFF_MAX_MS),  CONSTANT(HEADER_SIZE),
        CONSTANT(PROTOCOL_VERSION)};
    read_table("constant", "value");
    compare_constants(constants, sizeof constants / sizeof *constants, 0, 1);
}

static void small_values_agree(void **state)
{
    (void)state;
    static const struct {
        const char *field, *name;
        uint64_t value;
    } values[] = {{"role", "WORKER", MESSAGE_ROLE_WORKER},       {"role", "CLIENT", MESSAGE_ROLE_CLIENT},
                  {"outcome", "MERGED", MESSAGE_ACK_MERGED},     {"outcome", "DUPLICATE", MESSAGE_ACK_DUPLICATE},
                  {"outcome", "UNKNOWN", MESSAGE_ACK_UNKNOWN},   {"output", "IMAGE", MESSAGE_OUTPUT_IMAGE},
                  {"output", "PREVIEW", MESSAGE_OUTPUT_PREVIEW}, {"output", "REPORT", MESSAGE_OUTPUT_REPORT},
                  {"state", "FINISHED", MESSAGE_END_FINISHED},   {"state", "FAILED", MESSAGE_END_FAILED},
                  {"state", "CANCELLED", MESSAGE_END_CANCELLED}};
    read_table("field", "value");
    assert_int_equal(table.rows, sizeof values / sizeof *values);
    for (size_t i = 0; i < table.rows; i++) {
        assert_string_equal(table.cells[i][0], values[i].field);
        assert_int_equal(number(table.cells[i][1]), values[i].value);
        assert_string_equal(table.cells[i][2], values[i].name);
    }
}

static void fault_codes_agree(void **state)
{
    (void)state;
#define CODE_NAME(name, text) {#name, name},
    static constant_t constants[] = {FAULT_CODES(CODE_NAME)};
    const size_t count = sizeof constants / sizeof *constants;
    for (size_t i = 0; i < count; i++)
        constants[i].name += strlen("FAULT_");
    read_table("code", "name");
    compare_constants(constants, count, 1, 0);
}

static void the_document_states_signature_and_version(void **state)
{
    (void)state;
    FILE *file = fopen(PROTOCOL_DOCUMENT, "r");
    assert_non_null(file);
    static char text[1 << 17];
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    char title[64], signature[64];
    snprintf(title, sizeof title, "# The Garland protocol, version %d\n", MESSAGE_PROTOCOL_VERSION);
    snprintf(signature, sizeof signature, "%%x%02X.%02X.%02X.%02X", MESSAGE_SIGNATURE[0], MESSAGE_SIGNATURE[1],
             MESSAGE_SIGNATURE[2], MESSAGE_SIGNATURE[3]);
    assert_int_equal(strncmp(text, title, strlen(title)), 0);
    assert_non_null(strstr(text, signature));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(types_and_senders_agree),
        cmocka_unit_test(fields_agree),
        cmocka_unit_test(limits_agree),
        cmocka_unit_test(small_values_agree),
        cmocka_unit_test(fault_codes_agree),
        cmocka_unit_test(the_document_states_signature_and_version),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
