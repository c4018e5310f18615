/* notes.h: what a reader could not honour, said once.
 *
 * A note is one line, "file:line: text". The same text is kept once, with the place where it first applied and
 * the number of times it did. At most IMPORT_NOTES_MAX distinct notes are kept; the rest are counted.
 *
 *     import_notes_t *notes = import_notes_new();
 *     pbrt_read(path, builder, notes, &fault);
 *     for (size_t i = 0; i < import_notes_count(notes); i++)
 *         puts(import_notes_text(notes, i));
 *
 * One thread at a time.
 */
#ifndef IMPORT_NOTES_H
#define IMPORT_NOTES_H

#include <stddef.h>

enum { IMPORT_NOTES_MAX = 500, IMPORT_NOTE_SIZE = 512 };

typedef struct import_notes import_notes_t;

import_notes_t *import_notes_new(void); /* null when out of memory */
void import_notes_destroy(import_notes_t **notes);

/* Adds a note; `notes` may be null (it is dropped then). */
void import_notes_add(import_notes_t *notes, const char *file, int line, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

size_t import_notes_count(const import_notes_t *notes);
/* "file:line: text", with "(n times)" at its end where it applied more than once. Borrowed until the next add. */
const char *import_notes_text(const import_notes_t *notes, size_t index);
/* How many notes found no room. */
size_t import_notes_dropped(const import_notes_t *notes);

#endif
