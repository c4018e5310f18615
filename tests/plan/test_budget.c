/* How work is divided where it is little: samples beside chains come in whole passes over the image, and the chains
 * keep some work whatever is rounded. Were none left, what lies above the caps would be missing from the image. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "plan/plan_fixture.h"
#include "plan/plan_state.h"

static void check(int mutations)
{
    small_scene_t small;
    char text[256];
    snprintf(text, sizeof text,
             "{'scene':'x','film':{'width':24,'height':24},'algorithm':'rjmlt','max_path_length':4,'seed':'31',"
             "'stop':{'mutations_per_pixel':%d},'chains':{'split':1}}",
             mutations);
    small_scene_diffuse(&small);
    const job_t job = plan_fixture_job(text);
    plan_worker_t worker;
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    plan_fixture_run(plan, &worker, 0.1);
    double chains = 0;
    assert_true(plan_splits(plan) && plan->lengths[0].merged > 0);
    for (uint32_t k = 1; k <= 4; k++) {
        const plan_length_t *length = &plan->lengths[k];
        if ((length->share > 0) != (length->merged > 0))
            fail_msg("%d mutations a pixel: length %u has a share of %g and %llu mutations", mutations, k,
                     length->share, (unsigned long long)length->merged);
        chains += (double)length->merged;
    }
    print_message("%d mutations a pixel: samples' share %.2f, passes %g, chains %g a pixel\n", mutations,
                  plan->lengths[0].share, (double)plan->lengths[0].merged / (double)plan->pixels,
                  chains / (double)plan->pixels);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    small_scene_clear(&small);
}

/* 40 is the least with samples beside chains: nine tenths of it, rounded to passes of ten, were all. */
static void chains_keep_work_beside_samples(void **state)
{
    (void)state;
    for (int mutations = 40; mutations <= 52; mutations += 3)
        check(mutations);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chains_keep_work_beside_samples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
