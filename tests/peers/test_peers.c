/* The shared scenes against images of other renderers. Skipped where GARLAND_SHARED names no folder.
 *
 * Renders are made at a fraction of the references' size: with a box filter a pixel is then exactly the mean of the
 * reference's, and errors go down as fast as at full size. Judged are the means of 8 x 8 blocks and of the image,
 * over independent seeds; the references are two independent halves of a long render.
 *
 * Power: what is too large a score falls with the number of seeds, 8.2 with 36 and 7.4 with 54, so many short
 * renders see more than few long ones of as much work: 54 with half of the work see what 36 with all of it did, to
 * 4 %. Half of all runs see a brightness that is off by 7.4 of the standard errors that are printed: of the Cornell
 * box half a percent by samples and one by chains, of ring-box 2.5 and 4 %, of two-rooms 5 and 8 %, of water-box,
 * whose caustics are rare, 8 and 12 %. What does not average out is seen from 1.3 of what it was on, as that goes
 * by the work of all seeds. Where colours are another model's, to 4 %, there are 36 seeds with half the work: 6 %
 * are seen in place of 5.6. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <setjmp.h>
#include <cmocka.h>

#include <gsl/gsl_cdf.h>

#include "film/compare.h"
#include "film/image_file.h"
#include "math/vec.h"
#include "parallel.h"
#include "peer_scene.h"
#include "regions.h"

/* FEW: candidates for pt and bdpt, whose pilot tells but the scale of the film's numbers, as a power of two. */
enum { SEEDS = 54, SEEDS_WITHIN = 36, LONG_SEEDS = 6, THREADS = 2, COMPARISONS = 14, FEW = 512 };

/* False alarms: 1e-6 in a whole run, two sides, all comparisons and all regions of each. The statistic is at most
 * Student's with a degree of freedom less than seeds: variances are not less than measured, and the reference's own
 * noise adds degrees. */
static double alarm_score(int seeds)
{
    return gsl_cdf_tdist_Qinv(1e-6 / (2 * COMPARISONS * REGIONS), seeds - 1);
}

typedef struct peer_case {
    const char *scene, *algorithm;
    uint32_t shrink;   /* the references' side over the renders' */
    double mutations;  /* per pixel and seed */
    double candidates; /* of the pilot, a path length; 0: the plan's own number */
    bool exact;        /* precise enough that the brightness is held to 1 % */
    bool rate;         /* its error is compared with that of four times the mutations */
} peer_case_t;

static peer_loaded_t *scene_load(const char *name)
{
    fault_t fault = {0};
    peer_loaded_t *loaded = NULL;
    const peer_scene_t *entry = peer_scene_find(name);
    assert_non_null(entry);
    if (!peer_scene_present(entry)) {
        print_message("%s is not there: set GARLAND_SHARED to the folder of the shared scenes\n", name);
        skip();
    }
    if (peer_scene_load(&loaded, entry, &fault))
        fail_msg("%s", fault.text);
    return loaded;
}

static job_t case_job(const peer_case_t *c, const peer_scene_t *entry)
{
    fault_t fault = {0};
    job_t job;
    char text[512], chains[64] = "";
    if (c->candidates > 0)
        snprintf(chains, sizeof chains, "\"pilot_samples\":%.0f", c->candidates);
    snprintf(text, sizeof text,
             "{\"scene\":\"%s\",\"film\":{\"width\":%u,\"height\":%u,\"filter\":\"box\"},\"algorithm\":\"%s\","
             "\"max_path_length\":%u,\"chains\":{%s},\"stop\":{\"mutations_per_pixel\":%g}}",
             c->scene, entry->width / c->shrink, entry->height / c->shrink, c->algorithm, entry->max_path_length,
             chains, c->mutations);
    if (job_parse(&job, text, strlen(text), "job", &fault))
        fail_msg("%s", fault.text);
    return job;
}

/* The same case with `times` the mutations. */
static void case_render(image_t *images, const peer_case_t *c, const peer_loaded_t *loaded, double times,
                        unsigned seeds, uint64_t first)
{
    fault_t fault = {0};
    peer_case_t longer = *c;
    longer.mutations *= times;
    const job_t job = case_job(&longer, loaded->entry);
    if (parallel_seeds(images, &loaded->scene, &job, first, seeds, THREADS, &fault))
        fail_msg("%s, %s: %s", c->scene, c->algorithm, fault.text);
}

static void images_clear(image_t *images, unsigned count)
{
    for (unsigned i = 0; i < count; i++)
        image_clear(&images[i]);
}

/* Reference `index` at the renders' size. */
static image_t reference_small(const peer_scene_t *entry, int index, uint32_t shrink)
{
    fault_t fault = {0};
    image_t whole, small = {0};
    if (peer_reference_read(&whole, entry, index, &fault) || regions_shrink(&small, &whole, shrink, &fault))
        fail_msg("%s: %s", entry->name, fault.text);
    image_clear(&whole);
    return small;
}

/* ---- agreement ---- */

static void check_agreement(const peer_case_t *c, const image_t *images, const image_t halves[2])
{
    char title[128];
    regions_t ours, reference;
    int where = 0;
    regions_of_seeds(&ours, images, SEEDS);
    regions_of_halves(&reference, &halves[0], &halves[1]);
    const double worst = regions_worst(&ours, &reference, &where), most = alarm_score(SEEDS);
    const double ratio = ours.mean[REGIONS_WHOLE] / reference.mean[REGIONS_WHOLE];
    const double error =
        sqrt(ours.variance[REGIONS_WHOLE] + reference.variance[REGIONS_WHOLE]) / reference.mean[REGIONS_WHOLE];
    print_message("%s, %s: brightness %.4f +- %.4f, largest score of a region %.2f of %.2f\n", c->scene,
                  c->algorithm, ratio, error, worst, most);
    snprintf(title, sizeof title, "%s, %s", c->scene, c->algorithm);
    if (!(worst <= most)) {
        regions_print(title, &ours, &reference);
        fail_msg("%s: region %d (block %d, %d; %d is the image): %g, expected %g: score %.2f", title, where,
                 where % REGIONS_GRID, where / REGIONS_GRID, REGIONS_WHOLE, ours.mean[where], reference.mean[where],
                 worst);
    }
    if (c->exact && !(error <= 0.002 && fabs(ratio - 1) <= 0.01))
        fail_msg("%s: brightness %.4f +- %.4f, expected 1 within 1 %%, and known to 0.2 %%", title, ratio, error);
}

static double error_of(const image_t *image, const image_t halves[2], bool trimmed)
{
    static compare_result_t result;
    fault_t fault = {0};
    if (compare_images(&result, image, &halves[0], &halves[1], NULL, &fault))
        fail_msg("%s", fault.text);
    return trimmed ? result.relmse_trimmed : result.relmse;
}

/* The error of the seeds' mean goes to nothing: no pixel has a bias beyond what its noise explains. One-sided. */
static void check_no_floor(const peer_case_t *c, const image_t *images, const image_t halves[2])
{
    double error, single = 0;
    const double floor = regions_floor(images, SEEDS, halves, &error);
    const double most = gsl_cdf_tdist_Qinv(1e-6 / COMPARISONS, SEEDS * (SEEDS - 1) / 2 - 1);
    for (unsigned i = 0; i < SEEDS; i++)
        single += error_of(&images[i], halves, false) / SEEDS;
    print_message("%s, %s: relMSE of a seed %.4g, of that does not average out %.2g +- %.2g\n", c->scene,
                  c->algorithm, single, floor, error);
    if (!(floor <= most * error))
        fail_msg("%s, %s: relMSE has a floor of %g +- %g", c->scene, c->algorithm, floor, error);
}

/* ---- the error falls as one over time ---- */

static double mean_log_error(const image_t *images, unsigned count, const image_t halves[2], double *sum2)
{
    double sum = 0;
    *sum2 = 0;
    for (unsigned i = 0; i < count; i++) {
        const double value = log(error_of(&images[i], halves, true));
        sum += value;
        *sum2 += value * value;
    }
    *sum2 -= sum * sum / count;
    return sum / count;
}

/* Renders of 4 N mutations have a quarter of the relMSE of the case's own. Logarithms of the trimmed figure: their
 * spread is the same for both, and pooled. */
static void check_rate(const peer_case_t *c, const peer_loaded_t *loaded, const image_t *few,
                       const image_t halves[2])
{
    image_t many[LONG_SEEDS];
    double few2, many2;
    case_render(many, c, loaded, 4, LONG_SEEDS, 201);
    const double gain =
        mean_log_error(few, SEEDS, halves, &few2) - mean_log_error(many, LONG_SEEDS, halves, &many2);
    const double degrees = SEEDS + LONG_SEEDS - 2;
    const double error = sqrt((few2 + many2) / degrees * (1. / SEEDS + 1. / LONG_SEEDS));
    const double most = gsl_cdf_tdist_Qinv(0.5e-6 / 2, degrees);
    print_message("%s, %s: relMSE falls by %.3g with 4 times the mutations, expected 4 within a factor of %.3g\n",
                  c->scene, c->algorithm, exp(gain), exp(most * error));
    if (!(fabs(gain - log(4)) <= most * error))
        fail_msg("%s, %s: relMSE falls by %g with 4 times the mutations; expected %g to %g", c->scene, c->algorithm,
                 exp(gain), 4 * exp(-most * error), 4 * exp(most * error));
    images_clear(many, LONG_SEEDS);
}

/* ---- cases ---- */

static void check_case(const peer_case_t *c)
{
    image_t images[SEEDS];
    peer_loaded_t *loaded = scene_load(c->scene);
    image_t halves[2] = {reference_small(loaded->entry, 0, c->shrink),
                         reference_small(loaded->entry, 1, c->shrink)};
    case_render(images, c, loaded, 1, SEEDS, 1);
    check_agreement(c, images, halves);
    check_no_floor(c, images, halves);
    if (c->rate)
        check_rate(c, loaded, images, halves);
    images_clear(images, SEEDS);
    images_clear(halves, 2);
    peer_scene_unload(&loaded);
}

/* pt finds what bdpt finds wherever a light is large enough to be hit; not the light in water-box within this time.
 */
static void check_cases(const peer_case_t *cases, size_t count)
{
    for (size_t i = 0; i < count; i++)
        check_case(&cases[i]);
}

static void cornell_box_agrees(void **state)
{
    (void)state;
    static const peer_case_t cases[] = {{"cornell-320", "pt", 4, 2, FEW, true, false},
                                        {"cornell-320", "bdpt", 4, 1, FEW, true, false},
                                        {"cornell-320", "mmlt", 4, 14, 0, true, true}};
    check_cases(cases, 3);
}

static void ring_box_agrees(void **state)
{
    (void)state;
    static const peer_case_t cases[] = {{"ring-box", "pt", 4, 1, FEW, false, false},
                                        {"ring-box", "bdpt", 4, 1, FEW, false, false},
                                        {"ring-box", "mmlt", 4, 14, 0, false, true}};
    check_cases(cases, 3);
}

static void two_rooms_agree(void **state)
{
    (void)state;
    static const peer_case_t cases[] = {{"two-rooms", "pt", 5, 1, FEW, false, false},
                                        {"two-rooms", "bdpt", 5, 1, FEW, false, false},
                                        {"two-rooms", "mmlt", 5, 18, 0, false, false}};
    check_cases(cases, 3);
}

static void water_box_agrees(void **state)
{
    (void)state;
    static const peer_case_t cases[] = {{"water-box", "bdpt", 4, 1, FEW, false, false},
                                        {"water-box", "mmlt", 4, 27, 0, false, false}};
    check_cases(cases, 2);
}

/* ---- references that another colour model made ---- */

/* Reads the reference at the renders' size; a picture with a file name of its own (any size that is a multiple). */
static image_t reference_single(const peer_case_t *c, const peer_scene_t *entry, const char *file)
{
    char path[4096];
    fault_t fault = {0};
    image_t whole, small = {0};
    if (!file)
        return reference_small(entry, 0, c->shrink);
    snprintf(path, sizeof path, "%s/scenes/%s", peer_shared_folder(), file);
    if (image_file_read(&whole, path, &fault) ||
        regions_shrink(&small, &whole, whole.width / (entry->width / c->shrink), &fault))
        fail_msg("%s", fault.text);
    image_clear(&whole);
    return small;
}

/* The reference's noise is not known: it is left out, and belongs to the tolerance. */
static void check_within(const peer_case_t *c, const char *file, double tolerance, double tolerance_block)
{
    image_t images[SEEDS_WITHIN];
    char title[128];
    regions_t ours, reference;
    peer_loaded_t *loaded = scene_load(c->scene);
    image_t single = reference_single(c, loaded->entry, file);
    case_render(images, c, loaded, 1, SEEDS_WITHIN, 1);
    regions_of_seeds(&ours, images, SEEDS_WITHIN);
    regions_of_halves(&reference, &single, &single);
    const double most = alarm_score(SEEDS_WITHIN), whole = ours.mean[REGIONS_WHOLE] / reference.mean[REGIONS_WHOLE];
    double farthest = 0;
    int where = -1;
    snprintf(title, sizeof title, "%s, %s", c->scene, c->algorithm);
    for (int r = 0; r < REGIONS; r++) {
        const double off = fabs(ours.mean[r] / reference.mean[r] - 1);
        const double noise = most * sqrt(ours.variance[r]) / reference.mean[r];
        if (r != REGIONS_WHOLE)
            farthest = fmax(farthest, off);
        if (!(off <= (r == REGIONS_WHOLE ? tolerance : tolerance_block) + noise))
            where = r;
    }
    print_message("%s: brightness %.4f +- %.4f of a picture's that should be within %g %%, blocks within %.3f\n",
                  title, whole, sqrt(ours.variance[REGIONS_WHOLE]) / reference.mean[REGIONS_WHOLE], 100 * tolerance,
                  farthest);
    if (where >= 0) {
        regions_print(title, &ours, &reference);
        fail_msg("%s: region %d is %g, expected %g", title, where, ours.mean[where], reference.mean[where]);
    }
    images_clear(images, SEEDS_WITHIN);
    image_clear(&single);
    peer_scene_unload(&loaded);
}

static void spectral_references_agree_within_percents(void **state)
{
    (void)state;
    check_within(&(peer_case_t){"veach-bidir", "bdpt", 2, 1, FEW, false, false}, NULL, 0.04, 0.04);
    check_within(&(peer_case_t){"veach-bidir", "mmlt", 2, 14, 0, false, false}, NULL, 0.04, 0.04);
    check_within(&(peer_case_t){"veach-mis", "bdpt", 1, 1, FEW, false, false}, NULL, 0.04, 0.04);
    check_within(&(peer_case_t){"veach-mis", "mmlt", 1, 9, 0, false, false}, NULL, 0.04, 0.04);
}

/* The scenes' authors' own pictures: linear RGB, of 1024 x 1024 pixels with a wider filter. */
static void authors_picture_agrees(void **state)
{
    (void)state;
    check_within(&(peer_case_t){"cornell-box", "bdpt", 2, 3, FEW, false, false}, "cornell-box/TungstenRender.exr",
                 0.003, 0.01);
}

/* ---- all of them ---- */

static void check_reads_and_renders(const peer_scene_t *entry)
{
    fault_t fault = {0};
    parallel_run_t run;
    const float *planes[3];
    const peer_case_t c = {entry->name, "mmlt", 2, 8, 0, false, false};
    peer_loaded_t *loaded = scene_load(entry->name);
    for (size_t i = 0; i < import_notes_count(loaded->notes); i++)
        if (!peer_note_explained(loaded, i))
            fail_msg("%s: a note that nothing explains: %s", entry->name, import_notes_text(loaded->notes, i));
    const job_t job = case_job(&c, entry);
    if (parallel_render(&run, &loaded->scene, &job, THREADS, &fault) || image_find_rgb(&run.image, planes, &fault))
        fail_msg("%s: %s", entry->name, fault.text);
    const size_t pixels = (size_t)run.image.width * run.image.height;
    double sum = 0;
    for (int k = 0; k < 3; k++)
        for (size_t p = 0; p < pixels; p++)
            sum += planes[k][p];
    if (!(sum > 0 && sum < INFINITY))
        fail_msg("%s: the sum of the pixels is %g", entry->name, sum);
    const json_t *rejected = json_get(run.report, "rejected");
    for (const json_t *m = json_first(rejected); m; m = json_next(m))
        if (!(json_number(m) == 0))
            fail_msg("%s: %g contributions refused: %s", entry->name, json_number(m), json_name(m));
    parallel_clear(&run);
    peer_scene_unload(&loaded);
}

static void every_shared_scene_is_read_and_rendered(void **state)
{
    (void)state;
    for (size_t i = 0; peer_scene_at(i); i++)
        if (peer_scene_at(i)->file)
            check_reads_and_renders(peer_scene_at(i));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_shared_scene_is_read_and_rendered),
        cmocka_unit_test(authors_picture_agrees),
        cmocka_unit_test(spectral_references_agree_within_percents),
        cmocka_unit_test(cornell_box_agrees),
        cmocka_unit_test(ring_box_agrees),
        cmocka_unit_test(two_rooms_agree),
        cmocka_unit_test(water_box_agrees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
