/* bench_predict: what the first tenth of a render says about the time of its end, against what it took:
 * docs/accuracy.md.
 *
 *     bench_predict [--scenes diffuse,glossy] [--seconds 12] [--algorithm auto] [--seed 1] [--json FILE]
 *
 * Without --scenes all that are there. Each is rendered on one thread, and its clock is this thread's processor
 * time: other work on the machine makes the bench slower, not its figures. What is foretold is when the error would
 * be what the render ended with, from the points of its history up to a tenth of its time (docs/reports.md,
 * first_tenth). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "fail.h"
#include "options.h"
#include "plan/plan.h"

typedef struct bench {
    options_scenes_t scenes;
    const char *algorithm;
    double seconds;
    unsigned seed;
} bench_t;

/* What one render foretold; times in processor seconds, NaN: nothing. */
typedef struct prediction {
    double error, at, predicted, low, high, actual;
    bool then, reliable; /* the estimate that it was foretold from, and the last one */
} prediction_t;

static void bench_options(bench_t *bench, int argc, char **argv)
{
    static const char *const names[] = {"--scenes", "--seconds", "--algorithm", "--seed", "--json", NULL};
    options_expect(argc, argv, names);
    if (options_value(argc, argv, "--scenes")) {
        options_scenes(&bench->scenes, argc, argv, "");
    } else {
        const peer_scene_t *entry;
        for (size_t i = 0; (entry = peer_scene_at(i)) && bench->scenes.count < OPTIONS_LIST; i++)
            if (peer_scene_present(entry))
                bench->scenes.entries[bench->scenes.count++] = entry;
    }
    const char *algorithm = options_value(argc, argv, "--algorithm");
    bench->algorithm = algorithm ? algorithm : "auto";
    bench->seconds = options_number(argc, argv, "--seconds", 12, 1, 1e5);
    bench->seed = (unsigned)options_number(argc, argv, "--seed", 1, 0, 1e9);
}

static void bench_job(job_t *job, const bench_t *bench, const peer_scene_t *scene)
{
    fault_t fault = {0};
    char text[1024];
    snprintf(text, sizeof text,
             "{\"scene\":\"%s\",\"film\":{\"width\":%u,\"height\":%u,\"filter\":\"box\"},\"algorithm\":\"%.64s\","
             "\"max_path_length\":%u,\"seed\":\"%u\",\"stop\":{\"seconds\":%.17g}}",
             scene->name, scene->width, scene->height, bench->algorithm, scene->max_path_length, bench->seed,
             bench->seconds);
    if (job_parse(job, text, strlen(text), "bench", &fault))
        bench_fail(&fault);
}

static fault_code_t bench_unit(plan_t *plan, work_space_t *space, fault_t *fault)
{
    const atomic_bool cancel = false;
    const work_record_t *record;
    uint64_t unit;
    size_t size;
    uint8_t *data;
    work_result_t result;
    plan_absorbed_t how;
    if (!plan_next(plan, &unit, &record))
        return fault_set(fault, FAULT_RANGE, "a plan has no unit to do, and is not done");
    TRY(work_run(space, record, &cancel, &result, fault));
    TRY(work_result_encode(&result, &data, &size, fault));
    const fault_code_t code = plan_absorb(plan, unit, data, size, &how, fault);
    free(data);
    return code;
}

static double member(const json_t *object, const char *name)
{
    const json_t *value = json_get(object, name);
    return value && json_is_number(value) ? json_number(value) : NAN;
}

static void bench_read(prediction_t *found, const plan_t *plan)
{
    fault_t fault = {0};
    json_t *report = plan_report(plan);
    const json_t *error = json_get(report, "error"),
                 *tenth = json_get(json_get(report, "prediction"), "first_tenth");
    *found = (prediction_t){.error = member(error, "error"),
                            .at = member(tenth, "at_seconds"),
                            .predicted = member(tenth, "predicted_seconds"),
                            .low = member(tenth, "low"),
                            .high = member(tenth, "high"),
                            .actual = member(tenth, "actual_seconds")};
    if (json_read_bool_or(error, "error", "reliable", &found->reliable, &fault) ||
        (tenth && json_read_bool_or(tenth, "first_tenth", "reliable", &found->then, &fault)))
        bench_fail(&fault);
    json_destroy(&report);
}

static fault_code_t bench_render(prediction_t *found, const scene_t *scene, const job_t *job, fault_t *fault)
{
    plan_t *plan = NULL;
    renderer_t *renderer = NULL;
    work_space_t *space = NULL;
    fault_code_t code = plan_new(&plan, job, scene, fault);
    if (!code)
        code = renderer_new(&renderer, scene, &job->settings, fault);
    if (!code)
        code = work_space_new(&space, renderer, fault);
    const double begin = clock_thread_cpu();
    while (!code && !plan_check_stop(plan, clock_thread_cpu() - begin))
        code = bench_unit(plan, space, fault);
    if (!code)
        bench_read(found, plan);
    work_space_destroy(&space);
    renderer_destroy(&renderer);
    plan_destroy(&plan);
    return code;
}

static json_t *prediction_json(const char *scene, const prediction_t *found)
{
    json_t *object = json_new_object();
    json_add_string(object, "scene", scene);
    json_add_number(object, "error", found->error);
    json_add(object, "reliable", json_new_bool(found->reliable));
    json_add(object, "reliable_then", json_new_bool(found->then));
    json_add_number(object, "at_seconds", found->at);
    json_add_number(object, "predicted_seconds", found->predicted);
    json_add_number(object, "low", found->low);
    json_add_number(object, "high", found->high);
    json_add_number(object, "actual_seconds", found->actual);
    return object;
}

static prediction_t bench_scene(const bench_t *bench, const peer_scene_t *entry)
{
    fault_t fault = {0};
    peer_loaded_t *loaded;
    job_t job;
    prediction_t found = {0};
    if (peer_scene_load(&loaded, entry, &fault))
        bench_fail(&fault);
    bench_job(&job, bench, entry);
    if (bench_render(&found, &loaded->scene, &job, &fault))
        bench_fail(&fault);
    peer_scene_unload(&loaded);
    return found;
}

int main(int argc, char **argv)
{
    static bench_t bench;
    bench_options(&bench, argc, argv);
    json_t *root = json_new_object(), *cases = json_new_array();
    unsigned near = 0, covered = 0, known = 0, sure = 0, sure_near = 0;
    printf("%s, %g CPU seconds each, seed %u\n\n%-16s %9s %9s %7s %5s %9s %17s %8s %9s\n", bench.algorithm,
           bench.seconds, bench.seed, "scene", "error", "reliable", "after", "then", "foretold", "95 %", "it took",
           "ratio");
    for (size_t i = 0; i < bench.scenes.count; i++) {
        const prediction_t found = bench_scene(&bench, bench.scenes.entries[i]);
        const double ratio = found.predicted / found.actual;
        printf("%-16s %8.2f %% %9s %5.2f s %5s %7.2f s %7.2f to %6.2f %6.2f s %9.2f\n",
               bench.scenes.entries[i]->name, 100 * found.error, found.reliable ? "yes" : "no", found.at,
               found.then ? "yes" : "no", found.predicted, found.low, found.high, found.actual, ratio);
        fflush(stdout);
        known += isfinite(ratio);
        near += fabs(ratio - 1) <= 0.2;
        sure += found.then;
        sure_near += found.then && fabs(ratio - 1) <= 0.2;
        covered += found.low <= found.actual && found.actual <= found.high;
        json_append(cases, prediction_json(bench.scenes.entries[i]->name, &found));
    }
    printf(
        "\nof %zu, foretold %u, within a fifth %u, inside of the interval %u; by estimates that were reliable then "
        "%u, within a fifth %u\n",
        bench.scenes.count, known, near, covered, sure, sure_near);
    json_add(root, "cases", cases);
    options_write_json(root, argc, argv);
    json_destroy(&root);
    return 0;
}
