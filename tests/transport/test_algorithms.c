/* Algorithms against each other, by t scores over seeds: pt, mmlt and rjmlt against bdpt, on every scene of the project.
 * Compared are the mean luminances of 4 x 4 blocks of the image and of the whole. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <setjmp.h>
#include <cmocka.h>

#include <gsl/gsl_cdf.h>

#include "load.h"
#include "render.h"

enum { SEEDS = 24, SIDE = 24, BLOCKS = 4, REGIONS = BLOCKS * BLOCKS + 1 };

/* False alarms: 1e-6 in a whole run of 8 scenes, 3 comparisons, 17 regions, two sides. */
static const double alarm = 1e-6 / (8 * 3 * REGIONS * 2);

typedef struct regions {
    double sum[REGIONS], sum2[REGIONS];
} regions_t;

static void add_image(regions_t *regions, const image_t *image)
{
    double means[REGIONS] = {0};
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++) {
            const uint32_t p = y * SIDE + x;
            const double v = rgb_luminance(rgb(image_channel(image, 0)[p], image_channel(image, 1)[p],
                                               image_channel(image, 2)[p]));
            means[y * BLOCKS / SIDE * BLOCKS + x * BLOCKS / SIDE] += v;
            means[REGIONS - 1] += v;
        }
    for (int i = 0; i < REGIONS; i++) {
        regions->sum[i] += means[i];
        regions->sum2[i] += means[i] * means[i];
    }
}

static void run_seeds(const scene_t *scene, const char *algorithm, double work, regions_t *regions)
{
    *regions = (regions_t){0};
    for (int seed = 1; seed <= SEEDS; seed++) {
        char text[512];
        snprintf(text, sizeof text,
                 "{\"scene\":\"x\",\"film\":{\"width\":%d,\"height\":%d},\"algorithm\":\"%s\",\"max_path_length\":6,"
                 "\"seed\":\"%d\",\"stop\":{\"mutations_per_pixel\":%g}}",
                 SIDE, SIDE, algorithm, seed, work);
        render_t render;
        render_run(&render, scene, text);
        add_image(regions, &render.image);
        render_clear(&render);
    }
}

static void compare(const char *name, const char *algorithm, const regions_t *a, const regions_t *b)
{
    const double degrees = SEEDS - 1; /* Welch's are at least so many: the safe side */
    const double most = gsl_cdf_tdist_Qinv(alarm, degrees);
    double worst = 0, whole = 0;
    for (int i = 0; i < REGIONS; i++) {
        const double ma = a->sum[i] / SEEDS, mb = b->sum[i] / SEEDS;
        const double va = (a->sum2[i] / SEEDS - ma * ma) / (SEEDS - 1), vb = (b->sum2[i] / SEEDS - mb * mb) / (SEEDS - 1);
        const double t = (ma - mb) / sqrt(va + vb);
        worst = math_max(worst, fabs(t));
        if (i == REGIONS - 1)
            whole = ma / mb;
        if (!(fabs(t) <= most))
            fail_msg("%s, %s against bdpt: region %d is %g +- %g, expected %g +- %g: t = %.1f", name, algorithm, i, ma,
                     sqrt(va), mb, sqrt(vb), t);
    }
    print_message("%s, %s against bdpt: largest |t| %.2f of %.2f, brightness %.4f\n", name, algorithm, worst, most,
                  whole);
}

static void check(const char *name)
{
    const scene_t *scene = load_scene(name);
    regions_t pt, bdpt, mmlt, rjmlt;
    run_seeds(scene, "bdpt", 24, &bdpt);
    run_seeds(scene, "pt", 64, &pt);
    run_seeds(scene, "mmlt", 200, &mmlt);
    run_seeds(scene, "rjmlt", 200, &rjmlt);
    compare(name, "pt", &pt, &bdpt);
    compare(name, "mmlt", &mmlt, &bdpt);
    compare(name, "rjmlt", &rjmlt, &bdpt);
    load_clear();
}

#define SCENE_TEST(function, name)                                                                                   \
    static void function(void **state)                                                                               \
    {                                                                                                                \
        (void)state;                                                                                                 \
        check(name);                                                                                                 \
    }

SCENE_TEST(diffuse_room, "diffuse")
SCENE_TEST(glossy_room, "glossy")
SCENE_TEST(specular_room, "glass")
SCENE_TEST(sky_and_sun, "environment")
SCENE_TEST(point_and_spot, "delta-lights")
SCENE_TEST(lens_and_filter, "lens")
SCENE_TEST(transmitting_screens, "transmission")
SCENE_TEST(interpolated_normals, "normals")

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(diffuse_room),    cmocka_unit_test(glossy_room),
        cmocka_unit_test(specular_room),   cmocka_unit_test(sky_and_sun),
        cmocka_unit_test(point_and_spot),  cmocka_unit_test(lens_and_filter),
        cmocka_unit_test(transmitting_screens), cmocka_unit_test(interpolated_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
