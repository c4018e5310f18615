/* How work is divided where it is little: samples beside chains come in whole passes over the image, and the chains
 * keep some work whatever is rounded. Were none left, what lies above the caps would be missing from the image. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "plan/plan_fixture.h"
#include "plan/plan_state.h"

/* What a short render made: samples and mutations a pixel. */
typedef struct made {
    bool splits;
    double share, samples, mutations; /* share: of the samples */
    double error;                     /* estimated */
} made_t;

/* Fails where a length with a share had no chains, or one without had some. */
static made_t render(int mutations, double gain)
{
    small_scene_t small;
    char text[256];
    snprintf(text, sizeof text,
             "{'scene':'x','film':{'width':24,'height':24},'algorithm':'rjmlt','max_path_length':4,'seed':'31',"
             "'stop':{'mutations_per_pixel':%d},'chains':{'split':0.35,'split_gain':%g}}",
             mutations, gain);
    small_scene_diffuse(&small);
    const job_t job = plan_fixture_job(text);
    plan_worker_t worker;
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    plan_fixture_run(plan, &worker, 0.1);
    made_t made = {.splits = plan_splits(plan),
                   .share = plan->lengths[0].share,
                   .error = plan->error,
                   .samples = (double)plan->lengths[0].merged / (double)plan->pixels};
    for (uint32_t k = 1; k <= 4; k++) {
        const plan_length_t *length = &plan->lengths[k];
        if ((length->share > 0) != (length->merged > 0))
            fail_msg("%d mutations a pixel: length %u has a share of %g and %llu mutations", mutations, k,
                     length->share, (unsigned long long)length->merged);
        made.mutations += (double)length->merged / (double)plan->pixels;
    }
    print_message("%d mutations a pixel: samples' share %.2f, passes %g, chains %g a pixel\n", mutations,
                  made.share, made.samples, made.mutations);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    small_scene_clear(&small);
    return made;
}

/* 20 is the least with samples beside chains: nine tenths of it, rounded to passes of ten, were all. */
static void chains_keep_work_beside_samples(void **state)
{
    (void)state;
    for (int mutations = 20; mutations <= 52; mutations += 3) {
        const made_t made = render(mutations, 1);
        assert_true(made.splits && made.samples >= 1 && made.mutations > 0);
    }
}

/* With work for one pass it is all samples' or all chains', by what the pilot promises; with less it is chains'. */
static void where_there_is_room_for_one_only_the_pilot_chooses(void **state)
{
    (void)state;
    for (int mutations = 10; mutations < 20; mutations += 3) {
        const made_t chains = render(mutations, 1), samples = render(mutations, 1e6);
        assert_true(chains.splits && chains.share == 0 && chains.samples == 0 &&
                    fabs(chains.mutations - mutations) < 1e-9);
        assert_true(chains.error > 0 && samples.error > 0); /* a single pass has a stand-in */
        assert_true(samples.share == 1 && samples.samples == (mutations < 15 ? 1 : 2) && samples.mutations == 0);
    }
    for (int mutations = 3; mutations < 10; mutations += 3) {
        const made_t made = render(mutations, 1e6);
        assert_true(!made.splits && made.samples == 0 && fabs(made.mutations - mutations) < 1e-9);
    }
}

/* Features are a grid of rays in each pixel, or a single ray where they would take half of a worker's time. */
static void features_of_a_large_image_take_little_of_a_short_time(void **state)
{
    (void)state;
    static const struct {
        const char *stop;
        uint32_t side;
    } cases[] = {{"'mutations_per_pixel':3", 2}, {"'seconds':1", 1}, {"'seconds':2", 2}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        small_scene_t small;
        char text[192];
        snprintf(text, sizeof text,
                 "{'scene':'x','film':{'width':640,'height':480},'max_path_length':4,'stop':{%s}}", cases[i].stop);
        small_scene_diffuse(&small);
        const job_t job = plan_fixture_job(text);
        plan_t *plan = plan_fixture_new(&job, &small.scene);
        uint64_t unit, rows = 0;
        const work_record_t *record;
        while (plan_next(plan, &unit, &record))
            if (record->kind == WORK_FEATURES) {
                assert_int_equal(record->side, cases[i].side);
                rows += record->count;
            }
        assert_true(rows > 0 && rows <= 480); /* later ones wait for the pilot */
        plan_destroy(&plan);
        small_scene_clear(&small);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chains_keep_work_beside_samples),
        cmocka_unit_test(features_of_a_large_image_take_little_of_a_short_time),
        cmocka_unit_test(where_there_is_room_for_one_only_the_pilot_chooses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
