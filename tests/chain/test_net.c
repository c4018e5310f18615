/* Points of nets: one in every interval and rectangle, uniform each by itself, of an order of their own in each
 * number; and what their mean's variance is. Statistical bounds: a fixed seed, false alarms below 1e-6 a
 * comparison.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "chain/net.h"
#include "support/near.h"

enum { SEED = 7 };

/* The point's numbers, `draw` being that of the first one. */
static double place_one(uint64_t pixel, uint64_t index, uint64_t draw)
{
    const net_t net = net_at(SEED, 0, pixel, index);
    double u = random_double(random_key(SEED, RANDOM_PURPOSE_TEST, index, pixel), draw);
    net_place_one(&net, draw, &u);
    assert_true(u >= 0 && u < 1);
    return u;
}

static void place_pair(uint64_t pixel, uint64_t index, uint64_t draw, double u[2])
{
    const net_t net = net_at(SEED, 0, pixel, index);
    const uint64_t key = random_key(SEED, RANDOM_PURPOSE_TEST, index, pixel);
    u[0] = random_double(key, draw);
    u[1] = random_double(key, draw + 1);
    net_place_pair(&net, draw, u);
    assert_true(u[0] >= 0 && u[0] < 1 && u[1] >= 0 && u[1] < 1);
}

static void coordinates_are_sobol_s(void **state)
{
    (void)state;
    for (uint32_t j = 0; j < NET_POINTS; j++) {
        uint32_t first = 0, second = 0, column = NET_POINTS / 2; /* columns of Pascal's triangle modulo 2 */
        for (uint32_t i = 0; i < NET_DIGITS; i++, column ^= column >> 1) {
            first |= (j >> i & 1) << (NET_DIGITS - 1 - i);
            second ^= j >> i & 1 ? column : 0;
        }
        assert_int_equal(net_first[j], first);
        assert_int_equal(net_second[j], second);
    }
}

/* Any 2^m points from a multiple of 2^m on. */
static void every_interval_has_one_point(void **state)
{
    (void)state;
    for (uint64_t pixel = 0; pixel < 50; pixel++)
        for (uint32_t m = 0; m <= NET_DIGITS; m++)
            for (uint64_t begin = 0; begin < 3 * NET_POINTS; begin += 1 << m) {
                uint64_t one = 0, pairs[NET_DIGITS + 1] = {0};
                for (uint64_t i = begin; i < begin + (1 << m); i++) {
                    double u[2];
                    one |= UINT64_C(1) << (int)(place_one(pixel, i, 5) * (1 << m));
                    place_pair(pixel, i, 17, u);
                    for (uint32_t a = 0; a <= m; a++)
                        pairs[a] |= UINT64_C(1)
                                    << ((int)(u[0] * (1 << a)) * (1 << (m - a)) + (int)(u[1] * (1 << (m - a))));
                }
                const uint64_t full = m == 6 ? UINT64_MAX : (UINT64_C(1) << (1 << m)) - 1;
                assert_true(one == full);
                for (uint32_t a = 0; a <= m; a++)
                    assert_true(pairs[a] == full);
            }
}

/* Chi-square over cells, in standard deviations; normal enough with so many cells. */
static double chi_square_z(const double *cells, int count, double n)
{
    double chi = 0;
    for (int i = 0; i < count; i++)
        chi += (cells[i] - n / count) * (cells[i] - n / count) / (n / count);
    return (chi - (count - 1)) / sqrt(2.0 * (count - 1));
}

static void every_point_is_uniform(void **state)
{
    (void)state;
    enum { NETS = 40000, CELLS = 256 };
    for (uint64_t index = 0; index < NET_POINTS; index += 9) {
        double one[CELLS] = {0}, pair[CELLS] = {0};
        for (uint64_t pixel = 0; pixel < NETS; pixel++) {
            double u[2];
            one[(int)(place_one(pixel, index, 3) * CELLS)]++;
            place_pair(pixel, index, 8, u);
            pair[(int)(u[0] * 16) * 16 + (int)(u[1] * 16)]++;
        }
        assert_true(fabs(chi_square_z(one, CELLS, NETS)) < 5.5);
        assert_true(fabs(chi_square_z(pair, CELLS, NETS)) < 5.5);
    }
}

/* Numbers of the same point, and of different points of different numbers, in 8 x 8 cells. */
static void numbers_are_independent(void **state)
{
    (void)state;
    enum { NETS = 40000 };
    static const uint64_t points[][2] = {{0, 0}, {5, 5}, {63, 63}, {0, 1}, {0, 32}, {17, 49}, {3, 64 + 3}};
    for (size_t i = 0; i < sizeof points / sizeof *points; i++) {
        double cells[64] = {0}, within[64] = {0};
        for (uint64_t pixel = 0; pixel < NETS; pixel++) {
            double u[2];
            place_pair(pixel, points[i][1], 30, u);
            cells[(int)(place_one(pixel, points[i][0], 3) * 8) * 8 + (int)(u[0] * 8)]++;
            within[(int)(u[0] * 8) * 8 + (int)(u[1] * 8)]++;
        }
        assert_true(fabs(chi_square_z(cells, 64, NETS)) < 5.5);
        assert_true(fabs(chi_square_z(within, 64, NETS)) < 5.5);
    }
}

/* Variance of the mean of one net's points, over many nets, times the points: of independent ones that of one. */
static double variance_of_net(double (*f)(uint64_t pixel, uint64_t index), double expected)
{
    enum { NETS = 20000 };
    double sum = 0, sum2 = 0;
    for (uint64_t pixel = 0; pixel < NETS; pixel++) {
        double mean = 0;
        for (uint64_t i = 0; i < NET_POINTS; i++)
            mean += f(pixel, i) / NET_POINTS;
        sum += mean;
        sum2 += (mean - expected) * (mean - expected);
    }
    const double variance = sum2 / NETS;
    assert_near(sum / NETS, expected, 5 * sqrt(variance / NETS));
    return variance * NET_POINTS;
}

static double of_one(uint64_t pixel, uint64_t index)
{
    return place_one(pixel, index, 12);
}

static double of_pair(uint64_t pixel, uint64_t index)
{
    double u[2];
    place_pair(pixel, index, 12, u);
    return u[0] * u[1];
}

static double of_two(uint64_t pixel, uint64_t index)
{
    return (place_one(pixel, index, 12) - 0.5) * (place_one(pixel, index, 13) - 0.5);
}

/* In closed form: of u, jittered in 64 intervals, 1 / (12 64^2). Of the product of a pair, independent 7/144, far
 * less; of a product of numbers that do not belong together, where nothing can be gained, at most what two points
 * in opposite halves of both add: 1/144 + (1/16)^2. */
static void variance_is_less(void **state)
{
    (void)state;
    const double one = 1.0 / 12 / (NET_POINTS * NET_POINTS);
    assert_near(variance_of_net(of_one, 0.5), one, 6 * sqrt(2.0 / 20000) * one);
    assert_true(variance_of_net(of_pair, 0.25) < 7.0 / 144 / 100);
    assert_true(variance_of_net(of_two, 0) < 1.0 / 144 + 1.0 / 256 + 6 * sqrt(2.0 / 20000) / 144);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coordinates_are_sobol_s), cmocka_unit_test(every_interval_has_one_point),
        cmocka_unit_test(every_point_is_uniform),  cmocka_unit_test(numbers_are_independent),
        cmocka_unit_test(variance_is_less),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
