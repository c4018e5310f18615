/* settings.h: what a render does, as numbers: the part of a job that a result depends on.
 * Filled by job.h from JSON (folder plan), read by master and workers alike. Plain data. */
#ifndef CHAIN_SETTINGS_H
#define CHAIN_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

typedef enum settings_algorithm {
    SETTINGS_PT = 0,    /* independent samples, techniques s <= 1 */
    SETTINGS_BDPT = 1,  /* independent samples, all techniques */
    SETTINGS_MMLT = 2,  /* multiplexed Metropolis light transport (Hachisuka, Kaplanyan, Dachsbacher 2014) */
    SETTINGS_RJMLT = 3, /* the same with reversible jumps between techniques (Bitterli, Jarosz 2017) */
    SETTINGS_ALGORITHMS
} settings_algorithm_t;

typedef enum settings_target { SETTINGS_TARGET_LUMINANCE = 0, SETTINGS_TARGET_MAXIMUM = 1 } settings_target_t;
typedef enum settings_kernel { SETTINGS_KERNEL_KELEMEN = 0, SETTINGS_KERNEL_GAUSSIAN = 1 } settings_kernel_t;

typedef struct settings {
    settings_algorithm_t algorithm;
    uint32_t width, height;   /* pixels; 0: the scene's */
    int32_t filter;           /* scene_filter_t, or -1: the scene's */
    double filter_radius;     /* pixels; 0: the filter's usual one (box 0.5, triangle 1, gaussian 1.5) */
    uint32_t max_path_length; /* segments, 1 .. PATH_MAX_LENGTH; 0: the scene's, or 12 */
    uint64_t seed;
    settings_target_t target;
    settings_kernel_t kernel;
    double large_step;         /* probability of a large step */
    double technique_step; /* mmlt: probability that a small step draws the technique anew */
    double jump_step;      /* rjmlt: probability of a technique jump */
    double step_min, step_max; /* Kelemen's s1, s2; sigma of the Gaussian is step_max */
    uint64_t chain_length;     /* mutations a chain makes; 0: chosen by the plan */
    uint64_t pilot_samples;    /* candidates a path length; 0: chosen by the plan */
} settings_t;

/* Defaults for everything. */
void settings_default(settings_t *settings);
const char *settings_algorithm_name(settings_algorithm_t algorithm); /* "mmlt" */

#endif
