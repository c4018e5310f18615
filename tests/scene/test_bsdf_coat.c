#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "base/random.h"
#include "scene/bsdf_coat.h"

#include "scene/ggx.h"
#include "scene/quadrature.h"

#include "bsdf_fixture.h"
#include "support/near.h"

/* What docs/materials.md states of the tables: constant coats, and textured ones (linear between rows). */
#define TABLE_ERROR 5e-4
#define ANISOTROPIC_ERROR 1e-3
#define TEXTURED_ERROR 4e-3

static vec3_t direction(double z, double turns)
{
    const double r = sqrt((1 - z) * (1 + z));
    return vec3(r * cos(2 * MATH_PI * turns), r * sin(2 * MATH_PI * turns), z);
}

static double albedo_of(const bsdf_coat_t *coat, vec3_t w, double row)
{
    double through;
    const double albedo = bsdf_coat_albedo(coat, w, row, &through);
    assert_near(albedo + through, 1, 4e-16);
    return albedo;
}

static void check_table(const bsdf_coat_t *coat, double au, double av, double tolerance)
{
    static const double cosines[] = {0.9973, 0.81, 0.53, 0.27, 0.11, 0.031, 0.012, 0.0041};
    const double row = bsdf_coat_row(coat, au, av);
    for (size_t i = 0; i < sizeof cosines / sizeof *cosines; i++)
        for (int t = 0; t < 3; t++) {
            const vec3_t w = direction(cosines[i], 0.04 + 0.11 * t);
            assert_near(albedo_of(coat, w, row), bsdf_coat_quadrature(coat->eta, au, av, w, 6), tolerance);
        }
}

static void tables_hold_the_albedo_of_the_lobe(void **state)
{
    (void)state;
    static const double alphas[][2] = {{1, 1}, {0.5, 0.5}, {0.2, 0.2}, {0.05, 0.05}, {1e-2, 1e-2}, {1e-3, 1e-3}};
    for (size_t i = 0; i < sizeof alphas / sizeof *alphas; i++) {
        bsdf_coat_t coat;
        assert_int_equal(bsdf_coat_init(&coat, BSDF_COAT_ROUGH, 1.5, alphas[i][0], alphas[i][1], NULL), FAULT_NONE);
        check_table(&coat, alphas[i][0], alphas[i][1], TABLE_ERROR);
        bsdf_coat_clear(&coat);
    }
}

static void anisotropic_and_textured_tables_interpolate_between_rows(void **state)
{
    (void)state;
    bsdf_coat_t coat;
    assert_int_equal(bsdf_coat_init(&coat, BSDF_COAT_ANISOTROPIC, 1.5, 0.4, 0.1, NULL), FAULT_NONE);
    check_table(&coat, 0.4, 0.1, ANISOTROPIC_ERROR);
    bsdf_coat_clear(&coat);
    assert_int_equal(bsdf_coat_init(&coat, BSDF_COAT_ANISOTROPIC, 1.5, 0.1, 0.3, NULL), FAULT_NONE);
    check_table(&coat, 0.1, 0.3, ANISOTROPIC_ERROR);
    bsdf_coat_clear(&coat);
    assert_int_equal(bsdf_coat_init(&coat, BSDF_COAT_TEXTURED, 1.5, 0, 0, NULL), FAULT_NONE);
    check_table(&coat, 0.37, 0.37, TEXTURED_ERROR);
    check_table(&coat, 0.021, 0.021, TEXTURED_ERROR);
    check_table(&coat, 1, 1, TEXTURED_ERROR);
    bsdf_coat_clear(&coat);
}

/* The quadrature against random visible normals of another sampler: rejection from the cosine hemisphere is slow,
 * so the lobe's value is summed over a uniform hemisphere of wi. Tolerance 5.5 standard errors: 4e-8 each. */
static void quadrature_equals_the_mean_of_the_value(void **state)
{
    (void)state;
    enum { N = 100000 };
    const uint64_t key = random_key(7, RANDOM_PURPOSE_TEST, 0, 3);
    static const double cosines[] = {0.95, 0.4, 0.05};
    for (size_t i = 0; i < 3; i++) {
        const vec3_t w = direction(cosines[i], 0.1);
        double sum = 0, sum2 = 0;
        for (uint64_t n = 0; n < N; n++) {
            const vec3_t wi = direction(random_double(key, 2 * n), random_double(key, 2 * n + 1));
            const ggx_reflection_t g = ggx_reflect(0.6, 0.4, w, wi);
            const double x = wi.z > 0 ? 2 * MATH_PI * g.f * fresnel_dielectric(g.cosine, 1.7) * wi.z : 0;
            sum += x;
            sum2 += x * x;
        }
        const double mean = sum / N, error = sqrt((sum2 / N - mean * mean) / N);
        assert_near(bsdf_coat_quadrature(1.7, 0.6, 0.4, w, 2), mean, 5.5 * error);
    }
}

static void smooth_coats_are_fresnel(void **state)
{
    (void)state;
    bsdf_coat_t coat;
    assert_int_equal(bsdf_coat_init(&coat, BSDF_COAT_SMOOTH, 1.5, 0, 0, NULL), FAULT_NONE);
    assert_near(albedo_of(&coat, direction(0.3, 0.2), 0), fresnel_dielectric(0.3, 1.5), 0);
    /* the same from inside: two routes to the internal reflectance */
    assert_near(bsdf_coat_inner(&coat, 0), fresnel_diffuse(1 / 1.5), 1e-14);
    bsdf_coat_t textured;
    assert_int_equal(bsdf_coat_init(&textured, BSDF_COAT_TEXTURED, 1.5, 0, 0, NULL), FAULT_NONE);
    assert_near(albedo_of(&textured, direction(0.3, 0.2), 0), fresnel_dielectric(0.3, 1.5), 1e-6);
    assert_near(bsdf_coat_inner(&textured, 0), fresnel_diffuse(1 / 1.5), 1e-6);
    bsdf_coat_clear(&textured);
    bsdf_coat_clear(&coat);
}

/* int f cos over wi of the base alone: Gauss in mu = s^2, and 64 azimuths for anisotropic coats. */
static double base_albedo(const fixture_t *f, uint32_t material, vec3_t wo)
{
    enum { NODES = 64, AZIMUTHS = 64 };
    double x[NODES], w[NODES], sum = 0;
    quadrature_gauss(NODES, x, w);
    bsdf_t base = {.count = 1, .flags = BSDF_HAS_SMOOTH, .lobes = {fixture_bsdf(f, material)->lobes[1]}};
    assert_int_equal(base.lobes[0].kind, BSDF_COATED_BASE);
    for (int i = 0; i < NODES; i++)
        for (int j = 0; j < AZIMUTHS; j++) {
            const double mu = x[i] * x[i];
            bsdf_value_t v;
            bsdf_eval(&base, f->tables, wo, direction(mu, (j + 0.5) / AZIMUTHS), BSDF_RADIANCE, &v);
            sum += v.f.r * mu * 2 * x[i] * w[i] * 2 * MATH_PI / AZIMUTHS;
        }
    return sum;
}

/* The albedo of coat and white base is 1: exactly for a smooth coat, to the table's error for rough ones. */
static void white_under_a_coat_loses_nothing(void **state)
{
    (void)state;
    fixture_t f = {0};
    const uint32_t smooth = fixture_coated_diffuse(&f, "smooth", 1, 1.5F, 0, 0);
    const uint32_t thick = fixture_coated_diffuse(&f, "smooth", 1, 2.4F, 0, 0);
    const uint32_t rough = fixture_coated_diffuse(&f, "rough", 1, 1.5F, 0.3F, 0.3F);
    const uint32_t brushed = fixture_coated_diffuse(&f, "brushed", 1, 1.5F, 0.4F, 0.1F);
    fixture_make(&f);
    static const double cosines[] = {0.99, 0.5, 0.1, 0.01};
    for (size_t i = 0; i < 4; i++) {
        const vec3_t wo = direction(cosines[i], 0.17);
        assert_near(base_albedo(&f, smooth, wo) + fresnel_dielectric(wo.z, 1.5), 1, 1e-9);
        assert_near(base_albedo(&f, thick, wo) + fresnel_dielectric(wo.z, (double)2.4F), 1, 1e-9);
        const double e = bsdf_coat_quadrature(1.5, (double)0.3F, (double)0.3F, wo, 6);
        assert_near(base_albedo(&f, rough, wo) + e, 1, TABLE_ERROR);
        const double b = bsdf_coat_quadrature(1.5, (double)0.4F, (double)0.1F, wo, 6);
        assert_near(base_albedo(&f, brushed, wo) + b, 1, ANISOTROPIC_ERROR);
    }
    fixture_clear(&f);
}

/* The second way for a smooth coat: one photon at a time through interface and Lambertian base. */
static void smooth_coats_equal_a_random_walk(void **state)
{
    (void)state;
    enum { N = 200000 };
    const double eta = 1.5, rho = 0.7;
    const uint64_t key = random_key(9, RANDOM_PURPOSE_TEST, 0, 4);
    fixture_t f = {0};
    const uint32_t m = fixture_coated_diffuse(&f, "lacquer", 0.7F, 1.5F, 0, 0);
    fixture_make(&f);
    const vec3_t wo = direction(0.45, 0);
    uint64_t counter = 0;
    double out = 0, flat = 0; /* leaving by the base; those of cosine above 1/2 */
    for (int n = 0; n < N; n++) {
        if (random_double(key, counter++) < fresnel_dielectric(wo.z, eta))
            continue;
        while (random_double(key, counter++) < rho) {
            const double c = sqrt(random_double(key, counter++)); /* cosine-weighted, inside */
            double g;
            if (random_double(key, counter++) < fresnel_dielectric_g(c, 1 / eta, &g))
                continue;
            out += 1;
            flat += g * eta > 0.5;
            break;
        }
    }
    const double albedo = base_albedo(&f, m, wo);
    const double p = out / N;
    assert_near(albedo, p, 5.5 * sqrt(p * (1 - p) / N) + 1e-8);
    /* share above 1/2: int_{1/2}^1 T mu dmu / int_0^1 */
    double x[64], w[64], upper = 0, all = 0;
    quadrature_gauss(64, x, w);
    for (int i = 0; i < 64; i++) {
        const double mu = 0.5 + 0.5 * x[i], lower = 0.5 * x[i];
        upper += w[i] * mu * (1 - fresnel_dielectric(mu, eta));
        all += w[i] * lower * (1 - fresnel_dielectric(lower, eta));
    }
    const double share = upper / (upper + all);
    assert_near(flat / out, share, 5.5 * sqrt(share * (1 - share) / out));
    fixture_clear(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_hold_the_albedo_of_the_lobe),
        cmocka_unit_test(anisotropic_and_textured_tables_interpolate_between_rows),
        cmocka_unit_test(quadrature_equals_the_mean_of_the_value),
        cmocka_unit_test(smooth_coats_are_fresnel),
        cmocka_unit_test(white_under_a_coat_loses_nothing),
        cmocka_unit_test(smooth_coats_equal_a_random_walk),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
