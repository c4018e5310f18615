/* name_table.h: names to numbers, by hashing. Names are copied. One thread at a time. */
#ifndef IMPORT_NAME_TABLE_H
#define IMPORT_NAME_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"

typedef struct name_entry {
    char *name;
    int32_t value;
} name_entry_t;

typedef struct name_table { /* all zero: empty */
    name_entry_t *slots;
    size_t count, capacity; /* capacity: zero or a power of two */
} name_table_t;

void name_table_clear(name_table_t *table);
/* The value, or `absent`. */
int32_t name_table_get(const name_table_t *table, const char *name, int32_t absent);
/* Adds or replaces. FAULT_MEMORY. */
fault_code_t name_table_set(name_table_t *table, const char *name, int32_t value, fault_t *fault);

#endif
