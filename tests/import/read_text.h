/* read_text.h: for tests of client/import: scene texts in a temporary folder, read into a builder. */
#ifndef TESTS_IMPORT_READ_TEXT_H
#define TESTS_IMPORT_READ_TEXT_H

#include <stddef.h>

#include "client/import/pbrt.h"

typedef struct reading {
    scene_builder_t *builder;
    import_notes_t *notes;
    scene_t scene;
    fault_t fault;
    fault_code_t code;
} reading_t;

/* A list of strings that ends with null, for read_world_fails. */
#define WORDS(...) ((const char *const[]){__VA_ARGS__, NULL})

/* The temporary folder; made at the first call, removed by read_text_clean, a group's teardown. */
const char *read_text_folder(void);
int read_text_clean(void **state);
/* Writes a file there. */
void read_text_write(const char *name, const void *data, size_t size);

/* Reads the text as "test.pbrt" in that folder. */
reading_t read_text(const char *text);
/* `world` after a small camera and WorldBegin in line 1: the world's first line is line 2. Fails the test on a
 * fault. */
reading_t read_world(const char *world);
/* The same, but expects a fault whose text contains all of `words` (null-terminated list of strings). */
void read_world_fails(const char *world, fault_code_t code, const char *const *words);
void reading_end(reading_t *reading);

/* True if some note contains the text. */
int reading_notes(const reading_t *reading, const char *text);

#endif
