#include "reference.h"

#include <string.h>

typedef long double real_t;

/* A vertex of the whole path, x_0 on the light .. x_k on the lens. */
typedef struct point {
    const path_vertex_t *v;
    bool specular;
    frame_t frame;
    vec3_t to_light, to_camera;         /* unit; to x_{i-1}, x_{i+1} */
    real_t f[3];                        /* scattering: f |to_light.ns| / |to_light.ng|; specular: its coefficient */
    real_t pdf_to_light, pdf_to_camera; /* per solid angle (specular: per n^2 |cos| d omega) */
} point_t;

static real_t area_of(const point_t *from, const point_t *to, vec3_t w)
{
    const real_t cosine = fabs(vec3_dot(to->v->ng, w));
    if (from->v->kind == PATH_INFINITE)
        return cosine;
    if (to->v->kind == PATH_INFINITE)
        return 1;
    const vec3_t d = vec3_sub(to->v->position, from->v->position);
    const real_t d2 = (real_t)d.x * d.x + (real_t)d.y * d.y + (real_t)d.z * d.z;
    return cosine / d2;
}

static bool scatter_smooth(const path_scene_t *ps, point_t *x, vec3_t wl, vec3_t wc)
{
    bsdf_value_t camera, light;
    bsdf_eval(x->v->bsdf, ps->tables, wc, wl, BSDF_RADIANCE, &camera);
    bsdf_eval(x->v->bsdf, ps->tables, wl, wc, BSDF_IMPORTANCE, &light);
    const real_t turn = fabsl((real_t)wl.z / vec3_dot(x->to_light, x->v->ng));
    x->f[0] = camera.f.r * turn;
    x->f[1] = camera.f.g * turn;
    x->f[2] = camera.f.b * turn;
    x->pdf_to_light = camera.pdf;
    x->pdf_to_camera = light.pdf;
    return camera.pdf > 0;
}

static bool scatter_specular(const path_scene_t *ps, point_t *x, vec3_t wl, vec3_t wc)
{
    const double half[3] = {0.5, 0.5, 0.5};
    for (uint32_t lobe = 0; lobe < x->v->bsdf->count; lobe++) {
        double u[3];
        bsdf_sample_t to_light, to_camera;
        if (!BSDF_KIND_IS_SPECULAR(x->v->bsdf->lobes[lobe].kind) ||
            !bsdf_invert(x->v->bsdf, ps->tables, wc, wl, true, lobe, BSDF_RADIANCE, half, u) ||
            !bsdf_sample(x->v->bsdf, ps->tables, wc, u, BSDF_RADIANCE, &to_light) ||
            !bsdf_invert(x->v->bsdf, ps->tables, wl, wc, true, lobe, BSDF_IMPORTANCE, half, u) ||
            !bsdf_sample(x->v->bsdf, ps->tables, wl, u, BSDF_IMPORTANCE, &to_camera))
            continue;
        const real_t n2 = (real_t)to_light.eta * to_light.eta; /* of the light's side over the camera's */
        const real_t measure = fabsl((real_t)wl.z) * n2 / fabs(vec3_dot(x->to_light, x->v->ng));
        x->f[0] = (real_t)to_light.weight.r * to_light.pdf * measure;
        x->f[1] = (real_t)to_light.weight.g * to_light.pdf * measure;
        x->f[2] = (real_t)to_light.weight.b * to_light.pdf * measure;
        x->pdf_to_light = (real_t)to_light.pdf * fabsl((real_t)wl.z) * n2;
        x->pdf_to_camera = (real_t)to_camera.pdf * fabsl((real_t)wc.z);
        return true;
    }
    return false;
}

static vec3_t direction(const point_t *from, const point_t *to)
{
    if (to->v->kind == PATH_INFINITE)
        return to->v->ng;
    if (from->v->kind == PATH_INFINITE)
        return vec3_neg(from->v->ng);
    return vec3_unit(vec3_sub(to->v->position, from->v->position));
}

/* Emission, position and direction densities of x_0. */
static bool light_terms(const path_scene_t *ps, const point_t *x, real_t le[3], real_t *position, real_t *angle)
{
    const light_set_t *lights = &ps->lights;
    const path_vertex_t *v = x->v;
    rgb_t emitted = rgb_gray(0);
    double pdf = 0;
    if (v->kind == PATH_INFINITE && v->delta) {
        emitted = lights->emitters[v->emitter].radiance;
        *position = lights->emitters[v->emitter].probability;
        *angle = 1 / (MATH_PI * lights->scene_radius * lights->scene_radius);
    } else if (v->kind == PATH_INFINITE) {
        *position = 0;
        for (int32_t i = 0; i < lights->infinite_count; i++) {
            emitted =
                rgb_add(emitted, light_infinite_radiance(lights, ps->scene, lights->infinite[i], v->ng, &pdf));
            *position += pdf;
        }
        *angle = 1 / (MATH_PI * lights->scene_radius * lights->scene_radius);
    } else {
        if (v->emitter == PATH_NO_EMITTER)
            return false;
        emitted = light_eval(lights, ps->scene, v->emitter, v->ng, x->to_camera, &pdf);
        *position = light_pdf_position(lights, v->emitter);
        *angle = pdf;
    }
    le[0] = emitted.r;
    le[1] = emitted.g;
    le[2] = emitted.b;
    return true;
}

static bool collect(const path_scene_t *ps, const path_space_t *space, uint32_t s, uint32_t t, point_t *x)
{
    const uint32_t k = s + t - 1;
    for (uint32_t i = 0; i <= k; i++) {
        x[i].v = i < s ? &space->light[i] : &space->camera[k - i];
        x[i].specular = i + 1 != s && i != s && x[i].v->specular;
    }
    for (uint32_t i = 0; i <= k; i++) {
        if (i > 0)
            x[i].to_light = direction(&x[i], &x[i - 1]);
        if (i < k)
            x[i].to_camera = direction(&x[i], &x[i + 1]);
        if (i == 0 || i == k)
            continue;
        if (!x[i].v->bsdf)
            return false;
        const bool only_normal = (x[i].v->bsdf->flags & BSDF_ONLY_DIFFUSE) != 0;
        x[i].frame = only_normal ? frame_of_normal(x[i].v->frame.n) : x[i].v->frame;
        const vec3_t wl = frame_to_local(&x[i].frame, x[i].to_light),
                     wc = frame_to_local(&x[i].frame, x[i].to_camera);
        if (!(x[i].specular ? scatter_specular : scatter_smooth)(ps, &x[i], wl, wc))
            return false;
    }
    return true;
}

void reference_evaluate(const path_scene_t *ps, const path_space_t *space, uint32_t s, uint32_t t,
                        const path_techniques_t *techniques, reference_t *out)
{
    memset(out, 0, sizeof *out);
    static point_t x[PATH_MAX_VERTICES];
    const uint32_t k = s + t - 1;
    camera_value_t camera;
    real_t le[3], light_position, light_angle;
    if (!collect(ps, space, s, t, x) || !light_terms(ps, &x[0], le, &light_position, &light_angle) ||
        !camera_eval(&ps->camera, x[k].v->position, x[k].to_light, &camera))
        return;
    /* f: importance, emission, geometry and scattering */
    const bool point_light = x[0].v->kind == PATH_LIGHT && x[0].v->delta;
    for (int c = 0; c < 3; c++) {
        out->f[c] = le[c] * camera.importance;
        for (uint32_t i = 1; i < k; i++)
            out->f[c] *= x[i].f[c];
        for (uint32_t i = 0; i < k; i++) { /* G between x_i and x_{i+1} */
            out->f[c] *= area_of(&x[i], &x[i + 1], x[i].to_camera);
            if (x[i].v->kind != PATH_INFINITE && !(i == 0 && point_light))
                out->f[c] *= fabsl((real_t)vec3_dot(x[i].v->ng, x[i].to_camera));
        }
    }
    const real_t lens = ps->camera.pinhole ? 1 : 1 / (real_t)ps->camera.lens_area;
    for (uint32_t j = 0; j <= k; j++) { /* x_0 .. x_{j-1} from the light, the rest from the camera */
        if (!techniques->allowed[j] || (j == 0 && x[0].v->delta) || (j > 0 && (x[j - 1].specular || x[j].specular)))
            continue;
        real_t p = lens;
        for (uint32_t i = 0; i < j; i++)
            p *= i == 0 ? light_position
                        : (i == 1 ? light_angle : x[i - 1].pdf_to_camera) *
                              area_of(&x[i - 1], &x[i], x[i - 1].to_camera);
        for (uint32_t i = k; i-- > j;)
            p *= (i + 1 == k ? (real_t)camera.pdf_direction : x[i + 1].pdf_to_light) *
                 area_of(&x[i + 1], &x[i], x[i + 1].to_light);
        out->p[j] = p;
        out->sum += p;
    }
    out->valid = true;
}
