/* Lights at finite places, and distant ones: selection, densities, emission, inverses. Infinite lights with images:
 * test_environment.c. */
#include "scene/light_scene.h"

#include "math/warp.h"

static const double ends[] = {0, 0x1p-53, 0.5, 1 - 0x1p-52, MATH_ONE_MINUS};

/* Every kind once; far: everything moved; size: of the emitters. */
static void fill_all_kinds(light_scene_t *s, bool two_sided, vec3_t move, double size)
{
    light_scene_init(s);
    light_scene_add(s, SCENE_LIGHT_AREA, 3, 2, 1)->two_sided = two_sided;
    const vec3_t a = vec3_add(move, vec3(1, 2, 3));
    light_scene_triangle(s, 0, a, vec3_add(a, vec3(size, 0.2 * size, 0.1 * size)),
                         vec3_add(a, vec3(0.3 * size, size, -0.5 * size)));
    light_scene_round(s, SCENE_SHAPE_SPHERE, 0, vec3_add(move, vec3(-2, 1, 0)), 0.5 * size, vec3(0, 0, 1));
    light_scene_round(s, SCENE_SHAPE_DISK, 0, vec3_add(move, vec3(0, -3, 1)), 0.7 * size, vec3(0.6, 0, -0.8));
    scene_light_t *point = light_scene_add(s, SCENE_LIGHT_POINT, 1, 1, 2);
    scene_light_t *spot = light_scene_add(s, SCENE_LIGHT_SPOT, 4, 5, 6);
    for (int i = 0; i < 3; i++)
        point->position[i] = spot->position[i] = (float)(i == 0 ? move.x : i == 1 ? move.y : move.z);
    spot->direction[0] = 0.6f;
    spot->direction[1] = 0;
    spot->direction[2] = 0.8f;
    spot->cos_start = 0.9f;
    spot->cos_end = 0.7f;
    scene_light_t *distant = light_scene_add(s, SCENE_LIGHT_DISTANT, 0.01f, 0.01f, 0.01f);
    distant->direction[1] = -0.8f;
    distant->direction[2] = -0.6f;
    light_scene_add(s, SCENE_LIGHT_INFINITE, 0.003f, 0.004f, 0.005f);
    s->camera.to_world[3] = move.x;
    s->camera.to_world[7] = move.y;
    s->camera.to_world[11] = move.z;
}

/* ---- the set ---- */

static void selection_is_in_proportion_to_power(void **state)
{
    (void)state;
    for (int two = 0; two < 2; two++) {
        light_scene_t s;
        light_set_t set;
        fill_all_kinds(&s, two, vec3(0, 0, 0), 1);
        light_scene_set(&set, &s);
        assert_int_equal(set.count, 7);
        const double area = 0.212671 * 3 + 0.715160 * 2 + 0.072169, point = 0.212671 + 0.715160 + 2 * 0.072169,
                     spot = 0.212671 * 4 + 0.715160 * 5 + 0.072169 * 6;
        const double disk = MATH_PI * set.scene_radius * set.scene_radius;
        const vec3_t n = vec3_cross(vec3(1, 0.2, 0.1), vec3(0.3, 1, -0.5));
        const double cos_start = 0.9f, cos_end = 0.7f;
        const double powers[7] = {
            MATH_PI * area * (1 + two) * 0.5 * vec3_length(n),
            MATH_PI * area * (1 + two) * MATH_PI, /* 4 pi 0.5^2 */
            MATH_PI * area * (1 + two) * MATH_PI * 0.49,
            4 * MATH_PI * point,
            2 * MATH_PI * spot * ((1 - cos_start) + (cos_start - cos_end) / 2),
            0.01 * disk,
            4 * MATH_PI * (0.212671 * 0.003 + 0.715160 * 0.004 + 0.072169 * 0.005) * disk,
        };
        double total = 0;
        for (int i = 0; i < 7; i++)
            total += powers[i];
        assert_near(set.selection.sum / total, 1, 1e-6); /* coordinates and colours in single precision */
        for (uint32_t i = 0; i < 7; i++) {
            assert_int_equal(set.emitters[i].kind, i < 3 ? i
                                                         : (i == 3   ? LIGHT_POINT
                                                            : i == 4 ? LIGHT_SPOT
                                                            : i == 5 ? LIGHT_DISTANT
                                                                     : LIGHT_INFINITE));
            assert_near(set.emitters[i].probability * total / powers[i], 1, 1e-6);
            assert_near(set.emitters[i].probability, table1_probability(&set.selection, i), 0);
        }
        assert_true(set.can_hit && set.has_infinite && set.has_delta);
        assert_int_equal(set.infinite_count, 1);
        assert_int_equal(set.infinite[0], 6);
        for (uint32_t shape = 0; shape < 3; shape++)
            assert_int_equal(light_of_primitive(&set, shape, 0), shape);
        light_set_clear(&set);
        light_set_clear(&set); /* twice does no harm */
    }
}

/* Flux by sampling: the mean of Le cos / pdf over both densities, all emitters together, against the sum of powers.
 */
static void samples_carry_the_power(void **state)
{
    (void)state;
    enum { SAMPLES = 300000 };
    light_scene_t s;
    light_set_t set;
    fill_all_kinds(&s, true, vec3(0, 0, 0), 1);
    light_scene_set(&set, &s);
    stream_t stream = stream_of(1);
    double sum = 0, squares = 0;
    for (int i = 0; i < SAMPLES; i++) {
        emitted_t e;
        for (int k = 0; k < 5; k++)
            e.u[k] = stream_number(&stream);
        if (!light_scene_emit(&set, &s, &e))
            continue;
        const double value = rgb_luminance(e.out.radiance) * e.out.cosine / (e.at.pdf * e.out.pdf_direction);
        sum += value;
        squares += value * value;
    }
    const double mean = sum / SAMPLES, deviation = sqrt((squares / SAMPLES - mean * mean) / SAMPLES);
    assert_near(mean / set.selection.sum, 1, 5 * deviation / set.selection.sum + 1e-12); /* 5 sigma: 6e-7 */
    assert_true(deviation / mean < 0.01);
    light_set_clear(&set);
}

static void what_does_not_emit_has_no_entry(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    light_scene_init(&s);
    light_scene_add(&s, SCENE_LIGHT_AREA, 1, 1, 1);
    light_scene_add(&s, SCENE_LIGHT_AREA, 0, 0, 0);
    light_scene_add(&s, SCENE_LIGHT_POINT, 0, 0, 0);
    light_scene_add(&s, SCENE_LIGHT_INFINITE, 0, 0, 0);
    light_scene_triangle(&s, 0, vec3(0, 0, 0), vec3(1, 1, 1), vec3(2, 2, 2));               /* no area */
    light_scene_triangle(&s, 1, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0));               /* no radiance */
    light_scene_triangle(&s, 0, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0))->material = 1; /* interface */
    light_scene_triangle(&s, SCENE_NONE, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0));
    fault_t fault = {0};
    assert_int_equal(light_set_init(&set, &s.scene, &fault), FAULT_NO_LIGHT);
    assert_null(set.emitters);
    light_scene_triangle(&s, 0, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0));
    light_scene_set(&set, &s);
    assert_int_equal(set.count, 1);
    assert_int_equal(set.infinite_count, 0);
    assert_false(set.has_infinite || set.has_delta);
    for (uint32_t shape = 0; shape < 4; shape++)
        assert_int_equal(light_of_primitive(&set, shape, 0), UINT32_MAX);
    assert_int_equal(light_of_primitive(&set, 4, 0), 0);
    light_set_clear(&set);
    for (int i = 0; i < 9; i++)
        light_scene_add(&s, SCENE_LIGHT_INFINITE, 1, 1, 1);
    assert_int_equal(light_set_init(&set, &s.scene, &fault), FAULT_LIMIT);
}

static void a_mesh_of_many_triangles_is_indexed_by_primitive(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    light_scene_init(&s);
    light_scene_add(&s, SCENE_LIGHT_AREA, 1, 1, 1);
    light_scene_triangle(&s, SCENE_NONE, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0));
    scene_shape_t *mesh = light_scene_triangle(&s, 0, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0));
    mesh->triangles = 3; /* the second has no area, the third is turned round */
    const uint32_t more[6] = {0, 1, 1, 0, 2, 1};
    memcpy(s.indices + 6, more, sizeof more);
    s.scene.triangle_count += 2;
    light_scene_set(&set, &s);
    assert_int_equal(set.count, 2);
    assert_int_equal(light_of_primitive(&set, 0, 0), UINT32_MAX);
    assert_int_equal(light_of_primitive(&set, 1, 0), 0);
    assert_int_equal(light_of_primitive(&set, 1, 1), UINT32_MAX);
    assert_int_equal(light_of_primitive(&set, 1, 2), 1);
    assert_vec3_near(set.emitters[0].normal, vec3(0, 0, 1), 0);
    assert_vec3_near(set.emitters[1].normal, vec3(0, 0, -1), 0);
    light_set_clear(&set);
}

static void bounding_sphere_holds_everything(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    fill_all_kinds(&s, false, vec3(10, 20, 30), 1);
    s.camera.to_world[3] = -50;
    s.camera.lens_radius = 2;
    light_scene_set(&set, &s);
    for (uint64_t i = 0; i < s.scene.vertex_count; i++) {
        const float *p = s.positions + 3 * i;
        assert_true(vec3_length(vec3_sub(vec3(p[0], p[1], p[2]), set.centre)) < set.scene_radius);
    }
    for (uint32_t i = 1; i < 3; i++) {
        const float *p = s.shapes[i].centre;
        assert_true(vec3_length(vec3_sub(vec3(p[0], p[1], p[2]), set.centre)) + s.shapes[i].radius <
                    set.scene_radius);
    }
    assert_true(vec3_length(vec3_sub(vec3(-50, 20, 30), set.centre)) + 2 < set.scene_radius);
    assert_true(set.scene_radius < 50); /* and no more than needed: the camera is 61 away from the rest */
    light_set_clear(&set);
}

/* ---- places ---- */

/* The numbers that select an emitter and are then its own. */
static void draw_for(const light_set_t *set, uint32_t emitter, stream_t *stream, emitted_t *e)
{
    e->u[0] = table1_invert(&set->selection, emitter, stream_number(stream));
    for (int k = 1; k < 5; k++)
        e->u[k] = stream_number(stream);
}

/* Points lie on their surface, with the density of light_pdf_position; |dp/du1 x dp/du2| is the area. */
static void places_are_uniform_by_area(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    fill_all_kinds(&s, false, vec3(0, 0, 0), 1);
    light_scene_set(&set, &s);
    stream_t stream = stream_of(2);
    for (uint32_t emitter = 0; emitter < 3; emitter++)
        for (int i = 0; i < 2000; i++) {
            emitted_t e;
            draw_for(&set, emitter, &stream, &e);
            assert_true(light_sample_position(&set, &s.scene, e.u[0], e.u + 1, &e.at));
            assert_int_equal(e.at.emitter, emitter);
            const light_emitter_t *l = &set.emitters[emitter];
            assert_near(e.at.pdf / light_pdf_position(&set, emitter), 1, 1e-15);
            const vec3_t d = vec3_sub(e.at.position, l->position);
            if (emitter == 1) {
                assert_near(vec3_length(d), l->radius, 1e-15);
                assert_vec3_near(vec3_scale(d, 1 / l->radius), e.at.normal, 1e-15);
            } else {
                assert_near(vec3_dot(d, l->normal), 0, 1e-15);
                assert_vec3_near(e.at.normal, l->normal, 0);
            }
            assert_near(vec3_length(e.at.normal), 1, 1e-15);
            const double h = 1e-5; /* truncation h^2 / distance to the ends^2 */
            light_sample_t side[4];
            for (int k = 0; k < 4; k++) {
                double u[2] = {0.05 + 0.9 * e.u[1], 0.05 + 0.9 * e.u[2]};
                u[k / 2] += k % 2 ? h : -h;
                light_sample_position(&set, &s.scene, e.u[0], u, &side[k]);
            }
            const vec3_t d1 = vec3_scale(vec3_sub(side[1].position, side[0].position), 0.5 / h),
                         d2 = vec3_scale(vec3_sub(side[3].position, side[2].position), 0.5 / h);
            assert_near(vec3_length(vec3_cross(d1, d2)) / l->area, 1, 1e-6);
        }
    light_set_clear(&set);
}

/* A point and its numbers: S(R(x)) = x within the rounding of world coordinates. */
static void check_position_round_trip(const light_set_t *set, const light_scene_t *s, const light_sample_t *at,
                                      stream_t *stream, double slack)
{
    const double free_numbers[3] = {stream_number(stream), stream_number(stream), stream_number(stream)};
    double select, u[2];
    assert_true(light_invert_position(set, &s->scene, at, free_numbers, &select, u));
    assert_unit_interval(select);
    assert_unit_interval(u[0]);
    assert_unit_interval(u[1]);
    light_sample_t again;
    assert_true(light_sample_position(set, &s->scene, select, u, &again));
    assert_int_equal(again.emitter, at->emitter);
    const light_emitter_t *e = &set->emitters[at->emitter];
    if (e->flags & LIGHT_AT_INFINITY) {
        assert_vec3_near(again.to_light, at->to_light, slack + 4e-15);
    } else {
        const double size =
            e->kind == LIGHT_TRIANGLE ? fmax(vec3_length(e->edge1), vec3_length(e->edge2)) : e->radius;
        assert_vec3_near(again.position, at->position, slack + 1e-15 * (vec3_max_abs(e->position) + size));
    }
    assert_near(again.pdf / at->pdf, 1, 1e-15);
}

static void check_places_of_scene(const light_scene_t *s, uint64_t seed)
{
    light_set_t set;
    light_scene_set(&set, s);
    stream_t stream = stream_of(seed);
    for (uint32_t emitter = 0; emitter < set.count; emitter++) {
        /* at the pole u1 -> 1 of a sphere points are known to 1.1e-8 of a radius at worst (warp.h) */
        const light_emitter_t *e = &set.emitters[emitter];
        const bool round = e->kind == LIGHT_SPHERE || e->kind == LIGHT_INFINITE;
        for (int i = 0; i < 3025; i++) {
            emitted_t x;
            draw_for(&set, emitter, &stream, &x);
            if (i < 25) {
                x.u[1] = ends[i / 5];
                x.u[2] = ends[i % 5];
            }
            assert_true(light_sample_position(&set, &s->scene, x.u[0], x.u + 1, &x.at));
            const double near_pole = sqrt(fmax(1 - x.u[1], 0x1p-53));
            check_position_round_trip(&set, s, &x.at, &stream,
                                      round ? (e->kind == LIGHT_SPHERE ? e->radius : 1) * 4e-16 / near_pole : 0);
        }
    }
    light_set_clear(&set);
}

static void places_come_back(void **state)
{
    (void)state;
    light_scene_t s;
    fill_all_kinds(&s, false, vec3(0, 0, 0), 1);
    check_places_of_scene(&s, 10);
}

static void places_on_tiny_lights_come_back(void **state)
{
    (void)state;
    light_scene_t s;
    fill_all_kinds(&s, false, vec3(0, 0, 0),
                   1e-5); /* smaller ones collapse in single precision unless at the origin */
    check_places_of_scene(&s, 11);
    light_scene_init(&s);
    light_scene_add(&s, SCENE_LIGHT_AREA, 1, 1, 1);
    light_scene_triangle(&s, SCENE_NONE, vec3(-1, -1, -1), vec3(1, 1, 1), vec3(1, 0, 1)); /* the scene's size */
    light_scene_triangle(&s, 0, vec3(0, 0, 0), vec3(1e-8, 2e-9, 0), vec3(0, 1e-8, 3e-9));
    light_scene_round(&s, SCENE_SHAPE_SPHERE, 0, vec3(0.5, 0.5, 0.5), 1e-8, vec3(0, 0, 1));
    light_scene_round(&s, SCENE_SHAPE_DISK, 0, vec3(0, 0, 1e-8), 1e-8, vec3(0, 1, 0));
    check_places_of_scene(&s, 12);
}

static void places_far_from_the_origin_come_back(void **state)
{
    (void)state;
    light_scene_t s;
    fill_all_kinds(&s, false, vec3(1e5, -2e5, 3e5), 1);
    check_places_of_scene(&s, 13);
}

/* Heights down to 1e-7 of the length, at the origin and away from it, where points leave the triangle by rounding.
 */
static void places_on_needles_come_back(void **state)
{
    (void)state;
    for (int away = 0; away < 2; away++)
        for (double height = 1e-2; height > 5e-8; height *= 0.1) {
            light_scene_t s;
            light_scene_init(&s);
            light_scene_add(&s, SCENE_LIGHT_AREA, 1, 1, 1);
            const vec3_t o = away ? vec3(1, 2, 3) : vec3(0, 0, 0);
            light_scene_triangle(&s, 0, o, vec3_add(o, vec3(1, 0.7, 0.3)),
                                 vec3_add(o, vec3(0.5, 0.35 + height, 0.15)));
            check_places_of_scene(&s, 14);
        }
}

/* Points off the triangle (by rounding elsewhere) go to its nearest point. */
static void points_beside_a_needle_stay_near(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    light_scene_init(&s);
    light_scene_add(&s, SCENE_LIGHT_AREA, 1, 1, 1);
    light_scene_triangle(&s, 0, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0.5, 1e-7, 0));
    light_scene_set(&set, &s);
    stream_t stream = stream_of(15);
    for (int i = 0; i < 1000; i++) {
        const double off = 1e-7;
        light_sample_t at = {.emitter = 0}, again;
        at.position = vec3(stream_number(&stream), off * (2 * stream_number(&stream) - 1), 0);
        const double free_numbers[3] = {0.5, 0.5, 0.5};
        double select, u[2];
        assert_true(light_invert_position(&set, &s.scene, &at, free_numbers, &select, u));
        assert_true(light_sample_position(&set, &s.scene, select, u, &again));
        assert_vec3_near(again.position, at.position, 1.0001 * off);
    }
    light_set_clear(&set);
}

/* What a discrete place leaves open is drawn: the free numbers themselves. */
static void ambiguous_numbers_are_the_free_ones(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    fill_all_kinds(&s, false, vec3(0, 0, 0), 1);
    light_scene_set(&set, &s);
    const double free_numbers[3] = {0.125, 0.375, 0.875};
    for (uint32_t emitter = 3; emitter < 6; emitter++) {
        light_sample_t at = {.emitter = emitter, .position = set.emitters[emitter].position};
        double select, u[2], probability, rest;
        assert_true(light_invert_position(&set, &s.scene, &at, free_numbers, &select, u));
        assert_near(u[0], 0.375, 0);
        assert_near(u[1], 0.875, 0);
        assert_int_equal(table1_sample(&set.selection, select, &probability, &rest), emitter);
        assert_near(rest, 0.125, 1e-12);
    }
    light_set_clear(&set);
}

/* ---- directions ---- */

/* Density, radiance and cosine by light_eval; S(R(x)) = x; the Jacobian by differences. */
static void check_directions(const light_scene_t *s, uint64_t seed)
{
    light_set_t set;
    light_scene_set(&set, s);
    stream_t stream = stream_of(seed);
    for (uint32_t emitter = 0; emitter < set.count; emitter++)
        for (int i = 0; i < 2025; i++) {
            emitted_t x;
            draw_for(&set, emitter, &stream, &x);
            if (i < 25) {
                x.u[3] = ends[i / 5];
                x.u[4] = ends[i % 5];
            }
            const light_emitter_t *e = &set.emitters[emitter];
            const bool sampled = light_scene_emit(&set, s, &x);
            if (e->kind == LIGHT_SPOT && !sampled)
                continue; /* the rim carries nothing */
            assert_true(sampled);
            assert_near(vec3_length(x.out.direction), 1, 2e-15);
            const bool surface = e->kind <= LIGHT_DISK;
            if (surface)
                assert_near(x.out.cosine, fabs(vec3_dot(x.at.normal, x.out.direction)), 1e-15);
            double pdf;
            const rgb_t radiance = light_eval(&set, &s->scene, emitter, x.at.normal, x.out.direction, &pdf);
            /* a cosine is known to 1e-16, relative to itself; a spot's cone ends where rounding says */
            const double grazing = surface ? 5e-16 / x.out.cosine : 0;
            if (!(surface && x.out.cosine < 1e-7)) {
                assert_near(pdf / x.out.pdf_direction, 1, 1e-14 + grazing);
                assert_near(radiance.g, x.out.radiance.g, 1e-12 * e->radiance.g);
            }
            const vec3_t origin =
                e->flags & LIGHT_AT_INFINITY ? vec3_mad(x.out.origin, 0.7, x.out.direction) : x.out.origin;
            double u[2];
            const double free_numbers[2] = {0.5, 0.5};
            if (surface && x.out.cosine < 1e-7)
                continue; /* the side itself is rounding */
            assert_true(light_invert_direction(&set, &s->scene, &x.at, origin, x.out.direction, free_numbers, u));
            assert_unit_interval(u[0]);
            assert_unit_interval(u[1]);
            light_emission_t again;
            assert_true(light_sample_direction(&set, &s->scene, &x.at, u, &again));
            const double pole = e->kind == LIGHT_POINT ? 1e-15 / sqrt(fmax(1 - x.u[3], 0x1p-53)) : 0;
            /* a sphere's normal is found again from its point: as far as that is known */
            const double normal = e->kind == LIGHT_SPHERE ? 4e-16 * vec3_max_abs(x.at.position) / e->radius : 0;
            assert_vec3_near(again.direction, x.out.direction, 4e-15 + 2 * grazing + pole + normal);
            if (e->flags & LIGHT_AT_INFINITY)
                assert_vec3_near(again.origin, x.out.origin, 1e-14 * (set.scene_radius + vec3_max_abs(set.centre)));
        }
    light_set_clear(&set);
}

static void directions_agree_and_come_back(void **state)
{
    (void)state;
    light_scene_t s;
    for (int two = 0; two < 2; two++) {
        fill_all_kinds(&s, two, vec3(0, 0, 0), 1);
        check_directions(&s, 20);
        fill_all_kinds(&s, two, vec3(1e5, -2e5, 3e5), 1);
        check_directions(&s, 21);
        fill_all_kinds(&s, two, vec3(0, 0, 0), 1e-5);
        check_directions(&s, 22);
    }
}

static void direction_jacobian_is_the_inverse_density(void **state)
{
    (void)state;
    const double h = 1e-5;
    for (int two = 0; two < 2; two++) {
        light_scene_t s;
        light_set_t set;
        fill_all_kinds(&s, two, vec3(0, 0, 0), 1);
        light_scene_set(&set, &s);
        stream_t stream = stream_of(23);
        for (uint32_t emitter = 0; emitter < set.count; emitter++)
            for (int i = 0; i < 500; i++) {
                emitted_t x;
                draw_for(&set, emitter, &stream, &x);
                const double side = two ? 0.5 * (i % 2) : 0, width = two ? 0.5 : 1;
                x.u[3] = side + width * (0.05 + 0.9 * x.u[3]);
                assert_true(light_scene_emit(&set, &s, &x));
                light_emission_t near[4];
                for (int k = 0; k < 4; k++) {
                    double u[2] = {x.u[3], x.u[4] * 0.999 + 0.0005};
                    u[k / 2] += k % 2 ? h : -h;
                    light_sample_direction(&set, &s.scene, &x.at, u, &near[k]);
                }
                light_emission_t middle;
                const double u[2] = {x.u[3], x.u[4] * 0.999 + 0.0005};
                assert_true(light_sample_direction(&set, &s.scene, &x.at, u, &middle));
                const bool far = set.emitters[emitter].flags & LIGHT_AT_INFINITY;
                const vec3_t d1 = far ? vec3_sub(near[1].origin, near[0].origin)
                                      : vec3_sub(near[1].direction, near[0].direction),
                             d2 = far ? vec3_sub(near[3].origin, near[2].origin)
                                      : vec3_sub(near[3].direction, near[2].direction);
                const double jacobian = vec3_length(vec3_cross(d1, d2)) / (4 * h * h);
                /* (h / 0.025)^2 truncation */
                assert_near(jacobian * middle.pdf_direction, 1, 2e-6);
            }
        light_set_clear(&set);
    }
}

/* Integrals over the sphere by a product of midpoint rules that knows nothing of the emitter: of the density, 1; of
 * radiance * cosine per area, power. */
static void densities_and_power_integrate(void **state)
{
    (void)state;
    enum { ROWS = 600, COLUMNS = 1200 };
    for (int two = 0; two < 2; two++) {
        light_scene_t s;
        light_set_t set;
        fill_all_kinds(&s, two, vec3(0, 0, 0), 1);
        light_scene_set(&set, &s);
        for (uint32_t emitter = 0; emitter < 5; emitter++) {
            const light_emitter_t *e = &set.emitters[emitter];
            const vec3_t normal = emitter == 1 ? vec3(2. / 7, 3. / 7, 6. / 7) : e->normal;
            double density = 0, power = 0;
            for (int j = 0; j < ROWS; j++)
                for (int i = 0; i < COLUMNS; i++) {
                    const double z = 1 - 2 * (j + 0.5) / ROWS, phi = 2 * MATH_PI * (i + 0.5) / COLUMNS,
                                 r = sqrt(1 - z * z);
                    const vec3_t w = vec3(r * cos(phi), r * sin(phi), z);
                    double pdf;
                    const rgb_t radiance = light_eval(&set, &s.scene, emitter, normal, w, &pdf);
                    density += pdf;
                    power += rgb_luminance(radiance) * (emitter < 3 ? e->area * fabs(vec3_dot(normal, w)) : 1);
                }
            const double cell = 4 * MATH_PI / (ROWS * COLUMNS);
            /* the narrowest, the spot's cone of 45 degrees, has 108 000 of the cells; its edge cuts some 1500 of
             * them, each wrong by up to half its value, signs at random: sqrt(1500) / 2 / 108 000 = 2e-4, ten times
             * that */
            assert_near(density * cell, 1, 2e-3);
            assert_near(power * cell / (e->probability * set.selection.sum), 1, 2e-3);
        }
        light_set_clear(&set);
    }
}

static void sides_are_as_documented(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    fill_all_kinds(&s, true, vec3(0, 0, 0), 1);
    s.shapes[1].flags = SCENE_SHAPE_FLIP;
    light_scene_set(&set, &s);
    stream_t stream = stream_of(24);
    for (uint32_t emitter = 0; emitter < 3; emitter++)
        for (int i = 0; i < 100; i++) {
            emitted_t x;
            draw_for(&set, emitter, &stream, &x);
            assert_true(light_scene_emit(&set, &s, &x));
            assert_true((vec3_dot(x.out.direction, x.at.normal) > 0) == (x.u[3] < 0.5));
            if (emitter == 1) /* flipped: the normal looks to the centre */
                assert_true(vec3_dot(x.at.normal, vec3_sub(set.emitters[1].position, x.at.position)) > 0);
        }
    light_set_clear(&set);
    fill_all_kinds(&s, false, vec3(0, 0, 0), 1);
    s.shapes[0].flags = SCENE_SHAPE_FLIP;
    light_scene_set(&set, &s);
    const vec3_t n = set.emitters[0].normal;
    assert_true(vec3_dot(n, vec3_cross(set.emitters[0].edge1, set.emitters[0].edge2)) < 0);
    double pdf;
    assert_true(rgb_black(light_eval(&set, &s.scene, 0, n, vec3_neg(n), &pdf)));
    assert_near(pdf, 0, 0);
    light_sample_t at = {.emitter = 0, .position = set.emitters[0].position, .normal = n};
    double u[2];
    const double free_numbers[2] = {0, 0};
    assert_false(light_invert_direction(&set, &s.scene, &at, at.position, vec3_neg(n), free_numbers, u));
    light_set_clear(&set);
}

/* A cone of 3.5e-4 radians, the smallest that single precision's cosine tells from none. */
static void tiny_spots_keep_their_precision(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    light_scene_init(&s);
    scene_light_t *spot = light_scene_add(&s, SCENE_LIGHT_SPOT, 1, 1, 1);
    spot->cos_start = 1;
    spot->cos_end = 1 - 0x1p-24f;
    spot->direction[0] = 0.6f;
    spot->direction[2] = 0.8f;
    light_scene_set(&set, &s);
    assert_near(set.selection.sum / (2 * MATH_PI * 0x1p-25), 1, 1e-12);
    stream_t stream = stream_of(25);
    for (int i = 0; i < 2000; i++) {
        emitted_t x;
        draw_for(&set, 0, &stream, &x);
        assert_true(light_scene_emit(&set, &s, &x));
        /* smoothstep(cos_end, cos_start, cos) at cos = 1 - u (1 - cos_end) */
        const double t = 1 - x.u[3];
        assert_near(x.out.radiance.r, t * t * (3 - 2 * t), 1e-12);
        double pdf, u[2];
        const double free_numbers[2] = {0, 0};
        /* direction components are rounded to 1e-16; the cone's radius is 3.5e-4 */
        const rgb_t radiance = light_eval(&set, &s.scene, 0, x.at.normal, x.out.direction, &pdf);
        if (x.u[3] < 1 - 1e-11)
            assert_near(pdf / x.out.pdf_direction, 1, 1e-15);
        assert_near(radiance.r, x.out.radiance.r, 1e-11);
        assert_true(light_invert_direction(&set, &s.scene, &x.at, x.at.position, x.out.direction, free_numbers, u));
        assert_near(u[0], x.u[3], 1e-11);
    }
    double pdf, u[2];
    const double free_numbers[2] = {0, 0};
    const vec3_t beside = vec3_unit(vec3_add(set.emitters[0].normal, vec3(0, 4e-4, 0)));
    const light_sample_t at = {.emitter = 0};
    assert_true(rgb_black(light_eval(&set, &s.scene, 0, vec3(0, 0, 0), beside, &pdf)));
    assert_near(pdf, 0, 0);
    assert_false(light_invert_direction(&set, &s.scene, &at, at.position, beside, free_numbers, u));
    light_set_clear(&set);
}

/* Photons from infinity start outside the sphere, travel towards it and meet it. */
static void photons_from_infinity_start_outside(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    fill_all_kinds(&s, false, vec3(3, 1, 2), 1);
    light_scene_set(&set, &s);
    stream_t stream = stream_of(26);
    for (uint32_t emitter = 5; emitter < 7; emitter++)
        for (int i = 0; i < 1000; i++) {
            emitted_t x;
            draw_for(&set, emitter, &stream, &x);
            assert_true(light_scene_emit(&set, &s, &x));
            const vec3_t d = vec3_sub(x.out.origin, set.centre);
            assert_near(vec3_dot(d, x.out.direction), -set.scene_radius, 1e-13);
            assert_true(vec3_length(d) >= set.scene_radius * (1 - 1e-15));
            assert_true(vec3_length(vec3_mad(d, set.scene_radius, x.out.direction)) <=
                        set.scene_radius * (1 + 1e-15));
            assert_vec3_near(x.at.to_light, vec3_neg(x.out.direction), 0);
            assert_near(x.out.pdf_direction * MATH_PI * set.scene_radius * set.scene_radius, 1, 1e-15);
            double u[2];
            const double free_numbers[2] = {0, 0};
            const vec3_t beside = vec3_mad(set.centre, 1.01 * set.scene_radius, frame_of_normal(x.at.to_light).s);
            assert_false(light_invert_direction(&set, &s.scene, &x.at, beside, x.out.direction, free_numbers, u));
        }
    light_set_clear(&set);
}

/* One light 1e9 times the power of the others: both are sampled with the densities that are said. */
static void dim_lights_beside_a_bright_one(void **state)
{
    (void)state;
    light_scene_t s;
    light_set_t set;
    light_scene_init(&s);
    light_scene_add(&s, SCENE_LIGHT_AREA, 1, 1, 1);
    light_scene_add(&s, SCENE_LIGHT_AREA, 1e9f, 1e9f, 1e9f);
    light_scene_triangle(&s, 0, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0));
    light_scene_triangle(&s, 1, vec3(0, 0, 5), vec3(1, 0, 5), vec3(0, 1, 5));
    light_scene_triangle(&s, 0, vec3(0, 0, 9), vec3(1, 0, 9), vec3(0, 1, 9));
    light_scene_set(&set, &s);
    for (uint32_t emitter = 0; emitter < 3; emitter += 2) {
        const double p = set.emitters[emitter].probability;
        assert_near(p * 1e9, 1, 1e-6); /* the interval's ends are rounded to 1.1e-16 */
        light_sample_t at;
        const double u[2] = {0.5, 0.5};
        assert_true(light_sample_position(&set, &s.scene, table1_invert(&set.selection, emitter, 0.5), u, &at));
        assert_int_equal(at.emitter, emitter);
        assert_near(at.pdf, p / 0.5, 1e-24);
    }
    light_set_clear(&set);
}

/* R draws uniform numbers where places have the light's density: points made without the sampler, by rejection. */
static void inverse_numbers_are_uniform(void **state)
{
    (void)state;
    enum { SAMPLES = 20000 };
    static double numbers[3][3][SAMPLES];
    light_scene_t s;
    light_set_t set;
    fill_all_kinds(&s, false, vec3(0, 0, 0), 1);
    light_scene_set(&set, &s);
    stream_t stream = stream_of(27);
    for (uint32_t emitter = 0; emitter < 3; emitter++) {
        const light_emitter_t *e = &set.emitters[emitter];
        for (int i = 0; i < SAMPLES; i++) {
            light_sample_t at = {.emitter = emitter};
            for (;;) {
                const double a = stream_number(&stream), b = stream_number(&stream);
                if (emitter == 1) {
                    at.position = vec3_mad(e->position, e->radius, stream_direction(&stream));
                    break;
                }
                const double p = emitter == 0 ? a : e->radius * (2 * a - 1),
                             q = emitter == 0 ? b : e->radius * (2 * b - 1);
                at.position = vec3_mad(vec3_mad(e->position, p, e->edge1), q, e->edge2);
                if (emitter == 0 ? p + q <= 1 : p * p + q * q <= e->radius * e->radius)
                    break;
            }
            const double free_numbers[3] = {stream_number(&stream), 0, 0};
            double select, u[2], probability, rest;
            assert_true(light_invert_position(&set, &s.scene, &at, free_numbers, &select, u));
            table1_sample(&set.selection, select, &probability, &rest);
            numbers[emitter][0][i] = u[0];
            numbers[emitter][1][i] = u[1];
            numbers[emitter][2][i] = rest;
        }
        for (int k = 0; k < 3; k++)
            assert_uniform("inverse of a place", numbers[emitter][k], SAMPLES);
    }
    light_set_clear(&set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(selection_is_in_proportion_to_power),
        cmocka_unit_test(samples_carry_the_power),
        cmocka_unit_test(what_does_not_emit_has_no_entry),
        cmocka_unit_test(a_mesh_of_many_triangles_is_indexed_by_primitive),
        cmocka_unit_test(bounding_sphere_holds_everything),
        cmocka_unit_test(places_are_uniform_by_area),
        cmocka_unit_test(places_come_back),
        cmocka_unit_test(places_on_tiny_lights_come_back),
        cmocka_unit_test(places_far_from_the_origin_come_back),
        cmocka_unit_test(places_on_needles_come_back),
        cmocka_unit_test(points_beside_a_needle_stay_near),
        cmocka_unit_test(ambiguous_numbers_are_the_free_ones),
        cmocka_unit_test(directions_agree_and_come_back),
        cmocka_unit_test(direction_jacobian_is_the_inverse_density),
        cmocka_unit_test(densities_and_power_integrate),
        cmocka_unit_test(sides_are_as_documented),
        cmocka_unit_test(tiny_spots_keep_their_precision),
        cmocka_unit_test(photons_from_infinity_start_outside),
        cmocka_unit_test(dim_lights_beside_a_bright_one),
        cmocka_unit_test(inverse_numbers_are_uniform),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
