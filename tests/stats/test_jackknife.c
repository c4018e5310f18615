/* Weights without the noise's share in them, on groups whose law is known: pixels of 1 and of 0.1 side by side,
 * which a group sees as the mean of `events` exponentially distributed values: skewed, so that bright errors come
 * with large squares, as paths do it. Of 16 groups the image has a relative variance of 1 / (16 events).
 *
 * Means over 60 renders of 2000 pixels. The ratio of one scatters by some 0.04, so the mean has a standard error of
 * about 0.005; what is asserted of it has 0.03 on either side: false alarms below 1e-6 each but for the higher
 * orders, were the seed not fixed. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/random.h"
#include "stats/jackknife.h"
#include "support/near.h"

enum { RENDERS = 60, PIXELS = 2000 };

static const double unit = 1e-9; /* of the groups' sums */
static uint64_t counter;

static double exponential(void)
{
    return -log1p(-random_double(random_key(2385, RANDOM_PURPOSE_TEST, 43, 0), counter++));
}

static double light_of(uint32_t i)
{
    return i % 2 ? 0.1 : 1;
}

/* Groups of one length, sizes of one to three units if they are `uneven`; a unit is the mean of `events` values.
 * The image is the sum over groups, over the number of units: factor[1]. */
static void fill(groups_t *groups, int events, bool uneven, double factor[2])
{
    fault_t fault = {0};
    double units = 0;
    assert_int_equal(groups_init(groups, 1, PIXELS, &fault), FAULT_NONE);
    for (uint32_t g = 0; g < GROUPS_COUNT; g++) {
        const int size = uneven ? 1 + (int)(g % 3) : 1;
        groups->counts[GROUPS_COUNT + g] = 1000 * (uint64_t)size;
        units += size;
        for (uint32_t i = 0; i < PIXELS; i++) {
            double sum = 0;
            for (int e = 0; e < events * size; e++)
                sum += exponential() / events;
            groups->spots[(size_t)(GROUPS_COUNT + g) * PIXELS + i] = (exact_uint_t)(sum * light_of(i) / unit);
        }
    }
    factor[0] = 0;
    factor[1] = unit / units;
}

static double weight_of(double value)
{
    return 1 / (value * value + 0.01 * 0.55 * 0.55) / PIXELS;
}

/* Weights at hand: right ones; or those of the image itself; or right ones with those of dark pixels halved. */
typedef enum hand { RIGHT, OWN, HALVED } hand_t;

static void weigh(const groups_t *groups, double factor, hand_t hand, double weights[GROUPS_SPOTS])
{
    for (uint32_t i = 0; i < PIXELS; i++) {
        double value = 0;
        for (uint32_t g = 0; g < GROUPS_COUNT; g++)
            value += factor * (double)groups->spots[(size_t)(GROUPS_COUNT + g) * PIXELS + i];
        weights[i] = weight_of(hand == OWN ? value : light_of(i)) * (hand == HALVED && i % 2 ? 0.5 : 1);
    }
}

/* Mean ratio over renders, its standard error by their spread and as it is told. */
typedef struct figures {
    double ratio, scatter, told, room;
} figures_t;

static figures_t measure(int events, bool uneven, hand_t hand, double prior)
{
    figures_t out = {0};
    double squares = 0;
    for (int r = 0; r < RENDERS; r++) {
        groups_t groups;
        jackknife_t found;
        double factor[2], weights[GROUPS_SPOTS];
        fill(&groups, events, uneven, factor);
        weigh(&groups, factor[1], hand, weights);
        assert_true(jackknife_measure(&found, &groups, factor, factor, 0.01 * 0.55 * 0.55, weights, prior));
        groups_clear(&groups);
        out.ratio += found.ratio / RENDERS;
        squares += found.ratio * found.ratio / RENDERS;
        out.told += found.error * found.error / RENDERS;
        out.room += found.room / RENDERS;
    }
    out.scatter = sqrt((squares - out.ratio * out.ratio) * RENDERS / (RENDERS - 1));
    out.told = sqrt(out.told);
    print_message("%d events, weights %d: ratio %.4f +- %.4f (told %.4f), room %.4f\n", events, hand, out.ratio,
                  out.scatter, out.told, out.room);
    return out;
}

/* The error that is told is that of the squares; the noise that all pairs' weights have in common is not in it. */
static void right_weights_are_left_as_they_are(void **state)
{
    (void)state;
    for (int uneven = 0; uneven < 2; uneven++) {
        const figures_t found = measure(3, uneven, RIGHT, 10);
        assert_near(found.ratio, 1, 0.03);
        assert_true(found.told > 0.5 * found.scatter && found.told < 1.4 * found.scatter);
        assert_true(found.room >= 0 && found.room < 0.1);
    }
}

/* Those of the noisy image are too small where its errors are: by as much as they are found to be. What they are
 * too small by is known from right ones, of the same renders. */
static void weights_of_the_image_itself_are_made_right(void **state)
{
    (void)state;
    const uint64_t begin = counter;
    double right = 0, own = 0;
    for (int r = 0; r < RENDERS; r++) {
        groups_t groups;
        double factor[2], weights[GROUPS_SPOTS];
        fill(&groups, 1, false, factor);
        weigh(&groups, factor[1], OWN, weights);
        for (uint32_t i = 0; i < PIXELS; i++)
            for (uint32_t g = 0; g < GROUPS_COUNT; g++) {
                const double light =
                    (double)groups.spots[(size_t)(GROUPS_COUNT + g) * PIXELS + i] * unit - light_of(i);
                own += weights[i] * light * light;
                right += weight_of(light_of(i)) * light * light;
            }
        groups_clear(&groups);
    }
    print_message("right over own weights: %.4f\n", right / own);
    assert_true(right / own > 1.05);
    counter = begin;
    assert_near(measure(1, false, OWN, 10).ratio, right / own, 0.03);
}

/* Half of the squared error is that of dark pixels, nearly: 0.01 / 0.01303 of 1 against 1 of 1.00303. */
static void weights_that_are_wrong_are_found_to_be(void **state)
{
    (void)state;
    const double dark = 0.01 / (0.01 + 0.003025), bright = 1 / (1 + 0.003025);
    assert_near(measure(3, false, HALVED, 10).ratio, (dark + bright) / (0.5 * dark + bright), 0.04);
}

/* What is known beforehand counts for as much as it is sure. */
static void a_prior_is_weighed_against_the_groups(void **state)
{
    (void)state;
    const uint64_t begin = counter;
    const figures_t free_of_it = measure(3, false, HALVED, 10);
    counter = begin;
    const figures_t bound = measure(3, false, HALVED, 1e-6);
    assert_near(bound.ratio, 1, 1e-6);
    assert_near(bound.told, 1e-6, 1e-7);
    counter = begin;
    const figures_t between = measure(3, false, HALVED, free_of_it.told);
    assert_near(between.ratio - 1, 0.5 * (free_of_it.ratio - 1), 0.1);
    assert_near(between.told, free_of_it.told * M_SQRT1_2, 0.2 * free_of_it.told);
}

static void where_little_is_known_the_ratio_is_one(void **state)
{
    (void)state;
    groups_t groups;
    jackknife_t found;
    double factor[2], weights[GROUPS_SPOTS];
    fill(&groups, 3, false, factor);
    weigh(&groups, factor[1], HALVED, weights);
    groups.counts[GROUPS_COUNT + 5] = 0; /* a group without units */
    assert_false(jackknife_measure(&found, &groups, factor, factor, 0.01 * 0.55 * 0.55, weights, 0.25));
    assert_true(found.ratio == 1 && found.error == 0 && found.room == 0);
    groups.counts[GROUPS_COUNT + 5] = 1000;
    for (uint32_t i = 0; i < PIXELS; i++) /* and light of a single one: the others' image is another one */
        for (uint32_t g = 1; g < GROUPS_COUNT; g++)
            groups.spots[(size_t)(GROUPS_COUNT + g) * PIXELS + i] /= 1000;
    assert_false(jackknife_measure(&found, &groups, factor, factor, 0.01 * 0.55 * 0.55, weights, 0.25));
    assert_true(found.ratio == 1 && found.error == 0 && found.room == 0);
    groups_clear(&groups);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(right_weights_are_left_as_they_are),
        cmocka_unit_test(weights_of_the_image_itself_are_made_right),
        cmocka_unit_test(weights_that_are_wrong_are_found_to_be),
        cmocka_unit_test(a_prior_is_weighed_against_the_groups),
        cmocka_unit_test(where_little_is_known_the_ratio_is_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
