/* effects.h: what a scene has of the effects that a render can simulate, and what follows from each.
 *
 *     effects_t effects;
 *     effects_analyse(&effects, scene, &settings);
 *     ... effects.list[EFFECT_CAUSTICS].present, .reason ...
 *
 * A function of scene and settings alone: nothing is traced. Only what shapes refer to counts: a material, texture
 * or area light that no shape has is not there, nor is a light that radiates nothing. What is said to be absent
 * cannot occur; what is said to be present may still bring no light (a lamp behind a wall). Meanings:
 * docs/effects.md.
 */
#ifndef PLAN_EFFECTS_H
#define PLAN_EFFECTS_H

#include <stdbool.h>

#include "base/fault.h"
#include "base/json.h"
#include "chain/settings.h"
#include "scene/scene.h"

typedef enum effect_kind {
    EFFECT_DIFFUSE = 0,
    EFFECT_DIFFUSE_TRANSMISSION,
    EFFECT_GLOSSY, /* rough microfacets, reflecting or refracting */
    EFFECT_SPECULAR_REFLECTION,
    EFFECT_SPECULAR_TRANSMISSION,
    EFFECT_CAUSTICS,
    EFFECT_AREA_LIGHTS,
    EFFECT_POINT_LIGHTS,
    EFFECT_SPOT_LIGHTS,
    EFFECT_DISTANT_LIGHTS,
    EFFECT_ENVIRONMENT,
    EFFECT_APERTURE,
    EFFECT_IMAGE_TEXTURES,
    EFFECT_PROCEDURAL_TEXTURES,
    EFFECT_OPACITY,
    EFFECT_INTERPOLATED_NORMALS,
    EFFECT_PIXEL_FILTER,   /* one that reaches beyond its pixel */
    EFFECT_INDIRECT,       /* paths of more than two segments */
    EFFECT_EMISSION,       /* paths of one segment */
    EFFECT_LENS_HITS,      /* the technique t = 0 */
    EFFECT_ALL_TECHNIQUES, /* those of negligible energy too */
    EFFECT_TECHNIQUE_STEPS,
    EFFECT_JUMPS,
    EFFECT_EXCHANGES,
    EFFECT_INVERSE_STEPS,
    EFFECT_SPLIT,
    EFFECT_IMPORTANCE,
    EFFECT_COUNT
} effect_kind_t;

enum { EFFECT_REASON_SIZE = 112 };

typedef struct effect {
    bool present;          /* the scene and the other settings have it, whatever the job's switch says */
    settings_switch_t set; /* by the job */
    char reason[EFFECT_REASON_SIZE];
} effect_t;

typedef struct effects {
    effect_t list[EFFECT_COUNT]; /* by effect_kind_t */
} effects_t;

/* The scene has passed scene_check; the settings are complete (no zero stands for "the scene's"). */
void effects_analyse(effects_t *out, const scene_t *scene, const settings_t *settings);

/* Refuses settings that insist on an effect which is absent, with the reason. */
fault_code_t effects_check(const scene_t *scene, const settings_t *settings, fault_t *fault);

/* "caustics" */
const char *effects_name(effect_kind_t kind);

/* The effect that a job's switch is of. */
effect_kind_t effects_switched(settings_effect_t effect);

/* Share of the light with its standard error; NaN where they are not known. */
typedef struct effect_energy {
    double share, error;
} effect_energy_t;

/* The report's list (docs/reports.md). energy[kind]; null: of none. */
json_t *effects_json(const effects_t *effects, const effect_energy_t *energy);

#endif
