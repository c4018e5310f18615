/* No material returns more light than it gets, and those that must return all of it do. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "scene/bsdf_coat.h"

#include "bsdf_fixture.h"

enum { SAMPLES = 8000 };

typedef struct mean {
    double value, error;
} mean_t;

/* Mean over samples of the largest channel's weight, in importance mode, in which refraction conserves energy. */
static mean_t albedo(const fixture_t *f, uint32_t m, vec3_t wo, uint64_t key)
{
    double sum = 0, sum2 = 0;
    for (uint64_t n = 0; n < SAMPLES; n++) {
        /* the first number stratified: the choice of the lobe adds little noise */
        const double u[3] = {((double)n + random_double(key, 3 * n)) / SAMPLES, random_double(key, 3 * n + 1),
                             random_double(key, 3 * n + 2)};
        bsdf_sample_t s;
        const double x = bsdf_sample(fixture_bsdf(f, m), f->tables, wo, u, BSDF_IMPORTANCE, &s) ? s.weight.r : 0;
        sum += x;
        sum2 += x * x;
    }
    const double mean = sum / SAMPLES;
    return (mean_t){mean, sqrt(fmax(sum2 / SAMPLES - mean * mean, 0) / SAMPLES)};
}

/* 350 means, each allowed 6 standard errors (1e-9 one-sided; stratification makes the error smaller than stated)
 * and, where a coat's table is involved, its error. */
static void albedo_is_at_most_one_and_one_where_it_must(void **state)
{
    const fixture_t *f = *state;
    for (uint32_t m = 0; m < f->count; m++)
        for (int d = 0; d < FIXTURE_DIRECTIONS; d++) {
            const mean_t a = albedo(f, m, fixture_direction(d), random_key(5, RANDOM_PURPOSE_TEST, m, (uint64_t)d));
            const double slack = 6 * a.error + 1e-3;
            if (!(a.value <= 1 + slack) || !(a.value >= (f->furnace[m] ? 1 - slack : 0)))
                fail_msg("%s, wo.z %g: albedo %.6f +- %.6f%s", f->names[m], fixture_direction(d).z, a.value,
                         a.error, f->furnace[m] ? ", expected 1" : "");
        }
}

/* Sums of specular coefficients are exact: reflection and refraction share all light. */
static void specular_surfaces_share_all_light(void **state)
{
    const fixture_t *f = *state;
    for (uint32_t m = 0; m < f->count; m++) {
        const bsdf_t *bsdf = fixture_bsdf(f, m);
        if (!f->furnace[m] || bsdf->count != 1 || (bsdf->flags & BSDF_HAS_SMOOTH))
            continue;
        for (int d = 0; d < FIXTURE_DIRECTIONS; d++) {
            double sum = 0;
            bsdf_sample_t low, high;
            const double first[3] = {0, 0.5, 0.5}, last[3] = {MATH_ONE_MINUS, 0.5, 0.5};
            assert_true(bsdf_sample(bsdf, f->tables, fixture_direction(d), first, BSDF_IMPORTANCE, &low));
            assert_true(bsdf_sample(bsdf, f->tables, fixture_direction(d), last, BSDF_IMPORTANCE, &high));
            sum = low.weight.r * low.pdf + (low.transmitted != high.transmitted ? high.weight.r * high.pdf : 0);
            const double lost =
                f->names[m][0] == 'p' || f->names[m][0] == 'v' ? 1e-8 / fabs(fixture_direction(d).z) : 1e-14;
            if (!(fabs(sum - 1) < lost)) /* the perfect mirror's F is 1 - 4e-9 / cosine */
                fail_msg("%s, wo.z %g: %.12f", f->names[m], fixture_direction(d).z, sum);
        }
    }
}

/* Radiance through a smooth interface: 1 / eta^2 of it, and back again. */
static void radiance_changes_with_the_index(void **state)
{
    (void)state;
    fixture_t f = {0};
    const uint32_t m = fixture_dielectric(&f, "glass", 1.5F, 0, 0);
    fixture_make(&f);
    const double last[3] = {MATH_ONE_MINUS, 0.5, 0.5};
    for (int side = -1; side <= 1; side += 2) {
        bsdf_sample_t s;
        assert_true(bsdf_sample(fixture_bsdf(&f, m), f.tables, vec3(0.6 * 0.1, 0, side * sqrt(1 - 0.0036)), last,
                                BSDF_RADIANCE, &s));
        assert_true(s.transmitted && fabs(s.weight.r * pow(1.5, 2 * side) - 1) < 1e-14);
        assert_true(fabs(s.eta - pow(1.5, side)) < 1e-15);
        assert_true(fabs(s.wi.x + 0.06 / pow(1.5, side)) < 1e-15); /* Snell */
    }
    fixture_clear(&f);
}

/* Thin sheet: the sum over bounces between its faces, ray by ray. */
static void thin_sheet_sums_its_interreflections(void **state)
{
    (void)state;
    fixture_t f = {0};
    const uint32_t m = fixture_add(&f, "pane", SCENE_MATERIAL_THIN_DIELECTRIC);
    fixture_make(&f);
    const double r = fresnel_dielectric(0.37, 1.5);
    double reflected = r, inside = 1 - r;
    for (int bounce = 1; bounce < 200; bounce++) { /* at each face: (1 - r) leaves */
        if (bounce % 2 == 0)
            reflected += inside * (1 - r);
        inside *= r;
    }
    const double u[3] = {0, 0, 0};
    bsdf_sample_t s;
    assert_true(
        bsdf_sample(fixture_bsdf(&f, m), f.tables, vec3(sqrt(1 - 0.37 * 0.37), 0, 0.37), u, BSDF_RADIANCE, &s));
    assert_true(!s.transmitted && fabs(s.weight.r * s.pdf - reflected) < 1e-14);
    fixture_clear(&f);
}

static void coated_mirror_sums_its_interreflections(void **state)
{
    (void)state;
    fixture_t f = {0};
    const uint32_t m = fixture_coated_conductor(&f, "varnished", 0, 0);
    fixture_make(&f);
    const double c = 0.37, f0 = fresnel_dielectric(c, 1.5), inside = sqrt(1 - (1 - c * c) / 2.25);
    const double metal = fresnel_conductor1(inside, (double)0.21F / 1.5, (double)3.59F / 1.5);
    double reflected = f0, walk = (1 - f0) * metal;
    for (int bounce = 0; bounce < 500; bounce++) {
        reflected += walk * (1 - f0);
        walk *= f0 * metal;
    }
    const double u[3] = {0.9, 0, 0};
    bsdf_sample_t s;
    assert_true(bsdf_sample(fixture_bsdf(&f, m), f.tables, vec3(sqrt(1 - c * c), 0, c), u, BSDF_RADIANCE, &s));
    assert_true(s.specular && s.pdf == 1 && fabs(s.weight.r - reflected) < 1e-14);
    fixture_clear(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(albedo_is_at_most_one_and_one_where_it_must),
        cmocka_unit_test(specular_surfaces_share_all_light),
        cmocka_unit_test(radiance_changes_with_the_index),
        cmocka_unit_test(thin_sheet_sums_its_interreflections),
        cmocka_unit_test(coated_mirror_sums_its_interreflections),
    };
    return cmocka_run_group_tests(tests, fixture_setup, fixture_teardown);
}
