/* The right inverse: numbers that make a given direction, distributed as they should be, with the Jacobian they
 * should have. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>

#include "scene/bsdf_lobes.h"
#include "scene/fresnel.h"

#include "bsdf_fixture.h"

static void numbers(uint64_t key, uint64_t n, double u[3])
{
    for (uint64_t i = 0; i < 3; i++)
        u[i] = random_double(key, 3 * n + i);
}

/* How far S(R(wi)) may be from wi. Angles: the azimuth's number is known to 2^-53, times 2 pi. Near the horizon of
 * a cosine lobe z = sqrt(1 - u1) is known to 2^-53 / z. A microfacet m comes from h = wo + eta wi, known to 2^-52 /
 * |h|. Its number u2 is known to 2^-53, the height m.z / |S^-1 m| = 1 / t of it on the stretched hemisphere, of the
 * size of 1 - u2, to t 2^-53 of itself, and the tangent of m's angle likewise: m to t sin 2^-53. The direction wi
 * moves by twice that. Some ten roundings each: the factors 16 and 32. */
static double allowed(const bsdf_t *bsdf, vec3_t wo, vec3_t wi, bool specular)
{
    if (specular)
        return 1e-15; /* the same computation again */
    double eta = 1;
    for (uint32_t l = 0; l < bsdf->count; l++)
        if (bsdf->lobes[l].kind == BSDF_DIELECTRIC && wo.z * wi.z < 0)
            eta = wo.z > 0 ? bsdf->lobes[l].eta : 1 / bsdf->lobes[l].eta;
    const vec3_t h = vec3_mad(wo, eta, wi);
    const double size = vec3_length(h), sine = hypot(h.x, h.y) / size, cosine = fmax(fabs(h.z) / size, 1e-15);
    const double t = hypot(1, sine / cosine / fixture_alpha(bsdf));
    const double smooth = 16 * 0x1p-52 / fmin(size, 1);
    return smooth * (1 + 1 / fmax(fabs(wi.z), 1e-8)) + 32 * 0x1p-52 * t * sine + 1e-14;
}

static void round_trip(void **state)
{
    const fixture_t *f = *state;
    uint64_t trips = 0, failed = 0;
    for (uint32_t m = 0; m < f->count; m++)
        for (int d = 0; d < FIXTURE_DIRECTIONS; d++)
            for (uint64_t n = 0; n < 150; n++) {
                const bsdf_t *bsdf = fixture_bsdf(f, m);
                const vec3_t wo = fixture_direction(d);
                const uint64_t key = random_key(21, RANDOM_PURPOSE_TEST, m, (uint64_t)d);
                double u[3], free_numbers[3], v[3];
                numbers(key, 2 * n, u);
                numbers(key, 2 * n + 1, free_numbers);
                bsdf_sample_t s, t;
                if (!bsdf_sample(bsdf, f->tables, wo, u, BSDF_RADIANCE, &s))
                    continue;
                trips++;
                if (!bsdf_invert(bsdf, f->tables, wo, s.wi, s.specular, s.lobe, BSDF_RADIANCE, free_numbers, v))
                    fail_msg("%s, wo.z %g: no inverse of wi.z %g, pdf %g", f->names[m], wo.z, s.wi.z, s.pdf);
                for (int i = 0; i < 3; i++)
                    assert_true(v[i] >= 0 && v[i] < 1);
                if (!bsdf_sample(bsdf, f->tables, wo, v, BSDF_RADIANCE, &t) || t.transmitted != s.transmitted ||
                    t.specular != s.specular) {
                    failed++; /* a number at the very edge of an interval, by rounding */
                    continue;
                }
                const double off = vec3_length(vec3_sub(s.wi, t.wi));
                if (!(off <= allowed(bsdf, wo, s.wi, s.specular)))
                    fail_msg("%s, wo.z %g, u %.17g %.17g %.17g: wi.z %g comes back %g away, allowed %g (lobe %u, "
                             "then %u)",
                             f->names[m], wo.z, u[0], u[1], u[2], s.wi.z, off, allowed(bsdf, wo, s.wi, s.specular),
                             s.lobe, t.lobe);
                assert_true(fabs(t.pdf / s.pdf - 1) <
                            1e-6 + (s.specular ? 0 : 1e3 * fixture_condition(bsdf, wo, s.wi) + off / fabs(s.wi.z)));
            }
    print_message("%llu round trips, %llu fell on the other side of an interval's edge\n",
                  (unsigned long long)trips, (unsigned long long)failed);
    assert_true(trips > 20000 && failed == 0);
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* Two-sample Kolmogorov and Smirnov: D sqrt(n m / (n + m)). */
static double ks_distance(double *x, double *y, int n, int m)
{
    qsort(x, (size_t)n, sizeof *x, compare);
    qsort(y, (size_t)m, sizeof *y, compare);
    double most = 0;
    for (int i = 0, j = 0; i < n && j < m;) {
        const double t = fmin(x[i], y[j]);
        while (i < n && x[i] <= t)
            i++;
        while (j < m && y[j] <= t)
            j++;
        most = fmax(most, fabs((double)i / n - (double)j / m));
    }
    return most * sqrt((double)n * m / (n + m));
}

/* Numbers that an inverse returns for sampled directions are distributed as numbers that led to a direction:
 * uniform where every number does. P(distance > 3.6) = 2 exp(-2 3.6^2) = 1e-11 each; 1050 comparisons: 1e-8. */
static void inverted_numbers_are_distributed_as_drawn_ones(void **state)
{
    enum { N = 3000 };
    const fixture_t *f = *state;
    static double drawn[3][N], inverted[3][N];
    for (uint32_t m = 0; m < f->count; m++)
        for (int d = 0; d < FIXTURE_DIRECTIONS; d++) {
            const bsdf_t *bsdf = fixture_bsdf(f, m);
            const vec3_t wo = fixture_direction(d);
            const uint64_t key = random_key(22, RANDOM_PURPOSE_TEST, m, (uint64_t)d);
            int counts[2] = {0, 0};
            for (uint64_t n = 0; n < 2 * N; n++) {
                double u[3], free_numbers[3];
                numbers(key, 2 * n, u);
                numbers(key, 2 * n + 1, free_numbers);
                bsdf_sample_t s;
                if (!bsdf_sample(bsdf, f->tables, wo, u, BSDF_RADIANCE, &s))
                    continue;
                const int invert = (int)(n & 1);
                if (invert &&
                    !bsdf_invert(bsdf, f->tables, wo, s.wi, s.specular, s.lobe, BSDF_RADIANCE, free_numbers, u))
                    fail_msg("%s: no inverse", f->names[m]);
                for (int i = 0; i < 3; i++)
                    (invert ? inverted : drawn)[i][counts[invert]] = u[i];
                counts[invert]++;
            }
            for (int i = 0; i < 3 && counts[0] > 100; i++) {
                const double distance = ks_distance(drawn[i], inverted[i], counts[0], counts[1]);
                if (!(distance < 3.6))
                    fail_msg("%s, wo.z %g, number %d: distance %g", f->names[m], wo.z, i, distance);
            }
        }
}

/* Density of wi that the numbers u[1], u[2] have within the sampled lobe: p_l, without the discrete choice inside
 * it. */
static double lobe_density(const bsdf_t *bsdf, uint32_t l, vec3_t wo, vec3_t wi)
{
    const bsdf_lobe_t *lobe = &bsdf->lobes[l];
    const double sign = copysign(1, wo.z), eta = sign > 0 ? lobe->eta : 1 / lobe->eta;
    wo.z *= sign;
    wi.z *= sign;
    bsdf_value_t v;
    bsdf_lobe_eval(lobe, eta, wo, wi, 1, 1, BSDF_RADIANCE, &v);
    if (lobe->kind != BSDF_DIELECTRIC)
        return v.pdf;
    const vec3_t m = vec3_unit(wi.z > 0 ? vec3_add(wo, wi) : vec3_mad(wo, eta, wi));
    const double r = fresnel_dielectric(fmin(fabs(vec3_dot(wo, m)), 1), eta);
    return v.pdf / (wi.z > 0 ? r : 1 - r);
}

static bool moved(const fixture_t *f, uint32_t m, vec3_t wo, const double u[3], int axis, double by,
                  const bsdf_sample_t *s, vec3_t *wi)
{
    double v[3] = {u[0], u[1], u[2]};
    v[axis] += by;
    bsdf_sample_t t;
    const bool same = v[axis] >= 0 && v[axis] < 1 &&
                      bsdf_sample(fixture_bsdf(f, m), f->tables, wo, v, BSDF_RADIANCE, &t) && t.lobe == s->lobe &&
                      t.transmitted == s->transmitted;
    *wi = t.wi;
    return same;
}

/* |dwi/du1 x dwi/du2| = 1 / p_l, and the interval of u[0] is alpha_l (tested by the histograms): together 1 /
 * (alpha_l p_l). Central differences of 1e-5: truncation by the third derivative over the distance to the lobe's
 * ends, which are left out, and rounding of 1e-16 / (1e-5 alpha) (eta - 1 where refraction barely bends). */
static void jacobian_is_one_over_the_lobes_density(void **state)
{
    const fixture_t *f = *state;
    const double step = 1e-5;
    int checked = 0;
    for (uint32_t m = 0; m < f->count; m++)
        for (int d = 0; d < FIXTURE_DIRECTIONS; d++)
            for (uint64_t n = 0; n < 30; n++) {
                const bsdf_t *bsdf = fixture_bsdf(f, m);
                const vec3_t wo = fixture_direction(d);
                double u[3];
                numbers(random_key(23, RANDOM_PURPOSE_TEST, m, (uint64_t)d), n, u);
                u[1] = 0.03 + 0.94 * u[1];
                u[2] = 0.03 + 0.9 * u[2];
                bsdf_sample_t s;
                vec3_t a, b, c, e;
                if (!bsdf_sample(bsdf, f->tables, wo, u, BSDF_RADIANCE, &s) || s.specular || fabs(s.wi.z) < 0.05 ||
                    !moved(f, m, wo, u, 1, step, &s, &a) || !moved(f, m, wo, u, 1, -step, &s, &b) ||
                    !moved(f, m, wo, u, 2, step, &s, &c) || !moved(f, m, wo, u, 2, -step, &s, &e))
                    continue;
                const double area = vec3_length(vec3_cross(vec3_sub(a, b), vec3_sub(c, e))) / (4 * step * step);
                const double product = area * lobe_density(bsdf, s.lobe, wo, s.wi);
                const double eta = bsdf->lobes[s.lobe].eta;
                const double bend =
                    s.transmitted && bsdf->lobes[s.lobe].kind == BSDF_DIELECTRIC ? fabs(eta - 1) : 1;
                const double tolerance = 2e-4 + 1e-10 / (fixture_alpha(bsdf) * bend);
                if (!(fabs(product - 1) < tolerance))
                    fail_msg("%s, wo.z %g, u %g %g %g: Jacobian x density = %.8f", f->names[m], wo.z, u[0], u[1],
                             u[2], product);
                checked++;
            }
    assert_true(checked > 4000);
}

/* What cannot be made is refused. */
static void impossible_directions_have_no_inverse(void **state)
{
    const fixture_t *f = *state;
    const double free_numbers[3] = {0.2, 0.4, 0.6};
    const vec3_t wo = fixture_direction(1), below = fixture_direction(4);
    double u[3];
    for (uint32_t m = 0; m < f->count; m++) {
        const bsdf_t *bsdf = fixture_bsdf(f, m);
        if (!(bsdf->flags & BSDF_HAS_TRANSMISSION))
            assert_false(bsdf_invert(bsdf, f->tables, wo, below, false, 0, BSDF_RADIANCE, free_numbers, u));
        if (!(bsdf->flags & BSDF_HAS_SMOOTH))
            assert_false(
                bsdf_invert(bsdf, f->tables, wo, fixture_direction(2), false, 0, BSDF_RADIANCE, free_numbers, u));
        if (!(bsdf->flags & BSDF_HAS_SPECULAR))
            assert_false(
                bsdf_invert(bsdf, f->tables, wo, fixture_direction(2), true, 0, BSDF_RADIANCE, free_numbers, u));
        assert_false(bsdf_invert(bsdf, f->tables, wo, wo, true, BSDF_MAX_LOBES, BSDF_RADIANCE, free_numbers, u));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trip),
        cmocka_unit_test(inverted_numbers_are_distributed_as_drawn_ones),
        cmocka_unit_test(jacobian_is_one_over_the_lobes_density),
        cmocka_unit_test(impossible_directions_have_no_inverse),
    };
    return cmocka_run_group_tests(tests, fixture_setup, fixture_teardown);
}
