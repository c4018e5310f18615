#include "support.h"

#include "film/compare.h"
#include "film/image_file.h"
#include "support/normal.h"

/* Results hold a kilobyte and more of blocks each. */
static compare_result_t result;

static void grey_row(image_t *image, uint32_t width, const double *values)
{
    assert_ok(image_init_rgb(image, width, 1, fault));
    for (uint32_t c = 0; c < 3; c++)
        for (uint32_t x = 0; x < width; x++)
            image_channel(image, c)[x] = (float)values[x];
}

/* R = 1, 1; I = 1.5, 1. (0.5^2 / 1.01) / 2 = 0.12376. A common factor changes nothing, nor does a reference twice.
 */
static void two_grey_pixels_by_hand(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++) {
        const double unit = k == 1 ? 8 : 1;
        image_t i, r;
        grey_row(&i, 2, (const double[]){1.5 * unit, unit});
        grey_row(&r, 2, (const double[]){unit, unit});
        assert_ok(compare_images(&result, &i, &r, k == 2 ? &r : NULL, NULL, fault));
        assert_near(result.scale, 1 / unit, 1e-15);
        assert_near(result.mse, 0.125, 1e-15);
        assert_near(result.relmse, 0.25 / 1.01 / 2, 1e-15);
        assert_near(result.error, sqrt(0.25 / 1.01 / 2), 1e-15);
        assert_near(result.bias, 1.25, 1e-15);
        assert_near(result.bias_rgb[1], 1.25, 1e-15);
        assert_int_equal(result.trimmed, 1);
        assert_near(result.relmse_trimmed, 0, 0);
        assert_int_equal(result.worst_x, 0);
        assert_near(result.worst, 0.25 / 1.01, 1e-15);
        assert_int_equal(result.nonfinite, 0);
        assert_null(result.nonfinite_name);
        image_clear(&i);
        image_clear(&r);
    }
}

/* One pixel, colours. R = (2, 0, 0): luminance 0.425342, scale 2.3510; I = (1, 1, 0). A = (3, 0, 0), B = (1, 0, 0)
 * have the same mean. By hand, in units of the scale s: (I-R)^2 = 1, 1, 0; R^2 = 4, 0, 0; (I-A)(I-B) = 0, 1, 0. */
static void one_colour_by_hand(void **state)
{
    (void)state;
    image_t i, r, a, b;
    image_t *const images[] = {&i, &r, &a, &b};
    static const float colours[4][3] = {{1, 1, 0}, {2, 0, 0}, {3, 0, 0}, {1, 0, 0}};
    for (int k = 0; k < 4; k++) {
        assert_ok(image_init_rgb(images[k], 1, 1, fault));
        memcpy(images[k]->data, colours[k], sizeof colours[k]);
    }
    const double s = 1 / (2 * 0.212671), s2 = s * s;
    assert_ok(compare_images(&result, &i, &r, NULL, NULL, fault));
    assert_near(result.scale, s, 1e-14);
    assert_near(result.mse, 2 * s2 / 3, 1e-13);
    assert_near(result.relmse, (s2 / (4 * s2 + 0.01) + s2 / 0.01) / 3, 1e-11);
    assert_near(result.bias, (0.212671 + 0.715160) / (2 * 0.212671), 1e-14);
    assert_near(result.bias_rgb[0], 0.5, 1e-15);
    assert_true(isnan(result.bias_rgb[1]));
    assert_int_equal(result.trimmed, 0); /* the only pixel stays */
    assert_near(result.relmse_trimmed, result.relmse, 1e-11);
    assert_ok(compare_images(&result, &i, &a, &b, NULL, fault));
    assert_near(result.scale, s, 1e-14);
    assert_near(result.mse, s2 / 3, 1e-13);
    assert_near(result.relmse, s2 / 0.01 / 3, 1e-11);
    assert_near(result.worst, (s2 / (4 * s2 + 0.01) + s2 / 0.01) / 3, 1e-11);
    assert_ok(compare_images(&result, &b, &a, &b, NULL, fault)); /* I = B: nothing is left */
    assert_near(result.mse, 0, 0);
    image_clear(&i);
    image_clear(&r);
    image_clear(&a);
    image_clear(&b);
}

/* Pixel errors 1, 2, .. n in some order: trimming leaves out the largest ceil(n/1000). */
static void trimming_leaves_out_the_worst_pixels(void **state)
{
    (void)state;
    static const struct {
        uint32_t pixels, trimmed;
        double trim;
    } cases[] = {{999, 1, 0},  {1000, 1, 0},   {1001, 2, 0},    {2000, 2, 0},
                 {3000, 3, 0}, {32000, 32, 0}, {1000, 70, 0.07}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const uint32_t n = cases[k].pixels;
        double *values = malloc(n * sizeof *values), *ones = malloc(n * sizeof *ones);
        for (uint32_t x = 0; x < n; x++) {
            values[x] = 1 + ((uint64_t)x * 7919 + 13) % n + 1; /* 7919 is prime: a permutation */
            ones[x] = 1;
        }
        image_t i, r;
        grey_row(&i, n, values);
        grey_row(&r, n, ones);
        const compare_options_t options = {.trim = cases[k].trim};
        assert_ok(compare_images(&result, &i, &r, NULL, &options, fault));
        assert_int_equal(result.trimmed, cases[k].trimmed);
        const double all = n, kept = n - cases[k].trimmed; /* sum of squares up to m: m (m+1) (2m+1) / 6 */
        assert_near(result.relmse, (all + 1) * (2 * all + 1) / 6 / 1.01, 1e-12 * all * all);
        assert_near(result.relmse_trimmed, (kept + 1) * (2 * kept + 1) / 6 / 1.01, 1e-12 * all * all);
        free(values);
        free(ones);
        image_clear(&i);
        image_clear(&r);
    }
}

static void nonfinite_pixels_are_counted_named_and_left_out(void **state)
{
    (void)state;
    image_t i, r, b;
    grey_row(&i, 4, (const double[]){1.5, 1, 5, 7});
    grey_row(&r, 4, (const double[]){1, 1, 9, 9});
    grey_row(&b, 4, (const double[]){1, 1, 9, 9});
    image_channel(&i, 1)[3] = INFINITY;
    image_channel(&b, 2)[2] = NAN;
    const compare_options_t options = {.names = {"a.exr", "b.exr", "c.exr"}};
    assert_ok(compare_images(&result, &i, &r, &b, &options, fault));
    assert_int_equal(result.nonfinite, 2);
    assert_int_equal(result.nonfinite_x, 2);
    assert_int_equal(result.nonfinite_y, 0);
    assert_string_equal(result.nonfinite_name, "c.exr");
    assert_near(result.relmse, 0.25 / 1.01 / 2, 1e-15);
    assert_near(result.bias, 1.25, 1e-15);
    image_t map;
    assert_ok(compare_heat_map(&map, &result, &i, &r, &b, fault));
    assert_true(isnan(image_channel(&map, 3)[2]) && image_channel(&map, 1)[2] == 1 &&
                image_channel(&map, 0)[2] == 0);
    assert_near((double)image_channel(&map, 3)[0], sqrt(0.25 / 1.01), 1e-7);
    /* log(0.497519 / 0.01) / log(1000) = 0.565603: 26 % of the way from red to yellow */
    assert_near((double)image_channel(&map, 0)[0], 1, 1e-6);
    assert_near((double)image_channel(&map, 1)[0], 0.262412, 1e-5);
    assert_true(image_channel(&map, 2)[0] == 0);
    assert_true(image_channel(&map, 0)[1] == 0 && image_channel(&map, 2)[1] == 0); /* no error: black */
    image_clear(&map);
    for (int x = 0; x < 4; x++)
        image_channel(&r, 0)[x] = NAN;
    assert_fault(FAULT_RANGE, "a.exr and b.exr", compare_images(&result, &i, &r, NULL, &options, fault));
    image_clear(&i);
    image_clear(&r);
    image_clear(&b);
}

static void what_cannot_be_compared_is_refused(void **state)
{
    (void)state;
    image_t small, large, black, depth;
    static const char *const names[] = {"Z", "N.X"};
    assert_ok(image_init_rgb(&small, 3, 2, fault));
    assert_ok(image_init_rgb(&large, 4, 2, fault));
    assert_ok(image_init_rgb(&black, 3, 2, fault));
    assert_ok(image_init(&depth, 3, 2, 2, names, fault));
    small.data[0] = 1;
    const compare_options_t named = {.names = {"a.exr", "b.exr", "c.exr"}}, coarse = {.grid = 33},
                            wide = {.trim = 1}, odd = {.trim = NAN};
    assert_fault(FAULT_RANGE, "a.exr has 3 x 2 pixels, b.exr 4 x 2",
                 compare_images(&result, &small, &large, NULL, &named, fault));
    assert_fault(FAULT_RANGE, "a.exr has 3 x 2 pixels, c.exr 4 x 2",
                 compare_images(&result, &small, &small, &large, &named, fault));
    assert_fault(FAULT_RANGE, "reference: mean luminance is 0",
                 compare_images(&result, &small, &black, NULL, NULL, fault));
    assert_fault(FAULT_NOT_FOUND, "b.exr: no channel \"R\" nor \"Y\": found Z, N.X",
                 compare_images(&result, &small, &depth, NULL, &named, fault));
    assert_int_equal(compare_images(&result, &small, &depth, NULL, NULL, NULL), FAULT_NOT_FOUND);
    assert_fault(FAULT_RANGE, "grid: 33", compare_images(&result, &small, &small, NULL, &coarse, fault));
    assert_fault(FAULT_RANGE, "trim: 1", compare_images(&result, &small, &small, NULL, &wide, fault));
    assert_fault(FAULT_RANGE, "trim: nan", compare_images(&result, &small, &small, NULL, &odd, fault));
    image_clear(&small);
    image_clear(&large);
    image_clear(&black);
    image_clear(&depth);
}

/* 10 x 5 pixels in 4 x 4 blocks: a pixel belongs to block floor(4 x / 10), floor(4 y / 5). Two columns of blocks
 * are 1.5 times too bright; an image smaller than the grid leaves blocks empty. */
static void blocks_show_where_the_light_is_wrong(void **state)
{
    (void)state;
    image_t i, r;
    assert_ok(image_init_rgb(&i, 10, 5, fault));
    assert_ok(image_init_rgb(&r, 10, 5, fault));
    for (uint32_t c = 0; c < 3; c++)
        for (int y = 0; y < 5; y++)
            for (int x = 0; x < 10; x++) {
                image_channel(&r, c)[y * 10 + x] = (float)(1 + y);
                image_channel(&i, c)[y * 10 + x] = (float)((1 + y) * (x < 5 ? 1.5 : 1));
            }
    const compare_options_t options = {.grid = 4};
    assert_ok(compare_images(&result, &i, &r, NULL, &options, fault));
    assert_int_equal(result.grid, 4);
    static const int pixels[4] = {6, 3, 3, 3}; /* rows 0 and 1 in the first; columns 3, 2, 3, 2 */
    for (int by = 0; by < 4; by++)
        for (int bx = 0; bx < 4; bx++) {
            const compare_block_t *block = &result.blocks[by * 4 + bx];
            assert_int_equal(block->pixels, pixels[by] / 3 * (bx % 2 ? 2 : 3));
            assert_near(block->ratio, bx < 2 ? 1.5 : 1, 1e-12);
            assert_near(block->reference, (by == 0 ? 1.5 : by + 2) / 3, 1e-12); /* the mean is 3 */
            assert_near(block->image, block->reference * block->ratio, 1e-12);
        }
    const compare_options_t fine = {.grid = 16};
    assert_ok(compare_images(&result, &i, &r, NULL, &fine, fault));
    uint64_t sum = 0;
    for (int k = 0; k < 256; k++) {
        sum += result.blocks[k].pixels;
        assert_true(result.blocks[k].pixels > 0 || isnan(result.blocks[k].ratio));
    }
    assert_int_equal(sum, 50);
    image_clear(&i);
    image_clear(&r);
}

enum { SIDE = 128, TERMS = SIDE * SIDE * 3 };

static double normal(uint64_t stream, uint64_t index)
{
    return normal_of(uniform(stream, 2 * index), uniform(stream, 2 * index + 1));
}

static void noisy(image_t *image, double sigma, uint64_t stream)
{
    assert_ok(image_init_rgb(image, SIDE, SIDE, fault));
    for (uint64_t i = 0; i < TERMS; i++)
        image->data[i] = (float)(0.5 + uniform(1, i) + sigma * normal(stream, i));
}

/* The truth is 0.5 to 1.5 in each channel (mean luminance 1), the references carry noise of 0.1, which is more than
 * the image's own of 0.05. Against two references MSE is 0.05^2 without a floor, against their mean it would be
 * 0.05^2 + 0.1^2 / 2. The standard deviation of the mean of (I-A)(I-B) = (e-a)(e-b) is sqrt((2 e^4 + 2 e^2 s^2 +
 * s^4) / n) for the deviations e and s: 5 of them are a false-alarm rate of 6e-7. What the scale's own error (the
 * mean of 49152 values: 5 deviations are 1 %) and the curvature of the denominator add is bounded by 2 %. A perfect
 * image must come to 0 within the deviation of ab alone. */
static void two_references_have_no_floor(void **state)
{
    (void)state;
    const double s = 0.1;
    for (int k = 0; k < 2; k++) {
        const double e = k == 0 ? 0.05 : 0;
        image_t i, a, b, mean;
        noisy(&i, e, 2);
        noisy(&a, s, 3);
        noisy(&b, s, 4);
        assert_ok(image_init_rgb(&mean, SIDE, SIDE, fault));
        double denominators = 0; /* what relMSE's noise comes to, by the truth */
        for (uint64_t t = 0; t < TERMS; t++) {
            mean.data[t] = (a.data[t] + b.data[t]) / 2;
            const double truth = 0.5 + uniform(1, t);
            denominators += 1 / (truth * truth + COMPARE_EPSILON) / TERMS;
        }
        const double deviation = sqrt((2 * e * e * e * e + 2 * e * e * s * s + s * s * s * s) / TERMS);
        assert_ok(compare_images(&result, &i, &a, &b, NULL, fault));
        assert_near(result.mse, e * e, 5 * deviation + 0.02 * e * e);
        /* relMSE: the terms' weights are at most 1/(0.5^2), and 4 % of s^2 for their dependence on a and b */
        assert_near(result.relmse, e * e * denominators, 5 * deviation * 4 + 0.02 * e * e * 4 + 0.04 * s * s);
        assert_ok(compare_images(&result, &i, &mean, NULL, NULL, fault));
        assert_near(result.mse, e * e + s * s / 2, 0.05 * s * s);
        assert_true(result.relmse > e * e * denominators + 0.4 * s * s);
        image_clear(&i);
        image_clear(&a);
        image_clear(&b);
        image_clear(&mean);
    }
}

/* The other way round: straightforward sums in long double over random images. */
static void agrees_with_a_plain_implementation(void **state)
{
    (void)state;
    image_t i, a, b;
    noisy(&i, 0.3, 5);
    noisy(&a, 0.2, 6);
    noisy(&b, 0.2, 7);
    const size_t n = (size_t)SIDE * SIDE;
    static const long double luminance[3] = {0.212671L, 0.715160L, 0.072169L};
    long double mean = 0, squared = 0, relative = 0;
    for (size_t k = 0; k < TERMS; k++)
        mean += luminance[k / n] * ((long double)a.data[k] + (long double)b.data[k]) / 2 / n;
    for (size_t k = 0; k < TERMS; k++) {
        const long double v = (long double)i.data[k] / mean, x = (long double)a.data[k] / mean,
                          y = (long double)b.data[k] / mean, r = (x + y) / 2;
        squared += (v - x) * (v - y) / TERMS;
        relative += (v - x) * (v - y) / (r * r + 0.01L) / TERMS;
    }
    assert_ok(compare_images(&result, &i, &a, &b, NULL, fault));
    assert_near(result.scale, (double)(1 / mean), 1e-12);
    assert_near(result.mse, (double)squared, 1e-12);
    assert_near(result.relmse, (double)relative, 1e-12);
    image_clear(&i);
    image_clear(&a);
    image_clear(&b);
}

/* Figures that someone else's program printed (4 digits): of the parts of a reference against each other. With
 * shares f and 1-f of the parts in the reference R, part - R = (1-f) (part - other), and the figure printed is for
 * (part - other)^2. */
static void agrees_with_published_figures(void **state)
{
    (void)state;
    const char *shared = getenv("GARLAND_SHARED");
    if (!shared || access(shared, R_OK) != 0) {
        print_message("GARLAND_SHARED is not set: no published figures to compare with\n");
        skip();
    }
    static const struct {
        const char *part, *reference;
        double share, relmse, trimmed, digit; /* one unit of the last digit */
    } cases[] = {
        {"cornell-box-part-path-zsobol-s101", "cornell-box", 512 / 768.0, 0.00527, 0.005124, 1e-6},
        {"cornell-box-part-path-zsobol-s102", "cornell-box", 256 / 768.0, 0.00527, 0.005124, 1e-6},
        {"staircase2-part-volpath-zsobol-s101", "staircase2", 0.5, 0.09722, 0.09577, 1e-5},
        {"coffee-part-path-zsobol-s102", "coffee", 0.5, 0.1152, 0.1122, 1e-4},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char part[512], reference[512];
        snprintf(part, sizeof part, "%s/peers/pbrt/refs/%s.pfm", shared, cases[k].part);
        snprintf(reference, sizeof reference, "%s/peers/pbrt/refs/%s.pfm", shared, cases[k].reference);
        image_t i, r;
        assert_ok(image_file_read(&i, part, fault));
        assert_ok(image_file_read(&r, reference, fault));
        assert_ok(compare_images(&result, &i, &r, NULL, NULL, fault));
        const double factor = 1 / ((1 - cases[k].share) * (1 - cases[k].share));
        assert_near(result.relmse * factor, cases[k].relmse, cases[k].digit);
        assert_near(result.relmse_trimmed * factor, cases[k].trimmed, cases[k].digit);
        image_clear(&i);
        image_clear(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_grey_pixels_by_hand),
        cmocka_unit_test(one_colour_by_hand),
        cmocka_unit_test(trimming_leaves_out_the_worst_pixels),
        cmocka_unit_test(nonfinite_pixels_are_counted_named_and_left_out),
        cmocka_unit_test(what_cannot_be_compared_is_refused),
        cmocka_unit_test(blocks_show_where_the_light_is_wrong),
        cmocka_unit_test(two_references_have_no_floor),
        cmocka_unit_test(agrees_with_a_plain_implementation),
        cmocka_unit_test(agrees_with_published_figures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
