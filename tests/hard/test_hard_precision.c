/* The mathematics of common/math and common/scene in double precision against the same sources in extended
 * precision (extended/probe.h), at hard inputs: grazing down to 1e-9, alpha down to 1e-4, indices of 1 +- 5e-7 to
 * 20, the edge of total reflection, numbers at 0 and 1 - 2^-53, needles of aspect 1e6, narrow fields of view,
 * scales of 1e-6 to 1e6.
 *
 * Tolerance. A number in double is itself off by up to half a unit in the last place, 2^-53 of it, so no function
 * can be asked for more than what such a change of its inputs does to its value. The extended build says what that
 * is: each input is moved by 2^-53 of itself either way, one after the other, and what the output moves by is added
 * up. A function may be off by `roundings` times the sum of that and of 2^-53 of the output (Higham, Accuracy and
 * Stability of Numerical Algorithms, 2nd ed., 1.6: small mixed forward and backward error): a dozen operations, and
 * room for vectors made unit on the way, whose length no input moves, and for groups of outputs. What cancels where
 * its problem doesn't is off by orders of magnitude more: 1 - F at grazing was by 1e6, a needle's normal by 1e4,
 * and are so no more (fresnel_dielectric_t, vec3_cross_exact).
 *
 * At u = 1 - 2^-53 a visible normal is perpendicular to its direction to 1e-8, and whether light passes there is
 * decided by rounding: `void_most` of the cases of a sampler may exist in one precision alone, as one in ten is
 * there. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "base/random.h"
#include "extended/probe.h"
#include "figures.h"
#include "math/frame.h"
#include "math/warp.h"

enum { CASES = 1000 };
static const probe_number_t roundings = 256, unit = 0x1p-53L;
static const double void_most = 0.01;

/* ---- hard inputs ---- */

typedef struct maker {
    uint64_t key, count;
    double *out;
    double alpha[2], eta, scale;
    int alphas;
    vec3_t wo, along, from; /* last w, d, p */
    char shape;             /* last one: t, s, o */
    vec3_t corners[3];
    vec3_t centre;
    double radius, half;
    vec3_t axis; /* last z */
    double rim;  /* 1 - cosine of the last cone's */
} maker_t;

static double next(maker_t *m)
{
    return random_double(m->key, m->count++);
}

/* 10^between(a, b) */
static double power(maker_t *m, double a, double b)
{
    return pow(10, a + (b - a) * next(m));
}

static void put(maker_t *m, double x)
{
    *m->out++ = x;
}

static void put_vec(maker_t *m, vec3_t v)
{
    put(m, v.x);
    put(m, v.y);
    put(m, v.z);
}

static double make_number(maker_t *m)
{
    const double choice = next(m), small = power(m, -16, 0), any = next(m);
    return choice < 0.1    ? 0
           : choice < 0.2  ? MATH_ONE_MINUS
           : choice < 0.35 ? fmin(small, MATH_ONE_MINUS)
           : choice < 0.5  ? fmin(1 - small, MATH_ONE_MINUS)
                           : any;
}

/* In (0,1]: grazing, straight on, near the edge of total reflection. */
static double make_cosine(maker_t *m)
{
    const double choice = next(m), small = power(m, -9, 0), near = power(m, -16, 0), any = next(m);
    if (choice < 0.3)
        return small;
    if (choice < 0.4)
        return 1 - near;
    if (choice < 0.5 && m->eta < 1)
        return fmin(1, sqrt((1 - m->eta) * (1 + m->eta)) * (1 + (any < 0.5 ? -near : near)));
    return 1 - any;
}

static vec3_t make_direction(maker_t *m)
{
    const double z = make_cosine(m), turn = make_number(m), r = sqrt((1 - z) * (1 + z));
    double s, c;
    warp_sincos_turns(turn, &s, &c);
    return vec3_unit(vec3(r * c, r * s, z));
}

static double make_index(maker_t *m)
{
    static const double special[] = {1.0001, 1 / 1.0001, 1.5, 1 / 1.5, 1.0000005, 20, 0.05, 0.9999995};
    return next(m) < 0.7 ? special[(int)(8 * next(m))] : power(m, -1, 1);
}

/* A facet within some alphas of the normal. */
static vec3_t make_facet(maker_t *m)
{
    const double width = power(m, -2, 1), turn = next(m);
    double s, c;
    warp_sincos_turns(turn, &s, &c);
    return vec3_unit(vec3(m->alpha[0] * width * c, m->alpha[1] * width * s, 1));
}

static vec3_t make_reflection(maker_t *m)
{
    const vec3_t facet = make_facet(m);
    return vec3_unit(vec3_sub(vec3_scale(facet, 2 * vec3_dot(m->wo, facet)), m->wo));
}

/* To the other side; any direction there where nothing is refracted. */
static vec3_t make_refraction(maker_t *m)
{
    const vec3_t facet = make_facet(m);
    const double c = vec3_dot(m->wo, facet), g2 = c * c + (m->eta - 1) * (m->eta + 1);
    if (!(c > 0 && g2 > 0))
        return vec3_neg(make_direction(m));
    return vec3_unit(vec3_sub(vec3_scale(facet, c - sqrt(g2)), m->wo));
}

static vec3_t make_place(maker_t *m)
{
    const double x = next(m), y = next(m), z = next(m);
    return vec3_scale(vec3(x, y, z), m->scale);
}

/* Corners in single precision; one in three a needle. */
static void put_triangle(maker_t *m)
{
    const vec3_t a = make_place(m), b = make_place(m);
    vec3_t c = make_place(m);
    if (next(m) < 0.35)
        c = vec3_mad(b, power(m, -6, -1), vec3_sub(c, b));
    const vec3_t corners[3] = {a, b, c};
    m->shape = 't';
    for (int i = 0; i < 3; i++) {
        m->corners[i] = vec3((float)corners[i].x, (float)corners[i].y, (float)corners[i].z);
        put_vec(m, m->corners[i]);
    }
}

static void put_round(maker_t *m, char shape)
{
    const vec3_t c = make_place(m);
    m->shape = shape;
    m->centre = vec3((float)c.x, (float)c.y, (float)c.z);
    m->radius = (float)(m->scale * power(m, -8, 0));
    put_vec(m, m->centre);
    put(m, m->radius);
}

/* A point of the last shape, from two numbers. */
static vec3_t make_point(const maker_t *m, double u, double v)
{
    if (m->shape == 't') {
        const vec2_t b = warp_triangle(u, v);
        return vec3_mad(vec3_mad(m->corners[0], b.x, vec3_sub(m->corners[1], m->corners[0])), b.y,
                        vec3_sub(m->corners[2], m->corners[0]));
    }
    const vec2_t p = warp_disk(u, v);
    return vec3_mad(m->centre, m->radius, m->shape == 's' ? warp_sphere(u, v) : vec3(p.x, p.y, 0));
}

static vec3_t make_corner_point(maker_t *m)
{
    const double u = make_number(m), v = make_number(m);
    return make_point(m, u, v);
}

/* From the last place to a point inside: at an edge, and only there, either precision may decide to move the hit.
 */
static vec3_t make_aim(maker_t *m)
{
    const double u = next(m), v = next(m);
    return vec3_unit(vec3_sub(make_point(m, u, v), m->from));
}

/* In the field of view around the last d. */
static vec3_t make_view(maker_t *m)
{
    const frame_t frame = frame_of_normal(m->along);
    const double x = m->half * (2 * next(m) - 1), y = m->half * (2 * next(m) - 1);
    return vec3_unit(vec3_mad(vec3_mad(m->along, x, frame.s), y, frame.t));
}

static void put_single(maker_t *m, vec3_t v)
{
    put_vec(m, vec3((float)v.x, (float)v.y, (float)v.z));
}

/* One in five black; a sky without light has no table. */
static void put_texels(maker_t *m)
{
    for (int i = 0; i < 9; i++) {
        const double choice = next(m), value = power(m, -6, 0);
        put(m, choice < 0.2 && i > 0 ? 0 : (float)value);
    }
}

static void put_rotation(maker_t *m)
{
    const frame_t frame = frame_of_normal(make_direction(m));
    put_single(m, frame.s);
    put_single(m, frame.t);
    put_single(m, frame.n);
}

/* From needles to half spaces, rims from thin to all of it. */
static void put_cone(maker_t *m)
{
    const float end = (float)(1 - power(m, -6.5, 0));
    m->rim = 1 - (double)end;
    put(m, (float)(1 - m->rim * (1 - power(m, -4, 0))));
    put(m, end);
}

/* In the cone, towards its rim as much as to its middle. */
static vec3_t make_in_cone(maker_t *m)
{
    const double choice = next(m), small = power(m, -6, 0);
    const vec3_t axis = vec3_unit(m->axis);
    const frame_t frame = frame_of_normal(axis);
    return frame_to_world(&frame, warp_cone(choice < 0.5 ? small : 1 - small, next(m), m->rim));
}

static void put_input(maker_t *m, char letter)
{
    switch (letter) {
    case 'u':
        put(m, make_number(m));
        return;
    case 'a':
        m->alpha[m->alphas++ & 1] = next(m) < 0.3 ? 1e-4 : power(m, -4, 0);
        put(m, m->alpha[(m->alphas - 1) & 1]);
        return;
    case 'e':
        put(m, m->eta = make_index(m));
        return;
    case 'i':
        put(m, power(m, -3, 1));
        return;
    case 'k':
        put(m, next(m) < 0.2 ? 0 : power(m, -3, 2.9));
        return;
    case 'c':
        put(m, make_cosine(m));
        return;
    case 'w':
        put_vec(m, m->wo = make_direction(m));
        return;
    case 'd': {
        const vec3_t w = make_direction(m);
        put_vec(m, m->along = next(m) < 0.5 ? w : vec3(w.x, w.y, -w.z));
        return;
    }
    case 'm':
        put_vec(m, make_reflection(m));
        return;
    case 'r':
        put_vec(m, make_refraction(m));
        return;
    case 'p':
        put_vec(m, m->from = make_place(m));
        return;
    case 't':
        put_triangle(m);
        return;
    case 's':
    case 'o':
        put_round(m, letter);
        return;
    case 'q':
        put_vec(m, make_corner_point(m));
        return;
    case 'h':
        put_vec(m, make_aim(m));
        return;
    case 'g':
        put_vec(m, make_facet(m));
        return;
    case 'f':
        put(m, m->half = power(m, -6, 1));
        return;
    case 'v':
        put_vec(m, make_view(m));
        return;
    case 'l':
        put(m, next(m) < 0.3 ? 0 : power(m, -4, 0));
        return;
    case 'x':
        put_texels(m);
        return;
    case 'b':
        put_rotation(m);
        return;
    case 'y':
        put_cone(m);
        return;
    case 'z': {
        const vec3_t w = make_direction(m);
        m->axis = vec3((float)w.x, (float)w.y, (float)w.z);
        put_vec(m, m->axis);
        return;
    }
    case 'j':
        put_vec(m, make_in_cone(m));
        return;
    default:
        fail_msg("no input is called '%c'", letter);
    }
}

static int make_inputs(const char *letters, uint64_t key, double *in)
{
    maker_t m = {.key = key, .out = in, .eta = 1, .alpha = {1, 1}};
    m.scale = power(&m, -6, 6);
    for (const char *c = letters; *c; c++)
        put_input(&m, *c);
    return (int)(m.out - in);
}

/* ---- comparison ---- */

typedef struct tally {
    int compared, void_both, void_one;
    probe_number_t worst[PROBE_MAX_GROUPS];          /* error over what is allowed */
    probe_number_t worst_relative[PROBE_MAX_GROUPS]; /* error over value */
    double at[PROBE_MAX_GROUPS][PROBE_MAX_INPUTS];
} tally_t;

static probe_number_t distance(const probe_number_t *a, const probe_number_t *b, uint32_t size)
{
    probe_number_t sum = 0;
    for (uint32_t i = 0; i < size; i++)
        sum += (a[i] - (b ? b[i] : 0)) * (a[i] - (b ? b[i] : 0));
    return sqrtl(sum);
}

/* What each group of outputs moves by when inputs move by half a unit. False if an output comes or goes. */
static bool find_condition(uint32_t which, const probe_info_t *info, const double *in, int inputs,
                           const probe_number_t *value, probe_number_t *moved)
{
    bool steady = true;
    memset(moved, 0, PROBE_MAX_GROUPS * sizeof *moved);
    for (int i = 0; i < inputs; i++) {
        probe_number_t most[PROBE_MAX_GROUPS] = {0};
        for (int side = -1; side <= 1; side += 2) {
            probe_number_t near[PROBE_MAX_INPUTS] = {0}, other[PROBE_MAX_OUTPUTS];
            for (int j = 0; j < inputs; j++)
                near[j] = in[j];
            near[i] *= 1 + side * unit;
            if (!probe_run_extended(which, near, other)) {
                steady = false;
                continue;
            }
            uint32_t first = 0;
            for (int g = 0; g < PROBE_MAX_GROUPS && info->outputs[g].name; g++) {
                most[g] = fmaxl(most[g], distance(other + first, value + first, info->outputs[g].size));
                first += info->outputs[g].size;
            }
        }
        for (int g = 0; g < PROBE_MAX_GROUPS; g++)
            moved[g] += most[g];
    }
    return steady;
}

static void compare(uint32_t which, const probe_info_t *info, uint64_t key, tally_t *tally)
{
    double in[PROBE_MAX_INPUTS] = {0};
    probe_number_t exact[PROBE_MAX_INPUTS] = {0}, found[PROBE_MAX_OUTPUTS], wanted[PROBE_MAX_OUTPUTS],
                   moved[PROBE_MAX_GROUPS];
    const int inputs = make_inputs(info->inputs, key, in);
    for (int i = 0; i < inputs; i++)
        exact[i] = in[i];
    const bool valid = probe_run_double(which, exact, found), expected = probe_run_extended(which, exact, wanted);
    if (!valid || !expected) {
        tally->void_both += !valid && !expected;
        tally->void_one += valid != expected;
        return;
    }
    const bool steady = find_condition(which, info, in, inputs, wanted, moved);
    tally->compared++;
    uint32_t first = 0;
    for (int g = 0; g < PROBE_MAX_GROUPS && info->outputs[g].name; g++) {
        const uint32_t size = info->outputs[g].size;
        const probe_number_t scale = fmaxl(distance(wanted + first, NULL, size), info->outputs[g].least),
                             off = distance(found + first, wanted + first, size),
                             allowed = roundings * (unit * scale + moved[g]) + 0x1p-1000L;
        for (uint32_t i = first; i < first + size; i++)
            if (!isfinite((double)found[i]))
                fail_msg("%s: %s is %Lg, expected %Lg", info->name, info->outputs[g].name, found[i], wanted[i]);
        first += size;
        if (!steady)
            continue;
        if (off > tally->worst[g] * allowed) {
            tally->worst[g] = off / allowed;
            memcpy(tally->at[g], in, sizeof in);
        }
        if (scale > 0)
            tally->worst_relative[g] = fmaxl(tally->worst_relative[g], off / scale);
    }
}

static void report(const probe_info_t *info, const tally_t *tally)
{
    print_message("%s: %d cases, %d void, %d void in one precision\n", info->name, tally->compared,
                  tally->void_both, tally->void_one);
    for (int g = 0; g < PROBE_MAX_GROUPS && info->outputs[g].name; g++) {
        print_message("    %s: %.2Lg of what is allowed, off by %.2Lg relative at most\n", info->outputs[g].name,
                      tally->worst[g], tally->worst_relative[g]);
        if (tally->worst[g] <= 1)
            continue;
        print_message("        at");
        for (int i = 0; i < PROBE_MAX_INPUTS; i++)
            print_message(" %.17g", tally->at[g][i]);
        print_message("\n");
    }
}

static void doubles_are_as_good_as_their_inputs(void **state)
{
    (void)state;
    hard_case("precision");
    const probe_info_t *info;
    int failed = 0;
    for (uint32_t which = 0; (info = probe_info_double(which)); which++) {
        tally_t tally = {0};
        const uint32_t cases = CASES / (info->one_in ? info->one_in : 1);
        for (uint32_t i = 0; i < cases; i++)
            compare(which, info, random_key(61, RANDOM_PURPOSE_TEST, which, i), &tally);
        report(info, &tally);
        for (int g = 0; g < PROBE_MAX_GROUPS; g++) {
            hard_record(HARD_DOUBLE, g == 0 ? tally.compared : 0, (double)tally.worst[g]);
            failed += !(tally.worst[g] <= 1);
        }
        failed += !(tally.void_one <= void_most * cases);
        failed += !(tally.compared >= (int)cases / 4);
    }
    assert_int_equal(failed, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(doubles_are_as_good_as_their_inputs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
