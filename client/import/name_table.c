#include "client/import/name_table.h"

#include <stdlib.h>
#include <string.h>

void name_table_clear(name_table_t *table)
{
    for (size_t i = 0; i < table->capacity; i++)
        free(table->slots[i].name);
    free(table->slots);
    memset(table, 0, sizeof *table);
}

/* FNV-1a, 64 bits (Fowler, Noll, Vo). */
static uint64_t hash(const char *name)
{
    uint64_t h = UINT64_C(0xcbf29ce484222325);
    for (; *name; name++)
        h = (h ^ (uint8_t)*name) * UINT64_C(0x100000001b3);
    return h;
}

/* The name's slot, or the empty one where it would go; there is always an empty one. */
static name_entry_t *find(name_entry_t *slots, size_t capacity, const char *name)
{
    size_t i = (size_t)hash(name) & (capacity - 1);
    while (slots[i].name && strcmp(slots[i].name, name) != 0)
        i = (i + 1) & (capacity - 1);
    return &slots[i];
}

int32_t name_table_get(const name_table_t *table, const char *name, int32_t absent)
{
    if (table->capacity == 0)
        return absent;
    const name_entry_t *entry = find(table->slots, table->capacity, name);
    return entry->name ? entry->value : absent;
}

static bool grow(name_table_t *table)
{
    const size_t capacity = table->capacity ? 2 * table->capacity : 64;
    name_entry_t *slots = calloc(capacity, sizeof *slots);
    if (!slots)
        return false;
    for (size_t i = 0; i < table->capacity; i++)
        if (table->slots[i].name)
            *find(slots, capacity, table->slots[i].name) = table->slots[i];
    free(table->slots);
    table->slots = slots;
    table->capacity = capacity;
    return true;
}

fault_code_t name_table_set(name_table_t *table, const char *name, int32_t value, fault_t *fault)
{
    if (2 * (table->count + 1) > table->capacity && !grow(table))
        return fault_set(fault, FAULT_MEMORY, "no memory for the name \"%.100s\"", name);
    name_entry_t *entry = find(table->slots, table->capacity, name);
    if (!entry->name) {
        entry->name = strdup(name);
        if (!entry->name)
            return fault_set(fault, FAULT_MEMORY, "no memory for the name \"%.100s\"", name);
        table->count++;
    }
    entry->value = value;
    return FAULT_NONE;
}
