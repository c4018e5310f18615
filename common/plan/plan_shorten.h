/* plan_shorten.h: how long chains are: as short, and as many, as a length has seeds for.
 *
 * A chain that is stuck on a path (chain/stuck.h) stays there to its end at the most. So what a single stay can be
 * of the image is bounded by what a chain is: L of the N_k mutations of its length k, L / N_k of that length's
 * light. Nor need a chain be stuck for that: what it does not forget on its way it brings as one draw. Each chain
 * begins in equilibrium, at a candidate of the pilot's that was taken in proportion to its weight; so many short
 * ones are better than few long ones as long as they begin at different candidates.
 *
 * How many. Of n chains candidate i, with a part p_i of the weights, begins n p_i. Chains that never forget where
 * they began would have a variance of p_i / n by it where n p_i < 1, and of p_i^2, that of the candidates
 * themselves, beyond. What an estimate sees, from the differences between units, is p_i / n either way, as a
 * candidate that begins many chains has some in every unit. So
 *
 *     unseen(n) = sum over n p_i > 1 of p_i (n p_i - 1)
 *
 * is the most that is not seen of the variance, over all that is. A length has at most as many chains as keep that
 * below SHORTEN_UNSEEN, about sum p_i^2 to the power -1 where the p_i are alike, few where some stand out: its
 * seeds. (Water-box has a few dozen a length. With many times as many chains its error was three times as large as
 * with long chains, and said to be less.)
 *
 * How long. With m seeds left chains of the next unit have a part 1 / m of the mutations that are left. Where the
 * rule does not say how many these are chains are five over the length's seeds of all that it was handed, or of
 * what one worker would do in the rule's seconds if that is more: they grow as the length does, and as the sum of
 * dN / N is a logarithm there are not quite as many as seeds when they are as long as is usual. Never less than
 * SHORTEN_LEAST, beside which a chain's start costs little and a stuck stay can still be told, nor more than the
 * usual length; when there are no seeds left chains have that. All of it follows from the job, the pilot and the
 * units' list: there is nothing to wait for, and no order of results or clock enters.
 *
 * Where the job says how long chains are they are that long; the bound is in the report. One thread at a time, as
 * all of a plan. */
#ifndef PLAN_PLAN_SHORTEN_H
#define PLAN_PLAN_SHORTEN_H

#include "base/json.h"
#include "base/wire.h"
#include "chain/work.h"
#include "path/walk.h"

struct plan;

/* All zero: no seeds, nothing is in. */
typedef struct plan_shorten {
    double seeds[PATH_MAX_LENGTH + 1];   /* chains that a length may have by this */
    double largest[PATH_MAX_LENGTH + 1]; /* mutations of a chain that is added up, by weight: the most */
} plan_shorten_t;

/* Counts seeds: when the pilot is over. */
void plan_shorten_init(struct plan *plan);
/* Mutations of the chains that lengths[k] has in the next unit. */
uint64_t plan_shorten_chain(const struct plan *plan, uint32_t k);
/* Looks at the chains of a unit that is added up with this weight. */
void plan_shorten_absorb(struct plan *plan, const work_record_t *record, double weight);

/* The most chains for which unseen(n) is below SHORTEN_UNSEEN, within a quarter; of weights as running sums. */
double plan_shorten_seeds(const double *weights, uint64_t count);
/* What a chain of lengths[k] can be of the length's light: by mutations, the most. */
double plan_shorten_bound(const struct plan *plan, uint32_t k);
/* Of lengths whose chains are shorter than usual: length (0: chains of all), mutations of a chain as usual and in
 * the mean. */
json_t *plan_shorten_json(const struct plan *plan);

/* As bytes: for each length f64 largest. Hostile bytes back, when all else of the plan's sums is known. */
void plan_shorten_put(wire_writer_t *out, const struct plan *plan);
fault_code_t plan_shorten_get(wire_reader_t *in, struct plan *plan);

#endif
