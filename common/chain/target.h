/* target.h: the function that chains of one path length walk on: (technique, numbers) -> contribution.
 *
 * C_s(u) = w_s f* / p_s for the path x = S_s(u) (docs/transport.md): f* is luminance or the largest channel.
 * Each length has a list of its techniques; a technique is addressed by s. */
#ifndef CHAIN_TARGET_H
#define CHAIN_TARGET_H

#include "chain/importance.h"
#include "chain/settings.h"
#include "chain/split.h"
#include "path/connect.h"

/* The state space of one length: its techniques and the sizes of its streams. */
typedef struct target {
    const path_scene_t *scene;
    uint32_t length; /* k */
    settings_target_t kind;
    importance_t importance;
    double cap;                      /* what independent samples bring of each path (split.h); 0: nothing */
    uint32_t count;                  /* n_k: techniques that take part */
    uint8_t list[PATH_MAX_VERTICES]; /* their s */
    path_techniques_t techniques;
    uint32_t camera_count, light_count; /* numbers that any technique of the length may use */
} target_t;

typedef struct target_value {
    double c;    /* C_s(u), times the importance, less the cap; 0 if that leaves nothing */
    rgb_t color; /* what a splat of weight 1 adds */
    vec2_t raster;
} target_value_t;

/* Technique s takes part in length k if the algorithm has it and the lights can be reached by it. */
void target_init(target_t *target, const path_scene_t *scene, const settings_t *settings, uint32_t length);

/* Techniques that take no part, one bit each: s is bit s % 64 of word s / 64. */
typedef struct target_idle {
    uint64_t words[2];
} target_idle_t;

static inline bool target_is_idle(const target_idle_t *idle, uint32_t s)
{
    return idle->words[s / 64] >> (s % 64) & 1;
}

/* Takes techniques out of the state space and the weights. What only they can make is lost with them: whoever
 * chooses them sees to it that there is no such path. */
void target_leave(target_t *target, const target_idle_t *idle);

/* An evaluation in its parts: two walks, the shorter one first, and the connection. Where the first walk ends on
 * nothing that can be joined, neither the longer one nor its numbers need be made. */
static inline bool target_light_first(const target_t *target, uint32_t s)
{
    return s > 0 && 2 * s < target->length + 1;
}
/* Walks of technique s; false if the path carries nothing. target_walk_light is for s > 0. */
bool target_walk_camera(const target_t *target, path_space_t *space, uint32_t s, const double *camera);
bool target_walk_light(const target_t *target, path_space_t *space, uint32_t s, const double *light);
/* Joins the two walks of the space. */
void target_join(const target_t *target, path_space_t *space, uint32_t s, target_value_t *out);

/* All of it: technique s with the camera's and the light's numbers. */
void target_eval(const target_t *target, path_space_t *space, uint32_t s, const double *camera, const double *light,
                 target_value_t *out);

static inline double target_scalar(settings_target_t kind, rgb_t value)
{
    return kind == SETTINGS_TARGET_LUMINANCE ? rgb_luminance(value) : rgb_max(value);
}

/* The target's value of a joined path; false if it carries nothing. */
static inline bool target_value_of(const target_t *target, const path_value_t *path, target_value_t *out)
{
    double c = target_scalar(target->kind, path->value);
    if (target->importance.blocks)
        c *= importance_at(&target->importance, path->raster);
    out->c = 0;
    const double excess = split_excess(c, target->cap);
    if (!(excess > 0))
        return false; /* nothing is left for chains, or underflow */
    out->c = excess;
    out->color = rgb_scale(path->value, 1 / c); /* (f excess / c) / excess */
    out->raster = path->raster;
    return true;
}

#endif
