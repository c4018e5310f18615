/* What renders say of their error against a converged reference: 50 seeds each.
 *
 * relMSE: the mean of the estimates over the mean of the true ones, within 15 % of one for samples. The true one is
 * that against the reference, 50 times as many samples as their renders have, whose own error is 2 % of theirs and
 * 0.3 % of that of chains. The ratio's standard error is
 * printed and must be below 4 %: a ratio of one is then off by 15 % with a probability below 4e-4, were the seeds
 * not fixed. For chains this holds of the variances, weighted by the reference: weights from the render's own image
 * are too small where its noise is correlated and has tails, and their ratio is printed only (docs/transport.md).
 *
 * error.interval holds the render's own relMSE in 43 of 50 renders at least: were it in 95 %, fewer would be with a
 * probability of 4e-3. As wide ones hold anything, it may not be wider than a factor of 1.4 to either side.
 *
 * Regions: the image is cut into 4 x 4; the 95 % interval of each one's mean luminance covers the reference in 93
 * to 97 % of the 800 cases. Were these independent, a true 95 % would be outside of that with a probability of
 * 1e-2.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "plan/plan_estimate.h"
#include "plan/plan_fixture.h"
#include "plan/plan_regions.h"
#include "plan/plan_state.h"

enum { SEEDS = 50, SIDE = 24, PIXELS = SIDE * SIDE, CHANNELS = 3, CUTS = 4, REGIONS = CUTS * CUTS };

typedef struct render {
    double value[CHANNELS][PIXELS], variance[CHANNELS][PIXELS], relmse, low, high;
    bool reliable;
    plan_region_t regions[REGIONS];
    bool has_regions;
} render_t;

static void region_blocks(int region, bool blocks[GROUPS_BLOCKS])
{
    for (int i = 0; i < GROUPS_BLOCKS; i++) {
        const int x = i % GROUPS_SIDE * CUTS / GROUPS_SIDE, y = i / GROUPS_SIDE * CUTS / GROUPS_SIDE;
        blocks[i] = y * CUTS + x == region;
    }
}

static void render(render_t *out, const small_scene_t *small, const char *algorithm, double per_pixel, int seed)
{
    char text[256];
    snprintf(text, sizeof text,
             "{'scene':'x','algorithm':'%s','max_path_length':5,'seed':%d,'stop':{'mutations_per_pixel':%g}}",
             algorithm, seed, per_pixel);
    const job_t job = plan_fixture_job(text);
    plan_worker_t worker;
    image_t image;
    fault_t fault = {0};
    plan_error_t error;
    plan_worker_make(&worker, &job, &small->scene);
    plan_t *plan = plan_fixture_new(&job, &small->scene);
    plan_fixture_run(plan, &worker, 0);
    assert_int_equal(plan_image(plan, &image, &fault), FAULT_NONE);
    for (int i = 0; i < CHANNELS * PIXELS; i++) /* planes R, G, B come first */
        out->value[i / PIXELS][i % PIXELS] = (double)image.data[i];
    const float *errors = image_channel(&image, (uint32_t)image_find(&image, "stderr.R"));
    for (int i = 0; i < CHANNELS * PIXELS; i++)
        out->variance[i / PIXELS][i % PIXELS] = (double)errors[i] * (double)errors[i];
    plan_estimate_error(plan, &error);
    out->relmse = error.relmse;
    out->low = error.low;
    out->high = error.high;
    out->reliable = error.reliable;
    out->has_regions = true;
    for (int i = 0; i < REGIONS; i++) {
        bool blocks[GROUPS_BLOCKS];
        region_blocks(i, blocks);
        out->has_regions &= plan_estimate_region(plan, blocks, &out->regions[i]);
    }
    image_clear(&image);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
}

static double luminance_at(const render_t *of, int p)
{
    return rgb_luminance(rgb(of->value[0][p], of->value[1][p], of->value[2][p]));
}

/* What a render's error is: from the distance to the reference, or from the estimated variances. */
static double relmse_by(const render_t *of, const render_t *reference, bool variances)
{
    double mean = 0, sum = 0;
    for (int p = 0; p < PIXELS; p++)
        mean += luminance_at(reference, p) / PIXELS;
    for (int i = 0; i < CHANNELS * PIXELS; i++) {
        const int c = i / PIXELS, p = i % PIXELS;
        const double r = reference->value[c][p], d = of->value[c][p] - r;
        sum += (variances ? of->variance[c][p] : d * d) / (r * r + 0.01 * mean * mean);
    }
    return sum / (CHANNELS * PIXELS);
}

static double region_mean(const render_t *of, int region)
{
    double sum = 0;
    for (int p = 0; p < PIXELS; p++)
        if (p / SIDE * CUTS / SIDE * CUTS + p % SIDE * CUTS / SIDE == region)
            sum += luminance_at(of, p);
    return sum / (PIXELS / REGIONS);
}

static const double samples = 32;
static render_t reference;

static int make_reference(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_diffuse(&small);
    render(&reference, &small, "bdpt", 50 * samples, 1000);
    small_scene_clear(&small);
    return 0;
}

static void check_calibration(const char *algorithm, double per_pixel)
{
    static render_t renders[SEEDS];
    double estimated = 0, truth = 0, weighted = 0, squares = 0;
    int covered = 0, inside = 0;
    double interval = 0;
    small_scene_t small;
    small_scene_diffuse(&small);
    for (int r = 0; r < SEEDS; r++) {
        render(&renders[r], &small, algorithm, per_pixel, r + 1);
        assert_true(renders[r].has_regions);
        estimated += renders[r].relmse / SEEDS;
        const double own = relmse_by(&renders[r], &reference, false);
        inside += renders[r].low <= own && own <= renders[r].high;
        interval += 0.5 * log(renders[r].high / renders[r].low) / SEEDS;
        assert_true(renders[r].reliable);
        truth += own / SEEDS;
        weighted += relmse_by(&renders[r], &reference, true) / SEEDS;
        for (int i = 0; i < REGIONS; i++) {
            const double mean = region_mean(&reference, i);
            covered += renders[r].regions[i].low <= mean && mean <= renders[r].regions[i].high;
        }
    }
    small_scene_clear(&small);
    const double ratio = truth / estimated, coverage = (double)covered / (SEEDS * REGIONS);
    for (int r = 0; r < SEEDS; r++) {
        const double d = relmse_by(&renders[r], &reference, false) - ratio * renders[r].relmse;
        squares += d * d;
    }
    const double error = sqrt(squares / (SEEDS * (SEEDS - 1.0))) / estimated;
    print_message(
        "%s, %g a pixel: relMSE estimated %.5f, true %.5f, ratio %.3f +- %.3f, by the variances alone %.3f; "
        "regions covered %.3f; own relMSE inside of the interval %d of %d times, which is x %.3f\n",
        algorithm, per_pixel, estimated, truth, ratio, error, truth / weighted, coverage, inside, SEEDS,
        exp(interval));
    assert_true(error < 0.04);
    assert_true(fabs(ratio - 1) < 0.15);
    assert_true(fabs(truth / weighted - 1) < 0.15);
    assert_true(coverage >= 0.93 && coverage <= 0.97);
    assert_true(inside >= 43 && exp(interval) < 1.4);
}

static void samples_are_calibrated(void **state)
{
    (void)state;
    check_calibration("bdpt", samples);
}

static void chains_are_calibrated(void **state)
{
    (void)state;
    check_calibration("mmlt", 400);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_calibrated),
        cmocka_unit_test(chains_are_calibrated),
    };
    return cmocka_run_group_tests(tests, make_reference, NULL);
}
