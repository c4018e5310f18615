/* Algorithms against each other, by t scores over seeds: pt and every chain algorithm against bdpt, on every scene
 * of the project, with the moves that a job has by default.
 *
 * Power: each comparison prints what it would see in half of all runs. Of the image that is 1 to 5 %, of most
 * regions a quarter to a half of their light, for auto and pt a tenth to a quarter. The score that is too large
 * falls with the number of seeds, 9.96 with 24 and 8.26 with 36: so many see as much with 28 mutations a pixel each
 * as the former with 60. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "agreement.h"
#include "load.h"
#include "scene_list.h"

static const char *const chains[] = {"mmlt",      "rjmlt",      "cmlt",   "cmlt-rex",
                                     "cmlt-ipsm", "pssmlt-mix", "pssmlt", "auto"};
enum { SEEDS = 36, LENGTH = 6, CHAINS = sizeof chains / sizeof *chains };

/* False alarms: 1e-6 in a whole run of all scenes, 17 regions, two sides. */
static const double alarm = 1e-6 / (SCENES * (1 + CHAINS) * AGREEMENT_REGIONS * 2);

static void check(const char *name)
{
    const scene_t *scene = load_scene(name);
    pilots_t *pilots = pilots_new();
    regions_t bdpt, other;
    agreement_run(scene, "bdpt", AGREEMENT_SAMPLES, LENGTH, 8, SEEDS, NULL, &bdpt);
    agreement_run(scene, "pt", AGREEMENT_SAMPLES, LENGTH, 24, SEEDS, NULL, &other);
    agreement_compare(name, "pt against bdpt", &other, &bdpt, alarm);
    for (int i = 0; i < CHAINS; i++) {
        agreement_run(scene, chains[i], "", LENGTH, agreement_work(chains[i], LENGTH, 28), SEEDS, pilots, &other);
        agreement_compare(name, chains[i], &other, &bdpt, alarm);
    }
    pilots_destroy(&pilots);
    load_clear();
}

SCENE_LIST(SCENE_TEST)

int main(void)
{
    const struct CMUnitTest tests[] = {SCENE_LIST(SCENE_ENTRY)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
