#include "hard.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "chain/target.h"
#include "client/import/pbrt.h"
#include "load.h"
#include "reference.h"
#include "scene/builder.h"

/* ---- scenes as text ---- */

static FILE *text_file;
static char *text;
static size_t text_size;
static scene_builder_t *builder;
static scene_t scene_view;

FILE *hard_begin(const char *camera, double fov, uint32_t side)
{
    hard_clear();
    text_file = open_memstream(&text, &text_size);
    assert_non_null(text_file);
    const double half = tan(fov * (MATH_PI / 360)); /* narrower than the format's field of view may be */
    fprintf(text_file,
            "%s\nPixelFilter \"box\" \"float xradius\" [ 0.5 ] \"float yradius\" [ 0.5 ]\n"
            "Film \"rgb\" \"string filename\" [ \"image.exr\" ] \"integer xresolution\" [ %u ] \"integer "
            "yresolution\" [ %u ]\n"
            "Camera \"perspective\" \"float fov\" [ 90 ] \"float screenwindow\" [ %.17g %.17g %.17g %.17g "
            "]\nWorldBegin\n",
            camera, side, side, -half, half, -half, half);
    return text_file;
}

const scene_t *hard_end(const char *name)
{
    fault_t fault = {0};
    fclose(text_file);
    text_file = NULL;
    builder = scene_builder_new();
    if (pbrt_read_text(name, ".", text, text_size, builder, NULL, &fault))
        fail_msg("%s", fault.text);
    scene_view = scene_builder_view(builder);
    if (scene_check(&scene_view, &fault))
        fail_msg("%s: %s", name, fault.text);
    return &scene_view;
}

const scene_t *hard_load(const char *name)
{
    hard_clear();
    return load_scene(name);
}

void hard_clear(void)
{
    if (text_file)
        fclose(text_file);
    text_file = NULL;
    free(text);
    text = NULL;
    scene_builder_destroy(&builder);
    load_clear();
}

void hard_quad(FILE *f, vec3_t a, vec3_t b, vec3_t c, vec3_t d)
{
    const vec3_t p[4] = {a, b, c, d};
    fprintf(f, "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2 0 2 3 ] \"point3 P\" [");
    for (int i = 0; i < 4; i++)
        fprintf(f, " %.9g %.9g %.9g", p[i].x, p[i].y, p[i].z);
    fprintf(f, " ]\n");
}

void hard_box(FILE *f, vec3_t l, vec3_t h, bool inwards)
{
    const vec3_t c[8] = {vec3(l.x, l.y, l.z), vec3(h.x, l.y, l.z), vec3(l.x, h.y, l.z), vec3(h.x, h.y, l.z),
                         vec3(l.x, l.y, h.z), vec3(h.x, l.y, h.z), vec3(l.x, h.y, h.z), vec3(h.x, h.y, h.z)};
    static const int face[6][4] = {{0, 4, 5, 1}, {2, 3, 7, 6}, {0, 1, 3, 2},
                                   {4, 6, 7, 5}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    for (int i = 0; i < 6; i++) {
        const int *q = face[i];
        if (inwards)
            hard_quad(f, c[q[0]], c[q[1]], c[q[2]], c[q[3]]);
        else
            hard_quad(f, c[q[0]], c[q[3]], c[q[2]], c[q[1]]);
    }
}

void hard_furnace_walls(FILE *f, double albedo, double emission)
{
    fprintf(
        f,
        "Material \"diffuse\" \"rgb reflectance\" [ %.9g %.9g %.9g ]\nAreaLightSource \"diffuse\" \"rgb L\" [ %.9g "
        "%.9g %.9g ]\n",
        albedo, albedo, albedo, emission, emission, emission);
}

/* ---- jobs ---- */

/* Values refused before the film, per evaluation: each is a path lost. None is expected but those whose single
 * ratios of densities leave double's range. */
static const double refused_most = 1e-6;

static void check_refused(const render_t *render, const char *name, const hard_job_t *job)
{
    const json_t *rejected = json_get(render->report, "rejected");
    static const char *const before[] = {"nonfinite_ray", "nonfinite_weight", "nonfinite_value", "negative_value"};
    double refused = 0;
    for (size_t i = 0; i < sizeof before / sizeof *before; i++) {
        const double n = json_number(json_get(rejected, before[i]));
        refused += n;
        if (n > 0)
            print_message("%s, %s: %s %g\n", name, job->algorithm, before[i], n);
    }
    const double nonfinite = json_number(json_get(rejected, "film_nonfinite")),
                 negative = json_number(json_get(rejected, "film_negative"));
    if (nonfinite != 0 || negative != 0)
        fail_msg("%s, %s: the film met %g non-finite and %g negative values", name, job->algorithm, nonfinite,
                 negative);
    const double evaluations = job->work * job->side * job->side;
    hard_record(HARD_REFUSED, evaluations, refused);
    if (!(refused <= refused_most * evaluations))
        fail_msg("%s, %s: %g values refused of %g", name, job->algorithm, refused, evaluations);
    for (uint32_t i = 0; i < render->image.width * render->image.height; i++)
        for (uint32_t c = 0; c < 3; c++) {
            const float v = image_channel(&render->image, c)[i];
            if (!(v >= 0 && v < HUGE_VALF))
                fail_msg("%s, %s: channel %u of pixel %u is %g", name, job->algorithm, c, i, (double)v);
        }
}

void hard_render(render_t *render, const char *name, const scene_t *scene, const hard_job_t *job)
{
    char json[512];
    snprintf(json, sizeof json,
             "{\"scene\":\"x\",\"film\":{\"width\":%u,\"height\":%u},\"algorithm\":\"%s\",\"max_path_length\":%u,"
             "\"seed\":\"%llu\",\"chains\":{\"pilot_samples\":%u},\"stop\":{\"mutations_per_pixel\":%.17g}}",
             job->side, job->side, job->algorithm, job->length, (unsigned long long)job->seed,
             job->pilot ? job->pilot : 4096, job->work);
    render_run(render, scene, json);
    check_refused(render, name, job);
}

render_estimate_t hard_mean(const render_t *render, const hard_job_t *job)
{
    render_estimate_t mean = {0, 0};
    const double pixels = (double)job->side * job->side;
    for (uint32_t k = 1; k <= job->length; k++) {
        const render_estimate_t b = render_length(render, k);
        mean.value += b.value / pixels;
        mean.error += b.error * b.error / (pixels * pixels);
    }
    mean.error = sqrt(mean.error);
    return mean;
}

static const char *const algorithms[] = {"pt", "bdpt", "mmlt"};
enum { ALGORITHMS = 3 };

/* One job's work is taken so many times by each: a sample of bdpt joins the square of what one of pt does, a
 * mutation makes a path of one length. */
static const double shares_of_work[ALGORITHMS] = {2, 0.5, 16};

static hard_job_t job_of(hard_job_t job, int algorithm)
{
    job.algorithm = algorithms[algorithm];
    job.work *= shares_of_work[algorithm];
    return job;
}

void hard_expect_between(const char *name, const scene_t *scene, hard_job_t base, double low, double high)
{
    print_message("%s: expected %.6f to %.6f;", name, low, high);
    for (int a = 0; a < ALGORITHMS; a++) {
        const hard_job_t job = job_of(base, a);
        render_t render;
        hard_render(&render, name, scene, &job);
        const render_estimate_t mean = hard_mean(&render, &job);
        print_message(" %s %.6f +- %.1g", job.algorithm, mean.value, mean.error);
        const double beyond = fmax(0, fmax(low - mean.value, mean.value - high));
        hard_record(HARD_ENERGY, 1, beyond > 0 ? beyond / mean.error : 0);
        if (mean.error < 0.05 * mean.value)
            hard_record(HARD_OFF, 1, beyond / mean.value);
        if (!(mean.value >= low - HARD_Z * mean.error && mean.value <= high + HARD_Z * mean.error))
            fail_msg("%s, %s: mean %.9g +- %.3g, expected %.9g to %.9g", name, job.algorithm, mean.value,
                     mean.error, low, high);
        render_clear(&render);
    }
    print_message("\n");
}

void hard_expect_mean(const char *name, const scene_t *scene, hard_job_t job, double expected, double slack)
{
    hard_expect_between(name, scene, job, expected * (1 - slack), expected * (1 + slack));
}

void hard_expect_lengths(const char *name, const scene_t *scene, hard_job_t base, const double *expected,
                         double slack)
{
    print_message("%s: largest |z| of b_k", name);
    for (int a = 0; a < ALGORITHMS; a++) {
        const hard_job_t job = job_of(base, a);
        render_t render;
        hard_render(&render, name, scene, &job);
        double worst = 0;
        for (uint32_t k = 1; k <= job.length; k++) {
            const double want = expected[k];
            const render_estimate_t b = render_length(&render, k);
            worst = fmax(worst, fabs(b.value - want) / (b.error + slack * want + 1e-300));
            if (!(fabs(b.value - want) <= HARD_Z * b.error + slack * want))
                fail_msg("%s, %s: b_%u = %.9g +- %.3g, expected %.9g", name, job.algorithm, k, b.value, b.error,
                         want);
        }
        const render_estimate_t mean = hard_mean(&render, &job);
        double sum = 0;
        for (uint32_t k = 1; k <= job.length; k++)
            sum += expected[k] / ((double)job.side * job.side);
        print_message(", %s %.2f (mean %.5f)", job.algorithm, worst, mean.value);
        hard_record(HARD_ENERGY, job.length, worst);
        hard_record(HARD_OFF, 1, fabs(mean.value / sum - 1));
        render_clear(&render);
    }
    print_message("\n");
}

void hard_expect_furnace(const char *name, const scene_t *scene, hard_job_t job, double albedo, double emission)
{
    double expected[PATH_MAX_VERTICES];
    for (uint32_t k = 1; k <= job.length; k++)
        expected[k] = (double)job.side * job.side * emission * pow(albedo, k - 1);
    /* emission and albedo are in single precision, k times */
    hard_expect_lengths(name, scene, job, expected, 1e-7 * job.length);
}

/* ---- the target ---- */

/* The condition of a path, in units of 2^-52: directions recomputed from positions are off by d = largest
 * coordinate / distance, which changes a cosine by d relative to the cosine, and the value of a lobe of width alpha
 * by d / alpha (a half vector of length h: d / (alpha h); materials.md). */
static double lobe_condition(const path_vertex_t *v)
{
    double worst = 0;
    for (uint32_t l = 0; v->bsdf && l < v->bsdf->count; l++) {
        const bsdf_lobe_t *lobe = &v->bsdf->lobes[l];
        if (lobe->kind == BSDF_DIFFUSE || lobe->kind == BSDF_DIFFUSE_TRANSMIT || lobe->kind == BSDF_COATED_BASE ||
            BSDF_KIND_IS_SPECULAR(lobe->kind))
            continue;
        const double half = lobe->kind == BSDF_DIELECTRIC ? fmin(1, fabs(lobe->eta - 1)) : 1;
        worst = fmax(worst, 1 / (fmin(lobe->alpha_u, lobe->alpha_v) * half));
    }
    return worst;
}

/* A spot light's rim, where its intensity goes to zero with the square of t, the place between the cones. */
static double spot_condition(const path_scene_t *ps, const path_vertex_t *v, vec3_t w)
{
    if (v->kind != PATH_LIGHT || ps->lights.emitters[v->emitter].kind != LIGHT_SPOT)
        return 0;
    const light_emitter_t *e = &ps->lights.emitters[v->emitter];
    const double rim = fabs(vec3_dot(w, e->normal)) - e->cos_end;
    return rim > 0 ? 2 / rim : 1e300;
}

static double end_condition(const path_scene_t *ps, const path_vertex_t *v, vec3_t w)
{
    const double g = vec3_dot(v->ng, v->ng) > 0 ? fabs(vec3_dot(v->ng, w)) : 1; /* point lights have no normal */
    const double s = v->bsdf ? fabs(vec3_dot(v->frame.n, w)) : 1;
    return 1 / g + 1 / s + lobe_condition(v) + spot_condition(ps, v, w);
}

static double path_condition(const path_scene_t *ps, const path_space_t *space, uint32_t s, uint32_t t)
{
    const path_vertex_t *x[PATH_MAX_VERTICES];
    double sum = 8;
    for (uint32_t i = 0; i < s + t; i++)
        x[i] = i < s ? &space->light[i] : &space->camera[s + t - 1 - i];
    for (uint32_t i = 0; i + 1 < s + t; i++) {
        if (x[i]->kind == PATH_INFINITE)
            continue;
        const vec3_t d = vec3_sub(x[i + 1]->position, x[i]->position);
        const double length = vec3_length(d);
        const double off = fmax(1, fmax(vec3_max_abs(x[i]->position), vec3_max_abs(x[i + 1]->position)) / length);
        sum += off * (end_condition(ps, x[i], vec3_scale(d, 1 / length)) +
                      end_condition(ps, x[i + 1], vec3_scale(d, 1 / length)));
    }
    return sum;
}

/* Rounding errors per unit of condition. A hit that rounding put outside its triangle is moved to the edge by at
 * most 2^-20 of the coordinates: few paths, held to a tolerance that is larger in proportion. */
static const double roundings = 16, edge = 0x1p32;
static const double share_at_edges = 2e-3, share_hugging_off = 0.1;

typedef struct tally {
    uint32_t compared, off;
    uint32_t hugging, hugging_off;
    double worst, worst_inside, worst_condition; /* inside: of those that their condition allows */
} tally_t;

/* Whether a segment leaves or meets a surface so flatly, or is so short, that it stays within the distance by which
 * rays start off surfaces (surface.h): single precision cannot say what it passes. */
static bool path_hugs_surface(const path_space_t *space, uint32_t s, uint32_t t)
{
    const path_vertex_t *x[PATH_MAX_VERTICES];
    for (uint32_t i = 0; i < s + t; i++)
        x[i] = i < s ? &space->light[i] : &space->camera[s + t - 1 - i];
    for (uint32_t i = 0; i + 1 < s + t; i++) {
        if (x[i]->kind == PATH_INFINITE)
            continue;
        const vec3_t d = vec3_sub(x[i + 1]->position, x[i]->position);
        const double most = 2 * fmax(x[i]->epsilon, x[i + 1]->epsilon);
        for (uint32_t j = i; j <= i + 1; j++) /* point lights have no normal */
            if (vec3_dot(x[j]->ng, x[j]->ng) > 0 && fabs(vec3_dot(d, x[j]->ng)) < most)
                return true;
    }
    return false;
}

static bool make_path(const path_scene_t *ps, path_space_t *space, const target_t *target, uint32_t s, uint64_t key,
                      const hard_invariance_t *options, path_value_t *value)
{
    double camera[PATH_MAX_DIMENSIONS], light[PATH_MAX_DIMENSIONS];
    for (uint32_t i = 0; i < target->camera_count; i++)
        camera[i] = random_double(key, i);
    for (uint32_t i = 0; i < target->light_count; i++)
        light[i] = random_double(key, 1000 + i);
    if (options->spoil) {
        options->spoil(camera + 2, target->camera_count - 2, random_u64(key, 2000));
        options->spoil(light, target->light_count, random_u64(key, 2001));
    }
    const uint32_t t = target->length + 1 - s;
    return path_walk_camera(ps, space, camera, t, PATH_ENDS_ANYWHERE) == t &&
           (s == 0 || path_walk_light(ps, space, light, s, PATH_ENDS_ANYWHERE) == s) &&
           path_connect(ps, space, s, t, NULL, &target->techniques, value);
}

static void compare_path(const char *name, const path_scene_t *ps, path_space_t *space, const target_t *target,
                         uint32_t s, uint64_t key, const hard_invariance_t *options, tally_t *tally)
{
    path_value_t value;
    const uint32_t t = target->length + 1 - s;
    if (!make_path(ps, space, target, s, key, options, &value))
        return;
    reference_t reference;
    reference_evaluate(ps, space, s, t, &target->techniques, &reference);
    const bool hugging = path_hugs_surface(space, s, t), possible = reference.valid && reference.p[s] > 0;
    const double condition = path_condition(ps, space, s, t) * 0x1p-52;
    const double found[3] = {value.value.r, value.value.g, value.value.b};
    bool off = !possible; /* a microfacet at the horizon, on its other side after rounding */
    for (int c = 0; c < 3 && possible; c++) {
        const double expected = (double)(reference.f[c] / reference.sum);
        if (expected == 0 && found[c] == 0)
            continue;
        assert_true(isfinite(found[c]) && found[c] >= 0);
        const double error = fabs(found[c] - expected) / fmax(fabs(found[c]), fabs(expected));
        off |= !(error <= roundings * condition);
        if (hugging)
            continue;
        tally->worst = fmax(tally->worst, error);
        if (error <= roundings * condition) {
            tally->worst_inside = fmax(tally->worst_inside, error);
            tally->worst_condition = fmax(tally->worst_condition, error / condition);
        }
        if (roundings * condition < 1 && !(error <= fmin(0.5, edge * condition)))
            fail_msg("%s, length %u, s = %u: channel %d is %.12g, by definition %.12g; condition %g", name,
                     target->length, s, c, found[c], expected, condition);
    }
    *(hugging ? &tally->hugging_off : &tally->off) += off;
    *(hugging ? &tally->hugging : &tally->compared) += 1;
}

void hard_expect_invariance(const char *name, const scene_t *scene, const hard_invariance_t *options)
{
    fault_t fault = {0};
    path_scene_t ps;
    if (path_scene_init(&ps, scene, scene->camera, 0, 0, &fault))
        fail_msg("%s: %s", name, fault.text);
    path_space_t *space = path_space_new();
    settings_t settings;
    settings_default(&settings);
    tally_t tally = {0};
    for (uint32_t k = options->shortest; k <= options->longest; k++) {
        target_t target;
        target_init(&target, &ps, &settings, k);
        for (uint32_t i = 0; i < options->paths && target.count > 0; i++)
            compare_path(name, &ps, space, &target, target.list[i % target.count],
                         random_key(7, RANDOM_PURPOSE_TEST, k, i), options, &tally);
    }
    print_message(
        "%s: %u paths, %u at edges, worst %.2g relative, %.2g of the rounding its condition allows; %u hug a "
        "surface, %u of them off; refused %llu %llu %llu %llu\n",
        name, tally.compared, tally.off, tally.worst, tally.worst_condition / roundings, tally.hugging,
        tally.hugging_off, (unsigned long long)space->rejects[0], (unsigned long long)space->rejects[1],
        (unsigned long long)space->rejects[2], (unsigned long long)space->rejects[3]);
    hard_record(HARD_TARGET, tally.compared, tally.worst_inside);
    hard_record(HARD_EDGES, tally.compared, tally.off);
    assert_true(tally.compared >= options->least);
    assert_true(tally.off <= 1 + share_at_edges * tally.compared);
    assert_true(tally.hugging_off <= 1 + share_hugging_off * tally.hugging);
    for (int i = 0; i < PATH_REJECTS; i++)
        assert_true(space->rejects[i] <= refused_most * tally.compared);
    free(space);
    path_scene_clear(&ps);
}

double hard_leaks(const scene_t *scene, uint32_t walks, uint32_t length)
{
    fault_t fault = {0};
    path_scene_t ps;
    if (path_scene_init(&ps, scene, scene->camera, 0, 0, &fault))
        fail_msg("%s", fault.text);
    path_space_t *space = path_space_new();
    double u[PATH_MAX_DIMENSIONS];
    uint64_t leaks = 0, segments = 0;
    for (uint32_t i = 0; i < walks; i++) {
        const uint64_t key = random_key(9, RANDOM_PURPOSE_TEST, length, i);
        for (uint32_t d = 0; d < path_camera_dimensions(&ps, length + 1); d++)
            u[d] = random_double(key, d);
        const uint32_t vertices = path_walk_camera(&ps, space, u, length + 1, PATH_ENDS_ANYWHERE);
        segments += vertices;
        leaks += vertices <= length;
    }
    free(space);
    path_scene_clear(&ps);
    hard_record(HARD_LEAKS, (double)segments, (double)leaks);
    return (double)leaks / (double)segments;
}
