/* Tables: distributions, empty entries, half-open intervals, round trips, refusals. */
#include "math/sampling.h"
#include "math/table.h"

#include <string.h>

enum { SAMPLES = 200000 };

/* Weights of wild sizes with runs of zeros. */
static double *wild_weights(uint32_t count, uint64_t seed, double decades)
{
    double *weights = calloc(count, sizeof *weights);
    assert_non_null(weights);
    stream_t stream = stream_of(seed);
    for (uint32_t i = 0; i < count; i++)
        if (stream_number(&stream) > 0.3)
            weights[i] = pow(10, decades * (stream_number(&stream) - 0.5));
    weights[count / 2] = 1; /* not all zero */
    return weights;
}

static uint32_t linear_search(const table1_t *table, double u)
{
    uint32_t entry = 0;
    while (!(table->cdf[entry] <= u && u < table->cdf[entry + 1]))
        entry++;
    return entry;
}

static void table_matches_its_weights(void **state)
{
    (void)state;
    enum { COUNT = 237 };
    double *weights = wild_weights(COUNT, 1, 4), counts[COUNT] = {0}, expected[COUNT];
    table1_t table;
    assert_int_equal(table1_init(&table, weights, COUNT, NULL), FAULT_NONE);
    double sum = 0, total = 0;
    for (uint32_t i = 0; i < COUNT; i++)
        sum += weights[i];
    assert_near(table.sum / sum, 1, 1e-14);
    stream_t stream = stream_of(2);
    double *rests = malloc(SAMPLES * sizeof *rests);
    assert_non_null(rests);
    for (int i = 0; i < SAMPLES; i++) {
        double probability;
        const uint32_t entry = table1_sample(&table, stream_number(&stream), &probability, &rests[i]);
        assert_in_range(entry, 0, COUNT - 1);
        assert_near(probability, table1_probability(&table, entry), 0);
        counts[entry]++;
    }
    for (uint32_t i = 0; i < COUNT; i++) {
        /* two roundings of the distribution function, each half a unit of 1 */
        assert_near(table1_probability(&table, i), weights[i] / sum, 1.2e-16);
        total += table1_probability(&table, i);
        expected[i] = SAMPLES * weights[i] / sum;
    }
    assert_near(total, 1, 1e-15);
    assert_distribution("table", counts, expected, COUNT);
    assert_uniform("table: place in the entry", rests, SAMPLES);
    free(rests);
    free(weights);
    table1_clear(&table);
}

/* Entry i's interval is [cdf[i], cdf[i+1]): probed at both ends and one double to either side, against a linear
 * search. */
static void intervals_are_half_open(void **state)
{
    (void)state;
    static const uint32_t sizes[] = {1, 2, 3, 7, 64, 65, 1000, 40000};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++)
        for (int kind = 0; kind < 2; kind++) {
            const uint32_t count = sizes[s];
            double *weights = wild_weights(count, 3 + s, kind ? 30 : 1);
            table1_t table;
            assert_int_equal(table1_init(&table, weights, count, NULL), FAULT_NONE);
            assert_near(table.cdf[0], 0, 0);
            assert_near(table.cdf[count], 1, 0);
            for (uint32_t i = 0; i < count; i++) {
                assert_true(table.cdf[i] <= table.cdf[i + 1]);
                if (weights[i] == 0)
                    assert_near(table1_probability(&table, i), 0, 0);
                const double near[3] = {nextafter(table.cdf[i], 0), table.cdf[i], nextafter(table.cdf[i], 1)};
                for (int k = 0; k < 3; k++) {
                    if (!(near[k] >= 0 && near[k] < 1) || (count > 1000 && i % 97))
                        continue;
                    double probability, rest;
                    const uint32_t entry = table1_sample(&table, near[k], &probability, &rest);
                    assert_int_equal(entry, linear_search(&table, near[k]));
                    assert_true(weights[entry] > 0 && probability > 0);
                    assert_unit_interval(rest);
                }
            }
            free(weights);
            table1_clear(&table);
        }
}

static void ends_never_return_empty_entries(void **state)
{
    (void)state;
    const double weights[] = {0, 0, 0, 2.385, 0, 1e-9, 0, 0};
    table1_t table;
    assert_int_equal(table1_init(&table, weights, 8, NULL), FAULT_NONE);
    double probability, rest;
    assert_int_equal(table1_sample(&table, 0, &probability, &rest), 3);
    assert_near(rest, 0, 0);
    assert_int_equal(table1_sample(&table, MATH_ONE_MINUS, &probability, &rest), 5);
    assert_near(probability, 1e-9 / 2.385, 1.2e-16);
    assert_unit_interval(rest);
    table1_clear(&table);
}

/* All entries but one in one cell of the guide table: the search within must still end, and end right. */
static void crowded_cell_is_searched(void **state)
{
    (void)state;
    enum { COUNT = 100000 };
    double *weights = malloc(COUNT * sizeof *weights);
    assert_non_null(weights);
    for (int i = 0; i < COUNT; i++)
        weights[i] = i == COUNT / 3 ? 1 : 1e-13;
    table1_t table;
    assert_int_equal(table1_init(&table, weights, COUNT, NULL), FAULT_NONE);
    stream_t stream = stream_of(20);
    for (int i = 0; i < 300; i++) {
        const double u = i % 2 ? stream_number(&stream) * 1e-8 : 1 - stream_number(&stream) * 1e-8;
        double probability;
        assert_int_equal(table1_sample(&table, u, &probability, NULL), linear_search(&table, u));
    }
    free(weights);
    table1_clear(&table);
}

static void inverse_lands_in_its_entry(void **state)
{
    (void)state;
    enum { COUNT = 500 };
    static const double rests[] = {0, 0x1p-1074, 0x1p-53, 0.2385, 0.5, 1 - 0x1p-52, MATH_ONE_MINUS};
    double *weights = wild_weights(COUNT, 21, 24);
    table1_t table;
    assert_int_equal(table1_init(&table, weights, COUNT, NULL), FAULT_NONE);
    int tested = 0;
    for (uint32_t i = 0; i < COUNT; i++) {
        const double p = table1_probability(&table, i);
        if (!(p > 0))
            continue;
        for (size_t k = 0; k < sizeof rests / sizeof rests[0]; k++) {
            const double u = table1_invert(&table, i, rests[k]);
            assert_true(u >= table.cdf[i] && u < table.cdf[i + 1]);
            double probability, rest;
            assert_int_equal(table1_sample(&table, u, &probability, &rest), i);
            /* u is rounded to 1.1e-16, and held one more below the interval's end */
            assert_near(rest, rests[k], 2.3e-16 / p + 4e-16);
            tested++;
        }
    }
    assert_true(tested > 500);
    free(weights);
    table1_clear(&table);
}

static void numbers_come_back(void **state)
{
    (void)state;
    enum { COUNT = 333 };
    double *weights = wild_weights(COUNT, 22, 2);
    table1_t table;
    assert_int_equal(table1_init(&table, weights, COUNT, NULL), FAULT_NONE);
    stream_t stream = stream_of(23);
    for (int i = 0; i < 20000; i++) {
        const double u = stream_number(&stream);
        double probability, rest;
        const uint32_t entry = table1_sample(&table, u, &probability, &rest);
        assert_near(table1_invert(&table, entry, rest), u, 2.3e-16);
    }
    free(weights);
    table1_clear(&table);
}

static void impossible_weights_are_refused(void **state)
{
    (void)state;
    const double bad[][3] = {{0, 0, 0}, {1, -1e-300, 1}, {1, NAN, 1}, {1, INFINITY, 1}, {1.7e308, 1.7e308, 0}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        table1_t table;
        fault_t fault = {0};
        assert_int_equal(table1_init(&table, bad[i], 3, &fault), FAULT_RANGE);
        assert_true(strlen(fault.text) > 10);
        assert_null(table.cdf);
        table1_clear(&table);
        table2_t grid;
        assert_int_equal(table2_init(&grid, bad[i], 1, 3, &fault), FAULT_RANGE);
        assert_int_equal(table2_init(&grid, bad[i], 3, 1, NULL), FAULT_RANGE);
        table2_clear(&grid);
    }
    table1_t table;
    assert_int_equal(table1_init(&table, NULL, 0, NULL), FAULT_RANGE);
}

static void weights_may_be_as_small_or_large_as_doubles_are(void **state)
{
    (void)state;
    const double small[] = {0x1p-1074, 0x1p-1073, 0}, large[] = {1e308, 0, 0.5e308};
    table1_t table;
    assert_int_equal(table1_init(&table, small, 3, NULL), FAULT_NONE);
    assert_near(table1_probability(&table, 1), 2. / 3, 1.2e-16);
    table1_clear(&table);
    assert_int_equal(table1_init(&table, large, 3, NULL), FAULT_NONE);
    assert_near(table1_probability(&table, 0), 2. / 3, 1.2e-16);
    table1_clear(&table);
}

/* ---- two dimensions ---- */

static void grid_matches_its_weights(void **state)
{
    (void)state;
    enum { WIDTH = 13, HEIGHT = 7 };
    double *weights = wild_weights(WIDTH * HEIGHT, 30, 2);
    memset(weights + 2 * WIDTH, 0, WIDTH * sizeof *weights); /* a row of zeros */
    double counts[WIDTH * HEIGHT] = {0}, expected[WIDTH * HEIGHT], sum = 0, integral = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        sum += weights[i];
    table2_t table;
    assert_int_equal(table2_init(&table, weights, WIDTH, HEIGHT, NULL), FAULT_NONE);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const double pdf = table2_pdf(&table, (x + 0.2385) / WIDTH, (y + 0.77) / HEIGHT);
            const double share = weights[y * WIDTH + x] / sum;
            assert_near(pdf / (WIDTH * HEIGHT), share, 1e-15);
            integral += pdf / (WIDTH * HEIGHT);
            expected[y * WIDTH + x] = SAMPLES * share;
        }
    assert_near(integral, 1, 1e-14);
    stream_t stream = stream_of(31);
    for (int i = 0; i < SAMPLES; i++) {
        const double u = stream_number(&stream), v = stream_number(&stream);
        double x, y;
        const double pdf = table2_sample(&table, u, v, &x, &y);
        assert_unit_interval(x);
        assert_unit_interval(y);
        assert_near(table2_pdf(&table, x, y) / pdf, 1, 1e-15);
        counts[(int)(y * HEIGHT) * WIDTH + (int)(x * WIDTH)]++;
    }
    assert_distribution("grid", counts, expected, WIDTH * HEIGHT);
    free(weights);
    table2_clear(&table);
}

static void check_grid_round_trip(const table2_t *table, double u, double v)
{
    double x, y, back_u, back_v, x2, y2;
    const double pdf = table2_sample(table, u, v, &x, &y);
    assert_true(pdf > 0);
    assert_near(table2_pdf(table, x, y) / pdf, 1, 1e-15);
    table2_invert(table, x, y, &back_u, &back_v);
    assert_unit_interval(back_u);
    assert_unit_interval(back_v);
    assert_near(table2_sample(table, back_u, back_v, &x2, &y2) / pdf, 1, 1e-15);
    /* a cell 1/n wide of conditional probability p: 1.1e-16 / (p n), some roundings each way */
    const uint32_t row = (uint32_t)(y * table->height), column = (uint32_t)(x * table->width);
    const double p_row = table1_probability(&table->rows, row),
                 p_column = table1_probability(&table->columns[row], column);
    assert_near(x2, x, 1e-15 + 5e-16 / (p_column * table->width));
    assert_near(y2, y, 1e-15 + 5e-16 / (p_row * table->height));
}

static void grid_points_come_back(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {3, 5}, {1000, 7}, {7, 1000}, {49, 51}, {128, 64}};
    static const double ends[] = {0, 0x1p-53, 0.5, 1 - 0x1p-52, MATH_ONE_MINUS};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++) {
        double *weights = wild_weights(sizes[s][0] * sizes[s][1], 40 + s, 4);
        table2_t table;
        assert_int_equal(table2_init(&table, weights, sizes[s][0], sizes[s][1], NULL), FAULT_NONE);
        stream_t stream = stream_of(50 + s);
        for (int i = 0; i < 10000; i++) {
            const double u = stream_number(&stream), v = stream_number(&stream);
            check_grid_round_trip(&table, u, v);
        }
        for (int i = 0; i < 5; i++)
            for (int j = 0; j < 5; j++)
                check_grid_round_trip(&table, ends[i], ends[j]);
        /* and the numbers at the borders of cells, where x * width may round into the next one */
        for (uint32_t row = 0; row < sizes[s][1]; row++)
            for (int k = -1; k <= 1; k++) {
                const double border = table.rows.cdf[row], v = k < 0   ? nextafter(border, 0)
                                                               : k > 0 ? nextafter(border, 1)
                                                                       : border;
                if (v < 1)
                    check_grid_round_trip(&table, 0.2385, v);
            }
        free(weights);
        table2_clear(&table);
    }
}

static void grid_of_zeros_elsewhere_has_no_density_there(void **state)
{
    (void)state;
    const double weights[] = {0, 0, 0, 0, 1, 0};
    table2_t table;
    assert_int_equal(table2_init(&table, weights, 2, 3, NULL), FAULT_NONE);
    assert_near(table2_pdf(&table, 0.25, 0.9), 6, 1e-15);
    double u, v, x, y;
    for (int cell = 0; cell < 6; cell++) {
        const double px = 0.25 + 0.5 * (cell % 2), py = (cell / 2 + 0.5) / 3;
        if (cell != 4)
            assert_near(table2_pdf(&table, px, py), 0, 0);
        table2_invert(&table, px, py, &u, &v);
        assert_unit_interval(u);
        assert_unit_interval(v);
    }
    table2_sample(&table, MATH_ONE_MINUS, 0, &x, &y);
    assert_true(x < 0.5 && y * 3 >= 2);
    table2_clear(&table);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table_matches_its_weights),
        cmocka_unit_test(intervals_are_half_open),
        cmocka_unit_test(ends_never_return_empty_entries),
        cmocka_unit_test(crowded_cell_is_searched),
        cmocka_unit_test(inverse_lands_in_its_entry),
        cmocka_unit_test(numbers_come_back),
        cmocka_unit_test(impossible_weights_are_refused),
        cmocka_unit_test(weights_may_be_as_small_or_large_as_doubles_are),
        cmocka_unit_test(grid_matches_its_weights),
        cmocka_unit_test(grid_points_come_back),
        cmocka_unit_test(grid_of_zeros_elsewhere_has_no_density_there),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
