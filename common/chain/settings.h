/* settings.h: what a render does, as numbers: the part of a job that a result depends on.
 * Filled by job.h from JSON (folder plan), read by master and workers alike. Plain data. */
#ifndef CHAIN_SETTINGS_H
#define CHAIN_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

/* Independent samples first, then Markov chains; what each does: docs/transport.md. */
typedef enum settings_algorithm {
    SETTINGS_PT = 0,     /* independent samples, techniques s <= 1 */
    SETTINGS_BDPT,       /* independent samples, all techniques */
    SETTINGS_MMLT,       /* multiplexed (Hachisuka, Kaplanyan, Dachsbacher 2014) */
    SETTINGS_RJMLT,      /* reversible jumps between techniques (Bitterli, Jarosz 2017) */
    SETTINGS_CMLT,       /* chart swaps by serial tempering (Pantaleoni 2017) */
    SETTINGS_CMLT_REX,   /* chart swaps by replica exchange (ibid.) */
    SETTINGS_CMLT_IPSM,  /* inverse primary space perturbations (ibid.) */
    SETTINGS_PSSMLT_MIX, /* chains that keep their technique, weighted targets (ibid., section 3.2) */
    SETTINGS_PSSMLT,     /* two walks joined in all ways, all lengths at once (Kelemen et al. 2002) */
    SETTINGS_ALGORITHMS
} settings_algorithm_t;

typedef enum settings_target { SETTINGS_TARGET_LUMINANCE = 0, SETTINGS_TARGET_MAXIMUM = 1 } settings_target_t;
typedef enum settings_kernel { SETTINGS_KERNEL_KELEMEN = 0, SETTINGS_KERNEL_GAUSSIAN = 1 } settings_kernel_t;

/* What a proposal without contribution does to its chain. */
typedef enum settings_failures {
    SETTINGS_FAILURES_PLAIN = 0, /* the state counts once more (Metropolis, Hastings) */
    SETTINGS_FAILURES_DELAYED,   /* a second, smaller step is tried (delayed rejection; Tierney, Mira 1999) */
    SETTINGS_FAILURES_PUBLISHED, /* nothing counts ("rectified proposal failures", 2019): biased */
    SETTINGS_FAILURES
} settings_failures_t;

/* Effects that a job may leave out or insist on (docs/effects.md). */
typedef enum settings_switch {
    SETTINGS_SWITCH_AUTO = 0, /* there if the scene has it */
    SETTINGS_SWITCH_ON,       /* the job is refused if it is not there */
    SETTINGS_SWITCH_OFF,      /* its paths carry nothing */
    SETTINGS_SWITCHES
} settings_switch_t;
typedef enum settings_effect {
    SETTINGS_CAUSTICS = 0, /* paths whose first vertex after the light is specular, with a later one that is not */
    SETTINGS_ENVIRONMENT,  /* paths that start on infinite lights */
    SETTINGS_APERTURE,     /* off: a pinhole in the lens' place */
    SETTINGS_INDIRECT,     /* paths of more than two segments */
    SETTINGS_EMISSION,     /* paths of one segment: lights that are seen themselves */
    SETTINGS_ALL_TECHNIQUES, /* on: those of negligible energy stay; never off */
    SETTINGS_EFFECTS
} settings_effect_t;

typedef struct settings {
    settings_algorithm_t algorithm;
    uint32_t width, height;     /* pixels; 0: the scene's */
    int32_t filter;             /* scene_filter_t, or -1: the scene's */
    double filter_radius;       /* pixels; 0: the filter's usual one (box 0.5, triangle 1, gaussian 1.5) */
    uint32_t max_path_length;   /* segments, 1 .. PATH_MAX_LENGTH; 0: the scene's, or 12 */
    uint32_t whole_path_length; /* the same if indirect light were not left out; filled in with it */
    uint64_t seed;
    settings_target_t target;
    settings_kernel_t kernel;
    settings_failures_t failures;
    double large_step;     /* probability of a large step */
    double technique_step; /* mmlt: probability that a small step draws the technique anew */
    double jump_step;      /* rjmlt, cmlt: probability of a technique jump; cmlt-rex: of an exchange */
    double partial_step;   /* probability that a small step changes one walk only */
    double equalize;       /* exponent of the importance against the dark, 0 .. 1; 0: there is none */
    double split;      /* with it samples bring what they sample well, chains the rest (split.h): the mutations that
                          chains are taken to need for what one independent draw would do; 0: chains bring all */
    double split_gain; /* chains are run if the pilot promises the accuracy of samples alone in that part of the
                          time; 1: always (plan/plan_split.c) */
    bool adapt; /* the chains of each length are tried out first: what they make of a mutation decides the shares,
                   and which of a few steps they take the render (plan/plan_trial.c) */
    bool shift; /* the work is shared anew among lengths while the render runs (plan/plan_eras.h) */
    double auxiliary_step; /* probability of a step of the visibility chain, with an exchange; 0: there is none */
    double step_min, step_max;         /* Kelemen's s1, s2; sigma of the Gaussian is step_max */
    uint64_t chain_length;             /* mutations a chain makes; 0: chosen by the plan */
    uint64_t pilot_samples;            /* candidates a path length; 0: chosen by the plan */
    uint8_t effects[SETTINGS_EFFECTS]; /* settings_switch_t */
} settings_t;

/* Defaults for everything. */
void settings_default(settings_t *settings);
/* What a job means by the algorithm "auto": the moves and the split between samples and chains that were measured
 * to be best (docs/gains.md). */
void settings_auto(settings_t *settings);
const char *settings_algorithm_name(settings_algorithm_t algorithm); /* "mmlt" */

static inline bool settings_forbids(const settings_t *settings, settings_effect_t effect)
{
    return settings->effects[effect] == SETTINGS_SWITCH_OFF;
}

/* What an algorithm is made of. */
static inline bool settings_is_chains(settings_algorithm_t a)
{
    return a >= SETTINGS_MMLT;
}
static inline bool settings_jumps(settings_algorithm_t a)
{
    return a == SETTINGS_RJMLT || a == SETTINGS_CMLT;
}
/* Whether a chain never leaves its technique: its seeds put as many chains on each as it has energy. */
static inline bool settings_keeps_technique(settings_algorithm_t a)
{
    return a == SETTINGS_CMLT_REX || a == SETTINGS_PSSMLT_MIX;
}
/* Whether a chain's state is two walks joined in all ways, so that it is of all lengths at once. */
static inline bool settings_joins_all(settings_algorithm_t a)
{
    return a == SETTINGS_PSSMLT;
}
/* Whether units need the techniques' shares of energy (work_record_t.techniques). */
static inline bool settings_wants_shares(settings_algorithm_t a)
{
    return a == SETTINGS_CMLT || a == SETTINGS_CMLT_IPSM;
}

#endif
