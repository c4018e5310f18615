/* bundle.h: a scene in one file: validated, versioned, named by the hash of its content.
 *
 * Layout (little endian; docs/bundle.md has the table): a header of fixed size with magic, format version, total
 * size, number of sections; a table of sections (id, record size, offset, count); the sections, each aligned to 64
 * bytes, holding the arrays of scene.h as they are in memory; last 32 bytes: BLAKE2b-256 of all before. Opening
 * maps the file read-only, checks the hash, the header, the table and then everything in it (scene_check): a bundle
 * cut short or with any bit flipped is refused with what is wrong.
 *
 * The bundle's digest, by which master and workers name it, is the hash in its last 32 bytes.
 */
#ifndef SCENE_BUNDLE_H
#define SCENE_BUNDLE_H

#include <stdbool.h>

#include "base/digest.h"
#include "scene/scene.h"

enum { BUNDLE_VERSION = 1 };

typedef struct bundle bundle_t; /* opaque: the mapping; immutable, any thread */

/* The scene as bundle bytes; *data is the caller's to free(). */
fault_code_t bundle_encode(const scene_t *scene, uint8_t **data, size_t *size, digest_t *digest, fault_t *fault);
/* Checks the scene, then encodes to the file (written beside and renamed). */
fault_code_t bundle_save(const scene_t *scene, const char *path, digest_t *digest, fault_t *fault);

fault_code_t bundle_open(bundle_t **out, const char *path, fault_t *fault);
/* From memory that the bundle borrows until it is destroyed; data must be aligned to 64 bytes. */
fault_code_t bundle_open_memory(bundle_t **out, const void *data, size_t size, fault_t *fault);
void bundle_destroy(bundle_t **bundle);

const scene_t *bundle_scene(const bundle_t *bundle); /* valid for the bundle's life */
const digest_t *bundle_digest(const bundle_t *bundle);
/* The whole file's bytes, for sending. */
const uint8_t *bundle_bytes(const bundle_t *bundle, size_t *size);

/* True if the file begins with a bundle's magic: what a job names may be a bundle or a scene file. */
bool bundle_probe(const char *path);

#endif
