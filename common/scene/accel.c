#include "scene/accel.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pages.h"
#include "base/random.h"
#include "scene/accel_core.h"
#include "scene/surface.h"
#include "scene/texture.h"

/* What a geometry's callbacks need to know: its user data. */
typedef struct accel_geometry {
    const accel_t *accel;
    uint32_t shape; /* of a mesh */
} accel_geometry_t;

/* The ray as the caller gave it, for the callbacks: the line through `place`, from the origin on. */
typedef struct accel_context {
    struct RTCIntersectContext embree; /* first: Embree passes its address */
    vec3_t place, origin, direction;
} accel_context_t;

struct accel {
    RTCDevice device;
    RTCScene scene;
    const scene_t *data;
    accel_geometry_t *geometries; /* one a mesh shape */
    uint32_t *analytic;           /* shapes of the user geometry (spheres, disks), by primitive */
    uint32_t analytic_count, analytic_id;
    uint32_t *shape_of_geometry;
    float *corners;        /* of all meshes' triangles: position (and normal) of each corner */
    size_t *shape_corners; /* by shape: where its corners begin */
    accel_core_t core;
    _Atomic size_t bytes;
};

static bool accel_memory(void *user, ssize_t bytes, bool post)
{
    (void)post;
    ((accel_t *)user)->bytes += (size_t)bytes;
    return true;
}

/* ---- spheres and disks: user geometry, in double ---- */

/* By what fraction of the scene's largest coordinate Embree's ray may miss what the line meets: it starts off the
 * surface by SURFACE_EPSILON of a coordinate and is rounded, from twice the extent at most (light from infinity).
 */
#define ACCEL_WIDENED (4 * SURFACE_EPSILON)

static void analytic_bounds(const struct RTCBoundsFunctionArguments *args)
{
    const accel_t *accel = args->geometryUserPtr;
    const scene_shape_t *shape = &accel->data->shapes[accel->analytic[args->primID]];
    float half[3];
    for (int axis = 0; axis < 3; axis++) {
        const float n = shape->normal[axis];
        half[axis] = shape->kind == SCENE_SHAPE_SPHERE ? shape->radius : shape->radius * sqrtf(fmaxf(0, 1 - n * n));
        half[axis] += (float)(ACCEL_WIDENED * accel->core.extent) + 1e-30f;
    }
    const float *c = shape->centre;
    *args->bounds_o = (struct RTCBounds){c[0] - half[0], c[1] - half[1], c[2] - half[2], 0,
                                         c[0] + half[0], c[1] + half[1], c[2] + half[2], 0};
}

/* Where the line meets a primitive beyond its origin: parameters from `place` on, in order. */
typedef struct accel_roots {
    double t[2];
    bool leaves[2];
    int count;
} accel_roots_t;

/* Half-b form; the discriminant from the distance of the line to the centre, which does not cancel (Hearn and
 * Baker; Haines et al., Ray Tracing Gems, chapter 7). Which roots lie beyond the origin is what the origin says,
 * inside or outside, as it was moved off the sphere if the ray starts there. */
static void analytic_sphere(const scene_shape_t *shape, const accel_context_t *ray, accel_roots_t *roots)
{
    const vec3_t centre = vec3(shape->centre[0], shape->centre[1], shape->centre[2]), d = ray->direction;
    const vec3_t f = vec3_sub(ray->place, centre), from = vec3_sub(ray->origin, centre);
    const double r = shape->radius, a = vec3_dot(d, d), b = -vec3_dot(f, d);
    const vec3_t l = vec3_mad(f, b / a, d);
    const double discriminant = r * r - vec3_dot(l, l);
    const bool inside = vec3_dot(from, from) < r * r;
    roots->count = 0;
    if (discriminant < 0 || (!inside && vec3_dot(from, d) >= 0))
        return;
    const double half = sqrt(discriminant / a);
    if (!inside) {
        roots->t[0] = b / a - half;
        roots->leaves[0] = false;
        roots->count = 1;
    }
    roots->t[roots->count] = b / a + half;
    roots->leaves[roots->count++] = true;
}

static void analytic_disk(const scene_shape_t *shape, const accel_context_t *ray, accel_roots_t *roots)
{
    const vec3_t n = vec3(shape->normal[0], shape->normal[1], shape->normal[2]);
    const vec3_t centre = vec3(shape->centre[0], shape->centre[1], shape->centre[2]);
    const vec3_t f = vec3_sub(ray->place, centre);
    const double cosine = vec3_dot(n, ray->direction);
    roots->count = 0;
    /* the origin, moved off the disk if the ray starts there, must lie on the side that the ray comes from */
    if (!(vec3_dot(n, vec3_sub(ray->origin, centre)) * cosine < 0))
        return;
    roots->t[0] = -vec3_dot(n, f) / cosine;
    roots->leaves[0] = false;
    const vec3_t p = vec3_mad(f, roots->t[0], ray->direction);
    roots->count = vec3_dot(p, p) <= (double)shape->radius * shape->radius;
}

/* Opacity is looked at only where a shape is not opaque throughout. Emitters are: a point chosen on one is there.
 */
static bool accel_shape_has_opacity(const scene_shape_t *shape)
{
    return shape->area_light < 0 && (shape->alpha.texture >= 0 || shape->alpha.value[0] < 1);
}

/* Whether a hit with these texture coordinates counts, on a shape with opacity. */
static bool accel_opaque(const accel_t *accel, uint32_t shape, uint32_t primitive, double u, double v,
                         const struct RTCRay *ray, double t)
{
    const double opacity = texture_param_scalar(accel->data, &accel->data->shapes[shape].alpha, u, v);
    if (opacity >= 1)
        return true;
    if (opacity <= 0)
        return false;
    uint32_t bits[3];
    const float place[3] = {ray->org_x + (float)t * ray->dir_x, ray->org_y + (float)t * ray->dir_y,
                            ray->org_z + (float)t * ray->dir_z};
    memcpy(bits, place, sizeof bits);
    const uint64_t key =
        random_mix(((uint64_t)bits[0] << 32 | bits[1]) + RANDOM_GAMMA) ^ ((uint64_t)bits[2] << 32 | shape);
    return random_double(key, primitive) < opacity;
}

/* The nearest hit that counts: of a sphere with opacity that may be the far side. *t in the parameter of Embree's
 * ray, which starts at the origin. */
static bool analytic_hit(const accel_t *accel, uint32_t primitive, const struct RTCRay *ray,
                         const accel_context_t *line, double *t, bool *leaves)
{
    const uint32_t index = accel->analytic[primitive];
    const scene_shape_t *shape = &accel->data->shapes[index];
    const double begin =
        vec3_dot(vec3_sub(line->origin, line->place), line->direction) / vec3_dot(line->direction, line->direction);
    accel_roots_t roots;
    (shape->kind == SCENE_SHAPE_SPHERE ? analytic_sphere : analytic_disk)(shape, line, &roots);
    for (int i = 0; i < roots.count; i++) {
        *t = math_max(roots.t[i] - begin, 0);
        *leaves = roots.leaves[i];
        if (!(*t < (double)ray->tfar))
            continue;
        if (!accel_shape_has_opacity(shape))
            return true;
        surface_t at = {.u = 0};
        const accel_hit_t hit = {.shape = index, .t = *t, .leaves = *leaves};
        if (shape->alpha.texture >= 0)
            surface_at_hit(accel->data, &hit, line->place, line->direction, true, &at);
        if (accel_opaque(accel, index, 0, at.u, at.v, ray, *t))
            return true;
    }
    return false;
}

static void analytic_intersect(const struct RTCIntersectFunctionNArguments *args)
{
    if (!args->valid[0])
        return;
    const accel_t *accel = args->geometryUserPtr;
    struct RTCRayHit *rayhit = (struct RTCRayHit *)args->rayhit; /* N = 1: only single rays are traced */
    double t;
    bool leaves;
    if (!analytic_hit(accel, args->primID, &rayhit->ray, (const accel_context_t *)args->context, &t, &leaves))
        return;
    rayhit->ray.tfar = (float)t;
    rayhit->hit.Ng_x = 0;
    rayhit->hit.Ng_y = 0;
    rayhit->hit.Ng_z = 1;
    rayhit->hit.u = leaves ? 1 : 0;
    rayhit->hit.v = 0;
    rayhit->hit.primID = args->primID;
    rayhit->hit.geomID = args->geomID;
    rayhit->hit.instID[0] = args->context->instID[0];
}

static void analytic_occluded(const struct RTCOccludedFunctionNArguments *args)
{
    if (!args->valid[0])
        return;
    const accel_t *accel = args->geometryUserPtr;
    struct RTCRay *ray = (struct RTCRay *)args->ray;
    double t;
    bool leaves;
    if (!analytic_hit(accel, args->primID, ray, (const accel_context_t *)args->context, &t, &leaves))
        return;
    ray->tfar = -INFINITY;
}

/* ---- meshes ---- */

static void mesh_filter(const struct RTCFilterFunctionNArguments *args)
{
    const accel_geometry_t *geometry = args->geometryUserPtr;
    const struct RTCRay *ray = (const struct RTCRay *)args->ray; /* N = 1 */
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    if (args->valid[0] != -1)
        return;
    const scene_t *scene = geometry->accel->data;
    const scene_shape_t *shape = &scene->shapes[geometry->shape];
    const double b1 = hit->u, b2 = hit->v;
    double u = b1 + b2, v = b2; /* (0,0), (1,0), (1,1) */
    if (shape->flags & SCENE_SHAPE_UVS) {
        const uint32_t *corner = scene->indices + 3 * ((size_t)shape->first_triangle + hit->primID);
        const float *uv[3];
        for (int i = 0; i < 3; i++)
            uv[i] = scene->uvs + 2 * ((size_t)shape->first_vertex + corner[i]);
        u = (1 - b1 - b2) * uv[0][0] + b1 * uv[1][0] + b2 * uv[2][0];
        v = (1 - b1 - b2) * uv[0][1] + b1 * uv[1][1] + b2 * uv[2][1];
    }
    if (!accel_opaque(geometry->accel, geometry->shape, hit->primID, u, v, ray, ray->tfar))
        args->valid[0] = 0;
}

static fault_code_t accel_device_fault(const accel_t *accel, fault_t *fault)
{
    const enum RTCError error = accel->device ? rtcGetDeviceError(accel->device) : rtcGetDeviceError(NULL);
    return fault_set(fault, error == RTC_ERROR_OUT_OF_MEMORY ? FAULT_MEMORY : FAULT_UNSUPPORTED,
                     "Embree: error %d while building the scene", (int)error);
}

static uint32_t accel_corner_floats(const scene_shape_t *shape)
{
    return shape->flags & SCENE_SHAPE_NORMALS ? 6 : 3;
}

/* The table of corners. */
static fault_code_t accel_fill_corners(accel_t *accel, fault_t *fault)
{
    const scene_t *scene = accel->data;
    size_t floats = 0;
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        accel->shape_corners[i] = floats;
        floats += scene->shapes[i].kind == SCENE_SHAPE_MESH
                      ? 3 * (size_t)accel_corner_floats(&scene->shapes[i]) * scene->shapes[i].triangles
                      : 0;
    }
    accel->corners = pages_new(floats + 4, sizeof *accel->corners); /* Embree reads 16 bytes at the last corner */
    if (!accel->corners)
        return fault_set(fault, FAULT_MEMORY, "no memory for the corners of %llu triangles",
                         (unsigned long long)scene->triangle_count);
    accel->bytes += (floats + 4) * sizeof *accel->corners;
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const scene_shape_t *shape = &scene->shapes[i];
        float *to = accel->corners + accel->shape_corners[i];
        const uint32_t *corner = scene->indices + 3 * (size_t)shape->first_triangle;
        const uint32_t stride = accel_corner_floats(shape);
        for (size_t j = 0; shape->kind == SCENE_SHAPE_MESH && j < 3 * (size_t)shape->triangles; j++, to += stride) {
            const size_t vertex = shape->first_vertex + (size_t)corner[j];
            memcpy(to, scene->positions + 3 * vertex, 3 * sizeof(float));
            if (stride == 6)
                memcpy(to + 3, scene->normals + 3 * vertex, 3 * sizeof(float));
        }
    }
    return FAULT_NONE;
}

static fault_code_t accel_add_mesh(accel_t *accel, uint32_t index, fault_t *fault)
{
    const scene_t *scene = accel->data;
    const scene_shape_t *shape = &scene->shapes[index];
    RTCGeometry geometry = rtcNewGeometry(accel->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const uint32_t stride = accel_corner_floats(shape) * sizeof(float);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               accel->corners + accel->shape_corners[index], 0, stride,
                               3 * (size_t)shape->triangles);
    uint32_t *indices =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, shape->triangles);
    if (!indices) {
        rtcReleaseGeometry(geometry);
        return accel_device_fault(accel, fault);
    }
    for (uint32_t i = 0; i < 3 * shape->triangles; i++)
        indices[i] = i;
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    accel->geometries[index] = (accel_geometry_t){accel, index};
    rtcSetGeometryUserData(geometry, &accel->geometries[index]);
    if (accel_shape_has_opacity(shape)) {
        rtcSetGeometryIntersectFilterFunction(geometry, mesh_filter);
        rtcSetGeometryOccludedFilterFunction(geometry, mesh_filter);
    }
    rtcCommitGeometry(geometry);
    const uint32_t id = rtcAttachGeometry(accel->scene, geometry);
    rtcReleaseGeometry(geometry);
    accel->shape_of_geometry[id] = index;
    return FAULT_NONE;
}

static void accel_add_analytic(accel_t *accel)
{
    RTCGeometry geometry = rtcNewGeometry(accel->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, accel->analytic_count);
    rtcSetGeometryUserData(geometry, accel);
    rtcSetGeometryBoundsFunction(geometry, analytic_bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, analytic_intersect);
    rtcSetGeometryOccludedFunction(geometry, analytic_occluded);
    rtcCommitGeometry(geometry);
    accel->analytic_id = rtcAttachGeometry(accel->scene, geometry);
    rtcReleaseGeometry(geometry);
}

fault_code_t accel_new(accel_t **out, const scene_t *scene, fault_t *fault)
{
    accel_t *accel = calloc(1, sizeof *accel);
    if (!accel)
        return fault_set(fault, FAULT_MEMORY, "no memory for the accelerator");
    accel->data = scene;
    accel->analytic_id = RTC_INVALID_GEOMETRY_ID;
    accel_core_init(&accel->core, scene);
    accel->geometries = calloc(scene->shape_count + 1, sizeof *accel->geometries);
    accel->analytic = calloc(scene->shape_count + 1, sizeof *accel->analytic);
    accel->shape_of_geometry = calloc(scene->shape_count + 1, sizeof *accel->shape_of_geometry);
    accel->shape_corners = calloc(scene->shape_count + 1, sizeof *accel->shape_corners);
    fault_code_t code = FAULT_NONE;
    if (!accel->geometries || !accel->analytic || !accel->shape_of_geometry || !accel->shape_corners) {
        code = fault_set(fault, FAULT_MEMORY, "no memory for %u shapes", scene->shape_count);
        goto cleanup;
    }
    code = accel_fill_corners(accel, fault);
    if (code)
        goto cleanup;
    accel->device = rtcNewDevice("threads=1,set_affinity=0");
    if (!accel->device) {
        code = accel_device_fault(accel, fault);
        goto cleanup;
    }
    rtcSetDeviceMemoryMonitorFunction(accel->device, accel_memory, accel);
    accel->scene = rtcNewScene(accel->device);
    rtcSetSceneFlags(accel->scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(accel->scene, RTC_BUILD_QUALITY_HIGH);
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const scene_shape_t *shape = &scene->shapes[i];
        if (scene->materials[shape->material].kind == SCENE_MATERIAL_INTERFACE && shape->area_light < 0)
            continue;
        if (shape->kind != SCENE_SHAPE_MESH)
            accel->analytic[accel->analytic_count++] = i;
        else if (shape->triangles > 0) {
            code = accel_add_mesh(accel, i, fault);
            if (code)
                goto cleanup;
        }
    }
    if (accel->analytic_count > 0)
        accel_add_analytic(accel);
    rtcCommitScene(accel->scene);
    if (rtcGetDeviceError(accel->device) != RTC_ERROR_NONE)
        code = fault_set(fault, FAULT_MEMORY, "Embree could not build the scene");
cleanup:
    if (code)
        accel_destroy(&accel);
    *out = accel;
    return code;
}

void accel_destroy(accel_t **accel)
{
    if (!*accel)
        return;
    if ((*accel)->scene)
        rtcReleaseScene((*accel)->scene);
    if ((*accel)->device)
        rtcReleaseDevice((*accel)->device);
    free((*accel)->geometries);
    free((*accel)->analytic);
    free((*accel)->shape_of_geometry);
    free((*accel)->shape_corners);
    free((*accel)->corners);
    free(*accel);
    *accel = NULL;
}

/* Embree's assertions abort beyond about 1e18. One comparison for six numbers: a sum with a NaN is one. */
static bool accel_ray_sound(vec3_t o, vec3_t d)
{
    return (fabs(o.x) + fabs(d.x)) + (fabs(o.y) + fabs(d.y)) + (fabs(o.z) + fabs(d.z)) < 1e18;
}

static struct RTCRay accel_ray(vec3_t origin, vec3_t direction, float far)
{
    return (struct RTCRay){.org_x = (float)origin.x,
                           .org_y = (float)origin.y,
                           .org_z = (float)origin.z,
                           .dir_x = (float)direction.x,
                           .dir_y = (float)direction.y,
                           .dir_z = (float)direction.z,
                           .tnear = 0,
                           .tfar = far,
                           .mask = UINT32_MAX};
}

/* Embree's nearest hit up to `far`; false if there is none. */
static bool accel_trace(const accel_t *accel, accel_context_t *context, float far, struct RTCRayHit *rayhit)
{
    rayhit->ray = accel_ray(context->origin, context->direction, far);
    rayhit->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayhit->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcInitIntersectContext(&context->embree);
    rtcIntersect1(accel->scene, &context->embree, rayhit);
    return rayhit->hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

accel_answer_t accel_intersect_line(const accel_t *accel, vec3_t place, vec3_t origin, vec3_t direction,
                                    accel_hit_t *hit)
{
    if (!accel_ray_sound(origin, direction))
        return ACCEL_BAD_RAY;
    accel_context_t context = {.place = place, .origin = origin, .direction = direction};
    struct RTCRayHit rayhit;
    const double enters = accel->core.exists ? accel_core_entry(&accel->core, place, direction) : 0;
    double begin = 0;
    bool found =
        accel_trace(accel, &context,
                    enters > 0 ? (float)(enters + ACCEL_CORE_OVERLAP * accel->core.extent) : INFINITY, &rayhit);
    if (!found && enters > 0) {
        begin = enters;
        context.origin = vec3_mad(place, begin, direction);
        found = accel_trace(accel, &context, INFINITY, &rayhit);
    }
    if (!found)
        return ACCEL_MISS;
    const bool analytic = rayhit.hit.geomID == accel->analytic_id;
    hit->shape = analytic ? accel->analytic[rayhit.hit.primID] : accel->shape_of_geometry[rayhit.hit.geomID];
    hit->primitive = analytic ? 0 : rayhit.hit.primID;
    hit->t = begin + (double)rayhit.ray.tfar;
    hit->leaves = analytic && rayhit.hit.u > 0;
    const scene_shape_t *shape = &accel->data->shapes[hit->shape];
    hit->corners = analytic ? NULL
                            : accel->corners + accel->shape_corners[hit->shape] +
                                  3 * (size_t)accel_corner_floats(shape) * hit->primitive;
    return ACCEL_HIT;
}

accel_answer_t accel_intersect(const accel_t *accel, vec3_t origin, vec3_t direction, accel_hit_t *hit)
{
    return accel_intersect_line(accel, origin, origin, direction, hit);
}

static accel_answer_t accel_any(const accel_t *accel, vec3_t origin, vec3_t direction, float far)
{
    if (!accel_ray_sound(origin, direction))
        return ACCEL_BAD_RAY;
    struct RTCRay ray = accel_ray(origin, direction, far);
    accel_context_t context = {.place = origin, .origin = origin, .direction = direction};
    rtcInitIntersectContext(&context.embree);
    rtcOccluded1(accel->scene, &context.embree, &ray);
    return ray.tfar < 0 ? ACCEL_HIT : ACCEL_MISS;
}

/* Whether the segment is traced from the first point: from the one whose coordinates are smaller, so that the
 * answer does not depend on the direction, and the other end is met: with coordinates below x there, the roundings
 * of origin and direction move it by at most 3 2^-24 x, a fifth of its distance off the surface. */
static bool accel_order(vec3_t a, vec3_t b)
{
    const double x = vec3_max_abs(a), y = vec3_max_abs(b);
    if (x != y)
        return x < y;
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

accel_answer_t accel_occluded(const accel_t *accel, vec3_t from, vec3_t to)
{
    return accel_order(from, to) ? accel_any(accel, from, vec3_sub(to, from), 1)
                                 : accel_any(accel, to, vec3_sub(from, to), 1);
}

accel_answer_t accel_occluded_beyond(const accel_t *accel, vec3_t origin, vec3_t direction)
{
    return accel_any(accel, origin, direction, INFINITY);
}

size_t accel_bytes(const accel_t *accel)
{
    return accel->bytes;
}
