#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

#include "base/random.h"

/* Every statistical assertion below fails a sound generator with this probability; seeds are fixed, so that it
 * either always passes or always fails. */
static const double false_alarm = 1e-7;

enum { SEED = 20240229 };

/* Both tails: too even is as suspicious as too uneven. */
static void assert_uniform(const char *what, const uint32_t *counts, int bins, double expected)
{
    double chi2 = 0;
    for (int i = 0; i < bins; i++)
        chi2 += (counts[i] - expected) * (counts[i] - expected) / expected;
    const double upper = gsl_cdf_chisq_Q(chi2, bins - 1), lower = gsl_cdf_chisq_P(chi2, bins - 1);
    if (!(upper > false_alarm / 2 && lower > false_alarm / 2))
        fail_msg("%s: chi-square %.1f with %d degrees of freedom", what, chi2, bins - 1);
}

/* The sum of n products of independent pairs, each factor uniform on [-1/2,1/2), has variance n/144. */
static void assert_uncorrelated(const char *what, double sum, double n)
{
    const double z = fabs(sum) / sqrt(n / 144);
    if (!(2 * gsl_cdf_ugaussian_Q(z) > false_alarm))
        fail_msg("%s: %.2f standard deviations", what, z);
}

/* The five outputs from the state 1234567 that are commonly given for Vigna's public-domain splitmix64.c, and an
 * independent transcription of the algorithm with its state kept by addition. */
static uint64_t reference_next(uint64_t *state)
{
    uint64_t z = (*state += 0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
}

static void the_stream_is_splitmix64(void **state)
{
    (void)state;
    static const uint64_t known[5] = {UINT64_C(6457827717110365317), UINT64_C(3203168211198807973),
                                      UINT64_C(9817491932198370423), UINT64_C(4593380528125082431),
                                      UINT64_C(16408922859458223821)};
    uint64_t sequential = 1234567;
    for (uint64_t i = 0; i < 5; i++)
        assert_int_equal(random_u64(1234567, i), known[i]);
    for (uint64_t i = 0; i < 1000; i++)
        assert_int_equal(random_u64(1234567, i), reference_next(&sequential));
}

static void doubles_lie_in_the_half_open_interval(void **state)
{
    (void)state;
    assert_true(random_double_of(0) == 0.0);
    assert_true(random_double_of(UINT64_MAX) == 0x1.fffffffffffffp-1);
    assert_true(random_double_of(UINT64_C(1) << 11) == 0x1p-53);
    assert_true(random_double_of((UINT64_C(1) << 11) - 1) == 0.0);
}

/* Along the dimensions of one step, along steps, along chains: each a stream that must be uniform. */
static double draw(int axis, uint64_t i)
{
    const uint64_t index = axis == 3 ? i : 7, length = axis == 4 ? i : 5;
    const uint64_t key = random_key(axis == 5 ? i : SEED, RANDOM_PURPOSE_TEST, length, index);
    if (axis == 0)
        return random_double(key, i);
    if (axis == 1)
        return random_double(random_step(key, i), 0);
    if (axis == 2)
        return random_double(random_step(key, i >> 4), i & 15);
    return random_double(key, 0);
}

static const char *const axes[] = {"dimensions", "steps", "steps and dimensions", "chains", "lengths", "seeds"};
enum { AXES = 6, DRAWS = 1 << 18, BINS = 1024 };

static void every_axis_is_uniform(void **state)
{
    (void)state;
    for (int axis = 0; axis < AXES; axis++) {
        uint32_t counts[BINS] = {0};
        for (uint64_t i = 0; i < DRAWS; i++) {
            const double u = draw(axis, i);
            assert_true(u >= 0 && u < 1);
            counts[(int)(u * BINS)]++;
        }
        assert_uniform(axes[axis], counts, BINS, (double)DRAWS / BINS);
    }
}

static void neighbours_are_independent(void **state)
{
    (void)state;
    enum { SIDE = 32 };
    for (int axis = 0; axis < AXES; axis++) {
        for (uint64_t lag = 1; lag <= 16; lag *= 2) {
            uint32_t counts[SIDE * SIDE] = {0};
            double sum = 0;
            /* Disjoint pairs, so that the counts are multinomial. */
            for (uint64_t block = 0; block < DRAWS; block += 2 * lag)
                for (uint64_t i = block; i < block + lag; i++) {
                    const double u = draw(axis, i), v = draw(axis, i + lag);
                    counts[(int)(u * SIDE) * SIDE + (int)(v * SIDE)]++;
                    sum += (u - 0.5) * (v - 0.5);
                }
            assert_uniform(axes[axis], counts, SIDE * SIDE, DRAWS / 2.0 / (SIDE * SIDE));
            assert_uncorrelated(axes[axis], sum, DRAWS / 2.0);
        }
    }
}

/* One flipped bit of any argument flips each bit of the result with probability 1/2 (an avalanche): over n trials
 * of 64 bits the number of flips is binomial(64 n, 1/2). */
static void one_bit_of_any_argument_changes_half_of_the_key(void **state)
{
    (void)state;
    enum { TRIALS = 4096 };
    for (int argument = 0; argument < 4; argument++) {
        for (int bit = 0; bit < (argument == 1 ? 16 : 32); bit++) {
            uint64_t flips = 0;
            for (uint64_t i = 0; i < TRIALS; i++) {
                const uint64_t flip = UINT64_C(1) << bit;
                const uint64_t a[4] = {i, i & 1023, i * 31, i * 17};
                uint64_t b[4] = {a[0], a[1], a[2], a[3]};
                b[argument] ^= flip;
                flips += (uint64_t)__builtin_popcountll(
                    random_step(random_key(a[0], RANDOM_PURPOSE_TEST, a[1], a[2]), a[3]) ^
                    random_step(random_key(b[0], RANDOM_PURPOSE_TEST, b[1], b[2]), b[3]));
            }
            const double z = ((double)flips - 32.0 * TRIALS) / sqrt(16.0 * TRIALS);
            if (!(2 * gsl_cdf_ugaussian_Q(fabs(z)) > false_alarm))
                fail_msg("argument %d, bit %d: %.2f standard deviations", argument, bit, z);
        }
    }
}

static void purposes_and_lengths_are_kept_apart(void **state)
{
    (void)state;
    for (int a = RANDOM_PURPOSE_PILOT; a <= RANDOM_PURPOSE_TEST; a++)
        for (int b = RANDOM_PURPOSE_PILOT; b <= RANDOM_PURPOSE_TEST; b++)
            for (uint64_t length = 0; length < 64; length++)
                if (a != b || length != 9)
                    assert_true(random_key(SEED, (random_purpose_t)a, length, 3) !=
                                random_key(SEED, (random_purpose_t)b, 9, 3));
}

static int compare_u64(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Streams that overlapped would repeat each other's numbers. Of 2^17 independent numbers of 64 bits, two agree with
 * probability 2^-31. */
static void neighbouring_streams_share_no_number(void **state)
{
    (void)state;
    enum { LENGTHS = 2, CHAINS = 16, STEPS = 64, DIMENSIONS = 64, COUNT = LENGTHS * CHAINS * STEPS * DIMENSIONS };
    uint64_t *numbers = malloc(COUNT * sizeof *numbers);
    for (uint64_t i = 0; i < COUNT; i++) {
        const uint64_t stream = i / (STEPS * DIMENSIONS);
        const uint64_t key = random_key(SEED, RANDOM_PURPOSE_TEST, stream % LENGTHS, stream / LENGTHS);
        numbers[i] = random_u64(random_step(key, i / DIMENSIONS % STEPS), i % DIMENSIONS);
    }
    qsort(numbers, COUNT, sizeof *numbers, compare_u64);
    for (size_t i = 1; i < COUNT; i++)
        assert_true(numbers[i] != numbers[i - 1]);
    free(numbers);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_stream_is_splitmix64),
        cmocka_unit_test(doubles_lie_in_the_half_open_interval),
        cmocka_unit_test(every_axis_is_uniform),
        cmocka_unit_test(neighbours_are_independent),
        cmocka_unit_test(one_bit_of_any_argument_changes_half_of_the_key),
        cmocka_unit_test(purposes_and_lengths_are_kept_apart),
        cmocka_unit_test(neighbouring_streams_share_no_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
