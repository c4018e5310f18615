#include "path/inverse.h"

#include "base/random.h"

/* A path x_0 (on the light) .. x_k (on the lens) in the walks that made it. */
typedef struct path_whole {
    const path_vertex_t *light, *camera;
    uint32_t s, k;
} path_whole_t;

static path_whole_t path_whole_of(const path_space_t *space, uint32_t s, uint32_t k)
{
    return (path_whole_t){space->light, space->camera, s, k};
}

static const path_vertex_t *path_at(const path_whole_t *x, uint32_t i)
{
    return i < x->s ? &x->light[i] : &x->camera[x->k - i];
}

/* Whether x_i scattered specularly: the ends that were joined did not, whatever a longer walk did there. */
static bool path_is_specular(const path_whole_t *x, uint32_t i)
{
    const bool joined = i + 1 == x->s || i == x->s;
    return !joined && path_at(x, i)->specular;
}

/* Unit direction from a vertex to its neighbour. */
static vec3_t path_direction(const path_vertex_t *from, const path_vertex_t *to)
{
    if (to->kind == PATH_INFINITE)
        return to->ng;
    if (from->kind == PATH_INFINITE)
        return vec3_neg(from->ng);
    return vec3_unit(vec3_sub(to->position, from->position));
}

static bool path_on_delta_light(const path_vertex_t *v)
{
    return (v->kind == PATH_LIGHT || v->kind == PATH_INFINITE) && v->delta;
}

/* Whether technique s could have made the path: nothing specular is joined, no delta light hit. */
static bool path_is_open(const path_whole_t *x, uint32_t s)
{
    if (s == 0)
        return !path_on_delta_light(path_at(x, 0));
    return !path_is_specular(x, s - 1) && !path_is_specular(x, s);
}

/* The three numbers of scattering at x_i, from wo to wi; on entry they are the free ones. */
static bool path_invert_scattering(const path_scene_t *ps, const path_whole_t *x, uint32_t i, vec3_t wo, vec3_t wi,
                                   bsdf_mode_t mode, double u[BSDF_DIMENSIONS])
{
    const path_vertex_t *v = path_at(x, i);
    if (!v->bsdf)
        return false;
    const frame_t frame = path_frame(v);
    const double number[3] = {u[0], u[1], u[2]};
    return bsdf_invert(v->bsdf, ps->tables, frame_to_local(&frame, wo), frame_to_local(&frame, wi),
                       path_is_specular(x, i), v->lobe, mode, number, u);
}

/* z_0 .. z_{t-1} = x_k .. x_{k+1-t}. The first `kept` of them are those of the walk that u already makes. */
static bool path_invert_camera(const path_scene_t *ps, const path_whole_t *x, uint32_t t, uint32_t kept, double *u)
{
    const bool lens = !ps->camera.pinhole && kept == 0, film = t > 1 && kept < 2;
    if (lens || film) {
        const path_vertex_t *z = path_at(x, x->k);
        const double none[2] = {0, 0}; /* a pinhole's lens numbers have no place in its stream */
        double on_film[2], on_lens[2];
        if (!camera_invert(&ps->camera, z->position, path_direction(z, path_at(x, x->k - 1)), none, on_film,
                           on_lens))
            return false;
        if (lens) {
            u[2] = on_lens[0];
            u[3] = on_lens[1];
        }
        if (film) {
            u[0] = on_film[0];
            u[1] = on_film[1];
        }
    }
    const uint32_t first = kept > 2 ? kept - 1 : 1; /* z to scatter at */
    if (first + 1 >= t)
        return true;
    u += ps->camera_dimensions + (size_t)BSDF_DIMENSIONS * (first - 1);
    const path_vertex_t *at = path_at(x, x->k - first);
    vec3_t w = path_direction(path_at(x, x->k - first + 1), at);
    for (uint32_t j = first; j + 1 < t; j++, u += BSDF_DIMENSIONS) {
        const path_vertex_t *next = path_at(x, x->k - j - 1);
        const vec3_t wo = vec3_neg(w);
        w = path_direction(at, next);
        if (!path_invert_scattering(ps, x, x->k - j, wo, w, BSDF_RADIANCE, u))
            return false;
        at = next;
    }
    return true;
}

/* Which environment light made the direction: in proportion to their densities. What is left of *number is uniform.
 */
static bool path_draw_infinite(const path_scene_t *ps, vec3_t to_light, double *number, uint32_t *emitter)
{
    const light_set_t *lights = &ps->lights;
    double density[LIGHT_MAX_INFINITE], sum = 0;
    for (int32_t i = 0; i < lights->infinite_count; i++) {
        light_infinite_radiance(lights, ps->scene, lights->infinite[i], to_light, &density[i]);
        sum += density[i];
    }
    if (!(sum > 0))
        return false;
    double place = *number * sum, left = 0;
    int32_t drawn = -1;
    for (int32_t i = 0; i < lights->infinite_count; i++) {
        if (!(density[i] > 0))
            continue;
        drawn = i;
        left = place / density[i];
        if (place < density[i])
            break;
        place -= density[i];
    }
    *number = warp_clamp_unit(left);
    *emitter = lights->infinite[drawn];
    return true;
}

/* Numbers of y_0 unless kept, and of the direction to y_1 if wanted; on entry the free ones. */
static bool path_invert_origin(const path_scene_t *ps, const path_whole_t *x, bool kept, bool direction, double *u)
{
    const path_vertex_t *y = path_at(x, 0), *next = path_at(x, 1);
    double number[3] = {u[0], u[1], u[2]};
    light_sample_t at = {.emitter = y->emitter, .position = y->position, .normal = y->ng, .to_light = y->ng};
    if (!kept) {
        if (y->kind == PATH_INFINITE && !y->delta && !path_draw_infinite(ps, y->ng, &number[0], &at.emitter))
            return false;
        if (at.emitter == PATH_NO_EMITTER ||
            !light_invert_position(&ps->lights, ps->scene, &at, number, &u[0], &u[1]))
            return false;
    }
    if (!direction)
        return true;
    const double unused[2] = {u[3], u[4]};
    return light_invert_direction(&ps->lights, ps->scene, &at, next->position, path_direction(y, next), unused,
                                  &u[3]);
}

/* y_0 .. y_{s-1} = x_0 .. x_{s-1}. The first `kept` of them are those of the walk that u already makes. */
static bool path_invert_light(const path_scene_t *ps, const path_whole_t *x, uint32_t s, uint32_t kept, double *u)
{
    if (s > 0 && kept < 2 && !path_invert_origin(ps, x, kept == 1, s > 1, u))
        return false;
    const uint32_t first = kept > 2 ? kept - 1 : 1; /* y to scatter at */
    if (first + 1 >= s)
        return true;
    u += PATH_LIGHT_DIMENSIONS + (size_t)BSDF_DIMENSIONS * (first - 1);
    const path_vertex_t *at = path_at(x, first);
    vec3_t w = path_direction(path_at(x, first - 1), at);
    for (uint32_t j = first; j + 1 < s; j++, u += BSDF_DIMENSIONS) {
        const path_vertex_t *next = path_at(x, j + 1);
        const vec3_t wo = vec3_neg(w);
        w = path_direction(at, next);
        if (!path_invert_scattering(ps, x, j, wo, w, BSDF_IMPORTANCE, u))
            return false;
        at = next;
    }
    return true;
}

/* Fills what is not kept with free numbers; each inverse then reads its own ones and sets them. A camera walk of
 * one vertex keeps its lens numbers, behind the film's. */
static void path_free_numbers(const path_scene_t *ps, uint32_t k, uint32_t kept_light, uint32_t kept_camera,
                              uint64_t key, double *camera, double *light)
{
    const uint32_t camera_count = path_camera_dimensions(ps, k + 1), light_count = path_light_dimensions(k);
    if (kept_camera == 1) {
        camera[0] = random_double(key, 0);
        camera[1] = random_double(key, 1);
    }
    const uint32_t begin = kept_camera > 1 ? path_camera_dimensions(ps, kept_camera)
                           : kept_camera   ? ps->camera_dimensions
                                           : 0;
    for (uint32_t i = begin; i < camera_count; i++)
        camera[i] = random_double(key, i);
    for (uint32_t i = path_light_dimensions(kept_light); i < light_count; i++)
        light[i] = random_double(key, PATH_MAX_DIMENSIONS + i);
}

bool path_invert(const path_scene_t *ps, const path_space_t *space, uint32_t s, uint32_t t, uint32_t s_new,
                 uint64_t key, double *camera, double *light)
{
    const uint32_t k = s + t - 1;
    const path_whole_t x = path_whole_of(space, s, k);
    if (!path_is_open(&x, s_new))
        return false;
    path_free_numbers(ps, k, 0, 0, key, camera, light);
    return path_invert_camera(ps, &x, k + 1 - s_new, 0, camera) && path_invert_light(ps, &x, s_new, 0, light);
}

bool path_invert_jump(const path_scene_t *ps, const path_space_t *space, uint32_t s, uint32_t t, uint32_t s_new,
                      uint64_t key, double *camera, double *light)
{
    const uint32_t k = s + t - 1, t_new = k + 1 - s_new;
    const path_whole_t x = path_whole_of(space, s, k);
    if (!path_is_open(&x, s_new))
        return false;
    const uint32_t kept_light = s < s_new ? s : s_new, kept_camera = t < t_new ? t : t_new;
    path_free_numbers(ps, k, kept_light, kept_camera, key, camera, light);
    return path_invert_camera(ps, &x, t_new, kept_camera, camera) &&
           path_invert_light(ps, &x, s_new, kept_light, light);
}

/* ---- the round trip ---- */

/* Distance between two vertices that ought to be one; of directions where they are at infinity. */
static double path_distance(const path_vertex_t *a, const path_vertex_t *b)
{
    return a->kind == PATH_INFINITE ? vec3_length(vec3_sub(a->ng, b->ng))
                                    : vec3_length(vec3_sub(a->position, b->position));
}

/* Length of the segment x_i x_{i+1}; infinite to infinity. */
static double path_segment(const path_whole_t *x, uint32_t i)
{
    const path_vertex_t *a = path_at(x, i), *b = path_at(x, i + 1);
    return a->kind == PATH_INFINITE ? HUGE_VAL : vec3_length(vec3_sub(a->position, b->position));
}

/* Whether x_i and y_i are vertices of the same kind. */
static bool path_same_kind(const path_whole_t *x, const path_whole_t *y, uint32_t i)
{
    const path_vertex_t *a = path_at(x, i), *b = path_at(y, i);
    if ((a->kind == PATH_INFINITE) != (b->kind == PATH_INFINITE))
        return false;
    if (i == 0) /* environment lights are one light */
        return (a->kind == PATH_INFINITE && !path_on_delta_light(a) && !path_on_delta_light(b)) ||
               a->emitter == b->emitter;
    const bool specular = path_is_specular(x, i);
    return specular == path_is_specular(y, i) && (!specular || a->lobe == b->lobe);
}

static path_inverse_failure_t path_compare(const path_whole_t *x, const path_whole_t *y, double *error)
{
    double before = HUGE_VAL;
    bool moved = false;
    *error = 0;
    for (uint32_t i = 0; i <= x->k; i++) {
        if (!path_same_kind(x, y, i))
            return PATH_INVERSE_KIND;
        const path_vertex_t *a = path_at(x, i);
        const double after = i < x->k ? path_segment(x, i) : HUGE_VAL;
        const bool infinite = a->kind == PATH_INFINITE;
        const double reach = infinite ? 1 : fmin(before, after);
        const double distance = path_distance(a, path_at(y, i));
        const double floor = infinite ? 0 : PATH_INVERSE_FLOOR * vec3_max_abs(a->position);
        if (!(distance <= fmax(PATH_INVERSE_TOLERANCE * reach, floor)))
            moved = true;
        *error = fmax(*error, distance / reach);
        before = after;
    }
    return moved ? PATH_INVERSE_MOVED : PATH_INVERSE_AGREES;
}

path_inverse_failure_t path_verify(const path_scene_t *ps, const path_space_t *space, uint32_t s, uint32_t t,
                                   path_space_t *other, uint32_t s_new, const double *camera, const double *light,
                                   const path_techniques_t *techniques, path_check_t *out)
{
    const uint32_t k = s + t - 1, t_new = k + 1 - s_new;
    out->error = HUGE_VAL;
    if (path_walk_camera(ps, other, camera, t_new, PATH_ENDS_ANYWHERE) < t_new ||
        (s_new > 0 && path_walk_light(ps, other, light, s_new, PATH_ENDS_ANYWHERE) < s_new))
        return PATH_INVERSE_SHORT;
    const path_whole_t x = path_whole_of(space, s, k), y = path_whole_of(other, s_new, k);
    const path_inverse_failure_t failure = path_compare(&x, &y, &out->error);
    if (failure)
        return failure;
    return path_connect(ps, other, s_new, t_new, NULL, techniques, &out->value) ? PATH_INVERSE_AGREES
                                                                                : PATH_INVERSE_CARRIES_NOTHING;
}
