#include "pilots.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

typedef struct pilots_entry {
    uint8_t *key, *data;
    size_t key_size, size;
} pilots_entry_t;

struct pilots {
    pilots_entry_t *entries;
    size_t count;
};

/* What of a job independent samples know: all but how chains move. */
typedef struct pilots_settings {
    uint64_t seed, algorithm, width, height, max_path_length, whole_path_length, target;
    int64_t filter;
    double filter_radius;
    uint8_t effects[8];
} pilots_settings_t;

static_assert(SETTINGS_EFFECTS <= 8, "effects have their place");

static void *pilots_room(void *old, size_t size)
{
    void *room = realloc(old, size);
    if (!room)
        abort();
    return room;
}

static bool pilots_keeps(uint32_t kind)
{
    return kind == WORK_PILOT || kind == WORK_FEATURES;
}

static uint64_t pilots_sampler(settings_algorithm_t algorithm)
{
    return settings_is_chains(algorithm) && !settings_joins_all(algorithm) ? SETTINGS_MMLT : algorithm;
}

static fault_code_t pilots_key(const settings_t *s, const work_record_t *record, uint8_t **key, size_t *size,
                               fault_t *fault)
{
    uint8_t *bytes = NULL;
    size_t record_size;
    pilots_settings_t own;
    memset(&own, 0, sizeof own);
    own.seed = s->seed;
    own.algorithm = pilots_sampler(s->algorithm);
    own.width = s->width;
    own.height = s->height;
    own.max_path_length = s->max_path_length;
    own.whole_path_length = s->whole_path_length;
    own.target = s->target;
    own.filter = s->filter;
    own.filter_radius = s->filter_radius;
    memcpy(own.effects, s->effects, sizeof s->effects);
    TRY(work_record_encode(record, &bytes, &record_size, fault));
    *size = sizeof own + record_size;
    *key = pilots_room(NULL, *size);
    memcpy(*key, &own, sizeof own);
    memcpy(*key + sizeof own, bytes, record_size);
    free(bytes);
    return FAULT_NONE;
}

static fault_code_t pilots_make(work_space_t *space, const work_record_t *record, uint8_t **data, size_t *size,
                                fault_t *fault)
{
    const atomic_bool cancel = false;
    work_result_t result;
    TRY(work_run(space, record, &cancel, &result, fault));
    return work_result_encode(&result, data, size, fault);
}

pilots_t *pilots_new(void)
{
    pilots_t *pilots = pilots_room(NULL, sizeof *pilots);
    *pilots = (pilots_t){0};
    return pilots;
}

void pilots_destroy(pilots_t **pilots)
{
    for (size_t i = 0; *pilots && i < (*pilots)->count; i++) {
        free((*pilots)->entries[i].key);
        free((*pilots)->entries[i].data);
    }
    if (*pilots)
        free((*pilots)->entries);
    free(*pilots);
    *pilots = NULL;
}

static uint8_t *pilots_copy(const uint8_t *data, size_t size)
{
    return memcpy(pilots_room(NULL, size), data, size);
}

fault_code_t pilots_run(pilots_t *pilots, work_space_t *space, const settings_t *settings,
                        const work_record_t *record, uint8_t **data, size_t *size, fault_t *fault)
{
    if (!pilots || !pilots_keeps(record->kind))
        return pilots_make(space, record, data, size, fault);
    pilots_entry_t entry;
    TRY(pilots_key(settings, record, &entry.key, &entry.key_size, fault));
    for (size_t i = 0; i < pilots->count; i++) {
        const pilots_entry_t *kept = &pilots->entries[i];
        if (kept->key_size != entry.key_size || memcmp(kept->key, entry.key, entry.key_size) != 0)
            continue;
        free(entry.key);
        *size = kept->size;
        *data = pilots_copy(kept->data, kept->size);
        return FAULT_NONE;
    }
    const fault_code_t code = pilots_make(space, record, data, size, fault);
    if (code) {
        free(entry.key);
        return code;
    }
    entry.size = *size;
    entry.data = pilots_copy(*data, *size);
    pilots->entries = pilots_room(pilots->entries, (pilots->count + 1) * sizeof *pilots->entries);
    pilots->entries[pilots->count++] = entry;
    return FAULT_NONE;
}
