/* unit.h: what the kinds of work share inside this folder: a thread's space, and the renderer behind it. */
#ifndef CHAIN_UNIT_H
#define CHAIN_UNIT_H

#include "base/random.h"
#include "chain/kernel.h"
#include "chain/target.h"
#include "chain/work.h"

struct renderer {
    path_scene_t scene;
    settings_t settings; /* complete: width, height, max_path_length filled in */
    target_t *targets;   /* [max_path_length + 1], by length; [0] unused */
    kernel_t kernel;
};

/* What the state of a Markov chain is kept in: its numbers and its walks. */
typedef struct chain_room {
    double camera[PATH_MAX_DIMENSIONS], light[PATH_MAX_DIMENSIONS];
    path_space_t *kept;
} chain_room_t;

struct work_space {
    const renderer_t *renderer;
    path_space_t path; /* the walks of the sample or proposal at hand */
    stamp_meter_t inversion;
    kernel_t kernel;         /* of the unit at hand */
    const target_t *targets; /* of the unit at hand: the renderer's, or `idle` */
    target_t *idle;          /* room for them without techniques that take no part */
    uint32_t light_vertices; /* that any technique of theirs takes from a light */
    double camera[PATH_MAX_DIMENSIONS], light[PATH_MAX_DIMENSIONS]; /* their numbers */
    chain_room_t *rooms;                                            /* for chains that run together */
    uint32_t room_count;
    uint64_t failed[WORK_FAILED_BLOCKS]; /* failures = published */
    film_t film;                         /* made when first needed */
    work_moments_t *moments;             /* room for every length and technique */
    uint32_t moment_room;
    double *weights; /* grown when needed */
    size_t weight_room;
    float *features;
    size_t feature_room;
    double *tally; /* two numbers for each pixel, made when first needed */
};

/* One file each. They fill result's estimators, film and counts; the frame around them (work.c) does the rest. */
fault_code_t unit_pilot(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                        work_result_t *result, fault_t *fault);
fault_code_t unit_chains(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                         work_result_t *result, fault_t *fault);
fault_code_t unit_samples(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                          work_result_t *result, fault_t *fault);
fault_code_t unit_features(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                           work_result_t *result, fault_t *fault);

fault_code_t unit_trial(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                        work_result_t *result, fault_t *fault);

/* The chains of a unit, those that exchange together; `done` is called after each such run if it is not null. */
typedef void (*unit_done_t)(void *context);
fault_code_t unit_run_chains(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                             unit_done_t done, void *context, work_result_t *result, fault_t *fault);

fault_code_t unit_refine(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                         work_result_t *result, fault_t *fault);
fault_code_t unit_left_out(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                           work_result_t *result, fault_t *fault);

/* Chains of all lengths at once (bundle.h): what unit_chains is for settings_joins_all. */
fault_code_t unit_bundle(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                         work_result_t *result, fault_t *fault);

/* The key of a pilot's candidate. */
uint64_t unit_pilot_key(const renderer_t *renderer, uint64_t index);

/* Makes a pilot's candidate again as the state of a chain of the target's length: its numbers into space->camera
 * and space->light, its technique by `place` in [0,1). False if the candidate carries nothing of that length. */
bool unit_seed(work_space_t *space, const target_t *target, uint64_t candidate, double place, uint32_t *technique);

/* The block of the image that a raster position is in, of side x side blocks, by rows. */
static inline uint32_t unit_block(const settings_t *settings, vec2_t raster, uint32_t side)
{
    const double x = raster.x / settings->width * side, y = raster.y / settings->height * side;
    const uint32_t i = x > 0 ? (uint32_t)x : 0, j = y > 0 ? (uint32_t)y : 0, last = side - 1;
    return (j < last ? j : last) * side + (i < last ? i : last);
}

/* The record's importance. */
static inline importance_t unit_importance(const work_space_t *space, const work_record_t *record)
{
    const settings_t *settings = &space->renderer->settings;
    return (importance_t){record->importance, settings->width, settings->height};
}

/* The cap of a unit's chains. */
static inline double unit_cap(const work_record_t *record)
{
    return record->cap_count > 0 ? record->caps[0] : 0;
}

/* The film of the space, zeroed. */
fault_code_t unit_film(work_space_t *space, fault_t *fault);

static inline void unit_moment(work_moments_t *moment, double value)
{
    moment->sum += value;
    moment->sum2 += value * value;
}

/* Dimensions of a step's stream of random numbers: decisions first, then the two streams of the state. */
enum {
    UNIT_DRAW_MOVE = 0,
    UNIT_DRAW_ACCEPT = 1,
    UNIT_DRAW_FILTER = 2, /* 4 of them: two splats; in a chain's step the two after the decision */
    UNIT_DRAW_SEED = 8,   /* the technique a chain starts with */
    UNIT_DRAW_TECHNIQUE = 9,
    UNIT_DRAW_STREAM = 10, /* which walk changes */
    UNIT_DRAW_WINDOW = 11,
    UNIT_DRAW_SECOND_ACCEPT = 12, /* and the two after it */
    UNIT_DRAW_CUTOFF = 15,        /* samples: how far they go */
    UNIT_DRAW_CAMERA = 16,
    UNIT_DRAW_LIGHT = 1024,
    UNIT_DRAW_NEXT_EVENT = 2048, /* independent samples: 3 for each camera vertex */
    UNIT_DRAW_SECOND = 3072,     /* the numbers of a second proposal */
    UNIT_DRAW_FREE = 4096,       /* streams of their own: what inverses leave free, */
    UNIT_DRAW_AUXILIARY = 4100   /* an auxiliary chain's step */
};

/* Splats value at the raster position, moved by a sample of the pixel filter and weighted by what that leaves. */
static inline void unit_splat(const path_scene_t *scene, film_t *film, vec2_t raster, rgb_t value, uint64_t key,
                              uint64_t draw)
{
    if (!scene->camera.filter_is_box) {
        const vec2_t offset =
            camera_filter_offset(&scene->camera, random_double(key, draw), random_double(key, draw + 1));
        value = rgb_scale(value, camera_filter_weight(&scene->camera, raster));
        raster.x += offset.x;
        raster.y += offset.y;
    }
    film_splat(film, raster.x, raster.y, value);
}

#endif
