/* Algorithms against each other, by t scores over seeds: pt and every chain algorithm against bdpt, on every scene
 * of the project, with the moves that a job has by default. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "agreement.h"
#include "load.h"
#include "scene_list.h"

static const char *const chains[] = {"mmlt",      "rjmlt",      "cmlt",   "cmlt-rex",
                                     "cmlt-ipsm", "pssmlt-mix", "pssmlt", "auto"};
enum { SEEDS = 24, LENGTH = 6, CHAINS = sizeof chains / sizeof *chains };

/* False alarms: 1e-6 in a whole run of all scenes, 17 regions, two sides. */
static const double alarm = 1e-6 / (SCENES * (1 + CHAINS) * AGREEMENT_REGIONS * 2);

static void check(const char *name)
{
    const scene_t *scene = load_scene(name);
    regions_t bdpt, other;
    agreement_run(scene, "bdpt", "", LENGTH, 24, SEEDS, &bdpt);
    agreement_run(scene, "pt", "", LENGTH, 64, SEEDS, &other);
    agreement_compare(name, "pt against bdpt", &other, &bdpt, alarm);
    for (int i = 0; i < CHAINS; i++) {
        agreement_run(scene, chains[i], "", LENGTH, agreement_work(chains[i], LENGTH, 60), SEEDS, &other);
        agreement_compare(name, chains[i], &other, &bdpt, alarm);
    }
    load_clear();
}

SCENE_LIST(SCENE_TEST)

int main(void)
{
    const struct CMUnitTest tests[] = {SCENE_LIST(SCENE_ENTRY)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
