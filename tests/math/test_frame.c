#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>

#include "base/random.h"
#include "math/frame.h"

enum { TRIALS = 20000 };

/* A handful of roundings of 2^-53 on numbers up to 1. */
static const double rounding = 2e-15;

static void assert_near(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("found %.17g, expected %.17g, tolerance %g", found, expected, tolerance);
}

static void assert_vec(vec3_t found, vec3_t expected, double tolerance)
{
    assert_near(found.x, expected.x, tolerance);
    assert_near(found.y, expected.y, tolerance);
    assert_near(found.z, expected.z, tolerance);
}

static double uniform(uint64_t counter)
{
    return 2 * random_double(random_key(5, RANDOM_PURPOSE_TEST, 0, 0), counter) - 1;
}

static vec3_t any_vector(uint64_t trial)
{
    return vec3(uniform(3 * trial), uniform(3 * trial + 1), uniform(3 * trial + 2));
}

/* Random directions, and the places where a basis from a normal is delicate. */
static vec3_t any_normal(uint64_t trial)
{
    static const vec3_t delicate[] = {{0, 0, 1},      {0, 0, -1},        {1, 0, 0},          {0, 1, 0},
                                      {-1, 0, 0},     {0, -1, 0},        {1, 0, -0.0},       {0, -1, -0.0},
                                      {1e-9, 0, -1},  {1e-9, -1e-9, -1}, {0.6, 0.8, 1e-300}, {0.6, -0.8, -1e-300},
                                      {1e-160, 0, -1}};
    if (trial < sizeof delicate / sizeof *delicate)
        return vec3_unit(delicate[trial]);
    return vec3_unit(any_vector(trial));
}

/* ---- vectors ---- */

static void products_agree_with_components(void **state)
{
    (void)state;
    const vec3_t a = vec3(1.5, -2, 0.25), b = vec3(3, 0.5, -4);
    assert_vec(vec3_add(a, b), vec3(4.5, -1.5, -3.75), 0);
    assert_vec(vec3_sub(a, b), vec3(-1.5, -2.5, 4.25), 0);
    assert_vec(vec3_mad(a, -2, b), vec3(-4.5, -3, 8.25), 0);
    assert_vec(vec3_scale(vec3_neg(a), 2), vec3(-3, 4, -0.5), 0);
    assert_near(vec3_dot(a, b), 2.5, 0);
    assert_vec(vec3_cross(a, b), vec3(7.875, 6.75, 6.75), 0);
    assert_vec(vec3_cross(vec3(1, 0, 0), vec3(0, 1, 0)), vec3(0, 0, 1), 0); /* right-handed */
    assert_near(vec3_length(vec3(2, -3, 6)), 7, 0);
    assert_near(vec3_max_abs(vec3(2, -3, 1)), 3, 0);
}

/* Lagrange: |a x b|^2 + (a.b)^2 = |a|^2 |b|^2, and a x b is perpendicular to both. */
static void cross_and_dot_complete_each_other(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < TRIALS; i++) {
        const vec3_t a = any_vector(2 * i), b = any_vector(2 * i + 1), c = vec3_cross(a, b);
        const double dot = vec3_dot(a, b);
        assert_near(vec3_dot(c, c) + dot * dot, vec3_dot(a, a) * vec3_dot(b, b), 10 * rounding);
        assert_near(vec3_dot(a, c), 0, rounding);
        assert_near(vec3_dot(b, c), 0, rounding);
        assert_near(vec3_length(vec3_unit(a)), 1, rounding);
    }
}

static void what_is_not_finite_is_seen(void **state)
{
    (void)state;
    assert_true(vec3_finite(vec3(1, -1e300, 1e-300)));
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++) {
        assert_false(vec3_finite(vec3(bad[i], 0, 0)));
        assert_false(vec3_finite(vec3(0, bad[i], 0)));
        assert_false(vec3_finite(vec3(0, 0, bad[i])));
        assert_false(vec3_finite(vec3(bad[i], -bad[i], 1)));
    }
}

static void colours_combine_by_channel(void **state)
{
    (void)state;
    const rgb_t a = rgb(0.5, 2, 0.25), b = rgb(4, 0.25, 1), c = rgb_mad(rgb_mul(a, b), 2, rgb_add(a, b));
    assert_vec(vec3(c.r, c.g, c.b), vec3(11, 5, 2.75), 0);
    assert_near(rgb_luminance(rgb_gray(1)), 1, rounding); /* the weights sum to 1 */
    assert_true(rgb_luminance(rgb(0, 1, 0)) > rgb_luminance(rgb(1, 0, 0)));
    assert_true(rgb_luminance(rgb(1, 0, 0)) > rgb_luminance(rgb(0, 0, 1)));
    assert_near(rgb_max(a), 2, 0);
    assert_near(rgb_mean(rgb_scale(a, 12)), 11, 4 * rounding);
    assert_true(rgb_black(rgb_gray(0)));
    assert_false(rgb_black(rgb(0, 0, 1e-300)));
}

/* ---- frames ---- */

static void assert_right_handed(const frame_t *f)
{
    assert_near(vec3_dot(f->s, f->s), 1, rounding);
    assert_near(vec3_dot(f->t, f->t), 1, rounding);
    assert_near(vec3_dot(f->n, f->n), 1, rounding);
    assert_vec(vec3_cross(f->s, f->t), f->n, rounding);
    assert_vec(vec3_cross(f->t, f->n), f->s, rounding);
    assert_vec(vec3_cross(f->n, f->s), f->t, rounding);
}

static void frames_are_orthonormal_and_right_handed(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < TRIALS; i++) {
        const vec3_t n = any_normal(i);
        const frame_t f = frame_of_normal(n);
        assert_vec(f.n, n, 0);
        assert_right_handed(&f);
    }
}

static void local_and_world_are_inverse_and_keep_products(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < TRIALS; i++) {
        const frame_t f = frame_of_normal(any_normal(i));
        const vec3_t a = any_vector(TRIALS + 2 * i), b = any_vector(TRIALS + 2 * i + 1);
        assert_vec(frame_to_world(&f, frame_to_local(&f, a)), a, 2 * rounding);
        assert_vec(frame_to_local(&f, frame_to_world(&f, a)), a, 2 * rounding);
        assert_near(vec3_dot(frame_to_local(&f, a), frame_to_local(&f, b)), vec3_dot(a, b), 10 * rounding);
        assert_near(frame_to_local(&f, a).z, vec3_dot(a, f.n), rounding);
    }
}

/* The s axis is the tangent's part perpendicular to n: n, s and the tangent lie in one plane, s on the tangent's
 * side, and no perpendicular direction comes nearer. */
static void a_tangent_turns_the_frame(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < TRIALS; i++) {
        const vec3_t n = any_normal(i), tangent = any_vector(3 * TRIALS + i);
        const frame_t f = frame_of_normal_tangent(n, tangent);
        const double sine = vec3_length(vec3_cross(n, tangent)), length = vec3_length(tangent);
        assert_vec(f.n, n, 0);
        /* Cancellation: rounding of the tangent's size over what is left of it. */
        const double tolerance = 4 * rounding * length / sine;
        assert_near(vec3_dot(f.s, n), 0, tolerance);
        assert_near(vec3_dot(f.s, f.s), 1, rounding);
        assert_vec(f.t, vec3_cross(n, f.s), rounding);
        assert_near(vec3_dot(f.t, tangent), 0, 4 * rounding);
        assert_near(vec3_dot(f.s, tangent), sine, 4 * rounding + tolerance * length);
    }
}

static void a_tangent_along_the_normal_says_nothing(void **state)
{
    (void)state;
    static const double lengths[] = {0, 1, -1, 2.385, -1e-20, 1e20};
    for (uint64_t i = 0; i < 200; i++) {
        for (size_t k = 0; k < sizeof lengths / sizeof *lengths; k++) {
            const frame_t f = frame_of_normal_tangent(any_normal(i), vec3_scale(any_normal(i), lengths[k]));
            assert_right_handed(&f);
        }
        const frame_t f = frame_of_normal_tangent(any_normal(i), vec3(NAN, 0, 0));
        assert_right_handed(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(products_agree_with_components),
        cmocka_unit_test(cross_and_dot_complete_each_other),
        cmocka_unit_test(what_is_not_finite_is_seen),
        cmocka_unit_test(colours_combine_by_channel),
        cmocka_unit_test(frames_are_orthonormal_and_right_handed),
        cmocka_unit_test(local_and_world_are_inverse_and_keep_products),
        cmocka_unit_test(a_tangent_turns_the_frame),
        cmocka_unit_test(a_tangent_along_the_normal_says_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
