#include "support.h"

#include <stdlib.h>

#include "base/random.h"
#include "film/smooth.h"

enum { WIDEST = 23, HIGHEST = 19 };

static double plane[WIDEST * HIGHEST], means[WIDEST * HIGHEST];

static void make_plane(uint32_t width, uint32_t height)
{
    for (uint32_t i = 0; i < width * height; i++)
        means[i] = plane[i] = exp(20 * random_double(random_key(2385, RANDOM_PURPOSE_TEST, 0, i), 0));
}

/* Of the pixels within r, one by one. */
static double direct_mean(uint32_t width, uint32_t height, uint32_t r, uint32_t x, uint32_t y)
{
    double sum = 0, count = 0;
    for (uint32_t j = y > r ? y - r : 0; j <= y + r && j < height; j++)
        for (uint32_t i = x > r ? x - r : 0; i <= x + r && i < width; i++, count++)
            sum += plane[j * width + i];
    return sum / count;
}

/* Values over nine decades: running sums keep what large ones leave of the digits, some 1e-16 of the largest sum.
 */
static void means_are_those_of_squares_cut_at_the_edge(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{WIDEST, HIGHEST}, {1, HIGHEST}, {WIDEST, 1}, {1, 1}, {2, 3}, {7, 8}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (uint32_t r = 0; r < 30; r += r < 5 ? 1 : 6) {
            const uint32_t width = sizes[s][0], height = sizes[s][1];
            double *scratch = malloc(sizeof(double) * smooth_scratch(width, height, r)), largest = 0;
            assert_non_null(scratch);
            make_plane(width, height);
            for (uint32_t i = 0; i < width * height; i++)
                largest = fmax(largest, plane[i]);
            smooth_square(means, width, height, r, scratch);
            for (uint32_t y = 0; y < height; y++)
                for (uint32_t x = 0; x < width; x++)
                    assert_near(means[y * width + x], direct_mean(width, height, r, x, y), 1e-13 * largest);
            free(scratch);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(means_are_those_of_squares_cut_at_the_edge)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
