/* The closed furnace: albedo rho and emission L on every wall give the radiance L / (1 - rho) everywhere, of which
 * paths of length k carry L rho^(k-1). For every algorithm and length up to 50: b_k against its closed form within
 * its own standard error, and the image. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <setjmp.h>
#include <cmocka.h>

#include "load.h"
#include "render.h"

static const double rho = 0.8, emission = 1;
enum { LENGTHS = 50, SIDE = 8 };

/* Largest |z| of so many estimates: false alarm 1e-6 in all (Bonferroni: 2 * 51 * Q(z) with z = 5.8 is 7e-7).
 * Estimates' own standard errors have some noise: 10 % is allowed for. */
static const double z_most = 5.8 * 1.1;

static void check(const char *algorithm, double mutations_per_pixel)
{
    char text[512];
    snprintf(
        text, sizeof text,
        "{\"scene\":\"furnace\",\"algorithm\":\"%s\",\"max_path_length\":%d,\"stop\":{\"mutations_per_pixel\":%g}}",
        algorithm, LENGTHS, mutations_per_pixel);
    render_t render;
    render_run(&render, load_scene("furnace"), text);
    double expected = 0;
    for (int k = 1; k <= LENGTHS; k++) {
        const double want = SIDE * SIDE * emission * pow(rho, k - 1);
        const render_estimate_t b = render_length(&render, (uint32_t)k);
        expected += want;
        if (!(fabs(b.value - want) <= z_most * b.error + 1e-9 * want))
            fail_msg("%s: b_%d = %g +- %g, expected %g", algorithm, k, b.value, b.error, want);
    }
    double mean = 0, variance = 0;
    const float *r = image_channel(&render.image, 0), *e = image_channel(&render.image, 3);
    for (int p = 0; p < SIDE * SIDE; p++) {
        mean += r[p] / (SIDE * SIDE);
        variance += (double)e[p] * e[p];
        const double want = expected / (SIDE * SIDE);
        if (!(fabs(r[p] - want) <=
              z_most * 1.3 * e[p] + 1e-6 * want)) /* 16 units or more estimate each pixel's error */
            fail_msg("%s: pixel %d is %g +- %g, expected %g", algorithm, p, r[p], e[p], want);
    }
    print_message("%s: mean %.6f, expected %.6f\n", algorithm, mean, expected / (SIDE * SIDE));
    assert_true(fabs(mean - expected / (SIDE * SIDE)) <= z_most * sqrt(variance) / SIDE / SIDE + 1e-9);
    render_clear(&render);
    load_clear();
}

static void path_tracing(void **state)
{
    (void)state;
    check("pt", 2000);
}

static void bidirectional(void **state)
{
    (void)state;
    check("bdpt", 60);
}

static void multiplexed_chains(void **state)
{
    (void)state;
    check("mmlt", 20000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(path_tracing),
        cmocka_unit_test(bidirectional),
        cmocka_unit_test(multiplexed_chains),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
