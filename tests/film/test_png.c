#include "support.h"

#include <math.h>

#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>

#include "film/png.h"

/* The curve's inverse, IEC 61966-2-1: a second way. */
static double linear_of(double srgb)
{
    return srgb <= 0.04045 ? srgb / 12.92 : pow((srgb + 0.055) / 1.055, 2.4);
}

/* Decoded pixels, [height][width][3]; the caller frees them. */
static uint8_t *decoded(const image_t *image, double exposure)
{
    uint8_t *data;
    size_t size;
    assert_ok(png_encode(image, exposure, &data, &size, fault));
    int width, height, channels;
    uint8_t *pixels = stbi_load_from_memory(data, (int)size, &width, &height, &channels, 0);
    assert_non_null(pixels);
    assert_int_equal(width, image->width);
    assert_int_equal(height, image->height);
    assert_int_equal(channels, 3);
    free(data);
    return pixels;
}

/* A value 0.49 steps to either side of a level rounds to it. */
static void every_level_is_met_by_the_values_around_it(void **state)
{
    (void)state;
    image_t image;
    assert_ok(image_init_rgb(&image, 256, 1, fault));
    for (int i = 0; i < 256; i++) {
        image_channel(&image, 0)[i] = (float)(linear_of((i - (i ? 0.49 : 0)) / 255) / 2.385);
        image_channel(&image, 1)[i] = (float)(linear_of(i / 255.0) / 2.385);
        image_channel(&image, 2)[i] = (float)(linear_of((i + 0.49) / 255) / 2.385);
    }
    uint8_t *pixels = decoded(&image, 2.385);
    for (int i = 0; i < 256; i++)
        for (int c = 0; c < 3; c++)
            assert_int_equal(pixels[3 * i + c], i);
    stbi_image_free(pixels);
    image_clear(&image);
}

static void odd_values_are_clamped_and_rows_run_from_the_top(void **state)
{
    (void)state;
    image_t image;
    assert_ok(image_init_rgb(&image, 2, 2, fault));
    const float red[] = {-1, NAN, INFINITY, 1.001f}, green[] = {0, 0.5f, 1, -INFINITY},
                blue[] = {1e30f, 1e-30f, 0.2f, 0};
    memcpy(image_channel(&image, 0), red, sizeof red);
    memcpy(image_channel(&image, 1), green, sizeof green);
    memcpy(image_channel(&image, 2), blue, sizeof blue);
    uint8_t *pixels = decoded(&image, 1);
    /* 1.055 * 0.5^(1/2.4) - 0.055 = 0.73536, times 255 is 187.5; of 0.2 0.48453, 123.6 */
    static const uint8_t expected[] = {0, 0, 255, 0, 188, 0, 255, 255, 124, 255, 0, 0};
    assert_memory_equal(pixels, expected, sizeof expected);
    stbi_image_free(pixels);
    image_clear(&image);
}

static void files_are_written_and_faults_are_named(void **state)
{
    (void)state;
    image_t image;
    static const char *const names[] = {"Y", "samples"};
    assert_ok(image_init(&image, 3, 2, 2, names, fault));
    image.data[0] = 1;
    scratch_t scratch;
    scratch_open(&scratch, "a.png");
    assert_ok(png_write(&image, 1, scratch.path, fault));
    int width, height, channels;
    uint8_t *pixels = stbi_load(scratch.path, &width, &height, &channels, 3);
    assert_non_null(pixels);
    assert_int_equal(pixels[0] + pixels[1] + pixels[2], 3 * 255); /* grey */
    assert_int_equal(pixels[3], 0);
    stbi_image_free(pixels);
    assert_fault(FAULT_RANGE, "exposure 0", png_write(&image, 0, scratch.path, fault));
    assert_fault(FAULT_RANGE, "exposure nan", png_write(&image, NAN, scratch.path, fault));
    assert_fault(FAULT_RANGE, "exposure inf", png_write(&image, INFINITY, scratch.path, fault));
    char inside[160];
    snprintf(inside, sizeof inside, "%s/b.png", scratch.path); /* a file is no folder */
    assert_fault(FAULT_NOT_FOUND, inside, png_write(&image, 1, inside, fault));
    scratch_close(&scratch);
    image_clear(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_level_is_met_by_the_values_around_it),
        cmocka_unit_test(odd_values_are_clamped_and_rows_run_from_the_top),
        cmocka_unit_test(files_are_written_and_faults_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
