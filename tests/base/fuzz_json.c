/* Any bytes: either refused with a sentence, or a document that prints and reads back to the same text. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(int condition, const char *what)
{
    if (!condition) {
        fprintf(stderr, "fuzz_json: %s\n", what);
        abort();
    }
}

static void read_fields(const json_t *json)
{
    static const char *const known[] = {"scene", "film", "seed", NULL};
    double number = 0;
    int64_t whole = 0;
    uint64_t seed = 0;
    bool flag = false;
    const char *text = NULL;
    fault_t fault = {0};
    (void)json_expect_fields(json, "", known, &fault);
    for (const json_t *m = json_first(json); m; m = json_next(m)) {
        const char *name = json_is_object(json) ? json_name(m) : "none";
        (void)json_read_double_or(json, "x", name, -1, 1, &number, &fault);
        (void)json_read_int_or(json, "x", name, INT64_MIN, INT64_MAX, &whole, &fault);
        (void)json_read_u64_or(json, "x", name, &seed, &fault);
        (void)json_read_bool_or(json, "x", name, &flag, &fault);
        (void)json_read_string_or(json, "x", name, &text, &fault);
        require(number >= -1 && number <= 1, "a number out of its range was read");
        read_fields(m);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    json_t *json = NULL, *again = NULL;
    fault_t fault = {0};
    if (json_parse(&json, (const char *)data, size, &fault) != FAULT_NONE) {
        require(json == NULL && fault.text[0] != '\0', "a refusal without words");
        return 0;
    }
    read_fields(json);
    char *text = json_print(json, (size & 1) != 0);
    require(json_parse(&again, text, strlen(text), &fault) == FAULT_NONE, fault.text);
    char *text_again = json_print(again, (size & 1) != 0);
    require(strcmp(text, text_again) == 0, "printing and reading changed the document");
    free(text);
    free(text_again);
    json_destroy(&json);
    json_destroy(&again);
    return 0;
}
