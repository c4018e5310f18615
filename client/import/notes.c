#include "client/import/notes.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct note {
    char text[IMPORT_NOTE_SIZE]; /* without the place */
    char line[2 * IMPORT_NOTE_SIZE];
    char place[256];
    unsigned long times;
} note_t;

struct import_notes {
    note_t *items;
    size_t count, capacity, dropped;
};

import_notes_t *import_notes_new(void)
{
    return calloc(1, sizeof(import_notes_t));
}

void import_notes_destroy(import_notes_t **notes)
{
    if (!*notes)
        return;
    free((*notes)->items);
    free(*notes);
    *notes = NULL;
}

static void write_line(note_t *note)
{
    if (note->times > 1)
        snprintf(note->line, sizeof note->line, "%s: %s (%lu times)", note->place, note->text, note->times);
    else
        snprintf(note->line, sizeof note->line, "%s: %s", note->place, note->text);
}

static note_t *grow(import_notes_t *notes)
{
    if (notes->count == IMPORT_NOTES_MAX)
        return NULL;
    if (notes->count == notes->capacity) {
        const size_t capacity = notes->capacity ? 2 * notes->capacity : 16;
        note_t *items = realloc(notes->items, capacity * sizeof *items);
        if (!items)
            return NULL;
        notes->items = items;
        notes->capacity = capacity;
    }
    return &notes->items[notes->count++];
}

void import_notes_add(import_notes_t *notes, const char *file, int line, const char *format, ...)
{
    if (!notes)
        return;
    char text[IMPORT_NOTE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (size_t i = 0; i < notes->count; i++) {
        note_t *note = &notes->items[i];
        if (strcmp(note->text, text) == 0) {
            note->times++;
            write_line(note);
            return;
        }
    }
    note_t *note = grow(notes);
    if (!note) {
        notes->dropped++;
        return;
    }
    memcpy(note->text, text, sizeof text);
    /* The end of a long path says more than its beginning. */
    const size_t length = strlen(file), room = sizeof note->place - 16;
    snprintf(note->place, sizeof note->place, "%s:%d", length > room ? file + length - room : file, line);
    note->times = 1;
    write_line(note);
}

size_t import_notes_count(const import_notes_t *notes)
{
    return notes->count;
}

const char *import_notes_text(const import_notes_t *notes, size_t index)
{
    return notes->items[index].line;
}

size_t import_notes_dropped(const import_notes_t *notes)
{
    return notes->dropped;
}
