/* Ray queries against brute force in double precision, leaks, self-intersection, bad rays, opacity, and the point,
 * texture coordinates and tangent of a hit. */
#include "math/sampling.h"
#include "scene/accel.h"
#include "scene/surface.h"
#include "support/small_scenes.h"

static accel_t *accel_of(const scene_t *scene)
{
    accel_t *accel = NULL;
    fault_t fault = {0};
    if (accel_new(&accel, scene, &fault))
        fail_msg("%s", fault.text);
    return accel;
}

static vec3_t of_floats(const float *p)
{
    return vec3(p[0], p[1], p[2]);
}

static vec3_t stream_point(stream_t *stream, double half)
{
    const double x = stream_number(stream), y = stream_number(stream), z = stream_number(stream);
    return vec3(half * (2 * x - 1), half * (2 * y - 1), half * (2 * z - 1));
}

/* ---- brute force ---- */

enum { CLOUD_MESHES = 4, CLOUD_QUADS = 16, CLOUD_ROUND = 12 };

/* Random quads (not plane: their triangles differ), spheres and disks in [-1,1]^3. */
static void cloud_make(small_scene_t *cloud)
{
    stream_t stream = stream_of(1);
    small_scene_begin(cloud);
    const uint32_t grey = small_add_diffuse(cloud, 0.5, 0.5, 0.5);
    for (int m = 0; m < CLOUD_MESHES; m++) {
        float corners[12 * CLOUD_QUADS];
        for (int q = 0; q < 4 * CLOUD_QUADS; q += 4) {
            const vec3_t centre = stream_point(&stream, 0.9);
            for (int i = q; i < q + 4; i++) {
                const vec3_t p = vec3_add(centre, stream_point(&stream, 0.2));
                corners[3 * i] = (float)p.x;
                corners[3 * i + 1] = (float)p.y;
                corners[3 * i + 2] = (float)p.z;
            }
        }
        small_add_quads(cloud, grey, SCENE_NONE, corners, CLOUD_QUADS);
    }
    for (int i = 0; i < CLOUD_ROUND; i++) {
        const vec3_t c = stream_point(&stream, 0.9), n = stream_direction(&stream);
        const float centre[3] = {(float)c.x, (float)c.y, (float)c.z},
                    normal[3] = {(float)n.x, (float)n.y, (float)n.z};
        if (i % 2)
            small_add_sphere(cloud, grey, centre, 0.05f + 0.02f * (float)i);
        else
            small_add_disk(cloud, grey, centre, normal, 0.05f + 0.02f * (float)i);
    }
    small_set_camera(cloud, 0, 0, 5, 0.5);
    small_scene_finish(cloud);
}

/* Solves o + t d = p0 + b1 e1 + b2 e2 by Cramer's rule in extended precision. */
static double brute_triangle(const scene_t *scene, const scene_shape_t *shape, uint32_t primitive, vec3_t o,
                             vec3_t d)
{
    const uint32_t *corner = scene->indices + 3 * (shape->first_triangle + primitive);
    vec3_t p[3];
    for (int i = 0; i < 3; i++)
        p[i] = of_floats(scene->positions + 3 * (shape->first_vertex + corner[i]));
    const vec3_t a = vec3_neg(d), b = vec3_sub(p[1], p[0]), c = vec3_sub(p[2], p[0]), r = vec3_sub(o, p[0]);
#define DETERMINANT(u, v, w)                                                                                       \
    ((long double)(u).x * ((long double)(v).y * (w).z - (long double)(v).z * (w).y) -                              \
     (long double)(u).y * ((long double)(v).x * (w).z - (long double)(v).z * (w).x) +                              \
     (long double)(u).z * ((long double)(v).x * (w).y - (long double)(v).y * (w).x))
    const long double all = DETERMINANT(a, b, c);
    const long double t = DETERMINANT(r, b, c) / all, b1 = DETERMINANT(a, r, c) / all,
                      b2 = DETERMINANT(a, b, r) / all;
#undef DETERMINANT
    return b1 >= 0 && b2 >= 0 && b1 + b2 <= 1 && t > 0 ? (double)t : INFINITY;
}

static double brute_sphere(const scene_shape_t *shape, vec3_t o, vec3_t d)
{
    const vec3_t f = vec3_sub(o, of_floats(shape->centre));
    const long double a = vec3_dot(d, d), b = vec3_dot(f, d),
                      c = vec3_dot(f, f) - (double)shape->radius * shape->radius;
    const long double root = sqrtl(b * b - a * c); /* NaN: no root */
    const double near = (double)((-b - root) / a), far = (double)((-b + root) / a);
    return near > 0 ? near : far > 0 ? far : INFINITY;
}

static double brute_disk(const scene_shape_t *shape, vec3_t o, vec3_t d)
{
    const vec3_t n = of_floats(shape->normal), f = vec3_sub(of_floats(shape->centre), o);
    const double t = vec3_dot(f, n) / vec3_dot(d, n);
    const vec3_t off = vec3_sub(vec3_scale(d, t), f);
    return t > 0 && vec3_length(off) <= (double)shape->radius ? t : INFINITY;
}

static double brute_shape(const scene_t *scene, uint32_t index, vec3_t o, vec3_t d, uint32_t *primitive)
{
    const scene_shape_t *shape = &scene->shapes[index];
    *primitive = 0;
    if (shape->kind != SCENE_SHAPE_MESH)
        return (shape->kind == SCENE_SHAPE_SPHERE ? brute_sphere : brute_disk)(shape, o, d);
    double best = INFINITY;
    for (uint32_t i = 0; i < shape->triangles; i++) {
        const double t = brute_triangle(scene, shape, i, o, d);
        if (t < best) {
            best = t;
            *primitive = i;
        }
    }
    return best;
}

/* The nearest hit; INFINITY if there is none. */
static double brute_force(const scene_t *scene, vec3_t o, vec3_t d, accel_hit_t *hit)
{
    *hit = (accel_hit_t){0, 0, INFINITY, NULL};
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        uint32_t primitive;
        const double t = brute_shape(scene, i, o, d, &primitive);
        if (t < hit->t)
            *hit = (accel_hit_t){i, primitive, t, NULL};
    }
    return hit->t;
}

/* Rays are rounded to single precision inside: at a distance of up to 6 they are 6 2^-24 = 4e-7 off, and so are
 * vertices of what they meet. An outline (about 600 edges of length 0.3, seen in an area of 4) is within that of a
 * ray with a chance of 600 * 0.3 * 2 * 4e-7 / 4 = 4e-5: of 40,000 rays 1.4 may see another primitive than brute
 * force does. 15 or more: a chance below 1e-10. Points on tilted triangles are off by the error over the cosine:
 * those of a cosine below 0.01 are not compared, others within 1e-6 / cosine. */
static void nearest_hits_are_those_of_brute_force(void **state)
{
    (void)state;
    enum { RAYS = 40000 };
    small_scene_t cloud;
    cloud_make(&cloud);
    accel_t *accel = accel_of(&cloud.scene);
    stream_t stream = stream_of(2);
    int outlines = 0, hits = 0, misses = 0;
    for (int i = 0; i < RAYS; i++) {
        const vec3_t o = stream_point(&stream, 1.5), d = vec3_scale(vec3_sub(stream_point(&stream, 1), o), 2.385);
        accel_hit_t wanted, found;
        brute_force(&cloud.scene, o, d, &wanted);
        const accel_answer_t answer = accel_intersect(accel, o, d, &found);
        assert_int_not_equal(answer, ACCEL_BAD_RAY);
        if ((answer == ACCEL_MISS) != (wanted.t == INFINITY) ||
            (answer == ACCEL_HIT && (found.shape != wanted.shape || found.primitive != wanted.primitive))) {
            outlines++;
            continue;
        }
        if (answer == ACCEL_MISS) {
            misses++;
            continue;
        }
        hits++;
        surface_t at;
        assert_true(surface_at_hit(&cloud.scene, &found, o, d, false, &at));
        const double cosine = fabs(vec3_dot(at.ng, d)) / vec3_length(d);
        assert_vec3_near(at.position, vec3_mad(o, wanted.t, d), 1e-11 / fmax(cosine, 1e-4));
        if (cosine > 0.01)
            assert_near(found.t, wanted.t, 1e-6 / cosine);
    }
    print_message("%d hits, %d misses, %d at outlines\n", hits, misses, outlines);
    assert_true(hits > RAYS / 4 && misses > RAYS / 20);
    assert_in_range(outlines, 0, 14);
    accel_destroy(&accel);
    small_scene_clear(&cloud);
}

static void occlusion_is_that_of_brute_force_and_symmetrical(void **state)
{
    (void)state;
    enum { PAIRS = 20000 };
    small_scene_t cloud;
    cloud_make(&cloud);
    accel_t *accel = accel_of(&cloud.scene);
    stream_t stream = stream_of(3);
    int outlines = 0, free = 0;
    for (int i = 0; i < PAIRS; i++) {
        const vec3_t a = stream_point(&stream, 1.2), b = stream_point(&stream, 1.2), d = vec3_sub(b, a);
        accel_hit_t nearest;
        const accel_answer_t wanted = brute_force(&cloud.scene, a, d, &nearest) < 1 ? ACCEL_HIT : ACCEL_MISS;
        const accel_answer_t found = accel_occluded(accel, a, b);
        assert_int_equal(accel_occluded(accel, b, a), found);
        outlines += found != wanted;
        free += wanted == ACCEL_MISS;
        const accel_answer_t beyond = brute_force(&cloud.scene, a, d, &nearest) < INFINITY ? ACCEL_HIT : ACCEL_MISS;
        outlines += accel_occluded_beyond(accel, a, d) != beyond;
    }
    assert_true(free > PAIRS / 10);
    assert_in_range(outlines, 0, 14); /* as above, twice a pair */
    accel_destroy(&accel);
    small_scene_clear(&cloud);
}

/* A floor at the origin, whose own coordinates are small, under a far lamp: the ray must arrive from either end. */
static void far_points_see_each_other_from_both_ends(void **state)
{
    (void)state;
    for (double height = 1; height < 1e7; height *= 9.7) {
        small_scene_t small;
        small_scene_begin(&small);
        const float h = (float)height;
        const float quads[] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1, -h, h, -h, h, h, -h, h, h, h, -h, h, h};
        const uint32_t grey = small_add_diffuse(&small, 0.5, 0.5, 0.5);
        small_add_quads(&small, grey, SCENE_NONE, quads, 1);
        small_add_quads(&small, grey, SCENE_NONE, quads + 12, 1);
        small_set_camera(&small, 0, 0.5, 0, 1);
        small_scene_finish(&small);
        accel_t *accel = accel_of(&small.scene);
        stream_t stream = stream_of(4);
        for (int i = 0; i < 5000; i++) {
            const vec3_t x = stream_point(&stream, 1), y = stream_point(&stream, height);
            const vec3_t below = vec3(x.x, SURFACE_EPSILON, x.z),
                         above = vec3(y.x, (double)h * (1 - SURFACE_EPSILON), y.z);
            if (accel_occluded(accel, below, above) != ACCEL_MISS ||
                accel_occluded(accel, above, below) != ACCEL_MISS)
                fail_msg("lamp at height %g: (%g, %g) does not see (%g, %g)", height, x.x, x.z, y.x, y.z);
        }
        accel_destroy(&accel);
        small_scene_clear(&small);
    }
}

/* ---- leaks and self-intersection ---- */

typedef struct placement {
    double scale, shift;
} placement_t;
static const placement_t placements[] = {{1, 0}, {1e-6, 0}, {1e6, 0}, {1, 1e5}, {1e-6, 1e5}, {1e6, 1e5}};
enum { PLACEMENTS = sizeof placements / sizeof *placements };

static float placed(const placement_t *placement, double x, int axis)
{
    static const double towards[3] = {0.6, -0.64, 0.48};
    return (float)(placement->scale * (x + placement->shift * towards[axis]));
}

/* The cube of half width 1 with outward normals, or the sphere of radius 1. */
static void closed_make(small_scene_t *closed, bool sphere, const placement_t *placement)
{
    static const float faces[] = {-1, -1, -1, 1,  -1, -1, 1,  -1, 1,  -1, -1, 1,  -1, 1,  -1, -1, 1,  1,
                                  1,  1,  1,  1,  1,  -1, -1, -1, -1, -1, 1,  -1, 1,  1,  -1, 1,  -1, -1,
                                  -1, -1, 1,  1,  -1, 1,  1,  1,  1,  -1, 1,  1,  -1, -1, -1, -1, -1, 1,
                                  -1, 1,  1,  -1, 1,  -1, 1,  -1, -1, 1,  1,  -1, 1,  1,  1,  1,  -1, 1};
    small_scene_begin(closed);
    const uint32_t grey = small_add_diffuse(closed, 0.5, 0.5, 0.5);
    float corners[72], centre[3];
    for (int i = 0; i < 72; i++)
        corners[i] = placed(placement, faces[i], i % 3);
    for (int i = 0; i < 3; i++)
        centre[i] = placed(placement, 0, i);
    if (sphere)
        small_add_sphere(closed, grey, centre, (float)placement->scale);
    else
        small_add_quads(closed, grey, SCENE_NONE, corners, 6);
    small_set_camera(closed, 0, 0, 0, 1);
    small_scene_finish(closed);
}

/* In single precision. Volatile: GCC 12.2 drops the conversions there and back where it has put two of them into
 * one vector. */
static vec3_t placed_point(const placement_t *placement, vec3_t p)
{
    const volatile float x = placed(placement, p.x, 0), y = placed(placement, p.y, 1),
                         z = placed(placement, p.z, 2);
    return vec3((double)x, (double)y, (double)z);
}

static void nothing_leaks_from_closed_shapes(void **state)
{
    (void)state;
    for (int sphere = 0; sphere < 2; sphere++) {
        small_scene_t closed;
        closed_make(&closed, sphere, &placements[0]);
        accel_t *accel = accel_of(&closed.scene);
        stream_t stream = stream_of(5);
        accel_hit_t hit;
        for (int i = 0; i < 100000; i++) {
            const vec3_t o = stream_point(&stream, sphere ? 0.57 : 0.999), d = stream_direction(&stream);
            if (accel_intersect(accel, o, d, &hit) != ACCEL_HIT || accel_occluded_beyond(accel, o, d) != ACCEL_HIT)
                fail_msg("%s: ray %d left", sphere ? "sphere" : "cube", i);
        }
        for (int i = 0; i < 20000 && !sphere; i++) { /* at edges: one coordinate free, two at the wall */
            const vec3_t o = stream_point(&stream, 0.9);
            vec3_t p = stream_point(&stream, 1);
            p.x = p.x < 0 ? -1 : 1;
            *(i % 2 ? &p.y : &p.z) = i % 4 < 2 ? 1 : -1;
            if (accel_intersect(accel, o, vec3_sub(p, o), &hit) != ACCEL_HIT)
                fail_msg("ray %d to an edge left", i);
        }
        accel_destroy(&accel);
        small_scene_clear(&closed);
    }
}

/* A unit direction at the given cosine to the normal. */
static vec3_t direction_at(stream_t *stream, vec3_t normal, double cosine)
{
    const frame_t frame = frame_of_normal(normal);
    const double phi = 2 * MATH_PI * stream_number(stream), sine = sqrt(1 - cosine * cosine);
    return frame_to_world(&frame, vec3(sine * cos(phi), sine * sin(phi), cosine));
}

static double any_cosine(stream_t *stream, int i)
{
    static const double grazing[] = {1e-3, 1e-6, 1e-9, 1};
    return i % 2 ? grazing[i / 2 % 4] : sqrt(stream_number(stream));
}

/* Convex and closed: what leaves outwards meets nothing, at any angle; what leaves inwards meets it again, and the
 * next point is on it too. */
static void rays_leave_the_surface_they_start_on(void **state)
{
    (void)state;
    for (int k = 0; k < 2 * PLACEMENTS; k++) {
        const placement_t *placement = &placements[k / 2];
        small_scene_t closed;
        closed_make(&closed, k % 2, placement);
        accel_t *accel = accel_of(&closed.scene);
        stream_t stream = stream_of(6);
        const vec3_t inside = placed_point(placement, vec3(0.1, 0.2, -0.15));
        vec3_t o = inside, d = stream_direction(&stream), from = inside;
        for (int i = 0; i < 20000; i++) {
            accel_hit_t hit;
            surface_t at;
            if (accel_intersect(accel, o, d, &hit) != ACCEL_HIT ||
                !surface_at_hit(&closed.scene, &hit, from, d, false, &at))
                fail_msg("%s, scale %g, shift %g: left inside at bounce %d", k % 2 ? "sphere" : "cube",
                         placement->scale, placement->shift, i);
            const vec3_t out = direction_at(&stream, at.ng, any_cosine(&stream, i));
            accel_hit_t again;
            if (accel_intersect(accel, surface_offset(at.position, at.ng, at.epsilon, out), out, &again) !=
                ACCEL_MISS)
                fail_msg("%s, scale %g, shift %g: self-intersection at bounce %d, cosine %g",
                         k % 2 ? "sphere" : "cube", placement->scale, placement->shift, i, vec3_dot(out, at.ng));
            d = direction_at(&stream, vec3_neg(at.ng), any_cosine(&stream, i));
            o = surface_offset(at.position, at.ng, at.epsilon, d);
            from = at.position;
        }
        accel_destroy(&accel);
        small_scene_clear(&closed);
    }
}

/* ---- bad rays ---- */

static void bad_rays_are_refused(void **state)
{
    (void)state;
    small_scene_t closed;
    closed_make(&closed, false, &placements[0]);
    accel_t *accel = accel_of(&closed.scene);
    static const double bad[] = {NAN, -NAN, INFINITY, -INFINITY, 1e19, -1e19, 1.7e308};
    const vec3_t good = vec3(0.1, 0.2, 0.3);
    accel_hit_t hit;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        for (int axis = 0; axis < 3; axis++) {
            vec3_t v = good;
            *(axis == 0 ? &v.x : axis == 1 ? &v.y : &v.z) = bad[i];
            assert_int_equal(accel_intersect(accel, v, good, &hit), ACCEL_BAD_RAY);
            assert_int_equal(accel_intersect(accel, good, v, &hit), ACCEL_BAD_RAY);
            assert_int_equal(accel_occluded(accel, v, good), ACCEL_BAD_RAY);
            assert_int_equal(accel_occluded(accel, good, v), ACCEL_BAD_RAY);
            assert_int_equal(accel_occluded_beyond(accel, v, good), ACCEL_BAD_RAY);
            assert_int_equal(accel_occluded_beyond(accel, good, v), ACCEL_BAD_RAY);
        }
    /* odd but finite: an answer, not an abort */
    static const double odd[] = {0, 1e-300, 1e-45, 1e-38, 1e-20, 9e17};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        const vec3_t v = vec3(odd[i], -odd[i], 0);
        assert_in_range(accel_intersect(accel, good, v, &hit), ACCEL_MISS, ACCEL_BAD_RAY);
        assert_in_range(accel_intersect(accel, v, good, &hit), ACCEL_MISS, ACCEL_BAD_RAY);
        assert_in_range(accel_occluded(accel, good, vec3_add(good, v)), ACCEL_MISS, ACCEL_BAD_RAY);
        assert_in_range(accel_occluded_beyond(accel, good, v), ACCEL_MISS, ACCEL_BAD_RAY);
    }
    accel_destroy(&accel);
    small_scene_clear(&closed);
}

/* ---- opacity and interfaces ---- */

enum { VEIL_QUAD = 0, VEIL_DISK, VEIL_SPHERE, VEILS };

/* A quad, a disk and a sphere side by side, 10 apart, each with this opacity. */
static void veils_make(small_scene_t *veils, float opacity, scene_material_kind_t kind, int32_t alpha_texture)
{
    const scene_material_t material = small_material(kind);
    static const float square[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, z[3] = {0, 0, 1};
    small_scene_begin(veils);
    const uint32_t index = small_add_material(veils, &material);
    if (alpha_texture >= 0) {
        /* opaque where floor(u) + floor(v) is even */
        const scene_texture_t texture = {.kind = SCENE_TEXTURE_CHECKERBOARD,
                                         .image = SCENE_NONE,
                                         .scale_u = 4,
                                         .scale_v = 2,
                                         .value = {1, 1, 1},
                                         .a = {{1, 1, 1}, SCENE_NONE},
                                         .b = {{0, 0, 0}, SCENE_NONE},
                                         .m = {{0, 0, 0}, SCENE_NONE}};
        fault_t fault = {0};
        assert_int_equal(scene_builder_add_texture(veils->builder, &texture, &(uint32_t){0}, &fault), FAULT_NONE);
    }
    small_add_quads(veils, index, SCENE_NONE, square, 1);
    small_add_disk(veils, index, (const float[]){10, 0, 0}, z, 1);
    small_add_sphere(veils, index, (const float[]){20, 0, 0}, 1);
    small_set_camera(veils, 0, 0, 5, 0.5);
    small_scene_finish(veils);
    /* the builder has no way to set the opacity of what is in it */
    scene_shape_t *shapes = (scene_shape_t *)(uintptr_t)veils->scene.shapes;
    for (int i = 0; i < VEILS; i++)
        shapes[i].alpha = (scene_param_t){{opacity, opacity, opacity}, alpha_texture};
}

/* Rays along -z through the middle of shape `which`; counts hits at the first and at a second surface (spheres). */
static void veil_count(const small_scene_t *veils, const accel_t *accel, int which, int rays, int *first,
                       int *second, int *blocked)
{
    stream_t stream = stream_of(10 + (uint64_t)which);
    *first = *second = *blocked = 0;
    for (int i = 0; i < rays; i++) {
        const vec3_t p = stream_point(&stream, 0.69);
        const vec3_t o = vec3(10 * which + p.x, p.y, 3), d = vec3(1e-3 * p.z, 0, -1);
        accel_hit_t hit;
        if (accel_intersect(accel, o, d, &hit) == ACCEL_HIT) {
            surface_t at;
            assert_int_equal(hit.shape, which);
            assert_true(surface_at_hit(&veils->scene, &hit, o, d, false, &at));
            *(at.position.z >= 0 ? first : second) += 1;
        }
        *blocked += accel_occluded(accel, o, vec3_mad(o, 6, d)) == ACCEL_HIT;
    }
}

/* |count - n p| <= 5.1 sqrt(n p (1 - p)): a false alarm in 3e-7. */
static void assert_share(const char *what, int count, int n, double p)
{
    assert_near((double)count / n, p, 5.1 * sqrt(p * (1 - p) / n));
    (void)what;
}

static void opacity_is_the_share_of_hits(void **state)
{
    (void)state;
    enum { RAYS = 20000 };
    static const float opacities[] = {0, 1, 0.5f, 0.125f};
    for (size_t i = 0; i < sizeof opacities / sizeof *opacities; i++) {
        small_scene_t veils;
        const double a = (double)opacities[i];
        veils_make(&veils, opacities[i], SCENE_MATERIAL_DIFFUSE, SCENE_NONE);
        accel_t *accel = accel_of(&veils.scene);
        for (int which = 0; which < VEILS; which++) {
            int first, second, blocked;
            veil_count(&veils, accel, which, RAYS, &first, &second, &blocked);
            const double back = which == VEIL_SPHERE ? (1 - a) * a : 0; /* a sphere has two sides */
            assert_share("first", first, RAYS, a);
            assert_share("second", second, RAYS, back);
            assert_share("blocked", blocked, RAYS, a + back);
        }
        accel_destroy(&accel);
        small_scene_clear(&veils);
    }
}

static void opacity_is_a_function_of_the_ray(void **state)
{
    (void)state;
    small_scene_t veils;
    veils_make(&veils, 0.5f, SCENE_MATERIAL_DIFFUSE, SCENE_NONE);
    accel_t *accel = accel_of(&veils.scene), *other = accel_of(&veils.scene);
    stream_t stream = stream_of(20);
    for (int i = 0; i < 3000; i++) {
        const vec3_t p = stream_point(&stream, 0.69), o = vec3(10 * (i % VEILS) + p.x, p.y, 3), d = vec3(0, 0, -1);
        const vec3_t to = vec3(o.x, o.y, -3);
        accel_hit_t hit;
        const accel_answer_t answer = accel_intersect(accel, o, d, &hit);
        assert_int_equal(accel_intersect(other, o, d, &hit), answer);
        assert_int_equal(accel_occluded(accel, o, to), accel_occluded(other, o, to));
        assert_int_equal(accel_occluded(accel, o, to), accel_occluded(accel, to, o));
    }
    accel_destroy(&accel);
    accel_destroy(&other);
    small_scene_clear(&veils);
}

/* A texture of squares says which hits count; the second way is the texture coordinates that surface_at_hit gives.
 */
static void opacity_textures_are_looked_up_at_the_hit(void **state)
{
    (void)state;
    small_scene_t veils, plain;
    veils_make(&veils, 1, SCENE_MATERIAL_DIFFUSE, 0);
    veils_make(&plain, 1, SCENE_MATERIAL_DIFFUSE, SCENE_NONE);
    accel_t *accel = accel_of(&veils.scene), *solid = accel_of(&plain.scene);
    stream_t stream = stream_of(21);
    int seen[VEILS][2] = {{0}};
    for (int i = 0; i < 6000; i++) {
        const int which = i % VEILS;
        const vec3_t p = stream_point(&stream, 0.69), o = vec3(10 * which + p.x, p.y, 3), d = vec3(0, 0, -1);
        accel_hit_t hit, through;
        surface_t at;
        assert_int_equal(accel_intersect(solid, o, d, &hit), ACCEL_HIT);
        assert_true(surface_at_hit(&plain.scene, &hit, o, d, true, &at));
        const double u = 4 * at.u, v = 2 * at.v;
        if (fabs(u - rint(u)) < 1e-4 || fabs(v - rint(v)) < 1e-4)
            continue; /* on a line, where single precision may decide otherwise */
        const int opaque = ((int)floor(u) + (int)floor(v)) % 2 == 0;
        const bool front = accel_intersect(accel, o, d, &through) == ACCEL_HIT && fabs(through.t - hit.t) < 1e-5;
        if (front != (opaque != 0))
            fail_msg("shape %d at (u, v) = (%g, %g): %s, expected %s", which, at.u, at.v, front ? "hit" : "passed",
                     opaque ? "hit" : "passed");
        seen[which][opaque]++;
    }
    for (int which = 0; which < VEILS; which++)
        assert_true(seen[which][0] > 300 && seen[which][1] > 300);
    accel_destroy(&accel);
    accel_destroy(&solid);
    small_scene_clear(&veils);
    small_scene_clear(&plain);
}

static void emitters_are_opaque(void **state)
{
    (void)state;
    small_scene_t furnace;
    small_scene_furnace(&furnace, 0.5, 1);
    scene_shape_t *shape = (scene_shape_t *)(uintptr_t)furnace.scene.shapes;
    shape->alpha.value[0] = 0;
    accel_t *accel = accel_of(&furnace.scene);
    stream_t stream = stream_of(22);
    accel_hit_t hit;
    for (int i = 0; i < 1000; i++)
        assert_int_equal(accel_intersect(accel, stream_point(&stream, 0.9), stream_direction(&stream), &hit),
                         ACCEL_HIT);
    accel_destroy(&accel);
    small_scene_clear(&furnace);
}

static void interfaces_are_not_hit(void **state)
{
    (void)state;
    small_scene_t veils;
    veils_make(&veils, 1, SCENE_MATERIAL_INTERFACE, SCENE_NONE);
    accel_t *accel = accel_of(&veils.scene);
    for (int which = 0; which < VEILS; which++) {
        int first, second, blocked;
        veil_count(&veils, accel, which, 1000, &first, &second, &blocked);
        assert_int_equal(first + second + blocked, 0);
    }
    accel_destroy(&accel);
    small_scene_clear(&veils);
}

/* ---- the point of a hit ---- */

static void points_lie_on_their_primitive(void **state)
{
    (void)state;
    for (int k = 0; k < 2 * PLACEMENTS; k++) {
        const placement_t *placement = &placements[k / 2];
        small_scene_t closed;
        closed_make(&closed, k % 2, placement);
        const scene_shape_t *shape = &closed.scene.shapes[0];
        const double reach = placement->scale * (1 + placement->shift);
        accel_t *accel = accel_of(&closed.scene);
        stream_t stream = stream_of(30);
        for (int i = 0; i < 5000; i++) {
            const vec3_t o = placed_point(placement, stream_point(&stream, 0.5)), d = stream_direction(&stream);
            accel_hit_t hit;
            surface_t at;
            assert_int_equal(accel_intersect(accel, o, d, &hit), ACCEL_HIT);
            assert_true(surface_at_hit(&closed.scene, &hit, o, d, false, &at));
            const uint32_t *corner = closed.scene.indices + 3 * (size_t)hit.primitive;
            const double off =
                k % 2 ? vec3_length(vec3_sub(at.position, of_floats(shape->centre))) - (double)shape->radius
                      : vec3_dot(at.ng, vec3_sub(at.position, of_floats(closed.scene.positions + 3 * corner[0])));
            assert_near(off, 0, 1e-12 * reach);
            assert_near(vec3_length(at.ng), 1, 1e-14);
            assert_near(at.epsilon, SURFACE_EPSILON * reach, 0.5 * SURFACE_EPSILON * reach);
            /* and on the ray */
            const vec3_t to = vec3_sub(at.position, o);
            assert_near(vec3_length(vec3_cross(to, d)), 0, 1e-12 * reach);
        }
        accel_destroy(&accel);
        small_scene_clear(&closed);
    }
}

/* What single precision takes for a hit just outside is put on the triangle's edge. */
static void barycentric_coordinates_are_clamped(void **state)
{
    (void)state;
    static const float corners[] = {0.1f, 0.2f, 0.3f, 1.3f, 0.1f, 0.2f, 0.9f, 1.4f, 0.6f, 0.2f, 1.2f, 0.5f};
    small_scene_t small;
    small_scene_begin(&small);
    small_add_quads(&small, small_add_diffuse(&small, 0.5, 0.5, 0.5), SCENE_NONE, corners, 1);
    small_set_camera(&small, 0, 0, 5, 0.5);
    small_scene_finish(&small);
    const vec3_t p0 = of_floats(corners), e1 = vec3_sub(of_floats(corners + 3), p0),
                 e2 = vec3_sub(of_floats(corners + 6), p0);
    const accel_hit_t hit = {0, 0, 1, NULL};
    stream_t stream = stream_of(31);
    int outside = 0;
    for (int i = 0; i < 20000; i++) {
        const double reach = i % 2 ? 1e-6 : 0.5;
        const double r1 = stream_number(&stream), r2 = stream_number(&stream), r3 = stream_number(&stream);
        const double r = 1 - r1 * (i % 3 > 0),
                     off = reach * (2 * r3 - 1); /* a third of them along the third edge */
        const double b1 = r * (1 - r2) + off, b2 = r * r2 * (i % 5 > 0) + off; /* a fifth along the first */
        const vec3_t p = vec3_mad(vec3_mad(p0, b1, e1), b2, e2), d = stream_direction(&stream);
        surface_t at;
        if (fabs(vec3_dot(vec3_unit(vec3_cross(e1, e2)), d)) < 1e-3)
            continue;
        assert_true(surface_at_hit(&small.scene, &hit, vec3_sub(p, d), d, true, &at));
        /* without texture coordinates u = b1 + b2, v = b2: so 0 <= v <= u <= 1 */
        assert_true(at.v >= 0 && at.u >= at.v && at.u <= 1 + 1e-15);
        const bool inside = b1 >= 0 && b2 >= 0 && b1 + b2 <= 1;
        outside += !inside;
        if (inside)
            assert_vec3_near(at.position, p, 1e-11);
        else
            assert_vec3_near(at.position, p, 4 * reach);
    }
    assert_true(outside > 1000);
    small_scene_clear(&small);
}

/* A ray in the triangle's plane, or a triangle without area, is refused or answered with finite numbers. */
static void degenerate_hits_give_no_nonsense(void **state)
{
    (void)state;
    static const float corners[] = {0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1, 2, 0, 0, 3, 0, 0, 4, 0, 0, 5, 0, 0};
    small_scene_t small;
    small_scene_begin(&small);
    small_add_quads(&small, small_add_diffuse(&small, 0.5, 0.5, 0.5), SCENE_NONE, corners, 2);
    small_set_camera(&small, 0, 0, 5, 0.5);
    small_scene_finish(&small);
    surface_t at;
    assert_false(
        surface_at_hit(&small.scene, &(accel_hit_t){0, 0, 1, NULL}, vec3(-1, 0, 0.5), vec3(1, 0, 0), false, &at));
    assert_false(
        surface_at_hit(&small.scene, &(accel_hit_t){0, 2, 1, NULL}, vec3(2, 1, 0), vec3(0.1, -1, 0), false, &at));
    for (double slope = 1e-3; slope > 1e-323; slope *= 1e-3)
        for (int i = 0; i < 4; i++) {
            const vec3_t o = vec3(i & 1 ? -1 : 0, i & 2 ? slope : 0, 0.5);
            if (!surface_at_hit(&small.scene, &(accel_hit_t){0, 0, 1, NULL}, o, vec3(1, -slope, 0), true, &at))
                continue;
            if (!vec3_finite(at.position) || !isfinite(at.u + at.v) ||
                !(at.u >= at.v && at.v >= 0 && at.u <= 1 + 1e-15))
                fail_msg("slope %g: (%g, %g, %g), (u, v) = (%g, %g)", slope, at.position.x, at.position.y,
                         at.position.z, at.u, at.v);
        }
    small_scene_clear(&small);
}

/* The root is the one beyond the origin: from outside, inside, and from the surface itself. */
static void spheres_answer_with_the_right_root(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_begin(&small);
    const float centre[3] = {0.3f, -0.2f, 0.5f}, radius = 0.7f;
    small_add_sphere(&small, small_add_diffuse(&small, 0.5, 0.5, 0.5), centre, radius);
    small_set_camera(&small, 0, 0, 5, 0.5);
    small_scene_finish(&small);
    accel_t *accel = accel_of(&small.scene);
    stream_t stream = stream_of(32);
    const vec3_t c = of_floats(centre);
    for (int i = 0; i < 20000; i++) {
        const vec3_t n = stream_direction(&stream), on = vec3_mad(c, (double)radius, n),
                     m = stream_direction(&stream);
        const vec3_t other = vec3_mad(c, (double)radius, m), chord = vec3_sub(other, on);
        const double length = vec3_length(chord);
        if (length < 0.01)
            continue;
        const vec3_t d = vec3_scale(chord, 2.385);
        accel_hit_t hit;
        surface_t at;
        /* from outside along the chord: its beginning */
        const vec3_t outside = vec3_mad(on, -1, d);
        assert_int_equal(accel_intersect(accel, outside, d, &hit), ACCEL_HIT);
        assert_true(surface_at_hit(&small.scene, &hit, outside, d, false, &at));
        /* two points of one surface, moved along the chord by 1e-16 over its cosine (length / 2r) */
        assert_vec3_near(at.position, on, 1e-13 / length);
        /* from its middle, and from its beginning (moved inwards): its end */
        const vec3_t starts[2] = {vec3_mad(on, 0.5, chord), surface_offset(on, n, SURFACE_EPSILON, d)};
        for (int k = 0; k < 2; k++) {
            assert_int_equal(accel_intersect(accel, starts[k], d, &hit), ACCEL_HIT);
            assert_true(surface_at_hit(&small.scene, &hit, k ? on : starts[k], d, false, &at));
            assert_vec3_near(at.position, other, 1e-13 / length);
        }
    }
    accel_destroy(&accel);
    small_scene_clear(&small);
}

/* ---- texture coordinates and tangents ---- */

static void triangles_interpolate_coordinates(void **state)
{
    (void)state;
    static const float p[] = {0.1f, 0.2f, 0.3f, 1.3f, 0.1f, 0.2f, 0.9f, 1.4f, 0.6f};
    static const float uv[] = {0.2f, 0.7f, 0.9f, 0.6f, 0.4f, 0.1f};
    static const float normals[] = {0, 0, 1, 0.6f, 0, 0.8f, 0, -0.6f, 0.8f};
    static const uint32_t indices[] = {0, 1, 2};
    for (int flip = 0; flip < 2; flip++) {
        small_scene_t small;
        fault_t fault = {0};
        small_scene_begin(&small);
        const uint32_t grey = small_add_diffuse(&small, 0.5, 0.5, 0.5);
        const scene_shape_t shape = {.material = (int32_t)grey,
                                     .area_light = SCENE_NONE,
                                     .alpha = {{1, 1, 1}, SCENE_NONE},
                                     .flags = flip ? SCENE_SHAPE_FLIP : 0};
        assert_int_equal(
            scene_builder_add_mesh(small.builder, &shape, p, normals, uv, 3, indices, 1, &(uint32_t){0}, &fault),
            0);
        small_set_camera(&small, 0, 0, 5, 0.5);
        small_scene_finish(&small);
        const vec3_t p0 = of_floats(p), e1 = vec3_sub(of_floats(p + 3), p0), e2 = vec3_sub(of_floats(p + 6), p0);
        const vec3_t n = vec3_scale(vec3_unit(vec3_cross(e1, e2)), flip ? -1 : 1);
        stream_t stream = stream_of(40);
        for (int i = 0; i < 2000; i++) {
            const double r = sqrt(stream_number(&stream)), b1 = 1 - r, b2 = r * stream_number(&stream),
                         b0 = 1 - b1 - b2;
            const vec3_t q = vec3_mad(vec3_mad(p0, b1, e1), b2, e2), d = direction_at(&stream, n, 0.1 + 0.9 * b2);
            surface_t at, moved;
            const accel_hit_t hit = {0, 0, 1, NULL};
            assert_true(surface_at_hit(&small.scene, &hit, vec3_sub(q, d), d, true, &at));
            assert_near(at.u, b0 * (double)uv[0] + b1 * (double)uv[2] + b2 * (double)uv[4], 1e-13);
            assert_near(at.v, b0 * (double)uv[1] + b1 * (double)uv[3] + b2 * (double)uv[5], 1e-13);
            assert_vec3_near(at.ng, n, 1e-14);
            const vec3_t ns =
                vec3_unit(vec3_mad(vec3_mad(vec3_scale(of_floats(normals), b0), b1, of_floats(normals + 3)), b2,
                                   of_floats(normals + 6)));
            assert_vec3_near(at.ns, vec3_scale(ns, vec3_dot(ns, n) < 0 ? -1 : 1), 1e-13);
            assert_true(vec3_dot(at.ns, at.ng) > 0);
            /* dp/du: a step along it changes u by as much, v not at all; towards the middle, to stay inside */
            const double step =
                (vec3_dot(at.tangent, vec3_sub(vec3_mad(vec3_mad(p0, 1.0 / 3, e1), 1.0 / 3, e2), q)) < 0 ? -1 : 1) *
                1e-3 * fmin(b0, fmin(b1, b2));
            const vec3_t next = vec3_mad(q, step, at.tangent);
            assert_true(surface_at_hit(&small.scene, &hit, vec3_sub(next, d), d, true, &moved));
            assert_near(moved.u - at.u, step, 1e-12);
            assert_near(moved.v - at.v, 0, 1e-12);
        }
        small_scene_clear(&small);
    }
}

/* At a point on a sphere or disk: u grows along the tangent, v does not change. */
static void check_round_tangent(const scene_t *scene, vec3_t q, vec3_t towards, const surface_t *at)
{
    const double h = 1e-6;
    const vec3_t t = vec3_unit(at->tangent);
    surface_t moved;
    const vec3_t next = vec3_mad(q, h, t);
    assert_near(vec3_dot(t, at->ng), 0, 1e-12);
    assert_true(surface_at_hit(scene, &(accel_hit_t){0, 0, 1, NULL}, vec3_sub(next, towards), towards, true, &moved));
    const double du = moved.u - at->u < -0.5 ? moved.u - at->u + 1 : moved.u - at->u;
    assert_true(du > 0);
    /* along a circle of radius |tangent| the angle grows by h / |tangent|, to second order in that */
    const double angle = h / vec3_length(at->tangent);
    assert_near(2 * MATH_PI * du, angle, angle * angle + 1e-12 / fmin(1, vec3_length(at->tangent)));
    assert_near(moved.v, at->v, angle * angle + h * h + 1e-12);
}

static void spheres_and_disks_have_pbrt_coordinates(void **state)
{
    (void)state;
    for (int disk = 0; disk < 2; disk++) {
        small_scene_t small;
        small_scene_begin(&small);
        const uint32_t grey = small_add_diffuse(&small, 0.5, 0.5, 0.5);
        const float n[3] = {0.36f, 0.48f, 0.8f};
        if (disk)
            small_add_disk(&small, grey, (const float[]){0, 0, 0}, n, 1);
        else
            small_add_sphere(&small, grey, (const float[]){0, 0, 0}, 1);
        small_set_camera(&small, 0, 0, 5, 0.5);
        small_scene_finish(&small);
        const scene_shape_t *shape = &small.scene.shapes[0];
        const vec3_t axis = vec3_unit(of_floats(shape->normal)), zero = vec3_unit(of_floats(shape->tangent));
        const vec3_t third = vec3_cross(axis, zero);
        stream_t stream = stream_of(41 + (uint64_t)disk);
        for (int i = 0; i < 2000; i++) {
            const double u = stream_number(&stream), v = 0.02 + 0.96 * stream_number(&stream),
                         phi = 2 * MATH_PI * u;
            /* pbrt's parametrization: z = cos theta with theta = pi (1 - v), or radius 1 - v */
            const double r = disk ? 1 - v : sin(MATH_PI * (1 - v)), z = disk ? 0 : cos(MATH_PI * (1 - v));
            const vec3_t q = vec3_mad(vec3_mad(vec3_scale(axis, z), r * cos(phi), zero), r * sin(phi), third);
            const vec3_t d = vec3_neg(disk ? axis : vec3_unit(q));
            surface_t at;
            assert_true(surface_at_hit(&small.scene, &(accel_hit_t){0, 0, 1, NULL}, vec3_sub(q, d), d, true, &at));
            assert_vec3_near(at.position, q, 1e-7); /* axis and tangent are unit to single precision */
            assert_near(fabs(at.u - u) > 0.5 ? 1 - fabs(at.u - u) : fabs(at.u - u), 0, 1e-7 / r);
            assert_near(at.v, v, 1e-6);
            check_round_tangent(&small.scene, at.position, d, &at);
        }
        small_scene_clear(&small);
    }
}

static void memory_is_counted(void **state)
{
    (void)state;
    small_scene_t cloud;
    cloud_make(&cloud);
    accel_t *accel = accel_of(&cloud.scene);
    assert_true(accel_bytes(accel) > 36 * cloud.scene.triangle_count);
    accel_destroy(&accel);
    assert_null(accel);
    accel_destroy(&accel);
    small_scene_clear(&cloud);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nearest_hits_are_those_of_brute_force),
        cmocka_unit_test(occlusion_is_that_of_brute_force_and_symmetrical),
        cmocka_unit_test(far_points_see_each_other_from_both_ends),
        cmocka_unit_test(nothing_leaks_from_closed_shapes),
        cmocka_unit_test(rays_leave_the_surface_they_start_on),
        cmocka_unit_test(bad_rays_are_refused),
        cmocka_unit_test(opacity_is_the_share_of_hits),
        cmocka_unit_test(opacity_is_a_function_of_the_ray),
        cmocka_unit_test(opacity_textures_are_looked_up_at_the_hit),
        cmocka_unit_test(emitters_are_opaque),
        cmocka_unit_test(interfaces_are_not_hit),
        cmocka_unit_test(points_lie_on_their_primitive),
        cmocka_unit_test(barycentric_coordinates_are_clamped),
        cmocka_unit_test(degenerate_hits_give_no_nonsense),
        cmocka_unit_test(spheres_answer_with_the_right_root),
        cmocka_unit_test(triangles_interpolate_coordinates),
        cmocka_unit_test(spheres_and_disks_have_pbrt_coordinates),
        cmocka_unit_test(memory_is_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
