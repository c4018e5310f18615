/* garland bench: what a file may say, figures over the seeds against values worked out by hand, processes that
 * fail, are late or are told to stop, tables and the picture, a tiny run that is not made twice. */
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/clock.h"
#include "base/file.h"
#include "client/bench/pool.h"
#include "client/bench/results_plot.h"
#include "client/bench/results_table.h"
#include "support/near.h"
#include "support/small_scenes.h"

static const char good[] =
    "{\"scenes\":[{\"name\":\"box\",\"scene\":\"box.pbrt\",\"film\":{\"width\":8,\"height\":8},"
    "\"max_path_length\":3}],"
    "\"variants\":[{\"name\":\"b\",\"algorithm\":\"bdpt\"},{\"name\":\"m\",\"algorithm\":\"mmlt\","
    "\"chains\":{\"large_step\":0.3}}],"
    "\"budgets\":{\"mutations_per_pixel\":[1,4]},\"seeds\":3,\"workers\":2}";

static matrix_t matrix;

static fault_code_t parse(const char *text, fault_t *fault)
{
    *fault = (fault_t){0};
    return matrix_parse(&matrix, text, strlen(text), "folder/m.json", fault);
}

/* ---- the file ---- */

static void a_file_is_read(void **state)
{
    (void)state;
    fault_t fault;
    if (parse(good, &fault))
        fail_msg("%s", fault.text);
    assert_int_equal(matrix.scene_count, 1);
    assert_string_equal(matrix.scenes[0].scene, "folder/box.pbrt");
    assert_int_equal(matrix.variant_count, 2);
    assert_string_equal(matrix.variants[0].chains, "{}");
    assert_int_equal(matrix.budget_count, 2);
    assert_true(matrix.by_mutations);
    assert_int_equal(matrix.seeds, 3);
    assert_int_equal(matrix.workers, 2);
    job_t *job = calloc(1, sizeof *job);
    assert_int_equal(matrix_job(job, &matrix, 0, 1, 7, 1, &fault), FAULT_NONE);
    assert_near(job->stop.mutations_per_pixel, 4, 0);
    assert_near(job->settings.large_step, 0.3, 0);
    assert_int_equal(job->settings.seed, 7);
    free(job);
}

/* `from` in the good file replaced by `to`. */
static void expect_refusal(const char *from, const char *to, const char *words)
{
    char text[2048];
    fault_t fault;
    const char *at = strstr(good, from);
    assert_non_null(at);
    snprintf(text, sizeof text, "%.*s%s%s", (int)(at - good), good, to, at + strlen(from));
    if (parse(text, &fault) == FAULT_NONE)
        fail_msg("%s in place of %s was taken", to, from);
    if (!strstr(fault.text, words) || !strstr(fault.text, "m.json"))
        fail_msg("no \"%s\" with the file's name in: %s", words, fault.text);
}

static void what_is_wrong_is_refused_with_its_place(void **state)
{
    (void)state;
    expect_refusal("\"seeds\"", "\"sedes\"", "sedes");
    expect_refusal("\"seeds\":3", "\"seeds\":0", "seeds: expected a whole number from 1");
    expect_refusal("\"workers\":2", "\"workers\":1e9", "workers: expected");
    expect_refusal("[1,4]", "[4,1]", "budgets.mutations_per_pixel[1]: expected a number");
    expect_refusal("[1,4]", "[]", "budgets.mutations_per_pixel: expected a list");
    expect_refusal("[1,4]", "[1,\"4\"]", "budgets.mutations_per_pixel[1]");
    expect_refusal("{\"mutations_per_pixel\":[1,4]}", "{}", "budgets: expected one of");
    expect_refusal("{\"mutations_per_pixel\":[1,4]}", "{\"seconds\":[1],\"mutations_per_pixel\":[1]}",
                   "budgets: expected one of");
    expect_refusal("\"name\":\"box\"", "\"name\":\"../box\"", "scenes[0].name: found \"../box\"");
    expect_refusal("\"name\":\"m\"", "\"name\":\"b\"", "variants[1].name: \"b\" is variants[0]'s too");
    expect_refusal("\"name\":\"m\",", "", "variants[1].name: missing");
    expect_refusal("\"mmlt\"", "\"nonesuch\"", "box with m: algorithm");
    expect_refusal("0.3", "3", "chains.large_step");
    expect_refusal("\"width\":8", "\"width\":-8", "film.width");
    expect_refusal("\"max_path_length\":3", "\"max_path_length\":3,\"references\":[]", "scenes[0].references");
    expect_refusal("\"max_path_length\":3", "\"max_path_length\":3,\"references\":[1]",
                   "scenes[0].references[0]: expected the path");
    expect_refusal("\"workers\":2", "\"reference\":{\"seconds\":1}", "reference.algorithm: missing");
    expect_refusal("\"scenes\":[{", "\"scenes\":[1,{", "scenes[0]");
    expect_refusal("\"workers\":2}", "\"workers\":2} x", "m.json");
}

/* ---- figures ---- */

static void widths_are_those_of_student(void **state)
{
    (void)state;
    /* Tables give 12.706, 2.262, 2.201, 2.086 and 1.980 for 1, 9, 11, 20 and 120 degrees of freedom. */
    assert_true(isnan(seeds_width(1)));
    assert_near(seeds_width(2), 12.706, 1e-3);
    assert_near(seeds_width(10), 2.262, 1e-3);
    assert_near(seeds_width(12), 2.201, 0.003);
    assert_near(seeds_width(21), 2.086, 0.003);
    assert_near(seeds_width(121), 1.980, 0.001);
}

static void fill(results_t *results, size_t variant, size_t seed, double cpu, double relmse, double bias)
{
    run_figures_t *run = results_run(results, 0, variant, seed);
    run->made = true;
    for (size_t b = 0; b < 2; b++)
        run->points[b] =
            (run_point_t){cpu * (double)(b + 1), 8, relmse / (double)(b + 1), relmse / 4, bias, 2 * relmse};
}

static results_t *filled(void)
{
    static const double cpu[2][3] = {{1, 1, 1}, {2, 1, 1}}, error[2][3] = {{0.2, 0.4, 0.6}, {0.05, 0.1, 0.3}};
    results_t *results;
    fault_t fault;
    assert_int_equal(parse(good, &fault), FAULT_NONE);
    assert_int_equal(results_new(&results, &matrix, &fault), FAULT_NONE);
    strcpy(results->scenes[0].reference, "something");
    for (size_t v = 0; v < 2; v++)
        for (size_t i = 0; i < 3; i++)
            fill(results, v, i, cpu[v][i], error[v][i], 1 + 0.01 * (double)i);
    return results;
}

/* First variant: products 0.2, 0.4, 0.6 of mean 0.4; leaving one out 0.5, 0.4, 0.3. Second: 0.1, 0.1, 0.3 of mean
 * 1/6; leaving one out 0.2, 0.2, 0.1. Jackknife of their logarithms, Student's 4.303 with 2 degrees of freedom. */
static void gains_are_those_worked_out_by_hand(void **state)
{
    (void)state;
    results_t *results = filled();
    const results_cell_t cell = results_cell(results, 0, 1, 0);
    assert_near(cell.relmse.median, 0.1, 1e-15);
    assert_near(cell.relmse.min, 0.05, 1e-15);
    assert_near(cell.relmse.max, 0.3, 1e-15);
    assert_near(cell.cpu_seconds.median, 1, 0);
    assert_near(cell.bias.value, 1.01, 1e-15);
    assert_near(cell.bias.error, 0.01 / sqrt(3), 1e-15);
    assert_near(cell.gain.value, 2.4, 1e-12);
    const double a[3] = {log(0.5), log(0.4), log(0.3)}, b[3] = {log(0.2), log(0.2), log(0.1)};
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        const double da = a[i] - (a[0] + a[1] + a[2]) / 3, db = b[i] - (b[0] + b[1] + b[2]) / 3;
        sum += 2.0 / 3 * (da * da + db * db);
    }
    assert_near(log(cell.gain.high / cell.gain.value), 4.303 * sqrt(sum), 1e-12);
    assert_near(log(cell.gain.value / cell.gain.low), 4.303 * sqrt(sum), 1e-12);
    assert_near(results_cell(results, 0, 0, 0).gain.value, 1, 0);
    results_destroy(&results);
}

static void without_a_reference_estimates_are_compared(void **state)
{
    (void)state;
    results_t *results = filled();
    results->scenes[0].reference[0] = '\0';
    for (size_t i = 0; i < 3; i++)
        for (size_t b = 0; b < 2; b++)
            results_run(results, 0, 1, i)->points[b].estimate *= 3;
    assert_near(results_cell(results, 0, 1, 0).gain.value, 0.8, 1e-12);
    results_destroy(&results);
}

static char *print(void (*printer)(FILE *, const results_t *), const results_t *results)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    printer(out, results);
    fclose(out);
    return text;
}

static void tables_and_picture_hold_the_figures_and_the_failures(void **state)
{
    (void)state;
    results_t *results = filled();
    run_figures_t *lost = results_run(results, 0, 1, 2);
    lost->made = false;
    strcpy(lost->failure, "seed 3: was killed");
    char *table = print(results_print, results), *csv = print(results_print_csv, results),
         *plot = results_plot(results);
    assert_non_null(strstr(table, "0.4 (0.2, 0.6)"));
    assert_non_null(strstr(table, "not every run was made: seed 3: was killed"));
    assert_non_null(strstr(csv, "\r\nbox,m,1,2,")); /* two runs of it */
    assert_non_null(strstr(plot, "m: 0.0375 (0.025 to 0.05) after 3 s"));
    json_t *root = results_json(results);
    const json_t *runs = json_get(json_at(json_get(json_at(json_get(root, "scenes"), 0), "variants"), 1), "runs");
    assert_int_equal(json_size(runs), 3);
    assert_string_equal(json_string(json_get(json_at(runs, 2), "failure")), "seed 3: was killed");
    json_destroy(&root);
    free(table);
    free(csv);
    free(plot);
    results_destroy(&results);
}

/* ---- processes ---- */

static int good_tasks, bad_tasks;
static char last_failure[FAULT_TEXT_SIZE];

static fault_code_t task_work(void *user, size_t task, fault_t *fault)
{
    (void)user;
    if (task == 1)
        return fault_set(fault, FAULT_RANGE, "task %zu does not want to", task);
    if (task == 2)
        raise(SIGKILL);
    if (task == 3)
        sleep(600);
    return FAULT_NONE;
}

static void task_done(void *user, size_t task, const char *failure)
{
    (void)user;
    (void)task;
    good_tasks += failure == NULL;
    bad_tasks += failure != NULL;
    snprintf(last_failure, sizeof last_failure, "%s", failure ? failure : "");
}

static void processes_that_fail_are_told(void **state)
{
    (void)state;
    static const char *const words[] = {"", "task 1 does not want to", "killed by signal 9", "limit of 0.5 s", ""};
    fault_t fault = {0};
    const pool_options_t options = {.workers = 1, .limit_seconds = 0.5};
    good_tasks = bad_tasks = 0;
    for (size_t i = 0; i <= 4; i++) { /* tasks 0 .. i: the last one's words */
        assert_int_equal(pool_run(i + 1, task_work, task_done, NULL, &options, &fault), FAULT_NONE);
        assert_non_null(strstr(last_failure, words[i]));
    }
    assert_int_equal(good_tasks, 5 + 1);
    assert_int_equal(bad_tasks, 4 + 3 + 2);
}

static bool stop_now(void)
{
    return true;
}

static fault_code_t task_sleep(void *user, size_t task, fault_t *fault)
{
    (void)user;
    (void)task;
    (void)fault;
    sleep(600);
    return FAULT_NONE;
}

static void a_stop_ends_all_children(void **state)
{
    (void)state;
    fault_t fault = {0};
    const pool_options_t options = {.workers = 4, .limit_seconds = 1000, .stop = stop_now};
    const double began = clock_now();
    assert_int_equal(pool_run(10, task_sleep, task_done, NULL, &options, &fault), FAULT_CANCELLED);
    assert_true(clock_now() - began < 60);
}

/* ---- a run ---- */

static void a_run_is_read_back_and_only_for_its_own_job(void **state)
{
    (void)state;
    char path[] = "/tmp/garland-run-XXXXXX";
    small_scene_t box;
    fault_t fault;
    static run_figures_t figures;
    const int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    small_scene_box(&box, SMALL_LIGHT_AREA);
    assert_int_equal(parse(good, &fault), FAULT_NONE);
    run_context_t context = {.matrix = &matrix, .scene = &box.scene};
    assert_false(run_load(&figures, &context, 1, 5, path));
    if (run_render(&context, 1, 5, path, &fault))
        fail_msg("%s", fault.text);
    assert_true(run_load(&figures, &context, 1, 5, path));
    assert_true(figures.points[0].mutations_per_pixel >= 1);
    assert_true(figures.points[1].mutations_per_pixel >= 4);
    assert_true(figures.points[0].cpu_seconds > 0);
    assert_true(isnan(figures.points[1].relmse)); /* no reference */
    assert_false(run_load(&figures, &context, 1, 6, path));
    assert_false(run_load(&figures, &context, 0, 5, path));
    context.digest.bytes[3] = 1; /* another scene */
    assert_false(run_load(&figures, &context, 1, 5, path));
    unlink(path);
    small_scene_clear(&box);
}

static void runs_are_measured_against_halves_that_were_made(void **state)
{
    (void)state;
    char folder[] = "/tmp/garland-bench-XXXXXX", paths[2][128], path[128];
    small_scene_t box;
    fault_t fault;
    static run_figures_t figures;
    assert_non_null(mkdtemp(folder));
    small_scene_box(&box, SMALL_LIGHT_AREA);
    assert_int_equal(parse(good, &fault), FAULT_NONE);
    strcpy(matrix.reference, "bdpt");
    matrix.reference_seconds = 0.2;
    run_context_t context = {.matrix = &matrix, .scene = &box.scene};
    for (int half = 0; half < 2; half++) {
        char name[96];
        assert_int_equal(run_reference_name(&context, half, name, sizeof name, &fault), FAULT_NONE);
        snprintf(paths[half], sizeof paths[half], "%s/%s", folder, name);
        if (run_render_reference(&context, half, paths[half], &fault))
            fail_msg("%s", fault.text);
    }
    assert_string_not_equal(paths[0], paths[1]);
    assert_int_equal(run_context_references(&context, (const char *const[]){paths[0], paths[1]}, 2, &fault),
                     FAULT_NONE);
    snprintf(path, sizeof path, "%s/run.json", folder);
    assert_int_equal(run_render(&context, 0, 1, path, &fault), FAULT_NONE);
    assert_true(run_load(&figures, &context, 0, 1, path));
    /* 4 samples a pixel of a diffuse box: errors of some ten percent, not of nothing and not of all */
    assert_true(figures.points[1].relmse > 1e-4 && figures.points[1].relmse < 10);
    assert_true(figures.points[1].bias > 0.5 && figures.points[1].bias < 2);
    run_context_clear(&context);
    assert_false(run_load(&figures, &context, 0, 1, path)); /* no references: another run */
    unlink(path);
    unlink(paths[0]);
    unlink(paths[1]);
    rmdir(folder);
    small_scene_clear(&box);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_is_read),
        cmocka_unit_test(what_is_wrong_is_refused_with_its_place),
        cmocka_unit_test(widths_are_those_of_student),
        cmocka_unit_test(gains_are_those_worked_out_by_hand),
        cmocka_unit_test(without_a_reference_estimates_are_compared),
        cmocka_unit_test(tables_and_picture_hold_the_figures_and_the_failures),
        cmocka_unit_test(processes_that_fail_are_told),
        cmocka_unit_test(a_stop_ends_all_children),
        cmocka_unit_test(a_run_is_read_back_and_only_for_its_own_job),
        cmocka_unit_test(runs_are_measured_against_halves_that_were_made),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
