/* scene_source.h: what a job names as its scene, as a bundle file: a bundle as it is, anything else read in this
 * process and packed. */
#ifndef CLIENT_SCENE_SOURCE_H
#define CLIENT_SCENE_SOURCE_H

#include <stdio.h>

#include "base/digest.h"
#include "scene/scene.h"

typedef struct scene_counts {
    uint64_t triangles, vertices, texel_bytes, bundle_bytes;
    uint32_t shapes, materials, textures, images, lights;
} scene_counts_t;

/* Reads the scene file and writes the bundle. What the reader could not honour goes to `notes` (null: nowhere), a
 * line each. *counts may be null. */
fault_code_t scene_source_pack(const char *scene, const char *bundle, FILE *notes, digest_t *digest,
                               scene_counts_t *counts, fault_t *fault);
/* As above, but a scene that is a bundle already is checked and only linked or copied. */
fault_code_t scene_source_bundle(const char *scene, const char *bundle, FILE *notes, digest_t *digest,
                                 scene_counts_t *counts, fault_t *fault);

#endif
