/* accel_fixture.h: what tests of ray queries share: closed shapes of any size at any distance, points and
 * directions from a stream. */
#ifndef TESTS_SCENE_ACCEL_FIXTURE_H
#define TESTS_SCENE_ACCEL_FIXTURE_H

#include "math/sampling.h"
#include "scene/accel.h"
#include "support/small_scenes.h"

/* Fails the test if there is none; the caller destroys. */
accel_t *accel_of(const scene_t *scene);

vec3_t of_floats(const float *p);
/* In the cube [-half, half]^3. */
vec3_t stream_point(stream_t *stream, double half);
/* A unit direction at the given cosine to the normal. */
vec3_t direction_at(stream_t *stream, vec3_t normal, double cosine);

/* A shape's size, and its distance from the origin in that unit. */
typedef struct placement {
    double scale, shift;
} placement_t;
enum { PLACEMENTS = 6 };
extern const placement_t placements[PLACEMENTS];

/* The cube of half width 1 with outward normals, or the sphere of radius 1. */
void closed_make(small_scene_t *closed, bool sphere, const placement_t *placement);
/* A point of it, rounded to single precision. */
vec3_t placed_point(const placement_t *placement, vec3_t p);

#endif
