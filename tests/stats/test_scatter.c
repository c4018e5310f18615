/* How far a render's relMSE scatters, from groups whose law is known: pixels of independent normal errors, 16
 * groups of one unit each. relMSE is then a mean of n squares, its relative variance 2 / n.
 *
 * The variance is measured from 15 draws, so with a relative standard error of sqrt(2 / 14); its mean over 60
 * renders is asserted within 0.25, 5 standard errors: false alarms 6e-7 each, were the seeds not fixed. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/random.h"
#include "stats/scatter.h"
#include "support/near.h"
#include "support/normal.h"

enum { RENDERS = 60 };

static uint64_t counter;

static double uniform(void)
{
    return random_double(random_key(2385, RANDOM_PURPOSE_TEST, 41, 0), counter++);
}

static double normal(void)
{
    const double u = uniform();
    return normal_of(u, uniform());
}

/* One length in `count` groups; `alike` neighbouring spots have the same error, one group's is `loud` times that of
 * the others. */
static scatter_t scatter_of(size_t pixels, uint32_t count, uint32_t alike, double loud)
{
    groups_t groups;
    scatter_t scatter;
    fault_t fault = {0};
    double weights[GROUPS_SPOTS], factor[2] = {0, 1};
    assert_int_equal(groups_init(&groups, 1, pixels, &fault), FAULT_NONE);
    for (uint32_t i = 0; i < groups.spot_count; i++)
        weights[i] = 1;
    for (uint32_t g = 0; g < count; g++) {
        double error = 0;
        groups.counts[GROUPS_COUNT + g] = 1000;
        for (uint32_t i = 0; i < groups.spot_count; i++) {
            error = i % alike == 0 ? normal() * (g == 3 ? loud : 1) : error;
            groups.spots[(size_t)(GROUPS_COUNT + g) * groups.spot_count + i] = (exact_uint_t)(1e6 + 1e4 * error);
        }
    }
    assert_true(scatter_measure(&scatter, &groups, factor, weights, false));
    groups_clear(&groups);
    return scatter;
}

static double mean_variance(size_t pixels, uint32_t count, uint32_t alike)
{
    double sum = 0;
    for (int i = 0; i < RENDERS; i++) {
        const scatter_t scatter = scatter_of(pixels, count, alike, 1);
        sum += scatter.own * scatter.own / RENDERS;
        assert_near(scatter.freedom, count - 1.0, 1e-9);
        assert_near(scatter.estimate, scatter.own / sqrt(count - 1.0), 1e-12);
        assert_true(scatter.dominance < 0.1);
    }
    return sum;
}

static void the_scatter_is_that_of_a_mean_of_squares(void **state)
{
    (void)state;
    assert_near(mean_variance(500, GROUPS_COUNT, 1) * 500, 2, 0.5);
    assert_near(mean_variance(500, GROUPS_COUNT, 5) * 100, 2, 0.5); /* pixels that hang together are fewer */
}

/* Spots of a large image: four in five pixels are not seen, and count as much as those that are. What each pixel
 * adds alone is made less by the ratio; what is left of its noise cannot be below that. */
static void more_pixels_than_spots_scatter_less(void **state)
{
    (void)state;
    const double variance = mean_variance(5 * (size_t)GROUPS_SPOTS, GROUPS_COUNT, 1);
    assert_true(variance > 0.75 * 2 / (5 * GROUPS_SPOTS) && variance < 0.5 * 2 / GROUPS_SPOTS);
}

/* Six groups have five degrees of freedom: the mean over 60 renders has a relative standard error of 0.09. */
static void few_groups_have_few_degrees_of_freedom(void **state)
{
    (void)state;
    assert_near(mean_variance(500, 6, 1) * 500, 2, 0.9);
}

static void a_loud_group_dominates(void **state)
{
    (void)state;
    const double dominance = scatter_of(500, GROUPS_COUNT, 1, 5).dominance;
    assert_near(dominance, 25.0 / 40, 0.1); /* 25 against 15 times one, less what the mean takes */
}

/* Passes that are points of nets: errors of even and of odd groups go together, each sum of eight has a hundredth
 * of the variance that eight independent ones have, but for 0.3 of it. Contrasts that cut them so have other
 * variances than those within: draws of one contrast each scatter by that, draws of all do not. */
static void nets_do_not_scatter_by_what_cuts_them(void **state)
{
    (void)state;
    double mean[2] = {0};
    for (int r = 0; r < RENDERS; r++) {
        groups_t groups;
        fault_t fault = {0};
        double weights[GROUPS_SPOTS];
        static const double factor[2] = {1, 0};
        assert_int_equal(groups_init(&groups, 1, 1000, &fault), FAULT_NONE);
        for (uint32_t i = 0; i < groups.spot_count; i++) {
            double errors[GROUPS_COUNT], sums[2] = {0};
            weights[i] = 1;
            for (int g = 0; g < GROUPS_COUNT; g++)
                sums[g % 2] += errors[g] = normal();
            for (int g = 0; g < GROUPS_COUNT; g++)
                groups.spots[(size_t)g * groups.spot_count + i] =
                    (exact_uint_t)(1e6 + 1e4 * (errors[g] - 0.9 * sums[g % 2] / 8 + 0.5 * normal()));
        }
        for (int g = 0; g < GROUPS_COUNT; g++)
            groups.counts[g] = 1000;
        for (int nets = 0; nets < 2; nets++) {
            scatter_t scatter;
            assert_true(scatter_measure(&scatter, &groups, factor, weights, nets));
            mean[nets] += scatter.own * scatter.own / RENDERS;
        }
        groups_clear(&groups);
    }
    print_message("relative variance of relMSE, times pixels: %.2f by single contrasts, %.2f by all\n",
                  1000 * mean[0], 1000 * mean[1]);
    assert_true(1000 * mean[0] > 20);
    assert_near(1000 * mean[1], 2, 1);
}

static void too_few_groups_tell_nothing(void **state)
{
    (void)state;
    groups_t groups;
    scatter_t scatter;
    fault_t fault = {0};
    static const double weights[GROUPS_SPOTS], factor[2] = {0, 1};
    assert_int_equal(groups_init(&groups, 1, 100, &fault), FAULT_NONE);
    assert_false(scatter_measure(&scatter, &groups, factor, weights, false));
    groups.counts[GROUPS_COUNT] = groups.counts[GROUPS_COUNT + 1] = 1000;
    assert_false(scatter_measure(&scatter, &groups, factor, weights, false));
    groups_clear(&groups);
}

/* Groups of unequal sizes n_g whose sums at a spot have the variance n_g s^2: all together N s^2. Spots that do not
 * count are a thousand times as loud: a lamp beside a shadow. 250 spots that do, 5 or 15 degrees of freedom: a
 * relative standard error of 0.04 or 0.023, asserted within 0.25, more than 6. */
static void a_lengths_part_is_its_variance_where_it_counts(void **state)
{
    (void)state;
    static const uint32_t counts[] = {6, GROUPS_COUNT};
    for (int c = 0; c < 2; c++) {
        groups_t groups;
        fault_t fault = {0};
        double weights[GROUPS_SPOTS], all = 0;
        assert_int_equal(groups_init(&groups, 1, 500, &fault), FAULT_NONE);
        for (uint32_t i = 0; i < groups.spot_count; i++)
            weights[i] = i % 2 ? 0.004 : 0;
        for (uint32_t g = 0; g < counts[c]; g++) {
            const double n = 1000 * (1 + g % 3);
            groups.counts[GROUPS_COUNT + g] = (uint64_t)n;
            all += n;
            for (uint32_t i = 0; i < groups.spot_count; i++)
                groups.spots[(size_t)(GROUPS_COUNT + g) * groups.spot_count + i] =
                    (exact_uint_t)(1e6 * n + (i % 2 ? 1 : 1000) * 1e3 * sqrt(n) * normal());
        }
        assert_near(scatter_part(&groups, 1, 1e-3, weights) / all, 1, 0.25);
        assert_true(scatter_part(&groups, 0, 1e-3, weights) == 0);
        groups_clear(&groups);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_scatter_is_that_of_a_mean_of_squares),
        cmocka_unit_test(more_pixels_than_spots_scatter_less),
        cmocka_unit_test(few_groups_have_few_degrees_of_freedom),
        cmocka_unit_test(a_loud_group_dominates),
        cmocka_unit_test(nets_do_not_scatter_by_what_cuts_them),
        cmocka_unit_test(too_few_groups_tell_nothing),
        cmocka_unit_test(a_lengths_part_is_its_variance_where_it_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
