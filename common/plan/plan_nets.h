/* plan_nets.h: which points the passes of samples are of, and what that does to their error.
 *
 * The passes of samples over the image take points of nets (chain/net.h). Their sum has less variance than as many
 * independent passes would have, so what passes differ by, from which all estimates of the error come, says too
 * much. How much too much is measured: each pixel has two sequences of points, independent of each other, which
 * passes take in turn, so that the images A and B of either are independent and
 *
 *     E (A - B)^2 = Var A + Var B,
 *
 * whatever the points of one sequence do to each other. The ratio of that to what it would be if all passes were
 * independent is what the nets are worth at so many samples; all variances of samples are multiplied by it. It is
 * taken over the image, in relMSE's measure (`all`), and over each block of it, there together with the image's as
 * if that were of so many pixels as NETS_PRIOR more, as a block of a small image has but few. By pixel (A - B)^2
 * has one degree of freedom and says nothing: pixels keep the distribution within their block that passes show.
 * With one pass in each sequence the ratio is 1 by itself.
 *
 * Each era has two sequences of its own: how long it is was decided by what came before (plan_eras.h), and points
 * that go on where earlier ones ended would be what is left over by values that had a say in their number.
 *
 * One thread at a time, as all of a plan. */
#ifndef PLAN_PLAN_NETS_H
#define PLAN_PLAN_NETS_H

#include "base/wire.h"
#include "chain/work.h"
#include "film/film.h"
#include "stats/groups.h"

struct plan;
struct plan_unit;

typedef struct plan_nets {
    film_t second; /* of the film of samples: what passes of second sequences brought; null sums: nothing yet */
    double all, blocks[GROUPS_BLOCKS]; /* factors of the variance of samples */
} plan_nets_t;

/* An era's passes, in plan_part_t. */
typedef struct plan_turns {
    uint64_t passes[2]; /* handed out, by sequence */
    uint64_t second;    /* samples of the second one that are added up */
    uint32_t turn;      /* of the pass that was begun last */
} plan_turns_t;

void plan_nets_init(plan_nets_t *nets);
void plan_nets_clear(plan_nets_t *nets);

/* Fills in the points of the next unit of samples, of the current era, before it is counted as handed. */
void plan_nets_place(struct plan *plan, work_record_t *record);
/* Counts samples of a unit that was added up; adds their film (with the unit's weight) to its sequence. */
void plan_nets_count(struct plan *plan, const struct plan_unit *unit, uint64_t samples);
fault_code_t plan_nets_absorb(struct plan *plan, const struct plan_unit *unit, const film_t *film, fault_t *fault);

/* Where both sequences have passes: one number of the image of samples, of pixel and channel i, is with its error
 * (first film[i] - both second[i])^2 scale: an unbiased estimate of its variance, of one degree of freedom. */
typedef struct plan_nets_pair {
    double first, both, scale;
} plan_nets_pair_t;
static inline double plan_nets_variance(const plan_nets_pair_t *pair, int64_t film, int64_t second)
{
    const double d = (double)film * pair->first - (double)second * pair->both;
    return d * d * pair->scale;
}
/* False where there is but one. unit: what the film of samples is multiplied by for the image. */
bool plan_nets_pair(const struct plan *plan, double unit, plan_nets_pair_t *pair);
/* Sets the factors by the sums as they are. */
void plan_nets_measure(struct plan *plan);
/* Of lengths[k]: the image's factor if it is of samples, else 1. */
double plan_nets_factor(const struct plan *plan, uint32_t k);
/* What the image's factor is going to be after ten times as many samples, over what it is: the points of a sequence
 * take time to become even. With n points in each, factors are about f + (1 - f) n^-0.6, f the part of the variance
 * that nets do not help: measured on scenes where f is .35 to .9, between n^-2 of smooth integrands of one number
 * and n^-1/2 of edges in two. A factor below n^-0.6 is taken for a power of n, n^-2 at the most. */
double plan_nets_outlook(const struct plan *plan);

/* As bytes: the film, of size 0 if there is none. Hostile bytes back. */
void plan_nets_put(wire_writer_t *out, const struct plan *plan);
fault_code_t plan_nets_get(wire_reader_t *in, struct plan *plan, fault_t *fault);
/* After the units: whether the film goes with them. Measures. */
fault_code_t plan_nets_check(wire_reader_t *in, struct plan *plan);

#endif
