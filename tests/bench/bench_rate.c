/* bench_rate: how fast a thread renders, and how much of it is Embree's: docs/benchmarks.md.
 *
 *     bench_rate [--scenes a,b] [--algorithms pt,bdpt,mmlt] [--work N] [--repetitions N] [--threads 1,2] [--json
 * FILE]
 *
 * Repetitions are interleaved over scenes and algorithms, so that a busy moment of the machine does not meet one of
 * them alone; medians are printed with least and most. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fail.h"
#include "calibrate.h"
#include "options.h"
#include "parallel.h"
#include "rate_case.h"
#include "client/bench/spread.h"

enum { MAX_CASES = OPTIONS_LIST * SETTINGS_ALGORITHMS, MAX_REPETITIONS = 101, MAX_THREAD_COUNTS = 8 };

static const char usual_scenes[] =
    "cornell-320,ring-box,two-rooms,water-box,veach-bidir,veach-mis,water-caustic,veach-ajar,"
    "diffuse,glossy,glass,environment,delta-lights,lens,transmission,normals,tiny-light,furnace";

typedef struct bench_case {
    rate_case_t rate;
    double mutations[MAX_REPETITIONS], rays[MAX_REPETITIONS], raw[MAX_REPETITIONS];
    double share[MAX_REPETITIONS], share_timed[MAX_REPETITIONS];
    double wall[MAX_THREAD_COUNTS][MAX_REPETITIONS], cpu[MAX_THREAD_COUNTS][MAX_REPETITIONS];
} bench_case_t;

typedef struct bench {
    options_scenes_t scenes;
    options_algorithms_t algorithms;
    options_numbers_t threads;
    unsigned repetitions;
    double work;
    peer_loaded_t *loaded[OPTIONS_LIST];
    bench_case_t *cases;
    size_t count;
    double calibration[MAX_REPETITIONS];
    spread_t speed; /* of the calibration */
} bench_t;

static void bench_options(bench_t *bench, int argc, char **argv)
{
    static const char *const names[] = {"--scenes",  "--algorithms", "--work", "--repetitions",
                                        "--threads", "--json",       NULL};
    options_expect(argc, argv, names);
    options_scenes(&bench->scenes, argc, argv, usual_scenes);
    options_algorithms(&bench->algorithms, argc, argv, "pt,bdpt,mmlt");
    options_numbers(&bench->threads, argc, argv, "--threads", "1");
    bench->work = floor(options_number(argc, argv, "--work", 1 << 20, 1000, 1e9));
    bench->repetitions = (unsigned)options_number(argc, argv, "--repetitions", 5, 1, MAX_REPETITIONS);
    if (bench->threads.count > MAX_THREAD_COUNTS) {
        fprintf(stderr, "%s: --threads: at most %d numbers\n", argv[0], MAX_THREAD_COUNTS);
        exit(2);
    }
}

static void bench_load(bench_t *bench)
{
    fault_t fault = {0};
    bench->cases = calloc(MAX_CASES, sizeof *bench->cases);
    if (!bench->cases)
        abort();
    for (size_t i = 0; i < bench->scenes.count; i++) {
        fprintf(stderr, "loading %s\n", bench->scenes.entries[i]->name);
        if (peer_scene_load(&bench->loaded[i], bench->scenes.entries[i], &fault))
            bench_fail(&fault);
        for (size_t j = 0; j < bench->algorithms.count; j++)
            if (rate_case_init(&bench->cases[bench->count++].rate, bench->loaded[i], bench->algorithms.kinds[j],
                               bench->work, &fault))
                bench_fail(&fault);
    }
}

/* One repetition of one case; over several numbers of threads if they are asked for. */
static void bench_repeat(const bench_t *bench, bench_case_t *one, unsigned repetition)
{
    fault_t fault = {0};
    rate_figures_t figures;
    if (rate_case_run(&one->rate, &figures, &fault))
        bench_fail(&fault);
    one->mutations[repetition] = figures.mutations_per_second;
    one->rays[repetition] = figures.rays_per_second;
    one->raw[repetition] = figures.raw_rays_per_second;
    one->share[repetition] = figures.share;
    one->share_timed[repetition] = figures.share_timed;
    if (bench->threads.count < 2)
        return;
    for (size_t t = 0; t < bench->threads.count; t++)
        if (rate_case_threads(&one->rate, (unsigned)bench->threads.values[t], &one->wall[t][repetition],
                              &one->cpu[t][repetition], &fault))
            bench_fail(&fault);
}

static void bench_run(bench_t *bench)
{
    for (unsigned r = 0; r < bench->repetitions; r++) {
        fprintf(stderr, "repetition %u of %u\n", r + 1, bench->repetitions);
        bench->calibration[r] = calibrate_run();
        for (size_t i = 0; i < bench->count; i++)
            bench_repeat(bench, &bench->cases[i], r);
    }
    bench->speed = spread_of(bench->calibration, bench->repetitions);
}

/* ---- what comes out ---- */

static void print_speed(const char *name, peer_speed_t speed)
{
    if (speed.high > speed.low)
        printf(" %s %.2f to %.2f", name, speed.low, speed.high);
    else if (speed.high > 0)
        printf(" %s %.2f", name, speed.low);
}

static void print_rates(const bench_t *bench)
{
    const double scale = bench->speed.median / CALIBRATE_PEERS;
    printf(
        "calibration %.3f Mray per CPU second (%.3f to %.3f); \"scaled\" is the rate at a calibration of %.1f\n\n",
        bench->speed.median, bench->speed.min, bench->speed.max, CALIBRATE_PEERS);
    printf("%-14s %-5s %-25s %-7s %-7s %-7s %-8s %-8s %s\n", "scene", "", "Mmutation/CPU s (min, max)", "scaled",
           "Mray/s", "raw", "Embree", "timed", "other renderers, Mmutation/CPU s");
    for (size_t i = 0; i < bench->count; i++) {
        bench_case_t *c = &bench->cases[i];
        const spread_t m = spread_of(c->mutations, bench->repetitions),
                       rays = spread_of(c->rays, bench->repetitions), raw = spread_of(c->raw, bench->repetitions),
                       share = spread_of(c->share, bench->repetitions),
                       timed = spread_of(c->share_timed, bench->repetitions);
        printf("%-14s %-5s %8.4f (%.4f, %.4f) %7.4f %7.3f %7.3f %6.1f %% %6.1f %%", c->rate.entry->name,
               settings_algorithm_name(c->rate.algorithm), m.median, m.min, m.max, m.median / scale, rays.median,
               raw.median, 100 * share.median, 100 * timed.median);
        if (c->rate.algorithm == SETTINGS_MMLT) {
            print_speed(" Tungsten mmlt", c->rate.entry->mmlt_speed);
            print_speed("rjmlt", c->rate.entry->rjmlt_speed);
            print_speed(" pbrt-v4 mlt", c->rate.entry->pbrt_mlt_speed);
        }
        putchar('\n');
    }
}

static void print_costs(const bench_t *bench)
{
    printf("\n%-14s %-5s %-12s %-10s %-12s %s\n", "scene", "", "renderer KB", "film KB", "unit's KB",
           "encoding and merging a unit, of its run");
    for (size_t i = 0; i < bench->count; i++) {
        const rate_case_t *rate = &bench->cases[i].rate;
        printf("%-14s %-5s %10.0f   %8.0f   %10.0f   %.2f %%\n", rate->entry->name,
               settings_algorithm_name(rate->algorithm), (double)rate->renderer_bytes / 1024,
               (double)rate->film_bytes / 1024, rate->unit_bytes / 1024, 100 * rate->merge_share);
    }
}

/* Throughput of so many threads over that many times the first number's, by wall time and by CPU time. */
static void scaling_of(const bench_t *bench, const bench_case_t *c, size_t t, spread_t *wall, spread_t *cpu)
{
    double by_wall[MAX_REPETITIONS], by_cpu[MAX_REPETITIONS];
    const double threads = bench->threads.values[t] / bench->threads.values[0];
    for (unsigned r = 0; r < bench->repetitions; r++) {
        by_wall[r] = c->wall[0][r] / c->wall[t][r];
        by_cpu[r] = threads * c->cpu[0][r] / c->cpu[t][r];
    }
    *wall = spread_of(by_wall, bench->repetitions);
    *cpu = spread_of(by_cpu, bench->repetitions);
}

static void print_scaling(const bench_t *bench)
{
    printf("\n%-14s %-5s %-8s %-30s %s\n", "scene", "", "threads", "throughput a thread (min, max)", "by CPU time");
    for (size_t i = 0; i < bench->count; i++)
        for (size_t t = 1; t < bench->threads.count; t++) {
            spread_t wall, cpu;
            scaling_of(bench, &bench->cases[i], t, &wall, &cpu);
            printf("%-14s %-5s %-8.0f %6.1f %% (%.1f, %.1f) %12.1f %% (%.1f, %.1f)\n",
                   bench->cases[i].rate.entry->name, settings_algorithm_name(bench->cases[i].rate.algorithm),
                   bench->threads.values[t], 100 * wall.median, 100 * wall.min, 100 * wall.max, 100 * cpu.median,
                   100 * cpu.min, 100 * cpu.max);
        }
}

static json_t *case_json(const bench_t *bench, bench_case_t *c)
{
    json_t *object = json_new_object();
    json_add_string(object, "scene", c->rate.entry->name);
    json_add_string(object, "algorithm", settings_algorithm_name(c->rate.algorithm));
    json_add_number(object, "width", c->rate.entry->width);
    json_add_number(object, "height", c->rate.entry->height);
    json_add_number(object, "mutations", c->rate.mutations);
    json_add(object, "mmutations_per_cpu_second", spread_json(spread_of(c->mutations, bench->repetitions)));
    json_add(object, "mrays_per_cpu_second", spread_json(spread_of(c->rays, bench->repetitions)));
    json_add(object, "raw_mrays_per_cpu_second", spread_json(spread_of(c->raw, bench->repetitions)));
    json_add(object, "embree_share", spread_json(spread_of(c->share, bench->repetitions)));
    json_add(object, "embree_share_timed", spread_json(spread_of(c->share_timed, bench->repetitions)));
    json_add_number(object, "merge_share", c->rate.merge_share);
    json_add_number(object, "unit_bytes", c->rate.unit_bytes);
    json_add_number(object, "renderer_bytes", (double)c->rate.renderer_bytes);
    json_add_number(object, "film_bytes", (double)c->rate.film_bytes);
    json_t *scaling = json_new_array();
    for (size_t t = 1; t < bench->threads.count; t++) {
        spread_t wall, cpu;
        scaling_of(bench, c, t, &wall, &cpu);
        json_t *entry = json_new_object();
        json_add_number(entry, "threads", bench->threads.values[t]);
        json_add(entry, "wall", spread_json(wall));
        json_add(entry, "cpu", spread_json(cpu));
        json_append(scaling, entry);
    }
    json_add(object, "scaling", scaling);
    return object;
}

static void write_json(const bench_t *bench, int argc, char **argv)
{
    json_t *root = json_new_object(), *cases = json_new_array();
    json_add(root, "calibration", spread_json(bench->speed));
    json_add_number(root, "repetitions", bench->repetitions);
    json_add_number(root, "processors", (double)sysconf(_SC_NPROCESSORS_ONLN));
    json_add_string(root, "instructions", GARLAND_ARCH);
    for (size_t i = 0; i < bench->count; i++)
        json_append(cases, case_json(bench, &bench->cases[i]));
    json_add(root, "cases", cases);
    options_write_json(root, argc, argv);
    json_destroy(&root);
}

int main(int argc, char **argv)
{
    static bench_t bench;
    bench_options(&bench, argc, argv);
    bench_load(&bench);
    bench_run(&bench);
    print_rates(&bench);
    print_costs(&bench);
    if (bench.threads.count > 1)
        print_scaling(&bench);
    write_json(&bench, argc, argv);
    for (size_t i = 0; i < bench.count; i++)
        rate_case_clear(&bench.cases[i].rate);
    for (size_t i = 0; i < bench.scenes.count; i++)
        peer_scene_unload(&bench.loaded[i]);
    free(bench.cases);
    return 0;
}
