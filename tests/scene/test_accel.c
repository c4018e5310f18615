/* Ray queries against brute force in double precision, leaks, self-intersection, bad rays. */
#include "accel_fixture.h"
#include "scene/surface.h"

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
    *hit = (accel_hit_t){.t = INFINITY};
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        uint32_t primitive;
        const double t = brute_shape(scene, i, o, d, &primitive);
        if (t < hit->t)
            *hit = (accel_hit_t){.shape = i, .primitive = primitive, .t = t};
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

/* ---- small things far away ---- */

/* A sphere of 1e-8 of the distance is met by the line that is aimed at it, whatever the origin was moved by, and
 * not by one that passes at 1.001 of its radius. */
static void lines_meet_spheres_of_a_hundred_millionth(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_begin(&small);
    const float centre[3] = {0.125f, 0.75f, -0.25f}, radius = 1e-8f;
    small_add_sphere(&small, small_add_diffuse(&small, 0.5, 0.5, 0.5), centre, radius);
    small_set_camera(&small, 0, 0, 5, 0.5);
    small_scene_finish(&small);
    accel_t *accel = accel_of(&small.scene);
    stream_t stream = stream_of(8);
    const vec3_t c = of_floats(centre);
    for (int i = 0; i < 20000; i++) {
        const vec3_t place = stream_point(&stream, 1), n = stream_direction(&stream), to = vec3_sub(c, place);
        const frame_t frame = frame_of_normal(vec3_unit(to));
        const double far = 1.001 * sqrt(stream_number(&stream)), turn = 2 * MATH_PI * stream_number(&stream);
        const double across = i % 2 ? 0.999 * far / 1.001 : 1.001;
        const vec3_t aim = vec3_mad(vec3_mad(c, across * (double)radius * cos(turn), frame.s),
                                    across * (double)radius * sin(turn), frame.t);
        const vec3_t d = vec3_unit(vec3_sub(aim, place));
        accel_hit_t hit;
        const accel_answer_t answer =
            accel_intersect_line(accel, place, surface_offset(place, n, SURFACE_EPSILON, d), d, &hit);
        assert_int_equal(answer, i % 2 ? ACCEL_HIT : ACCEL_MISS);
        if (answer == ACCEL_HIT)
            assert_false(hit.leaves);
    }
    accel_destroy(&accel);
    small_scene_clear(&small);
}

/* A floor of half side 1 in a room of half side 1e5: of its two triangles the walls see the one they aim at, to
 * 1e-5 from their common edge. Single precision alone would miss by 1e-2. */
static void rays_from_far_find_the_core(void **state)
{
    (void)state;
    enum { SIDE = 100000 };
    static const float floor_corners[] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1};
    static const float wall_corners[] = {-SIDE, -SIDE, -SIDE, -SIDE, SIDE,  -SIDE,
                                         -SIDE, SIDE,  SIDE,  -SIDE, -SIDE, SIDE};
    small_scene_t small;
    small_scene_begin(&small);
    const uint32_t grey = small_add_diffuse(&small, 0.5, 0.5, 0.5);
    small_add_quads(&small, grey, SCENE_NONE, floor_corners, 1);
    small_add_quads(&small, grey, SCENE_NONE, wall_corners, 1);
    small_set_camera(&small, 0, 0, 5, 0.5);
    small_scene_finish(&small);
    accel_t *accel = accel_of(&small.scene);
    stream_t stream = stream_of(9);
    for (int i = 0; i < 20000; i++) {
        const double y = SIDE * (0.1 + 0.9 * stream_number(&stream)), z = SIDE * (2 * stream_number(&stream) - 1),
                     along = 1.9 * stream_number(&stream) - 0.95,
                     beside = (i % 2 ? 1 : -1) * pow(10, -3 * stream_number(&stream)) * (1 - fabs(along));
        const vec3_t place = vec3(-SIDE, y, z), aim = vec3(along + beside / 2, 0, along - beside / 2);
        const vec3_t d = vec3_unit(vec3_sub(aim, place));
        accel_hit_t hit;
        surface_t at;
        assert_int_equal(accel_intersect_line(accel, place, surface_offset(place, vec3(1, 0, 0), 0.1, d), d, &hit),
                         ACCEL_HIT);
        assert_int_equal(hit.shape, 0);
        assert_true(surface_at_hit(&small.scene, &hit, place, d, false, &at));
        assert_false(at.moved);
        assert_vec3_near(at.position, aim, 1e-9);
    }
    accel_destroy(&accel);
    small_scene_clear(&small);
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
        cmocka_unit_test(lines_meet_spheres_of_a_hundred_millionth),
        cmocka_unit_test(rays_from_far_find_the_core),
        cmocka_unit_test(bad_rays_are_refused),
        cmocka_unit_test(memory_is_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
