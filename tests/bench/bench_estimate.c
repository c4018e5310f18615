/* bench_estimate: whether renders are right about their own error: docs/accuracy.md.
 *
 *     bench_estimate [--scenes diffuse,glossy] [--seeds 50] [--mutations 100] [--samples 20] [--reference 5000]
 *                    [--side 32] [--threads 2] [--json FILE]
 *
 * Each scene is rendered with each of a list of jobs and each seed, chains to --mutations a pixel, samples to
 * --samples, and held against two independent renders of --reference bidirectional samples a pixel each. */
#include <stdio.h>
#include <string.h>

#include "fail.h"
#include "estimates.h"
#include "options.h"
#include "parallel.h"

typedef struct bench_job {
    const char *name, *algorithm, *chains;
    bool samples;
} bench_job_t;

static const bench_job_t jobs[] = {
    {"bdpt", "bdpt", "{}", true},    {"mmlt", "mmlt", "{}", false},
    {"rjmlt", "rjmlt", "{}", false}, {"mmlt, equalize 1, split 20", "mmlt", "{\"equalize\":1,\"split\":20}", false},
    {"auto", "auto", "{}", false},
};

typedef struct bench {
    options_scenes_t scenes;
    unsigned seeds, threads, side;
    double mutations, samples, reference;
} bench_t;

static void bench_options(bench_t *bench, int argc, char **argv)
{
    static const char *const names[] = {"--scenes", "--seeds",   "--mutations", "--samples", "--reference",
                                        "--side",   "--threads", "--json",      NULL};
    options_expect(argc, argv, names);
    options_scenes(&bench->scenes, argc, argv, "diffuse,glossy,glass,caustics");
    bench->seeds = (unsigned)options_number(argc, argv, "--seeds", 50, 2, ESTIMATES_MAX_SEEDS);
    bench->mutations = options_number(argc, argv, "--mutations", 100, 1, 1e6);
    bench->samples = options_number(argc, argv, "--samples", 20, 1, 1e6);
    bench->reference = options_number(argc, argv, "--reference", 5000, 1, 1e7);
    bench->side = (unsigned)options_number(argc, argv, "--side", 32, PLAN_REGION_SIDE, 4096);
    bench->threads = (unsigned)options_number(argc, argv, "--threads", 2, 1, PARALLEL_MAX_THREADS);
}

static void bench_job(job_t *job, const bench_t *bench, const peer_scene_t *scene, const char *algorithm,
                      const char *chains, double per_pixel)
{
    fault_t fault = {0};
    char text[1024];
    snprintf(text, sizeof text,
             "{\"scene\":\"%s\",\"film\":{\"width\":%u,\"height\":%u,\"filter\":\"box\"},\"algorithm\":\"%s\","
             "\"max_path_length\":%u,\"chains\":%s,\"stop\":{\"mutations_per_pixel\":%.17g}}",
             scene->name, bench->side, bench->side, algorithm, scene->max_path_length, chains, per_pixel);
    if (job_parse(job, text, strlen(text), "bench", &fault))
        bench_fail(&fault);
}

static void figure_json(json_t *object, const char *name, estimates_figure_t figure)
{
    json_t *pair = json_new_object();
    json_add_number(pair, "value", figure.value);
    json_add_number(pair, "standard_error", figure.error);
    json_add(object, name, pair);
}

static json_t *case_json(const char *scene, const char *job, const estimates_t *e)
{
    json_t *object = json_new_object();
    json_add_string(object, "scene", scene);
    json_add_string(object, "job", job);
    json_add_number(object, "relmse", e->relmse);
    json_add_number(object, "estimate", e->estimate);
    figure_json(object, "ratio", e->ratio);
    figure_json(object, "inside", e->inside);
    figure_json(object, "covered", e->covered);
    json_add_number(object, "wide", e->wide);
    json_add_number(object, "interval", e->interval);
    json_add_number(object, "reliable", e->reliable);
    json_add_number(object, "reliable_off", e->reliable_off);
    json_add_number(object, "unreliable", e->unreliable);
    json_add_number(object, "unreliable_off", e->unreliable_off);
    json_add_number(object, "cpu_seconds", e->cpu_seconds);
    return object;
}

static void bench_scene(const bench_t *bench, const peer_scene_t *entry, json_t *cases)
{
    fault_t fault = {0};
    peer_loaded_t *loaded;
    estimates_reference_t reference;
    job_t job;
    if (peer_scene_load(&loaded, entry, &fault))
        bench_fail(&fault);
    bench_job(&job, bench, entry, "bdpt", "{}", bench->reference);
    if (estimates_reference(&reference, &loaded->scene, &job, bench->threads, &fault))
        bench_fail(&fault);
    for (size_t i = 0; i < sizeof jobs / sizeof *jobs; i++) {
        estimates_t e;
        bench_job(&job, bench, entry, jobs[i].algorithm, jobs[i].chains,
                  jobs[i].samples ? bench->samples : bench->mutations);
        if (estimates_measure(&e, &loaded->scene, &job, bench->seeds, bench->threads, &reference, &fault))
            bench_fail(&fault);
        printf("%-9s %-27s %7.3g %7.3g %6.3f +- %-5.3f %4.0f %% %5.2f %4u of %-3u %4u of %-3u %5.1f +- %3.1f %% "
               "%5.2f %% %5.1f s\n",
               entry->name, jobs[i].name, e.relmse, e.estimate, e.ratio.value, e.ratio.error, 100 * e.inside.value,
               e.interval, e.reliable_off, e.reliable, e.unreliable_off, e.unreliable, 100 * e.covered.value,
               100 * e.covered.error, 100 * e.wide, e.cpu_seconds);
        fflush(stdout);
        json_append(cases, case_json(entry->name, jobs[i].name, &e));
    }
    estimates_reference_clear(&reference);
    peer_scene_unload(&loaded);
}

int main(int argc, char **argv)
{
    static bench_t bench;
    bench_options(&bench, argc, argv);
    json_t *root = json_new_object(), *cases = json_new_array();
    printf("%u seeds, %u x %u pixels, chains %g mutations a pixel, bdpt %g samples, references 2 x %g samples\n\n"
           "%-9s %-27s %7s %7s %-15s %6s %5s %11s %11s %13s %7s %7s\n",
           bench.seeds, bench.side, bench.side, bench.mutations, bench.samples, bench.reference, "scene", "job",
           "relMSE", "by it", "ratio", "inside", "x", "off, sure", "off, unsure", "regions", "+-", "CPU");
    for (size_t i = 0; i < bench.scenes.count; i++)
        bench_scene(&bench, bench.scenes.entries[i], cases);
    json_add(root, "cases", cases);
    options_write_json(root, argc, argv);
    json_destroy(&root);
    return 0;
}
