#include "stats/law.h"

#include <math.h>
#include <stdlib.h>

/* The prior of p about 1/2, and of a in parts of the last error. */
static const double LAW_POWER = 0.5, LAW_POWER_SPREAD = 0.025, LAW_POWER_STEP = 0.01, LAW_FLOOR_SPREAD = 0.01,
                    LAW_FLOOR_MOST = 0.8;
/* No estimate is surer than this. Of estimates that call themselves unreliable half are off by a factor of more
 * than 1.5 (docs/accuracy.md): were logarithms normal, by log 1.5 / 0.674 = 0.6, half of that in the root. */
static const double LAW_NOISE_LEAST = 0.01, LAW_NOISE_UNKNOWN = 0.3;

/* The relative standard error of an error is half that of its square. */
static double law_noise(const history_point_t *point)
{
    const double noise = 0.5 * point->spread;
    return isfinite(noise) ? fmax(noise, LAW_NOISE_LEAST) : LAW_NOISE_UNKNOWN;
}

/* A law with c = 1 but for the scale: t^-p and the floor beside it, squared, times t^2: what the series' sums of
 * squares grow as. */
static double law_sum(double floor, double p, double t)
{
    const double error = floor + pow(t, -p);
    return error * error * t * t;
}

/* Points that are far less sure than the last, or do not know how sure they are, are left out beside it: what they
 * are off by, all in the same way, would be taken for a law. */
static bool law_counts(const history_t *history, uint32_t count, uint32_t i)
{
    const double last = history->points[count - 1].spread;
    return !isfinite(last) || history->points[i].spread <= 2 * last;
}

/* The best c for p and a floor that is the part `share` of the last error; minus the logarithm of how likely the
 * series is with it. relMSE is a mean of squares over t^2: what is added between two points is independent of what
 * was before, its relative variance in proportion to 1 / (time between them). */
static double law_try(const law_t *law, const history_t *history, uint32_t count, double share, law_fit_t *fit)
{
    const double end = history->points[count - 1].cpu_seconds - law->pilot,
                 floor = share / (1 - share) * pow(end, -fit->p);
    double before = 0, sum = 0, wanted = 0, weights = 0, mean = 0, squares = 0;
    for (uint32_t i = 0; i < count; i++) {
        const double t = history->points[i].cpu_seconds - law->pilot;
        if (!(t > before) || !law_counts(history, count, i))
            continue;
        const double weight = (t - before) / end, all = history->points[i].outlook * t * t,
                     of_law = law_sum(floor, fit->p, t), ratio = (all - sum) / (of_law - wanted), d = ratio - mean;
        before = t;
        sum = all;
        wanted = of_law;
        weights += weight;
        mean += weight / weights * d;
        squares += weight * d * (ratio - mean);
    }
    if (!(mean > 0))
        return INFINITY;
    fit->c = sqrt(mean);
    fit->a = fit->c * floor;
    const double z = (fit->p - LAW_POWER) / LAW_POWER_SPREAD;
    return 0.5 * squares / (4 * law->noise * law->noise * mean * mean) + 0.5 * z * z + share / LAW_FLOOR_SPREAD;
}

bool law_fit(law_t *law, const history_t *history, uint32_t count, double pilot)
{
    *law = (law_t){.pilot = pilot};
    if (count == 0 || !(history->points[count - 1].cpu_seconds > pilot))
        return false;
    double costs[LAW_FITS], least = INFINITY, sum = 0;
    law->noise = law_noise(&history->points[count - 1]);
    for (int i = 0; i < LAW_FITS; i++) {
        law_fit_t *fit = &law->fits[i];
        fit->p = LAW_POWER + LAW_POWER_STEP * (i / LAW_FLOORS - LAW_POWERS / 2);
        costs[i] = law_try(law, history, count, LAW_FLOOR_MOST * (i % LAW_FLOORS) / (LAW_FLOORS - 1), fit);
        if (costs[i] < least) {
            least = costs[i];
            law->a = fit->a;
            law->c = fit->c;
            law->p = fit->p;
        }
    }
    if (!(least < INFINITY))
        return false;
    for (int i = 0; i < LAW_FITS; i++)
        sum += law->fits[i].weight = exp(least - costs[i]);
    for (int i = 0; i < LAW_FITS; i++)
        law->fits[i].weight /= sum;
    return true;
}

typedef struct law_draw {
    double time, weight;
} law_draw_t;

static int law_compare(const void *a, const void *b)
{
    const double x = ((const law_draw_t *)a)->time, y = ((const law_draw_t *)b)->time;
    return x < y ? -1 : x > y;
}

/* c is as unsure as the series' last error: three nodes of Gauss and Hermite's rule. */
enum { LAW_NODES = 3 };
static const double law_nodes[LAW_NODES] = {-1.7320508075688772, 0, 1.7320508075688772},
                    law_node_weights[LAW_NODES] = {1.0 / 6, 2.0 / 3, 1.0 / 6};

/* Where the weights below, and half of the one at hand, reach `part`: between two times in proportion. */
static double law_quantile(const law_draw_t *times, int count, double part)
{
    double below = 0, at = 0, time = times[0].time;
    for (int i = 0; i < count; i++) {
        const double middle = below + 0.5 * times[i].weight;
        if (middle >= part)
            return i > 0 && isfinite(times[i].time) && middle > at
                       ? time + (times[i].time - time) * (part - at) / (middle - at)
                       : times[i].time;
        below += times[i].weight;
        at = middle;
        time = times[i].time;
    }
    return time;
}

law_time_t law_time(const law_t *law, double error)
{
    law_draw_t times[LAW_FITS * LAW_NODES];
    for (int i = 0; i < LAW_FITS * LAW_NODES; i++) {
        const law_fit_t *fit = &law->fits[i / LAW_NODES];
        const double c = fit->c * exp(law_nodes[i % LAW_NODES] * law->noise);
        times[i].time = error > fit->a ? law->pilot + pow(c / (error - fit->a), 1 / fit->p) : INFINITY;
        times[i].weight = fit->weight * law_node_weights[i % LAW_NODES];
    }
    qsort(times, LAW_FITS * LAW_NODES, sizeof *times, law_compare);
    return (law_time_t){law_quantile(times, LAW_FITS * LAW_NODES, 0.5),
                        law_quantile(times, LAW_FITS * LAW_NODES, 0.025),
                        law_quantile(times, LAW_FITS * LAW_NODES, 0.975)};
}
