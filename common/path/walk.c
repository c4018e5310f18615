#include "path/walk.h"

#include <stdlib.h>
#include <string.h>

path_space_t *path_space_new(void)
{
    path_space_t *space = aligned_alloc(64, (sizeof *space + 63) / 64 * 64);
    if (!space)
        return NULL;
    memset(space, 0, sizeof *space);
    path_space_init(space);
    return space;
}

/* Where a walk goes next. `density` is per solid angle; from a vertex at infinity per area of the disk that photons
 * start on. */
typedef struct path_step {
    vec3_t origin, direction;
    double density;
} path_step_t;

/* Fills the vertex where a ray meets a surface: geometry, densities, scattering. */
static void path_arrive(const path_scene_t *ps, const path_vertex_t *from, const path_step_t *step,
                        const accel_hit_t *hit, const surface_t *at, bool wants_uv, bool last, bsdf_t *scratch,
                        path_vertex_t *to)
{
    const scene_t *scene = ps->scene;
    const vec3_t w = step->direction;
    to->kind = PATH_SURFACE;
    to->specular = 0;
    to->delta = 0;
    to->lobe = 0;
    to->position = at->position;
    to->ng = at->ng;
    to->epsilon = at->epsilon;
    to->ratio = 0;
    const double cos_g = vec3_dot(at->ng, w); /* of the arriving direction: negative from outside */
    if (from->kind == PATH_INFINITE) {
        to->pdf = step->density * fabs(cos_g);
        to->to_previous = 1;
    } else {
        const vec3_t d = vec3_sub(at->position, from->position);
        const double inverse = 1 / vec3_dot(d, d);
        to->pdf = step->density * fabs(cos_g) * inverse;
        to->to_previous = fabs(vec3_dot(from->ng, w)) * inverse;
    }
    to->emitter = light_of_primitive(&ps->lights, hit->shape, hit->primitive);
    const double cos_s = vec3_dot(at->ns, w);
    to->bsdf = NULL;
    to->correction = 1;
    if (!(cos_g * cos_s > 0)) /* the normals disagree about the side: nothing scatters here */
        return;
    const int32_t material = scene->shapes[hit->shape].material;
    if (!bsdf_material_visible(scene, material))
        return;
    to->bsdf = bsdf_resolve(scene, ps->tables, (uint32_t)material, at->u, at->v, scratch);
    to->correction = cos_s / cos_g;
    if (last && (to->bsdf->flags & BSDF_ONLY_DIFFUSE)) {
        to->frame.n = at->ns;
        to->wo = vec3(0, 0, -cos_s);
        to->lobe = PATH_FRAME_OF_NORMAL;
        if (wants_uv) {
            to->frame.s = at->tangent;
            to->lobe = PATH_FRAME_OF_TANGENT;
        }
        return;
    }
    to->frame = wants_uv ? frame_of_normal_tangent(at->ns, at->tangent) : frame_of_normal(at->ns);
    to->wo = frame_to_local(&to->frame, vec3_neg(w));
}

/* Scatters at `at` (whose predecessor is `before`): throughput of the next vertex, densities both ways, the next
 * step. */
static bool path_scatter(const path_scene_t *ps, path_vertex_t *before, path_vertex_t *at, const double u[3],
                         bsdf_mode_t mode, rgb_t *beta, path_step_t *step)
{
    bsdf_sample_t sample;
    if (!at->bsdf || !bsdf_sample(at->bsdf, ps->tables, at->wo, u, mode, &sample))
        return false;
    const vec3_t w = frame_to_world(&at->frame, sample.wi);
    const double cos_g = vec3_dot(w, at->ng), cos_s = sample.wi.z;
    if (!(cos_g * cos_s > 0))
        return false;
    rgb_t weight = sample.weight;
    if (mode == BSDF_IMPORTANCE) /* Veach 1997, 5.3.2: |wo.ns| |wi.ng| / (|wo.ng| |wi.ns|) */
        weight = rgb_scale(weight, at->correction * cos_g / cos_s);
    *beta = rgb_mul(at->beta, weight);
    if (!(rgb_max(*beta) > 0))
        return false;
    double forward = sample.pdf, reverse = sample.pdf_reverse;
    at->specular = sample.specular;
    at->lobe = (uint8_t)sample.lobe;
    if (sample.specular) { /* with respect to n^2 |cos| d omega on either side */
        forward *= fabs(sample.wi.z) * sample.eta * sample.eta;
        reverse *= fabs(at->wo.z);
    }
    before->ratio = before->delta || before->kind == PATH_LENS ? 0 : reverse * at->to_previous / before->pdf;
    step->origin = surface_offset(at->position, at->ng, at->epsilon, w);
    step->direction = w;
    step->density = forward;
    return true;
}

/* Embree's ray starts off its surface and may meet a triangle that the line itself passes: the line meets the plane
 * outside, and the point was moved to the edge. From a place just before, on the line itself, the ray finds the
 * neighbour, or what lies behind a silhouette. `back` is 64 times farther than the ray was off at that place, so
 * that no neighbour but one that is seen flatter by that much lies before it. True if *hit and *at are replaced. */
static bool path_look_again(const path_scene_t *ps, vec3_t place, vec3_t direction, accel_hit_t *hit, surface_t *at)
{
    const double back = 64 * at->epsilon / fabs(vec3_dot(at->ng, direction));
    const double begin = vec3_dot(vec3_sub(at->position, place), direction) - back;
    accel_hit_t again;
    surface_t there;
    if (!(begin > 0) ||
        accel_intersect(ps->accel, vec3_mad(place, begin, direction), direction, &again) != ACCEL_HIT ||
        !surface_at_hit(ps->scene, &again, place, direction, true, &there) || there.moved)
        return false;
    *hit = again;
    *at = there;
    return true;
}

static inline bool path_end_is_of_use(const path_scene_t *ps, const accel_hit_t *hit, path_ends_t ends)
{
    return ends == PATH_ENDS_ANYWHERE || (ps->shape_flags[hit->shape] & ends);
}

/* The vertices [1, vertices) of either walk, from vertex 0 and its step. */
static uint32_t path_walk(const path_scene_t *ps, path_space_t *space, path_vertex_t *v, bsdf_t *scratch,
                          path_step_t step, rgb_t beta, const double *u, uint32_t vertices, path_ends_t ends,
                          bsdf_mode_t mode)
{
    for (uint32_t i = 1;; i++) {
        accel_hit_t hit;
        /* the line's point: photons from infinity start in the air */
        const vec3_t place = v[i - 1].kind == PATH_INFINITE ? step.origin : v[i - 1].position;
        const uint64_t stamp = stamp_enter(&space->tracing);
        const accel_answer_t answer = accel_intersect_line(ps->accel, place, step.origin, step.direction, &hit);
        stamp_leave(&space->tracing, stamp);
        if (answer == ACCEL_BAD_RAY) {
            space->rejects[PATH_REJECT_RAY]++;
            return i;
        }
        space->rays++;
        path_vertex_t *to = &v[i], *from = &v[i - 1];
        to->beta = beta;
        if (answer == ACCEL_MISS) {
            if (mode == BSDF_IMPORTANCE || ps->lights.infinite_count == 0)
                return i;
            to->kind = PATH_INFINITE;
            to->ng = step.direction;
            to->bsdf = NULL;
            to->emitter = PATH_NO_EMITTER;
            to->specular = to->delta = 0;
            to->pdf = step.density;
            to->to_previous = fabs(vec3_dot(from->ng, step.direction));
            return i + 1;
        }
        const bool last = i + 1 == vertices;
        if (last && !path_end_is_of_use(ps, &hit, ends))
            return i;
        surface_t at;
        bool wants_uv = (ps->shape_flags[hit.shape] & PATH_SHAPE_WANTS_UV) != 0;
        if (!surface_at_hit(ps->scene, &hit, place, step.direction, wants_uv, &at))
            return i;
        if (__builtin_expect(at.moved, 0) && path_look_again(ps, place, step.direction, &hit, &at)) {
            if (last && !path_end_is_of_use(ps, &hit, ends))
                return i;
            wants_uv = (ps->shape_flags[hit.shape] & PATH_SHAPE_WANTS_UV) != 0;
        }
        path_arrive(ps, from, &step, &hit, &at, wants_uv, last, &scratch[i], to);
        if (!(to->pdf > 0) || last)
            return to->pdf > 0 ? i + 1 : i;
        if (!path_scatter(ps, from, to, u, mode, &beta, &step))
            return i + 1;
        u += BSDF_DIMENSIONS;
    }
}

uint32_t path_walk_camera(const path_scene_t *ps, path_space_t *space, const double *u, uint32_t vertices,
                          path_ends_t ends)
{
    path_vertex_t *z = &space->camera[0];
    static const double centre[2] = {0.5, 0.5};
    const double *lens = ps->camera.pinhole ? centre : u + 2;
    z->kind = PATH_LENS;
    z->bsdf = NULL;
    z->emitter = PATH_NO_EMITTER;
    z->specular = z->delta = 0;
    z->ng = ps->camera.forward;
    z->epsilon = 0;
    if (vertices == 1) {
        z->pdf = camera_sample_lens(&ps->camera, lens, &z->position);
        z->beta = rgb_gray(1 / z->pdf);
        return 1;
    }
    camera_sample_t sample;
    camera_sample(&ps->camera, u, lens, &sample);
    z->position = sample.origin;
    z->pdf = sample.pdf_position;
    z->beta = rgb_gray(1 / sample.pdf_position); /* for connections to the lens (t = 1) */
    space->raster = sample.raster;
    const path_step_t step = {sample.origin, sample.direction, sample.pdf_direction};
    return path_walk(ps, space, z, space->camera_bsdf, step, rgb_gray(sample.weight), u + ps->camera_dimensions,
                     vertices, ends, BSDF_RADIANCE);
}

static bool path_origin_of(const path_scene_t *ps, const double u[3], light_sample_t *at, path_vertex_t *y)
{
    const light_set_t *lights = &ps->lights;
    if (!light_sample_position(lights, ps->scene, u[0], u + 1, at))
        return false;
    const light_emitter_t *emitter = &lights->emitters[at->emitter];
    y->bsdf = NULL;
    y->emitter = at->emitter;
    y->specular = 0;
    y->ratio = 0;
    y->correction = 1;
    y->delta = (emitter->flags & (LIGHT_DELTA_POSITION | LIGHT_DELTA_DIRECTION)) != 0;
    y->pdf = at->pdf;
    if (!(emitter->flags & LIGHT_AT_INFINITY)) {
        y->kind = PATH_LIGHT;
        y->position = at->position;
        y->ng = at->normal;
        y->epsilon = ps->emitter_epsilon[at->emitter];
        y->beta = rgb_gray(1 / at->pdf);
        return true;
    }
    y->kind = PATH_INFINITE;
    y->ng = at->to_light;
    y->epsilon = 0;
    rgb_t radiance = emitter->radiance;
    if (emitter->kind ==
        LIGHT_INFINITE) { /* several lights at infinity are one: any of them may have made the direction */
        radiance = rgb_gray(0);
        y->pdf = 0;
        for (int32_t i = 0; i < lights->infinite_count; i++) {
            double pdf;
            radiance = rgb_add(radiance,
                               light_infinite_radiance(lights, ps->scene, lights->infinite[i], at->to_light, &pdf));
            y->pdf += pdf;
        }
    }
    y->beta = rgb_scale(radiance, 1 / y->pdf);
    return y->pdf > 0;
}

bool path_light_origin(const path_scene_t *ps, const double u[3], path_vertex_t *y)
{
    light_sample_t at;
    return path_origin_of(ps, u, &at, y);
}

uint32_t path_walk_light(const path_scene_t *ps, path_space_t *space, const double *u, uint32_t vertices,
                         path_ends_t ends)
{
    path_vertex_t *y = &space->light[0];
    light_sample_t at;
    if (!path_origin_of(ps, u, &at, y))
        return 0;
    if (vertices == 1)
        return 1;
    light_emission_t emission;
    if (!light_sample_direction(&ps->lights, ps->scene, &at, u + 3, &emission))
        return 1;
    rgb_t beta = y->beta;
    if (y->kind == PATH_INFINITE)
        beta = rgb_scale(beta, 1 / emission.pdf_direction);
    else
        beta = rgb_mul(beta, rgb_scale(emission.radiance, emission.cosine / emission.pdf_direction));
    if (!(rgb_max(beta) > 0))
        return 1;
    const path_step_t step = {y->kind == PATH_LIGHT
                                  ? surface_offset(y->position, y->ng, y->epsilon, emission.direction)
                                  : emission.origin,
                              emission.direction, emission.pdf_direction};
    return path_walk(ps, space, y, space->light_bsdf, step, beta, u + PATH_LIGHT_DIMENSIONS, vertices, ends,
                     BSDF_IMPORTANCE);
}
