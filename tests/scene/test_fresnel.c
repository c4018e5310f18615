#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include <complex.h>
#include <stdio.h>

#include "base/random.h"
#include "scene/fresnel.h"
#include "support/near.h"

#define SEED random_key(2024, RANDOM_PURPOSE_TEST, 0, 1)

/* The textbook forms in extended precision, complex where they need to be: the second way. */
static double textbook(double c, long double complex index)
{
    const long double cl = c, s2 = (1 - cl) * (1 + cl);
    const long double complex g = csqrtl(index * index - s2);
    const long double complex rs = (cl - g) / (cl + g);
    const long double complex rp = (index * index * cl - g) / (index * index * cl + g);
    const long double as = cabsl(rs), ap = cabsl(rp);
    return (double)((as * as + ap * ap) / 2);
}

static void dielectric_equals_the_textbook_form(void **state)
{
    (void)state;
    static const double etas[] = {1.5, 1 / 1.5, 1.33, 2.4, 1 / 2.4, 10};
    for (size_t e = 0; e < sizeof etas / sizeof *etas; e++)
        for (uint64_t i = 0; i < 4000; i++) {
            const double c =
                i == 0 ? 1 : random_double(SEED, i) * pow(10, -9 * random_double(SEED, i + 9999)) + 1e-12;
            /* near the critical angle F has an infinite slope in c: rounding of c^2 + eta^2 - 1 by 2e-16 gives sqrt
             * of it */
            const double g2 = fabs(c * c + etas[e] * etas[e] - 1);
            assert_near(fresnel_dielectric(c, etas[e]), textbook(c, etas[e]), 1e-14 + 3e-15 / sqrt(g2 + 1e-16));
        }
}

/* The real form, without total reflection, in extended precision. */
static double textbook_real(double c, double eta)
{
    const long double cl = c, n = eta, g = sqrtl(cl * cl + (n * n - 1));
    const long double rs = (cl - g) / (cl + g), rp = (n * n * cl - g) / (n * n * cl + g);
    return (double)((rs * rs + rp * rp) / 2);
}

static void dielectric_keeps_relative_precision_as_the_index_is_matched(void **state)
{
    (void)state;
    for (int power = 1; power <= 12; power++) {
        const double eta = 1 + pow(10, -power);
        for (uint64_t i = 0; i < 1000; i++) {
            const double c = 0.01 + 0.99 * random_double(SEED, i);
            const double expected = textbook_real(c, eta);
            /* 19 digits of the long double, minus those that c - g and n^2 - 1 lose: both are of the size of eta -
             * 1 */
            const double lost = 1e-18 / (eta - 1);
            /* r_p has a zero (Brewster), where only r_s is left: it stays relative */
            assert_near(fresnel_dielectric(c, eta), expected, expected * (1e-13 + 8 * lost));
        }
    }
    assert_true(fresnel_dielectric(0.3, 1) == 0);
}

static void dielectric_is_the_same_from_both_sides(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 10000; i++) {
        const double eta = 1 + 2 * random_double(SEED, 2 * i), c = random_double(SEED, 2 * i + 1) + 1e-9;
        double g;
        const double f = fresnel_dielectric_g(c, eta, &g);
        /* the cosine comes back as sqrt(c'^2 + 1/eta^2 - 1) = c / eta: off by 2^-52 / c, and F has a slope of 4 / g
         */
        assert_near(fresnel_dielectric(g / eta, 1 / eta), f, 1e-14 + 0x1p-48 * eta * eta / (c * g));
        assert_near(g * g, c * c + eta * eta - 1, 1e-14 * eta * eta);
    }
}

static void total_reflection_begins_at_the_critical_angle(void **state)
{
    (void)state;
    const double eta = 1 / 1.5, critical = sqrt(1 - eta * eta);
    double g = 7;
    assert_true(fresnel_dielectric_g(critical * (1 - 1e-12), eta, &g) == 1);
    assert_true(g == 0);
    const double above = fresnel_dielectric_g(critical * (1 + 1e-9), eta, &g);
    assert_true(above < 1 && above > 0.999 && g > 0);
    assert_near(fresnel_dielectric(1e-12, 1.5), 1, 1e-11);
}

static void conductor_equals_the_complex_form(void **state)
{
    (void)state;
    static const double indices[][2] = {{0.2, 3.9}, {1.18, 2.31}, {1e-3, 1000}, {1000, 1000},
                                        {1.5, 0},   {0.05, 5},    {0.5, 0.01}};
    for (size_t m = 0; m < sizeof indices / sizeof *indices; m++)
        for (uint64_t i = 0; i < 4000; i++) {
            const double c = i == 0 ? 1 : pow(10, -9 * random_double(SEED, i));
            const double n = indices[m][0], k = indices[m][1];
            assert_near(fresnel_conductor1(c, n, k), textbook(c, (long double)n + (long double)k * I), 1e-13);
        }
    assert_near(fresnel_conductor1(0.4, 1.7, 0), fresnel_dielectric(0.4, 1.7), 1e-15);
    assert_near(1 - fresnel_conductor1(1, 1e-3, 1000), 4e-9, 1e-14);
    assert_true(fresnel_conductor1(1e-12, 0.2, 3.9) > 1 - 1e-9);
}

/* Walsh's closed form (1926; as Duntley 1942 gives it), which cancels near n = 1. */
static double walsh(double n)
{
    const double n2 = n * n, n4 = n2 * n2;
    return 0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) +
           n2 * (n2 - 1) * (n2 - 1) / ((n2 + 1) * (n2 + 1) * (n2 + 1)) * log((n - 1) / (n + 1)) -
           2 * n2 * n * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1)) +
           8 * n4 * (n4 + 1) / ((n2 + 1) * (n4 - 1) * (n4 - 1)) * log(n);
}

static double diffuse_by_sum(double eta)
{
    enum { STEPS = 400000 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        const double c = (i + 0.5) / STEPS;
        sum += 2 * c * fresnel_dielectric(c, eta) / STEPS;
    }
    return sum;
}

static void diffuse_averages_equal_closed_form_and_sum(void **state)
{
    (void)state;
    static const double etas[] = {1.2, 1.33, 1.5, 2.4, 7};
    for (size_t e = 0; e < sizeof etas / sizeof *etas; e++) {
        /* the closed form divides by (n^4 - 1)^2, 1.15 at 1.2: some ten roundings */
        assert_near(fresnel_diffuse(etas[e]), walsh(etas[e]), 1e-13);
        /* midpoint sum across the edge of total reflection: error of sqrt type, h^1.5 */
        assert_near(fresnel_diffuse(1 / etas[e]), diffuse_by_sum(1 / etas[e]), 1e-6);
    }
    assert_true(fresnel_diffuse(1) == 0);
    assert_near(fresnel_diffuse(1.0001), diffuse_by_sum(1.0001), 1e-8);
    /* eta = 1 + e: the average goes to zero with e */
    assert_true(fresnel_diffuse(1 + 1e-7) > 0 && fresnel_diffuse(1 + 1e-7) < 1e-6);
    assert_true(fresnel_diffuse(1000) < 1 && fresnel_diffuse(1000) > 0.99);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dielectric_equals_the_textbook_form),
        cmocka_unit_test(dielectric_keeps_relative_precision_as_the_index_is_matched),
        cmocka_unit_test(dielectric_is_the_same_from_both_sides),
        cmocka_unit_test(total_reflection_begins_at_the_critical_angle),
        cmocka_unit_test(conductor_equals_the_complex_form),
        cmocka_unit_test(diffuse_averages_equal_closed_form_and_sum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
