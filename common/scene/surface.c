#include "scene/surface.h"

#include <string.h>

#include "math/triangle.h"

static vec3_t surface_vec(const float *p)
{
    return vec3(p[0], p[1], p[2]);
}

/* dp/du of a triangle from its corners' texture coordinates; zero where they are degenerate. */
static vec3_t surface_triangle_tangent(vec3_t e1, vec3_t e2, double du1, double dv1, double du2, double dv2)
{
    const double determinant = du1 * dv2 - dv1 * du2;
    if (determinant == 0)
        return e1;
    return vec3_scale(vec3_sub(vec3_scale(e1, dv2), vec3_scale(e2, dv1)), 1 / determinant);
}

/* Three corners, each a position and, where the shape has them, a normal. */
static const float *surface_gather(const scene_t *scene, const scene_shape_t *shape, uint32_t primitive, float *to)
{
    const uint32_t *corner = scene->indices + 3 * ((size_t)shape->first_triangle + primitive);
    const bool normals = (shape->flags & SCENE_SHAPE_NORMALS) != 0;
    float *at = to;
    for (int i = 0; i < 3; i++) {
        const size_t vertex = shape->first_vertex + (size_t)corner[i];
        memcpy(at, scene->positions + 3 * vertex, 3 * sizeof(float));
        if (normals)
            memcpy(at + 3, scene->normals + 3 * vertex, 3 * sizeof(float));
        at += normals ? 6 : 3;
    }
    return to;
}

static bool surface_triangle(const scene_t *scene, const scene_shape_t *shape, const accel_hit_t *hit,
                             vec3_t origin, vec3_t direction, bool want_uv, surface_t *out)
{
    float gathered[18];
    const float *corners = hit->corners ? hit->corners : surface_gather(scene, shape, hit->primitive, gathered);
    const int stride = shape->flags & SCENE_SHAPE_NORMALS ? 6 : 3;
    const vec3_t p0 = surface_vec(corners), p1 = surface_vec(corners + stride),
                 p2 = surface_vec(corners + 2 * stride);
    const vec3_t e1 = vec3_sub(p1, p0), e2 = vec3_sub(p2, p0);
    const vec3_t n = vec3_cross_exact(e1, e2);
    const double n2 = vec3_dot(n, n), det = vec3_dot(n, direction);
    if (!(n2 > 0) || det == 0)
        return false;
    /* Moeller and Trumbore 1997 with the normal at hand: b1 = -((q x d).e2) / (n.d), b2 = ((q x d).e1) / (n.d),
     * q = origin - p0. */
    const vec3_t q = vec3_sub(origin, p0), r = vec3_cross(q, direction);
    const double inverse = 1 / det;
    double b1 = -vec3_dot(r, e2) * inverse, b2 = vec3_dot(r, e1) * inverse;
    /* b1 e1 + b2 e2 = (n x r) / (n.d), which keeps its precision where the edges are all but parallel */
    vec3_t offset = vec3_scale(vec3_cross(n, r), inverse);
    out->moved = b1 < 0 || b2 < 0 || b1 + b2 > 1;
    if (__builtin_expect(out->moved, 0)) { /* outside by rounding: to the triangle's edge */
        const vec2_t b = triangle_nearest(e1, e2, offset);
        b1 = b.x;
        b2 = b.y;
        offset = vec3_mad(vec3_scale(e1, b1), b2, e2);
    }
    out->position = vec3_add(p0, offset);
    out->epsilon = SURFACE_EPSILON * math_max(vec3_max_abs(p0), math_max(vec3_max_abs(p1), vec3_max_abs(p2)));
    out->ng = vec3_scale(n, (shape->flags & SCENE_SHAPE_FLIP ? -1 : 1) / sqrt(n2));
    out->ns = out->ng;
    if (shape->flags & SCENE_SHAPE_NORMALS) {
        const vec3_t n0 = surface_vec(corners + 3), n1 = surface_vec(corners + 9), n2v = surface_vec(corners + 15);
        const vec3_t ns = vec3_mad(vec3_mad(vec3_scale(n0, 1 - b1 - b2), b1, n1), b2, n2v);
        const double length2 = vec3_dot(ns, ns);
        if (length2 > 1e-12) /* else the corners cancel and say nothing */
            out->ns = vec3_scale(ns, (vec3_dot(ns, out->ng) < 0 ? -1 : 1) / sqrt(length2));
    }
    if (want_uv) {
        if (shape->flags & SCENE_SHAPE_UVS) {
            const uint32_t *corner = scene->indices + 3 * ((size_t)shape->first_triangle + hit->primitive);
            const float *uvs = scene->uvs + 2 * (size_t)shape->first_vertex;
            const float *t0 = uvs + 2 * (size_t)corner[0], *t1 = uvs + 2 * (size_t)corner[1],
                        *t2 = uvs + 2 * (size_t)corner[2];
            const double u0 = t0[0], v0 = t0[1];
            const double du1 = t1[0] - u0, dv1 = t1[1] - v0, du2 = t2[0] - u0, dv2 = t2[1] - v0;
            out->u = u0 + b1 * du1 + b2 * du2;
            out->v = v0 + b1 * dv1 + b2 * dv2;
            out->tangent = surface_triangle_tangent(e1, e2, du1, dv1, du2, dv2);
        } else { /* (0,0), (1,0), (1,1) */
            out->u = b1 + b2;
            out->v = b2;
            out->tangent = e1;
        }
    }
    return true;
}

static bool surface_sphere(const scene_shape_t *shape, bool leaves, vec3_t origin, vec3_t direction, bool want_uv,
                           surface_t *out)
{
    const vec3_t centre = surface_vec(shape->centre);
    const double radius = shape->radius;
    const vec3_t f = vec3_sub(origin, centre);
    const double a = vec3_dot(direction, direction), b = -vec3_dot(f, direction) / a;
    const vec3_t l = vec3_mad(f, b, direction); /* from the centre to the line's nearest point */
    const double discriminant = math_max(0, radius * radius - vec3_dot(l, l));
    const double half = sqrt(discriminant / a);
    const double t = leaves ? b + half : b - half;
    const vec3_t p = vec3_mad(f, t, direction);
    const vec3_t n = vec3_unit(p);
    out->position = vec3_mad(centre, radius, n);
    out->epsilon = SURFACE_EPSILON * (vec3_max_abs(centre) + radius);
    out->moved = false;
    out->ng = shape->flags & SCENE_SHAPE_FLIP ? vec3_neg(n) : n;
    out->ns = out->ng;
    if (want_uv) {
        const vec3_t axis = surface_vec(shape->normal), zero = surface_vec(shape->tangent);
        const double z = vec3_dot(n, axis), x = vec3_dot(n, zero), y = vec3_dot(n, vec3_cross(axis, zero));
        const double phi = atan2(y, x);
        out->u = (phi < 0 ? phi + 2 * MATH_PI : phi) * (0.5 * MATH_INV_PI);
        /* pbrt: v = (theta - theta_zmin) / (theta_zmax - theta_zmin), theta_zmin = pi at the south pole */
        out->v = 1 - acos(z < -1 ? -1 : z > 1 ? 1 : z) * MATH_INV_PI;
        out->tangent = vec3_cross(axis, n);
    }
    return true;
}

static bool surface_disk(const scene_shape_t *shape, vec3_t origin, vec3_t direction, bool want_uv, surface_t *out)
{
    const vec3_t centre = surface_vec(shape->centre), n = vec3_unit(surface_vec(shape->normal));
    const vec3_t f = vec3_sub(origin, centre);
    const double cosine = vec3_dot(n, direction);
    if (cosine == 0)
        return false;
    vec3_t p = vec3_mad(f, -vec3_dot(n, f) / cosine, direction);
    p = vec3_mad(p, -vec3_dot(p, n), n);
    const double r = vec3_length(p), radius = shape->radius;
    if (r > radius)
        p = vec3_scale(p, radius / r);
    out->position = vec3_add(centre, p);
    out->epsilon = SURFACE_EPSILON * (vec3_max_abs(centre) + radius);
    out->moved = false;
    out->ng = shape->flags & SCENE_SHAPE_FLIP ? vec3_neg(n) : n;
    out->ns = out->ng;
    if (want_uv) {
        const vec3_t zero = surface_vec(shape->tangent);
        const double phi = atan2(vec3_dot(p, vec3_cross(n, zero)), vec3_dot(p, zero));
        out->u = (phi < 0 ? phi + 2 * MATH_PI : phi) * (0.5 * MATH_INV_PI);
        out->v = 1 - math_min(1, r / radius);
        out->tangent = vec3_cross(n, p);
    }
    return true;
}

bool surface_at_hit(const scene_t *scene, const accel_hit_t *hit, vec3_t origin, vec3_t direction, bool want_uv,
                    surface_t *out)
{
    const scene_shape_t *shape = &scene->shapes[hit->shape];
    switch (shape->kind) {
    case SCENE_SHAPE_MESH:
        return surface_triangle(scene, shape, hit, origin, direction, want_uv, out);
    case SCENE_SHAPE_SPHERE:
        return surface_sphere(shape, hit->leaves, origin, direction, want_uv, out);
    default:
        return surface_disk(shape, origin, direction, want_uv, out);
    }
}
