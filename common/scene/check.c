#include "scene/check.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>

#include "scene/light.h"

/* ---- messages and numbers ---- */

void check_begin(check_t *c, const char *kind, uint64_t index)
{
    snprintf(c->record, sizeof c->record, "%s %llu", kind, (unsigned long long)index);
}

fault_code_t check_refuse(check_t *c, fault_code_t code, const char *format, ...)
{
    char text[256];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return fault_set(c->fault, code, "%s: %s", c->record, text);
}

fault_code_t check_number(check_t *c, const char *field, double value, double lo, double hi)
{
    if (value >= lo && value <= hi)
        return FAULT_NONE;
    return check_refuse(c, FAULT_RANGE, "%s is %g, expected %g to %g", field, value, lo, hi);
}

fault_code_t check_numbers(check_t *c, const char *field, const float *values, int count, double lo, double hi)
{
    for (int i = 0; i < count; i++)
        if (!((double)values[i] >= lo && (double)values[i] <= hi))
            return check_refuse(c, FAULT_RANGE, "%s[%d] is %g, expected %g to %g", field, i, (double)values[i], lo,
                                hi);
    return FAULT_NONE;
}

fault_code_t check_word(check_t *c, const char *field, uint32_t value, uint32_t limit)
{
    if (value < limit)
        return FAULT_NONE;
    return check_refuse(c, FAULT_RANGE, "%s is %u, expected 0 to %u", field, value, limit - 1);
}

fault_code_t check_index(check_t *c, const char *field, int32_t index, uint32_t count, int optional)
{
    if ((index >= 0 && (uint32_t)index < count) || (optional && index == SCENE_NONE))
        return FAULT_NONE;
    return check_refuse(c, FAULT_RANGE, "%s is %d, expected an index below %u%s", field, index, count,
                        optional ? " or -1" : "");
}

fault_code_t check_param(check_t *c, const char *field, const scene_param_t *param, uint32_t textures)
{
    TRY(check_numbers(c, field, param->value, 3, 0, 1));
    if (param->texture < 0 ? param->texture == SCENE_NONE : (uint32_t)param->texture < textures)
        return FAULT_NONE;
    return check_refuse(c, FAULT_RANGE, "%s has the texture %d, expected an index below %u or -1", field,
                        param->texture, textures);
}

static double dot3(const float *a, const float *b)
{
    return (double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2];
}

static bool is_unit(const float *v)
{
    return fabs(sqrt(dot3(v, v)) - 1.0) <= CHECK_UNIT_TOLERANCE;
}

static fault_code_t check_unit(check_t *c, const char *field, const float *v)
{
    if (is_unit(v))
        return FAULT_NONE;
    return check_refuse(c, FAULT_RANGE, "%s (%g, %g, %g) has the length %g, expected 1", field, (double)v[0],
                        (double)v[1], (double)v[2], sqrt(dot3(v, v)));
}

/* ---- counts ---- */

static fault_code_t check_array(check_t *c, const char *what, const void *array, uint64_t count, uint64_t limit)
{
    if (count > limit)
        return fault_set(c->fault, FAULT_LIMIT, "the scene has %llu %s, more than the %llu allowed",
                         (unsigned long long)count, what, (unsigned long long)limit);
    if (count > 0 && !array)
        return fault_set(c->fault, FAULT_FORMAT, "the scene has no array for its %llu %s",
                         (unsigned long long)count, what);
    return FAULT_NONE;
}

static fault_code_t check_counts(check_t *c)
{
    const scene_t *s = c->scene;
    TRY(check_array(c, "vertices", s->positions, s->vertex_count, SCENE_MAX_VERTICES));
    TRY(check_array(c, "triangles", s->indices, s->triangle_count, SCENE_MAX_TRIANGLES));
    TRY(check_array(c, "shapes", s->shapes, s->shape_count, SCENE_MAX_SHAPES));
    TRY(check_array(c, "materials", s->materials, s->material_count, SCENE_MAX_MATERIALS));
    TRY(check_array(c, "textures", s->textures, s->texture_count, SCENE_MAX_TEXTURES));
    TRY(check_array(c, "images", s->images, s->image_count, SCENE_MAX_IMAGES));
    TRY(check_array(c, "bytes of texels", s->texels, s->texel_bytes, SCENE_MAX_TEXEL_BYTES));
    return check_array(c, "lights", s->lights, s->light_count, SCENE_MAX_LIGHTS);
}

/* ---- shapes ---- */

/* Meshes follow each other in the arrays: no vertex belongs to two, none to nobody. */
static fault_code_t check_mesh_ranges(check_t *c, const scene_shape_t *s, uint64_t vertex, uint64_t triangle)
{
    const scene_t *scene = c->scene;
    if (s->first_vertex != vertex || s->first_triangle != triangle)
        return check_refuse(
            c, FAULT_FORMAT,
            "begins at vertex %u and triangle %u, expected %llu and %llu, the end of the mesh before",
            s->first_vertex, s->first_triangle, (unsigned long long)vertex, (unsigned long long)triangle);
    if (s->vertices > scene->vertex_count - vertex)
        return check_refuse(c, FAULT_RANGE, "%u vertices from vertex %u on, the scene has %llu", s->vertices,
                            s->first_vertex, (unsigned long long)scene->vertex_count);
    if (s->triangles > scene->triangle_count - triangle)
        return check_refuse(c, FAULT_RANGE, "%u triangles from triangle %u on, the scene has %llu", s->triangles,
                            s->first_triangle, (unsigned long long)scene->triangle_count);
    if (s->triangles == 0)
        return check_refuse(c, FAULT_RANGE, "a mesh without triangles");
    if ((s->flags & SCENE_SHAPE_NORMALS) && !scene->normals)
        return check_refuse(c, FAULT_FORMAT, "has vertex normals, the scene has none");
    if ((s->flags & SCENE_SHAPE_UVS) && !scene->uvs)
        return check_refuse(c, FAULT_FORMAT, "has texture coordinates, the scene has none");
    return FAULT_NONE;
}

static fault_code_t check_mesh_vertices(check_t *c, const scene_shape_t *s)
{
    const scene_t *scene = c->scene;
    for (uint64_t i = 0; i < s->vertices; i++) {
        const uint64_t v = s->first_vertex + i;
        const float *p = scene->positions + 3 * v;
        for (int k = 0; k < 3; k++)
            if (!(fabsf(p[k]) < SCENE_MAX_COORDINATE))
                return check_refuse(
                    c, FAULT_RANGE, "vertex %llu lies at (%g, %g, %g), expected magnitudes below %g",
                    (unsigned long long)i, (double)p[0], (double)p[1], (double)p[2], (double)SCENE_MAX_COORDINATE);
        if ((s->flags & SCENE_SHAPE_NORMALS) && !is_unit(scene->normals + 3 * v))
            return check_refuse(c, FAULT_RANGE, "the normal of vertex %llu is not of unit length",
                                (unsigned long long)i);
        if ((s->flags & SCENE_SHAPE_UVS) && !(fabsf(scene->uvs[2 * v]) < SCENE_MAX_COORDINATE &&
                                              fabsf(scene->uvs[2 * v + 1]) < SCENE_MAX_COORDINATE))
            return check_refuse(c, FAULT_RANGE,
                                "the texture coordinates of vertex %llu are not finite or too large",
                                (unsigned long long)i);
    }
    return FAULT_NONE;
}

static fault_code_t check_mesh_indices(check_t *c, const scene_shape_t *s)
{
    const uint32_t *indices = c->scene->indices + 3 * (uint64_t)s->first_triangle;
    for (uint64_t i = 0; i < 3 * (uint64_t)s->triangles; i++)
        if (indices[i] >= s->vertices)
            return check_refuse(c, FAULT_RANGE, "index %u of triangle %llu is beyond its %u vertices", indices[i],
                                (unsigned long long)(i / 3), s->vertices);
    return FAULT_NONE;
}

static fault_code_t check_round(check_t *c, const scene_shape_t *s)
{
    if (s->flags & (SCENE_SHAPE_NORMALS | SCENE_SHAPE_UVS))
        return check_refuse(c, FAULT_FORMAT, "flags %u, expected no vertex data on a sphere or disk", s->flags);
    TRY(check_number(c, "radius", (double)s->radius, FLT_MIN, (double)SCENE_MAX_COORDINATE));
    TRY(check_numbers(c, "centre", s->centre, 3, -(double)SCENE_MAX_COORDINATE, (double)SCENE_MAX_COORDINATE));
    TRY(check_unit(c, "normal", s->normal));
    TRY(check_unit(c, "tangent", s->tangent));
    if (!(fabs(dot3(s->normal, s->tangent)) <= CHECK_UNIT_TOLERANCE))
        return check_refuse(c, FAULT_RANGE, "normal and tangent are not perpendicular, their product is %g",
                            dot3(s->normal, s->tangent));
    return FAULT_NONE;
}

static fault_code_t check_shape(check_t *c, const scene_shape_t *s)
{
    const scene_t *scene = c->scene;
    TRY(check_word(c, "kind", s->kind, SCENE_SHAPE_DISK + 1));
    TRY(check_word(c, "flags", s->flags, 8));
    TRY(check_index(c, "material", s->material, scene->material_count, false));
    TRY(check_index(c, "area light", s->area_light, scene->light_count, true));
    if (s->area_light >= 0 && scene->lights[s->area_light].kind != SCENE_LIGHT_AREA)
        return check_refuse(c, FAULT_FORMAT, "its area light %d is of another kind", s->area_light);
    TRY(check_param(c, "alpha", &s->alpha, scene->texture_count));
    TRY(check_numbers(c, "centre", s->centre, 3, -FLT_MAX, FLT_MAX));
    TRY(check_number(c, "radius", (double)s->radius, 0, FLT_MAX));
    TRY(check_numbers(c, "normal", s->normal, 3, -FLT_MAX, FLT_MAX));
    TRY(check_numbers(c, "tangent", s->tangent, 3, -FLT_MAX, FLT_MAX));
    if (!(s->pad0 == 0 && s->pad1 == 0))
        return check_refuse(c, FAULT_FORMAT, "reserved bytes are not zero");
    return FAULT_NONE;
}

static fault_code_t check_shapes(check_t *c)
{
    const scene_t *scene = c->scene;
    uint64_t vertex = 0, triangle = 0;
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const scene_shape_t *s = &scene->shapes[i];
        check_begin(c, "shape", i);
        TRY(check_shape(c, s));
        if (s->kind != SCENE_SHAPE_MESH) {
            TRY(check_round(c, s));
            continue;
        }
        TRY(check_mesh_ranges(c, s, vertex, triangle));
        TRY(check_mesh_vertices(c, s));
        TRY(check_mesh_indices(c, s));
        vertex += s->vertices;
        triangle += s->triangles;
    }
    if (vertex != scene->vertex_count || triangle != scene->triangle_count)
        return fault_set(c->fault, FAULT_FORMAT,
                         "the meshes have %llu vertices and %llu triangles, the scene has %llu and %llu",
                         (unsigned long long)vertex, (unsigned long long)triangle,
                         (unsigned long long)scene->vertex_count, (unsigned long long)scene->triangle_count);
    return FAULT_NONE;
}

/* ---- lights ---- */

/* Rows of a rotation, mirrored or not. */
static fault_code_t check_rotation(check_t *c, const float rows[9])
{
    for (int i = 0; i < 3; i++) {
        const float *row = rows + 3 * i, *next = rows + 3 * ((i + 1) % 3);
        TRY(check_unit(c, "row of to_light", row));
        if (!(fabs(dot3(row, next)) <= CHECK_UNIT_TOLERANCE))
            return check_refuse(c, FAULT_RANGE, "rows of to_light are not perpendicular, their product is %g",
                                dot3(row, next));
    }
    return FAULT_NONE;
}

static fault_code_t check_infinite(check_t *c, const scene_light_t *l)
{
    TRY(check_rotation(c, l->to_light));
    if (l->image >= 0) {
        const scene_image_t *image = &c->scene->images[l->image];
        if (image->width != image->height)
            return check_refuse(c, FAULT_FORMAT, "its image %d has %u x %u texels, expected a square", l->image,
                                image->width, image->height);
    }
    return FAULT_NONE;
}

static fault_code_t check_light(check_t *c, const scene_light_t *l)
{
    TRY(check_word(c, "kind", l->kind, SCENE_LIGHT_KINDS));
    TRY(check_word(c, "two_sided", l->two_sided, 2));
    TRY(check_numbers(c, "radiance", l->radiance, 3, 0, FLT_MAX));
    TRY(check_numbers(c, "position", l->position, 3, -(double)SCENE_MAX_COORDINATE, (double)SCENE_MAX_COORDINATE));
    TRY(check_numbers(c, "direction", l->direction, 3, -2, 2));
    TRY(check_numbers(c, "to_light", l->to_light, 9, -2, 2));
    TRY(check_number(c, "cos_end", (double)l->cos_end, -1, 1));
    TRY(check_number(c, "cos_start", (double)l->cos_start, (double)l->cos_end, 1));
    TRY(check_index(c, "image", l->image, l->kind == SCENE_LIGHT_INFINITE ? c->scene->image_count : 0, true));
    if (l->pad[0] | l->pad[1] | l->pad[2])
        return check_refuse(c, FAULT_FORMAT, "reserved bytes are not zero");
    if (l->kind == SCENE_LIGHT_INFINITE)
        return check_infinite(c, l);
    if (l->kind == SCENE_LIGHT_DISTANT || l->kind == SCENE_LIGHT_SPOT)
        return check_unit(c, "direction", l->direction);
    return FAULT_NONE;
}

static fault_code_t check_lights(check_t *c)
{
    int infinite = 0;
    for (uint32_t i = 0; i < c->scene->light_count; i++) {
        const scene_light_t *l = &c->scene->lights[i];
        check_begin(c, "light", i);
        TRY(check_light(c, l));
        if (l->kind == SCENE_LIGHT_INFINITE && ++infinite > LIGHT_MAX_INFINITE)
            return check_refuse(c, FAULT_LIMIT, "more than %d infinite lights", LIGHT_MAX_INFINITE);
    }
    return FAULT_NONE;
}

/* ---- camera ---- */

/* The columns of the matrix span a volume: relative to their lengths, so that scale does not matter. */
static fault_code_t check_camera_matrix(check_t *c, const double m[12])
{
    double length[3];
    for (int k = 0; k < 12; k++)
        TRY(check_number(c, "an entry of to_world", m[k], -(double)SCENE_MAX_COORDINATE,
                         (double)SCENE_MAX_COORDINATE));
    for (int k = 0; k < 3; k++) {
        length[k] = sqrt(m[k] * m[k] + m[4 + k] * m[4 + k] + m[8 + k] * m[8 + k]);
        TRY(check_number(c, "the length of a column of to_world", length[k], 1e-12, 1e12));
    }
    const double det = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
                       m[2] * (m[4] * m[9] - m[5] * m[8]);
    const double volume = fabs(det) / (length[0] * length[1] * length[2]);
    if (!(volume >= 1e-6))
        return check_refuse(c, FAULT_RANGE, "to_world cannot be inverted: its columns span %g of a right box",
                            volume);
    return FAULT_NONE;
}

static fault_code_t check_film(check_t *c, const scene_camera_t *m)
{
    TRY(check_number(c, "width", m->width, 1, SCENE_MAX_FILM_SIZE));
    TRY(check_number(c, "height", m->height, 1, SCENE_MAX_FILM_SIZE));
    if (m->crop[0] >= m->crop[1] || m->crop[1] > m->width || m->crop[2] >= m->crop[3] || m->crop[3] > m->height)
        return check_refuse(c, FAULT_RANGE,
                            "the crop window x %u to %u, y %u to %u is empty or leaves the film of "
                            "%u x %u pixels",
                            m->crop[0], m->crop[1], m->crop[2], m->crop[3], m->width, m->height);
    TRY(check_word(c, "filter", m->filter, SCENE_FILTER_KINDS));
    TRY(check_number(c, "filter_radius[0]", m->filter_radius[0], 1e-3, 16));
    TRY(check_number(c, "filter_radius[1]", m->filter_radius[1], 1e-3, 16));
    TRY(check_number(c, "filter_sigma", m->filter_sigma, m->filter == SCENE_FILTER_GAUSSIAN ? 1e-3 : 0, 1e3));
    return check_number(c, "imaging_scale", m->imaging_scale, 1e-30, 1e30);
}

static fault_code_t check_camera(check_t *c)
{
    const scene_camera_t *m = c->scene->camera;
    if (!m)
        return fault_set(c->fault, FAULT_FORMAT, "the scene has no camera");
    snprintf(c->record, sizeof c->record, "camera");
    TRY(check_camera_matrix(c, m->to_world));
    for (int k = 0; k < 4; k++)
        TRY(check_number(c, "an edge of the screen", m->screen[k], -1e6, 1e6));
    if (!(m->screen[1] - m->screen[0] >= 1e-9 && m->screen[3] - m->screen[2] >= 1e-9))
        return check_refuse(c, FAULT_RANGE, "the screen x %g to %g, y %g to %g is empty", m->screen[0],
                            m->screen[1], m->screen[2], m->screen[3]);
    TRY(check_number(c, "lens_radius", m->lens_radius, 0, (double)SCENE_MAX_COORDINATE));
    TRY(check_number(c, "focal_distance", m->focal_distance, m->lens_radius > 0 ? 1e-12 : 0,
                     (double)SCENE_MAX_COORDINATE));
    return check_film(c, m);
}

fault_code_t scene_check(const scene_t *scene, fault_t *fault)
{
    check_t c = {.scene = scene, .fault = fault};
    TRY(check_counts(&c));
    TRY(check_images(&c));
    TRY(check_textures(&c));
    TRY(check_materials(&c));
    TRY(check_lights(&c));
    TRY(check_shapes(&c));
    return check_camera(&c);
}
