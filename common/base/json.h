/* json.h: strict JSON in, exact JSON out. The only place that knows cJSON.
 *
 * Reading refuses what cJSON lets pass: trailing text, duplicate keys, keys that differ only in case, invalid
 * UTF-8, \u0000, bare control characters, numbers outside JSON's grammar, longer than 60 characters or not finite,
 * nesting beyond 32, more than 2^20 values. Every getter names the field's path ("film.width") and what was found
 * and expected in its fault. Unknown fields are found by json_expect_fields.
 *
 *     json_t *root = NULL;
 *     int64_t width = 640;
 *     TRY(json_parse(&root, text, length, fault));
 *     code = json_read_int_or(json_get(root, "film"), "film", "width", 1, 32768, &width, fault);
 *     json_destroy(&root);
 *
 * Thread rule: a value may be read by any number of threads; it is changed by one at a time.
 *
 * Writing prints doubles with 17 significant digits (they read back to the same bits; shorter where that suffices),
 * non-finite values as null. Integers of 64 bits and seeds travel as strings.
 */
#ifndef BASE_JSON_H
#define BASE_JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"

typedef struct json json_t; /* a value; children belong to their root */

enum {
    JSON_MAX_BYTES = 64 << 20,
    JSON_MAX_DEPTH = 32,
    JSON_MAX_VALUES = 1 << 20,
    JSON_MAX_NUMBER = 60 /* characters of a number */
};

/* Parses text[0..length); the caller destroys the result. A syntax error names line and column. */
fault_code_t json_parse(json_t **out, const char *text, size_t length, fault_t *fault);
void json_destroy(json_t **json);

/* Reading. `path` is the path of `object` as messages should print it ("" for the root). A getter for an optional
 * field (the _or forms) leaves *out alone when the field is absent or null. `object` may be null: it has no fields;
 * one that is not an object is FAULT_TYPE. */
bool json_is_object(const json_t *json);
bool json_is_array(const json_t *json);
bool json_is_string(const json_t *json);
bool json_is_number(const json_t *json);
const json_t *json_get(const json_t *object, const char *name); /* null if absent; case-sensitive */
size_t json_size(const json_t *array_or_object);
const json_t *json_at(const json_t *array_or_object, size_t index); /* null beyond the end; walks from the start */
/* The members in order, null after the last: for (m = json_first(a); m; m = json_next(m)). */
const json_t *json_first(const json_t *array_or_object);
const json_t *json_next(const json_t *member);
const char *json_name(const json_t *member); /* of an object's member; borrowed; null for an array's */
const char *json_string(const json_t *json); /* borrowed; null unless a string */
double json_number(const json_t *json);      /* 0 unless a number */
/* Refuses members of `object` that are not in the null-terminated list. */
fault_code_t json_expect_fields(const json_t *object, const char *path, const char *const *names, fault_t *fault);
fault_code_t json_read_object(const json_t *object, const char *path, const char *name, const json_t **out,
                              fault_t *fault); /* *out = null if absent */
fault_code_t json_read_string_or(const json_t *object, const char *path, const char *name, const char **out,
                                 fault_t *fault); /* borrowed */
fault_code_t json_read_double_or(const json_t *object, const char *path, const char *name, double lo, double hi,
                                 double *out, fault_t *fault);
fault_code_t json_read_int_or(const json_t *object, const char *path, const char *name, int64_t lo, int64_t hi,
                              int64_t *out, fault_t *fault); /* an integral number */
fault_code_t json_read_bool_or(const json_t *object, const char *path, const char *name, bool *out, fault_t *fault);
/* A 64-bit unsigned number as a decimal string, or as a number below 2^53. */
fault_code_t json_read_u64_or(const json_t *object, const char *path, const char *name, uint64_t *out,
                              fault_t *fault);

/* Writing: values are created, then added (the container takes ownership); a name is added once. Creation never
 * returns null: out of memory aborts, as nothing here is large. Bytes of a text that are not UTF-8 become '?'. */
json_t *json_new_object(void);
json_t *json_new_array(void);
json_t *json_new_string(const char *text);
json_t *json_new_number(double value);
json_t *json_new_bool(bool value);
json_t *json_new_null(void);
void json_add(json_t *object, const char *name, json_t *value);
void json_append(json_t *array, json_t *value);
void json_add_string(json_t *object, const char *name, const char *text);
void json_add_number(json_t *object, const char *name, double value);
void json_add_bool(json_t *object, const char *name, bool value);
void json_add_u64(json_t *object, const char *name, uint64_t value); /* as a decimal string */
json_t *json_copy(const json_t *json);
/* Text of the value, indented or compact; the caller frees it with free(). */
char *json_print(const json_t *json, bool indented);

#endif
