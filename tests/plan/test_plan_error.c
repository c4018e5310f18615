/* The standard errors of the image against the spread between renders that differ in their seed alone.
 *
 * For each seed r: A_r, the sum over pixels and channels of the estimated variance; D_r, that of the squared
 * distance from the mean image M (times R / (R - 1)); both over M^2 + 0.01 m^2, m its mean, as the error is
 * relative. Both have the same expectation if the estimate is right, so the mean of A_r - D_r is near zero as far
 * as its own spread over the seeds says. |mean| <= 6 standard errors: with 40 seeds (Student, 39 degrees) a false
 * alarm in 5e-7, were the seeds not fixed. The bound must itself be sharp: 6 standard errors of the ratio below
 * 0.4. What the test would catch: 1.21 for passes over the image cut in parts, 1.6 to 9 for a short last unit taken
 * for a whole one.
 *
 * The scene is diffuse: where single paths carry much (caustics) the spread of D_r is too large to say anything.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "plan/plan_fixture.h"

enum { SEEDS = 40, SIDE = 24, NUMBERS = 3 * SIDE * SIDE };

typedef struct render {
    double value[NUMBERS], variance[NUMBERS];
} render_t;

static void render(render_t *out, const small_scene_t *small, const char *algorithm, const char *chains,
                   double per_pixel, int seed)
{
    char text[256];
    snprintf(text, sizeof text,
             "{'scene':'x','algorithm':'%s','chains':{%s},'max_path_length':5,'seed':%d,"
             "'stop':{'mutations_per_pixel':%g}}",
             algorithm, chains, seed, per_pixel);
    const job_t job = plan_fixture_job(text);
    plan_worker_t worker;
    image_t image;
    fault_t fault = {0};
    plan_worker_make(&worker, &job, &small->scene);
    plan_t *plan = plan_fixture_new(&job, &small->scene);
    plan_fixture_run(plan, &worker, 0);
    assert_int_equal(plan_image(plan, &image, &fault), FAULT_NONE);
    const float *errors = image_channel(&image, (uint32_t)image_find(&image, "stderr.R"));
    for (int i = 0; i < NUMBERS; i++) { /* planes R, G, B and stderr.R, .G, .B */
        out->value[i] = (double)image.data[i];
        out->variance[i] = (double)errors[i] * (double)errors[i];
    }
    image_clear(&image);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
}

static void check_errors(const char *algorithm, const char *chains, double per_pixel)
{
    static render_t renders[SEEDS];
    double mean[NUMBERS] = {0}, weight[NUMBERS], level = 0, estimated = 0, spread = 0, sum2 = 0;
    small_scene_t small;
    small_scene_diffuse(&small);
    for (int r = 0; r < SEEDS; r++) {
        render(&renders[r], &small, algorithm, chains, per_pixel, r + 1);
        for (int i = 0; i < NUMBERS; i++)
            mean[i] += renders[r].value[i] / SEEDS;
    }
    small_scene_clear(&small);
    for (int i = 0; i < NUMBERS; i++)
        level += mean[i] / NUMBERS;
    for (int i = 0; i < NUMBERS; i++)
        weight[i] = 1 / (mean[i] * mean[i] + 0.01 * level * level);
    for (int r = 0; r < SEEDS; r++) {
        double distance = 0, variance = 0;
        for (int i = 0; i < NUMBERS; i++) {
            const double d = renders[r].value[i] - mean[i];
            distance += weight[i] * d * d * SEEDS / (SEEDS - 1);
            variance += weight[i] * renders[r].variance[i];
        }
        estimated += variance / SEEDS;
        spread += distance / SEEDS;
        sum2 += (variance - distance) * (variance - distance) / SEEDS;
    }
    const double off = estimated - spread, error = sqrt((sum2 - off * off) / (SEEDS - 1));
    print_message("%s, %g a pixel: estimated variance / variance between seeds = %.3f +- %.3f\n", algorithm,
                  per_pixel, estimated / spread, error / spread);
    assert_true(6 * error < 0.4 * spread);
    if (!(fabs(off) <= 6 * error))
        fail_msg("%s, %g a pixel: estimated variance %g, between seeds %g: %.1f standard errors apart", algorithm,
                 per_pixel, estimated, spread, off / error);
}

static void errors_of_samples_are_right(void **state)
{
    (void)state;
    check_errors("bdpt", "", 20);
    check_errors("bdpt", "", 21.7); /* not whole passes */
    check_errors("pt", "", 16);
}

static void errors_of_chains_are_right(void **state)
{
    (void)state;
    check_errors("mmlt", "", 20);
    check_errors("mmlt", "", 61); /* budgets that units do not divide */
}

/* Shares of whole passes are rounded: the weights of what came of them are not those foreseen. */
static void errors_of_samples_beside_chains_are_right(void **state)
{
    (void)state;
    check_errors("mmlt", "'split':20", 93);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_of_samples_are_right),
        cmocka_unit_test(errors_of_chains_are_right),
        cmocka_unit_test(errors_of_samples_beside_chains_are_right),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
