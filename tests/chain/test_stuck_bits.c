/* Looking for stuck chains leaves the image as it is, to the bit: renders in which no stay is called stuck, those
 * that the rule finds, and every stay that is long enough to be asked about. Where the job says how long chains
 * are: else they are shorter (tests/plan/test_shorten.c). The linker sends all calls of stuck_is to the
 * verdict here (--wrap). */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "chain/stuck.h"
#include "plan/plan_fixture.h"
#include "transport/load.h"

typedef enum verdict { NEVER, BY_RULE, ALWAYS, VERDICTS } verdict_t;

static verdict_t verdict;

bool __real_stuck_is(uint64_t stay, uint64_t accepted, uint64_t steps);
bool __wrap_stuck_is(uint64_t stay, uint64_t accepted, uint64_t steps);

bool __wrap_stuck_is(uint64_t stay, uint64_t accepted, uint64_t steps)
{
    return verdict == BY_RULE ? __real_stuck_is(stay, accepted, steps) : verdict == ALWAYS;
}

/* The image of a render with this verdict on its stays, and how many were called stuck. */
static double render(const char *text, image_t *image)
{
    const job_t job = plan_fixture_job(text);
    const scene_t *scene = load_scene("stuck");
    plan_worker_t worker;
    fault_t fault = {0};
    plan_worker_make(&worker, &job, scene);
    plan_t *plan = plan_fixture_new(&job, scene);
    plan_fixture_run(plan, &worker, 0.25);
    if (plan_image(plan, image, &fault))
        fail_msg("%s", fault.text);
    json_t *report = plan_report(plan);
    const double chains = json_number(json_get(json_get(report, "stuck"), "chains"));
    json_destroy(&report);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    load_clear();
    return chains;
}

static void bits_do_not_depend_on_what_is_found(void **state)
{
    (void)state;
    static const char *const algorithms[] = {"mmlt", "rjmlt", "cmlt", "pssmlt", "auto"};
    for (size_t a = 0; a < sizeof algorithms / sizeof *algorithms; a++) {
        char text[256];
        image_t images[VERDICTS];
        double chains[VERDICTS];
        snprintf(
            text, sizeof text,
            "{'scene':'x','algorithm':'%s','max_path_length':5,'seed':4,'chains':{'split_gain':1,'length':16384},"
            "'stop':{'mutations_per_pixel':100}}",
            algorithms[a]);
        for (int v = 0; v < VERDICTS; v++) {
            verdict = (verdict_t)v;
            chains[v] = render(text, &images[v]);
        }
        if (!(chains[NEVER] == 0 && chains[BY_RULE] <= chains[ALWAYS] && chains[ALWAYS] > 0))
            fail_msg("%s: %g, %g and %g stuck chains", algorithms[a], chains[NEVER], chains[BY_RULE],
                     chains[ALWAYS]);
        const size_t size = sizeof(float) * images[0].channel_count * images[0].width * images[0].height;
        for (int v = 1; v < VERDICTS; v++)
            assert_memory_equal(images[0].data, images[v].data, size);
        for (int v = 0; v < VERDICTS; v++)
            image_clear(&images[v]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(bits_do_not_depend_on_what_is_found)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
