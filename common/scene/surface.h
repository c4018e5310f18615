/* surface.h: the point where a ray meets a primitive, in double precision.
 *
 * Embree's hit is only a name (shape, primitive); here the ray meets that triangle, sphere or disk again in double.
 * The point lies on the primitive: what lies outside its triangle is moved to its nearest edge (8e-6 of hits lie
 * outside by rounding), spheres' points are projected onto the sphere.
 */
#ifndef SCENE_SURFACE_H
#define SCENE_SURFACE_H

#include "math/frame.h"
#include "scene/accel.h"

typedef struct surface {
    vec3_t position;
    vec3_t ng;      /* unit geometric normal, on the shape's outer side (after its flip) */
    vec3_t ns;      /* unit shading normal, on the side of ng */
    double u, v;    /* texture coordinates */
    vec3_t tangent; /* dp/du, any length; zero if `want_uv` was false */
    double epsilon; /* how far a ray must start off the surface: 2^-20 of the primitive's largest coordinate */
    bool moved;     /* to the triangle's edge: the line met its plane outside */
} surface_t;

/* Where the ray (origin on its own surface, not moved) meets the hit primitive. Without want_uv the fields u, v,
 * tangent are not set. False if the primitive is degenerate. */
bool surface_at_hit(const scene_t *scene, const accel_hit_t *hit, vec3_t origin, vec3_t direction, bool want_uv,
                    surface_t *out);

/* A point off the surface, on the side that unit w leaves to. */
static inline vec3_t surface_offset(vec3_t position, vec3_t ng, double epsilon, vec3_t w)
{
    return vec3_mad(position, vec3_dot(ng, w) < 0 ? -epsilon : epsilon, ng);
}

/* Fraction of a primitive's largest coordinate by which rays start off it: single precision keeps 2^-24 of a
 * coordinate, and three roundings (origin, vertices, plane) meet. */
#define SURFACE_EPSILON 0x1p-20

#endif
