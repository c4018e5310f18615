/* Moves against independent samples, without large steps to hide what is wrong: of a chain's mutations, some 90 to
 * 1500 by length, one in a hundred is large, so that what a wrong ratio does to its law has time to show. By t
 * scores over seeds against bdpt.
 *
 * Power: each comparison prints what it would see in half of all runs. Of the image that is 1.4 to 6 %, where
 * chains go by importance up to 30 %; of most regions the whole of their light, for Gaussian steps a third to two
 * thirds, beside samples (split) an eighth to a third. Twice bdpt's samples would only sharpen the last: 0.12 for
 * 0.13, 0.20 for 0.25. Each variant is compared in every other scene: a fault that shows in one scene alone, and
 * not with the moves that test_algorithms.c has there by default, is missed where it is one of the others. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "agreement.h"
#include "load.h"
#include "scene_list.h"

#define CHAINS(more) ",\"chains\":{\"large_step\":0.01,\"length\":4096" more "}"

typedef struct variant {
    const char *name, *algorithm, *more;
} variant_t;

static const variant_t variants[] = {
    {"mmlt", "mmlt", CHAINS(",\"technique_step\":0.2")},
    {"rjmlt", "rjmlt", CHAINS(",\"jump_step\":0.2")},
    {"cmlt", "cmlt", CHAINS(",\"jump_step\":0.2")},
    {"cmlt-rex", "cmlt-rex", CHAINS(",\"jump_step\":0.2")},
    {"cmlt-ipsm", "cmlt-ipsm", CHAINS("")},
    {"pssmlt-mix", "pssmlt-mix", CHAINS("")},
    {"pssmlt", "pssmlt", CHAINS("")},
    {"partial steps", "rjmlt", CHAINS(",\"jump_step\":0.2,\"partial_step\":0.6")},
    {"delayed", "rjmlt", CHAINS(",\"jump_step\":0.1,\"partial_step\":0.3,\"failures\":\"delayed\"")},
    {"delayed, gaussian", "mmlt",
     CHAINS(",\"kernel\":\"gaussian\",\"step_max\":0.05,\"technique_step\":0.1,\"failures\":\"delayed\"")},
    {"equalize", "rjmlt", CHAINS(",\"jump_step\":0.2,\"equalize\":1")},
    {"split", "rjmlt", CHAINS(",\"jump_step\":0.2,\"equalize\":1,\"split\":10")},
    {"split, exchange", "cmlt-rex", CHAINS(",\"jump_step\":0.2,\"split\":30")},
    {"equalize, all lengths", "pssmlt", CHAINS(",\"equalize\":0.7")},
    {"auxiliary", "cmlt", CHAINS(",\"jump_step\":0.1,\"auxiliary_step\":0.2")},
};
enum { SEEDS = 20, LENGTH = 5, VARIANTS = sizeof variants / sizeof *variants };

enum { COMPARED = (SCENES * VARIANTS + 1) / 2 };

/* False alarms: 1e-6 in a whole run of all scenes, 17 regions, two sides. */
static const double alarm = 1e-6 / (COMPARED * AGREEMENT_REGIONS * 2);

/* Scenes take turns: of those that follow each other in the list one has the variants of even number, one those of
 * odd. */
static bool is_compared(int variant, const char *scene)
{
    static const char *const scenes[] = {SCENE_LIST(SCENE_NAME)};
    int place = 0;
    while (strcmp(scenes[place], scene) != 0)
        place++;
    return (variant + place) % 2 == 0;
}

static void check(const char *name)
{
    const scene_t *scene = load_scene(name);
    pilots_t *pilots = pilots_new();
    regions_t bdpt, other;
    agreement_run(scene, "bdpt", AGREEMENT_SAMPLES, LENGTH, 16, SEEDS, NULL, &bdpt);
    for (int i = 0; i < VARIANTS; i++) {
        const variant_t *v = &variants[i];
        if (!is_compared(i, name))
            continue;
        agreement_run(scene, v->algorithm, v->more, LENGTH, agreement_work(v->algorithm, LENGTH, 80), SEEDS, pilots,
                      &other);
        agreement_compare(name, variants[i].name, &other, &bdpt, alarm);
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
