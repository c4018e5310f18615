/* Numbers of exactly 0 and of the largest double below 1, in every dimension of both streams, on every scene of the
 * project; shading normals that disagree with their surface. */
#include "hard.h"

#include <dirent.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "chain/target.h"
#include "support/sanitized.h"

/* ---- the ends of [0,1) ---- */

enum { LENGTHS = 6, RANDOM_ROUNDS = 40 };

typedef struct trial {
    const char *name;
    path_scene_t ps;
    path_space_t *space;
    uint64_t evaluated, lit;
} trial_t;

static void evaluate(trial_t *trial, const target_t *target, uint32_t s, const double *camera, const double *light)
{
    target_value_t value = {.c = 0};
    target_eval(target, trial->space, s, camera, light, &value);
    trial->evaluated++;
    if (value.c == 0)
        return;
    trial->lit++;
    const double sum = value.color.r + value.color.g + value.color.b + value.raster.x + value.raster.y;
    if (!(value.c > 0) || !isfinite(value.c) || !isfinite(sum) || !(value.color.r >= 0) || !(value.color.g >= 0) ||
        !(value.color.b >= 0))
        fail_msg("%s, length %u, s = %u: C is %g, color %g %g %g at %g, %g", trial->name, target->length, s,
                 value.c, value.color.r, value.color.g, value.color.b, value.raster.x, value.raster.y);
}

/* Numbers of a stream: each is 0, the largest below 1, or random, by `share` of the first two. */
static void draw(double *u, uint32_t count, uint64_t key, double share)
{
    for (uint32_t i = 0; i < count; i++) {
        const double choice = random_double(key, 2 * i);
        u[i] = choice < share / 2 ? 0 : choice < share ? MATH_ONE_MINUS : random_double(key, 2 * i + 1);
    }
}

static void try_technique(trial_t *trial, const target_t *target, uint32_t s, uint64_t key)
{
    double camera[PATH_MAX_DIMENSIONS], light[PATH_MAX_DIMENSIONS];
    for (int i = 0; i < 4; i++) { /* all of a stream at one end */
        for (uint32_t d = 0; d < target->camera_count; d++)
            camera[d] = i & 1 ? MATH_ONE_MINUS : 0;
        for (uint32_t d = 0; d < target->light_count; d++)
            light[d] = i & 2 ? MATH_ONE_MINUS : 0;
        evaluate(trial, target, s, camera, light);
    }
    for (uint32_t d = 0; d < target->camera_count + target->light_count; d++) /* one number at an end */
        for (int end = 0; end < 6; end++) {
            draw(camera, target->camera_count, random_step(key, d * 12 + (uint32_t)end), 0);
            draw(light, target->light_count, random_step(key, d * 12 + 6 + (uint32_t)end), 0);
            double *u = d < target->camera_count ? &camera[d] : &light[d - target->camera_count];
            *u = end & 1 ? MATH_ONE_MINUS : 0;
            evaluate(trial, target, s, camera, light);
        }
    for (uint32_t round = 0; round < RANDOM_ROUNDS; round++) { /* some, and many */
        draw(camera, target->camera_count, random_step(key, 100000 + 2 * round), round & 1 ? 0.2 : 0.6);
        draw(light, target->light_count, random_step(key, 100001 + 2 * round), round & 1 ? 0.2 : 0.6);
        evaluate(trial, target, s, camera, light);
    }
}

static void try_scene(const char *name)
{
    const scene_t *scene = hard_load(name);
    fault_t fault = {0};
    trial_t trial = {.name = name, .space = path_space_new()};
    if (path_scene_init(&trial.ps, scene, scene->camera, 0, 0, &fault))
        fail_msg("%s: %s", name, fault.text);
    settings_t settings;
    settings_default(&settings);
    for (uint32_t k = 1; k <= LENGTHS; k++) {
        target_t target;
        target_init(&target, &trial.ps, &settings, k);
        for (uint32_t i = 0; i < target.count; i++)
            try_technique(&trial, &target, target.list[i], random_key(41, RANDOM_PURPOSE_TEST, k, target.list[i]));
    }
    const uint64_t *rejects = trial.space->rejects;
    print_message(
        "%s: %llu evaluations, %llu carry light, refused: %llu rays, %llu weights, %llu values, %llu negative\n",
        name, (unsigned long long)trial.evaluated, (unsigned long long)trial.lit, (unsigned long long)rejects[0],
        (unsigned long long)rejects[1], (unsigned long long)rejects[2], (unsigned long long)rejects[3]);
    hard_record(HARD_REFUSED, (double)trial.evaluated, (double)(rejects[0] + rejects[1] + rejects[2] + rejects[3]));
    assert_true(trial.lit > 0);
    /* what is refused: numbers at their ends put vertices into corners of the scene, where distances vanish */
    assert_true(rejects[PATH_REJECT_RAY] + rejects[PATH_REJECT_VALUE] + rejects[PATH_REJECT_NEGATIVE] == 0);
    assert_true(rejects[PATH_REJECT_WEIGHT] <= 1e-3 * trial.evaluated);
    path_scene_clear(&trial.ps);
    free(trial.space);
    hard_clear();
}

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

static void ends_of_the_interval_on_every_scene(void **state)
{
    (void)state;
    hard_case("ends");
    enum { MOST = 256, NAME = 128 };
    static char names[MOST][NAME];
    char folder[4096];
    size_t count = 0;
    const char *tests = getenv("GARLAND_TESTS");
    snprintf(folder, sizeof folder, "%s/scenes", tests ? tests : "tests");
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (const struct dirent *entry = readdir(dir); entry; entry = readdir(dir)) {
        const char *dot = strrchr(entry->d_name, '.');
        if (!dot || strcmp(dot, ".pbrt") != 0 || count == MOST || dot - entry->d_name >= NAME)
            continue;
        memcpy(names[count], entry->d_name, (size_t)(dot - entry->d_name));
        names[count++][dot - entry->d_name] = 0;
    }
    closedir(dir);
    assert_true(count >= 10);
    qsort(names, count, NAME, by_name);
    for (size_t i = 0; i < count; i++)
        try_scene(names[i]);
}

/* ---- normals that disagree ---- */

/* A coarse sphere (16 x 8 facets) around `centre` whose normals are random: anything from right to turned away by
 * 90 degrees and more. */
static void add_wild_sphere(FILE *f, double radius, uint64_t key)
{
    enum { AROUND = 16, UP = 8 };
    fprintf(f, "Shape \"trianglemesh\" \"integer indices\" [");
    for (int j = 0; j < UP; j++)
        for (int i = 0; i < AROUND; i++) {
            const int a = j * (AROUND + 1) + i, b = a + 1, c = a + AROUND + 1, d = c + 1;
            if (j > 0)
                fprintf(f, " %d %d %d", a, c, b);
            if (j + 1 < UP)
                fprintf(f, " %d %d %d", b, c, d);
        }
    fprintf(f, " ] \"point3 P\" [");
    for (int j = 0; j <= UP; j++)
        for (int i = 0; i <= AROUND; i++) {
            const double t = MATH_PI * j / UP, p = 2 * MATH_PI * (i % AROUND) / AROUND;
            fprintf(f, " %.9g %.9g %.9g", radius * sin(t) * cos(p), radius * cos(t), radius * sin(t) * sin(p));
        }
    fprintf(f, " ] \"normal N\" [");
    for (int i = 0; i < (UP + 1) * (AROUND + 1); i++) {
        const double z = 2 * random_double(key, 2 * (uint64_t)i) - 1,
                     p = 2 * MATH_PI * random_double(key, 2 * (uint64_t)i + 1);
        fprintf(f, " %.9g %.9g %.9g", sqrt(1 - z * z) * cos(p), sqrt(1 - z * z) * sin(p), z);
    }
    fprintf(f, " ]\n");
}

/* With shading normals a Lambertian vertex sends rho or less of the uniform radiance around it to any direction:
 * rho times the share of the cosine hemisphere around the normal that is on the surface's side. So nothing is
 * brighter than the furnace without it. */
static void wild_normals_add_no_light(void **state)
{
    (void)state;
    hard_case("normals");
    FILE *f = hard_begin("LookAt 0.1 0.2 0.95  0 0 0  0 1 0", 70, 4);
    fprintf(f, "AttributeBegin\n");
    hard_furnace_walls(f, 0.5, 1);
    hard_box(f, vec3(-1, -1, -1), vec3(1, 1, 1), true);
    fprintf(f, "AttributeEnd\nMaterial \"diffuse\" \"rgb reflectance\" [ 1 1 1 ]\n");
    add_wild_sphere(f, 0.6, 42);
    hard_expect_between("white sphere of random normals in a furnace", hard_end("wild furnace"),
                        (hard_job_t){.side = 4, .length = 16, .work = 200, .seed = 42}, 0.5, 2);
    hard_clear();
}

static void check_wild(const char *name, const char *material)
{
    FILE *f = hard_begin("LookAt 0 1 3.9  0 0.8 0  0 1 0", 38, 8);
    fprintf(f, "Material \"diffuse\" \"rgb reflectance\" [ 0.7 0.6 0.5 ]\n");
    hard_box(f, vec3(-1, 0, -1), vec3(1, 2, 4), true);
    fprintf(f, "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 4 4 4 ]\n");
    hard_quad(f, vec3(-0.5, 1.95, -0.5), vec3(0.5, 1.95, -0.5), vec3(0.5, 1.95, 0.5), vec3(-0.5, 1.95, 0.5));
    fprintf(f, "AttributeEnd\n%s\nTranslate 0 0.7 0\n", material);
    add_wild_sphere(f, 0.6, 43);
    const scene_t *scene = hard_end(name);
    hard_expect_invariance(name, scene, &(hard_invariance_t){1, 5, 3000, 3000, NULL});
    hard_expect_round_trips(name, scene, &(hard_round_trip_t){1, 5, 1000, 1000, 1e-3, 0.1});
    hard_agree(name, scene, (hard_job_t){.side = 8, .length = 4, .work = 8});
    hard_clear();
}

static void wild_normals_agree(void **state)
{
    (void)state;
    hard_case("normals");
    if (SANITIZED)
        skip();
    check_wild("random normals, Lambertian", "Material \"diffuse\" \"rgb reflectance\" [ 0.8 0.8 0.8 ]");
    check_wild("random normals, metal",
               "Material \"conductor\" \"float roughness\" [ 0.3 ] \"bool remaproughness\" [ false ]");
    check_wild("random normals, glass", "Material \"dielectric\" \"float eta\" [ 1.5 ]");
    check_wild("random normals, rough glass", "Material \"dielectric\" \"float eta\" [ 1.5 ] \"float roughness\" [ "
                                              "0.3 ] \"bool remaproughness\" [ false ]");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ends_of_the_interval_on_every_scene),
        cmocka_unit_test(wild_normals_add_no_light),
        cmocka_unit_test(wild_normals_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
