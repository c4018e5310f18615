#include "base/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/json_scan.h"

/* A json_t is a cJSON under another name. */
static const cJSON *node_of(const json_t *json)
{
    return (const cJSON *)json;
}

static cJSON *mutable_node(json_t *json)
{
    return (cJSON *)json;
}

static json_t *json_of(cJSON *node)
{
    if (!node) {
        fputs("out of memory for JSON\n", stderr);
        abort();
    }
    return (json_t *)node;
}

/* ---- names in messages ---- */

enum { PATH_SIZE = 200 };

/* `text` without control characters: messages go to terminals. */
static void clean_text(char *out, size_t size, const char *text)
{
    size_t n = 0;
    for (; text[n] && n + 1 < size; n++)
        out[n] = (unsigned char)text[n] < ' ' || text[n] == 0x7f ? '?' : text[n];
    out[n] = '\0';
}

/* "path.name"; either may be empty. */
static void path_of(char out[PATH_SIZE], const char *path, const char *name)
{
    char clean[64];
    clean_text(clean, sizeof clean, name);
    snprintf(out, PATH_SIZE, "%.130s%s%s", path, *path && *clean ? "." : "", clean);
}

/* What a value is, for a message. */
static void describe(char *out, size_t size, const json_t *json)
{
    const cJSON *node = node_of(json);
    char clean[40];
    if (cJSON_IsNumber(node))
        snprintf(out, size, "%.17g", node->valuedouble);
    else if (cJSON_IsBool(node))
        snprintf(out, size, cJSON_IsTrue(node) ? "true" : "false");
    else if (cJSON_IsArray(node))
        snprintf(out, size, "an array");
    else if (cJSON_IsObject(node))
        snprintf(out, size, "an object");
    else if (cJSON_IsString(node)) {
        clean_text(clean, sizeof clean, node->valuestring);
        snprintf(out, size, "the text \"%s\"", clean);
    } else
        snprintf(out, size, "null");
}

static fault_code_t wrong(fault_code_t code, const char *path, const char *name, const char *expected,
                          const json_t *found, fault_t *fault)
{
    char place[PATH_SIZE], what[80];
    path_of(place, path, name);
    describe(what, sizeof what, found);
    return fault_set(fault, code, "%s: expected %s, found %s", *place ? place : "the document", expected, what);
}

/* ---- parsing ---- */

static int compare_names(const void *a, const void *b)
{
    const char *const *x = a;
    const char *const *y = b;
    return strcasecmp(*x, *y);
}

/* `names` has room for the members of any object of the document. */
static fault_code_t check_names(const cJSON *object, const char *path, const char **names, fault_t *fault)
{
    size_t count = 0;
    for (const cJSON *m = object->child; m; m = m->next)
        names[count++] = m->string;
    qsort(names, count, sizeof *names, compare_names);
    for (size_t i = 1; i < count; i++) {
        char place[PATH_SIZE];
        if (strcasecmp(names[i - 1], names[i]) != 0)
            continue;
        path_of(place, path, names[i]);
        if (strcmp(names[i - 1], names[i]) == 0)
            return fault_set(fault, FAULT_SYNTAX, "%s: this name appears twice", place);
        return fault_set(fault, FAULT_SYNTAX, "%s: another name differs from it only in case", place);
    }
    return FAULT_NONE;
}

static fault_code_t check_tree(const cJSON *node, const char *path, const char **names, fault_t *fault)
{
    if (cJSON_IsObject(node))
        TRY(check_names(node, path, names, fault));
    size_t index = 0;
    for (const cJSON *m = node->child; m; m = m->next, index++) {
        char inner[PATH_SIZE];
        if (!m->child)
            continue;
        if (m->string)
            path_of(inner, path, m->string);
        else
            snprintf(inner, sizeof inner, "%.150s[%zu]", path, index);
        TRY(check_tree(m, inner, names, fault));
    }
    return FAULT_NONE;
}

static size_t most_members(const cJSON *node)
{
    size_t own = 0, most = 0;
    for (const cJSON *m = node->child; m; m = m->next, own++) {
        const size_t inner = most_members(m);
        most = inner > most ? inner : most;
    }
    return own > most ? own : most;
}

fault_code_t json_parse(json_t **out, const char *text, size_t length, fault_t *fault)
{
    *out = NULL;
    TRY(json_scan(text, length, fault));
    cJSON *root = cJSON_ParseWithLength(text, length);
    const char **names = root ? malloc((most_members(root) + 1) * sizeof *names) : NULL;
    if (!names) {
        cJSON_Delete(root);
        return fault_set(fault, FAULT_MEMORY, "no memory for %zu bytes of JSON", length);
    }
    const fault_code_t code = check_tree(root, "", names, fault);
    free(names);
    if (code != FAULT_NONE)
        cJSON_Delete(root);
    else
        *out = (json_t *)root;
    return code;
}

void json_destroy(json_t **json)
{
    if (json && *json) {
        cJSON_Delete(mutable_node(*json));
        *json = NULL;
    }
}

/* ---- reading ---- */

bool json_is_object(const json_t *json)
{
    return cJSON_IsObject(node_of(json));
}

bool json_is_array(const json_t *json)
{
    return cJSON_IsArray(node_of(json));
}

bool json_is_string(const json_t *json)
{
    return cJSON_IsString(node_of(json));
}

bool json_is_number(const json_t *json)
{
    return cJSON_IsNumber(node_of(json));
}

static bool is_container(const json_t *json)
{
    return json_is_object(json) || json_is_array(json);
}

const json_t *json_get(const json_t *object, const char *name)
{
    return json_is_object(object) ? (const json_t *)cJSON_GetObjectItemCaseSensitive(node_of(object), name) : NULL;
}

size_t json_size(const json_t *array_or_object)
{
    size_t size = 0;
    for (const json_t *m = json_first(array_or_object); m; m = json_next(m))
        size++;
    return size;
}

const json_t *json_at(const json_t *array_or_object, size_t index)
{
    const json_t *m = json_first(array_or_object);
    while (m && index-- > 0)
        m = json_next(m);
    return m;
}

const json_t *json_first(const json_t *array_or_object)
{
    return is_container(array_or_object) ? (const json_t *)node_of(array_or_object)->child : NULL;
}

const json_t *json_next(const json_t *member)
{
    return (const json_t *)node_of(member)->next;
}

const char *json_name(const json_t *member)
{
    return node_of(member)->string;
}

const char *json_string(const json_t *json)
{
    return json_is_string(json) ? node_of(json)->valuestring : NULL;
}

double json_number(const json_t *json)
{
    return json_is_number(json) ? node_of(json)->valuedouble : 0;
}

static fault_code_t unknown_field(const char *path, const char *name, const char *const *names, fault_t *fault)
{
    char place[PATH_SIZE], list[400] = "";
    path_of(place, path, name);
    for (size_t i = 0, n = 0; names[i] && n < sizeof list; i++)
        n += (size_t)snprintf(list + n, sizeof list - n, "%s%s", i ? ", " : "", names[i]);
    return fault_set(fault, FAULT_UNKNOWN, "%s: unknown field; known here: %s", place, list);
}

fault_code_t json_expect_fields(const json_t *object, const char *path, const char *const *names, fault_t *fault)
{
    if (object && !json_is_object(object))
        return wrong(FAULT_TYPE, path, "", "an object", object, fault);
    for (const json_t *m = json_first(object); m; m = json_next(m)) {
        size_t i = 0;
        while (names[i] && strcmp(names[i], json_name(m)) != 0)
            i++;
        if (!names[i])
            return unknown_field(path, json_name(m), names, fault);
    }
    return FAULT_NONE;
}

/* The field, or null where it is absent or null. */
static fault_code_t find(const json_t *object, const char *path, const char *name, const json_t **field,
                         fault_t *fault)
{
    *field = NULL;
    if (object && !json_is_object(object))
        return wrong(FAULT_TYPE, path, "", "an object", object, fault);
    const json_t *found = json_get(object, name);
    if (found && !cJSON_IsNull(node_of(found)))
        *field = found;
    return FAULT_NONE;
}

fault_code_t json_read_object(const json_t *object, const char *path, const char *name, const json_t **out,
                              fault_t *fault)
{
    *out = NULL;
    const json_t *field;
    TRY(find(object, path, name, &field, fault));
    if (field && !json_is_object(field))
        return wrong(FAULT_TYPE, path, name, "an object", field, fault);
    *out = field;
    return FAULT_NONE;
}

fault_code_t json_read_string_or(const json_t *object, const char *path, const char *name, const char **out,
                                 fault_t *fault)
{
    const json_t *field;
    TRY(find(object, path, name, &field, fault));
    if (field && !json_is_string(field))
        return wrong(FAULT_TYPE, path, name, "a text", field, fault);
    if (field)
        *out = json_string(field);
    return FAULT_NONE;
}

fault_code_t json_read_double_or(const json_t *object, const char *path, const char *name, double lo, double hi,
                                 double *out, fault_t *fault)
{
    const json_t *field;
    char expected[100];
    TRY(find(object, path, name, &field, fault));
    if (!field)
        return FAULT_NONE;
    const double value = json_number(field);
    snprintf(expected, sizeof expected, "a number from %.17g to %.17g", lo, hi);
    if (!json_is_number(field))
        return wrong(FAULT_TYPE, path, name, expected, field, fault);
    if (!(value >= lo && value <= hi))
        return wrong(FAULT_RANGE, path, name, expected, field, fault);
    *out = value;
    return FAULT_NONE;
}

fault_code_t json_read_int_or(const json_t *object, const char *path, const char *name, int64_t lo, int64_t hi,
                              int64_t *out, fault_t *fault)
{
    const json_t *field;
    char expected[100];
    TRY(find(object, path, name, &field, fault));
    if (!field)
        return FAULT_NONE;
    const double value = json_number(field);
    snprintf(expected, sizeof expected, "a whole number from %lld to %lld", (long long)lo, (long long)hi);
    if (!json_is_number(field))
        return wrong(FAULT_TYPE, path, name, expected, field, fault);
    /* Beyond 2^53 a double no longer tells neighbouring integers apart. */
    if (value != floor(value) || fabs(value) > 0x1p53 || (int64_t)value < lo || (int64_t)value > hi)
        return wrong(FAULT_RANGE, path, name, expected, field, fault);
    *out = (int64_t)value;
    return FAULT_NONE;
}

fault_code_t json_read_bool_or(const json_t *object, const char *path, const char *name, bool *out, fault_t *fault)
{
    const json_t *field;
    TRY(find(object, path, name, &field, fault));
    if (field && !cJSON_IsBool(node_of(field)))
        return wrong(FAULT_TYPE, path, name, "true or false", field, fault);
    if (field)
        *out = cJSON_IsTrue(node_of(field));
    return FAULT_NONE;
}

/* Decimal digits alone, within 64 bits. */
static bool parse_u64(const char *text, uint64_t *out)
{
    uint64_t value = 0;
    if (!*text)
        return false;
    for (; *text; text++) {
        const unsigned digit = (unsigned)*text - '0';
        if (digit > 9 || __builtin_mul_overflow(value, 10, &value) || __builtin_add_overflow(value, digit, &value))
            return false;
    }
    *out = value;
    return true;
}

fault_code_t json_read_u64_or(const json_t *object, const char *path, const char *name, uint64_t *out,
                              fault_t *fault)
{
    static const char expected[] = "a whole number below 2^64 as decimal digits in quotes, or a number below 2^53";
    const json_t *field;
    TRY(find(object, path, name, &field, fault));
    if (!field)
        return FAULT_NONE;
    if (json_is_string(field))
        return parse_u64(json_string(field), out) ? FAULT_NONE
                                                  : wrong(FAULT_RANGE, path, name, expected, field, fault);
    if (!json_is_number(field))
        return wrong(FAULT_TYPE, path, name, expected, field, fault);
    const double value = json_number(field);
    if (!(value >= 0 && value < 0x1p53) || value != floor(value))
        return wrong(FAULT_RANGE, path, name, expected, field, fault);
    *out = (uint64_t)value;
    return FAULT_NONE;
}

/* ---- writing ---- */

/* A copy with every byte that is not UTF-8 replaced. */
static char *valid_text(const char *text)
{
    const size_t length = strlen(text);
    char *copy = malloc(length + 1);
    if (!copy)
        return NULL;
    for (size_t i = 0; i < length;) {
        const size_t n = json_utf8_length(text + i, length - i);
        if (n == 0)
            copy[i] = '?';
        else
            memcpy(copy + i, text + i, n);
        i += n ? n : 1;
    }
    copy[length] = '\0';
    return copy;
}

json_t *json_new_object(void)
{
    return json_of(cJSON_CreateObject());
}

json_t *json_new_array(void)
{
    return json_of(cJSON_CreateArray());
}

json_t *json_new_string(const char *text)
{
    char *valid = valid_text(text);
    json_t *json = json_of(valid ? cJSON_CreateString(valid) : NULL);
    free(valid);
    return json;
}

json_t *json_new_number(double value)
{
    return json_of(isfinite(value) ? cJSON_CreateNumber(value) : cJSON_CreateNull());
}

json_t *json_new_bool(bool value)
{
    return json_of(cJSON_CreateBool(value));
}

json_t *json_new_null(void)
{
    return json_of(cJSON_CreateNull());
}

void json_add(json_t *object, const char *name, json_t *value)
{
    char *valid = valid_text(name);
    const bool done = valid && cJSON_AddItemToObject(mutable_node(object), valid, mutable_node(value));
    json_of(done ? mutable_node(object) : NULL);
    free(valid);
}

void json_append(json_t *array, json_t *value)
{
    json_of(cJSON_AddItemToArray(mutable_node(array), mutable_node(value)) ? mutable_node(array) : NULL);
}

void json_add_string(json_t *object, const char *name, const char *text)
{
    json_add(object, name, json_new_string(text));
}

void json_add_number(json_t *object, const char *name, double value)
{
    json_add(object, name, json_new_number(value));
}

void json_add_bool(json_t *object, const char *name, bool value)
{
    json_add(object, name, json_new_bool(value));
}

void json_add_u64(json_t *object, const char *name, uint64_t value)
{
    char text[24];
    snprintf(text, sizeof text, "%llu", (unsigned long long)value);
    json_add_string(object, name, text);
}

json_t *json_copy(const json_t *json)
{
    return json_of(cJSON_Duplicate(node_of(json), true));
}

/* The shortest of 15, 16 or 17 digits that reads back to the same bits. */
static void print_double(char out[32], double value)
{
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(out, 32, "%.*g", digits, value);
        if (strtod(out, NULL) == value)
            return;
    }
}

/* Turns numbers into literal text: cJSON's own printing loses bits. */
static void freeze_numbers(cJSON *node)
{
    if (cJSON_IsNumber(node)) {
        char text[32];
        print_double(text, node->valuedouble);
        node->valuestring = strdup(text);
        json_of(node->valuestring ? node : NULL);
        node->type = (node->type & ~0xff) | cJSON_Raw;
    }
    for (cJSON *m = node->child; m; m = m->next)
        freeze_numbers(m);
}

char *json_print(const json_t *json, bool indented)
{
    json_t *copy = json_copy(json);
    freeze_numbers(mutable_node(copy));
    char *text = indented ? cJSON_Print(mutable_node(copy)) : cJSON_PrintUnformatted(mutable_node(copy));
    json_of(text ? mutable_node(copy) : NULL);
    json_destroy(&copy);
    return text;
}
