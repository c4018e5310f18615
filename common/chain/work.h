/* work.h: units of work: what the master hands out and what a worker's thread makes of it.
 *
 * A unit's result is a function of (scene, settings, record) alone: no clock, thread, order or neighbour enters it,
 * but for the timing figures in its stats. Units are small (a fraction of a second to seconds), so a lost one costs
 * little.
 *
 *     renderer_t *renderer;                              one a job and process, immutable
 *     TRY(renderer_new(&renderer, scene, &settings, fault));
 *     work_space_t *space;                               one a thread
 *     TRY(work_space_new(&space, renderer, fault));
 *     TRY(work_run(space, &record, &cancel, &result, fault));   result borrows from the space until the next run
 *     TRY(work_result_encode(&result, &bytes, &size, fault));
 */
#ifndef CHAIN_WORK_H
#define CHAIN_WORK_H

#include <math.h>
#include <stdatomic.h>
#include <stddef.h>

#include "chain/importance.h"
#include "chain/settings.h"
#include "chain/stuck.h"
#include "chain/target.h"
#include "film/film.h"
#include "scene/scene.h"

typedef struct renderer renderer_t;
typedef struct work_space work_space_t;

/* Builds what rendering needs: the Embree scene, light tables, materials. `scene` is borrowed for the renderer's
 * life. */
fault_code_t renderer_new(renderer_t **out, const scene_t *scene, const settings_t *settings, fault_t *fault);
/* Fills in what settings leave to the scene: film size, path length. Needs no Embree. */
fault_code_t renderer_complete_settings(settings_t *settings, const scene_t *scene, fault_t *fault);
void renderer_destroy(renderer_t **renderer);
void renderer_film_size(const renderer_t *renderer, uint32_t *width, uint32_t *height);
const settings_t *renderer_settings(const renderer_t *renderer); /* with the scene's values filled in */
/* Bytes held by a renderer, without the scene's own arrays. */
size_t renderer_bytes(const renderer_t *renderer);

typedef enum work_kind {
    WORK_PILOT = 1,    /* candidates for seeds: independent samples of all lengths, with their weights */
    WORK_CHAINS = 2,   /* Markov chains of one length or of all, each from its seed */
    WORK_SAMPLES = 3,  /* independent pt or bdpt samples of all lengths */
    WORK_FEATURES = 4, /* albedo, normal and depth of pixel rows */
    WORK_REFINE = 5,   /* independent samples of all lengths for the estimates of b_k alone */
    WORK_TRIAL = 6,    /* Markov chains as in WORK_CHAINS, for what they differ by alone (trial.c) */
    WORK_LEFT_OUT = 7, /* independent samples of all light, for the energy of what the job leaves out */
    WORK_KINDS
} work_kind_t;

enum {
    WORK_MAX_CHAINS = 65536,
    WORK_MAX_CANDIDATES = 1 << 16,
    WORK_RECORD_MAX_BYTES = 1 << 20,
    WORK_MAX_SKIP = 1 << 20,
    WORK_MAX_SIDE = 16,
    WORK_SEQUENCES = 256,
    WORK_FEATURE_CHANNELS = 7, /* albedo R,G,B, normal X,Y,Z, depth */
    WORK_STEPS = 16,           /* the most that steps are scaled by, as a power of two */
    WORK_REPLICAS = 8,         /* cmlt-rex: chains that exchange */
    WORK_FAILED_SIDE = 8,      /* blocks along the image's sides in which failures are counted */
    WORK_FAILED_BLOCKS = WORK_FAILED_SIDE * WORK_FAILED_SIDE,
    WORK_BLOCKS_SIDE = IMPORTANCE_SIDE, /* blocks in which the pilot adds up its light */
    WORK_BLOCKS = IMPORTANCE_BLOCKS,
    WORK_LEFT_OUT_ALL = SETTINGS_EFFECTS, /* in place of an effect: whatever the job leaves out */
    WORK_LEFT_OUT_MOMENTS = 1 + 2 * (SETTINGS_EFFECTS + 1)
};

/* A pilot's samples from this index on come in pairs, 2 i and 2 i + 1, each pair within one pixel: what two samples
 * of a pixel differ by is the noise of samples that are spread evenly over the pixels. */
#define WORK_PAIRS_FIRST (UINT64_C(1) << 41)

/* The largest index of a point in its sequence. */
#define WORK_MAX_POINT (UINT64_C(1) << 40)

typedef struct work_record {
    uint32_t kind;   /* work_kind_t */
    uint32_t length; /* k: chains and trials; 0: chains of all lengths at once (settings_joins_all), and all else */
    uint64_t first;  /* pilot, refine, samples, left out: index of the first sample; chains: id of the first chain;
                        features: first row */
    uint64_t count;  /* of candidates, samples, chains, or rows */
    uint64_t skip;   /* samples: indices that are passed over from one to the next: a lattice of pixels; else 0 */
    uint32_t side;   /* features: rays a pixel are its square, 1 to WORK_MAX_SIDE squared; else 0 */
    uint32_t sequence;  /* samples: of the pixels' points (net.h), below WORK_SEQUENCES; else 0 */
    uint64_t point;     /* of the first sample in it; passes after that one take those that follow; else 0 */
    uint64_t mutations; /* chains: in all; chain i of the unit makes floor((i+1) m / c) - floor(i m / c) */
    int32_t steps; /* chains and trials: small steps are longer by two to this power, -WORK_STEPS .. WORK_STEPS */
    int32_t large; /* likewise: large steps are as likely as the settings say times two to this power, <= 0 */
    double scale;  /* samples: film value of a contribution of 1; trials: brightness of a splat of 1 of every chain,
                      relative to what is seen around it; else 0 */
    uint64_t *seeds; /* chains: the candidate each starts from, `count` of them; owned by the record */
    double *shares;  /* chains of cmlt and cmlt-ipsm: probabilities of the techniques s = 0 .. k, k + 1 of them that
                        sum to one; else null; owned by the record */
    double *importance; /* all but features and left out: IMPORTANCE_BLOCKS numbers, or null; owned by the record */
    uint32_t cap_count; /* chains: 0 or 1, theirs; pilot, refine, samples: 0 or one for each length from 1 on */
    double *caps;       /* split.h; null if there is none (samples then bring all light); owned by the record */
    uint32_t idle_count; /* likewise: techniques that take no part, of the chains' length or of all */
    target_idle_t *idle;
    uint32_t rate_count; /* samples: 0 or one for each length from 1 on */
    double *rates;       /* cutoff.h; null if all samples are of all lengths; owned by the record */
} work_record_t;

void work_record_clear(work_record_t *record);
fault_code_t work_record_encode(const work_record_t *record, uint8_t **data, size_t *size, fault_t *fault);
/* Checks everything that can be checked without a scene (WORK_MAX_..., lengths). */
fault_code_t work_record_decode(work_record_t *record, const uint8_t *data, size_t size, fault_t *fault);

/* Sums of one estimator: n values, their sum and sum of squares. */
typedef struct work_moments {
    double n, sum, sum2;
} work_moments_t;

/* What any such sums are, of numbers that are not negative. */
static inline bool work_moments_are_sound(const work_moments_t *m)
{
    return m->n >= 0 && m->sum >= 0 && m->sum2 >= 0 && isfinite(m->n + m->sum + m->sum2);
}

/* Adds up `count` of them that are `stride` apart, in their order. */
static inline work_moments_t work_moments_sum(const work_moments_t *first, uint64_t count, size_t stride)
{
    work_moments_t sum = {0, 0, 0};
    for (uint64_t i = 0; i < count; i++, first += stride) {
        sum.n += first->n;
        sum.sum += first->sum;
        sum.sum2 += first->sum2;
    }
    return sum;
}

/* Why a contribution was refused. */
typedef enum work_reject {
    WORK_REJECT_NONFINITE_RAY = 0,
    WORK_REJECT_NONFINITE_WEIGHT,
    WORK_REJECT_NONFINITE_VALUE,
    WORK_REJECT_NEGATIVE_VALUE,
    WORK_REJECTS
} work_reject_t;

typedef enum work_move {
    WORK_MOVE_LARGE = 0,
    WORK_MOVE_SMALL,
    WORK_MOVE_TECHNIQUE,
    WORK_MOVE_JUMP,
    WORK_MOVE_CAMERA, /* small, of the camera's walk alone */
    WORK_MOVE_LIGHT,
    WORK_MOVE_INVERSE,
    WORK_MOVE_EXCHANGE,
    WORK_MOVE_AUXILIARY,
    WORK_MOVE_SECOND, /* after a failed step: not a mutation of its own */
    WORK_MOVES
} work_move_t;

typedef struct work_stats {
    double cpu_seconds;
    /* Of them: in Embree, and from paths back to numbers; both from a sample of the calls (stamp.h). */
    double tracing_seconds, inversion_seconds;
    /* Of the worker's thread before this unit: packing the last result, and without a unit. Its to fill in. */
    double merging_seconds, waiting_seconds;
    uint64_t rays, shadow_rays;
    uint64_t evaluations; /* of the target, or samples */
    uint64_t rejects[WORK_REJECTS];
    uint64_t proposed[WORK_MOVES];
    double accepted[WORK_MOVES]; /* sum of acceptance probabilities */
    uint64_t zero_proposals;     /* proposals without contribution */
    uint64_t longest_stay;       /* rejections in a row, the most */
} work_stats_t;

typedef struct work_result {
    uint32_t kind, length;
    work_stats_t stats;
    /* Estimators. Chains (their large steps) of length k: [0] the length's b_k (technique factor included), [1 + s]
     * the part of technique s. Pilot, refine, samples, chains of all lengths: for each length k = 1..K, 1 + (k+1)
     * such entries in a row. Left out: [0] all light, [1 + 2 e] that of effect e (settings_effect_t, or
     * WORK_LEFT_OUT_ALL: whatever the job leaves out), [2 + 2 e] the rest. */
    uint32_t moment_count;
    work_moments_t *moments;
    stuck_t stuck;         /* chains */
    uint32_t weight_count; /* pilot: K for each candidate: the sum of C_s over the techniques of length k = 1..K;
                              then K x WORK_BLOCKS: their sums over candidates by length and block of the image;
                              then K: the rays that paths of each length take beyond those of shorter ones */
    double *weights;
    uint64_t *failed; /* chains with failures = published: proposals without contribution by block of the image,
                         WORK_FAILED_BLOCKS of them; else null */
    double spread;    /* trial: how much the chains' films differ, see trial.c */
    bool has_film;    /* chains, samples */
    film_t film;
    uint32_t feature_rows, feature_width; /* features: WORK_FEATURE_CHANNELS floats a pixel */
    float *features;
} work_result_t;

/* Doubles in weights[] of a pilot's unit. */
static inline size_t work_pilot_weights(uint64_t count, uint32_t max_path_length)
{
    return (size_t)(count + WORK_BLOCKS + 1) * max_path_length;
}

/* Chains that run together: those that exchange, or one. */
static inline uint32_t work_together(settings_algorithm_t algorithm)
{
    return algorithm == SETTINGS_CMLT_REX ? WORK_REPLICAS : 1;
}

/* Whether a unit runs chains. */
static inline bool work_runs_chains(uint32_t kind)
{
    return kind == WORK_CHAINS || kind == WORK_TRIAL;
}

/* Index of moments[] where length k starts, in a result for all lengths. */
static inline uint32_t work_samples_moment(uint32_t k)
{
    return (k - 1) * (k + 4) / 2; /* sum over j < k of (j + 2) */
}

fault_code_t work_space_new(work_space_t **out, const renderer_t *renderer, fault_t *fault);
void work_space_destroy(work_space_t **space);

/* Runs a unit. FAULT_CANCELLED soon after *cancel becomes true; FAULT_RANGE if the record does not fit the scene.
 * The result's arrays belong to the space and are valid until its next run. */
fault_code_t work_run(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                      work_result_t *result, fault_t *fault);

/* The result as bytes; *data is the caller's to free(). */
fault_code_t work_result_encode(const work_result_t *result, uint8_t **data, size_t *size, fault_t *fault);
/* Decodes hostile bytes into a result that owns its arrays; film size and array lengths must be what the record
 * asks for. Clear it with work_result_clear. `spare`: null, or a film of that size or none: a result that has a
 * film takes it and leaves none, as making and zeroing a new one costs as much as all else. */
fault_code_t work_result_decode(work_result_t *result, const work_record_t *record, uint32_t width, uint32_t height,
                                uint32_t max_path_length, film_t *spare, const uint8_t *data, size_t size,
                                fault_t *fault);
void work_result_clear(work_result_t *result);

#endif
