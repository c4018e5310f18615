#include "math/triangle.h"
#include "math/warp.h"
#include "scene/environment.h"
#include "scene/light.h"

/* Tolerance of the inverses for what rounding puts just outside a cone or a disk (relative). */
#define LIGHT_RIM 1e-9

/* ---- directions to an infinite light ---- */

static vec3_t infinite_to_local(const light_emitter_t *e, vec3_t w)
{
    return vec3(vec3_dot(e->edge1, w), vec3_dot(e->edge2, w), vec3_dot(e->normal, w));
}

static vec3_t infinite_to_world(const light_emitter_t *e, vec3_t w)
{
    return vec3_mad(vec3_mad(vec3_scale(e->edge1, w.x), w.y, e->edge2), w.z, e->normal);
}

/* Density per solid angle, selection excluded. */
static double infinite_sample(const light_set_t *set, const light_emitter_t *e, const double u[2], vec3_t *to_light)
{
    const table2_t *table = &set->infinite_tables[e->primitive];
    if (table->width == 0) {
        *to_light = warp_sphere(u[0], u[1]);
        return 0.25 * MATH_INV_PI;
    }
    double x, y;
    const double pdf = table2_sample(table, u[0], u[1], &x, &y);
    *to_light = infinite_to_world(e, warp_octahedral(x, y));
    return pdf * (0.25 * MATH_INV_PI);
}

static bool infinite_invert(const light_set_t *set, const light_emitter_t *e, vec3_t to_light, double u[2])
{
    const table2_t *table = &set->infinite_tables[e->primitive];
    if (table->width == 0) {
        warp_sphere_invert(to_light, &u[0], &u[1]);
        return true;
    }
    double x, y;
    warp_octahedral_invert(infinite_to_local(e, to_light), &x, &y);
    if (!(table2_pdf(table, x, y) > 0))
        return false;
    table2_invert(table, x, y, &u[0], &u[1]);
    return true;
}

rgb_t light_infinite_radiance(const light_set_t *set, const scene_t *scene, uint32_t emitter, vec3_t to_light,
                              double *pdf)
{
    const light_emitter_t *e = &set->emitters[emitter];
    const table2_t *table = &set->infinite_tables[e->primitive];
    if (table->width == 0) {
        *pdf = e->probability * 0.25 * MATH_INV_PI;
        return e->radiance;
    }
    double x, y;
    warp_octahedral_invert(infinite_to_local(e, to_light), &x, &y);
    *pdf = e->probability * table2_pdf(table, x, y) * (0.25 * MATH_INV_PI);
    return environment_radiance(scene, &scene->images[scene->lights[e->light].image], e->radiance, x, y);
}

/* ---- places ---- */

static void sample_surface(const light_emitter_t *e, const double u[2], light_sample_t *out)
{
    out->normal = e->normal;
    if (e->kind == LIGHT_TRIANGLE) {
        const vec2_t b = warp_triangle(u[0], u[1]);
        out->position = vec3_mad(vec3_mad(e->position, b.x, e->edge1), b.y, e->edge2);
    } else if (e->kind == LIGHT_DISK) {
        const vec2_t p = warp_disk(u[0], u[1]);
        out->position = vec3_mad(vec3_mad(e->position, e->radius * p.x, e->edge1), e->radius * p.y, e->edge2);
    } else {
        const vec3_t n = warp_sphere(u[0], u[1]);
        out->position = vec3_mad(e->position, e->radius, n);
        out->normal = e->flags & LIGHT_INWARD ? vec3_neg(n) : n;
    }
}

bool light_sample_position(const light_set_t *set, const scene_t *scene, double select, const double position[2],
                           light_sample_t *out)
{
    (void)scene;
    double probability;
    out->emitter = table1_sample(&set->selection, select, &probability, NULL);
    const light_emitter_t *e = &set->emitters[out->emitter];
    out->position = e->position;
    out->normal = vec3(0, 0, 0);
    out->to_light = vec3(0, 0, 0);
    switch (e->kind) {
    case LIGHT_TRIANGLE:
    case LIGHT_SPHERE:
    case LIGHT_DISK:
        sample_surface(e, position, out);
        out->pdf = e->probability / e->area;
        break;
    case LIGHT_INFINITE:
        out->pdf = e->probability * infinite_sample(set, e, position, &out->to_light);
        break;
    case LIGHT_DISTANT:
        out->to_light = vec3_neg(e->normal);
        out->pdf = e->probability;
        break;
    default:
        out->pdf = e->probability;
        break;
    }
    return out->pdf > 0;
}

/* ---- directions ---- */

/* 1 - cos of the angle between unit vectors, to full relative precision. */
static double one_minus_dot(vec3_t a, vec3_t b)
{
    const vec3_t d = vec3_sub(a, b);
    return 0.5 * vec3_dot(d, d);
}

/* Intensity at h = 1 - cos: pbrt's smoothstep(cos_end, cos_start, cos), in differences that don't cancel. */
static rgb_t spot_intensity(const light_emitter_t *e, double h)
{
    const double begin = 1 - e->cos_start, end = 1 - e->cos_end;
    if (h <= begin)
        return e->radiance;
    if (!(h < end))
        return rgb(0, 0, 0);
    const double t = (end - h) / (end - begin);
    return rgb_scale(e->radiance, t * t * (3 - 2 * t));
}

/* The number within its side's interval; *side is 1 or -1. */
static double choose_side(const light_emitter_t *e, double u, double *side)
{
    *side = 1;
    if (!(e->flags & LIGHT_TWO_SIDED))
        return u;
    if (u < 0.5)
        return 2 * u;
    *side = -1;
    return 2 * u - 1;
}

static double surface_pdf(const light_emitter_t *e, double cosine)
{
    return cosine * (e->flags & LIGHT_TWO_SIDED ? 0.5 * MATH_INV_PI : MATH_INV_PI);
}

static void emit_surface(const light_emitter_t *e, vec3_t normal, const double u[2], light_emission_t *out)
{
    double side;
    const double u1 = choose_side(e, u[0], &side);
    const frame_t frame = frame_of_normal(normal);
    const vec3_t w = warp_cosine(u1, u[1]);
    out->direction = frame_to_world(&frame, vec3(w.x, w.y, side * w.z));
    out->cosine = w.z;
    out->pdf_direction = surface_pdf(e, w.z);
    out->radiance = e->radiance;
}

static void emit_spot(const light_emitter_t *e, const double u[2], light_emission_t *out)
{
    const double end = 1 - e->cos_end;
    const frame_t frame = frame_of_normal(e->normal);
    out->direction = frame_to_world(&frame, warp_cone(u[0], u[1], end));
    out->pdf_direction = 0.5 * MATH_INV_PI / end;
    out->radiance = spot_intensity(e, u[0] * end);
}

static void emit_from_infinity(const light_set_t *set, const scene_t *scene, const light_sample_t *at,
                               const double u[2], light_emission_t *out)
{
    const light_emitter_t *e = &set->emitters[at->emitter];
    const frame_t frame = frame_of_normal(at->to_light);
    const double radius = set->scene_radius;
    const vec2_t p = warp_disk(u[0], u[1]);
    out->origin = vec3_add(set->centre, frame_to_world(&frame, vec3(radius * p.x, radius * p.y, radius)));
    out->direction = vec3_neg(at->to_light);
    out->pdf_direction = MATH_INV_PI / (radius * radius);
    double pdf;
    out->radiance = e->kind == LIGHT_INFINITE ? light_infinite_radiance(set, scene, at->emitter, at->to_light, &pdf)
                                              : e->radiance;
}

bool light_sample_direction(const light_set_t *set, const scene_t *scene, const light_sample_t *at,
                            const double direction[2], light_emission_t *out)
{
    const light_emitter_t *e = &set->emitters[at->emitter];
    out->origin = at->position;
    out->cosine = 1;
    switch (e->kind) {
    case LIGHT_TRIANGLE:
    case LIGHT_SPHERE:
    case LIGHT_DISK:
        emit_surface(e, at->normal, direction, out);
        break;
    case LIGHT_POINT:
        out->direction = warp_sphere(direction[0], direction[1]);
        out->pdf_direction = 0.25 * MATH_INV_PI;
        out->radiance = e->radiance;
        break;
    case LIGHT_SPOT:
        emit_spot(e, direction, out);
        break;
    default:
        emit_from_infinity(set, scene, at, direction, out);
        break;
    }
    return out->pdf_direction > 0 && !rgb_black(out->radiance);
}

rgb_t light_eval(const light_set_t *set, const scene_t *scene, uint32_t emitter, vec3_t normal, vec3_t w,
                 double *pdf_direction)
{
    const light_emitter_t *e = &set->emitters[emitter];
    const rgb_t black = {0, 0, 0};
    switch (e->kind) {
    case LIGHT_TRIANGLE:
    case LIGHT_SPHERE:
    case LIGHT_DISK: {
        const double cosine = vec3_dot(e->kind == LIGHT_SPHERE ? normal : e->normal, w);
        const bool emits = cosine > 0 || (cosine < 0 && e->flags & LIGHT_TWO_SIDED);
        *pdf_direction = emits ? surface_pdf(e, fabs(cosine)) : 0;
        return emits ? e->radiance : black;
    }
    case LIGHT_POINT:
        *pdf_direction = 0.25 * MATH_INV_PI;
        return e->radiance;
    case LIGHT_SPOT: {
        const double h = one_minus_dot(e->normal, w), end = 1 - e->cos_end;
        *pdf_direction = h < end ? 0.5 * MATH_INV_PI / end : 0;
        return spot_intensity(e, h);
    }
    default: {
        *pdf_direction = MATH_INV_PI / (set->scene_radius * set->scene_radius);
        double pdf;
        return e->kind == LIGHT_INFINITE ? light_infinite_radiance(set, scene, emitter, vec3_neg(w), &pdf)
                                         : e->radiance;
    }
    }
}

/* ---- inverses ---- */

/* In coordinates from the second corner, where warp_triangle's u1 is 0: b0 + b2 is r = 1 - b1, b2 / r the second
 * number, without cancellation. */
static void triangle_invert(const light_emitter_t *e, vec3_t position, double u[2])
{
    const vec3_t to_first = vec3_neg(e->edge1), to_third = vec3_sub(e->edge2, e->edge1);
    const vec3_t p = vec3_sub(vec3_sub(position, e->position), e->edge1);
    vec2_t b = triangle_coordinates(to_first, to_third, p);
    if (!(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1))
        b = triangle_nearest(to_first, to_third, p);
    const double r = b.x + b.y;
    u[0] = warp_clamp_unit(r * r);
    u[1] = r > 0 ? warp_clamp_unit(b.y / r) : 0;
}

static vec3_t sphere_direction(const light_emitter_t *e, vec3_t position)
{
    return vec3_unit(vec3_sub(position, e->position));
}

bool light_invert_position(const light_set_t *set, const scene_t *scene, const light_sample_t *at,
                           const double free_numbers[3], double *select, double position[2])
{
    (void)scene;
    const light_emitter_t *e = &set->emitters[at->emitter];
    if (!(e->probability > 0))
        return false;
    *select = table1_invert(&set->selection, at->emitter, free_numbers[0]);
    switch (e->kind) {
    case LIGHT_TRIANGLE:
        triangle_invert(e, at->position, position);
        return true;
    case LIGHT_SPHERE:
        warp_sphere_invert(sphere_direction(e, at->position), &position[0], &position[1]);
        return true;
    case LIGHT_DISK: {
        const vec3_t d = vec3_scale(vec3_sub(at->position, e->position), 1 / e->radius);
        warp_disk_invert((vec2_t){vec3_dot(d, e->edge1), vec3_dot(d, e->edge2)}, &position[0], &position[1]);
        return true;
    }
    case LIGHT_INFINITE:
        return infinite_invert(set, e, at->to_light, position);
    default:
        position[0] = free_numbers[1];
        position[1] = free_numbers[2];
        return true;
    }
}

static bool invert_surface(const light_emitter_t *e, vec3_t normal, vec3_t w, double u[2])
{
    const frame_t frame = frame_of_normal(normal);
    const vec3_t local = frame_to_local(&frame, w);
    const bool two_sided = e->flags & LIGHT_TWO_SIDED;
    if (!(two_sided ? local.z != 0 : local.z > 0))
        return false;
    warp_cosine_invert(vec3(local.x, local.y, fabs(local.z)), &u[0], &u[1]);
    if (two_sided)
        u[0] = warp_clamp_unit(0.5 * u[0] + (local.z < 0 ? 0.5 : 0));
    return true;
}

static bool invert_spot(const light_emitter_t *e, vec3_t w, double u[2])
{
    const double end = 1 - e->cos_end, h = one_minus_dot(e->normal, w);
    if (!(h <= end * (1 + LIGHT_RIM)))
        return false;
    /* The axis is perpendicular to the frame's other two but for rounding, of which nothing is left in w less the
     * axis: a narrow cone's w has little else. */
    const frame_t frame = frame_of_normal(e->normal);
    const vec3_t off = vec3_sub(w, e->normal);
    warp_cone_invert(vec3(vec3_dot(off, frame.s), vec3_dot(off, frame.t), vec3_dot(w, e->normal)), end, &u[0],
                     &u[1]);
    return true;
}

static bool invert_from_infinity(const light_set_t *set, vec3_t to_light, vec3_t origin, double u[2])
{
    const frame_t frame = frame_of_normal(to_light);
    const vec3_t d = vec3_scale(vec3_sub(origin, set->centre), 1 / set->scene_radius);
    const vec2_t p = {vec3_dot(d, frame.s), vec3_dot(d, frame.t)};
    if (!(p.x * p.x + p.y * p.y <= 1 + LIGHT_RIM))
        return false;
    warp_disk_invert(p, &u[0], &u[1]);
    return true;
}

bool light_invert_direction(const light_set_t *set, const scene_t *scene, const light_sample_t *at, vec3_t origin,
                            vec3_t w, const double free_numbers[2], double direction[2])
{
    (void)scene;
    (void)free_numbers;
    const light_emitter_t *e = &set->emitters[at->emitter];
    switch (e->kind) {
    case LIGHT_TRIANGLE:
    case LIGHT_DISK:
        return invert_surface(e, e->normal, w, direction);
    case LIGHT_SPHERE: {
        const vec3_t n = sphere_direction(e, at->position);
        return invert_surface(e, e->flags & LIGHT_INWARD ? vec3_neg(n) : n, w, direction);
    }
    case LIGHT_POINT:
        warp_sphere_invert(w, &direction[0], &direction[1]);
        return true;
    case LIGHT_SPOT:
        return invert_spot(e, w, direction);
    default:
        return invert_from_infinity(set, at->to_light, origin, direction);
    }
}
