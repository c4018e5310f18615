/* plan_eras.h: the render in parts, the eras, between which the work is shared anew among path lengths.
 *
 * How large eras are is fixed beforehand: W_r, as work. How much of an era each length k gets, n_{k,r} mutations
 * (of samples beside chains: samples), is decided from the variances and costs that were measured in earlier eras
 * (stats/shift.h). A unit of length k in era r has the weight u = W_r / n_{k,r}, and the length's image is
 *
 *     I_k = b_k sum u film / sum u mutations = b_k sum_r W_r (mean of era r) / sum_r W_r.
 *
 * Why not just add up films and divide by mutations? Given all that came before, the mean of era r has the right
 * expectation whatever n_{k,r} is, and W_r is no random number: so I_k has it too. N_k, the sum of the n_{k,r}, is
 * a random number that hangs together with the values of length k itself: a length that met a bright rare path
 * early has a large variance, gets more mutations, and the path's part in the quotient is made smaller by them; one
 * that has not met it gets few, and its darkness stays. The quotient is biased, to the dark where light is rare
 * (tests/plan/test_eras.c shows it). Where all eras have the same shares all u are the same.
 *
 * A render that stops within an era (by time or error) has done a part a of its units. Units of an era are made in
 * an order that brings all lengths forward together, so a is the same for each up to a unit, and the era counts
 * a W_r: as ever with such rules the end may hang together with what was found, but no length's weight does.
 *
 * The price of fixed weights: with shares s_r the variance of a length is in proportion to sum_r W_r / s_r, where
 * the quotient's would be to 1 / sum_r W_r s_r. If a share changes by a factor f after a part a of the work that is
 * (a + (1 - a) / f) (a + (1 - a) f) times as much: 1.05 for f = 2 after an eighth, 1.25 for f = 4. It is the price
 * of the first eras alone, so these are short. A length of so little work that it would have no chain or pass of
 * samples in the first eras gets its part of these at once, in the first, and that part has all their weight.
 *
 * Exactness. What era r + 1 gets is decided when all units of the eras up to r - 1 are in and added up, and none of
 * era r: results that come before are kept (plan_pending.h) until it is decided. So the decision is the same
 * whatever the order of results, and as it is made while era r is out, nobody waits for it, unless more than
 * PLAN_PENDING_MOST units of era r are out before the last of era r - 1 is in. Costs are rays, counted. Decisions
 * are saved with the plan, as they cannot be worked out again later.
 *
 * Seeds: the chains of all eras of a length take places of one Kronecker sequence (plan_seeds.c), any run of which
 * is spread evenly over the candidates whatever its number; what the number changes is of the order of that
 * spread's discrepancy.
 *
 * One thread at a time, as all of a plan. */
#ifndef PLAN_PLAN_ERAS_H
#define PLAN_PLAN_ERAS_H

#include "base/fault.h"
#include "base/json.h"
#include "base/wire.h"
#include "plan/plan_nets.h"
#include "plan/plan_pending.h"

struct plan;
struct plan_unit;

enum { PLAN_ERAS = 64, PLAN_NO_ERA = UINT8_MAX };

/* A length's part of an era. */
typedef struct plan_part {
    double work;     /* W_r of this length, in mutations; 0: the era has no units of it */
    double share;    /* of all work, n_{k,r} / W_r */
    double due;      /* of the era's units, by work */
    double weight;   /* of a unit: u over that of the first era */
    uint64_t budget; /* n_{k,r}; UINT64_MAX: without end */
    uint64_t handed;
    uint64_t merged, units; /* that are added up: mutations or samples, units */
    plan_turns_t turns;     /* of samples */
} plan_part_t;

typedef struct plan_era {
    double work;
    uint64_t units, in; /* made; added up */
} plan_era_t;

typedef struct plan_eras {
    uint32_t count;   /* that there will be; 1: shares are frozen */
    uint32_t decided; /* the first so many have their budgets */
    uint32_t current; /* whose units are made */
    plan_era_t list[PLAN_ERAS];
    plan_part_t *parts; /* [PLAN_ERAS][max_path_length + 1] */
    plan_pending_t pending;
} plan_eras_t;

fault_code_t plan_eras_init(plan_eras_t *eras, uint32_t max_path_length, fault_t *fault);
void plan_eras_clear(plan_eras_t *eras);

/* With the pilot's shares and unit sizes: how many eras, and the budgets of the first ones. */
void plan_eras_begin(struct plan *plan);
/* The part of lengths[k] in an era. */
plan_part_t *plan_eras_part(const struct plan *plan, uint32_t era, uint32_t k);
/* Whether a unit may be made now; goes on to the next era where the current one is all handed out. */
bool plan_eras_ready(struct plan *plan);
/* Whether the last era is all handed out. */
bool plan_eras_spent(const struct plan *plan);
/* Counts a unit that was made, and is of the current era. */
void plan_eras_made(struct plan *plan, struct plan_unit *unit);
/* Whether a unit's result may be added up now. */
bool plan_eras_takes(const struct plan *plan, const struct plan_unit *unit);
/* Counts a unit that was added up; its mutations of lengths[k], or samples, as one unit of their own: of passes
 * that several units make, the whole pass. */
void plan_eras_took(struct plan *plan, const struct plan_unit *unit);
void plan_eras_add(struct plan *plan, const struct plan_unit *unit, uint32_t k, uint64_t mutations);
/* The weight of a unit. */
double plan_eras_weight(const struct plan *plan, const struct plan_unit *unit);
/* Decides the next era, if it is time. False if not. */
bool plan_eras_decide(struct plan *plan);

/* Over what was added up of lengths[k]: mutations by weight; the same by weight squared; how many units of one
 * weight those are worth, for a variance between them: with w their weights, m their mutations,
 * sum w sum w m / sum w^2 m. */
double plan_eras_counted(const struct plan *plan, uint32_t k);
double plan_eras_squared(const struct plan *plan, uint32_t k);
double plan_eras_units(const struct plan *plan, uint32_t k);

/* Shares of lengths[k] by era, of those that have begun; null if shares are frozen. */
json_t *plan_eras_json(const struct plan *plan, uint32_t k);

/* Decisions and pending results as bytes: u32 eras decided; from the third on, for each length u64 budget; then
 * plan_pending_put. Hostile bytes back, to a plan whose eras have begun. */
void plan_eras_put(wire_writer_t *out, const struct plan *plan);
fault_code_t plan_eras_get(wire_reader_t *in, struct plan *plan, uint64_t units);

#endif
