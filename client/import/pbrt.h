/* pbrt.h: reads scene files of pbrt-v4.
 *
 *     scene_builder_t *builder = scene_builder_new();
 *     import_notes_t *notes = import_notes_new();
 *     if (pbrt_read("scene.pbrt", builder, notes, &fault))
 *         fprintf(stderr, "garland: %s\n", fault.text);       // scene.pbrt:12:5: what is wrong
 *
 * What is read, and how each thing is honoured or approximated, stands in docs/scenes.md; what a file asks for and
 * does not get is said in the notes. A scene that is read passes scene_check.
 *
 * Faults name file, line and column. Files may be compressed (gzip). Any number of threads may read, each into its
 * own builder.
 */
#ifndef IMPORT_PBRT_H
#define IMPORT_PBRT_H

#include <stddef.h>

#include "base/fault.h"
#include "client/import/notes.h"
#include "scene/builder.h"

/* Reads the scene into an empty builder; notes may be null. After a fault the builder holds part of the scene. */
fault_code_t pbrt_read(const char *path, scene_builder_t *builder, import_notes_t *notes, fault_t *fault);

/* The same from text in memory (borrowed). `name` stands for the file in messages; files that the scene names are
 * looked for in `folder`. */
fault_code_t pbrt_read_text(const char *name, const char *folder, const char *text, size_t size,
                            scene_builder_t *builder, import_notes_t *notes, fault_t *fault);

#endif
