#include "client/import/surfaces.h"

typedef struct surface_point {
    vec3_t p, n;
} surface_point_t;

/* A surface of revolution about z: what the parameters u, v in [0,1] give. */
typedef struct revolution {
    enum { SPHERE, DISK, CYLINDER } kind;
    double radius, inner_radius, z_min, z_max, phi_max;
} revolution_t;

static surface_point_t at(const revolution_t *s, double u, double v)
{
    /* The seam of a full turn closes exactly. */
    const double phi = u == 1 && s->phi_max == 2 * MATH_PI ? 0 : u * s->phi_max, c = cos(phi), d = sin(phi);
    if (s->kind == DISK) {
        const double r = s->radius + v * (s->inner_radius - s->radius);
        return (surface_point_t){vec3(r * c, r * d, s->z_min), vec3(0, 0, 1)};
    }
    if (s->kind == CYLINDER)
        return (surface_point_t){vec3(s->radius * c, s->radius * d, s->z_min + v * (s->z_max - s->z_min)),
                                 vec3(c, d, 0)};
    const double first = acos(fmin(fmax(s->z_min / s->radius, -1), 1));
    const double last = acos(fmin(fmax(s->z_max / s->radius, -1), 1));
    const double theta = first + v * (last - first);
    const double sine = theta == 0 || theta == acos(-1) ? 0 : sin(theta); /* the poles are points */
    const vec3_t n = vec3(sine * c, sine * d, cos(theta));
    return (surface_point_t){vec3_scale(n, s->radius), n};
}

static void put_vertex(geometry_t *out, uint64_t i, surface_point_t s, double u, double v)
{
    out->positions[3 * i] = (float)s.p.x;
    out->positions[3 * i + 1] = (float)s.p.y;
    out->positions[3 * i + 2] = (float)s.p.z;
    if (out->normals) {
        out->normals[3 * i] = (float)s.n.x;
        out->normals[3 * i + 1] = (float)s.n.y;
        out->normals[3 * i + 2] = (float)s.n.z;
    }
    out->uvs[2 * i] = (float)u;
    out->uvs[2 * i + 1] = (float)v;
}

/* Two triangles for the cell between vertices a, a+1 (along u) and b, b+1 (the next row). */
static void put_cell(uint32_t *to, uint32_t a, uint32_t b)
{
    const uint32_t corners[6] = {a, a + 1, b + 1, a, b + 1, b};
    for (int i = 0; i < 6; i++)
        to[i] = corners[i];
}

static fault_code_t tessellate(geometry_t *out, const revolution_t *s, uint32_t along, fault_t *fault)
{
    const uint32_t around = (uint32_t)fmax(3, ceil(SURFACES_AROUND * s->phi_max / (2 * MATH_PI) - 1e-9));
    TRY(geometry_new_mesh(out, (uint64_t)(around + 1) * (along + 1), 2 * (uint64_t)around * along, true, true,
                          fault));
    out->generated = true;
    for (uint32_t j = 0, i = 0; j <= along; j++)
        for (uint32_t k = 0; k <= around; k++, i++)
            put_vertex(out, i, at(s, (double)k / around, (double)j / along), (double)k / around, (double)j / along);
    for (uint32_t j = 0, i = 0; j < along; j++)
        for (uint32_t k = 0; k < around; k++, i++)
            put_cell(out->indices + 6 * (uint64_t)i, j * (around + 1) + k, (j + 1) * (around + 1) + k);
    return FAULT_NONE;
}

fault_code_t surfaces_sphere(geometry_t *out, double radius, double z_min, double z_max, double phi_max,
                             fault_t *fault)
{
    const revolution_t s = {SPHERE, radius, 0, z_min, z_max, phi_max};
    return tessellate(out, &s, SURFACES_ALONG, fault);
}

fault_code_t surfaces_disk(geometry_t *out, double height, double radius, double inner_radius, double phi_max,
                           fault_t *fault)
{
    const revolution_t s = {DISK, radius, inner_radius, height, height, phi_max};
    return tessellate(out, &s, 1, fault);
}

fault_code_t surfaces_cylinder(geometry_t *out, double radius, double z_min, double z_max, double phi_max,
                               fault_t *fault)
{
    const revolution_t s = {CYLINDER, radius, 0, z_min, z_max, phi_max};
    return tessellate(out, &s, 1, fault);
}

/* ---- bilinear patches ---- */

static vec3_t corner(const double *values, const uint32_t index)
{
    return vec3(values[3 * (uint64_t)index], values[3 * (uint64_t)index + 1], values[3 * (uint64_t)index + 2]);
}

/* p00 + p11 = p10 + p01 to single precision. */
static bool is_parallelogram(const double *points, const uint32_t *i)
{
    const vec3_t a = corner(points, i[0]), b = corner(points, i[1]), c = corner(points, i[2]),
                 d = corner(points, i[3]);
    const vec3_t gap = vec3_sub(vec3_add(a, d), vec3_add(b, c));
    const double size = fmax(vec3_max_abs(vec3_sub(d, a)), vec3_max_abs(vec3_sub(c, b)));
    const double reach = fmax(fmax(vec3_max_abs(a), vec3_max_abs(b)), fmax(vec3_max_abs(c), vec3_max_abs(d)));
    return vec3_max_abs(gap) <= 1e-6 * fmax(size, 0.1 * reach);
}

static vec3_t blend(const vec3_t c[4], double u, double v)
{
    const vec3_t low = vec3_add(vec3_scale(c[0], 1 - u), vec3_scale(c[1], u));
    const vec3_t high = vec3_add(vec3_scale(c[2], 1 - u), vec3_scale(c[3], u));
    return vec3_add(vec3_scale(low, 1 - v), vec3_scale(high, v));
}

/* The patch's own normal: dp/du x dp/dv. */
static vec3_t patch_normal(const vec3_t c[4], double u, double v)
{
    const vec3_t du = vec3_add(vec3_scale(vec3_sub(c[1], c[0]), 1 - v), vec3_scale(vec3_sub(c[3], c[2]), v));
    const vec3_t dv = vec3_add(vec3_scale(vec3_sub(c[2], c[0]), 1 - u), vec3_scale(vec3_sub(c[3], c[1]), u));
    const vec3_t n = vec3_cross(du, dv);
    return vec3_length(n) > 0 ? vec3_unit(n) : vec3(0, 0, 0);
}

static void put_patch(geometry_t *out, uint64_t vertex, uint64_t triangle, uint32_t cells, const double *points,
                      const double *normals, const double *uvs, const uint32_t *index)
{
    vec3_t p[4], n[4];
    static const double unit[8] = {0, 0, 1, 0, 0, 1, 1, 1};
    double uv[8];
    for (int i = 0; i < 4; i++) {
        p[i] = corner(points, index[i]);
        n[i] = normals ? corner(normals, index[i]) : vec3(0, 0, 0);
        uv[2 * i] = uvs ? uvs[2 * (uint64_t)index[i]] : unit[2 * i];
        uv[2 * i + 1] = uvs ? uvs[2 * (uint64_t)index[i] + 1] : unit[2 * i + 1];
    }
    for (uint32_t j = 0, i = 0; j <= cells; j++)
        for (uint32_t k = 0; k <= cells; k++, i++) {
            const double u = (double)k / cells, v = (double)j / cells;
            const double w[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
            const surface_point_t s = {blend(p, u, v), normals ? blend(n, u, v) : patch_normal(p, u, v)};
            put_vertex(out, vertex + i, s, w[0] * uv[0] + w[1] * uv[2] + w[2] * uv[4] + w[3] * uv[6],
                       w[0] * uv[1] + w[1] * uv[3] + w[2] * uv[5] + w[3] * uv[7]);
        }
    for (uint32_t j = 0, i = 0; j < cells; j++)
        for (uint32_t k = 0; k < cells; k++, i++)
            put_cell(out->indices + 3 * triangle + 6 * (uint64_t)i, (uint32_t)vertex + j * (cells + 1) + k,
                     (uint32_t)vertex + (j + 1) * (cells + 1) + k);
}

fault_code_t surfaces_patches(geometry_t *out, const double *points, const double *normals, const double *uvs,
                              const uint32_t *indices, uint64_t patches, uint64_t *curved, fault_t *fault)
{
    uint64_t vertices = 0, triangles = 0;
    *curved = 0;
    for (uint64_t i = 0; i < patches; i++) {
        const uint64_t cells = is_parallelogram(points, indices + 4 * i) ? 1 : SURFACES_PATCH;
        *curved += cells > 1;
        vertices += (cells + 1) * (cells + 1);
        triangles += 2 * cells * cells;
    }
    TRY(geometry_new_mesh(out, vertices, triangles, normals != NULL || *curved > 0, true, fault));
    out->generated = true;
    vertices = triangles = 0;
    for (uint64_t i = 0; i < patches; i++) {
        const uint32_t *index = indices + 4 * i;
        const uint32_t cells = is_parallelogram(points, index) ? 1 : SURFACES_PATCH;
        put_patch(out, vertices, triangles, cells, points, normals, uvs, index);
        vertices += (uint64_t)(cells + 1) * (cells + 1);
        triangles += 2 * (uint64_t)cells * cells;
    }
    return FAULT_NONE;
}
