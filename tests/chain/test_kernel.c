/* Perturbations on the torus: their laws, their symmetry, their ends. False alarms: 1e-6 for each of the
 * Kolmogorov-Smirnov and binomial comparisons, were the seed not fixed. */
#include "chain/kernel.h"
#include "math/sampling.h"
#include "support/near.h"

enum { COUNT = 40000 };
static double from[COUNT], to[COUNT], values[COUNT];

static kernel_t kernel_make(settings_kernel_t kind, double step_min, double step_max)
{
    settings_t settings;
    settings_default(&settings);
    settings.kernel = kind;
    settings.step_min = step_min;
    settings.step_max = step_max;
    return kernel_of(&settings);
}

/* The step on the torus, in [-1/2, 1/2). */
static double step_between(double a, double b)
{
    const double d = b - a;
    return d - floor(d + 0.5);
}

static void perturb_from(const kernel_t *kernel, double u, uint64_t key)
{
    for (int i = 0; i < COUNT; i++)
        from[i] = u;
    kernel_perturb(kernel, key, 0, from, to, COUNT);
}

static const double kelemen_steps[][2] = {{1.0 / 1024, 1.0 / 64}, {1e-9, 0.25}, {0.1, 0.5}, {1e-6, 1e-5}};
enum { KELEMEN_STEPS = sizeof kelemen_steps / sizeof *kelemen_steps };

/* r = log(|du| / s1) / log(s2 / s1) is uniform: densities proportional to 1 / |du|. For either sign by itself. */
static void kelemen_steps_are_log_uniform(void **state)
{
    (void)state;
    for (int k = 0; k < KELEMEN_STEPS; k++) {
        const double s1 = kelemen_steps[k][0], s2 = kelemen_steps[k][1];
        const kernel_t kernel = kernel_make(SETTINGS_KERNEL_KELEMEN, s1, s2);
        perturb_from(&kernel, 0.5, 100 + (uint64_t)k);
        for (int sign = -1; sign <= 1; sign += 2) {
            size_t n = 0;
            for (int i = 0; i < COUNT; i++) {
                const double step = (to[i] - 0.5) * sign;
                if (!(step > 0))
                    continue;
                /* 3e-6: the power's stated error; 1e-16 / s1: that of 0.5 + s1 */
                const double r = log(step / s1) / log(s2 / s1), off = 4e-6 / log(s2 / s1) + 1e-16 / s1;
                if (!(r >= -off && r <= 1 + off))
                    fail_msg("step %g is not within %g and %g", step, s1, s2);
                values[n++] = fmin(fmax(r, 0), MATH_ONE_MINUS);
            }
            assert_uniform("log of the step", values, n);
        }
    }
}

static void signs_are_symmetric(void **state)
{
    (void)state;
    const kernel_t kernels[] = {kernel_make(SETTINGS_KERNEL_KELEMEN, 1.0 / 1024, 1.0 / 64),
                                kernel_make(SETTINGS_KERNEL_GAUSSIAN, 0.01, 0.01)};
    for (int k = 0; k < 2; k++) {
        perturb_from(&kernels[k], 0.5, 200);
        int above = 0;
        for (int i = 0; i < COUNT; i++) {
            assert_true(to[i] != 0.5);
            above += to[i] > 0.5;
        }
        /* 4.9 standard deviations: 1e-6 */
        assert_near(above, COUNT / 2.0, 4.9 * sqrt(COUNT / 4.0));
    }
}

/* With one step size there is one length, in both directions. */
static void equal_ends_make_equal_steps(void **state)
{
    (void)state;
    const kernel_t kernel = kernel_make(SETTINGS_KERNEL_KELEMEN, 0.03, 0.03);
    perturb_from(&kernel, 0.5, 210);
    for (int i = 0; i < COUNT; i++)
        assert_near(fabs(to[i] - 0.5), 0.03, 0.03 * 4e-6);
}

static void gaussian_steps_are_normal(void **state)
{
    (void)state;
    static const double sigmas[] = {1e-6, 0.02, 0.06};
    for (int k = 0; k < 3; k++) {
        const kernel_t kernel = kernel_make(SETTINGS_KERNEL_GAUSSIAN, sigmas[k], sigmas[k]);
        perturb_from(&kernel, 0.5, 300 + (uint64_t)k);
        double sum2 = 0;
        for (int i = 0; i < COUNT; i++) {
            const double x = (to[i] - 0.5) / sigmas[k]; /* beyond 7 sigma there is nothing: 0.06 does not wrap */
            sum2 += x * x;
            values[i] = fmin(gsl_cdf_ugaussian_P(x), MATH_ONE_MINUS);
        }
        assert_uniform("normal law", values, COUNT);
        /* a second way: the sum of squares is chi-square; both tails */
        const double p = gsl_cdf_chisq_P(sum2, COUNT);
        assert_true(p > SAMPLING_ALARM / 2 && p < 1 - SAMPLING_ALARM / 2);
    }
}

/* Where one stands does not matter: on the torus the step is the same from anywhere, the ends included. That and
 * the sign's symmetry are the kernel's symmetry. */
static void steps_do_not_depend_on_the_place(void **state)
{
    (void)state;
    static const double places[] = {0, 0x1p-1074, 1e-300, 1e-17, 1e-9, 0.25, 0.75, 1 - 1e-9, MATH_ONE_MINUS};
    static double middle[COUNT];
    for (int kind = 0; kind < 2; kind++)
        for (int k = 0; k < KELEMEN_STEPS; k++) {
            const kernel_t kernel = kernel_make(kind ? SETTINGS_KERNEL_GAUSSIAN : SETTINGS_KERNEL_KELEMEN,
                                                kelemen_steps[k][0], kelemen_steps[k][1]);
            perturb_from(&kernel, 0.5, 400);
            for (int i = 0; i < COUNT; i++)
                middle[i] = step_between(0.5, to[i]);
            for (size_t p = 0; p < sizeof places / sizeof *places; p++) {
                perturb_from(&kernel, places[p], 400);
                for (int i = 0; i < COUNT; i++) {
                    assert_unit_interval(to[i]);
                    /* three roundings of numbers below 2 */
                    assert_near(step_between(middle[i], step_between(places[p], to[i])), 0, 5e-16);
                }
            }
        }
}

static void uniform_numbers_stay_uniform(void **state)
{
    (void)state;
    const kernel_t kernels[] = {kernel_make(SETTINGS_KERNEL_KELEMEN, 1.0 / 1024, 1.0 / 64),
                                kernel_make(SETTINGS_KERNEL_KELEMEN, 0.1, 0.5),
                                kernel_make(SETTINGS_KERNEL_GAUSSIAN, 0.1, 0.1)};
    for (int k = 0; k < 3; k++) {
        kernel_draw(500, 0, from, COUNT);
        for (int step = 0; step < 100; step++) {
            kernel_perturb(&kernels[k], random_step(501, (uint64_t)step), 0, from, to, COUNT);
            for (int i = 0; i < COUNT; i++)
                from[i] = to[i];
        }
        assert_uniform("after 100 steps", from, COUNT);
    }
}

/* A number that starts at one place spreads over all of the torus: the chain is ergodic. */
static void any_start_is_forgotten(void **state)
{
    (void)state;
    const kernel_t kernel = kernel_make(SETTINGS_KERNEL_KELEMEN, 0.01, 0.25);
    for (int i = 0; i < COUNT; i++)
        from[i] = MATH_ONE_MINUS;
    /* variance a step: (s2^2 - s1^2) / (2 ln(s2 / s1)) = 0.0097, so the first Fourier coefficient shrinks by at
     * least 0.85 a step: after 200 steps nothing of it is left */
    for (int step = 0; step < 200; step++) {
        kernel_perturb(&kernel, random_step(600, (uint64_t)step), 0, from, to, COUNT);
        for (int i = 0; i < COUNT; i++)
            from[i] = to[i];
    }
    assert_uniform("from the upper end", from, COUNT);
}

static void numbers_depend_on_key_and_index_alone(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        const kernel_t kernel = kernel_make(kind ? SETTINGS_KERNEL_GAUSSIAN : SETTINGS_KERNEL_KELEMEN, 0.001, 0.1);
        kernel_draw(700, 0, from, 64);
        kernel_perturb(&kernel, 701, 5, from, to, 64);
        for (uint32_t at = 0; at < 64; at++) {
            double alone, drawn;
            kernel_perturb(&kernel, 701, 5 + at, &from[at], &alone, 1);
            assert_true(alone == to[at]);
            kernel_draw(700, at, &drawn, 1);
            assert_true(drawn == from[at]);
        }
        double other[64];
        int same = 0;
        kernel_perturb(&kernel, 702, 5, from, other, 64);
        for (int i = 0; i < 64; i++)
            same += other[i] == to[i];
        assert_int_equal(same, 0);
        kernel_perturb(&kernel, 701, 5, from, from, 64); /* in place */
        assert_memory_equal(from, to, sizeof other);
    }
}

/* The ratio of two steps' densities against their laws: 1 / (2 d log(s2 / s1)) and the normal law wrapped round. */
static void ratios_are_those_of_the_densities(void **state)
{
    (void)state;
    const kernel_t kelemen = kernel_make(SETTINGS_KERNEL_KELEMEN, 1.0 / 1024, 1.0 / 64);
    const double via[3] = {0.5, 0.001, 0.3}, a[3] = {0.51, 0.999, 0.298}, b[3] = {0.505, 0.9905, 0.302};
    /* distances 0.01, 0.002, 0.002 from a; 0.005, 0.0105, 0.002 from b; the second over the torus's edge */
    assert_near(kernel_log_ratio(&kelemen, a, via, b, 3), log(0.01 / 0.005) + log(0.002 / 0.0105), 1e-12);
    const double far[3] = {0.52, 0.999, 0.298}, close[3] = {0.5005, 0.999, 0.298};
    assert_true(kernel_log_ratio(&kelemen, a, via, far, 3) == -HUGE_VAL);
    assert_true(kernel_log_ratio(&kelemen, a, via, close, 3) == -HUGE_VAL);
    for (int i = 0; i < 2; i++) {
        const double sigma = i ? 0.4 : 0.02;
        const kernel_t gaussian = kernel_make(SETTINGS_KERNEL_GAUSSIAN, 1e-3, sigma);
        double density[2] = {0, 0};
        for (int turns = -8; turns <= 8; turns++) {
            density[0] += exp(-0.5 * pow((0.002 + turns) / sigma, 2));
            density[1] += exp(-0.5 * pow((0.0105 + turns) / sigma, 2));
        }
        assert_near(kernel_log_ratio(&gaussian, a + 1, via + 1, b + 1, 1), log(density[1] / density[0]), 1e-12);
    }
    const kernel_t shorter = kernel_scaled(&kelemen, 0.25);
    perturb_from(&shorter, 0.5, 77);
    for (int i = 0; i < COUNT; i++)
        assert_true(fabs(to[i] - 0.5) < 0.25 / 64 * (1 + 1e-5) && fabs(to[i] - 0.5) > 0.25 / 1024 * (1 - 1e-5));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kelemen_steps_are_log_uniform),
        cmocka_unit_test(signs_are_symmetric),
        cmocka_unit_test(equal_ends_make_equal_steps),
        cmocka_unit_test(gaussian_steps_are_normal),
        cmocka_unit_test(steps_do_not_depend_on_the_place),
        cmocka_unit_test(uniform_numbers_stay_uniform),
        cmocka_unit_test(any_start_is_forgotten),
        cmocka_unit_test(numbers_depend_on_key_and_index_alone),
        cmocka_unit_test(ratios_are_those_of_the_densities),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
