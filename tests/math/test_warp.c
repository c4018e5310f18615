/* Warps: values, densities (against geometry worked out without the warp), Jacobians, round trips, extremes. */
#include "math/sampling.h"
#include "math/warp.h"

static const double extremes[] = {0.0, 0x1p-1074, 0x1p-60, 0x1p-53, 0.25, 0.5, 0.75, 1 - 0x1p-52, MATH_ONE_MINUS};
enum { EXTREMES = sizeof extremes / sizeof extremes[0] };

/* ---- sine and cosine ---- */

static double ulp_of(double x)
{
    return nextafter(fabs(x), INFINITY) - fabs(x);
}

static void check_sincos(double u)
{
    /* the second way: exact reduction to an eighth of a turn, then the C library in extended precision (error
     * 1e-19) */
    const int quarter = (int)rint(4 * u);
    const long double angle = 2 * 3.14159265358979323846264338327950288L * (long double)(u - 0.25 * quarter);
    const long double turn[4] = {sinl(angle), cosl(angle), -sinl(angle), -cosl(angle)};
    const long double s_wanted = turn[quarter % 4], c_wanted = turn[(quarter + 1) % 4];
    double s, c;
    warp_sincos_turns(u, &s, &c);
    const double s_off = (double)(fabsl(s - s_wanted)) / ulp_of((double)s_wanted),
                 c_off = (double)(fabsl(c - c_wanted)) / ulp_of((double)c_wanted);
    /* the bounds of warp.h; the sine's polynomial (even quarters: the sine) is the better one */
    if (!(s_off <= (quarter % 2 ? 1.1 : 0.8)) || !(c_off <= (quarter % 2 ? 0.8 : 1.1)))
        fail_msg("u = %.17g: sine off by %g ulp, cosine by %g ulp", u, s_off, c_off);
}

static void sincos_is_within_its_bounds(void **state)
{
    (void)state;
    stream_t stream = stream_of(1);
    for (int i = 0; i < 500000; i++)
        check_sincos(stream_number(&stream));
    for (int eighth = 0; eighth < 8; eighth++)
        for (int i = -20; i <= 20; i++) {
            const double u = eighth / 8.0 + i * 0x1p-53;
            if (u >= 0 && u < 1)
                check_sincos(u);
        }
    for (int i = 0; i < EXTREMES; i++)
        check_sincos(extremes[i]);
}

static void sincos_of_small_angles_keeps_relative_precision(void **state)
{
    (void)state;
    for (double u = 0x1p-10; u > 1e-300; u *= 0.2385) {
        double s, c;
        warp_sincos_turns(u, &s, &c);
        const long double wanted = sinl(2 * 3.14159265358979323846264338327950288L * u);
        assert_near(s / (double)wanted, 1, 2.3e-16);
    }
}

static void quarters_are_exact(void **state)
{
    (void)state;
    static const double sines[4] = {0, 1, 0, -1}, cosines[4] = {1, 0, -1, 0};
    for (int i = 0; i < 4; i++) {
        double s, c;
        warp_sincos_turns(0.25 * i, &s, &c);
        assert_near(s, sines[i], 0);
        assert_near(c, cosines[i], 0);
    }
}

/* ---- maps onto surfaces, all as points in space ---- */

#define CONE_WIDE 1.7
#define CONE_SMALL 0.01
#define CONE_TINY 1e-14

static vec3_t disk_forward(double u1, double u2)
{
    const vec2_t p = warp_disk(u1, u2);
    return vec3(p.x, p.y, 0);
}
static void disk_back(vec3_t p, double *u1, double *u2)
{
    warp_disk_invert((vec2_t){p.x, p.y}, u1, u2);
}
static double disk_pdf(vec3_t p)
{
    (void)p;
    return 1 / MATH_PI;
}
static double cosine_pdf(vec3_t w)
{
    return w.z / MATH_PI;
}
static double sphere_pdf(vec3_t w)
{
    (void)w;
    return 1 / (4 * MATH_PI);
}
static vec3_t wide_forward(double u1, double u2)
{
    return warp_cone(u1, u2, CONE_WIDE);
}
static void wide_back(vec3_t w, double *u1, double *u2)
{
    warp_cone_invert(w, CONE_WIDE, u1, u2);
}
static double wide_pdf(vec3_t w)
{
    (void)w;
    return 1 / (2 * MATH_PI * CONE_WIDE);
}
static vec3_t small_forward(double u1, double u2)
{
    return warp_cone(u1, u2, CONE_SMALL);
}
static void small_back(vec3_t w, double *u1, double *u2)
{
    warp_cone_invert(w, CONE_SMALL, u1, u2);
}
static double small_pdf(vec3_t w)
{
    (void)w;
    return 1 / (2 * MATH_PI * CONE_SMALL);
}
static vec3_t tiny_forward(double u1, double u2)
{
    return warp_cone(u1, u2, CONE_TINY);
}
static void tiny_back(vec3_t w, double *u1, double *u2)
{
    warp_cone_invert(w, CONE_TINY, u1, u2);
}
static double tiny_pdf(vec3_t w)
{
    (void)w;
    return 1 / (2 * MATH_PI * CONE_TINY);
}
static vec3_t triangle_forward(double u1, double u2)
{
    const vec2_t b = warp_triangle(u1, u2);
    return vec3(b.x, b.y, 0);
}
static void triangle_back(vec3_t b, double *u1, double *u2)
{
    warp_triangle_invert((vec2_t){b.x, b.y}, u1, u2);
}
static double triangle_pdf(vec3_t b)
{
    (void)b;
    return 2;
}

typedef struct map {
    const char *name;
    vec3_t (*forward)(double u1, double u2);
    void (*back)(vec3_t x, double *u1, double *u2);
    double (*pdf)(vec3_t x);
    double scale; /* of the image: steps of points are compared with it */
} map_t;

static const map_t maps[] = {
    {"disk", disk_forward, disk_back, disk_pdf, 1},
    {"cosine", warp_cosine, warp_cosine_invert, cosine_pdf, 1},
    {"sphere", warp_sphere, warp_sphere_invert, sphere_pdf, 1},
    {"wide cone", wide_forward, wide_back, wide_pdf, 1},
    {"small cone", small_forward, small_back, small_pdf, 0.1},
    {"tiny cone", tiny_forward, tiny_back, tiny_pdf, 1e-7},
    {"triangle", triangle_forward, triangle_back, triangle_pdf, 1},
    {"octahedral", warp_octahedral, warp_octahedral_invert, sphere_pdf, 1},
};
enum { MAPS = sizeof maps / sizeof maps[0] };

/* Error of a point that comes back, from u's own rounding: 1.1e-16 in u1 (see warp.h) moves it by 1.1e-16 |dx/du1|,
 * and |dx/du1| <= 1 / (pdf |dx/du2|) where the two are orthogonal; measured instead by a difference. */
static double rounding_of(const map_t *map, double u1, double u2)
{
    const double step = 0x1p-50; /* 8 units of rounding */
    const double near1 = u1 > 0.5 ? u1 - step : u1 + step * u1, near2 = u2 > 0.5 ? u2 - step : u2 + step;
    const vec3_t x = map->forward(u1, u2);
    return vec3_length(vec3_sub(map->forward(near1, u2), x)) + vec3_length(vec3_sub(map->forward(u1, near2), x)) +
           1e-15 * map->scale;
}

static void check_round_trip(const map_t *map, double u1, double u2)
{
    const vec3_t x = map->forward(u1, u2);
    if (!vec3_finite(x))
        fail_msg("%s(%.17g, %.17g) is not finite", map->name, u1, u2);
    double v1 = -1, v2 = -1;
    map->back(x, &v1, &v2);
    assert_unit_interval(v1);
    assert_unit_interval(v2);
    const vec3_t y = map->forward(v1, v2);
    const double off = vec3_length(vec3_sub(x, y)), limit = rounding_of(map, u1, u2);
    if (!(off <= limit))
        fail_msg("%s(%.17g, %.17g) comes back off by %g > %g, as (%.17g, %.17g)", map->name, u1, u2, off, limit, v1,
                 v2);
}

static void points_come_back(void **state)
{
    (void)state;
    stream_t stream = stream_of(2);
    for (int m = 0; m < MAPS; m++)
        for (int i = 0; i < 20000; i++) {
            const double u1 = stream_number(&stream), u2 = stream_number(&stream);
            check_round_trip(&maps[m], u1, u2);
            /* and close to the ends, where a square root vanishes */
            check_round_trip(&maps[m], pow(10, -15 * u1), u2 * MATH_ONE_MINUS);
            check_round_trip(&maps[m], warp_clamp_unit(1 - pow(10, -15 * u1)), u2);
        }
}

static void extremes_come_back(void **state)
{
    (void)state;
    for (int m = 0; m < MAPS; m++)
        for (int i = 0; i < EXTREMES; i++)
            for (int j = 0; j < EXTREMES; j++)
                check_round_trip(&maps[m], extremes[i], extremes[j]);
}

static void numbers_come_back(void **state)
{
    (void)state;
    stream_t stream = stream_of(3);
    for (int m = 0; m < MAPS; m++)
        for (int i = 0; i < 20000; i++) {
            /* from 1e-3 on all maps are well conditioned: errors of a few 1e-16 grow by at most 1e3 */
            const double u1 = 0.001 + 0.998 * stream_number(&stream), u2 = stream_number(&stream);
            double v1, v2;
            maps[m].back(maps[m].forward(u1, u2), &v1, &v2);
            assert_near(v1, u1, 1e-12);
            assert_near(fabs(v2 - u2) > 0.5 ? 1 - fabs(v2 - u2) : fabs(v2 - u2), 0, 1e-12);
        }
}

/* |dx/du1 x dx/du2| = 1/pdf, by central differences of step h: truncation error of order (h/d)^2 at a distance d
 * from where the map isn't smooth. */
static void jacobian_is_the_inverse_density(void **state)
{
    (void)state;
    const double h = 1e-5;
    stream_t stream = stream_of(4);
    for (int m = 0; m < MAPS; m++)
        for (int i = 0; i < 2000; i++) {
            const double u1 = 0.05 + 0.9 * stream_number(&stream), u2 = 0.05 + 0.9 * stream_number(&stream);
            if (maps[m].forward == warp_octahedral) { /* off the creases */
                const double au = fabs(2 * u1 - 1), av = fabs(2 * u2 - 1);
                if (fabs(au + av - 1) < 0.05 || au < 0.05 || av < 0.05)
                    continue;
            }
            const map_t *map = &maps[m];
            const vec3_t d1 =
                vec3_scale(vec3_sub(map->forward(u1 + h, u2), map->forward(u1 - h, u2)), 0.5 / (h * map->scale));
            const vec3_t d2 =
                vec3_scale(vec3_sub(map->forward(u1, u2 + h), map->forward(u1, u2 - h)), 0.5 / (h * map->scale));
            const double jacobian = vec3_length(vec3_cross(d1, d2)) * map->scale * map->scale;
            const double product = jacobian * map->pdf(map->forward(u1, u2));
            if (!(fabs(product - 1) <= 1e-6))
                fail_msg("%s(%g, %g): jacobian * pdf = %.9g", map->name, u1, u2, product);
        }
}

/* ---- densities against geometry ---- */

enum { SAMPLES = 200000, SIDE = 16 };

/* Area of the unit disk in [x0,x1] x [y0,y1] by the midpoint rule in x, exact in y. */
static double disk_in_box(double x0, double x1, double y0, double y1)
{
    double sum = 0;
    const int steps = 4000;
    for (int i = 0; i < steps; i++) {
        const double x = x0 + (x1 - x0) * (i + 0.5) / steps, half = sqrt(fmax(1 - x * x, 0));
        sum += fmax(fmin(y1, half) - fmax(y0, -half), 0);
    }
    return sum * (x1 - x0) / steps;
}

static void disk_is_uniform(void **state)
{
    (void)state;
    double counts[SIDE * SIDE] = {0}, expected[SIDE * SIDE];
    stream_t stream = stream_of(5);
    for (int i = 0; i < SAMPLES; i++) {
        const double u1 = stream_number(&stream), u2 = stream_number(&stream);
        const vec2_t p = warp_disk(u1, u2);
        counts[(int)((p.y + 1) * (SIDE / 2)) * SIDE + (int)((p.x + 1) * (SIDE / 2))]++;
    }
    double total = 0;
    for (int j = 0; j < SIDE; j++)
        for (int i = 0; i < SIDE; i++) {
            const double x = 2.0 * i / SIDE - 1, y = 2.0 * j / SIDE - 1, d = 2.0 / SIDE;
            expected[j * SIDE + i] = SAMPLES * disk_in_box(x, x + d, y, y + d) / MATH_PI;
            total += expected[j * SIDE + i];
        }
    assert_near(total / SAMPLES, 1, 1e-5); /* the density integrates to one */
    assert_distribution("disk", counts, expected, SIDE * SIDE);
}

/* On any hemisphere slab z in [a,b] the cosine law has b^2 - a^2; and its shadow on any axis in the plane is a
 * semicircle. */
static void cosine_has_its_density(void **state)
{
    (void)state;
    double *heights = malloc(SAMPLES * sizeof *heights), *shadows = malloc(SAMPLES * sizeof *shadows);
    assert_non_null(heights);
    assert_non_null(shadows);
    stream_t stream = stream_of(6);
    for (int i = 0; i < SAMPLES; i++) {
        const double u1 = stream_number(&stream), u2 = stream_number(&stream);
        const vec3_t w = warp_cosine(u1, u2);
        assert_near(vec3_length(w), 1, 1e-15);
        heights[i] = w.z * w.z;
        const double x = 0.6 * w.x + 0.8 * w.y; /* the semicircle's distribution function */
        shadows[i] = 0.5 + (x * sqrt(fmax(1 - x * x, 0)) + asin(fmin(fmax(x, -1), 1))) / MATH_PI;
    }
    assert_uniform("cosine: height", heights, SAMPLES);
    assert_uniform("cosine: shadow", shadows, SAMPLES);
    free(heights);
    free(shadows);
}

/* Archimedes: any coordinate of a uniform direction is uniform, and so is the angle around it; about an axis that
 * the maps don't know. */
static void check_uniform_sphere(const char *name, vec3_t (*forward)(double, double), uint64_t seed)
{
    const vec3_t axis = vec3(2. / 7, 3. / 7, 6. / 7), across = vec3(6. / 7, 2. / 7, -3. / 7),
                 up = vec3(-3. / 7, 6. / 7, -2. / 7);
    double counts[SIDE * SIDE] = {0}, expected[SIDE * SIDE];
    stream_t stream = stream_of(seed);
    for (int i = 0; i < SAMPLES; i++) {
        const double u1 = stream_number(&stream), u2 = stream_number(&stream);
        const vec3_t w = forward(u1, u2);
        assert_near(vec3_length(w), 1, 1e-15);
        const int row = (int)fmin((vec3_dot(w, axis) + 1) * (SIDE / 2), SIDE - 1);
        const int column =
            (int)fmin((atan2(vec3_dot(w, across), vec3_dot(w, up)) / MATH_PI + 1) * (SIDE / 2), SIDE - 1);
        counts[row * SIDE + column]++;
    }
    for (int i = 0; i < SIDE * SIDE; i++)
        expected[i] = (double)SAMPLES / (SIDE * SIDE);
    assert_distribution(name, counts, expected, SIDE * SIDE);
}

static void sphere_is_uniform(void **state)
{
    (void)state;
    check_uniform_sphere("sphere", warp_sphere, 7);
}

static void octahedral_map_has_equal_areas(void **state)
{
    (void)state;
    check_uniform_sphere("octahedral", warp_octahedral, 8);
}

/* A cone's shadow on the plane, stretched to the unit disk of equal areas: rho^2 = (1 - z) / one_minus_cos. */
static void check_cone(double one_minus_cos, uint64_t seed)
{
    double *radii = malloc(SAMPLES * sizeof *radii), *angles = malloc(SAMPLES * sizeof *angles);
    assert_non_null(radii);
    assert_non_null(angles);
    stream_t stream = stream_of(seed);
    for (int i = 0; i < SAMPLES; i++) {
        const double u1 = stream_number(&stream), u2 = stream_number(&stream);
        const vec3_t w = warp_cone(u1, u2, one_minus_cos);
        assert_near(vec3_length(w), 1, 1e-15);
        /* half the angle from its chord with +z; 1 - cos = 2 sin^2 */
        const double half = atan2(hypot(w.x, w.y), 1 + w.z);
        radii[i] = 2 * sin(half) * sin(half) / one_minus_cos;
        angles[i] = (atan2(w.y, w.x) / MATH_PI + 1) / 2;
    }
    assert_uniform("cone: height", radii, SAMPLES);
    assert_uniform("cone: angle", angles, SAMPLES);
    free(radii);
    free(angles);
}

static void cones_are_uniform(void **state)
{
    (void)state;
    check_cone(CONE_WIDE, 9);
    check_cone(CONE_SMALL, 10);
    check_cone(CONE_TINY, 11);
}

/* The triangle cut into SIDE^2 equal ones by lines parallel to its sides. */
static void triangle_is_uniform(void **state)
{
    (void)state;
    double counts[2 * SIDE * SIDE] = {0}, expected[2 * SIDE * SIDE] = {0};
    stream_t stream = stream_of(12);
    for (int i = 0; i < SAMPLES; i++) {
        const double u1 = stream_number(&stream), u2 = stream_number(&stream);
        const vec2_t b = warp_triangle(u1, u2);
        const double x = b.x * SIDE, y = b.y * SIDE;
        const int column = (int)x, row = (int)y;
        counts[2 * (row * SIDE + column) + (x - column + y - row >= 1)]++;
    }
    for (int row = 0; row < SIDE; row++)
        for (int column = 0; row + column < SIDE; column++) {
            expected[2 * (row * SIDE + column)] = (double)SAMPLES / (SIDE * SIDE);
            if (row + column < SIDE - 1)
                expected[2 * (row * SIDE + column) + 1] = (double)SAMPLES / (SIDE * SIDE);
        }
    assert_distribution("triangle", counts, expected, 2 * SIDE * SIDE);
}

/* ---- particulars ---- */

/* Clarberg's map: +z in the middle, -z at the corners, the equator on the diamond, x to the right, y down the rows.
 */
static void octahedral_map_is_oriented_as_documented(void **state)
{
    (void)state;
    assert_vec3_near(warp_octahedral(0.5, 0.5), vec3(0, 0, 1), 1e-15);
    assert_vec3_near(warp_octahedral(MATH_ONE_MINUS, 0.5), vec3(1, 0, 0), 1e-15);
    assert_vec3_near(warp_octahedral(0, 0.5), vec3(-1, 0, 0), 1e-15);
    assert_vec3_near(warp_octahedral(0.5, MATH_ONE_MINUS), vec3(0, 1, 0), 1e-15);
    assert_vec3_near(warp_octahedral(0.5, 0), vec3(0, -1, 0), 1e-15);
    for (int corner = 0; corner < 4; corner++)
        assert_vec3_near(warp_octahedral(corner & 1 ? MATH_ONE_MINUS : 0, corner & 2 ? MATH_ONE_MINUS : 0),
                         vec3(0, 0, -1), 1e-15);
    const double r = sqrt(0.5);
    assert_vec3_near(warp_octahedral(0.75, 0.75), vec3(r, r, 0), 1e-15);
    assert_vec3_near(warp_octahedral(0.25, 0.75), vec3(-r, r, 0), 1e-15);
}

static void octahedral_edges_fold(void **state)
{
    (void)state;
    stream_t stream = stream_of(13);
    for (int i = 0; i < 1000; i++) {
        const double t = stream_number(&stream);
        assert_vec3_near(warp_octahedral(0, t), warp_octahedral(0, 1 - t), 1e-15);
        assert_vec3_near(warp_octahedral(t, 0), warp_octahedral(1 - t, 0), 1e-15);
        /* 1.1e-16 off the edge, where points move at up to 8 a unit, on both sides */
        assert_vec3_near(warp_octahedral(MATH_ONE_MINUS, t), warp_octahedral(MATH_ONE_MINUS, 1 - t), 3e-15);
    }
}

static void cosine_never_lies_on_the_horizon(void **state)
{
    (void)state;
    const vec3_t w = warp_cosine(MATH_ONE_MINUS, 0.2385);
    assert_true(w.z > 1e-8);
}

/* Directions at grazing angles: z is lost to 1.1e-16 / z, no more. */
static void grazing_directions_come_back(void **state)
{
    (void)state;
    for (double z = 0.3; z > 2e-8; z *= 0.2385) {
        const double r = sqrt((1 - z) * (1 + z));
        const vec3_t w = vec3(0.6 * r, -0.8 * r, z);
        double u1, u2;
        warp_cosine_invert(w, &u1, &u2);
        assert_vec3_near(warp_cosine(u1, u2), w, 1.2e-16 / z + 1e-15);
    }
}

static void points_just_outside_are_clamped(void **state)
{
    (void)state;
    double u1, u2;
    warp_disk_invert((vec2_t){1 + 1e-9, 1e-9}, &u1, &u2);
    assert_near(u1, MATH_ONE_MINUS, 0);
    warp_cosine_invert(vec3(1, 0, -1e-12), &u1, &u2);
    assert_near(u1, MATH_ONE_MINUS, 0);
    warp_cone_invert(vec3(1, 0, 0), 0.5, &u1, &u2);
    assert_near(u1, MATH_ONE_MINUS, 0);
    warp_triangle_invert((vec2_t){-1e-12, 1 + 1e-9}, &u1, &u2);
    assert_near(u1, MATH_ONE_MINUS, 0);
    assert_near(u2, MATH_ONE_MINUS, 0);
    warp_triangle_invert((vec2_t){1, 0}, &u1, &u2);
    assert_near(u1, 0, 0);
    assert_unit_interval(u2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sincos_is_within_its_bounds),
        cmocka_unit_test(sincos_of_small_angles_keeps_relative_precision),
        cmocka_unit_test(quarters_are_exact),
        cmocka_unit_test(points_come_back),
        cmocka_unit_test(extremes_come_back),
        cmocka_unit_test(numbers_come_back),
        cmocka_unit_test(jacobian_is_the_inverse_density),
        cmocka_unit_test(disk_is_uniform),
        cmocka_unit_test(cosine_has_its_density),
        cmocka_unit_test(sphere_is_uniform),
        cmocka_unit_test(octahedral_map_has_equal_areas),
        cmocka_unit_test(cones_are_uniform),
        cmocka_unit_test(triangle_is_uniform),
        cmocka_unit_test(octahedral_map_is_oriented_as_documented),
        cmocka_unit_test(octahedral_edges_fold),
        cmocka_unit_test(cosine_never_lies_on_the_horizon),
        cmocka_unit_test(grazing_directions_come_back),
        cmocka_unit_test(points_just_outside_are_clamped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
