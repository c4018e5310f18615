/* The camera: importance, densities, inverse, film override, filters; matrices that scale, mirror and shear. */
#include "math/sampling.h"
#include "scene/camera.h"

#include <string.h>

enum { MATRIX_UPRIGHT, MATRIX_TURNED, MATRIX_MIRRORED, MATRIX_SHEARED, MATRIX_FAR, MATRICES };

/* Columns x, y, z and the origin. */
static void set_matrix(scene_camera_t *data, vec3_t x, vec3_t y, vec3_t z, vec3_t o)
{
    const double rows[12] = {x.x, y.x, z.x, o.x, x.y, y.y, z.y, o.y, x.z, y.z, z.z, o.z};
    memcpy(data->to_world, rows, sizeof rows);
}

static scene_camera_t camera_data(int matrix, bool lens, double filter_radius)
{
    scene_camera_t data = {.width = 64, .height = 48, .crop = {0, 64, 0, 48}, .imaging_scale = 2.385};
    const double tangent = 0.4; /* of half the shorter field of view */
    data.screen[0] = -tangent * 64 / 48;
    data.screen[1] = tangent * 64 / 48;
    data.screen[2] = -tangent;
    data.screen[3] = tangent;
    data.lens_radius = lens ? 0.05 : 0;
    data.focal_distance = 3.7;
    data.filter = SCENE_FILTER_BOX;
    data.filter_radius[0] = data.filter_radius[1] = filter_radius;
    data.filter_sigma = 0.5;
    const vec3_t a = vec3(2. / 7, 3. / 7, 6. / 7), b = vec3(6. / 7, 2. / 7, -3. / 7),
                 c = vec3(-3. / 7, 6. / 7, -2. / 7);
    switch (matrix) {
    case MATRIX_TURNED: /* and scaled */
        set_matrix(&data, vec3_scale(a, 2.5), vec3_scale(b, 2.5), vec3_scale(c, 2.5), vec3(1, -2, 3));
        break;
    case MATRIX_MIRRORED:
        set_matrix(&data, vec3_scale(a, -0.3), vec3_scale(b, 0.3), vec3_scale(c, 0.3), vec3(1, -2, 3));
        break;
    case MATRIX_SHEARED:
        set_matrix(&data, vec3(1.3, 0.2, 0), vec3(0.1, 0.7, -0.3), vec3(0.4, 0.3, 1.1), vec3(-1, 0.5, 0));
        break;
    case MATRIX_FAR:
        set_matrix(&data, a, b, c, vec3(1e5, -2e5, 3e5));
        break;
    default:
        set_matrix(&data, vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0, 0, 0));
        break;
    }
    return data;
}

static camera_t camera_of(const scene_camera_t *data, uint32_t width, uint32_t height)
{
    camera_t camera;
    fault_t fault = {0};
    if (camera_init(&camera, data, width, height, &fault))
        fail_msg("camera_init: %s", fault.text);
    return camera;
}

/* Rounding of a lens's point in world coordinates, relative to the distance at which it matters. */
static double world_rounding(const camera_t *camera, double over)
{
    return camera->pinhole ? 0 : 4 * 0x1p-53 * vec3_max_abs(camera->origin) / over;
}

/* The definition, from the scene's words, without the camera's own vectors: the point of camera space that raster
 * (x,y) looks at, and the lens's point, both through the matrix. */
static vec3_t transform(const scene_camera_t *data, vec3_t p, double w)
{
    const double *m = data->to_world;
    return vec3(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3] * w, m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7] * w,
                m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11] * w);
}

static vec3_t looked_at(const scene_camera_t *data, double x, double y, double distance)
{
    const double *s = data->screen;
    const vec3_t p = vec3(x / data->width * (s[1] - s[0]) + s[0], s[3] - y / data->height * (s[3] - s[2]), 1);
    return transform(data, vec3_scale(p, distance), 1);
}

static void rays_follow_the_definition(void **state)
{
    (void)state;
    stream_t stream = stream_of(1);
    for (int matrix = 0; matrix < MATRICES; matrix++)
        for (int lens = 0; lens < 2; lens++) {
            const scene_camera_t data = camera_data(matrix, lens, 0.5);
            const camera_t camera = camera_of(&data, 0, 0);
            for (int i = 0; i < 500; i++) {
                const double u[4] = {stream_number(&stream), stream_number(&stream), stream_number(&stream),
                                     stream_number(&stream)};
                camera_sample_t sample;
                camera_sample(&camera, u, u + 2, &sample);
                assert_near(sample.raster.x, 64 * u[0], 1e-13);
                assert_near(sample.raster.y, 48 * u[1], 1e-13);
                vec3_t point;
                const double pdf = camera_sample_lens(&camera, u + 2, &point);
                assert_near(pdf, sample.pdf_position, 0);
                assert_vec3_near(point, sample.origin, 0);
                const vec3_t focus = looked_at(&data, sample.raster.x, sample.raster.y, data.focal_distance);
                assert_vec3_near(sample.direction, vec3_unit(vec3_sub(focus, sample.origin)),
                                 1e-14 + 1e-15 * vec3_max_abs(camera.origin));
                if (!lens)
                    assert_vec3_near(sample.origin, camera.origin, 0);
            }
        }
}

/* Lens points: inside the matrix's image of the disk, uniform there (the squared radius in camera space is
 * uniform). */
static void lens_points_are_uniform(void **state)
{
    (void)state;
    enum { SAMPLES = 50000 };
    static double radii[SAMPLES], angles[SAMPLES];
    const scene_camera_t data = camera_data(MATRIX_TURNED, true, 0.5);
    const camera_t camera = camera_of(&data, 0, 0);
    assert_near(camera.lens_radius, 2.5 * 0.05, 1e-15);
    assert_near(camera.lens_area, MATH_PI * 0.125 * 0.125, 1e-15);
    assert_near(camera.focal_distance, 2.5 * 3.7, 1e-14);
    stream_t stream = stream_of(2);
    for (int i = 0; i < SAMPLES; i++) {
        const double u[2] = {stream_number(&stream), stream_number(&stream)};
        vec3_t point;
        camera_sample_lens(&camera, u, &point);
        const vec3_t d = vec3_sub(point, camera.origin);
        assert_near(vec3_dot(d, camera.forward), 0, 1e-15);
        radii[i] = vec3_dot(d, d) / (0.125 * 0.125);
        angles[i] = (atan2(vec3_dot(d, camera.right), vec3_dot(d, camera.down)) / MATH_PI + 1) / 2;
    }
    assert_uniform("lens radius", radii, SAMPLES);
    assert_uniform("lens angle", angles, SAMPLES);
}

/* What t = 1 needs: the value of a sampled ray is the sample's own. */
static void eval_agrees_with_sample(void **state)
{
    (void)state;
    stream_t stream = stream_of(3);
    for (int matrix = 0; matrix < MATRICES; matrix++)
        for (int lens = 0; lens < 2; lens++) {
            const scene_camera_t data = camera_data(matrix, lens, lens ? 1.5 : 0.5);
            const camera_t camera = camera_of(&data, 0, 0);
            for (int i = 0; i < 2000; i++) {
                const double u[4] = {stream_number(&stream), stream_number(&stream), stream_number(&stream),
                                     stream_number(&stream)};
                camera_sample_t sample;
                camera_sample(&camera, u, u + 2, &sample);
                camera_value_t value;
                assert_true(camera_eval(&camera, sample.origin, sample.direction, &value));
                const double far = 64 / 0.4 * world_rounding(&camera, camera.focal_distance);
                assert_near(value.raster.x, sample.raster.x, 1e-11 + far);
                assert_near(value.raster.y, sample.raster.y, 1e-11 + far);
                assert_near(value.pdf_direction / sample.pdf_direction, 1, 1e-13);
                const double cosine = vec3_dot(sample.direction, camera.forward);
                assert_near(value.importance * cosine / (sample.pdf_position * sample.pdf_direction) /
                                sample.weight,
                            1, 1e-12);
                assert_near(sample.weight, camera.raster_w * camera.raster_h * data.imaging_scale, 1e-9);
            }
        }
}

/* The density by geometry: the solid angle of a small patch of the raster, from rays at its corners. A
 * quadrilateral of side h is flat and straight on the plane; the solid angle of its triangles after Van Oosterom
 * and Strackee 1983. */
static double solid_angle(vec3_t a, vec3_t b, vec3_t c)
{
    const double triple = vec3_dot(a, vec3_cross(b, c));
    return 2 * atan2(fabs(triple), 1 + vec3_dot(a, b) + vec3_dot(b, c) + vec3_dot(c, a));
}

static vec3_t direction_of(const camera_t *camera, double u, double v, const double lens[2])
{
    const double film[2] = {u, v};
    camera_sample_t sample;
    camera_sample(camera, film, lens, &sample);
    return sample.direction;
}

static void density_is_the_inverse_solid_angle(void **state)
{
    (void)state;
    const double h = 1e-4; /* the density changes by h^2 over it, symmetric about the middle */
    stream_t stream = stream_of(4);
    for (int matrix = 0; matrix < MATRICES; matrix++)
        for (int lens = 0; lens < 2; lens++) {
            const scene_camera_t data = camera_data(matrix, lens, 0.5);
            const camera_t camera = camera_of(&data, 0, 0);
            for (int i = 0; i < 200; i++) {
                const double u = 0.01 + 0.98 * stream_number(&stream), v = 0.01 + 0.98 * stream_number(&stream);
                const double p[2] = {stream_number(&stream), stream_number(&stream)};
                const vec3_t a = direction_of(&camera, u - h, v - h, p), b = direction_of(&camera, u + h, v - h, p),
                             c = direction_of(&camera, u + h, v + h, p), d = direction_of(&camera, u - h, v + h, p);
                const double patch = solid_angle(a, b, c) + solid_angle(a, c, d);
                camera_sample_t sample;
                const double film[2] = {u, v};
                camera_sample(&camera, film, p, &sample);
                assert_near(sample.pdf_direction * patch / (4 * h * h), 1, 1e-6);
            }
        }
}

/* Integral of W cos over all directions from a lens point, by directions that don't come from the camera: uniform
 * in a cone around forward that holds the film, in strata. Equals the film's pixels * scale (/ lens area). */
static void importance_integrates_to_the_number_of_pixels(void **state)
{
    (void)state;
    enum { SIDE = 1000 };
    const double cos_cone = 0.75; /* the film's corner has tan 0.667 + the lens's slant: cos 0.83 */
    for (int matrix = 0; matrix < MATRICES; matrix++)
        for (int lens = 0; lens < 2; lens++) {
            if (matrix == MATRIX_SHEARED)
                continue; /* its film lies elsewhere; the solid angles above cover it */
            const scene_camera_t data = camera_data(matrix, lens, 1.5);
            const camera_t camera = camera_of(&data, 0, 0);
            const double place[2] = {0.9, 0.3};
            vec3_t origin;
            camera_sample_lens(&camera, place, &origin);
            stream_t stream = stream_of(5);
            double sum = 0, density = 0;
            for (int j = 0; j < SIDE; j++)
                for (int i = 0; i < SIDE; i++) {
                    const double z = 1 - (1 - cos_cone) * (j + stream_number(&stream)) / SIDE,
                                 phi = 2 * MATH_PI * (i + stream_number(&stream)) / SIDE;
                    const double r = sqrt(1 - z * z);
                    vec3_t w = vec3_scale(camera.forward, z);
                    w = vec3_mad(vec3_mad(w, r * cos(phi), camera.right), r * sin(phi), camera.down);
                    camera_value_t value;
                    if (!camera_eval(&camera, origin, w, &value))
                        continue;
                    sum += value.importance * z;
                    density += value.pdf_direction;
                }
            const double cell = 2 * MATH_PI * (1 - cos_cone) / ((double)SIDE * SIDE);
            const double pixels = (64 + 2) * (48 + 2) * data.imaging_scale / camera.lens_area;
            /* strata cut by the film's edge: about 5000 of a million, each wrong by half its value at random:
             * sqrt(5000)/2 of 300 000 cells inside, 1.2e-4; six times that */
            assert_near(sum * cell / pixels, 1, 7e-4);
            assert_near(density * cell, 1, 7e-4);
        }
}

static void rays_come_back(void **state)
{
    (void)state;
    static const double ends[] = {0, 0x1p-53, 0.5, 1 - 0x1p-52, MATH_ONE_MINUS};
    const double free_numbers[2] = {0.125, 0.625};
    stream_t stream = stream_of(6);
    for (int matrix = 0; matrix < MATRICES; matrix++)
        for (int lens = 0; lens < 2; lens++) {
            const scene_camera_t data = camera_data(matrix, lens, 1);
            const camera_t camera = camera_of(&data, 0, 0);
            for (int i = 0; i < 3000; i++) {
                double u[4], film[2], place[2];
                for (int k = 0; k < 4; k++) /* the first 625: all combinations of the ends */
                    u[k] = i < 625 ? ends[i / (int)pow(5, k) % 5] : stream_number(&stream);
                camera_sample_t sample, again;
                camera_sample(&camera, u, u + 2, &sample);
                if (matrix == MATRIX_FAR && lens && i < 625)
                    continue; /* the lens's rounding exceeds the slack at the film's edge */
                assert_true(camera_invert(&camera, sample.origin, sample.direction, free_numbers, film, place));
                for (int k = 0; k < 2; k++) {
                    assert_unit_interval(film[k]);
                    assert_unit_interval(place[k]);
                    assert_near(film[k], u[k], 1e-13 + 4 * world_rounding(&camera, camera.focal_distance));
                    if (!lens)
                        assert_near(place[k], free_numbers[k], 0);
                }
                camera_sample(&camera, film, place, &again);
                const double coordinate = vec3_max_abs(camera.origin);
                assert_vec3_near(again.origin, sample.origin, 1e-15 + 4e-16 * coordinate);
                assert_vec3_near(again.direction, sample.direction, 1e-14 + 2e-15 * coordinate);
            }
        }
}

static void rays_beside_the_film_are_refused(void **state)
{
    (void)state;
    const scene_camera_t data = camera_data(MATRIX_TURNED, false, 1);
    const camera_t camera = camera_of(&data, 0, 0);
    camera_value_t value;
    for (int side = 0; side < 8; side++) {
        const double out = side & 4 ? 0.51 : 0.49; /* the domain ends half a pixel beyond the film */
        const double x = side & 1 ? 64 + out : -out, y = side & 2 ? 30 : 10;
        const bool across = side & 2;
        const double px = across ? 20 : x, py = across ? (side & 1 ? 48 + out : -out) : y;
        const vec3_t w = vec3_unit(vec3_sub(looked_at(&data, px, py, 1), camera.origin));
        assert_int_equal(camera_eval(&camera, camera.origin, w, &value), !(side & 4));
    }
    double film[2], lens[2];
    const double free_numbers[2] = {0, 0};
    assert_false(camera_eval(&camera, camera.origin, vec3_neg(camera.forward), &value));
    assert_false(camera_eval(&camera, camera.origin, camera.right, &value));
    assert_false(camera_eval(&camera, camera.origin, vec3(NAN, 0, 0), &value));
    assert_false(camera_invert(&camera, camera.origin, vec3_neg(camera.forward), free_numbers, film, lens));
}

/* ---- the film ---- */

static void crop_is_a_window_on_the_same_image(void **state)
{
    (void)state;
    scene_camera_t data = camera_data(MATRIX_TURNED, false, 0.5);
    const uint32_t crop[4] = {10, 31, 5, 40};
    memcpy(data.crop, crop, sizeof crop);
    const camera_t camera = camera_of(&data, 0, 0);
    assert_int_equal(camera.width, 21);
    assert_int_equal(camera.height, 35);
    const double film[2] = {0.25, 0.75}, lens[2] = {0, 0};
    camera_sample_t sample;
    camera_sample(&camera, film, lens, &sample);
    const vec3_t at = looked_at(&data, 10 + 0.25 * 21, 5 + 0.75 * 35, 1);
    assert_vec3_near(sample.direction, vec3_unit(vec3_sub(at, camera.origin)), 1e-14);
}

static double extent_x(const camera_t *camera)
{
    return vec3_length(camera->dx) * camera->width;
}
static double extent_y(const camera_t *camera)
{
    return vec3_length(camera->dy) * camera->height;
}

static void override_keeps_the_shorter_extent(void **state)
{
    (void)state;
    const scene_camera_t data = camera_data(MATRIX_TURNED, false, 0.5);
    static const uint32_t sizes[][2] = {{32, 24}, {640, 480}, {100, 50}, {50, 100}, {77, 77}, {0, 24}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        const camera_t camera = camera_of(&data, sizes[i][0], sizes[i][1]);
        assert_int_equal(camera.width, sizes[i][0] ? sizes[i][0] : 64);
        assert_int_equal(camera.height, sizes[i][1]);
        assert_near(fmin(extent_x(&camera), extent_y(&camera)), 0.8, 1e-14);
        assert_near(extent_x(&camera) / extent_y(&camera), (double)camera.width / camera.height, 1e-14);
        /* the middle of the film still looks along the axis */
        const double film[2] = {0.5, 0.5}, lens[2] = {0, 0};
        camera_sample_t sample;
        camera_sample(&camera, film, lens, &sample);
        assert_vec3_near(sample.direction, camera.forward, 1e-15);
    }
}

static void override_keeps_pixel_shape_and_crop(void **state)
{
    (void)state;
    scene_camera_t data = camera_data(MATRIX_UPRIGHT, false, 0.5);
    data.screen[0] *= 1.5; /* pixels 1.5 times as wide as high */
    data.screen[1] *= 1.5;
    const uint32_t crop[4] = {16, 48, 12, 36};
    memcpy(data.crop, crop, sizeof crop);
    camera_t camera = camera_of(&data, 32, 48);
    assert_near(vec3_length(camera.dx) / vec3_length(camera.dy), 1.5, 1e-14);
    assert_int_equal(camera.width, 16);
    assert_int_equal(camera.height, 24);
    camera = camera_of(&data, 128, 96);
    assert_int_equal(camera.width, 64);
    assert_int_equal(camera.height, 48);
    assert_near(extent_x(&camera), 0.5 * 0.8 * 64 / 48 * 1.5, 1e-14);
    camera = camera_of(&data, 1, 1); /* a crop never loses its last pixel */
    assert_int_equal(camera.width, 1);
    assert_int_equal(camera.height, 1);
}

/* ---- filters ---- */

/* The scene's filter as scene.h words it, normalised by the midpoint rule: the second way. */
static double raw_filter(uint32_t filter, double radius, double sigma, double x)
{
    x = fabs(x);
    if (x >= radius)
        return 0;
    if (filter == SCENE_FILTER_TRIANGLE)
        return radius - x;
    if (filter == SCENE_FILTER_GAUSSIAN)
        return exp(-x * x / (2 * sigma * sigma)) - exp(-radius * radius / (2 * sigma * sigma));
    return 1;
}

static double normalised_filter(uint32_t filter, double radius, double sigma, double x)
{
    const int steps = 2000;
    double sum = 0;
    for (int i = 0; i < steps; i++)
        sum += raw_filter(filter, radius, sigma, radius * ((i + 0.5) / steps));
    return raw_filter(filter, radius, sigma, x) / (2 * sum * radius / steps);
}

/* For splats at x: the share that lands on pixel j, times the weight, is f(x - c_j). Shares by regular u. */
static void check_filter(uint32_t filter, double radius, double sigma, double tolerance)
{
    enum { STEPS = 20000 };
    scene_camera_t data = camera_data(MATRIX_UPRIGHT, false, radius);
    data.filter = filter;
    data.filter_sigma = sigma;
    const camera_t camera = camera_of(&data, 0, 0);
    assert_near(camera.raster_x0, -fmax(radius - 0.5, 0), 1e-15);
    assert_near(camera.raster_w, 64 + 2 * fmax(radius - 0.5, 0), 1e-13);
    stream_t stream = stream_of(7);
    for (int place = 0; place < 12; place++) {
        const vec2_t at = {20 + stream_number(&stream), 20.5};
        const vec2_t middle = {20.5, at.x}; /* the y axis, the same */
        double share[41] = {0};
        for (int i = 0; i < STEPS; i++) {
            const vec2_t offset = camera_filter_offset(&camera, (i + 0.5) / STEPS, 0.5);
            assert_true(fabs(offset.x) <= fmax(radius - 0.5, 0));
            share[(int)floor(at.x + offset.x)] += 1.0 / STEPS;
        }
        const double along_y = camera_filter_weight(&camera, (vec2_t){20.5, 20.5});
        assert_near(camera_filter_weight(&camera, at), camera_filter_weight(&camera, middle), 1e-14);
        const double weight = camera_filter_weight(&camera, at) / sqrt(along_y);
        for (int j = 0; j < 41; j++)
            assert_near(share[j] * weight, normalised_filter(filter, radius, sigma, at.x - (j + 0.5)), tolerance);
    }
}

static void splats_follow_the_filter(void **state)
{
    (void)state;
    /* 1/STEPS of counting; the table's linear steps of the distribution function, second derivative up to 5:
     * (2/256)^2 / 8 * 5; the normalisation's midpoint rule */
    const double tolerance = 2e-4;
    check_filter(SCENE_FILTER_BOX, 0.5, 0, tolerance);
    check_filter(SCENE_FILTER_TRIANGLE, 1, 0, tolerance);
    check_filter(SCENE_FILTER_TRIANGLE, 2, 0, 2 * tolerance);
    check_filter(SCENE_FILTER_TRIANGLE, 1.3, 0, tolerance);
    check_filter(SCENE_FILTER_GAUSSIAN, 1.5, 0.5, tolerance);
    check_filter(SCENE_FILTER_GAUSSIAN, 2, 0.8, 2 * tolerance);
    check_filter(SCENE_FILTER_GAUSSIAN, 1.5, 300, 2 * tolerance);
    /* boxes are exact off the steps' smear */
    check_filter(SCENE_FILTER_BOX, 1, 0, tolerance);
    check_filter(SCENE_FILTER_BOX, 1.5, 0, tolerance);
}

static void filters_inside_a_pixel_need_no_offset(void **state)
{
    (void)state;
    scene_camera_t data = camera_data(MATRIX_UPRIGHT, false, 0.25);
    camera_t camera = camera_of(&data, 0, 0);
    assert_false(camera.filter_is_box);
    const vec2_t offset = camera_filter_offset(&camera, 0.9, 0.1);
    assert_near(offset.x, 0, 0);
    assert_near(offset.y, 0, 0);
    assert_near(camera_filter_weight(&camera, (vec2_t){3.5, 7.6}), 4, 1e-15);
    assert_near(camera_filter_weight(&camera, (vec2_t){3.5, 7.9}), 0, 0);
    data = camera_data(MATRIX_UPRIGHT, false, 0.5);
    camera = camera_of(&data, 0, 0);
    assert_true(camera.filter_is_box);
    assert_near(camera_filter_weight(&camera, (vec2_t){3.5, 7.9}), 1, 0);
    /* a Gaussian that is a point: every splat to the nearest pixel centre's pixel */
    data = camera_data(MATRIX_UPRIGHT, false, 1.5);
    data.filter = SCENE_FILTER_GAUSSIAN;
    data.filter_sigma = 0.002;
    camera = camera_of(&data, 0, 0);
    for (int i = 1; i < 100; i++)
        assert_true(fabs(camera_filter_offset(&camera, i / 100.0, 0.5).x) < 0.02);
}

/* A constant image: the filter's average weight is one, as its integral is. */
static void filter_weights_average_to_one(void **state)
{
    (void)state;
    scene_camera_t data = camera_data(MATRIX_UPRIGHT, false, 1.5);
    data.filter = SCENE_FILTER_GAUSSIAN;
    const camera_t camera = camera_of(&data, 0, 0);
    double sum = 0, worst = 0;
    for (int i = 0; i < 1000; i++) {
        const double weight =
            camera_filter_weight(&camera, (vec2_t){5 + (i + 0.5) / 1000, 5 + (i * 37 % 1000) / 1000.});
        sum += weight;
        worst = fmax(worst, fabs(weight - 1));
    }
    assert_near(sum / 1000, 1, 1e-3);
    assert_true(worst > 1e-3 && worst < 0.06);
}

/* ---- refusals ---- */

static void bad_cameras_are_refused(void **state)
{
    (void)state;
    for (int i = 0; i < 14; i++) {
        scene_camera_t data = camera_data(MATRIX_TURNED, true, 1);
        uint32_t width = 0;
        switch (i) {
        case 0:
            data.width = 0;
            break;
        case 1:
            width = SCENE_MAX_FILM_SIZE + 1;
            break;
        case 2:
            data.crop[1] = data.crop[0];
            break;
        case 3:
            data.crop[3] = data.height + 1;
            break;
        case 4:
            data.screen[1] = data.screen[0];
            break;
        case 5:
            data.screen[2] = NAN;
            break;
        case 6:
            data.lens_radius = -1;
            break;
        case 7:
            data.focal_distance = 0;
            break;
        case 8:
            data.imaging_scale = INFINITY;
            break;
        case 9:
            memset(data.to_world, 0, sizeof data.to_world);
            break;
        case 10:
            data.to_world[5] = NAN;
            break;
        case 11:
            data.filter = SCENE_FILTER_KINDS;
            break;
        case 12:
            data.filter_radius[1] = 0;
            break;
        default:
            data.filter = SCENE_FILTER_GAUSSIAN;
            data.filter_sigma = 0;
            break;
        }
        camera_t camera;
        fault_t fault = {0};
        assert_int_equal(camera_init(&camera, &data, width, 0, &fault), FAULT_RANGE);
        assert_true(strncmp(fault.text, "camera: ", 8) == 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_follow_the_definition),
        cmocka_unit_test(lens_points_are_uniform),
        cmocka_unit_test(eval_agrees_with_sample),
        cmocka_unit_test(density_is_the_inverse_solid_angle),
        cmocka_unit_test(importance_integrates_to_the_number_of_pixels),
        cmocka_unit_test(rays_come_back),
        cmocka_unit_test(rays_beside_the_film_are_refused),
        cmocka_unit_test(crop_is_a_window_on_the_same_image),
        cmocka_unit_test(override_keeps_the_shorter_extent),
        cmocka_unit_test(override_keeps_pixel_shape_and_crop),
        cmocka_unit_test(splats_follow_the_filter),
        cmocka_unit_test(filters_inside_a_pixel_need_no_offset),
        cmocka_unit_test(filter_weights_average_to_one),
        cmocka_unit_test(bad_cameras_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
