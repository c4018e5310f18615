#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/random.h"
#include "scene/texture.h"

/* Sums of a few products of numbers up to 1, in double: some 10 roundings of 2^-53 each. */
static const double rounding = 4e-15;

static void assert_near(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("found %.17g, expected %.17g", found, expected);
}

static void assert_color(rgb_t found, double r, double g, double b)
{
    assert_near(found.r, r, rounding);
    assert_near(found.g, g, rounding);
    assert_near(found.b, b, rounding);
}

static scene_texture_t image_texture(uint32_t wrap)
{
    return (scene_texture_t){
        .kind = SCENE_TEXTURE_IMAGE, .wrap = wrap, .scale_u = 1, .scale_v = 1, .value = {1, 1, 1}};
}

static scene_param_t param(float value, int32_t texture)
{
    return (scene_param_t){{value, value, value}, texture};
}

static double uniform(uint64_t counter)
{
    return random_double(random_key(11, RANDOM_PURPOSE_TEST, 0, 0), counter);
}

/* ---- images ---- */

enum { WIDTH = 5, HEIGHT = 3 };
static float pixels[WIDTH * HEIGHT];
static const scene_image_t gray = {.width = WIDTH, .height = HEIGHT, .channels = 1, .texel = SCENE_TEXEL_FLOAT32};

static scene_t gray_scene(const scene_texture_t *texture)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        pixels[i] = (float)uniform((uint64_t)i);
    return (scene_t){.textures = texture,
                     .texture_count = 1,
                     .images = &gray,
                     .image_count = 1,
                     .texels = (const uint8_t *)pixels,
                     .texel_bytes = sizeof pixels};
}

/* The second way: the sum over the texels of the plane of texel times tent, heights 1 at the centre, 0 one texel
 * off. */
static double tent_sum(double u, double v, uint32_t wrap)
{
    const double x = u * WIDTH - 0.5, y = (1 - v) * HEIGHT - 0.5;
    double sum = 0;
    for (int j = -40; j < 40; j++) {
        for (int i = -40; i < 40; i++) {
            const double weight = fmax(0, 1 - fabs(x - i)) * fmax(0, 1 - fabs(y - j));
            int column = i, row = j;
            if (wrap == SCENE_WRAP_REPEAT) {
                column = (i + 40 * WIDTH) % WIDTH;
                row = (j + 40 * HEIGHT) % HEIGHT;
            } else if (wrap == SCENE_WRAP_CLAMP) {
                column = i < 0 ? 0 : i < WIDTH ? i : WIDTH - 1;
                row = j < 0 ? 0 : j < HEIGHT ? j : HEIGHT - 1;
            }
            if (column >= 0 && column < WIDTH && row >= 0 && row < HEIGHT)
                sum += weight * (double)pixels[row * WIDTH + column];
        }
    }
    return sum;
}

static void images_are_filtered_by_a_tent_in_every_wrap_mode(void **state)
{
    (void)state;
    for (uint32_t wrap = SCENE_WRAP_REPEAT; wrap <= SCENE_WRAP_CLAMP; wrap++) {
        const scene_texture_t texture = image_texture(wrap);
        const scene_t scene = gray_scene(&texture);
        for (uint64_t i = 0; i < 2000; i++) {
            const double u = 6 * uniform(100 + 2 * i) - 3, v = 6 * uniform(101 + 2 * i) - 3;
            /* u is known to 2^-52, of which the tent's slope makes 5 x 2^-52. */
            assert_near(texture_scalar(&scene, 0, u, v), tent_sum(u, v, wrap), 20 * rounding);
            const rgb_t color = texture_color(&scene, 0, u, v);
            assert_color(color, texture_scalar(&scene, 0, u, v), color.r, color.r);
        }
    }
}

static void texel_centres_give_texels_and_v_goes_up(void **state)
{
    (void)state;
    const scene_texture_t texture = image_texture(SCENE_WRAP_CLAMP);
    const scene_t scene = gray_scene(&texture);
    for (int row = 0; row < HEIGHT; row++)
        for (int column = 0; column < WIDTH; column++)
            assert_near(texture_scalar(&scene, 0, (column + 0.5) / WIDTH, 1 - (row + 0.5) / HEIGHT),
                        (double)pixels[row * WIDTH + column], rounding);
    assert_near(texture_scalar(&scene, 0, 0, 0), (double)pixels[(HEIGHT - 1) * WIDTH], 0); /* the bottom row */
    assert_near(texture_scalar(&scene, 0, 0, 1), (double)pixels[0], 0);
}

static void coordinates_are_scaled_and_shifted(void **state)
{
    (void)state;
    scene_texture_t mapped = image_texture(SCENE_WRAP_REPEAT);
    const scene_texture_t plain = mapped;
    mapped.scale_u = 2.5f;
    mapped.offset_u = 0.375f;
    mapped.scale_v = -1.25f;
    mapped.offset_v = 0.0625f;
    const scene_t scene = gray_scene(&mapped), reference = gray_scene(&plain);
    for (uint64_t i = 0; i < 100; i++) {
        const double u = uniform(5000 + 2 * i), v = uniform(5001 + 2 * i);
        assert_near(texture_scalar(&scene, 0, u, v),
                    texture_scalar(&reference, 0, 2.5 * u + 0.375, -1.25 * v + 0.0625), 20 * rounding);
    }
}

/* Any coordinates: some value within the image's, never a read beyond it. */
static void odd_coordinates_are_safe(void **state)
{
    (void)state;
    static const double odd[] = {0,     -0.0,   1,        -1,        0.1, 1 - 0x1p-53, -0x1p-60,    1e9, -1e9, 1e18,
                                 1e300, -1e300, INFINITY, -INFINITY, NAN, 0x1p-1074,   4294967296.5};
    for (uint32_t wrap = SCENE_WRAP_REPEAT; wrap <= SCENE_WRAP_CLAMP; wrap++) {
        const scene_texture_t texture = image_texture(wrap);
        const scene_t scene = gray_scene(&texture);
        for (size_t i = 0; i < sizeof odd / sizeof *odd; i++)
            for (size_t j = 0; j < sizeof odd / sizeof *odd; j++) {
                const double value = texture_scalar(&scene, 0, odd[i], odd[j]);
                if (!(value >= 0 && value <= 1 + rounding))
                    fail_msg("%g at (%g, %g)", value, odd[i], odd[j]);
            }
    }
}

static scene_t one_texel(const scene_texture_t *texture, scene_image_t *image, const void *texel, uint32_t channels,
                         uint32_t kind)
{
    *image = (scene_image_t){.width = 1, .height = 1, .channels = channels, .texel = kind};
    return (scene_t){.textures = texture, .texture_count = 1, .images = image, .image_count = 1, .texels = texel};
}

/* Encoding what was decoded gives the code back (IEC 61966-2-1). */
static void srgb_codes_are_decoded_and_alpha_is_not(void **state)
{
    (void)state;
    scene_texture_t texture = image_texture(SCENE_WRAP_REPEAT);
    for (int code = 0; code < 256; code++) {
        const uint8_t texel[4] = {(uint8_t)code, (uint8_t)(255 - code), 128, (uint8_t)code};
        scene_image_t image;
        scene_t scene = one_texel(&texture, &image, texel, 4, SCENE_TEXEL_SRGB8);
        texture.alpha_channel = 0;
        const rgb_t c = texture_color(&scene, 0, 0.3, 0.7);
        const double encoded = c.r <= 0.0031308 ? 12.92 * c.r : 1.055 * pow(c.r, 1 / 2.4) - 0.055;
        /* The standard's two thresholds are rounded to 8 decimals: both branches agree there within 1e-7. */
        assert_near(encoded, code / 255.0, 1e-7);
        assert_near(texture_scalar(&scene, 0, 0, 0), (c.r + c.g + c.b) / 3, rounding);
        texture.alpha_channel = 1;
        assert_near(texture_scalar(&scene, 0, 0, 0), code / 255.0, rounding);
        scene = one_texel(&texture, &image, texel, 4, SCENE_TEXEL_LINEAR8);
        assert_color(texture_color(&scene, 0, 0.3, 0.7), code / 255.0, 1 - code / 255.0, 128 / 255.0);
    }
}

static void values_scale_and_invert(void **state)
{
    (void)state;
    const float texel[3] = {0.25f, 0.5f, 1.5f};
    scene_texture_t texture = image_texture(SCENE_WRAP_REPEAT);
    scene_image_t image;
    const scene_t scene = one_texel(&texture, &image, texel, 3, SCENE_TEXEL_FLOAT32);
    texture.value[0] = 0.5f;
    texture.value[1] = 0.25f;
    texture.value[2] = 2.0f;
    assert_color(texture_color(&scene, 0, 0.1, 0.2), 0.125, 0.125, 3);
    assert_near(texture_scalar(&scene, 0, 0.1, 0.2), 0.5 * 0.75, rounding);
    texture.invert = 1;
    assert_color(texture_color(&scene, 0, 0.1, 0.2), 0.875, 0.875, 0); /* never below 0 */
    assert_near(texture_scalar(&scene, 0, 0.1, 0.2), 1 - 0.5 * 0.75, rounding);
}

/* ---- the other kinds ---- */

static void operands_combine_as_documented(void **state)
{
    (void)state;
    const scene_texture_t textures[] = {
        {.kind = SCENE_TEXTURE_CONSTANT, .value = {0.25f, 0.5f, 0.75f}},
        {.kind = SCENE_TEXTURE_SCALE, .value = {2, 1, 0.5f}, .a = param(0.5f, 0), .b = param(0.25f, 0)},
        {.kind = SCENE_TEXTURE_MIX, .a = param(1, 0), .b = param(0.125f, SCENE_NONE), .m = param(1, 0)},
    };
    const scene_t scene = {.textures = textures, .texture_count = 3};
    assert_color(texture_color(&scene, 0, 3, 4), 0.25, 0.5, 0.75);
    assert_near(texture_scalar(&scene, 0, 3, 4), 0.25, 0);
    assert_color(texture_color(&scene, 1, 3, 4), 2 * 0.125 * 0.0625, 0.25 * 0.125, 0.5 * 0.375 * 0.1875);
    assert_near(texture_scalar(&scene, 1, 3, 4), 2 * 0.125 * 0.0625, rounding);
    /* m is the scalar 0.25 */
    assert_color(texture_color(&scene, 2, 3, 4), 0.75 * 0.25 + 0.25 * 0.125, 0.75 * 0.5 + 0.25 * 0.125,
                 0.75 * 0.75 + 0.25 * 0.125);
    assert_near(texture_scalar(&scene, 2, 3, 4), 0.75 * 0.25 + 0.25 * 0.125, rounding);
}

static void checkerboards_alternate_on_both_sides_of_zero(void **state)
{
    (void)state;
    const scene_texture_t texture = {.kind = SCENE_TEXTURE_CHECKERBOARD,
                                     .scale_u = 2,
                                     .scale_v = 1,
                                     .offset_v = 0.5f,
                                     .a = param(0.25f, SCENE_NONE),
                                     .b = param(0.75f, SCENE_NONE)};
    const scene_t scene = {.textures = &texture, .texture_count = 1};
    for (int i = -5; i < 5; i++) {
        for (int j = -5; j < 5; j++) {
            const double u = (i + 0.3) / 2, v = j + 0.7 - 0.5; /* in square (i, j) */
            const double expected = (i + j) % 2 == 0 ? 0.25 : 0.75;
            assert_near(texture_scalar(&scene, 0, u, v), expected, 0);
            assert_color(texture_color(&scene, 0, u, v), expected, expected, expected);
        }
    }
}

static void parameters_multiply_their_texture(void **state)
{
    (void)state;
    const scene_texture_t texture = {.kind = SCENE_TEXTURE_CONSTANT, .value = {0.5f, 0.25f, 0.125f}};
    const scene_t scene = {.textures = &texture, .texture_count = 1};
    const scene_param_t plain = {{0.5f, 0.75f, 1}, SCENE_NONE}, textured = {{0.5f, 0.75f, 1}, 0};
    assert_color(texture_param_color(&scene, &plain, 0, 0), 0.5, 0.75, 1);
    assert_color(texture_param_color(&scene, &textured, 0, 0), 0.25, 0.1875, 0.125);
    assert_near(texture_param_scalar(&scene, &plain, 0, 0), 0.5, 0);
    assert_near(texture_param_scalar(&scene, &textured, 0, 0), 0.25, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_are_filtered_by_a_tent_in_every_wrap_mode),
        cmocka_unit_test(texel_centres_give_texels_and_v_goes_up),
        cmocka_unit_test(coordinates_are_scaled_and_shifted),
        cmocka_unit_test(odd_coordinates_are_safe),
        cmocka_unit_test(srgb_codes_are_decoded_and_alpha_is_not),
        cmocka_unit_test(values_scale_and_invert),
        cmocka_unit_test(operands_combine_as_documented),
        cmocka_unit_test(checkerboards_alternate_on_both_sides_of_zero),
        cmocka_unit_test(parameters_multiply_their_texture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
