/* bench_gain: what algorithms gain: many seeds of each for equal CPU time on the same scenes: docs/gains.md. The
 * script tests/bench/gain runs it.
 *
 *     bench_gain references --folder DIR [--scenes a,b] [--seconds 120] [--part 20] [--width 128] [--threads 2]
 *     bench_gain measure --references DIR --out DIR [--scenes a,b] [--variants mmlt,rjmlt | all] [--list FILE]
 *                        [--seconds 2] [--points 4] [--seeds 10] [--first-seed 1] [--width 128] [--threads 2]
 *     bench_gain report --from DIR --out DIR [--scenes a,b] [--prefix own-]
 *
 * references: makes references, or makes them better (gain_reference.h). measure: DIR/SCENE.json for each scene
 * (gain_data.h), written when the scene is done. report: tables and plots from these files. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "gain_claims.h"
#include "gain_measure.h"
#include "gain_plot.h"
#include "gain_table.h"
#include "options.h"
#include "parallel.h"

enum { PATH_ROOM = 4096 };

static const char usual_scenes[] =
    "ring-box,two-rooms,water-box,veach-ajar,veach-bidir,water-caustic,coffee,staircase2";

__attribute__((noreturn)) static void gain_fail(const fault_t *fault)
{
    fprintf(stderr, "bench_gain: %s\n", fault->text);
    exit(1);
}

static const char *needed(int argc, char **argv, const char *name)
{
    const char *value = options_value(argc, argv, name);
    if (!value) {
        fprintf(stderr, "bench_gain %s: %s is missing\n", argv[0], name);
        exit(2);
    }
    return value;
}

static unsigned threads_of(int argc, char **argv)
{
    return (unsigned)options_number(argc, argv, "--threads", 2, 1, PARALLEL_MAX_THREADS);
}

static uint32_t width_of(int argc, char **argv)
{
    return (uint32_t)options_number(argc, argv, "--width", 128, 4, 4096);
}

static peer_loaded_t *load(const peer_scene_t *entry)
{
    fault_t fault = {0};
    peer_loaded_t *loaded;
    if (peer_scene_load(&loaded, entry, &fault))
        gain_fail(&fault);
    return loaded;
}

/* ---- references ---- */

static void gain_references(int argc, char **argv)
{
    static const char *const names[] = {"--folder", "--scenes",  "--seconds", "--part",
                                        "--width",  "--threads", NULL};
    options_scenes_t list;
    peer_loaded_t *loaded[OPTIONS_LIST];
    fault_t fault = {0};
    options_expect(argc, argv, names);
    options_scenes(&list, argc, argv, usual_scenes);
    const char *folder = needed(argc, argv, "--folder");
    const double seconds = options_number(argc, argv, "--seconds", 120, 0.1, 1e6),
                 part = options_number(argc, argv, "--part", fmin(seconds, 20), 0.1, 1e6);
    for (size_t i = 0; i < list.count; i++)
        loaded[i] = load(list.entries[i]);
    if (gain_reference_make(loaded, list.count, width_of(argc, argv), folder, seconds, part, threads_of(argc, argv),
                            &fault))
        gain_fail(&fault);
    for (size_t i = 0; i < list.count; i++) {
        gain_reference_t reference;
        if (gain_reference_read(&reference, list.entries[i], gain_size_of(list.entries[i], width_of(argc, argv)),
                                folder, &fault))
            gain_fail(&fault);
        printf("%-14s %s, %.0f and %.0f CPU s: relMSE %.3g, brightness of the halves %.4f apart\n",
               list.entries[i]->name, reference.recipe, reference.seconds[0], reference.seconds[1], reference.noise,
               reference.difference);
        gain_reference_clear(&reference);
        peer_scene_unload(&loaded[i]);
    }
}

/* ---- measuring ---- */

static void choose_variants(gain_variants_t *variants, int argc, char **argv)
{
    fault_t fault = {0};
    const char *list = options_value(argc, argv, "--list"), *names = options_value(argc, argv, "--variants");
    const bool all = names && strcmp(names, "all") == 0;
    if (names)
        gain_variants_all(variants);
    else
        gain_variants_usual(variants);
    if ((list && gain_variants_read(variants, list, &fault)) ||
        (names && !all && gain_variants_select(variants, names, &fault)))
        gain_fail(&fault);
}

/* Says which variants this build does not know; returns how many it does. */
static size_t check_variants(const gain_variants_t *variants, const peer_scene_t *entry)
{
    size_t known = 0;
    for (size_t i = 0; i < variants->count; i++) {
        fault_t fault = {0};
        job_t job;
        if (gain_job(&job, entry, (gain_size_t){1, 1}, &variants->items[i], 1, 1, &fault))
            fprintf(stderr, "skipped: %s\n", fault.text);
        else
            known++;
    }
    return known;
}

static void write_text(const char *folder, const char *prefix, const char *name, const char *text)
{
    fault_t fault = {0};
    char path[PATH_ROOM];
    snprintf(path, sizeof path, "%s/%s%s", folder, prefix, name);
    if (file_write(path, text, strlen(text), &fault))
        gain_fail(&fault);
}

static void measure_scene(const peer_scene_t *entry, const gain_options_t *options, const char *references,
                          const char *folder)
{
    fault_t fault = {0};
    gain_reference_t reference;
    gain_scene_t scene;
    char name[GAIN_NAME + 8];
    peer_loaded_t *loaded = load(entry);
    if (gain_reference_read(&reference, entry, gain_size_of(entry, options->width), references, &fault) ||
        gain_measure(&scene, loaded, &reference, options, &fault))
        gain_fail(&fault);
    json_t *root = gain_scene_json(&scene);
    char *text = json_print(root, true);
    snprintf(name, sizeof name, "%s.json", entry->name);
    write_text(folder, "", name, text);
    free(text);
    json_destroy(&root);
    gain_scene_clear(&scene);
    gain_reference_clear(&reference);
    peer_scene_unload(&loaded);
}

static void gain_measure_all(int argc, char **argv)
{
    static const char *const names[] = {"--references", "--out",     "--scenes",  "--variants",
                                        "--list",       "--seconds", "--points",  "--seeds",
                                        "--first-seed", "--width",   "--threads", NULL};
    static gain_variants_t variants;
    options_scenes_t list;
    fault_t fault = {0};
    options_expect(argc, argv, names);
    options_scenes(&list, argc, argv, usual_scenes);
    choose_variants(&variants, argc, argv);
    const char *references = needed(argc, argv, "--references"), *folder = needed(argc, argv, "--out");
    const gain_options_t options = {.variants = &variants,
                                    .width = width_of(argc, argv),
                                    .seconds = options_number(argc, argv, "--seconds", 2, 0.01, 1e5),
                                    .points = (size_t)options_number(argc, argv, "--points", 4, 1, GAIN_POINTS),
                                    .first_seed = (uint64_t)options_number(argc, argv, "--first-seed", 1, 0, 1e9),
                                    .seeds = (unsigned)options_number(argc, argv, "--seeds", 10, 1, GAIN_MAX_SEEDS),
                                    .threads = threads_of(argc, argv)};
    if (file_make_folder(folder, &fault))
        gain_fail(&fault);
    if (list.count == 0)
        return;
    const size_t known = check_variants(&variants, list.entries[0]);
    fprintf(stderr, "%zu variants, %u seeds, %zu scenes, %g CPU s each: about %.0f minutes of %u idle cores\n",
            known, options.seeds, list.count, options.seconds,
            (double)(known * options.seeds * list.count) * options.seconds / options.threads / 60, options.threads);
    for (size_t i = 0; i < list.count; i++)
        measure_scene(list.entries[i], &options, references, folder);
}

/* ---- reporting ---- */

typedef void gain_printer_t(FILE *out, const gain_scene_t *scenes, size_t count);
typedef char *gain_plotter_t(const gain_scene_t *scenes, size_t count);

static void write_table(const char *folder, const char *prefix, const char *name, gain_printer_t *print,
                        const gain_scene_t *scenes, size_t count)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        abort();
    print(out, scenes, count);
    if (fclose(out) != 0)
        abort();
    write_text(folder, prefix, name, text);
    free(text);
}

static void write_plot(const char *folder, const char *prefix, const char *name, gain_plotter_t *plot,
                       const gain_scene_t *scenes, size_t count)
{
    char *text = plot(scenes, count);
    write_text(folder, prefix, name, text);
    free(text);
}

/* The scenes of the list that have been measured. */
static size_t read_scenes(gain_scene_t *scenes, const options_scenes_t *list, const char *folder)
{
    size_t count = 0;
    for (size_t i = 0; i < list->count; i++) {
        char path[PATH_ROOM];
        fault_t fault = {0};
        snprintf(path, sizeof path, "%s/%s.json", folder, list->entries[i]->name);
        if (!file_exists(path))
            fprintf(stderr, "%s is not there: %s is left out\n", path, list->entries[i]->name);
        else if (gain_scene_read(&scenes[count], path, &fault))
            gain_fail(&fault);
        else
            count++;
    }
    return count;
}

static void gain_report(int argc, char **argv)
{
    static const char *const names[] = {"--from", "--out", "--scenes", "--prefix", NULL};
    options_scenes_t list;
    fault_t fault = {0};
    options_expect(argc, argv, names);
    options_scenes(&list, argc, argv, usual_scenes);
    const char *from = needed(argc, argv, "--from"), *folder = needed(argc, argv, "--out"),
               *prefix = options_value(argc, argv, "--prefix");
    gain_scene_t *scenes = seeds_allocate(list.count, sizeof *scenes);
    const size_t count = read_scenes(scenes, &list, from);
    prefix = prefix ? prefix : "";
    if (file_make_folder(folder, &fault))
        gain_fail(&fault);
    write_table(folder, prefix, "summary.txt", gain_print_summary, scenes, count);
    write_table(folder, prefix, "scenes.txt", gain_print_scenes, scenes, count);
    write_table(folder, prefix, "moves.txt", gain_print_moves, scenes, count);
    write_table(folder, prefix, "claims.txt", gain_print_claims, scenes, count);
    write_plot(folder, prefix, "time.svg", gain_plot_time, scenes, count);
    write_plot(folder, prefix, "end.svg", gain_plot_end, scenes, count);
    write_plot(folder, prefix, "stability.svg", gain_plot_stability, scenes, count);
    for (size_t i = 0; i < count; i++)
        gain_scene_clear(&scenes[i]);
    free(scenes);
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        void (*run)(int argc, char **argv);
    } commands[] = {{"references", gain_references}, {"measure", gain_measure_all}, {"report", gain_report}};
    for (size_t i = 0; argc > 1 && i < sizeof commands / sizeof *commands; i++)
        if (strcmp(argv[1], commands[i].name) == 0) {
            commands[i].run(argc - 1, argv + 1);
            return 0;
        }
    fprintf(stderr, "bench_gain: expected references, measure or report and options\n");
    return 2;
}
