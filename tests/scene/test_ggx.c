#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include <gsl/gsl_cdf.h>

#include "base/random.h"
#include "math/warp.h"
#include "scene/ggx.h"
#include "scene/quadrature.h"
#include "support/near.h"

#define SEED random_key(2024, RANDOM_PURPOSE_TEST, 0, 2)

static const double alphas[][2] = {{1, 1},       {0.3, 0.3},   {0.05, 0.05},  {1e-2, 1e-2},
                                   {1e-3, 1e-3}, {1e-4, 1e-4}, {0.41, 0.023}, {1e-4, 0.7}};
enum { ALPHAS = sizeof alphas / sizeof *alphas };
static const double cosines[] = {1, 0.8, 0.31, 1e-2, 1e-6, 1e-9};
enum { COSINES = sizeof cosines / sizeof *cosines };

static vec3_t direction(double z, double turns)
{
    const double r = sqrt((1 - z) * (1 + z));
    double s, c;
    warp_sincos_turns(turns, &s, &c);
    return vec3(r * c, r * s, z);
}

/* A normal with the slopes r (au cos phi, av sin phi). */
static vec3_t normal_at(double au, double av, double r, double phi)
{
    return vec3_unit(vec3(au * r * cos(phi), av * r * sin(phi), 1));
}

/* int g(m) dm over the upper hemisphere: solid angle m.z^3 au av r dr dphi, in octaves of r = tan / alpha, in
 * which everything is smooth but the edge of visibility. */
typedef double (*integrand_t)(double au, double av, vec3_t w, vec3_t m);

static double integrate(integrand_t g, double au, double av, vec3_t w, double r0, double r1, double phi0,
                        double phi1, int nodes)
{
    double x[64], weight[64], sum = 0;
    quadrature_gauss(nodes, x, weight);
    for (int i = 0; i < nodes; i++)
        for (int j = 0; j < nodes; j++) {
            const double r = r0 + (r1 - r0) * x[i], phi = phi0 + (phi1 - phi0) * x[j];
            const vec3_t m = normal_at(au, av, r, phi);
            sum += weight[i] * weight[j] * g(au, av, w, m) * m.z * m.z * m.z * au * av * r;
        }
    return sum * (r1 - r0) * (phi1 - phi0);
}

static double integrate_all(integrand_t g, double au, double av, vec3_t w, int nodes)
{
    double sum = 0, r0 = 0;
    for (double r1 = 0.125; r0 < 1e5 / fmin(au, av); r1 *= 2) {
        for (int j = 0; j < 8; j++)
            sum += integrate(g, au, av, w, r0, r1, j * MATH_PI / 4, (j + 1) * MATH_PI / 4, nodes);
        r0 = r1;
    }
    return sum;
}

static double projected_d(double au, double av, vec3_t w, vec3_t m)
{
    (void)w;
    return ggx_d(au, av, m, 1) * m.z;
}

static double projected_visible(double au, double av, vec3_t w, vec3_t m)
{
    return ggx_d(au, av, m, 1) * fmax(vec3_dot(w, m), 0) * ggx_g1(au, av, w);
}

/* Heitz 2014, eq. 22 and 16: the two normalisations that define D and G1. */
static void distribution_and_masking_are_normalised(void **state)
{
    (void)state;
    for (int a = 0; a < ALPHAS; a++) {
        const double au = alphas[a][0], av = alphas[a][1];
        assert_near(integrate_all(projected_d, au, av, vec3(0, 0, 1), 12), 1, 1e-7);
        for (int i = 0; i < COSINES; i++) {
            const vec3_t w = direction(cosines[i], 0.13);
            /* the edge w.m = 0 is a kink: second order in the cells of 1/14 x 1/14 */
            assert_near(integrate_all(projected_visible, au, av, w, 14) / w.z, 1, 2e-3);
        }
    }
}

static void unnormalised_half_vectors_have_the_same_density(void **state)
{
    (void)state;
    for (int a = 0; a < ALPHAS; a++) {
        const vec3_t m = normal_at(alphas[a][0], alphas[a][1], 0.7, 0.4);
        const double d = ggx_d(alphas[a][0], alphas[a][1], m, 1);
        assert_near(ggx_d(alphas[a][0], alphas[a][1], vec3_scale(m, 3e-7), 9e-14), d, 1e-12 * d);
        /* the form with angles: 1 / (pi au av cos^4 (1 + tan^2 (cos^2/au^2 + sin^2/av^2))^2) */
        const double tu = m.x / m.z / alphas[a][0], tv = m.y / m.z / alphas[a][1], e = 1 + tu * tu + tv * tv;
        const double c2 = m.z * m.z;
        assert_near(1 / (MATH_PI * alphas[a][0] * alphas[a][1] * c2 * c2 * e * e), d, 1e-12 * d);
    }
}

static void smith_terms_agree(void **state)
{
    (void)state;
    for (int a = 0; a < ALPHAS; a++)
        for (int i = 0; i < COSINES; i++)
            for (int j = 0; j < COSINES; j++) {
                const double au = alphas[a][0], av = alphas[a][1];
                const vec3_t o = direction(cosines[i], 0.13), w = direction(cosines[j], 0.62);
                const double lo = ggx_lambda(au, av, o), lw = ggx_lambda(au, av, w);
                assert_near(ggx_g1(au, av, o) * (1 + lo), 1, 1e-14);
                assert_near(ggx_g2(au, av, o, w) * (1 + lo + lw), 1, 1e-14);
            }
}

static double visible_pdf(double au, double av, vec3_t w, vec3_t m)
{
    return ggx_visible_pdf(au, av, w, m);
}

/* Chi-square of N samples over octaves of slope and eighths of azimuth. */
static double histogram_p(double au, double av, vec3_t w, uint64_t key)
{
    enum { N = 40000, OCTAVES = 24, SECTORS = 8 };
    double seen[OCTAVES * SECTORS + 1] = {0};
    for (uint64_t i = 0; i < N; i++) {
        const vec3_t m = ggx_sample(au, av, w, random_double(key, 2 * i), random_double(key, 2 * i + 1));
        const double x = m.x / m.z / au, y = m.y / m.z / av, r = hypot(x, y);
        const int octave = r < 0.125 ? 0 : 1 + (int)floor(log2(r / 0.125));
        const int sector = (int)(warp_turns(y, x) * SECTORS);
        seen[octave < OCTAVES ? octave * SECTORS + sector : OCTAVES * SECTORS]++;
    }
    double chi2 = 0, rest_seen = seen[OCTAVES * SECTORS], rest_expected = N;
    int freedom = 0;
    for (int o = 0; o < OCTAVES; o++)
        for (int s = 0; s < SECTORS; s++) {
            const double r0 = o ? 0.125 * exp2(o - 1) : 0, r1 = 0.125 * exp2(o);
            const double expected =
                N * integrate(visible_pdf, au, av, w, r0, r1, s * MATH_PI / 4, (s + 1) * MATH_PI / 4, 20);
            if (expected < 10) {
                rest_seen += seen[o * SECTORS + s];
                continue;
            }
            rest_expected -= expected;
            const double d = seen[o * SECTORS + s] - expected;
            chi2 += d * d / expected;
            freedom++;
        }
    if (rest_expected > 10) {
        chi2 += (rest_seen - rest_expected) * (rest_seen - rest_expected) / rest_expected;
        freedom++;
    }
    assert_true(freedom > 8);
    return gsl_cdf_chisq_Q(chi2, freedom - 1);
}

/* 48 histograms, each with a false-alarm rate of 2e-8: 1e-6 together. */
static void samples_follow_the_density_of_visible_normals(void **state)
{
    (void)state;
    for (int a = 0; a < ALPHAS; a++)
        for (int i = 0; i < COSINES; i++) {
            const double p = histogram_p(alphas[a][0], alphas[a][1], direction(cosines[i], 0.13),
                                         random_step(SEED, (uint64_t)(a * COSINES + i)));
            if (!(p > 2e-8))
                fail_msg("alpha %g x %g, cosine %g: p = %g", alphas[a][0], alphas[a][1], cosines[i], p);
        }
}

/* u -> m -> u -> m. The round trip in m is what counts: in the azimuth u1 is without meaning where the cap's point
 * is at the pole. m's slopes are compared on the scale of alpha. */
static void inverse_gives_the_normal_back(void **state)
{
    (void)state;
    for (int a = 0; a < ALPHAS; a++)
        for (int i = 0; i < COSINES; i++)
            for (uint64_t n = 0; n < 2000; n++) {
                const double au = alphas[a][0], av = alphas[a][1];
                const vec3_t w = direction(cosines[i], 0.13);
                const double u1 = random_double(SEED, 2 * n), u2 = random_double(SEED, 2 * n + 1);
                double v1, v2;
                const vec3_t m = ggx_sample(au, av, w, u1, u2);
                ggx_invert(au, av, w, m, &v1, &v2);
                const vec3_t k = ggx_sample(au, av, w, v1, v2);
                /* on the stretched hemisphere, where all is of size 1. Near the horizon, at a height h.z, m has
                 * lost 2^-52 / (alpha h.z) of it; where h is short (grazing, cap point against w) rounding of c and
                 * w shows 1 / |h| times. */
                const vec3_t h = vec3_unit(vec3(m.x / au, m.y / av, m.z)),
                             g = vec3_unit(vec3(k.x / au, k.y / av, k.z));
                const vec3_t s = vec3_unit(vec3(au * w.x, av * w.y, w.z));
                const double tolerance = 1e-13 + 1e-14 / fmax(vec3_dot(h, s), 1e-9);
                if (!(vec3_length(vec3_sub(h, g)) < tolerance))
                    fail_msg("alpha %g x %g cosine %g u %.17g %.17g -> %.17g %.17g: off by %g (allowed %g)", au, av,
                             cosines[i], u1, u2, v1, v2, vec3_length(vec3_sub(h, g)), tolerance);
                assert_true(v1 >= 0 && v1 < 1 && v2 >= 0 && v2 < 1);
            }
}

/* |dm/du1 x dm/du2| = 1 / density, by central differences: error of order step^2 over the distance to the cap's
 * ends. */
static void jacobian_is_one_over_the_density(void **state)
{
    (void)state;
    const double step = 1e-5;
    for (int a = 0; a < ALPHAS; a++)
        for (int i = 0; i < COSINES; i++)
            for (uint64_t n = 0; n < 200; n++) {
                const double au = alphas[a][0], av = alphas[a][1];
                const vec3_t w = direction(cosines[i], 0.13);
                const double u1 = random_double(SEED, 2 * n), u2 = 0.02 + 0.9 * random_double(SEED, 2 * n + 1);
                const vec3_t m = ggx_sample(au, av, w, u1, u2);
                const vec3_t d1 =
                    vec3_sub(ggx_sample(au, av, w, u1 + step, u2), ggx_sample(au, av, w, u1 - step, u2));
                const vec3_t d2 =
                    vec3_sub(ggx_sample(au, av, w, u1, u2 + step), ggx_sample(au, av, w, u1, u2 - step));
                const double area = vec3_length(vec3_cross(d1, d2)) / (4 * step * step);
                /* differences of size alpha step, known to 2^-53: relative 1e-16 / (alpha step), at 1e-4 1e-7. At
                 * grazing w the cap's ends approach: derivatives grow with 1 / (h.w) */
                const vec3_t s = vec3_unit(vec3(au * w.x, av * w.y, w.z));
                const vec3_t h = vec3_unit(vec3(m.x / au, m.y / av, m.z));
                if (vec3_dot(h, s) < 0.05)
                    continue;
                assert_near(area * ggx_visible_pdf(au, av, w, m), 1, 1e-4);
            }
}

static void extremes_are_finite(void **state)
{
    (void)state;
    static const double ends[] = {0, 0x1p-53, 0.5, MATH_ONE_MINUS};
    for (int a = 0; a < ALPHAS; a++)
        for (int i = 0; i < COSINES; i++)
            for (int j = 0; j < 16; j++)
                for (int t = 0; t < 8; t++) {
                    const double au = alphas[a][0], av = alphas[a][1];
                    const vec3_t w = direction(cosines[i], t / 8.0);
                    const vec3_t m = ggx_sample(au, av, w, ends[j % 4], ends[j / 4]);
                    const double pdf = ggx_visible_pdf(au, av, w, m);
                    assert_true(vec3_finite(m) && m.z >= 0);
                    assert_near(vec3_length(m), 1, 1e-14);
                    assert_true(isfinite(pdf) && pdf >= 0);
                    double u1, u2;
                    ggx_invert(au, av, w, m, &u1, &u2);
                    assert_true(u1 >= 0 && u1 < 1 && u2 >= 0 && u2 < 1);
                }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distribution_and_masking_are_normalised),
        cmocka_unit_test(unnormalised_half_vectors_have_the_same_density),
        cmocka_unit_test(smith_terms_agree),
        cmocka_unit_test(samples_follow_the_density_of_visible_normals),
        cmocka_unit_test(inverse_gives_the_normal_back),
        cmocka_unit_test(jacobian_is_one_over_the_density),
        cmocka_unit_test(extremes_are_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
