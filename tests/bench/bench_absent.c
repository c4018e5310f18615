/* bench_absent: what is absent costs nothing, and what leaving things out saves: docs/effects.md.
 *
 *     bench_absent [--scenes a,b] [--algorithm mmlt] [--units 24] [--turns 7] [--seeds 4] [--mutations 60] [--json
 * FILE]
 *
 * Units of work are run on a scene as it is, on one with features that nothing uses, and on one with features that
 * change nothing forced on (absent_scene.h), one after the other. The first two get the same units: what comes out
 * must be the same to the bit. The third gets its own plan's, as surfaces with textures have other tangents. Of
 * each unit the least CPU time of all turns counts; printed are ratios of the sums to those of the scene as it is,
 * with twice the standard error that the units' ratios leave them.
 *
 * Whole renders without the techniques of negligible energy and with all of them are compared by CPU time x relMSE,
 * pilots aside, as the renders estimate it: mutations are others, so that time alone says nothing. Geometric mean
 * over seeds, twice its standard error. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fail.h"
#include "absent_scene.h"
#include "base/clock.h"
#include "base/random.h"
#include "options.h"
#include "parallel.h"

enum { MAX_UNITS = 256, MAX_SEEDS = 100, SIDE = 64, PILOT = 65536 };
typedef enum absent_way { PLAIN = 0, UNUSED, FORCED, WAYS } absent_way_t;

static const char usual_scenes[] =
    "diffuse,glossy,glass,environment,sky,delta-lights,lens,transmission,normals,tiny-light,courtyard,caustics";
static const atomic_bool never = false;

typedef struct bench {
    options_scenes_t list;
    const char *algorithm;
    double mutations;
    unsigned units, turns, seeds;
} bench_t;

/* Twice the standard error is relative. */
typedef struct ratio {
    double value, error;
} ratio_t;

static void bench_options(bench_t *bench, int argc, char **argv)
{
    static const char *const names[] = {"--scenes", "--algorithm", "--units", "--turns",
                                        "--seeds",  "--mutations", "--json",  NULL};
    options_expect(argc, argv, names);
    options_scenes(&bench->list, argc, argv, usual_scenes);
    bench->algorithm = options_value(argc, argv, "--algorithm");
    bench->algorithm = bench->algorithm ? bench->algorithm : "mmlt";
    bench->units = (unsigned)options_number(argc, argv, "--units", 24, 2, MAX_UNITS);
    bench->turns = (unsigned)options_number(argc, argv, "--turns", 7, 1, 1000);
    bench->seeds = (unsigned)options_number(argc, argv, "--seeds", 4, 2, MAX_SEEDS);
    bench->mutations = options_number(argc, argv, "--mutations", 60, 40, 1e6);
}

static job_t bench_job(const bench_t *bench, const peer_scene_t *entry, bool all, unsigned seed)
{
    fault_t fault = {0};
    char text[512];
    job_t job;
    snprintf(text, sizeof text,
             "{\"scene\":\"%s\",\"film\":{\"width\":%d,\"height\":%d},\"algorithm\":\"%s\",\"max_path_length\":%u,"
             "\"seed\":\"%u\",\"chains\":{\"pilot_samples\":%d},\"effects\":{\"all_techniques\":\"%s\"},"
             "\"stop\":{\"mutations_per_pixel\":%.17g}}",
             entry->name, SIDE, SIDE, bench->algorithm, entry->max_path_length, seed, PILOT, all ? "on" : "auto",
             bench->mutations);
    if (job_parse(&job, text, strlen(text), "bench", &fault))
        bench_fail(&fault);
    return job;
}

/* ---- the same units ---- */

/* A scene with what runs units on it. */
typedef struct engine {
    renderer_t *renderer;
    work_space_t *space;
} engine_t;

static void engine_open(engine_t *engine, const scene_t *scene, const job_t *job)
{
    fault_t fault = {0};
    if (renderer_new(&engine->renderer, scene, &job->settings, &fault) ||
        work_space_new(&engine->space, engine->renderer, &fault))
        bench_fail(&fault);
}

static void engine_close(engine_t *engine)
{
    work_space_destroy(&engine->space);
    renderer_destroy(&engine->renderer);
}

/* CPU seconds of a unit; the result is the space's. */
static double engine_run(engine_t *engine, const work_record_t *record, work_result_t *result)
{
    fault_t fault = {0};
    const double begin = clock_thread_cpu();
    if (work_run(engine->space, record, &never, result, &fault))
        bench_fail(&fault);
    return clock_thread_cpu() - begin;
}

static void pilot_step(plan_t *plan, engine_t *engine)
{
    fault_t fault = {0};
    uint64_t unit;
    const work_record_t *record;
    work_result_t result;
    uint8_t *data;
    size_t size;
    plan_absorbed_t how;
    if (!plan_next(plan, &unit, &record)) {
        fault_set(&fault, FAULT_RANGE, "the pilot does not end");
        bench_fail(&fault);
    }
    engine_run(engine, record, &result);
    if (work_result_encode(&result, &data, &size, &fault) || plan_absorb(plan, unit, data, size, &how, &fault))
        bench_fail(&fault);
    free(data);
}

/* A job's units after its pilot, copies of their records. */
static unsigned take_units(const bench_t *bench, const scene_t *scene, const job_t *job, engine_t *engine,
                           work_record_t *records)
{
    fault_t fault = {0};
    plan_t *plan;
    plan_progress_t at = {0};
    if (plan_new(&plan, job, scene, &fault))
        bench_fail(&fault);
    for (plan_progress(plan, &at); at.phase == PLAN_PILOT; plan_progress(plan, &at))
        pilot_step(plan, engine);
    uint64_t unit;
    const work_record_t *record;
    unsigned count = 0;
    while (count < bench->units && plan_next(plan, &unit, &record)) {
        uint8_t *data;
        size_t size;
        if (work_record_encode(record, &data, &size, &fault) ||
            work_record_decode(&records[count++], data, size, &fault))
            bench_fail(&fault);
        free(data);
    }
    plan_destroy(&plan);
    return count;
}

/* Of a result: its light by pixels and its estimators, in one number. */
static uint64_t bits_of(const work_result_t *result)
{
    uint64_t hash = 0;
    for (uint32_t i = 0; i < result->moment_count; i++) {
        uint64_t bits;
        memcpy(&bits, &result->moments[i].sum, sizeof bits);
        hash = random_mix(hash ^ bits);
    }
    const size_t count = result->has_film ? (size_t)FILM_CHANNELS * result->film.width * result->film.height : 0;
    for (size_t i = 0; i < count; i++)
        hash = random_mix(hash ^ (uint64_t)result->film.sums[i]);
    return hash;
}

/* Of each unit, in each way: seconds for as much work as PLAIN's. */
typedef struct units {
    work_record_t records[WAYS][MAX_UNITS]; /* those of UNUSED are PLAIN's */
    unsigned count;
    double least[WAYS][MAX_UNITS];
    uint64_t bits[WAYS][MAX_UNITS];
} units_t;

static double amount_of(const work_record_t *record)
{
    return (double)(record->kind == WORK_CHAINS ? record->mutations : record->count);
}

/* Puts FORCED's units in the order of PLAIN's by kind and length; what has no partner goes. */
static void units_match(units_t *units, unsigned plain, unsigned own)
{
    work_record_t *a = units->records[PLAIN], *b = units->records[FORCED];
    units->count = 0;
    for (unsigned i = 0; i < plain; i++) {
        unsigned j = units->count;
        while (j < own && (b[j].kind != a[i].kind || b[j].length != a[i].length))
            j++;
        if (j == own) {
            work_record_clear(&a[i]);
            continue;
        }
        const work_record_t first = a[i], second = b[j];
        b[j] = b[units->count];
        b[units->count] = second;
        a[i] = (work_record_t){0};
        a[units->count++] = first;
    }
    for (unsigned j = units->count; j < own; j++)
        work_record_clear(&b[j]);
    memcpy(units->records[UNUSED], units->records[PLAIN], sizeof units->records[PLAIN]);
}

static void units_run(units_t *units, engine_t *engines, unsigned turns)
{
    for (unsigned turn = 0; turn < turns; turn++)
        for (unsigned i = 0; i < units->count; i++)
            for (unsigned step = 0; step < WAYS; step++) {
                const unsigned way = (step + turn + i) % WAYS;
                work_result_t result;
                const double seconds = engine_run(&engines[way], &units->records[way][i], &result) *
                                       amount_of(&units->records[PLAIN][i]) / amount_of(&units->records[way][i]);
                units->least[way][i] = turn > 0 ? fmin(units->least[way][i], seconds) : seconds;
                units->bits[way][i] = bits_of(&result);
            }
}

static ratio_t units_ratio(const units_t *units, absent_way_t way)
{
    double own = 0, plain = 0, squares = 0;
    for (unsigned i = 0; i < units->count; i++) {
        own += units->least[way][i];
        plain += units->least[PLAIN][i];
    }
    for (unsigned i = 0; i < units->count; i++) {
        const double d = units->least[way][i] - own / plain * units->least[PLAIN][i];
        squares += d * d;
    }
    const double n = units->count;
    return (ratio_t){own / plain, 2 * sqrt(squares * n / (n - 1)) / own};
}

static bool units_same(const units_t *units)
{
    return memcmp(units->bits[UNUSED], units->bits[PLAIN], sizeof *units->bits[PLAIN] * units->count) == 0;
}

static void bench_units(const bench_t *bench, const peer_loaded_t *loaded, units_t *units)
{
    absent_scene_t unused, forced;
    fault_t fault = {0};
    engine_t engines[WAYS];
    const job_t job = bench_job(bench, loaded->entry, true, 1);
    if (absent_scene_unused(&unused, &loaded->scene, &fault) ||
        absent_scene_forced(&forced, &loaded->scene, &fault))
        bench_fail(&fault);
    const scene_t *const scenes[WAYS] = {&loaded->scene, &unused.scene, &forced.scene};
    for (int way = 0; way < WAYS; way++)
        engine_open(&engines[way], scenes[way], &job);
    const unsigned plain = take_units(bench, scenes[PLAIN], &job, &engines[PLAIN], units->records[PLAIN]),
                   own = take_units(bench, scenes[FORCED], &job, &engines[FORCED], units->records[FORCED]);
    units_match(units, plain, own);
    units_run(units, engines, bench->turns);
    for (unsigned i = 0; i < units->count; i++) {
        work_record_clear(&units->records[PLAIN][i]);
        work_record_clear(&units->records[FORCED][i]);
    }
    for (int way = 0; way < WAYS; way++)
        engine_close(&engines[way]);
    absent_scene_clear(&unused);
    absent_scene_clear(&forced);
}

/* ---- whole renders ---- */

static double number_of(const json_t *object, const char *name)
{
    const json_t *value = object ? json_get(object, name) : NULL;
    return value && json_is_number(value) ? json_number(value) : (double)NAN;
}

/* CPU time x relMSE; how many techniques take no part. */
static double bench_work(const bench_t *bench, const peer_loaded_t *loaded, bool all, unsigned seed, unsigned *idle)
{
    fault_t fault = {0};
    parallel_run_t run;
    const job_t job = bench_job(bench, loaded->entry, all, seed);
    if (parallel_render(&run, &loaded->scene, &job, 1, &fault))
        bench_fail(&fault);
    const double work = number_of(json_get(run.report, "time"), "render_cpu_seconds") *
                        number_of(json_get(run.report, "error"), "relmse");
    *idle = 0;
    for (const json_t *k = json_first(json_get(run.report, "lengths")); k; k = json_next(k))
        for (const json_t *s = json_get(k, "idle") ? json_first(json_get(k, "idle")) : NULL; s; s = json_next(s))
            ++*idle;
    parallel_clear(&run);
    return work;
}

/* All techniques over those that are not negligible. Without idle ones there is nothing to compare: 1. */
static ratio_t bench_techniques(const bench_t *bench, const peer_loaded_t *loaded, unsigned *idle)
{
    double sum = 0, sum2 = 0;
    for (unsigned seed = 1; seed <= bench->seeds; seed++) {
        unsigned none;
        const double kept = bench_work(bench, loaded, false, seed, idle);
        if (*idle == 0)
            return (ratio_t){1, 0};
        const double x = log(bench_work(bench, loaded, true, seed, &none) / kept);
        sum += x;
        sum2 += x * x;
    }
    const double n = bench->seeds, mean = sum / n;
    return (ratio_t){exp(mean), 2 * sqrt(fmax(0, sum2 / n - mean * mean) / (n - 1))};
}

/* ---- what comes out ---- */

static void json_add_ratio(json_t *object, const char *name, ratio_t ratio)
{
    json_t *pair = json_new_object();
    json_add_number(pair, "ratio", ratio.value);
    json_add_number(pair, "error", ratio.error);
    json_add(object, name, pair);
}

static json_t *bench_scene(const bench_t *bench, const peer_loaded_t *loaded)
{
    static units_t units;
    unsigned idle = 0;
    bench_units(bench, loaded, &units);
    const ratio_t unused = units_ratio(&units, UNUSED), forced = units_ratio(&units, FORCED),
                  techniques = bench_techniques(bench, loaded, &idle);
    const bool same = units_same(&units);
    printf("%-14s %6.3f +- %.3f   %6.3f +- %.3f   %-4s %6u", loaded->entry->name, unused.value, unused.error,
           forced.value, forced.error, same ? "yes" : "no", idle);
    if (idle > 0)
        printf("   %6.2f +- %.2f", techniques.value, techniques.error);
    printf("\n");
    fflush(stdout);
    json_t *object = json_new_object();
    json_add_string(object, "scene", loaded->entry->name);
    json_add_bool(object, "same_results", same);
    json_add_ratio(object, "unused", unused);
    json_add_ratio(object, "forced", forced);
    json_add_number(object, "idle", idle);
    json_add_ratio(object, "all_techniques", techniques);
    return object;
}

int main(int argc, char **argv)
{
    static bench_t bench;
    fault_t fault = {0};
    json_t *list = json_new_array();
    bench_options(&bench, argc, argv);
    printf("%s: %u units %u times, time over that of the scene as it is; renders of %u seeds, time x relMSE\n",
           bench.algorithm, bench.units, bench.turns, bench.seeds);
    printf("%-14s %-17s %-17s %-4s %6s   %s\n", "scene", "unused", "forced", "same", "idle", "all techniques");
    for (size_t i = 0; i < bench.list.count; i++) {
        peer_loaded_t *loaded;
        if (peer_scene_load(&loaded, bench.list.entries[i], &fault))
            bench_fail(&fault);
        json_append(list, bench_scene(&bench, loaded));
        peer_scene_unload(&loaded);
    }
    options_write_json(list, argc, argv);
    json_destroy(&list);
    return 0;
}
