/* bench_gain's parts: figures over seeds, verdicts, files of figures, plots, renders ended by CPU time, references
 * that grow. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/file.h"
#include "base/random.h"
#include "gain_claims.h"
#include "gain_measure.h"
#include "gain_plot.h"
#include "gain_table.h"
#include "client/bench/seeds.h"
#include "client/bench/solo.h"
#include "support/near.h"
#include "support/normal.h"
#include "draw/svg.h"

/* ---- figures over seeds ---- */

static void deviation_of_two_seeds_is_their_distance(void **state)
{
    (void)state;
    /* s = |a - b| / sqrt(2) in each pixel; the mean of all values is 2.5 */
    const float values[] = {1, 2, 3, 4, 2, 2, 4, 2};
    gain_figure_t mean, percentile;
    seeds_deviation(values, 2, 4, &mean, &percentile);
    assert_near(mean.value, (1 + 0 + 1 + 2) / 4. * M_SQRT1_2 / 2.5, 1e-12);
    assert_near(percentile.value, 1 * M_SQRT1_2 / 2.5, 1e-12); /* of four: the third, index floor(0.99 * 3) */
    assert_true(isnan(mean.error));
}

/* Independent Gaussian pixels, 12 seeds, 4000 of them: the sample deviation's mean is c4(12) = 0.97756 of sigma,
 * its spread 0.21; over 4000 pixels 0.0034. Ten of these are the tolerance: false alarms below 1e-20. The error
 * estimated by leaving out seeds is of that size; with n = 12 it varies by a factor of two at most. */
static void deviation_and_its_error_agree_with_theory(void **state)
{
    (void)state;
    enum { SEEDS = 12, PIXELS = 4000 };
    static float values[SEEDS * PIXELS];
    const uint64_t key = random_key(7, RANDOM_PURPOSE_TEST, 0, 0);
    for (uint64_t i = 0; i < SEEDS * PIXELS; i++) {
        values[i] = (float)(10 + normal_of(random_double(key, 2 * i), random_double(key, 2 * i + 1)));
    }
    gain_figure_t mean, percentile;
    seeds_deviation(values, SEEDS, PIXELS, &mean, &percentile);
    assert_near(mean.value, 0.097756, 0.0034 * 10 / 10);
    assert_true(percentile.value > mean.value && percentile.value < 2 * mean.value);
    assert_true(mean.error > 0.00034 / 3 && mean.error < 0.00034 * 3);
}

static void logarithms_of_means_have_the_delta_methods_errors(void **state)
{
    (void)state;
    /* close together: the jackknife of log(mean) is s / (mean sqrt(n)) to first order */
    const double values[] = {10.01, 9.98, 10.03, 9.97, 10.02, 9.99};
    double mean = 0, sum = 0;
    for (int i = 0; i < 6; i++)
        mean += values[i] / 6;
    for (int i = 0; i < 6; i++)
        sum += (values[i] - mean) * (values[i] - mean);
    const gain_figure_t figure = seeds_log_mean(values, 6);
    assert_near(figure.value, log(mean), 1e-12);
    assert_near(figure.error, sqrt(sum / 30) / mean, 1e-3 * figure.error);
    assert_near(seeds_log_deviation(values, 6).value, log(sqrt(sum / 5)), 1e-12);
    const double negative[] = {-1, 0.5};
    assert_true(isnan(seeds_log_mean(negative, 2).value));
}

static void ratios_come_with_intervals_on_both_sides(void **state)
{
    (void)state;
    const seeds_ratio_t ratio = seeds_log_ratio((gain_figure_t){log(3.), 0.3}, (gain_figure_t){log(2.), 0.4});
    assert_near(ratio.value, 1.5, 1e-12);
    assert_near(ratio.low, 1.5 * exp(-SEEDS_WIDTH * 0.5), 1e-12);
    assert_near(ratio.high, 1.5 * exp(SEEDS_WIDTH * 0.5), 1e-12);
}

static void verdicts_need_the_whole_interval(void **state)
{
    (void)state;
    assert_int_equal(gain_verdict_of(0.5, 0.9, 1, false), GAIN_HOLDS);
    assert_int_equal(gain_verdict_of(0.5, 0.9, 1, true), GAIN_CONTRARY);
    assert_int_equal(gain_verdict_of(0.5, 1.1, 1, false), GAIN_UNDECIDED);
    assert_int_equal(gain_verdict_of(1.1, 1.2, 1, true), GAIN_HOLDS);
    assert_int_equal(gain_verdict_of(NAN, NAN, 1, true), GAIN_UNDECIDED);
}

/* ---- files and pictures ---- */

/* Two variants of three runs; errors fall as 1 / time, "rjmlt" has half of "mmlt"'s. */
static void fill_scene(gain_scene_t *scene)
{
    *scene = (gain_scene_t){.size = {8, 6},
                            .max_path_length = 3,
                            .times = {0.5, 1},
                            .point_count = 2,
                            .calibration = 4.5,
                            .reference_seconds = {20, 40},
                            .reference_noise = 1e-4,
                            .reference_difference = 1e-3,
                            .entry_count = 3};
    snprintf(scene->name, sizeof scene->name, "a<b>&\"c\"");
    snprintf(scene->recipe, sizeof scene->recipe, "bdpt");
    scene->entries = seeds_allocate(3, sizeof *scene->entries);
    for (size_t i = 0; i < 2; i++) {
        gain_entry_t *entry = &scene->entries[i];
        snprintf(entry->variant.name, GAIN_NAME, "%s", i ? "rjmlt" : "mmlt");
        snprintf(entry->variant.algorithm, GAIN_NAME, "%s", i ? "rjmlt" : "mmlt");
        snprintf(entry->variant.chains, GAIN_CHAINS, "{\"failures\":\"plain\"}");
        entry->run_count = 3;
        entry->runs = seeds_allocate(3, sizeof *entry->runs);
        for (size_t r = 0; r < 3; r++) {
            entry->runs[r] = (gain_run_t){
                .seed = UINT64_MAX - r, .estimate = NAN, .us_per_mutation = 0.75, .rays_per_mutation = 2.5};
            for (size_t p = 0; p < 2; p++)
                entry->runs[r].points[p] =
                    (gain_point_t){.cpu_seconds = 0.5 * (double)(p + 1),
                                   .mutations = 1000,
                                   .relmse = (0.1 + 0.01 * (double)r) / (double)((p + 1) * (i + 1)),
                                   .trimmed = 0.05,
                                   .brightness = 1};
        }
        entry->deviation = (gain_figure_t){0.25, 0.01};
        entry->deviation_99 = (gain_figure_t){0.75, 0.1};
        entry->length_count = 3;
        for (size_t k = 1; k <= 3; k++) {
            entry->lengths[k].mutations = 100 * (double)k;
            gain_length_add(&entry->lengths[k], "small", 90, 0.5);
            gain_length_add(&entry->lengths[k], i ? "jump" : "technique", 10, i ? 1 : 0.1);
        }
    }
    snprintf(scene->entries[2].variant.name, GAIN_NAME, "pssmlt");
    snprintf(scene->entries[2].refused, GAIN_TEXT, "unknown");
    snprintf(scene->entries[2].variant.chains, GAIN_CHAINS, "{}");
}

static char *scene_text(const gain_scene_t *scene)
{
    json_t *root = gain_scene_json(scene);
    char *text = json_print(root, true);
    json_destroy(&root);
    return text;
}

static void figures_come_back_from_their_file(void **state)
{
    (void)state;
    char path[] = "/tmp/garland-gain-XXXXXX";
    gain_scene_t scene, back;
    fault_t fault = {0};
    fill_scene(&scene);
    const int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    char *text = scene_text(&scene);
    if (file_write(path, text, strlen(text), &fault) || gain_scene_read(&back, path, &fault))
        fail_msg("%s", fault.text);
    for (size_t i = 0; i < 3; i++) /* not read: tables have no need of them */
        memcpy(back.entries[i].variant.chains, scene.entries[i].variant.chains, GAIN_CHAINS);
    char *again = scene_text(&back);
    assert_string_equal(text, again);
    assert_true(gain_scene_find(&back, "pssmlt") == NULL);
    assert_near(gain_entry_spread(gain_scene_find(&back, "rjmlt"), 1, GAIN_RELMSE_CPU).median, 0.11 / 4, 1e-15);
    unlink(path);
    free(text);
    free(again);
    gain_scene_clear(&scene);
    gain_scene_clear(&back);
}

static void acceptance_of_all_lengths_is_that_of_all_proposals(void **state)
{
    (void)state;
    gain_entry_t entry = {.length_count = 2};
    gain_length_add(&entry.lengths[1], "small", 100, 0.8);
    gain_length_add(&entry.lengths[2], "small", 300, 0.4);
    gain_length_add(&entry.lengths[2], "jump", 0, 0);
    const gain_length_t total = gain_entry_total(&entry);
    assert_int_equal(total.move_count, 1);
    assert_near(gain_length_move(&total, "small")->acceptance, 0.5, 1e-12);
    assert_true(gain_length_move(&total, "jump") == NULL);
}

static char *print(void (*printer)(FILE *, const gain_scene_t *, size_t), const gain_scene_t *scene)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    printer(out, scene, 1);
    fclose(out);
    return text;
}

static void acceptance_of_chains_of_all_lengths_is_kept(void **state)
{
    (void)state;
    char path[] = "/tmp/garland-gain-XXXXXX";
    gain_scene_t scene, back;
    fault_t fault = {0};
    fill_scene(&scene);
    memset(scene.entries[1].lengths, 0, sizeof scene.entries[1].lengths);
    scene.entries[1].lengths[0].mutations = 1000;
    gain_length_add(&scene.entries[1].lengths[0], "small", 900, 0.375);
    char *text = scene_text(&scene);
    const int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    assert_int_equal(file_write(path, text, strlen(text), &fault), FAULT_NONE);
    free(text);
    assert_int_equal(gain_scene_read(&back, path, &fault), FAULT_NONE);
    unlink(path);
    const gain_length_t total = gain_entry_total(&back.entries[1]);
    assert_near(gain_length_move(&total, "small")->acceptance, 0.375, 1e-12);
    char *moves = print(gain_print_moves, &back);
    assert_non_null(strstr(moves, "0.375 (all lengths at once)"));
    free(moves);
    gain_scene_clear(&scene);
    gain_scene_clear(&back);
}

static void tables_say_who_gains_and_what_is_not_reproduced(void **state)
{
    (void)state;
    gain_scene_t scene;
    fill_scene(&scene);
    char *summary = print(gain_print_summary, &scene), *claims = print(gain_print_claims, &scene),
         *scenes = print(gain_print_scenes, &scene), *moves = print(gain_print_moves, &scene);
    assert_non_null(strstr(summary, "rjmlt                           2.00          2.00"));
    assert_non_null(strstr(claims, "=> reproduced on all 1 scenes"));
    assert_non_null(strstr(claims, "=> not measured"));                      /* cmlt */
    assert_non_null(strstr(claims, "=> NOT REPRODUCED on any of 1 scenes")); /* equal deviations */
    assert_non_null(strstr(scenes, "not measured: unknown"));
    assert_non_null(strstr(moves, "technique     0.100  0.100  0.100"));
    free(summary);
    free(claims);
    free(scenes);
    free(moves);
    gain_scene_clear(&scene);
}

/* Tags open and close in order, no bare ampersand: what a parser asks of text without comments or sections. */
static void check_xml(const char *text)
{
    char open[64][32];
    int depth = 0;
    for (const char *c = text; *c; c++) {
        if (*c == '&' && strncmp(c, "&amp;", 5) && strncmp(c, "&lt;", 4) && strncmp(c, "&gt;", 4) &&
            strncmp(c, "&quot;", 6))
            fail_msg("a bare ampersand: %.40s", c);
        if (*c != '<')
            continue;
        char name[32] = "";
        const bool closing = c[1] == '/';
        const char *end = strchr(c, '>');
        assert_non_null(end);
        assert_int_equal(sscanf(c + 1 + closing, "%31[a-z]", name), 1);
        if (closing) {
            assert_true(depth > 0);
            assert_string_equal(open[--depth], name);
        } else if (end[-1] != '/') {
            assert_true(depth < 64);
            memcpy(open[depth++], name, sizeof name);
        }
        c = end;
    }
    assert_int_equal(depth, 0);
}

static void plots_are_well_formed_whatever_the_names(void **state)
{
    (void)state;
    gain_scene_t scene;
    fill_scene(&scene);
    scene.entries[0].runs[0].points[1].relmse = -0.01; /* lost in the reference's noise */
    char *(*const plots[])(const gain_scene_t *, size_t) = {gain_plot_time, gain_plot_end, gain_plot_stability};
    for (size_t i = 0; i < 3; i++) {
        char *text = plots[i](&scene, 1);
        check_xml(text);
        assert_non_null(strstr(text, "a&lt;b&gt;&amp;&quot;c&quot;"));
        for (int n = 0; n < 2; n++) /* as a number, not in a word */
            for (const char *found = text; (found = strstr(found, n ? "inf" : "nan")); found++)
                if (strchr("\" (,-M", found[-1]))
                    fail_msg("a number that is none: %.60s", found - 20);
        free(text);
    }
    gain_scene_clear(&scene);
}

static void lists_of_variants_are_read_and_checked(void **state)
{
    (void)state;
    static const char text[] = "[{\"name\":\"a\",\"algorithm\":\"mmlt\",\"chains\":{\"large_step\":0.3}},"
                               "{\"name\":\"b\",\"algorithm\":\"bdpt\"}]";
    char path[] = "/tmp/garland-gain-XXXXXX";
    static gain_variants_t list;
    fault_t fault = {0};
    const int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    if (file_write(path, text, strlen(text), &fault) || gain_variants_read(&list, path, &fault))
        fail_msg("%s", fault.text);
    assert_int_equal(list.count, 2);
    assert_string_equal(list.items[0].chains, "{\"large_step\":0.3}");
    assert_int_equal(gain_variants_select(&list, "b,c", &fault), FAULT_UNKNOWN);
    assert_string_equal(fault.text, "there is no variant c");
    assert_int_equal(gain_variants_select(&list, "b", &fault), FAULT_NONE);
    assert_int_equal(list.count, 1);
    unlink(path);
}

/* ---- renders ---- */

static peer_loaded_t *load(const char *name)
{
    fault_t fault = {0};
    peer_loaded_t *loaded;
    if (peer_scene_load(&loaded, peer_scene_find(name), &fault))
        fail_msg("%s", fault.text);
    return loaded;
}

typedef struct looks {
    size_t count;
    double seconds[2];
} looks_t;

static fault_code_t look(void *user, size_t index, double cpu_seconds, const plan_t *plan, fault_t *fault)
{
    looks_t *looks = user;
    image_t image;
    assert_int_equal(index, looks->count++);
    assert_int_equal(plan_finished(plan), index == 1);
    looks->seconds[index] = cpu_seconds;
    TRY(plan_image(plan, &image, fault));
    image_clear(&image);
    return FAULT_NONE;
}

static void renders_end_by_cpu_time_and_are_looked_at_on_the_way(void **state)
{
    (void)state;
    const double times[] = {0.1, 0.2};
    const gain_variant_t variant = {"mmlt", "mmlt", "{}"};
    peer_loaded_t *loaded = load("diffuse");
    looks_t looks = {0};
    fault_t fault = {0};
    job_t job;
    if (gain_job(&job, loaded->entry, (gain_size_t){16, 16}, &variant, 1, times[1], &fault) ||
        solo_render(&loaded->scene, &job, times, 2, look, &looks, &fault))
        fail_msg("%s", fault.text);
    assert_int_equal(looks.count, 2);
    for (int i = 0; i < 2; i++)
        assert_true(looks.seconds[i] >= times[i]);
    assert_true(looks.seconds[0] <= looks.seconds[1]);
    peer_scene_unload(&loaded);
}

static unsigned files_in(const char *folder)
{
    char command[128];
    unsigned count = 0;
    snprintf(command, sizeof command, "ls %s | wc -l", folder);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    assert_int_equal(fscanf(pipe, "%u", &count), 1);
    pclose(pipe);
    return count;
}

/* Makes references twice, the second time twice as good, and measures against them. */
static void references_grow_and_runs_are_measured_against_them(void **state)
{
    (void)state;
    char folder[] = "/tmp/garland-gain-XXXXXX", command[64];
    static gain_variants_t variants = {
        .items = {{"bdpt", "bdpt", "{}"}, {"mmlt", "mmlt", "{}"}, {"no", "such-algorithm", "{}"}}, .count = 3};
    const gain_options_t options = {
        .variants = &variants, .width = 16, .seconds = 0.1, .points = 2, .first_seed = 1, .seeds = 3, .threads = 2};
    fault_t fault = {0};
    gain_reference_t reference;
    gain_scene_t scene;
    peer_loaded_t *loaded = load("diffuse");
    assert_non_null(mkdtemp(folder));
    assert_int_equal(gain_reference_read(&reference, loaded->entry, (gain_size_t){16, 16}, folder, &fault),
                     FAULT_NOT_FOUND);
    for (unsigned round = 1; round <= 2; round++) {
        if (gain_reference_make(&loaded, 1, 16, folder, 0.2 * round, 0.2, 2, &fault) ||
            gain_reference_read(&reference, loaded->entry, (gain_size_t){16, 16}, folder, &fault))
            fail_msg("%s", fault.text);
        assert_int_equal(files_in(folder), 2 * round);
        assert_near(reference.seconds[0], 0.2 * round, 1e-12);
        assert_true(reference.noise > 0);
        if (round == 1)
            gain_reference_clear(&reference);
    }
    if (gain_measure(&scene, loaded, &reference, &options, &fault))
        fail_msg("%s", fault.text);
    assert_int_equal(scene.entry_count, 3);
    assert_true(scene.entries[2].refused[0] != '\0');
    for (size_t i = 0; i < 2; i++) {
        const gain_entry_t *entry = &scene.entries[i];
        assert_string_equal(entry->refused, "");
        assert_true(entry->deviation.value > 0 && entry->deviation_99.value > entry->deviation.value);
        for (size_t r = 0; r < 3; r++) {
            assert_int_equal(entry->runs[r].seed, r + 1);
            assert_near(entry->runs[r].points[1].brightness, 1, 0.3); /* a tenth of a second of a diffuse room */
            assert_true(entry->runs[r].points[1].cpu_seconds >= 0.1);
        }
    }
    const gain_length_t total = gain_entry_total(&scene.entries[1]);
    assert_non_null(gain_length_move(&total, "large"));
    gain_scene_clear(&scene);
    gain_reference_clear(&reference);
    peer_scene_unload(&loaded);
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(deviation_of_two_seeds_is_their_distance),
        cmocka_unit_test(deviation_and_its_error_agree_with_theory),
        cmocka_unit_test(logarithms_of_means_have_the_delta_methods_errors),
        cmocka_unit_test(ratios_come_with_intervals_on_both_sides),
        cmocka_unit_test(verdicts_need_the_whole_interval),
        cmocka_unit_test(figures_come_back_from_their_file),
        cmocka_unit_test(acceptance_of_all_lengths_is_that_of_all_proposals),
        cmocka_unit_test(acceptance_of_chains_of_all_lengths_is_kept),
        cmocka_unit_test(tables_say_who_gains_and_what_is_not_reproduced),
        cmocka_unit_test(plots_are_well_formed_whatever_the_names),
        cmocka_unit_test(lists_of_variants_are_read_and_checked),
        cmocka_unit_test(renders_end_by_cpu_time_and_are_looked_at_on_the_way),
        cmocka_unit_test(references_grow_and_runs_are_measured_against_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
