/* accel_core.h: small things in the middle of a large scene, for accel.c alone.
 *
 * Single precision knows a ray to 2^-24 of the coordinates that it starts from: from a wall at 1e5 it misses what
 * it is aimed at by 1e-2. The core of a scene is what has coordinates below 2^-10 of the largest (scenes stand
 * around the origin: path/recentre.h). A ray from outside is traced up to the core's box and from there on again,
 * where its coordinates are small. Most scenes have none.
 *
 * Immutable after accel_core_init; any thread.
 */
#ifndef SCENE_ACCEL_CORE_H
#define SCENE_ACCEL_CORE_H

#include <stdbool.h>

#include "math/vec.h"
#include "scene/scene.h"

typedef struct accel_core {
    double extent; /* largest coordinate of the scene and its camera */
    bool exists;
    vec3_t low, high; /* of the box */
} accel_core_t;

/* Of the extent: by how much the two halves of a ray overlap, so that nothing lies between them. */
#define ACCEL_CORE_OVERLAP 0x1p-22

void accel_core_init(accel_core_t *core, const scene_t *scene);

/* Where a ray that starts outside the box enters it, in units of d; 0 if it does not. The core exists. */
double accel_core_entry(const accel_core_t *core, vec3_t o, vec3_t d);

#endif
