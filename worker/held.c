#include "worker/held.h"

#include <stdlib.h>
#include <string.h>

void held_init(held_list_t *list)
{
    *list = (held_list_t){0};
    list->last = &list->first;
}

static void append(held_list_t *list, held_t *held)
{
    held->next = NULL;
    *list->last = held;
    list->last = &held->next;
    list->count++;
}

static void detach(held_list_t *list, held_t *held)
{
    held_t **link = &list->first;
    while (*link != held)
        link = &(*link)->next;
    *link = held->next;
    if (list->last == &held->next)
        list->last = link;
    list->count--;
    if (held->state == HELD_DONE) {
        list->done--;
        list->done_bytes -= held->result_size;
    }
}

static void destroy(held_t *held)
{
    free(held->record);
    free(held->result);
    free(held->text);
    free(held);
}

void held_clear(held_list_t *list)
{
    while (list->first)
        held_remove(list, list->first);
}

held_t *held_add(held_list_t *list, const message_work_t *work)
{
    held_t *held = calloc(1, sizeof *held);
    uint8_t *record = malloc(work->record.size ? work->record.size : 1);
    if (!held || !record) {
        free(held);
        free(record);
        return NULL;
    }
    if (work->record.size)
        memcpy(record, work->record.data, work->record.size);
    held->lease = work->lease;
    held->job_digest = work->job_digest;
    held->bundle_digest = work->bundle_digest;
    held->record = record;
    held->record_size = work->record.size;
    append(list, held);
    return held;
}

held_t *held_find(const held_list_t *list, const message_lease_t *lease)
{
    for (held_t *held = list->first; held; held = held->next)
        if (message_lease_equal(&held->lease, lease))
            return held;
    return NULL;
}

void held_remove(held_list_t *list, held_t *held)
{
    detach(list, held);
    destroy(held);
}

void held_drop_record(held_t *held)
{
    free(held->record);
    held->record = NULL;
    held->record_size = 0;
}

void held_finish(held_list_t *list, held_t *held, uint8_t *result, size_t size, const fault_t *fault)
{
    detach(list, held);
    held_drop_record(held);
    held->state = HELD_DONE;
    held->result = result;
    held->result_size = size;
    held->code = fault->code;
    held->text = fault->code ? strdup(fault->text) : NULL; /* without memory the code has to do */
    held->sent = false;
    append(list, held);
    list->done++;
    list->done_bytes += size;
}
