#include "path/connect.h"

/* The two vertices that meet and their neighbours: r = reverse density / density (connect.h). */
typedef struct path_join {
    uint32_t s, t;
    const path_vertex_t *y, *z; /* vertex 0 of either walk */
    bool y0_hittable;           /* y_0 is not a delta light */
    double y_last, y_previous;  /* r of y_{s-1}, y_{s-2} */
    double z_last, z_previous;  /* r of z_{t-1}, z_{t-2} */
} path_join_t;

static double join_ratio_y(const path_join_t *join, uint32_t i)
{
    return i + 1 == join->s ? join->y_last : i + 2 == join->s ? join->y_previous : join->y[i].ratio;
}

static double join_ratio_z(const path_join_t *join, uint32_t i)
{
    return i + 1 == join->t ? join->z_last : i + 2 == join->t ? join->z_previous : join->z[i].ratio;
}

/* Technique i < s joins y_{i-1} to y_i: possible if neither scattered specularly on this path. */
static bool join_open_y(const path_join_t *join, const uint8_t *allowed, uint32_t i)
{
    if (!allowed[i])
        return false;
    if (i == 0)
        return join->y0_hittable;
    return !join->y[i - 1].specular && (i + 1 == join->s || !join->y[i].specular);
}

/* The technique with t' = i < t camera vertices joins z_{i-1} to z_i. */
static bool join_open_z(const path_join_t *join, const uint8_t *allowed, uint32_t i)
{
    return allowed[join->s + join->t - i] && !join->z[i - 1].specular && (i + 1 == join->t || !join->z[i].specular);
}

/* sum_j p_j / p_s over the open techniques, s itself included. Horner's rule from the outer ends:
 *     light side   a <- r_i (open_i + a), i = 0 .. s-1;     camera side likewise, i = 1 .. t-1. */
static double join_sum(const path_join_t *join, const uint8_t *allowed)
{
    double light = 0, camera = 0;
    for (uint32_t i = 0; i < join->s; i++)
        light = join_ratio_y(join, i) * ((join_open_y(join, allowed, i) ? 1.0 : 0.0) + light);
    for (uint32_t i = 1; i < join->t; i++)
        camera = join_ratio_z(join, i) * ((join_open_z(join, allowed, i) ? 1.0 : 0.0) + camera);
    return 1 + light + camera;
}

/* The same in extended precision, for sums that leave double's range. */
static long double join_sum_extended(const path_join_t *join, const uint8_t *allowed)
{
    long double light = 0, camera = 0;
    for (uint32_t i = 0; i < join->s; i++)
        light = join_ratio_y(join, i) * ((join_open_y(join, allowed, i) ? 1.0L : 0.0L) + light);
    for (uint32_t i = 1; i < join->t; i++)
        camera = join_ratio_z(join, i) * ((join_open_z(join, allowed, i) ? 1.0L : 0.0L) + camera);
    return 1 + light + camera;
}

/* Weighs, checks and hands out the value. */
static bool path_finish(path_space_t *space, const path_join_t *join, const path_techniques_t *techniques,
                        rgb_t unweighted, path_value_t *out)
{
    double weight = 1 / join_sum(join, techniques->allowed);
    if (__builtin_expect(!(weight > 1e-300), 0)) {
        const long double sum = join_sum_extended(join, techniques->allowed);
        if (!(sum >= 1) || !__builtin_isfinite(sum)) {
            space->rejects[PATH_REJECT_WEIGHT]++;
            return false;
        }
        weight = (double)(1 / sum);
    }
    space->end_ratios[0] = join->y_last;
    space->end_ratios[1] = join->y_previous;
    space->end_ratios[2] = join->z_last;
    space->end_ratios[3] = join->z_previous;
    out->value = rgb_scale(unweighted, weight);
    if (__builtin_expect(!isfinite(out->value.r + out->value.g + out->value.b), 0)) {
        space->rejects[PATH_REJECT_VALUE]++;
        return false;
    }
    if (__builtin_expect(!(out->value.r >= 0 && out->value.g >= 0 && out->value.b >= 0), 0)) {
        space->rejects[PATH_REJECT_NEGATIVE]++;
        return false;
    }
    return rgb_max(out->value) > 0;
}

/* 1 / (pi R^2): density of a photon's start, per area perpendicular to its direction. */
static double path_disk_density(const path_scene_t *ps)
{
    return MATH_INV_PI / (ps->lights.scene_radius * ps->lights.scene_radius);
}

/* s = 0: the camera walk's last vertex is on a light. */
static bool path_hit_light(const path_scene_t *ps, path_space_t *space, uint32_t t,
                           const path_techniques_t *techniques, path_value_t *out)
{
    const path_vertex_t *z = space->camera, *last = &z[t - 1];
    rgb_t emitted = rgb_gray(0);
    double pdf_position = 0, pdf_direction = 0;
    if (last->kind == PATH_INFINITE) {
        for (int32_t i = 0; i < ps->lights.infinite_count; i++) {
            double pdf;
            emitted = rgb_add(
                emitted, light_infinite_radiance(&ps->lights, ps->scene, ps->lights.infinite[i], last->ng, &pdf));
            pdf_position += pdf;
        }
        pdf_direction = path_disk_density(ps);
    } else if (last->emitter != PATH_NO_EMITTER) {
        const vec3_t w = vec3_unit(vec3_sub(z[t - 2].position, last->position));
        emitted = light_eval(&ps->lights, ps->scene, last->emitter, last->ng, w, &pdf_direction);
        pdf_position = light_pdf_position(&ps->lights, last->emitter);
    }
    if (!(rgb_max(emitted) > 0))
        return false;
    const path_join_t join = {.s = 0,
                              .t = t,
                              .y = space->light,
                              .z = z,
                              .z_last = pdf_position / last->pdf,
                              .z_previous = t > 2 ? pdf_direction * last->to_previous / z[t - 2].pdf : 0};
    out->raster = space->raster;
    return path_finish(space, &join, techniques, rgb_mul(emitted, last->beta), out);
}

/* The light walk's end as seen along w (unit, from y to the other end): radiance or throughput times
 * its scattering and cosine, densities. */
typedef struct path_end {
    rgb_t value;
    double pdf;      /* of w per solid angle (from infinity: per area of the disk) */
    double previous; /* density of y_{s-2} by the reversed walk over its own */
} path_end_t;

static bool path_end_of_light(const path_scene_t *ps, const path_vertex_t *y, const path_vertex_t *before, vec3_t w,
                              path_end_t *end)
{
    end->previous = 0;
    if (y->kind == PATH_INFINITE) {
        end->value = y->beta;
        end->pdf = path_disk_density(ps);
        return true;
    }
    if (y->kind == PATH_LIGHT) {
        const rgb_t emitted = light_eval(&ps->lights, ps->scene, y->emitter, y->ng, w, &end->pdf);
        const bool surface = !(ps->lights.emitters[y->emitter].flags & LIGHT_DELTA_POSITION);
        end->value = rgb_scale(rgb_mul(y->beta, emitted), surface ? fabs(vec3_dot(y->ng, w)) : 1);
        return rgb_max(end->value) > 0;
    }
    if (!y->bsdf || !(y->bsdf->flags & BSDF_HAS_SMOOTH))
        return false;
    const bool diffuse = (y->bsdf->flags & BSDF_ONLY_DIFFUSE) != 0;
    const vec3_t wi = diffuse ? vec3(0, 0, vec3_dot(y->frame.n, w)) : frame_to_local(&y->frame, w);
    const double cos_g = vec3_dot(y->ng, w);
    if (!(cos_g * wi.z > 0))
        return false;
    bsdf_value_t value;
    bsdf_eval(y->bsdf, ps->tables, y->wo, wi, BSDF_IMPORTANCE, &value);
    end->value = rgb_scale(rgb_mul(y->beta, value.f), y->correction * fabs(cos_g));
    end->pdf = value.pdf;
    end->previous = before->delta ? 0 : value.pdf_reverse * y->to_previous / before->pdf;
    return rgb_max(end->value) > 0;
}

static bool path_end_of_camera(const path_scene_t *ps, const path_vertex_t *z, const path_vertex_t *before,
                               vec3_t w, path_end_t *end)
{
    if (!z->bsdf || !(z->bsdf->flags & BSDF_HAS_SMOOTH))
        return false;
    const bool diffuse = (z->bsdf->flags & BSDF_ONLY_DIFFUSE) != 0;
    const vec3_t wi = diffuse ? vec3(0, 0, vec3_dot(z->frame.n, w)) : frame_to_local(&z->frame, w);
    if (!(vec3_dot(z->ng, w) * wi.z > 0))
        return false;
    bsdf_value_t value;
    bsdf_eval(z->bsdf, ps->tables, z->wo, wi, BSDF_RADIANCE, &value);
    end->value = rgb_scale(rgb_mul(z->beta, value.f), fabs(wi.z));
    end->pdf = value.pdf;
    end->previous = before->kind == PATH_LENS ? 0 : value.pdf_reverse * z->to_previous / before->pdf;
    return rgb_max(end->value) > 0;
}

/* t = 1: the other end is the lens. */
static bool path_end_of_lens(const path_scene_t *ps, const path_vertex_t *z, vec3_t w, path_end_t *end,
                             vec2_t *raster)
{
    camera_value_t value;
    const double cosine = vec3_dot(ps->camera.forward, w);
    if (!(cosine > 0) || !camera_eval(&ps->camera, z->position, w, &value))
        return false;
    end->value = rgb_scale(z->beta, value.importance * cosine);
    end->pdf = value.pdf_direction;
    end->previous = 0;
    *raster = value.raster;
    return value.importance > 0;
}

static bool path_visible(const path_scene_t *ps, path_space_t *space, const path_vertex_t *y,
                         const path_vertex_t *z, vec3_t w)
{
    const vec3_t from =
        z->kind == PATH_LENS ? z->position : surface_offset(z->position, z->ng, z->epsilon, vec3_neg(w));
    const vec3_t to = y->kind == PATH_INFINITE ? y->ng : surface_offset(y->position, y->ng, y->epsilon, w);
    const uint64_t stamp = stamp_enter(&space->tracing);
    accel_answer_t answer;
    if (y->kind == PATH_INFINITE)
        answer = accel_occluded_beyond(ps->accel, from, to);
    else
        answer = accel_occluded(ps->accel, from, to);
    stamp_leave(&space->tracing, stamp);
    space->shadow_rays++;
    if (answer == ACCEL_BAD_RAY)
        space->rejects[PATH_REJECT_RAY]++;
    return answer == ACCEL_MISS;
}

/* A caustic by its vertices: those that are joined do not scatter specularly, so that y_1 decides for s > 2, and
 * for s = 1, 2 there is none; for s = 0 the light is z_{t-1}, and some vertex nearer to the lens must not be
 * specular. */
static bool path_is_caustic(const path_space_t *space, uint32_t s, uint32_t t)
{
    if (s > 0)
        return s > 2 && space->light[1].specular;
    if (t < 4 || !space->camera[t - 2].specular)
        return false;
    for (uint32_t i = 1; i + 2 < t; i++)
        if (!space->camera[i].specular)
            return true;
    return false;
}

bool path_connect(const path_scene_t *ps, path_space_t *space, uint32_t s, uint32_t t, const path_vertex_t *y0,
                  const path_techniques_t *techniques, path_value_t *out)
{
    if (!techniques->allowed[s])
        return false;
    if (__builtin_expect(techniques->left_out, 0) && (path_classes(space, s, t, y0) & techniques->left_out))
        return false;
    if (s == 0)
        return path_hit_light(ps, space, t, techniques, out);
    const path_vertex_t *light = y0 ? y0 : space->light;
    const path_vertex_t *y = &light[s - 1], *z = &space->camera[t - 1];
    const bool infinite = y->kind == PATH_INFINITE;
    if (z->kind == PATH_INFINITE)
        return false;
    if (s == 1 && t == 1 && y->delta) /* a light without extent is not to be seen itself */
        return false;
    vec3_t w;       /* unit, from y to z */
    double inverse; /* 1 / distance^2; 1 from infinity */
    if (infinite) {
        w = vec3_neg(y->ng);
        inverse = 1;
    } else {
        const vec3_t d = vec3_sub(z->position, y->position);
        const double d2 = vec3_dot(d, d);
        inverse = 1 / d2;
        w = vec3_scale(d, sqrt(inverse));
        if (!(d2 > 0) || !isfinite(inverse))
            return false;
    }
    path_end_t from, to;
    out->raster = space->raster;
    const bool meets = t == 1 ? path_end_of_lens(ps, z, vec3_neg(w), &to, &out->raster)
                              : path_end_of_camera(ps, z, z - 1, vec3_neg(w), &to);
    if (!meets || !path_end_of_light(ps, y, y - (s > 1), w, &from))
        return false;
    const rgb_t unweighted = rgb_scale(rgb_mul(from.value, to.value), inverse);
    if (!(rgb_max(unweighted) > 0) || !path_visible(ps, space, y, z, w))
        return false;
    const double cos_y = infinite ? 1 : fabs(vec3_dot(y->ng, w)), cos_z = fabs(vec3_dot(z->ng, w));
    const path_join_t join = {.s = s,
                              .t = t,
                              .y = light,
                              .z = space->camera,
                              .y0_hittable = !light[0].delta,
                              .y_last = y->delta ? 0 : to.pdf * cos_y * inverse / y->pdf,
                              .y_previous = from.previous,
                              .z_last = t == 1 ? 0 : from.pdf * cos_z * inverse / z->pdf,
                              .z_previous = to.previous};
    return path_finish(space, &join, techniques, unweighted, out);
}

uint8_t path_classes(const path_space_t *space, uint32_t s, uint32_t t, const path_vertex_t *y0)
{
    const path_vertex_t *light = s == 0 ? &space->camera[t - 1] : y0 ? y0 : space->light;
    const bool infinite = light->kind == PATH_INFINITE && (s == 0 || !light->delta);
    return (uint8_t)((path_is_caustic(space, s, t) ? PATH_CLASS_CAUSTIC : 0) |
                     (infinite ? PATH_CLASS_INFINITE : 0));
}

bool path_technique_weights(const path_space_t *space, uint32_t s, uint32_t t, const path_vertex_t *y0,
                            const path_techniques_t *techniques, double *weights)
{
    const path_vertex_t *light = y0 ? y0 : space->light;
    const path_join_t join = {.s = s,
                              .t = t,
                              .y = light,
                              .z = space->camera,
                              .y0_hittable = s > 0 && !light[0].delta,
                              .y_last = space->end_ratios[0],
                              .y_previous = space->end_ratios[1],
                              .z_last = space->end_ratios[2],
                              .z_previous = space->end_ratios[3]};
    /* p_j / p_s: products of the ratios of the vertices that change sides */
    double sum = weights[s] = 1, product = 1;
    for (uint32_t i = s; i-- > 0;) {
        product *= join_ratio_y(&join, i);
        weights[i] = join_open_y(&join, techniques->allowed, i) ? product : 0;
        sum += weights[i];
    }
    product = 1;
    for (uint32_t i = t; --i > 0;) {
        product *= join_ratio_z(&join, i);
        weights[s + t - i] = join_open_z(&join, techniques->allowed, i) ? product : 0;
        sum += weights[s + t - i];
    }
    if (!(sum < 1e300))
        return false;
    for (uint32_t j = 0; j < s + t; j++)
        weights[j] /= sum;
    return true;
}
