#include "client/import/geometry.h"

#include <stdlib.h>
#include <string.h>

#include "client/import/surfaces.h"

void geometry_clear(geometry_t *geometry)
{
    free(geometry->positions);
    free(geometry->normals);
    free(geometry->uvs);
    free(geometry->indices);
    memset(geometry, 0, sizeof *geometry);
}

void placed_clear(placed_t *placed)
{
    free(placed->positions);
    free(placed->normals);
    free(placed->indices);
    free(placed->uvs_owned);
    memset(placed, 0, sizeof *placed);
}

static void *array_of(uint64_t count, size_t size)
{
    return count < SIZE_MAX / size ? malloc((size_t)(count + 1) * size) : NULL;
}

fault_code_t geometry_new_mesh(geometry_t *out, uint64_t vertices, uint64_t triangles, bool normals, bool uvs,
                               fault_t *fault)
{
    memset(out, 0, sizeof *out);
    if (vertices > SCENE_MAX_VERTICES || triangles > SCENE_MAX_TRIANGLES)
        return fault_set(fault, FAULT_LIMIT, "a mesh of %llu vertices and %llu triangles",
                         (unsigned long long)vertices, (unsigned long long)triangles);
    out->kind = SCENE_SHAPE_MESH;
    out->vertices = vertices;
    out->triangles = triangles;
    out->positions = array_of(3 * vertices, sizeof(float));
    out->normals = normals ? array_of(3 * vertices, sizeof(float)) : NULL;
    out->uvs = uvs ? array_of(2 * vertices, sizeof(float)) : NULL;
    out->indices = array_of(3 * triangles, sizeof(uint32_t));
    if (out->positions && out->indices && (!normals || out->normals) && (!uvs || out->uvs))
        return FAULT_NONE;
    geometry_clear(out);
    return fault_set(fault, FAULT_MEMORY, "no memory for a mesh of %llu triangles", (unsigned long long)triangles);
}

static vec3_t load(const float *v)
{
    return vec3(v[0], v[1], v[2]);
}

static void store(float *to, vec3_t v)
{
    to[0] = (float)v.x;
    to[1] = (float)v.y;
    to[2] = (float)v.z;
}

static bool in_range(vec3_t p)
{
    return vec3_finite(p) && vec3_max_abs(p) < (double)SCENE_MAX_COORDINATE;
}

static fault_code_t out_of_range(vec3_t p, fault_t *fault)
{
    return fault_set(fault, FAULT_RANGE, "a point at (%g, %g, %g): expected coordinates of at most %g", p.x, p.y,
                     p.z, (double)SCENE_MAX_COORDINATE);
}

static fault_code_t place_positions(const geometry_t *g, const transform_t *to_world, placed_t *out, fault_t *fault)
{
    for (uint64_t i = 0; i < g->vertices; i++) {
        const vec3_t p = transform_point(to_world, load(g->positions + 3 * i));
        if (!in_range(p))
            return out_of_range(p, fault);
        store(out->positions + 3 * i, p);
    }
    return FAULT_NONE;
}

/* Unit normals in the world; zero where the mesh says nothing. */
static void place_normals(const geometry_t *g, const transform_t *inverse, bool reverse, placed_t *out)
{
    for (uint64_t i = 0; i < g->vertices; i++) {
        vec3_t n = transform_transposed(inverse, load(g->normals + 3 * i));
        const double scale = vec3_max_abs(n);
        n = isfinite(scale) && scale > 0 ? vec3_unit(vec3_scale(n, 1 / scale)) : vec3(0, 0, 0);
        store(out->normals + 3 * i, reverse ? vec3_neg(n) : n);
    }
}

/* Copies the triangles that have an area, turned to the side of their vertices' normals. */
static void place_triangles(const geometry_t *g, placed_t *out)
{
    for (uint64_t t = 0; t < g->triangles; t++) {
        const uint32_t *from = g->indices + 3 * t;
        const vec3_t p0 = load(out->positions + 3 * (uint64_t)from[0]);
        const vec3_t e1 = vec3_sub(load(out->positions + 3 * (uint64_t)from[1]), p0);
        const vec3_t e2 = vec3_sub(load(out->positions + 3 * (uint64_t)from[2]), p0);
        const vec3_t normal = vec3_cross(e1, e2);
        const double area = 0.5 * vec3_length(normal);
        if (!(area > 0)) {
            out->degenerate += !g->generated;
            continue;
        }
        uint32_t *to = out->indices + 3 * out->triangles++;
        memcpy(to, from, 3 * sizeof *to);
        out->area += area;
        if (!out->normals)
            continue;
        vec3_t sum = load(out->normals + 3 * (uint64_t)from[0]);
        sum = vec3_add(sum, load(out->normals + 3 * (uint64_t)from[1]));
        sum = vec3_add(sum, load(out->normals + 3 * (uint64_t)from[2]));
        if (vec3_dot(sum, normal) < 0) {
            to[1] = from[2];
            to[2] = from[1];
        }
    }
}

/* Vertices without a usable normal take that of a triangle they belong to. */
static void mend_normals(placed_t *out)
{
    for (uint64_t i = 0; i < 3 * out->triangles; i++) {
        float *n = out->normals + 3 * (uint64_t)out->indices[i];
        if (n[0] != 0 || n[1] != 0 || n[2] != 0)
            continue;
        const uint32_t *corner = out->indices + i / 3 * 3;
        const vec3_t p0 = load(out->positions + 3 * (uint64_t)corner[0]);
        const vec3_t e1 = vec3_sub(load(out->positions + 3 * (uint64_t)corner[1]), p0);
        const vec3_t e2 = vec3_sub(load(out->positions + 3 * (uint64_t)corner[2]), p0);
        store(n, vec3_unit(vec3_cross(e1, e2)));
        out->no_normal++;
    }
    for (uint64_t i = 0; i < out->vertices; i++) { /* those that no triangle uses */
        float *n = out->normals + 3 * i;
        if (n[0] == 0 && n[1] == 0 && n[2] == 0)
            n[2] = 1;
    }
}

static fault_code_t place_mesh(const geometry_t *g, const transform_t *to_world, const transform_t *inverse,
                               bool reverse, placed_t *out, fault_t *fault)
{
    out->vertices = g->vertices;
    out->positions = array_of(3 * g->vertices, sizeof(float));
    out->indices = array_of(3 * g->triangles, sizeof(uint32_t));
    out->normals = g->normals ? array_of(3 * g->vertices, sizeof(float)) : NULL;
    out->uvs = g->uvs;
    if (!out->positions || !out->indices || (g->normals && !out->normals))
        return fault_set(fault, FAULT_MEMORY, "no memory for a mesh of %llu triangles",
                         (unsigned long long)g->triangles);
    TRY(place_positions(g, to_world, out, fault));
    if (out->normals)
        place_normals(g, inverse, reverse, out);
    place_triangles(g, out);
    if (out->normals)
        mend_normals(out);
    else if (reverse != (transform_determinant(to_world) < 0))
        out->shape.flags |= SCENE_SHAPE_FLIP;
    return FAULT_NONE;
}

/* A sphere or disk under a rotation, mirror image and scale. */
static fault_code_t place_exact(const geometry_t *g, const transform_t *to_world, const transform_t *inverse,
                                double scale, bool reverse, placed_t *out, fault_t *fault)
{
    const vec3_t centre = transform_point(to_world, vec3(0, 0, g->kind == SCENE_SHAPE_DISK ? g->height : 0));
    const double radius = scale * g->radius;
    if (!in_range(centre) || !(radius < (double)SCENE_MAX_COORDINATE))
        return out_of_range(centre, fault);
    if (!((float)radius > 0))
        return fault_set(fault, FAULT_RANGE, "a radius of %g", radius);
    const vec3_t axis = vec3_unit(transform_transposed(inverse, vec3(0, 0, 1)));
    vec3_t tangent = transform_vector(to_world, vec3(1, 0, 0));
    tangent = vec3_unit(vec3_mad(tangent, -vec3_dot(tangent, axis), axis));
    store(out->shape.centre, centre);
    store(out->shape.normal, axis);
    store(out->shape.tangent, tangent);
    out->shape.radius = (float)radius;
    out->shape.flags = reverse ? SCENE_SHAPE_FLIP : 0;
    out->area = (g->kind == SCENE_SHAPE_SPHERE ? 4 : 1) * MATH_PI * radius * radius;
    return FAULT_NONE;
}

static fault_code_t place_tessellated(const geometry_t *g, const transform_t *to_world, const transform_t *inverse,
                                      bool reverse, placed_t *out, fault_t *fault)
{
    geometry_t mesh;
    TRY(g->kind == SCENE_SHAPE_SPHERE ? surfaces_sphere(&mesh, g->radius, -g->radius, g->radius, 2 * MATH_PI, fault)
                                      : surfaces_disk(&mesh, g->height, g->radius, 0, 2 * MATH_PI, fault));
    out->shape.kind = SCENE_SHAPE_MESH;
    out->tessellated = true;
    const fault_code_t code = place_mesh(&mesh, to_world, inverse, reverse, out, fault);
    out->uvs_owned = mesh.uvs; /* goes over to the placed shape */
    mesh.uvs = NULL;
    geometry_clear(&mesh);
    return code;
}

fault_code_t geometry_place(const geometry_t *geometry, const transform_t *to_world, bool reverse, placed_t *out,
                            fault_t *fault)
{
    memset(out, 0, sizeof *out);
    transform_t inverse;
    double scale;
    if (!transform_affine(to_world) || !transform_invert(to_world, &inverse))
        return fault_set(fault, FAULT_RANGE, "the shape's transformation is %s",
                         transform_affine(to_world) ? "singular" : "not affine");
    out->shape.kind = geometry->kind;
    out->shape.area_light = SCENE_NONE;
    out->shape.alpha = (scene_param_t){{1, 1, 1}, SCENE_NONE};
    fault_code_t code;
    if (geometry->kind == SCENE_SHAPE_MESH)
        code = place_mesh(geometry, to_world, &inverse, reverse, out, fault);
    else if (transform_similarity(to_world, &scale))
        code = place_exact(geometry, to_world, &inverse, scale, reverse, out, fault);
    else
        code = place_tessellated(geometry, to_world, &inverse, reverse, out, fault);
    if (code)
        placed_clear(out);
    return code;
}

/* Whether every vertex normal is its triangles' own, to an angle of 1e-5 (single precision and six printed digits
 * make that much): then they say nothing, and shading need not interpolate them. */
static bool normals_are_flat(const placed_t *placed)
{
    const double least = 1 - 0.5e-10;
    for (uint64_t t = 0; t < placed->triangles; t++) {
        vec3_t p[3];
        for (int i = 0; i < 3; i++) {
            const float *from = placed->positions + 3 * (size_t)placed->indices[3 * t + (uint64_t)i];
            p[i] = vec3(from[0], from[1], from[2]);
        }
        const vec3_t n = vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));
        const double length = vec3_length(n);
        for (int i = 0; i < 3; i++) {
            const float *from = placed->normals + 3 * (size_t)placed->indices[3 * t + (uint64_t)i];
            const vec3_t normal = vec3(from[0], from[1], from[2]);
            if (!(vec3_dot(n, normal) >= least * length * vec3_length(normal)))
                return false;
        }
    }
    return true;
}

fault_code_t geometry_add(const placed_t *placed, scene_builder_t *builder, fault_t *fault)
{
    uint32_t index;
    if (placed->shape.kind != SCENE_SHAPE_MESH)
        return scene_builder_add_shape(builder, &placed->shape, &index, fault);
    const float *normals = placed->normals && !normals_are_flat(placed) ? placed->normals : NULL;
    return scene_builder_add_mesh(builder, &placed->shape, placed->positions, normals, placed->uvs,
                                  placed->vertices, placed->indices, placed->triangles, &index, fault);
}
