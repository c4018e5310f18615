/* recentre.h: scenes that lie far from the origin, moved to it.
 *
 * Embree's coordinates are in single precision, and rays start off a surface by a fraction of its coordinates
 * (SURFACE_EPSILON): 1e5 of its own size away from the origin a scene would be traced with offsets of a tenth of
 * its size. Such a scene is copied and moved; directions, distances and images don't know of it. Vertices lose
 * nothing: of coordinates that are all beyond four times the scene's extent, differences to a round number near
 * their middle are exact in single precision.
 */
#ifndef PATH_RECENTRE_H
#define PATH_RECENTRE_H

#include "scene/scene.h"

/* A copy that owns what differs from the original and borrows the rest. */
typedef struct path_recentred {
    scene_t scene;
    scene_camera_t camera;
    float *positions;
    scene_shape_t *shapes;
    scene_light_t *lights;
} path_recentred_t;

/* *out is null where the scene is near the origin (with this camera, which stands in for its own). */
fault_code_t path_recentre(path_recentred_t **out, const scene_t *scene, const scene_camera_t *camera,
                           fault_t *fault);
void path_recentred_destroy(path_recentred_t **moved);

#endif
