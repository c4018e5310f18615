/* agreement.h: two ways of rendering a scene compared by t scores over seeds: mean luminances of 4 x 4 blocks of
 * the image and of the whole. */
#ifndef TESTS_TRANSPORT_AGREEMENT_H
#define TESTS_TRANSPORT_AGREEMENT_H

#include "pilots.h"
#include "scene/scene.h"

enum { AGREEMENT_SIDE = 24, AGREEMENT_BLOCKS = 4, AGREEMENT_REGIONS = AGREEMENT_BLOCKS * AGREEMENT_BLOCKS + 1 };

typedef struct regions {
    double sum[AGREEMENT_REGIONS], sum2[AGREEMENT_REGIONS];
    int seeds;
} regions_t;

/* `more` for pt and bdpt: of their pilot only the scale of the film's numbers is used, as a power of two, and the
 * usual one takes as long as eight samples a pixel. */
#define AGREEMENT_SAMPLES ",\"chains\":{\"pilot_samples\":512}"

/* Renders 24 x 24 pixels, `work` mutations or samples a pixel, paths of up to `length` segments. `more` is further
 * JSON of the job, beginning with a comma, or empty. `pilots` of the scene, or null. */
void agreement_run(const scene_t *scene, const char *algorithm, const char *more, uint32_t length, double work,
                   int seeds, pilots_t *pilots, regions_t *regions);

/* Mutations a pixel that are as many for each length as `work` of one length each: fewer, where each is of all. */
double agreement_work(const char *algorithm, uint32_t length, double work);

/* Fails the test where |t| of a region is so large that two right ways would exceed it with probability `alarm`. */
void agreement_compare(const char *scene, const char *name, const regions_t *a, const regions_t *b, double alarm);

#endif
