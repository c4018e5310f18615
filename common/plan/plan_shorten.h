/* plan_shorten.h: shorter chains, and more of them, where chains get stuck.
 *
 * A chain that is stuck on a path (chain/stuck.h) stays there to its end at the most. So what a single stay can be
 * of the image is bounded by what a chain is: L of the N_k mutations of its length k, L / N_k of that length's
 * light. Where a stuck stay was a 64th of its chain or longer, later chains of the length have a sixteenth of the
 * mutations and are sixteen times as many, each from a seed of its own; and so on, down to SHORTEN_LEAST mutations,
 * beside which a chain's start costs little.
 *
 * When. Units of the rendering are in stages: the eras (plan_eras.h) where there are some, else the first units,
 * two for each length, as many again, and then always as many as there were before. How long chains of stage r are
 * depends on the units of stage r - 2 and before alone, and no unit of stage r is made before all these are in: so
 * it does not depend on the order of results, on clocks or losses. While they come in the units of stage r - 1 are
 * there to do; workers of which there are more than these wait, until stages are as large as they are many. With
 *
 *     level_r = max(level_{r-1}, level_{r-2} + [a chain of stage r - 2 was stuck for a 64th of it])
 *
 * chains are 16^-level_r times as long as at first. Not decided here: how many mutations a length has, and what
 * they are weighted by. Given all that came before, every mutation of stage r is one of a chain that begins in
 * equilibrium, of whatever length: the mean of the stage has the right expectation.
 *
 * How short. Chains begin at the pilot's candidates, in proportion to their weights, and what they share of a few
 * of those does not average out, nor does the render's own error tell of it: chains that are long forget where they
 * began, short ones do not. So a length has no more chains by this than seeds, (sum w)^2 / sum w^2 of its
 * candidates' weights; when it has had as many, chains are as long as ever. (Without that the error of water-box,
 * whose lengths have a few dozen seeds, was three times as large as with long chains, and said to be less.)
 *
 * Nothing is done where the job says how long chains are; the bound is in the report. One thread at a time, as all
 * of a plan. */
#ifndef PLAN_PLAN_SHORTEN_H
#define PLAN_PLAN_SHORTEN_H

#include "base/json.h"
#include "base/wire.h"
#include "chain/work.h"
#include "path/walk.h"

struct plan;
struct plan_unit;

enum { PLAN_STAGES = 64 };

/* All zero: nothing is in. */
typedef struct plan_shorten {
    uint64_t in[PLAN_STAGES];                      /* units, where stages are not eras */
    uint8_t cut[PLAN_STAGES][PATH_MAX_LENGTH + 1]; /* 1: a chain of the stage and length was stuck for that long */
    double seeds[PATH_MAX_LENGTH + 1];             /* candidates that a length's chains begin at, by weight */
    double largest[PATH_MAX_LENGTH + 1];           /* mutations of a chain that is added up, by weight: the most */
} plan_shorten_t;

/* Counts seeds: when the pilot is over. */
void plan_shorten_init(struct plan *plan);
/* Whether all is in that the next unit's chains depend on. */
bool plan_shorten_ready(const struct plan *plan);
/* Mutations of the chains that lengths[k] has in the next unit; 0: as ever. */
uint64_t plan_shorten_chain(const struct plan *plan, uint32_t k);
/* Counts a unit that is in. */
void plan_shorten_count(struct plan *plan, uint64_t unit);
/* Looks at the chains of a unit that is added up with this weight. */
void plan_shorten_absorb(struct plan *plan, const struct plan_unit *unit, const work_result_t *result,
                         double weight);

/* What a chain of lengths[k] can be of the length's light: by mutations, the most. */
double plan_shorten_bound(const struct plan *plan, uint32_t k);
/* Of lengths whose chains were made shorter: length (0: chains of all), mutations of a chain at first and now. */
json_t *plan_shorten_json(const struct plan *plan);

/* As bytes: u32 stages; for each and each length u8 cut; for each length f64 largest. Hostile bytes back, when all
 * else of the plan's sums is known. */
void plan_shorten_put(wire_writer_t *out, const struct plan *plan);
fault_code_t plan_shorten_get(wire_reader_t *in, struct plan *plan);

#endif
