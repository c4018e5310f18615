/* What the inverse path sampler draws, and how it maps volumes. Right inverses turn uniform numbers into uniform
 * ones: u -> x -> R_s(x) leaves their law as it is; what R draws for one path has the law that path/inverse.h
 * states; and the map from one technique's numbers to another's has the Jacobian p_s'(x) / p_s(x). False alarm of
 * each statistical assertion, were the seed not fixed: 1e-6 (SAMPLING_ALARM). */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <setjmp.h>
#include <cmocka.h>

#include "base/random.h"
#include "inverse_trip.h"
#include "math/sampling.h"
#include "reference.h"

static trip_t trip;

/* Kolmogorov-Smirnov for two samples; sorts both. */
static void assert_same_law(const char *what, double *a, size_t m, double *b, size_t n)
{
    qsort(a, m, sizeof *a, sampling_compare);
    qsort(b, n, sizeof *b, sampling_compare);
    double d = 0;
    for (size_t i = 0, j = 0; i < m && j < n;) {
        const double x = fmin(a[i], b[j]);
        while (i < m && a[i] <= x)
            i++;
        while (j < n && b[j] <= x)
            j++;
        d = fmax(d, fabs((double)i / (double)m - (double)j / (double)n));
    }
    const double root = sqrt((double)m * (double)n / (double)(m + n)), lambda = (root + 0.12 + 0.11 / root) * d;
    double p = 0;
    for (int k = 1; k < 100; k++)
        p += (k % 2 ? 2 : -2) * exp(-2.0 * k * k * lambda * lambda);
    if (lambda > 0.3 && !(p >= SAMPLING_ALARM))
        fail_msg("%s: Kolmogorov-Smirnov D = %g of %zu and %zu numbers, p = %g", what, d, m, n, p);
}

/* ---- u -> x -> R_s(x) ---- */

enum { LAW_DIMENSIONS = 64, LAW_PATHS = 12000 };

typedef struct law {
    double before[LAW_DIMENSIONS][LAW_PATHS], after[LAW_DIMENSIONS][LAW_PATHS];
    size_t before_count, after_count;
} law_t;

/* Of paths that carry light the numbers are not uniform, but given the path they are what R draws: even samples
 * show the law of u, odd ones that of R_s(S_s(u)). */
static void check_law(const char *name, uint32_t k, uint32_t s)
{
    law_t *law = calloc(1, sizeof *law);
    assert_non_null(law);
    trip_begin(&trip, name);
    trip_length(&trip, k);
    const uint32_t camera = trip.target.camera_count, light = trip.target.light_count;
    assert_true(camera + light <= LAW_DIMENSIONS);
    for (uint32_t i = 0; i < LAW_PATHS; i++) {
        const uint64_t key = random_key(5, RANDOM_PURPOSE_TEST, k + 100 * s, i);
        trip_numbers(&trip, key, false);
        if (!(trip_make(&trip, s) > 0))
            continue;
        if (i % 2) {
            if (!trip_invert(&trip, s, s, random_step(key, 1)))
                continue;
            for (uint32_t j = 0; j < camera + light; j++)
                law->after[j][law->after_count] = j < camera ? trip.camera_new[j] : trip.light_new[j - camera];
            law->after_count++;
        } else {
            for (uint32_t j = 0; j < camera + light; j++)
                law->before[j][law->before_count] = j < camera ? trip.camera[j] : trip.light[j - camera];
            law->before_count++;
        }
    }
    print_message("%s, k = %u, s = %u: %zu and %zu paths\n", name, k, s, law->before_count, law->after_count);
    assert_true(law->before_count > 200 && law->after_count > 200);
    for (uint32_t j = 0; j < camera + light; j++) {
        char what[80];
        snprintf(what, sizeof what, "%s, k = %u, s = %u, %s number %u", name, k, s, j < camera ? "camera" : "light",
                 j < camera ? j : j - camera);
        assert_same_law(what, law->before[j], law->before_count, law->after[j], law->after_count);
    }
    trip_end(&trip);
    free(law);
}

static void inverses_of_uniform_numbers_keep_their_law(void **state)
{
    (void)state;
    check_law("diffuse", 2, 1);
    check_law("glossy", 3, 1);
    check_law("glossy", 3, 3);
    check_law("glass", 4, 1);
    check_law("lens", 3, 2);
    check_law("delta-lights", 3, 3);
    check_law("lamps", 3, 1);
    check_law("lamps", 3, 3);
    check_law("skies", 2, 0);
    check_law("skies", 2, 1);
    check_law("skies", 2, 2);
    check_law("transmission", 4, 2);
}

/* ---- what is drawn for one path ---- */

enum { DRAWS = 20000 };
static double drawn[DRAWS];

/* A path of technique s for which `suits`. */
static void find_path(uint32_t s, bool (*suits)(uint32_t s))
{
    for (uint32_t i = 0; i < 200000; i++) {
        trip_numbers(&trip, random_key(6, RANDOM_PURPOSE_TEST, 0, i), false);
        if (trip_make(&trip, s) > 0 && suits(s))
            return;
    }
    fail_msg("no path found");
}

static bool any_path(uint32_t s)
{
    (void)s;
    return true;
}

/* x_2 of k = 3 has two smooth lobes and no other, both in play. */
static bool two_lobes_at_two(uint32_t s)
{
    const bsdf_t *bsdf = trip_vertex(&trip, s, 2)->bsdf;
    return bsdf->count == 2 && !BSDF_KIND_IS_SPECULAR(bsdf->lobes[0].kind) &&
           !BSDF_KIND_IS_SPECULAR(bsdf->lobes[1].kind);
}

/* The density of one lobe alone. */
static double lobe_density(const bsdf_t *bsdf, uint32_t l, vec3_t wo, vec3_t wi)
{
    bsdf_t one = *bsdf;
    one.count = 1;
    one.lobes[0] = bsdf->lobes[l];
    bsdf_value_t value;
    bsdf_eval(&one, trip.ps.tables, wo, wi, BSDF_RADIANCE, &value);
    return value.pdf;
}

static double mixture_density(const bsdf_t *bsdf, vec3_t wo, vec3_t wi)
{
    bsdf_value_t value;
    bsdf_eval(bsdf, trip.ps.tables, wo, wi, BSDF_RADIANCE, &value);
    return value.pdf;
}

/* alpha_0 from the mixture's density: p = alpha_0 p_0 + (1 - alpha_0) p_1, in a direction where they differ. */
static double first_share(const bsdf_t *bsdf, vec3_t wo)
{
    double best = 0, share = 0;
    for (int i = 0; i < 64; i++) {
        vec3_t wi = warp_cosine((i + 0.5) / 64, i * 0.618 - (int)(i * 0.618));
        wi.z = copysign(wi.z, wo.z);
        const double p0 = lobe_density(bsdf, 0, wo, wi), p1 = lobe_density(bsdf, 1, wo, wi);
        const double contrast = fabs(p0 - p1) / (p0 + p1);
        if (contrast > best) {
            best = contrast;
            share = (mixture_density(bsdf, wo, wi) - p1) / (p0 - p1);
        }
    }
    assert_true(best > 0.1);
    return share;
}

/* The first number of scattering at a mixture: lobe l in proportion to alpha_l p_l, uniform within its interval. */
static void lobes_are_drawn_by_their_densities(void **state)
{
    (void)state;
    trip_begin(&trip, "glossy");
    trip_length(&trip, 3);
    find_path(2, two_lobes_at_two);
    const path_vertex_t *v = trip_vertex(&trip, 2, 2);
    const frame_t frame = path_frame(v);
    const vec3_t place = v->position;
    const vec3_t wo = frame_to_local(&frame, vec3_unit(vec3_sub(trip_vertex(&trip, 2, 3)->position, place)));
    const vec3_t wi = frame_to_local(&frame, vec3_unit(vec3_sub(trip_vertex(&trip, 2, 1)->position, place)));
    const double alpha = first_share(v->bsdf, wo), p0 = alpha * lobe_density(v->bsdf, 0, wo, wi),
                 p1 = (1 - alpha) * lobe_density(v->bsdf, 1, wo, wi), chance = p0 / (p0 + p1);
    double counts[2] = {0, 0}, first[DRAWS];
    for (uint32_t i = 0; i < DRAWS; i++) {
        assert_true(trip_invert(&trip, 2, 1, random_key(8, RANDOM_PURPOSE_TEST, 1, i)));
        const double u = trip.camera_new[trip.ps.camera_dimensions];
        if (u < alpha)
            first[(size_t)counts[0]] = u / alpha;
        else
            drawn[(size_t)counts[1]] = (u - alpha) / (1 - alpha);
        counts[u >= alpha]++;
    }
    const double expected[2] = {DRAWS * chance, DRAWS * (1 - chance)};
    print_message("lobe 0 chosen with %.4f by the mixture, drawn with %.4f, expected %.4f\n", alpha,
                  counts[0] / DRAWS, chance);
    assert_true(fabs(chance - alpha) > 0.02);
    assert_distribution("lobes", counts, expected, 2);
    assert_uniform("place in lobe 0", first, (size_t)counts[0]);
    assert_uniform("place in lobe 1", drawn, (size_t)counts[1]);
    trip_end(&trip);
}

/* Which of two skies made a direction: in proportion to their densities there. */
static void skies_are_drawn_by_their_densities(void **state)
{
    (void)state;
    trip_begin(&trip, "skies");
    trip_length(&trip, 2);
    find_path(0, any_path);
    const light_set_t *lights = &trip.ps.lights;
    assert_int_equal(lights->infinite_count, 2);
    double pdf[2], counts[2] = {0, 0};
    for (int i = 0; i < 2; i++)
        light_infinite_radiance(lights, trip.ps.scene, lights->infinite[i], trip_vertex(&trip, 0, 0)->ng, &pdf[i]);
    for (uint32_t i = 0; i < DRAWS; i++) {
        assert_true(trip_invert(&trip, 0, 1, random_key(8, RANDOM_PURPOSE_TEST, 2, i)));
        double probability;
        const uint32_t emitter = table1_sample(&lights->selection, trip.light_new[0], &probability, &drawn[i]);
        assert_true(emitter == lights->infinite[0] || emitter == lights->infinite[1]);
        counts[emitter == lights->infinite[1]]++;
    }
    const double chance = pdf[0] / (pdf[0] + pdf[1]), expected[2] = {DRAWS * chance, DRAWS * (1 - chance)};
    print_message("sky 0 drawn with %.4f, expected %.4f\n", counts[0] / DRAWS, chance);
    assert_true(chance > 0.01 && chance < 0.99);
    assert_distribution("skies", counts, expected, 2);
    assert_uniform("place in the sky's interval", drawn, DRAWS);
    trip_end(&trip);
}

static void assert_free(uint32_t s, uint32_t j, bool camera, uint32_t dimension)
{
    for (uint32_t i = 0; i < DRAWS; i++) {
        assert_true(trip_invert(&trip, s, j, random_key(8, RANDOM_PURPOSE_TEST, 3 + s, i)));
        drawn[i] = (camera ? trip.camera_new : trip.light_new)[dimension];
    }
    assert_uniform(camera ? "free camera number" : "free light number", drawn, DRAWS);
}

static void unused_numbers_are_uniform(void **state)
{
    (void)state;
    trip_begin(&trip, "diffuse");
    trip_length(&trip, 3);
    find_path(1, any_path);
    assert_free(1, 3, true, 0);  /* the film of a lens sample */
    assert_free(1, 3, true, 4);  /* a walk that is not made */
    assert_free(1, 3, false, 5); /* the lobe, where there is one */
    assert_free(1, 1, true, 2);
    assert_free(1, 1, false, 3); /* the light's direction, for a connection */
    trip_end(&trip);
    trip_begin(&trip, "delta-lights");
    trip_length(&trip, 3);
    find_path(1, any_path);
    assert_free(1, 3, false, 1); /* a point has no places */
    assert_free(1, 3, false, 2);
    trip_end(&trip);
}

/* ---- the Jacobian ---- */

enum { SIDE = 24, JACOBIAN_K = 4 };

/* A number that a path is determined by: its stream, its place. */
typedef struct coordinate {
    bool camera;
    uint32_t index;
} coordinate_t;

/* The coordinates of technique s: all but lobes, selection and what delta lights and pinholes don't use. */
static uint32_t coordinates(uint32_t s, const light_emitter_t *light, coordinate_t *out)
{
    const uint32_t t = trip.target.length + 1 - s;
    uint32_t n = 0;
    for (uint32_t i = 0; i < trip.ps.camera_dimensions; i++)
        if (i >= 2 || t > 1)
            out[n++] = (coordinate_t){true, i};
    for (uint32_t z = 1; z + 1 < t; z++)
        for (uint32_t i = 1; i < 3; i++)
            out[n++] = (coordinate_t){true, trip.ps.camera_dimensions + 3 * (z - 1) + i};
    const uint32_t delta = LIGHT_DELTA_POSITION | LIGHT_DELTA_DIRECTION;
    if (s > 0 && !(light->flags & delta)) {
        out[n++] = (coordinate_t){false, 1};
        out[n++] = (coordinate_t){false, 2};
    }
    if (s > 1) {
        out[n++] = (coordinate_t){false, 3};
        out[n++] = (coordinate_t){false, 4};
    }
    for (uint32_t y = 1; y + 1 < s; y++)
        for (uint32_t i = 1; i < 3; i++)
            out[n++] = (coordinate_t){false, PATH_LIGHT_DIMENSIONS + 3 * (y - 1) + i};
    return n;
}

/* The numbers v of technique j as a function of those of s. */
static bool map(uint32_t s, uint32_t j, const coordinate_t *to, uint32_t n, double *v)
{
    if (!(trip_make(&trip, s) > 0) || !trip_invert(&trip, s, j, 1))
        return false;
    for (uint32_t i = 0; i < n; i++)
        v[i] = (to[i].camera ? trip.camera_new : trip.light_new)[to[i].index];
    return true;
}

/* |determinant| by elimination with pivots. */
static double determinant(double m[SIDE][SIDE], uint32_t n)
{
    double result = 1;
    for (uint32_t c = 0; c < n; c++) {
        uint32_t p = c;
        for (uint32_t r = c + 1; r < n; r++)
            p = fabs(m[r][c]) > fabs(m[p][c]) ? r : p;
        if (m[p][c] == 0)
            return 0;
        for (uint32_t i = 0; i < n; i++) {
            const double swap = m[c][i];
            m[c][i] = m[p][i];
            m[p][i] = swap;
        }
        result *= fabs(m[c][c]);
        for (uint32_t r = c + 1; r < n; r++) {
            const double f = m[r][c] / m[c][c];
            for (uint32_t i = c; i < n; i++)
                m[r][i] -= f * m[c][i];
        }
    }
    return result;
}

/* |d v / d u| by central differences; 0 where the map has an edge nearby. Angles are taken modulo a turn. */
static double jacobian(uint32_t s, uint32_t j, const coordinate_t *from, const coordinate_t *to, uint32_t n,
                       double h)
{
    static double m[SIDE][SIDE];
    double high[SIDE], low[SIDE];
    for (uint32_t c = 0; c < n; c++) {
        double *u = &(from[c].camera ? trip.camera : trip.light)[from[c].index];
        const double middle = *u;
        bool ok = middle > h && middle < 1 - h;
        *u = middle + h;
        ok = ok && map(s, j, to, n, high);
        *u = middle - h;
        ok = ok && map(s, j, to, n, low);
        *u = middle;
        if (!ok)
            return 0;
        for (uint32_t r = 0; r < n; r++) {
            const double d = high[r] - low[r];
            m[r][c] = (d - round(d)) / (2 * h);
        }
    }
    return determinant(m, n);
}

/* Whether direction numbers map with the density of the whole mixture: one lobe, and no Fresnel choice in it. */
static bool single_lobes(uint32_t s)
{
    for (uint32_t i = 1; i < trip.target.length; i++) {
        const bsdf_t *bsdf = trip_vertex(&trip, s, i)->bsdf;
        if (bsdf->count != 1 || bsdf->lobes[0].kind == BSDF_DIELECTRIC || !(bsdf->flags & BSDF_HAS_SMOOTH))
            return false;
    }
    return true;
}

static const light_emitter_t *light_of(uint32_t s)
{
    const path_vertex_t *v = trip_vertex(&trip, s, 0);
    const light_set_t *lights = &trip.ps.lights;
    return &lights->emitters[v->emitter == PATH_NO_EMITTER ? lights->infinite[0] : v->emitter];
}

typedef struct jacobians {
    uint32_t compared, edges;
    double worst;
} jacobians_t;

static void compare_jacobian(const char *name, uint32_t s, uint32_t j, const reference_t *reference,
                             jacobians_t *out)
{
    const light_emitter_t *light = light_of(s);
    coordinate_t from[SIDE], to[SIDE];
    const uint32_t n = coordinates(s, light, from);
    assert_int_equal(n, coordinates(j, light, to));
    /* the densities hold the chance of selecting the light, which the coordinates leave out */
    const double expected = (double)(reference->p[j] / reference->p[s]) * (s > 0 ? light->probability : 1) /
                            (j > 0 ? light->probability : 1);
    const double fine = jacobian(s, j, from, to, n, 1e-6), coarse = jacobian(s, j, from, to, n, 2e-6);
    if (!(fabs(fine - coarse) <= 1e-4 * fine) || fine == 0) { /* the differences are no derivatives */
        out->edges++;
        return;
    }
    const double error = fabs(fine / expected - 1);
    if (!(error <= 1e-3))
        fail_msg("%s, k = %u: |d u_%u / d u_%u| = %.9g, p_%u / p_%u = %.9g", name, trip.target.length, j, s, fine,
                 j, s, expected);
    out->worst = fmax(out->worst, error);
    out->compared++;
}

static void check_jacobians(const char *name)
{
    jacobians_t result = {0};
    trip_begin(&trip, name);
    for (uint32_t k = 1; k <= JACOBIAN_K; k++) {
        trip_length(&trip, k);
        for (uint32_t i = 0; i < 160 && trip.target.count > 0; i++) {
            const uint32_t s = trip.target.list[i % trip.target.count];
            trip_numbers(&trip, random_key(9, RANDOM_PURPOSE_TEST, k, i), false);
            if (!(trip_make(&trip, s) > 0) || !single_lobes(s))
                continue;
            reference_t reference;
            reference_evaluate(&trip.ps, trip.x, s, k + 1 - s, &trip.target.techniques, &reference);
            assert_true(reference.valid);
            for (uint32_t j = 0; j < trip.target.count; j++)
                if (trip.target.list[j] != s && reference.p[trip.target.list[j]] > 0 && trip_make(&trip, s) > 0)
                    compare_jacobian(name, s, trip.target.list[j], &reference, &result);
        }
    }
    print_message("%s: %u Jacobians, worst %.2g; %u near edges\n", name, result.compared, result.worst,
                  result.edges);
    assert_true(result.compared > 100);
    assert_true(result.edges <= 0.2 * (result.compared + result.edges));
    trip_end(&trip);
}

static void jacobian_is_the_ratio_of_densities(void **state)
{
    (void)state;
    check_jacobians("diffuse");
    check_jacobians("glossy");
    check_jacobians("lens");
    check_jacobians("delta-lights");
    check_jacobians("sky");
    check_jacobians("lamps");
    check_jacobians("normals");
    check_jacobians("tiny-light");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inverses_of_uniform_numbers_keep_their_law),
        cmocka_unit_test(lobes_are_drawn_by_their_densities),
        cmocka_unit_test(skies_are_drawn_by_their_densities),
        cmocka_unit_test(unused_numbers_are_uniform),
        cmocka_unit_test(jacobian_is_the_ratio_of_densities),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
