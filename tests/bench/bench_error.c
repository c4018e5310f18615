/* bench_error: how far the images are from the references after equal time, or after equal numbers of mutations:
 * docs/benchmarks.md.
 *
 *     bench_error [--scenes a,b] [--algorithms bdpt,mmlt] [--seconds 15 | --mutations 25,100,400] [--threads 2]
 *                 [--seeds 3] [--first-seed 1] [--chains '{"large_step":0.3}'] [--images FOLDER] [--json FILE]
 *
 * Runs are interleaved over scenes and algorithms within each seed. --mutations renders to these numbers a pixel in
 * the place of a time and shows how the error falls. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fail.h"
#include "calibrate.h"
#include "film/compare.h"
#include "film/pfm.h"
#include "options.h"
#include "parallel.h"
#include "client/bench/spread.h"

enum { MAX_SEEDS = 1000, JOB_TEXT = 2048 };

static const char usual_scenes[] = "cornell-320,ring-box,two-rooms,water-box";

typedef struct bench_figures {
    double relmse[MAX_SEEDS], trimmed[MAX_SEEDS], bias[MAX_SEEDS], cpu[MAX_SEEDS], mutations[MAX_SEEDS];
    double estimate[MAX_SEEDS]; /* of relMSE, the render's own */
} bench_figures_t;

typedef struct bench_case {
    size_t scene;
    settings_algorithm_t algorithm;
    double budget; /* mutations per pixel; 0: seconds */
    bench_figures_t figures;
} bench_case_t;

typedef struct bench_scene {
    peer_loaded_t *loaded;
    image_t references[2];
} bench_scene_t;

typedef struct bench {
    options_scenes_t list;
    options_algorithms_t algorithms;
    options_numbers_t budgets;
    double seconds;
    unsigned threads, seeds;
    uint64_t first_seed;
    const char *chains, *images;
    bench_scene_t scenes[OPTIONS_LIST];
    bench_case_t *cases;
    size_t count;
    double calibration[MAX_SEEDS];
    spread_t speed;
} bench_t;

static void bench_options(bench_t *bench, int argc, char **argv)
{
    static const char *const names[] = {"--scenes", "--algorithms", "--seconds", "--mutations", "--threads",
                                        "--seeds",  "--first-seed", "--chains",  "--images",    "--json",
                                        NULL};
    options_expect(argc, argv, names);
    options_scenes(&bench->list, argc, argv, usual_scenes);
    options_algorithms(&bench->algorithms, argc, argv, "bdpt,mmlt");
    bench->seconds = options_number(argc, argv, "--seconds", 15, 0.1, 1e6);
    bench->threads = (unsigned)options_number(argc, argv, "--threads", 2, 1, PARALLEL_MAX_THREADS);
    bench->seeds = (unsigned)options_number(argc, argv, "--seeds", 3, 1, MAX_SEEDS);
    bench->first_seed = (uint64_t)options_number(argc, argv, "--first-seed", 1, 0, 1e15);
    bench->chains = options_value(argc, argv, "--chains");
    bench->images = options_value(argc, argv, "--images");
    if (options_value(argc, argv, "--mutations"))
        options_numbers(&bench->budgets, argc, argv, "--mutations", "");
    else
        bench->budgets = (options_numbers_t){{0}, 1};
}

static void bench_load(bench_t *bench)
{
    fault_t fault = {0};
    bench->cases =
        calloc(bench->list.count * bench->algorithms.count * bench->budgets.count + 1, sizeof *bench->cases);
    if (!bench->cases)
        abort();
    for (size_t i = 0; i < bench->list.count; i++) {
        const peer_scene_t *entry = bench->list.entries[i];
        bench_scene_t *scene = &bench->scenes[i];
        if (peer_scene_load(&scene->loaded, entry, &fault))
            bench_fail(&fault);
        for (int r = 0; r < 2; r++)
            if ((r == 0 || entry->references[r]) && peer_reference_read(&scene->references[r], entry, r, &fault))
                bench_fail(&fault);
        for (size_t a = 0; a < bench->algorithms.count; a++)
            for (size_t b = 0; b < bench->budgets.count; b++)
                bench->cases[bench->count++] = (bench_case_t){
                    .scene = i, .algorithm = bench->algorithms.kinds[a], .budget = bench->budgets.values[b]};
    }
}

static void bench_job(job_t *job, const bench_t *bench, const bench_case_t *one, unsigned seed)
{
    fault_t fault = {0};
    char text[JOB_TEXT], stop[64];
    const peer_scene_t *e = bench->list.entries[one->scene];
    if (one->budget > 0)
        snprintf(stop, sizeof stop, "\"mutations_per_pixel\":%.17g", one->budget);
    else
        snprintf(stop, sizeof stop, "\"seconds\":%.17g", bench->seconds);
    snprintf(text, sizeof text,
             "{\"scene\":\"%s\",\"film\":{\"width\":%u,\"height\":%u,\"filter\":\"box\"},\"algorithm\":\"%s\","
             "\"max_path_length\":%u,\"seed\":\"%llu\",\"chains\":%s,\"stop\":{%s}}",
             e->name, e->width, e->height, settings_algorithm_name(one->algorithm), e->max_path_length,
             (unsigned long long)(bench->first_seed + seed), bench->chains ? bench->chains : "{}", stop);
    if (job_parse(job, text, strlen(text), "bench", &fault))
        bench_fail(&fault);
}

static void bench_keep_image(const bench_t *bench, const bench_case_t *one, unsigned seed, const image_t *image)
{
    fault_t fault = {0};
    char path[JOB_TEXT];
    snprintf(path, sizeof path, "%s/%s-%s-%g-%u.pfm", bench->images, bench->list.entries[one->scene]->name,
             settings_algorithm_name(one->algorithm), one->budget > 0 ? one->budget : bench->seconds, seed + 1);
    if (pfm_write(image, path, &fault))
        bench_fail(&fault);
}

static void bench_one(bench_t *bench, bench_case_t *one, unsigned seed)
{
    static compare_result_t result;
    fault_t fault = {0};
    const bench_scene_t *scene = &bench->scenes[one->scene];
    parallel_run_t run;
    job_t job;
    bench_job(&job, bench, one, seed);
    if (parallel_render(&run, &scene->loaded->scene, &job, bench->threads, &fault) ||
        compare_images(&result, &run.image, &scene->references[0],
                       scene->references[1].data ? &scene->references[1] : NULL, NULL, &fault))
        bench_fail(&fault);
    if (bench->images)
        bench_keep_image(bench, one, seed, &run.image);
    bench_figures_t *f = &one->figures;
    f->relmse[seed] = result.relmse;
    f->trimmed[seed] = result.relmse_trimmed;
    f->bias[seed] = result.bias;
    f->cpu[seed] = run.cpu_seconds;
    f->mutations[seed] = run.mutations;
    const json_t *estimate = json_get(json_get(run.report, "error"), "relmse");
    f->estimate[seed] = json_is_number(estimate) ? json_number(estimate) : NAN;
    fprintf(stderr,
            "%-14s %-5s seed %llu: %.1f s, %.1f CPU s (%.2f merging), relMSE %.5g (%.5g), brightness %.4f\n",
            bench->list.entries[one->scene]->name, settings_algorithm_name(one->algorithm),
            (unsigned long long)(bench->first_seed + seed), run.wall_seconds, run.cpu_seconds, run.merge_seconds,
            result.relmse, result.relmse_trimmed, result.bias);
    parallel_clear(&run);
}

static void bench_run(bench_t *bench)
{
    for (unsigned seed = 0; seed < bench->seeds; seed++) {
        bench->calibration[seed] = calibrate_run();
        for (size_t i = 0; i < bench->count; i++)
            bench_one(bench, &bench->cases[i], seed);
    }
    bench->speed = spread_of(bench->calibration, bench->seeds);
}

/* ---- what comes out ---- */

typedef struct bench_summary {
    spread_t relmse, trimmed, bias, cpu, mutations, estimate;
} bench_summary_t;

/* Sorts the figures. */
static bench_summary_t bench_summarise(const bench_t *bench, bench_case_t *one)
{
    bench_figures_t *f = &one->figures;
    const unsigned n = bench->seeds;
    return (bench_summary_t){spread_of(f->relmse, n), spread_of(f->trimmed, n),   spread_of(f->bias, n),
                             spread_of(f->cpu, n),    spread_of(f->mutations, n), spread_of(f->estimate, n)};
}

/* What another renderer's relMSE is of ours after as many CPU seconds of a machine as fast: above 1, ours is less.
 * relMSE falls as 1 / time. */
static double bench_ratio(const bench_t *bench, double theirs, double their_seconds, double ours,
                          double our_seconds)
{
    return theirs * their_seconds / (ours * our_seconds * bench->speed.median / CALIBRATE_PEERS);
}

static void print_against(const bench_t *bench, const char *name, peer_error_t peer, double noise,
                          const bench_summary_t *s)
{
    if (!(peer.relmse > 0))
        return;
    printf("  %s %.3g: x%.2f", name, peer.relmse,
           bench_ratio(bench, peer.relmse, peer.cpu_seconds, s->relmse.median - noise, s->cpu.median));
    if (peer.trimmed > 0)
        printf(" (%.3g: x%.2f)", peer.trimmed,
               bench_ratio(bench, peer.trimmed, peer.cpu_seconds, s->trimmed.median - noise, s->cpu.median));
}

static void print_case(const bench_t *bench, const bench_case_t *one, const bench_summary_t *s)
{
    const peer_scene_t *entry = bench->list.entries[one->scene];
    char budget[32];
    snprintf(budget, sizeof budget, one->budget > 0 ? "%g/pixel" : "%g s",
             one->budget > 0 ? one->budget : bench->seconds);
    printf("%-14s %-5s %-10s %8.2f %8.1f %10.5g (%.5g, %.5g) %10.5g %10.5g %8.4f", entry->name,
           settings_algorithm_name(one->algorithm), budget, s->cpu.median,
           s->mutations.median / entry->width / entry->height, s->relmse.median, s->relmse.min, s->relmse.max,
           s->trimmed.median, s->estimate.median, s->bias.median);
    if (one->budget == 0) {
        print_against(bench, "bdpt", entry->bdpt, 0, s);
        print_against(bench, "mmlt", entry->mmlt, 0, s);
        print_against(bench, "rjmlt", entry->rjmlt, 0, s);
        print_against(bench, "pbrt bdpt", entry->pbrt_bdpt, entry->reference_noise, s);
        print_against(bench, "pbrt mlt", entry->pbrt_mlt, entry->reference_noise, s);
    }
    putchar('\n');
}

static json_t *case_json(const bench_t *bench, const bench_case_t *one, const bench_summary_t *s)
{
    json_t *object = json_new_object();
    json_add_string(object, "scene", bench->list.entries[one->scene]->name);
    json_add_string(object, "algorithm", settings_algorithm_name(one->algorithm));
    if (one->budget > 0)
        json_add_number(object, "mutations_per_pixel", one->budget);
    else
        json_add_number(object, "seconds", bench->seconds);
    json_add(object, "cpu_seconds", spread_json(s->cpu));
    json_add(object, "mutations", spread_json(s->mutations));
    json_add(object, "relmse", spread_json(s->relmse));
    json_add(object, "relmse_trimmed", spread_json(s->trimmed));
    json_add(object, "relmse_estimated", spread_json(s->estimate));
    json_add(object, "brightness", spread_json(s->bias));
    return object;
}

static json_t *bench_print(const bench_t *bench)
{
    json_t *root = json_new_object(), *cases = json_new_array();
    json_add(root, "calibration", spread_json(bench->speed));
    json_add_number(root, "threads", bench->threads);
    json_add_number(root, "seeds", bench->seeds);
    printf("calibration %.3f Mray per CPU second (%.3f to %.3f), %u threads, medians over %u seeds\n"
           "last columns: another renderer's relMSE (trimmed); x: that over ours at equal CPU time and "
           "calibration\n\n",
           bench->speed.median, bench->speed.min, bench->speed.max, bench->threads, bench->seeds);
    printf("%-14s %-5s %-10s %8s %8s %-28s %10s %10s %8s\n", "scene", "", "budget", "CPU s", "/pixel",
           "relMSE (min, max)", "trimmed", "estimate", "bright");
    for (size_t i = 0; i < bench->count; i++) {
        const bench_summary_t summary = bench_summarise(bench, &bench->cases[i]);
        print_case(bench, &bench->cases[i], &summary);
        json_append(cases, case_json(bench, &bench->cases[i], &summary));
    }
    json_add(root, "cases", cases);
    return root;
}

int main(int argc, char **argv)
{
    static bench_t bench;
    bench_options(&bench, argc, argv);
    bench_load(&bench);
    bench_run(&bench);
    json_t *root = bench_print(&bench);
    options_write_json(root, argc, argv);
    json_destroy(&root);
    for (size_t i = 0; i < bench.list.count; i++) {
        peer_scene_unload(&bench.scenes[i].loaded);
        image_clear(&bench.scenes[i].references[0]);
        image_clear(&bench.scenes[i].references[1]);
    }
    free(bench.cases);
    return 0;
}
