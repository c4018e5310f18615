/* plan_state.h: what a plan knows; for the files of this folder only. */
#ifndef PLAN_PLAN_STATE_H
#define PLAN_PLAN_STATE_H

#include "plan/plan.h"
#include "plan/plan_eras.h"
#include "stats/groups.h"
#include "stats/history.h"
#include "plan/plan_length.h"
#include "plan/plan_nets.h"
#include "plan/plan_passes.h"
#include "plan/plan_shorten.h"

/* A bidirectional sample costs as much as about so many mutations, and counts as so many where there are both. */
enum { PLAN_SAMPLE_MUTATIONS = 10 };

/* Mutations a second of one worker, about: where a rule says seconds. */
enum { PLAN_USUAL_RATE = 1000000 };

/* What a trial told (plan_trial.c), of one of its chains. */
typedef struct plan_trial {
    double spread; /* of what they add to the image (chain/trial.c) */
    double rays;
} plan_trial_t;

/* A length of chains begins with so many small units, so that there is an estimate of the error early. */
enum { PLAN_EARLY = 4 };

typedef enum plan_unit_state { PLAN_UNIT_OUT = 0, PLAN_UNIT_IN = 1 } plan_unit_state_t;

typedef struct plan_unit {
    uint8_t state;        /* plan_unit_state_t */
    uint8_t era;          /* of the render, or PLAN_NO_ERA */
    bool handed;          /* after a restore: false until it is handed out again */
    uint64_t number;      /* among the units of its length */
    work_record_t record; /* cleared once the unit's result is added up */
} plan_unit_t;

struct plan {
    job_t job;
    settings_t settings; /* complete */
    const scene_t *scene;
    size_t pixels;
    plan_phase_t phase;
    plan_unit_t *units;
    uint64_t unit_count, unit_room;      /* handed out so far */
    uint64_t resume;                     /* units below it may need handing out again, after a restore */
    uint64_t sketch_units;               /* with equalize: the first units of all, for the importance; else 0 */
    uint64_t pilot_units, in;            /* units of the first phase; units in */
    uint64_t pilot_next;                 /* units of the first phase generated so far */
    uint64_t candidates;                 /* of the pilot */
    uint32_t pilot_unit;                 /* samples of the pilot a unit */
    uint32_t feature_rows, feature_side; /* rows a unit, and rays along a pixel's side */
    uint32_t candidate_unit;             /* candidates a unit: as many, or few where they are not for seeds */
    bool has_candidates;                 /* they are all in: b_k and seeds are known */
    uint64_t trial_units, trial_next, trial_in; /* units of trials, after the pilot's: in all, generated, in */
    uint64_t trial_mutations;                   /* of each of their chains */
    plan_trial_t *trials;                       /* [trial_units] */
    work_moments_t *pilot_moments; /* of each pilot unit, until all are in: sums need their unit, plan->b, first */
    uint64_t sketch_in;            /* of them in */
    bool has_importance;
    double importance[IMPORTANCE_BLOCKS]; /* once the sketch is in */
    double *pilot_blocks;                 /* [pilot units][K][WORK_BLOCKS], as long */
    uint64_t split_units; /* with split: units for the choice of the caps, after the sketch's; else 0 */
    uint64_t split_in;    /* of them in */
    uint64_t split_rays[PATH_MAX_LENGTH]; /* what they traced for length k beyond k - 1, in [k - 1] */
    bool has_caps, samples_alone;         /* then all caps are infinite */
    double caps[PATH_MAX_LENGTH];         /* of length k in [k - 1], once those units are in; infinite: no chains */
    double rates[PATH_MAX_LENGTH]; /* how often samples go to length k, in [k - 1], likewise (chain/cutoff.h) */
    double split_promise;          /* work of samples alone over that of the best choice, by the pilot */
    double split_samples;     /* samples that are due, as lengths' mutations are b_k sqrt(inefficiency / cost) */
    uint32_t measurable;      /* the last length of which the pilot is sure that it carries light */
    uint64_t refine_handed;   /* samples */
    uint64_t survey_units;    /* of either round of the look for idle techniques; 0: all stay */
    work_moments_t *survey;   /* [2][survey_units][work_samples_moment(K + 1)]; zero of those not in */
    bool has_idle[2];         /* a round is over: */
    target_idle_t *idle;      /* [K], proposed by the first, settled by the second */
    double *idle_energy;      /* [K], the most that those of a length bring of its energy */
    uint64_t left_out_units;  /* after the features, of jobs that leave out something; else 0 */
    work_moments_t *left_out; /* [left_out_units][WORK_LEFT_OUT_MOMENTS]; zero of those that are not in */
    plan_length_t *lengths;   /* [max_path_length + 1]; see plan_first */
    double b;              /* sum of the pilot's b_k (with split: of all light): the unit of the estimators' sums */
    double scale;          /* samples: film value of a contribution of 1; a power of two */
    uint64_t sample_unit;  /* samples a unit */
    double weight_max;     /* largest b_k / share_k */
    exact_uint_t *squares; /* [pixels][3]: sum over units of (c_k x)^2 / n 2^40: c_k = b_k / share_k / weight_max, n
                              the unit's size over the usual one of its length */
    exact_uint_t *strata;  /* chains: by length and block of the image the same of the block's sum, and of its
                              pixels; and a row of sums (plan_strata.c) */
    groups_t groups;
    plan_passes_t passes; /* of samples */
    plan_nets_t nets;     /* their points */
    plan_eras_t eras;
    plan_shorten_t shorten;
    history_t history;   /* of the estimated error */
    double predicted;    /* CPU seconds until the rule's error, by the history as it is; NaN while unknown */
    float *features;     /* [pixels][WORK_FEATURE_CHANNELS] */
    work_stats_t totals; /* over all units (but for accepted, proposed: by length) */
    stuck_t stuck;       /* likewise */
    double pilot_cpu_seconds;
    film_counts_t film_counts;
    film_t spare;           /* or none: of the result added up last, for the next one */
    double seconds;         /* as last told */
    double error;           /* sqrt(relMSE), NaN while unknown */
    uint64_t error_next;    /* units in when it is estimated anew, */
    double error_due;       /* but not before so many seconds */
    double mutations_total; /* of the rule; 0 if there is none */
    bool stopped;
    const char *stopped_by;
};

/* What reports and headers say of failures = published. */
#define PLAN_BIASED "failed proposals are left out: the image is of C (1 - p_fail), not of C"

static inline bool plan_is_chains(const plan_t *plan)
{
    return settings_is_chains(plan->settings.algorithm);
}

/* Whether it runs any, too: not where the pilot left all to samples. */
static inline bool plan_runs_chains(const plan_t *plan)
{
    return plan_is_chains(plan) && !plan->samples_alone;
}

/* Whether samples bring a part of the light that chains do not: lengths[0] is theirs beside the chains' lengths. */
static inline bool plan_splits(const plan_t *plan)
{
    return plan->split_units > 0;
}

/* Whether a unit is of all lengths at once: samples, and chains that join all. */
static inline bool plan_is_whole(const plan_t *plan)
{
    return !plan_is_chains(plan) || settings_joins_all(plan->settings.algorithm);
}

/* Those of lengths[] that have units, film and counts of them: each length has its own, or [0] all. */
static inline uint32_t plan_first(const plan_t *plan)
{
    return plan_is_whole(plan) || plan_splits(plan) ? 0 : 1;
}
static inline uint32_t plan_last(const plan_t *plan)
{
    return plan_is_whole(plan) ? 0 : plan->settings.max_path_length;
}

/* Whether lengths[k] is of samples, not of chains. */
static inline bool plan_is_samples(const plan_t *plan, uint32_t k)
{
    return k == 0 && (!plan_is_chains(plan) || plan_splits(plan));
}

/* Mutations that one of lengths[k] counts as, in shares and in the rule mutations_per_pixel. */
static inline double plan_mutations_of(const plan_t *plan, uint32_t k)
{
    return k == 0 && plan_splits(plan) ? PLAN_SAMPLE_MUTATIONS : 1;
}

/* What a splat of 1 on the film of lengths[k] is in the image, times all mutations there will be. */
static inline double plan_weight(const plan_t *plan, uint32_t k)
{
    const plan_length_t *length = &plan->lengths[k];
    const double b = plan_is_samples(plan, k) ? plan_mutations_of(plan, k) / plan->scale : length->b;
    return b / length->share;
}

/* Whether chains of lengths[k] start from candidates. */
static inline bool plan_has_seeds(const plan_t *plan, uint32_t k)
{
    return plan_is_chains(plan) && !plan_is_samples(plan, k) && (k == 0) == plan_is_whole(plan);
}

/* Mutations of lengths[k] that count, by weight: with failures = published those alone that carried light. */
static inline double plan_counted(const plan_t *plan, uint32_t k)
{
    const bool fewer = plan->settings.failures == SETTINGS_FAILURES_PUBLISHED;
    return plan_eras_counted(plan, k) - (fewer ? (double)plan->lengths[k].zero_proposals : 0);
}

/* plan.c */
/* Mutations merged, samples beside chains as what they count. */
double plan_merged(const plan_t *plan);
/* Makes the next unit of the list; false if there is none now. */
bool plan_generate(plan_t *plan);
/* Takes the decisions that are due, and adds up the results that waited for them. */
fault_code_t plan_settle(plan_t *plan, fault_t *fault);

#endif
