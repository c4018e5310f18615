/* The point, texture coordinates and tangent of a hit. */
#include "accel_fixture.h"
#include "scene/surface.h"

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
    const accel_hit_t hit = {.t = 1};
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
    assert_false(surface_at_hit(&small.scene, &(accel_hit_t){.t = 1}, vec3(-1, 0, 0.5), vec3(1, 0, 0), false, &at));
    assert_false(surface_at_hit(&small.scene, &(accel_hit_t){.primitive = 2, .t = 1}, vec3(2, 1, 0),
                                vec3(0.1, -1, 0), false, &at));
    for (double slope = 1e-3; slope > 1e-323; slope *= 1e-3)
        for (int i = 0; i < 4; i++) {
            const vec3_t o = vec3(i & 1 ? -1 : 0, i & 2 ? slope : 0, 0.5);
            if (!surface_at_hit(&small.scene, &(accel_hit_t){.t = 1}, o, vec3(1, -slope, 0), true, &at))
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
            const accel_hit_t hit = {.t = 1};
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
    assert_true(surface_at_hit(scene, &(accel_hit_t){.t = 1}, vec3_sub(next, towards), towards, true, &moved));
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
            assert_true(surface_at_hit(&small.scene, &(accel_hit_t){.t = 1}, vec3_sub(q, d), d, true, &at));
            assert_vec3_near(at.position, q, 1e-7); /* axis and tangent are unit to single precision */
            assert_near(fabs(at.u - u) > 0.5 ? 1 - fabs(at.u - u) : fabs(at.u - u), 0, 1e-7 / r);
            assert_near(at.v, v, 1e-6);
            check_round_tangent(&small.scene, at.position, d, &at);
        }
        small_scene_clear(&small);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_lie_on_their_primitive),
        cmocka_unit_test(barycentric_coordinates_are_clamped),
        cmocka_unit_test(degenerate_hits_give_no_nonsense),
        cmocka_unit_test(spheres_answer_with_the_right_root),
        cmocka_unit_test(triangles_interpolate_coordinates),
        cmocka_unit_test(spheres_and_disks_have_pbrt_coordinates),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
