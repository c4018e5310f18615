/* What holds for a pair of directions: sample and value agree, both densities, reciprocity, the adjoint, hard
 * cases. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "bsdf_fixture.h"

#define assert_close(value, expected, tolerance)                                                                   \
    do {                                                                                                           \
        const double value_ = (value), expected_ = (expected), tolerance_ = (tolerance)*fabs(expected_);           \
        if (!(fabs(value_ - expected_) <= tolerance_))                                                             \
            fail_msg("%s, wo.z %g wi.z %g: %s is %.17g, expected %.17g within %g", f->names[m], wo.z, wi.z,        \
                     #value, value_, expected_, tolerance_);                                                       \
    } while (0)

enum { PER_DIRECTION = 100 };

static vec3_t direction(double z, double turns)
{
    const double r = sqrt((1 - z) * (1 + z));
    return vec3(r * cos(2 * MATH_PI * turns), r * sin(2 * MATH_PI * turns), z);
}

static void numbers(uint64_t key, uint64_t n, double u[3])
{
    for (uint64_t i = 0; i < 3; i++)
        u[i] = random_double(key, 3 * n + i);
}

/* For smooth samples weight pdf = f cos; both densities are what bsdf_eval says, and the reverse one what it says
 * of the swapped pair. The three compute the same formulas from the same directions up to the order of roundings.
 */
static void check_smooth(const fixture_t *f, uint32_t m, vec3_t wo, bsdf_mode_t mode, const bsdf_sample_t *s)
{
    const bsdf_t *bsdf = fixture_bsdf(f, m);
    const vec3_t wi = s->wi;
    const double loose = 1e-12 + fixture_condition(bsdf, wo, wi);
    bsdf_value_t v, swapped;
    bsdf_eval(bsdf, f->tables, wo, wi, mode, &v);
    bsdf_eval(bsdf, f->tables, wi, wo, mode == BSDF_RADIANCE ? BSDF_IMPORTANCE : BSDF_RADIANCE, &swapped);
    assert_close(s->pdf, v.pdf, 1e-12);
    assert_close(s->pdf_reverse, v.pdf_reverse, 1e-12);
    assert_close(s->weight.r * s->pdf, v.f.r * fabs(wi.z), 1e-12);
    assert_close(s->weight.b * s->pdf, v.f.b * fabs(wi.z), 1e-12);
    assert_close(s->pdf_reverse, swapped.pdf, loose);
    assert_close(s->pdf, swapped.pdf_reverse, loose);
    /* adjoint: the same light along the same path, walked from the other end (Veach 1997, eq. 5.14 and section 5.2)
     */
    assert_close(v.f.g, swapped.f.g, loose);
}

/* A specular event taken back: the same probability that pdf_reverse announces, and the same product of
 * coefficients. */
static void check_specular(const fixture_t *f, uint32_t m, vec3_t wo, bsdf_mode_t mode, const bsdf_sample_t *s)
{
    const bsdf_t *bsdf = fixture_bsdf(f, m);
    const vec3_t wi = s->wi;
    const double free_numbers[3] = {0.5, 0.5, 0.5};
    double u[3];
    assert_true(bsdf_invert(bsdf, f->tables, wi, wo, true, s->lobe, mode, free_numbers, u));
    bsdf_sample_t back;
    const bsdf_mode_t other = mode == BSDF_RADIANCE ? BSDF_IMPORTANCE : BSDF_RADIANCE;
    assert_true(bsdf_sample(bsdf, f->tables, wi, u, other, &back));
    assert_true(back.specular && back.lobe == s->lobe && back.transmitted == s->transmitted);
    const double bent = s->eta > 1 ? s->eta : 1 / s->eta;
    /* from the denser side the other cosine is c = sqrt(eta^2 c'^2 - (eta^2 - 1)): c^2 is known to some eta^2
     * 2^-52, c to eta^2 2^-53 / c, and 1 - F, proportional to c at grazing, to eta^2 2^-53 / c^2 of itself; a few
     * roundings: 2^-50 */
    const double least = fmin(fabs(wo.z), fabs(wi.z));
    const double loose = 1e-12 + 0x1p-50 * bent * bent / (least * least);
    if (vec3_length(vec3_sub(back.wi, wo)) > loose)
        fail_msg("%s, wo.z %g: comes back %g away", f->names[m], wo.z, vec3_length(vec3_sub(back.wi, wo)));
    assert_close(s->pdf_reverse, back.pdf, loose);
    assert_close(s->pdf, back.pdf_reverse, loose);
    /* f = C / |cos wi| delta(wi) with C = weight pdf, and cos_o dwo = eta^2 cos_i dwi: f of one mode is f of the
     * way back in the other if C = C_back / eta^2 */
    assert_close(s->weight.g * s->pdf, back.weight.g * back.pdf / (s->eta * s->eta), loose);
    assert_close(s->eta * back.eta, 1, 1e-14);
}

static void samples_agree_with_values_and_with_the_way_back(void **state)
{
    const fixture_t *f = *state;
    for (uint32_t m = 0; m < f->count; m++)
        for (int d = 0; d < FIXTURE_DIRECTIONS; d++)
            for (uint64_t n = 0; n < PER_DIRECTION; n++) {
                const bsdf_mode_t mode = n & 1 ? BSDF_IMPORTANCE : BSDF_RADIANCE;
                double u[3];
                numbers(random_key(3, RANDOM_PURPOSE_TEST, m, (uint64_t)d), n, u);
                bsdf_sample_t s;
                if (!bsdf_sample(fixture_bsdf(f, m), f->tables, fixture_direction(d), u, mode, &s))
                    continue;
                if (s.specular)
                    check_specular(f, m, fixture_direction(d), mode, &s);
                else
                    check_smooth(f, m, fixture_direction(d), mode, &s);
            }
}

/* Reflection: f(o,i) = f(i,o) in one mode. Refraction: f / eta^2 of the side of wi is symmetric (Veach 1997,
 * eq. 5.14), which makes f of importance eta^2 that of radiance. Over random pairs, wherever they are. */
static void reciprocity_and_adjoint(void **state)
{
    const fixture_t *f = *state;
    for (uint32_t m = 0; m < f->count; m++)
        for (uint64_t n = 0; n < 300; n++) {
            const vec3_t wo = fixture_random_direction(99, 2 * n), wi = fixture_random_direction(99, 2 * n + 1);
            const bsdf_t *bsdf = fixture_bsdf(f, m);
            const double loose = 1e-12 + fixture_condition(bsdf, wo, wi);
            bsdf_value_t v, swapped, importance;
            bsdf_eval(bsdf, f->tables, wo, wi, BSDF_RADIANCE, &v);
            bsdf_eval(bsdf, f->tables, wi, wo, BSDF_RADIANCE, &swapped);
            bsdf_eval(bsdf, f->tables, wo, wi, BSDF_IMPORTANCE, &importance);
            double eta2 = 1;
            for (uint32_t l = 0; l < bsdf->count; l++)
                if (bsdf->lobes[l].kind == BSDF_DIELECTRIC && wo.z * wi.z < 0)
                    eta2 = pow(bsdf->lobes[l].eta, wo.z > 0 ? 2 : -2);
            assert_close(importance.f.r, v.f.r * eta2, 1e-12);
            assert_close(swapped.f.r, v.f.r * eta2, loose);
            assert_close(importance.pdf, v.pdf, 0);
            assert_close(swapped.pdf, v.pdf_reverse, loose);
        }
}

/* Numbers at the ends of their range, directions down to a cosine of 1e-9: nothing but finite numbers. */
static void check_finite(const fixture_t *f, uint32_t m, vec3_t wo, const double u[3], bsdf_mode_t mode)
{
    bsdf_sample_t s;
    if (!bsdf_sample(fixture_bsdf(f, m), f->tables, wo, u, mode, &s))
        return;
    const double sum = s.weight.r + s.weight.g + s.weight.b;
    const bool good = s.weight.r >= 0 && s.weight.g >= 0 && s.weight.b >= 0 && isfinite(sum) && s.pdf > 0 &&
                      isfinite(s.pdf) && s.pdf_reverse >= 0 && isfinite(s.pdf_reverse) && s.wi.z != 0 &&
                      fabs(vec3_length(s.wi) - 1) < 1e-12 && s.transmitted == (s.wi.z * wo.z < 0);
    if (!good)
        fail_msg("%s, wo.z %g, u %g %g %g: weight %g %g %g, pdf %g, reverse %g, wi %g %g %g", f->names[m], wo.z,
                 u[0], u[1], u[2], s.weight.r, s.weight.g, s.weight.b, s.pdf, s.pdf_reverse, s.wi.x, s.wi.y,
                 s.wi.z);
    const double free_numbers[3] = {u[2], u[1], u[0]};
    double back[3];
    if (bsdf_invert(fixture_bsdf(f, m), f->tables, wo, s.wi, s.specular, s.lobe, mode, free_numbers, back))
        for (int i = 0; i < 3; i++)
            assert_true(back[i] >= 0 && back[i] < 1);
}

static void hard_cases_stay_finite(void **state)
{
    const fixture_t *f = *state;
    static const double ends[] = {0, 0x1p-53, 0.3, MATH_ONE_MINUS};
    static const double cosines[] = {1, 0.4, 1e-3, 1e-6, 1e-9, -1, -0.4, -1e-6, -1e-9};
    for (uint32_t m = 0; m < f->count; m++)
        for (size_t i = 0; i < sizeof cosines / sizeof *cosines; i++)
            for (int j = 0; j < 64; j++) {
                const double u[3] = {ends[j % 4], ends[j / 4 % 4], ends[j / 16]};
                check_finite(f, m, direction(cosines[i], 0.11), u, j & 1 ? BSDF_IMPORTANCE : BSDF_RADIANCE);
                check_finite(f, m, direction(cosines[i], 0.25), u, j & 1 ? BSDF_RADIANCE : BSDF_IMPORTANCE);
            }
}

static void values_of_odd_pairs_are_finite(void **state)
{
    const fixture_t *f = *state;
    static const double cosines[] = {1, 0.7, 1e-6, 1e-9, -1e-9, -1e-6, -0.7, -1};
    for (uint32_t m = 0; m < f->count; m++)
        for (int i = 0; i < 8; i++)
            for (int j = 0; j < 8; j++)
                for (int t = 0; t < 4; t++) {
                    bsdf_value_t v;
                    bsdf_eval(fixture_bsdf(f, m), f->tables, direction(cosines[i], 0.1),
                              direction(cosines[j], 0.1 + 0.25 * t), BSDF_RADIANCE, &v);
                    const bool good = v.f.r >= 0 && v.f.g >= 0 && v.f.b >= 0 && v.pdf >= 0 && v.pdf_reverse >= 0 &&
                                      isfinite(v.f.r + v.f.g + v.f.b + v.pdf + v.pdf_reverse);
                    if (!good)
                        fail_msg("%s, cosines %g %g: f %g %g %g pdf %g %g", f->names[m], cosines[i], cosines[j],
                                 v.f.r, v.f.g, v.f.b, v.pdf, v.pdf_reverse);
                }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_agree_with_values_and_with_the_way_back),
        cmocka_unit_test(reciprocity_and_adjoint),
        cmocka_unit_test(hard_cases_stay_finite),
        cmocka_unit_test(values_of_odd_pairs_are_finite),
    };
    return cmocka_run_group_tests(tests, fixture_setup, fixture_teardown);
}
