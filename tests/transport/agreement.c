#include "agreement.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <gsl/gsl_cdf.h>

#include "render.h"

static void add_image(regions_t *regions, const image_t *image)
{
    enum { SIDE = AGREEMENT_SIDE, BLOCKS = AGREEMENT_BLOCKS, REGIONS = AGREEMENT_REGIONS };
    double means[REGIONS] = {0};
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++) {
            const uint32_t p = y * SIDE + x;
            const double v = rgb_luminance(
                rgb(image_channel(image, 0)[p], image_channel(image, 1)[p], image_channel(image, 2)[p]));
            means[y * BLOCKS / SIDE * BLOCKS + x * BLOCKS / SIDE] += v;
            means[REGIONS - 1] += v;
        }
    for (int i = 0; i < REGIONS; i++) {
        regions->sum[i] += means[i];
        regions->sum2[i] += means[i] * means[i];
    }
}

void agreement_run(const scene_t *scene, const char *algorithm, const char *more, uint32_t length, double work,
                   int seeds, pilots_t *pilots, regions_t *regions)
{
    *regions = (regions_t){.seeds = seeds};
    for (int seed = 1; seed <= seeds; seed++) {
        char text[512];
        snprintf(
            text, sizeof text,
            "{\"scene\":\"x\",\"film\":{\"width\":%d,\"height\":%d},\"algorithm\":\"%s\",\"max_path_length\":%u,"
            "\"seed\":\"%d\",\"stop\":{\"mutations_per_pixel\":%g}%s}",
            AGREEMENT_SIDE, AGREEMENT_SIDE, algorithm, length, seed, work, more);
        render_t render;
        render_image_with(&render, scene, text, pilots);
        add_image(regions, &render.image);
        render_clear(&render);
    }
}

double agreement_work(const char *algorithm, uint32_t length, double work)
{
    return strcmp(algorithm, "pssmlt") == 0 ? work / length : work;
}

static double mean_of(const regions_t *r, int i, double *variance)
{
    const double mean = r->sum[i] / r->seeds;
    *variance = (r->sum2[i] / r->seeds - mean * mean) / (r->seeds - 1);
    return mean;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void agreement_compare(const char *scene, const char *name, const regions_t *a, const regions_t *b, double alarm)
{
    const int least = a->seeds < b->seeds ? a->seeds : b->seeds;
    /* Welch's degrees of freedom are at least so many: the safe side */
    const double most = gsl_cdf_tdist_Qinv(alarm, least - 1);
    double worst = 0, whole = 0, seen[AGREEMENT_REGIONS];
    for (int i = 0; i < AGREEMENT_REGIONS; i++) {
        double va, vb;
        const double ma = mean_of(a, i, &va), mb = mean_of(b, i, &vb), t = (ma - mb) / sqrt(va + vb);
        worst = math_max(worst, fabs(t));
        seen[i] = most * sqrt(va + vb) / mb;
        if (i == AGREEMENT_REGIONS - 1)
            whole = ma / mb;
        if (!(fabs(t) <= most))
            fail_msg("%s, %s: region %d is %g +- %g, expected %g +- %g: t = %.1f", scene, name, i, ma, sqrt(va), mb,
                     sqrt(vb), t);
    }
    qsort(seen, AGREEMENT_REGIONS - 1, sizeof *seen, compare_doubles);
    print_message("%s, %s: largest |t| %.2f of %.2f, brightness %.4f; seen in half of all runs: %.2g of the image, "
                  "%.2g of most regions\n",
                  scene, name, worst, most, whole, seen[AGREEMENT_REGIONS - 1],
                  seen[3 * (AGREEMENT_REGIONS - 1) / 4]);
}
