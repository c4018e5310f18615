/* sampler.h: independent samples of all path lengths at once: one walk from the camera, one from a light, all their
 * vertices joined in all allowed ways (Veach 1997, chapter 10). Connections to the light itself (s = 1) draw a
 * point of their own for every camera vertex; but for settings_joins_all, where a sample must be a function of the
 * walks' numbers alone, they take the light walk's first vertex.
 *
 * What a sample is for is said by the pointers that are set: an image, sums by length, the techniques of one
 * length.
 *
 * Weights. The balance heuristic takes a technique's second moment for its variance (Veach 1997, 9.2.2). Of light
 * that is seen directly or after one scattering, most of a camera walk's second moment is the mean squared: a
 * pixel's samples are alike, and as points of a net (net.h) they share out what differs. What light walks splat is
 * spread over the image, and nearly all of it is variance. So in the weights of the image's samples the technique t
 * = 1 of paths of k = 1 and 2 segments counts SAMPLER_DIRECT times,
 *
 *     w'_s = v_s w_s / sum_j v_j w_j,     v_k = SAMPLER_DIRECT, other v_s = 1,
 *
 * which sum to one as the w_s do (Grittmann, Georgiev, Krivanek, Slusallek 2019, "Variance-aware multiple
 * importance sampling", whose factors are measured pixel by pixel; here there is one for all). Longer paths gain
 * nothing by it (docs/transport.md). Chains and their seeds follow C, and have the balance heuristic's.
 */
#ifndef CHAIN_SAMPLER_H
#define CHAIN_SAMPLER_H

#include "chain/net.h"
#include "chain/unit.h"

/* What a sample adds to the image at one place. */
typedef struct sampler_splat {
    vec2_t raster;
    rgb_t value;
} sampler_splat_t;

/* What t = 1 counts in the weights of the image's samples, for paths of one and two segments. */
#define SAMPLER_DIRECT 0.25

typedef struct sampler {
    work_space_t *space;
    const renderer_t *renderer;
    film_t *film; /* splatted on if not null, values times `scale` */
    double scale;
    double *totals;          /* [K + 1]: scalar target of this sample by length; set, not added to */
    work_moments_t *moments; /* added to if not null */
    double *by_class;        /* [K + 1][PATH_CLASS_SETS]: if not null, scalar target by length and set of the path's
                                classes (connect.h), added to */
    double *by_technique;    /* [K + 1]: C_s of length `only`, if that is not 0 */
    importance_t importance; /* in totals, moments and by_technique; not in film, splats, blocks, by_class */
    const double *caps; /* [K], of length k in [k - 1], or null. With them totals, moments and by_technique are of
                           what chains follow, and the film gets what they leave (split.h) */
    double *blocks;     /* [K][WORK_BLOCKS]: added to if not null: scalar target by length and block of the image */
    sampler_splat_t *splats; /* [K + 1]: if not null, where this sample is seen: set, not added to */
    uint32_t splat_count;
    double *rays;          /* [K], of length k in [k - 1]: added to if not null: rays that it takes beyond k - 1 */
    bool of_image;         /* film and totals have the image's weights; else the balance heuristic's, as
                              moments by technique and by_technique always have */
    uint32_t only;         /* join only to this length; 0: to all */
    uint32_t longest;      /* length that samples are made up to */
    const double *weights; /* [K], of length k in [k - 1]: what a path counts (cutoff.h); null: 1 */
    const net_t *net;      /* the point that the walks' first numbers are of; null: they are independent */
    /* of the sample at hand */
    uint64_t key;
    rgb_t pixel; /* what the camera walk gathered */
} sampler_t;

/* Sample with the random numbers of `key`. pixel < 0: anywhere on the film; else within that pixel's share of it.
 * The walks' numbers are left in the space. */
void sampler_run(sampler_t *sampler, uint64_t key, int64_t pixel);

/* The same with the walks' numbers that are in the space; `key` is for numbers beside theirs. */
void sampler_evaluate(sampler_t *sampler, uint64_t key);

/* The numbers of the point on a light that camera vertex t - 1 is joined to (s = 1). */
void sampler_next_event(uint64_t key, uint32_t t, double u[3]);

#endif
