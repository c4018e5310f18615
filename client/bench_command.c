/* garland bench: scenes, variants of algorithms and budgets over seeds, compared at equal CPU time. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "client/bench/pool.h"
#include "client/bench/results_plot.h"
#include "client/bench/results_table.h"
#include "client/commands.h"
#include "client/interrupt.h"
#include "client/options.h"
#include "client/remote.h"
#include "client/scene_source.h"
#include "client/temp_folder.h"
#include "scene/bundle.h"

static const char usage[] =
    "usage: garland bench FILE.json [--out DIR] [--json] [--quiet]\n"
    "\n"
    "Renders every scene with every variant for every seed, each run on one thread in a process of its own, and\n"
    "compares them with references at every budget (docs/bench.md). Runs whose results are in DIR already are not "
    "made\n"
    "again: after an interrupt the same command goes on.\n"
    "\n"
    "  --out DIR   where runs, references and results go: bench.txt, bench.json, bench.csv, bench.svg (default: "
    "bench)\n"
    "  --json      print the results as JSON in place of the table\n"
    "  --quiet     no line for each run\n"
    "\n"
    "Exit status: 0 every run was made, 1 some were not, 2 wrong usage.\n";

typedef struct bench {
    matrix_t matrix;
    results_t *results;
    run_context_t context; /* of the scene at hand */
    char runs[JOB_PATH_SIZE], references[JOB_PATH_SIZE];
    size_t *tasks; /* run numbers that are to be made: seed * variants + place in the seed's order */
    const char *out;
    bool quiet;
    fault_t trouble; /* the first of the references' */
} bench_t;

/* ---- runs ---- */

/* Interleaved: all variants of a seed, each seed beginning with another, so that a busy moment of the machine does
 * not meet one of them alone. */
static size_t variant_of(const bench_t *bench, size_t run)
{
    const size_t variants = bench->matrix.variant_count;
    return (run + run / variants) % variants;
}

static size_t seed_of(const bench_t *bench, size_t run)
{
    return run / bench->matrix.variant_count;
}

static fault_code_t run_path(const bench_t *bench, size_t run, char path[JOB_PATH_SIZE], fault_t *fault)
{
    char name[3 * MATRIX_NAME];
    snprintf(name, sizeof name, "%s-%s-%zu.json", bench->matrix.scenes[bench->context.index].name,
             bench->matrix.variants[variant_of(bench, run)].name, seed_of(bench, run) + 1);
    return file_join(path, JOB_PATH_SIZE, bench->runs, name, fault);
}

static run_figures_t *figures_of(const bench_t *bench, size_t run)
{
    return results_run(bench->results, bench->context.index, variant_of(bench, run), seed_of(bench, run));
}

static bool load_run(const bench_t *bench, size_t run)
{
    char path[JOB_PATH_SIZE];
    return run_path(bench, run, path, NULL) == FAULT_NONE &&
           run_load(figures_of(bench, run), &bench->context, variant_of(bench, run), seed_of(bench, run) + 1, path);
}

static fault_code_t work_run_task(void *user, size_t task, fault_t *fault)
{
    const bench_t *bench = user;
    const size_t run = bench->tasks[task];
    char path[JOB_PATH_SIZE];
    TRY(run_path(bench, run, path, fault));
    return run_render(&bench->context, variant_of(bench, run), seed_of(bench, run) + 1, path, fault);
}

static void run_done(void *user, size_t task, const char *failure)
{
    bench_t *bench = user;
    const matrix_t *m = &bench->matrix;
    const size_t run = bench->tasks[task];
    run_figures_t *figures = figures_of(bench, run);
    if (!failure && !load_run(bench, run))
        failure = "its results cannot be read back";
    if (failure)
        snprintf(figures->failure, sizeof figures->failure, "seed %zu: %.200s", seed_of(bench, run) + 1, failure);
    if (bench->quiet)
        return;
    const run_point_t *last = &figures->points[m->budget_count - 1];
    fprintf(stderr, "%s %s seed %zu: ", m->scenes[bench->context.index].name,
            m->variants[variant_of(bench, run)].name, seed_of(bench, run) + 1);
    if (failure)
        fprintf(stderr, "%s\n", failure);
    else
        fprintf(stderr, "%.2f CPU s, %.4g a pixel, relMSE %.4g, estimate %.4g\n", last->cpu_seconds,
                last->mutations_per_pixel, last->relmse, last->estimate);
}

static pool_options_t pool_options(const bench_t *bench)
{
    return (pool_options_t){bench->matrix.workers, bench->matrix.limit_seconds, interrupt_happened};
}

static fault_code_t make_runs(bench_t *bench, fault_t *fault)
{
    const size_t runs = bench->matrix.variant_count * bench->matrix.seeds;
    const pool_options_t options = pool_options(bench);
    size_t missing = 0;
    for (size_t run = 0; run < runs; run++)
        if (!load_run(bench, run))
            bench->tasks[missing++] = run;
    if (!bench->quiet && missing < runs)
        fprintf(stderr, "%s: %zu of %zu runs are there\n", bench->matrix.scenes[bench->context.index].name,
                runs - missing, runs);
    return pool_run(missing, work_run_task, run_done, bench, &options, fault);
}

/* ---- references ---- */

static fault_code_t reference_path(const bench_t *bench, size_t half, char path[JOB_PATH_SIZE], fault_t *fault)
{
    char name[2 * MATRIX_NAME];
    TRY(run_reference_name(&bench->context, (int)half, name, sizeof name, fault));
    return file_join(path, JOB_PATH_SIZE, bench->references, name, fault);
}

/* A half that is there stays. */
static fault_code_t work_reference_task(void *user, size_t task, fault_t *fault)
{
    const bench_t *bench = user;
    char path[JOB_PATH_SIZE];
    TRY(reference_path(bench, task, path, fault));
    return file_exists(path) ? FAULT_NONE : run_render_reference(&bench->context, (int)task, path, fault);
}

static void reference_done(void *user, size_t task, const char *failure)
{
    bench_t *bench = user;
    if (failure && bench->trouble.code == FAULT_NONE)
        fault_set(&bench->trouble, FAULT_IO, "half %zu of the reference: %.512s", task + 1, failure);
}

static fault_code_t make_references(bench_t *bench, fault_t *fault)
{
    char paths[2][JOB_PATH_SIZE];
    pool_options_t options = pool_options(bench);
    options.limit_seconds += 100 * bench->matrix.reference_seconds;
    bench->trouble = (fault_t){0};
    TRY(pool_run(2, work_reference_task, reference_done, bench, &options, fault));
    if (bench->trouble.code != FAULT_NONE)
        return fault_set(fault, bench->trouble.code, "%s", bench->trouble.text);
    for (size_t half = 0; half < 2; half++)
        TRY(reference_path(bench, half, paths[half], fault));
    return run_context_references(&bench->context, (const char *const[]){paths[0], paths[1]}, 2, fault);
}

/* The images that the file names, those that it asks to make, or none. */
static fault_code_t find_references(bench_t *bench, fault_t *fault)
{
    const matrix_t *m = &bench->matrix;
    const matrix_scene_t *scene = &m->scenes[bench->context.index];
    results_scene_t *about = &bench->results->scenes[bench->context.index];
    if (scene->reference_count > 0) {
        TRY(run_context_references(&bench->context,
                                   (const char *const[]){scene->references[0], scene->references[1]},
                                   scene->reference_count, fault));
        snprintf(about->reference, sizeof about->reference, "%s",
                 scene->reference_count > 1 ? "two halves of a reference" : "one reference, its noise included");
    } else if (m->reference[0]) {
        TRY(make_references(bench, fault));
        snprintf(about->reference, sizeof about->reference, "two halves by %s, %g CPU s each", m->reference,
                 m->reference_seconds);
    }
    return FAULT_NONE;
}

/* ---- scenes ---- */

static void note_size(bench_t *bench, const job_t *job)
{
    results_scene_t *about = &bench->results->scenes[bench->context.index];
    const scene_t *scene = bench->context.scene;
    const uint32_t w = job->settings.width, h = job->settings.height;
    about->width = w ? w : scene->camera->width;
    about->height = h ? h : scene->camera->height;
}

static fault_code_t measure_loaded(bench_t *bench, fault_t *fault)
{
    job_t *job = calloc(1, sizeof *job);
    if (!job)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job");
    const fault_code_t code = matrix_job(job, &bench->matrix, bench->context.index, 0, 1, 0, fault);
    if (code == FAULT_NONE)
        note_size(bench, job);
    free(job);
    TRY(code);
    TRY(find_references(bench, fault));
    return make_runs(bench, fault);
}

static fault_code_t measure_scene(bench_t *bench, size_t index, const char *folder, fault_t *fault)
{
    char path[TEMP_FOLDER_SIZE + 16];
    bundle_t *bundle;
    digest_t digest;
    snprintf(path, sizeof path, "%s/scene.bundle", folder);
    remove(path);
    TRY(scene_source_bundle(bench->matrix.scenes[index].scene, path, bench->quiet ? NULL : stderr, &digest, NULL,
                            fault));
    TRY(bundle_open(&bundle, path, fault));
    bench->context =
        (run_context_t){.matrix = &bench->matrix, .index = index, .scene = bundle_scene(bundle), .digest = digest};
    const fault_code_t code = measure_loaded(bench, fault);
    run_context_clear(&bench->context);
    bundle_destroy(&bundle);
    return code;
}

/* A scene that fails is told and passed over; an interrupt ends everything. */
static fault_code_t measure_scenes(bench_t *bench, fault_t *fault)
{
    char folder[TEMP_FOLDER_SIZE];
    fault_code_t code = FAULT_NONE;
    TRY(temp_folder_make(folder, fault));
    for (size_t s = 0; s < bench->matrix.scene_count && code == FAULT_NONE; s++) {
        fault_t own = {0};
        results_scene_t *about = &bench->results->scenes[s];
        const fault_code_t result = measure_scene(bench, s, folder, &own);
        if (result == FAULT_CANCELLED)
            code =
                fault_set(fault, result, "interrupted; the same command goes on from the runs in %s", bench->runs);
        else if (result != FAULT_NONE) {
            fprintf(stderr, "garland: %s: %s\n", bench->matrix.scenes[s].name, own.text);
            snprintf(about->failure, sizeof about->failure, "%.*s", (int)sizeof about->failure - 1, own.text);
        }
    }
    temp_folder_remove(folder);
    return code;
}

/* ---- results ---- */

typedef void printer_t(FILE *out, const results_t *results);

static void print_json(FILE *out, const results_t *results)
{
    json_t *root = results_json(results);
    char *text = json_print(root, true);
    fprintf(out, "%s\n", text);
    free(text);
    json_destroy(&root);
}

static void print_plot(FILE *out, const results_t *results)
{
    char *text = results_plot(results);
    fputs(text, out);
    free(text);
}

static fault_code_t write_result(const bench_t *bench, const char *name, printer_t *print, fault_t *fault)
{
    char path[JOB_PATH_SIZE], *text = NULL;
    size_t size = 0;
    TRY(file_join(path, sizeof path, bench->out, name, fault));
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return fault_set(fault, FAULT_MEMORY, "%s: no memory", path);
    print(out, bench->results);
    fault_code_t code = FAULT_NONE;
    if (fclose(out) != 0)
        code = fault_set(fault, FAULT_MEMORY, "%s: no memory", path);
    else
        code = file_write(path, text, size, fault);
    free(text);
    return code;
}

static fault_code_t write_results(const bench_t *bench, fault_t *fault)
{
    TRY(write_result(bench, "bench.txt", results_print, fault));
    TRY(write_result(bench, "bench.json", print_json, fault));
    TRY(write_result(bench, "bench.csv", results_print_csv, fault));
    return write_result(bench, "bench.svg", print_plot, fault);
}

static bool all_made(const results_t *results)
{
    for (size_t s = 0; s < results->matrix->scene_count; s++)
        for (size_t v = 0; v < results->matrix->variant_count; v++)
            if (results_failure(results, s, v))
                return false;
    return true;
}

static fault_code_t run(bench_t *bench, const char *name, fault_t *fault)
{
    TRY(matrix_read(&bench->matrix, name, fault));
    TRY(file_join(bench->runs, sizeof bench->runs, bench->out, "runs", fault));
    TRY(file_join(bench->references, sizeof bench->references, bench->out, "references", fault));
    TRY(file_make_folder(bench->runs, fault));
    TRY(file_make_folder(bench->references, fault));
    TRY(results_new(&bench->results, &bench->matrix, fault));
    bench->tasks = calloc(bench->matrix.variant_count * bench->matrix.seeds, sizeof *bench->tasks);
    if (!bench->tasks)
        return fault_set(fault, FAULT_MEMORY, "no memory for a list of runs");
    TRY(measure_scenes(bench, fault));
    return write_results(bench, fault);
}

int command_bench(int argc, char **argv)
{
    const char *name, *out = "bench";
    bool as_json = false, quiet = false;
    int status;
    fault_t fault = {0};
    const option_t list[] = {
        {"out", OPTION_TEXT, &out}, {"json", OPTION_FLAG, &as_json}, {"quiet", OPTION_FLAG, &quiet}, {0}};
    if (!options_parse("bench", usage, list, argc, argv, &name, 1, 1, &status))
        return status;
    bench_t *bench = calloc(1, sizeof *bench);
    if (!bench) {
        fprintf(stderr, "garland: out of memory\n");
        return STATUS_FAILURE;
    }
    bench->out = out;
    bench->quiet = quiet;
    interrupt_catch();
    if (run(bench, name, &fault) != FAULT_NONE) {
        status = remote_fail(&fault);
    } else {
        (as_json ? print_json : results_print)(stdout, bench->results);
        status = all_made(bench->results) ? STATUS_SUCCESS : STATUS_FAILURE;
    }
    results_destroy(&bench->results);
    free(bench->tasks);
    free(bench);
    return status;
}
