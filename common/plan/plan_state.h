/* plan_state.h: what a plan knows; for the files of this folder only. */
#ifndef PLAN_PLAN_STATE_H
#define PLAN_PLAN_STATE_H

#include "path/walk.h"
#include "plan/exact.h"
#include "plan/plan.h"
#include "plan/plan_groups.h"
#include "plan/plan_history.h"
#include "plan/plan_stuck.h"

/* A bidirectional sample costs as much as about so many mutations, and counts as so many where there are both. */
enum { PLAN_SAMPLE_MUTATIONS = 10 };

/* Mutations a second of one worker, about: where a rule says seconds. */
enum { PLAN_USUAL_RATE = 1000000 };

/* How the chains of a length step: powers of two, as in work_record_t. */
typedef struct plan_steps {
    int32_t steps, large;
} plan_steps_t;

/* What a trial told (plan_trial.c), of one of its chains. */
typedef struct plan_trial {
    double spread; /* of what they add to the image (chain/trial.c) */
    double rays;
} plan_trial_t;

typedef enum plan_unit_state { PLAN_UNIT_OUT = 0, PLAN_UNIT_IN = 1 } plan_unit_state_t;

typedef struct plan_unit {
    uint8_t state;        /* plan_unit_state_t */
    bool handed;          /* after a restore: false until it is handed out again */
    work_record_t record; /* cleared once the unit is in */
} plan_unit_t;

/* Sums of one estimator over units, free of order; in units of `unit` and its square. */
typedef struct plan_moments {
    double n;
    exact_sum_t sum, sum2;
} plan_moments_t;

/* One path length; [0]: samples or chains of all of them at once. */
typedef struct plan_length {
    /* pilot */
    double *weights; /* of the candidates; after the pilot their running sum, where chains start from them */
    double b;        /* the pilot's estimate of what chains follow */
    double light;    /* and of all light of the length, without importance and cap */
    double need; /* mean over the image's blocks of I_k m / (I^2 + 0.01 m^2): how much the error is in its pixels */
    double inefficiency; /* mutations that do what one independent draw would do; guessed, or by trials */
    double cost;         /* rays of a mutation, likewise */
    uint32_t trials, trial_options, option; /* chains that are tried, with so many kinds of steps; the one taken */
    plan_steps_t steps;                     /* what it is */
    double share;                           /* of the mutations; 0: nothing to render */
    double techniques[PATH_MAX_VERTICES];   /* their shares of b by the pilot, for algorithms that want them */
    /* rendering */
    uint64_t budget; /* mutations in all when the rule is mutations_per_pixel; else UINT64_MAX */
    uint64_t unit_mutations, unit_chains;
    uint64_t units_out, units_in;
    uint64_t handed, merged; /* mutations */
    uint64_t chains;         /* ids given out */
    film_t film;
    /* Estimators [0] of b_k, [1 + s] of b_{k,s}: by bidirectional samples (pilot, refinement, pt and bdpt), by the
     * large steps of chains. */
    plan_moments_t samples[PATH_MAX_VERTICES + 1], large_steps[PATH_MAX_VERTICES + 1];
    uint64_t proposed[WORK_MOVES];
    exact_sum_t accepted[WORK_MOVES];
    uint64_t zero_proposals, longest_stay, stuck_rejections;
    uint64_t failed[WORK_FAILED_BLOCKS]; /* failures = published */
    double cpu_seconds;
} plan_length_t;

struct plan {
    job_t job;
    settings_t settings; /* complete */
    const scene_t *scene;
    size_t pixels;
    plan_phase_t phase;
    plan_unit_t *units;
    uint64_t unit_count, unit_room;    /* handed out so far */
    uint64_t resume;                   /* units below it may need handing out again, after a restore */
    uint64_t sketch_units;             /* with equalize: the first units of all, for the importance; else 0 */
    uint64_t pilot_units, in;          /* units of the first phase; units in */
    uint64_t pilot_next;               /* units of the first phase generated so far */
    uint64_t candidates;               /* of the pilot */
    uint32_t pilot_unit, feature_rows; /* candidates and rows a unit */
    bool has_candidates;               /* they are all in: b_k and seeds are known */
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
    bool has_caps;
    double caps[PATH_MAX_LENGTH];  /* of length k in [k - 1], once those units are in; infinite: no chains */
    double rates[PATH_MAX_LENGTH]; /* how often samples go to length k, in [k - 1], likewise (chain/cutoff.h) */
    double split_samples;   /* samples that are due, as lengths' mutations are b_k sqrt(inefficiency / cost) */
    uint64_t refine_handed; /* samples */
    plan_length_t *lengths; /* [max_path_length + 1]; see plan_first */
    double b;              /* sum of the pilot's b_k (with split: of all light): the unit of the estimators' sums */
    double scale;          /* samples: film value of a contribution of 1; a power of two */
    uint64_t sample_unit;  /* samples a unit */
    double weight_max;     /* largest b_k / share_k */
    exact_uint_t *squares; /* [pixels][3]: sum over units of (c_k x)^2 / n 2^40: c_k = b_k / share_k / weight_max, n
                              the unit's size over the usual one of its length */
    exact_uint_t *strata;  /* chains: the same of sums over blocks, see plan_strata.c; and room for a row of them */
    plan_groups_t groups;
    plan_history_t history; /* of the estimated error */
    double predicted;       /* CPU seconds until the rule's error, by the history as it is; NaN while unknown */
    float *features;        /* [pixels][WORK_FEATURE_CHANNELS] */
    work_stats_t totals;    /* over all units (but for accepted, proposed: by length) */
    stuck_t stuck;          /* likewise */
    double pilot_cpu_seconds;
    film_counts_t film_counts;
    double seconds;         /* as last told */
    double error;           /* sqrt(relMSE), NaN while unknown */
    uint64_t error_next;    /* units in when it is estimated anew */
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

/* Mutations that count: with failures = published those alone that carried light. */
static inline double plan_counted(const plan_t *plan, const plan_length_t *length)
{
    const bool fewer = plan->settings.failures == SETTINGS_FAILURES_PUBLISHED;
    return (double)(length->merged - (fewer ? length->zero_proposals : 0));
}

/* plan.c */
/* Mutations merged, samples beside chains as what they count. */
double plan_merged(const plan_t *plan);
/* Makes the next unit of the list; false if there is none now. */
bool plan_generate(plan_t *plan);

/* plan_sketch.c */
/* How many of the pilot's units make the sketch: 0 without equalize. */
uint64_t plan_sketch_size(const plan_t *plan, uint64_t units);
/* The sketch's unit number `index`. */
void plan_sketch_record(const plan_t *plan, uint64_t index, work_record_t *record);
bool plan_is_sketch(const work_record_t *record);
/* Takes in a unit of it; the last one fixes the importance. */
void plan_absorb_sketch(plan_t *plan, const work_record_t *record, const work_result_t *result);
/* Gives the record a copy of the importance, if there is one. */
fault_code_t plan_set_importance(const plan_t *plan, work_record_t *record, fault_t *fault);

/* plan_split.c */
/* How many of the pilot's units are for the caps: 0 without split. */
uint64_t plan_split_size(const plan_t *plan, uint64_t units);
void plan_split_record(const plan_t *plan, uint64_t index, work_record_t *record);
bool plan_is_split(const work_record_t *record);
/* Takes in a unit of them; the last one fixes the caps. */
void plan_absorb_split(plan_t *plan, const work_record_t *record, const work_result_t *result);
/* After the pilot: lengths without chains. Then the shares of samples and lengths. */
void plan_split_settle(plan_t *plan);
void plan_split_shares(plan_t *plan);
/* Gives the record a copy of the caps and rates that it needs, if there are any. */
fault_code_t plan_set_caps(const plan_t *plan, work_record_t *record, fault_t *fault);

/* plan_budget.c */
/* Sizes of the first phase from the job; called once. */
void plan_size_pilot(plan_t *plan);
/* Unit number `index` of the first phase. */
fault_code_t plan_pilot_record(const plan_t *plan, uint64_t index, work_record_t *record);
/* Whether the next of them waits for those before it to come in. */
bool plan_pilot_waits(const plan_t *plan);
/* With the candidates in: b and what goes with it. FAULT_NO_LIGHT if nothing was found. */
fault_code_t plan_find_light(plan_t *plan, fault_t *fault);
/* After pilot and trials: shares, unit sizes. */
void plan_size_render(plan_t *plan);
/* After the pilot's sums are in: shares of the techniques. */
void plan_freeze_techniques(plan_t *plan);
/* The next unit of the rendering phase; false if the budget is spent or memory is. */
bool plan_render_record(plan_t *plan, work_record_t *record);

/* Mutations that a chain makes. */
uint64_t plan_chain_length(const plan_t *plan);
/* Sets the shares by what is known of inefficiencies and costs. */
void plan_shares(plan_t *plan);
/* Rays of a mutation of length k, about. */
double plan_usual_cost(uint32_t k);
/* A unit of chains of length k; false if memory is out. */
bool plan_chains_record(const plan_t *plan, work_kind_t kind, uint32_t k, uint64_t first, uint64_t chains,
                        uint64_t mutations, plan_steps_t steps, work_record_t *record);

/* plan_trial.c */
/* How many there are once the candidates are in, and room for what they tell: none where they would not pay. */
fault_code_t plan_prepare_trials(plan_t *plan, fault_t *fault);
/* Unit number `index` of them. */
bool plan_trial_record(const plan_t *plan, uint64_t index, work_record_t *record);
void plan_absorb_trial(plan_t *plan, uint64_t index, const work_record_t *record, const work_result_t *result);
/* With all of them in: steps, inefficiencies and costs of the lengths. */
void plan_finish_trials(plan_t *plan);

/* plan_seeds.c */
/* Turns candidate weights into running sums. */
void plan_prepare_seeds(const plan_t *plan, plan_length_t *length);
/* The candidate that chain `chain` of length k starts from: systematic resampling of as many chains as ever come.
 */
uint64_t plan_seed(const plan_t *plan, uint32_t k, uint64_t chain);

/* plan_estimate.c */
/* Estimates from all samples and large steps so far, with their standard errors: of b_k (of b for k = 0: that error
 * is the sum of the b_k's, which is the most it can be), of b_{k,s}. */
double plan_length_b(const plan_t *plan, uint32_t k, double *error);
double plan_technique_b(const plan_t *plan, uint32_t k, uint32_t s, double *error);
/* Pixel values and variances: what plan_pixel needs, computed once an image. */
typedef struct plan_pixels {
    const plan_t *plan;
    uint32_t count;                         /* lengths that have been rendered */
    uint32_t lengths[PATH_MAX_VERTICES];    /* which */
    const int64_t *sums[PATH_MAX_VERTICES]; /* their films */
    double factor[PATH_MAX_VERTICES];       /* b_k / (N_k 2^28) */
    double b_variance[PATH_MAX_VERTICES];   /* (sigma_{b_k} / b_k)^2 factor^2 */
    double square[PATH_MAX_VERTICES];       /* of a sum: what the mean takes off the squares, in image units */
    double squares_factor;                  /* of plan->squares, in image units */
    double correction;                      /* U / (U - 1) */
} plan_pixels_t;

void plan_pixels_init(plan_pixels_t *pixels, const plan_t *plan);
/* Value and variance of pixel p, per channel. Variance is infinite while there are too few units. */
void plan_pixel(const plan_pixels_t *pixels, size_t p, double value[3], double variance[3]);
/* The error of the image as it stands. */
typedef struct plan_error {
    double relmse;    /* NaN while there are too few units */
    double spread;    /* its relative standard error, from groups of units; NaN while these are too few */
    double low, high; /* 95 % of relmse; NaN likewise */
    double lengths[PATH_MAX_VERTICES]; /* what each of plan->lengths brings to it */
} plan_error_t;
void plan_estimate_error(const plan_t *plan, plan_error_t *error);
/* How alike the groups' images are: brightness of each over the image's, and the root of the mean squared relative
 * difference over 16 x 16 blocks, in the measure of relMSE. False while there are too few units. */
typedef struct plan_group_figures {
    double brightness[PLAN_GROUPS], deviation[PLAN_GROUPS];
} plan_group_figures_t;
bool plan_estimate_groups(const plan_t *plan, plan_group_figures_t *figures);
/* The mean luminance of a region of blocks, with 95 % between low and high: Student's, from the groups, and the
 * error of b. False before each length that is rendered has a unit in every group. */
typedef struct plan_region {
    double mean, low, high;
} plan_region_t;
bool plan_estimate_region(const plan_t *plan, const bool region[PLAN_GROUP_BLOCKS], plan_region_t *out);
/* Regions that a report tells of: so many across and down. */
enum { PLAN_REGION_SIDE = 4, PLAN_REGIONS = PLAN_REGION_SIDE * PLAN_REGION_SIDE };

/* plan_accuracy.c: what the history says about the time that accuracy takes, for reports and progress. */
/* Estimates the error now and notes it in the history. */
void plan_note_error(plan_t *plan);
/* What the history says of when the rule's error is met; after it has changed. */
void plan_predict(plan_t *plan);
void plan_report_accuracy(const plan_t *plan, json_t *report);

/* plan_strata.c: how much the errors of neighbouring pixels hang together. */
/* Blocks of the image; three of plan->strata each. */
size_t plan_strata(const plan_t *plan);
/* Adds the squares of a unit's sums over blocks, as absorb_squares those of its pixels. */
void plan_absorb_strata(plan_t *plan, const film_t *film, double c, double size);
/* Variance of the blocks' sums over the sum of their pixels' variances; NaN while there are too few units. */
double plan_estimate_strata(const plan_t *plan);

#endif
