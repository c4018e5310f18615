/* frame.h: an orthonormal frame around a normal. Local directions have z along the normal. */
#ifndef MATH_FRAME_H
#define MATH_FRAME_H

#include "math/vec.h"

typedef struct frame {
    vec3_t s, t, n;
} frame_t;

/* Any frame around the unit vector n (Duff et al.: Building an orthonormal basis, revisited, JCGT 2017). Continuous
 * except where n.z changes sign. */
static inline frame_t frame_of_normal(vec3_t n)
{
    const double sign = copysign(1.0, n.z);
    const double a = -1.0 / (sign + n.z);
    const double b = n.x * n.y * a;
    return (frame_t){{1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

/* The frame around n whose s axis is as near to `tangent` as can be; any frame where they are parallel. */
static inline frame_t frame_of_normal_tangent(vec3_t n, vec3_t tangent)
{
    const vec3_t s = vec3_mad(tangent, -vec3_dot(n, tangent), n);
    const double length = vec3_length(s);
    if (!(length > 1e-8 * vec3_length(tangent))) /* parallel: the tangent says nothing */
        return frame_of_normal(n);
    const vec3_t unit = vec3_scale(s, 1.0 / length);
    return (frame_t){unit, vec3_cross(n, unit), n};
}

static inline vec3_t frame_to_local(const frame_t *f, vec3_t w)
{
    return vec3(vec3_dot(w, f->s), vec3_dot(w, f->t), vec3_dot(w, f->n));
}

static inline vec3_t frame_to_world(const frame_t *f, vec3_t w)
{
    return vec3(w.x * f->s.x + w.y * f->t.x + w.z * f->n.x, w.x * f->s.y + w.y * f->t.y + w.z * f->n.y,
                w.x * f->s.z + w.y * f->t.z + w.z * f->n.z);
}

#endif
