/* agree.c: every algorithm against bdpt. */
#include "hard.h"

#include <math.h>

#include <gsl/gsl_cdf.h>

enum { SEEDS = 20, REGIONS = 5 };

/* What is compared with bdpt, and how much of a job's work each gets: a sample of bdpt joins the square of what one
 * of pt does, a mutation makes a path of one length. Few candidates for seeds: errors are measured, so t scores
 * hold all the same. */
static const struct {
    const char *algorithm;
    double share;
} compared[] = {{"pt", 2},       {"mmlt", 16},     {"rjmlt", 4},      {"cmlt", 4},
                {"cmlt-rex", 4}, {"cmlt-ipsm", 4}, {"pssmlt-mix", 4}, {"pssmlt", 4}};
enum { COMPARED = sizeof compared / sizeof *compared, PILOT = 512 };
static const double share_of_bdpt = 0.5;

/* False alarms: 4e-6 in a run of at most 40 scenes, 8 comparisons, 5 regions, two sides. */
static const double alarm = 4e-6 / (40 * COMPARED * REGIONS * 2);

typedef struct regions {
    double sum[REGIONS], sum2[REGIONS];
} regions_t;

static void add_image(regions_t *regions, const image_t *image, uint32_t side)
{
    double means[REGIONS] = {0};
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++) {
            const uint32_t p = y * side + x;
            const double v =
                rgb_luminance(rgb((double)image_channel(image, 0)[p], (double)image_channel(image, 1)[p],
                                  (double)image_channel(image, 2)[p]));
            means[2 * (2 * y / side) + 2 * x / side] += v;
            means[REGIONS - 1] += v;
        }
    for (int i = 0; i < REGIONS; i++) {
        regions->sum[i] += means[i];
        regions->sum2[i] += means[i] * means[i];
    }
}

static void run_seeds(const char *name, const scene_t *scene, hard_job_t job, regions_t *regions)
{
    *regions = (regions_t){0};
    for (int seed = 1; seed <= SEEDS; seed++) {
        job.seed = (uint64_t)seed;
        render_t render;
        hard_render(&render, name, scene, &job);
        add_image(regions, &render.image, job.side);
        render_clear(&render);
    }
}

static void compare(const char *name, const char *algorithm, const regions_t *a, const regions_t *b)
{
    const double most = gsl_cdf_tdist_Qinv(alarm, SEEDS - 1); /* Welch's degrees are at least so many */
    double worst = 0, whole = 0, error = 0;
    for (int i = 0; i < REGIONS; i++) {
        const double ma = a->sum[i] / SEEDS, mb = b->sum[i] / SEEDS;
        const double va = fmax(0, (a->sum2[i] / SEEDS - ma * ma) / (SEEDS - 1)),
                     vb = fmax(0, (b->sum2[i] / SEEDS - mb * mb) / (SEEDS - 1));
        const double t = (ma - mb) / sqrt(va + vb + 1e-14 * mb * mb); /* images are in single precision */
        worst = fmax(worst, fabs(t));
        whole = ma / mb;
        error = sqrt(va + vb) / mb;
        if (!(fabs(t) <= most))
            fail_msg("%s, %s against bdpt: region %d is %g +- %g, expected %g +- %g: t = %.1f", name, algorithm, i,
                     ma, sqrt(va), mb, sqrt(vb), t);
    }
    hard_record(HARD_AGREE, REGIONS, worst);
    print_message("%s, %s against bdpt: largest |t| %.2f of %.2f, brightness %.4f +- %.4f\n", name, algorithm,
                  worst, most, whole, error);
}

static void run_algorithm(const char *name, const scene_t *scene, hard_job_t job, const char *algorithm,
                          double share, regions_t *regions)
{
    job.algorithm = algorithm;
    job.work *= share;
    run_seeds(name, scene, job, regions);
}

void hard_agree(const char *name, const scene_t *scene, hard_job_t job)
{
    regions_t expected, found;
    job.pilot = job.pilot ? job.pilot : PILOT;
    run_algorithm(name, scene, job, "bdpt", share_of_bdpt, &expected);
    for (int i = 0; i < COMPARED; i++) {
        run_algorithm(name, scene, job, compared[i].algorithm, compared[i].share, &found);
        compare(name, compared[i].algorithm, &found, &expected);
    }
}
