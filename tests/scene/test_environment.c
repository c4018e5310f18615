/* Infinite lights with images: fold, filter, table, densities, inverses; and the texel fetch below them. */
#include "scene/light_scene.h"

#include "math/warp.h"
#include "scene/environment.h"
#include "scene/texel.h"

/* A rotation by thirds, mirrored on request: rows of the matrix world -> light. */
static void fill_environment(light_scene_t *s, uint32_t side, bool mirror, uint64_t seed)
{
    light_scene_init(s);
    light_scene_round(s, SCENE_SHAPE_SPHERE, SCENE_NONE, vec3(1, 2, 3), 2, vec3(0, 0, 1));
    scene_light_t *light = light_scene_add(s, SCENE_LIGHT_INFINITE, 0.5f, 1, 2);
    const float rows[9] = {2.f / 7, 3.f / 7, 6.f / 7, 6.f / 7, 2.f / 7, -3.f / 7, -3.f / 7, 6.f / 7, -2.f / 7};
    memcpy(light->to_light, rows, sizeof rows);
    for (int i = 0; mirror && i < 3; i++)
        light->to_light[i] = -light->to_light[i];
    light->image = 0;
    s->image = (scene_image_t){.width = side, .height = side, .channels = 3, .texel = SCENE_TEXEL_FLOAT32};
    s->scene.image_count = 1;
    stream_t stream = stream_of(seed);
    for (uint32_t i = 0; i < 3 * side * side; i++) {
        const double value = stream_number(&stream);
        s->texels[i] = stream_number(&stream) < 0.2 ? (float)(20 * value) : (float)(0.5 * value);
    }
}

static void one_texel(light_scene_t *s, uint32_t side, uint32_t x, uint32_t y)
{
    memset(s->texels, 0, sizeof s->texels);
    for (int c = 0; c < 3; c++)
        s->texels[3 * (y * side + x) + (uint32_t)c] = 1;
}

/* Density and luminance, integrated over the sphere by a rule in polar coordinates, which the map doesn't know. */
static void densities_integrate_to_one(void **state)
{
    (void)state;
    enum { ROWS = 500, COLUMNS = 1000 };
    for (int mirror = 0; mirror < 2; mirror++) {
        light_scene_t s;
        light_set_t set;
        fill_environment(&s, 16, mirror, 1);
        light_scene_set(&set, &s);
        assert_int_equal(set.count, 1);
        double density = 0, luminance = 0;
        for (int j = 0; j < ROWS; j++)
            for (int i = 0; i < COLUMNS; i++) {
                const double z = 1 - 2 * (j + 0.5) / ROWS, phi = 2 * MATH_PI * (i + 0.5) / COLUMNS,
                             r = sqrt(1 - z * z);
                double pdf;
                luminance += rgb_luminance(
                    light_infinite_radiance(&set, &s.scene, 0, vec3(r * cos(phi), r * sin(phi), z), &pdf));
                density += pdf;
            }
        const double cell = 4 * MATH_PI / (ROWS * COLUMNS);
        /* the density jumps at the table's 16 + 16 borders, each crossed by some 1000 points whose cells are wrong
         * by up to half a jump, signs at random: sqrt(32000) / 2 of 500 000 values of about one is 2e-4; the bright
         * texels' are ten times the mean */
        assert_near(density * cell, 1, 3e-3);
        const double disk = MATH_PI * set.scene_radius * set.scene_radius;
        assert_near(luminance * cell * disk / set.selection.sum, 1, 1e-3); /* radiance is continuous */
        light_set_clear(&set);
    }
}

/* Counts in cells of polar coordinates against the density integrated over them. */
static void directions_have_their_density(void **state)
{
    (void)state;
    enum { SAMPLES = 200000, ROWS = 12, COLUMNS = 24, FINE = 40 };
    light_scene_t s;
    light_set_t set;
    fill_environment(&s, 8, false, 2);
    light_scene_set(&set, &s);
    double counts[ROWS * COLUMNS] = {0}, expected[ROWS * COLUMNS] = {0}, total = 0;
    for (int j = 0; j < ROWS * FINE; j++)
        for (int i = 0; i < COLUMNS * FINE; i++) {
            const double z = 1 - 2 * (j + 0.5) / (ROWS * FINE), phi = 2 * MATH_PI * (i + 0.5) / (COLUMNS * FINE),
                         r = sqrt(1 - z * z);
            double pdf;
            light_infinite_radiance(&set, &s.scene, 0, vec3(r * cos(phi), r * sin(phi), z), &pdf);
            expected[j / FINE * COLUMNS + i / FINE] += pdf;
            total += pdf;
        }
    for (int i = 0; i < ROWS * COLUMNS; i++)
        expected[i] *= SAMPLES / total;
    stream_t stream = stream_of(3);
    for (int i = 0; i < SAMPLES; i++) {
        const double u[2] = {stream_number(&stream), stream_number(&stream)};
        light_sample_t at;
        assert_true(light_sample_position(&set, &s.scene, 0.5, u, &at));
        double phi = atan2(at.to_light.y, at.to_light.x) / (2 * MATH_PI);
        phi = phi < 0 ? phi + 1 : phi;
        const int row = (int)fmin((1 - at.to_light.z) * 0.5 * ROWS, ROWS - 1);
        counts[row * COLUMNS + (int)fmin(phi * COLUMNS, COLUMNS - 1)]++;
    }
    /* the integrals' own error, 1e-3 of a cell, adds 700 * 1e-6 to chi-square: nothing beside its 287 */
    assert_distribution("environment", counts, expected, ROWS * COLUMNS);
    light_set_clear(&set);
}

static void directions_come_back(void **state)
{
    (void)state;
    static const double ends[] = {0, 0x1p-53, 0.5, 1 - 0x1p-52, MATH_ONE_MINUS};
    for (uint32_t side = 1; side <= 32; side = 2 * side + side % 3) {
        light_scene_t s;
        light_set_t set;
        fill_environment(&s, side, side % 2, 4);
        light_scene_set(&set, &s);
        stream_t stream = stream_of(5);
        for (int i = 0; i < 5025; i++) {
            double u[2] = {stream_number(&stream), stream_number(&stream)}, v[2], select, pdf;
            if (i < 25) {
                u[0] = ends[i / 5];
                u[1] = ends[i % 5];
            }
            light_sample_t at, again;
            assert_true(light_sample_position(&set, &s.scene, 0.5, u, &at));
            assert_near(vec3_length(at.to_light), 1, 1e-15);
            light_infinite_radiance(&set, &s.scene, 0, at.to_light, &pdf);
            const double free_numbers[3] = {0.3, 0.1, 0.1};
            assert_true(light_invert_position(&set, &s.scene, &at, free_numbers, &select, v));
            assert_unit_interval(v[0]);
            assert_unit_interval(v[1]);
            assert_true(light_sample_position(&set, &s.scene, select, v, &again));
            /* cells have probabilities above 1e-5: 1e-16 / 1e-5 of a cell at worst */
            assert_vec3_near(again.to_light, at.to_light, 2e-11);
            if (i >= 25) /* within a cell; at a border either is right */
                assert_near(pdf / at.pdf, 1, 1e-14);
        }
        light_set_clear(&set);
    }
}

static void jacobian_is_the_inverse_density(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    fill_environment(&s, 8, true, 6);
    light_scene_set(&set, &s);
    stream_t stream = stream_of(7);
    int tested = 0;
    for (int i = 0; i < 4000; i++) {
        const double h = 1e-7, u[2] = {stream_number(&stream), stream_number(&stream)};
        light_sample_t middle, near[4];
        light_sample_position(&set, &s.scene, 0.5, u, &middle);
        bool same = true;
        for (int k = 0; k < 4; k++) {
            double v[2] = {u[0], u[1]};
            v[k / 2] =
                warp_clamp_unit(v[k / 2] + (k % 2 ? 50 * h : -50 * h)); /* stay off cells' borders and creases */
            light_sample_position(&set, &s.scene, 0.5, v, &near[k]);
            same = same && near[k].pdf == middle.pdf;
            v[k / 2] = warp_clamp_unit(u[k / 2] + (k % 2 ? h : -h));
            light_sample_position(&set, &s.scene, 0.5, v, &near[k]);
        }
        const light_emitter_t *e = &set.emitters[0];
        const vec3_t local = vec3(vec3_dot(e->edge1, middle.to_light), vec3_dot(e->edge2, middle.to_light),
                                  vec3_dot(e->normal, middle.to_light));
        if (!same || fabs(local.z) < 0.02 || fabs(local.x) < 0.02 || fabs(local.y) < 0.02)
            continue;
        const vec3_t d1 = vec3_sub(near[1].to_light, near[0].to_light),
                     d2 = vec3_sub(near[3].to_light, near[2].to_light);
        /* 1e-16 / h of rounding, over a Jacobian of at least 1e-2 of the sphere's */
        assert_near(vec3_length(vec3_cross(d1, d2)) / (4 * h * h) * middle.pdf, 1, 1e-5);
        tested++;
    }
    assert_true(tested > 2000);
    light_set_clear(&set);
}

/* Wherever there is radiance there is a density: images of one bright texel, in the middle, at an edge, in a
 * corner. */
static void density_covers_the_radiance(void **state)
{
    (void)state;
    enum { SIDE = 8 };
    static const uint32_t places[][2] = {{3, 4}, {0, 2}, {7, 5}, {1, 0}, {0, 0}, {7, 7}};
    stream_t stream = stream_of(8);
    for (size_t p = 0; p < sizeof places / sizeof places[0]; p++) {
        light_scene_t s;
        light_set_t set;
        fill_environment(&s, SIDE, false, 9);
        one_texel(&s, SIDE, places[p][0], places[p][1]);
        light_scene_set(&set, &s);
        int lit = 0;
        for (int i = 0; i < 20000; i++) {
            double pdf;
            const vec3_t w = stream_direction(&stream);
            const rgb_t radiance = light_infinite_radiance(&set, &s.scene, 0, w, &pdf);
            assert_true(rgb_black(radiance) || pdf > 0);
            lit += !rgb_black(radiance);
            if (rgb_black(radiance)) {
                /* no such numbers, unless rounding puts the direction into a lit cell */
                const light_sample_t at = {.emitter = 0, .to_light = w};
                const double free_numbers[3] = {0, 0, 0};
                double select, u[2];
                assert_true(light_invert_position(&set, &s.scene, &at, free_numbers, &select, u) == (pdf > 0));
            }
        }
        assert_true(lit > 20000 / (SIDE * SIDE)); /* a bilinear bump covers four texels */
        for (int i = 0; i < 2000; i++) {
            const double u[2] = {stream_number(&stream), stream_number(&stream)};
            light_sample_t at;
            double pdf;
            assert_true(light_sample_position(&set, &s.scene, 0.5, u, &at));
            light_infinite_radiance(&set, &s.scene, 0, at.to_light, &pdf);
            assert_near(pdf / at.pdf, 1, 1e-12);
        }
        light_set_clear(&set);
    }
}

/* Radiance at the middle of a texel is the texel's; across an edge of the square it doesn't jump. */
static void radiance_is_the_folded_bilinear_one(void **state)
{
    (void)state;
    enum { SIDE = 8 };
    light_scene_t s;
    fill_environment(&s, SIDE, false, 10);
    const rgb_t scale = {0.5, 1, 2};
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++) {
            const rgb_t found = environment_radiance(&s.scene, &s.image, scale, (x + 0.5) / SIDE, (y + 0.5) / SIDE);
            const float *texel = s.texels + 3 * (y * SIDE + x);
            assert_near(found.r, 0.5 * texel[0], 1e-14);
            assert_near(found.g, texel[1], 1e-14);
            assert_near(found.b, 2.0 * texel[2], 1e-14);
        }
    const float *a = s.texels + 3 * (2 * SIDE + 3), *b = a + 3, *c = a + 3 * SIDE, *d = c + 3;
    const rgb_t mixed = environment_radiance(&s.scene, &s.image, scale, (3.5 + 0.25) / SIDE, (2.5 + 0.75) / SIDE);
    assert_near(mixed.g, 0.1875 * a[1] + 0.0625 * b[1] + 0.5625 * c[1] + 0.1875 * d[1], 1e-14);
    stream_t stream = stream_of(11);
    for (int i = 0; i < 1000; i++) {
        const double t = stream_number(&stream), edge = i % 2 ? 1e-13 : 1 - 1e-13;
        const rgb_t one = environment_radiance(&s.scene, &s.image, scale, edge, t),
                    other = environment_radiance(&s.scene, &s.image, scale, edge, 1 - t),
                    third = environment_radiance(&s.scene, &s.image, scale, t, edge),
                    fourth = environment_radiance(&s.scene, &s.image, scale, 1 - t, edge);
        assert_near(one.g, other.g, 1e-10); /* 1e-13 of the square, 8 texels of up to 20 apart */
        assert_near(third.g, fourth.g, 1e-10);
    }
    s.texels[0] = -3;
    s.texels[1] = NAN;
    const rgb_t first = environment_radiance(&s.scene, &s.image, scale, 0.5 / SIDE, 0.5 / SIDE);
    assert_near(first.r, 0, 0);
    assert_near(first.g, 0, 0);
}

/* Mean luminance over a texel's area by the midpoint rule: exact, as the function is bilinear in each quarter and
 * no interval of the rule crosses their borders. */
static double cell_average(const scene_t *scene, const scene_image_t *image, rgb_t scale, int x, int y)
{
    enum { FINE = 20 };
    double sum = 0;
    for (int j = 0; j < FINE; j++)
        for (int i = 0; i < FINE; i++)
            sum += rgb_luminance(environment_radiance(scene, image, scale, (x + (i + 0.5) / FINE) / image->width,
                                                      (y + (j + 0.5) / FINE) / image->height));
    return sum / (FINE * FINE);
}

/* A cell's share is the integral of the bilinear luminance over it; also with fewer cells than
 * texels, not in a whole ratio. */
static void table_holds_the_cells_integrals(void **state)
{
    (void)state;
    enum { WIDTH = 2 * ENVIRONMENT_MAX_TABLE + 904, HEIGHT = 3 };
    uint8_t *texels = malloc(WIDTH * HEIGHT);
    assert_non_null(texels);
    stream_t stream = stream_of(12);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        texels[i] = stream_number(&stream) < 0.3 ? (uint8_t)(256 * stream_number(&stream)) : 0;
    const scene_image_t image = {.width = WIDTH, .height = HEIGHT, .channels = 1, .texel = SCENE_TEXEL_LINEAR8};
    const scene_t scene = {.texels = texels, .images = &image, .image_count = 1};
    table2_t table;
    double mean;
    assert_int_equal(environment_table(&scene, &image, rgb_gray(1), &table, &mean, NULL), FAULT_NONE);
    assert_int_equal(table.width, ENVIRONMENT_MAX_TABLE);
    assert_int_equal(table.height, HEIGHT);
    double texel_mean = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        texel_mean += texels[i] / 255.0 / (WIDTH * HEIGHT);
    assert_near(mean / texel_mean, 1, 1e-12); /* folded weights add up to one for each texel */
    for (int cell = 0; cell < ENVIRONMENT_MAX_TABLE; cell += 37) {
        /* texels by the area they share with the cell */
        const double begin = cell * (double)WIDTH / ENVIRONMENT_MAX_TABLE,
                     end = (cell + 1) * (double)WIDTH / ENVIRONMENT_MAX_TABLE;
        double sum = 0;
        for (int x = (int)begin; x < end; x++)
            sum += cell_average(&scene, &image, rgb_gray(1), x, 1) * (fmin(end, x + 1) - fmax(begin, x));
        const double pdf = table2_pdf(&table, (cell + 0.5) / ENVIRONMENT_MAX_TABLE, 0.5);
        assert_near(pdf * mean * (end - begin), sum, 1e-12);
    }
    table2_clear(&table);
    free(texels);

    /* as many cells as texels: exact */
    light_scene_t s;
    fill_environment(&s, 5, false, 13);
    assert_int_equal(environment_table(&s.scene, &s.image, rgb(0.5, 1, 2), &table, &mean, NULL), FAULT_NONE);
    for (int y = 0; y < 5; y++)
        for (int x = 0; x < 5; x++) {
            const double sum = cell_average(&s.scene, &s.image, rgb(0.5, 1, 2), x, y);
            assert_near(table2_pdf(&table, (x + 0.5) / 5, (y + 0.5) / 5) * mean / sum, 1, 1e-12);
        }
    table2_clear(&table);
}

static void black_images_are_no_light(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    fill_environment(&s, 4, false, 14);
    memset(s.texels, 0, sizeof s.texels);
    assert_int_equal(light_set_init(&set, &s.scene, NULL), FAULT_NO_LIGHT);
    s.texels[7] = INFINITY;
    fault_t fault = {0};
    assert_int_equal(light_set_init(&set, &s.scene, &fault), FAULT_RANGE);
    assert_non_null(strstr(fault.text, "light 0"));
    /* a second, constant one beside a black one takes the free place */
    s.texels[7] = 0;
    light_scene_add(&s, SCENE_LIGHT_INFINITE, 1, 1, 1);
    light_scene_set(&set, &s);
    assert_int_equal(set.count, 1);
    assert_int_equal(set.infinite_count, 1);
    double pdf;
    const rgb_t radiance = light_infinite_radiance(&set, &s.scene, set.infinite[0], vec3(0.6, 0, 0.8), &pdf);
    assert_near(radiance.r, 1, 0);
    assert_near(pdf, 1 / (4 * MATH_PI), 1e-16);
    light_set_clear(&set);
}

/* ---- texels ---- */

static void texels_decode(void **state)
{
    (void)state;
    for (int i = 0; i < 256; i++) { /* IEC 61966-2-1 */
        const double v = i / 255.0;
        assert_near(texel_srgb[i], v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4), 1e-15);
    }
    static const uint8_t bytes[16 + 8] = {[16] = 0, 128, 255, 51, 10, 20, 30, 102};
    scene_image_t image = {.offset = 16, .width = 2, .height = 1, .channels = 4, .texel = SCENE_TEXEL_SRGB8};
    const scene_t scene = {.texels = bytes};
    rgb_t c = texel_rgb(&scene, &image, 0, 0);
    assert_near(c.r, 0, 0);
    assert_near(c.g, texel_srgb[128], 0);
    assert_near(c.b, 1, 0);
    assert_near(texel_channel(&scene, &image, 1, 0, 3), 0.4, 1e-16); /* alpha is linear */
    image.texel = SCENE_TEXEL_LINEAR8;
    assert_near(texel_channel(&scene, &image, 1, 0, 2), 30 / 255.0, 1e-16);
    image = (scene_image_t){.offset = 16, .width = 4, .height = 2, .channels = 1, .texel = SCENE_TEXEL_LINEAR8};
    c = texel_rgb(&scene, &image, 3, 1);
    assert_near(c.r, 0.4, 1e-16);
    assert_near(c.b, 0.4, 1e-16);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(densities_integrate_to_one),
        cmocka_unit_test(directions_have_their_density),
        cmocka_unit_test(directions_come_back),
        cmocka_unit_test(jacobian_is_the_inverse_density),
        cmocka_unit_test(density_covers_the_radiance),
        cmocka_unit_test(radiance_is_the_folded_bilinear_one),
        cmocka_unit_test(table_holds_the_cells_integrals),
        cmocka_unit_test(black_images_are_no_light),
        cmocka_unit_test(texels_decode),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
