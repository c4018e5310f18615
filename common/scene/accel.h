/* accel.h: ray queries. The only place that knows Embree.
 *
 * Embree finds the primitive in single precision (ROBUST traversal); surface.h computes the hit anew in double.
 * Every ray is checked before the call, because the library aborts on what is not finite: a bad ray is a failure of
 * its path, counted by the caller, never a call.
 *
 * Single precision knows a ray to 2^-24 of the largest coordinate that it starts from. Two things keep in reach
 * what is small: spheres and disks are met in double, by the ray as the caller gave it, and rays from far away are
 * traced anew where they come near (accel_core.h).
 *
 * The corners of triangles are kept a second time, side by side, as rays meet them: a hit in the indexed arrays
 * waits for an index, then for three positions, then for three normals, each somewhere else in memory (water of
 * 65,000 triangles: 13 % of the time of a render). Embree's geometries share the table.
 *
 * Shapes whose material is an interface are not part of the accelerator. A hit on a shape with opacity below one
 * counts with that probability, decided by a hash of the hit, so that it is a function of the ray.
 *
 * Thread rule: immutable after creation; any number of threads.
 */
#ifndef SCENE_ACCEL_H
#define SCENE_ACCEL_H

#include <stdbool.h>

#include "math/vec.h"
#include "scene/scene.h"

typedef struct accel accel_t;

/* `scene` is borrowed for the accelerator's life. */
fault_code_t accel_new(accel_t **out, const scene_t *scene, fault_t *fault);
void accel_destroy(accel_t **accel);

typedef struct accel_hit {
    uint32_t shape, primitive;
    double t; /* in single precision's accuracy, in units of the direction's length */
    /* Of a triangle: its corners from the accelerator's table, as surface.h takes them. Null: only the scene has
     * them.
     */
    const float *corners;
    bool leaves; /* of a sphere: its far side */
} accel_hit_t;

typedef enum accel_answer { ACCEL_MISS = 0, ACCEL_HIT = 1, ACCEL_BAD_RAY = 2 } accel_answer_t;

/* The nearest hit beyond the origin. The origin is already moved off its surface (surface_offset). */
accel_answer_t accel_intersect(const accel_t *accel, vec3_t origin, vec3_t direction, accel_hit_t *hit);

/* The same for a ray that is the line through `place`, the point on the surface that the origin was moved off:
 * where surface_at_hit finds the hit. Spheres and disks are met by that line, as narrow as they may be. */
accel_answer_t accel_intersect_line(const accel_t *accel, vec3_t place, vec3_t origin, vec3_t direction,
                                    accel_hit_t *hit);

/* ACCEL_HIT if something lies on the open segment between two points, both moved off their surfaces. */
accel_answer_t accel_occluded(const accel_t *accel, vec3_t from, vec3_t to);

/* ACCEL_HIT if something lies on the half line. */
accel_answer_t accel_occluded_beyond(const accel_t *accel, vec3_t origin, vec3_t direction);

/* Bytes that Embree and the table of corners hold for the scene. */
size_t accel_bytes(const accel_t *accel);

#endif
