#include "plan/techniques.h"

#include "plan/effects.h"

/* Moves that need a second technique to go to, and are asked for. */
static bool techniques_are_moved_between(const settings_t *settings)
{
    switch (settings->algorithm) {
    case SETTINGS_RJMLT:
    case SETTINGS_CMLT:
    case SETTINGS_CMLT_REX:
        return settings->jump_step > 0;
    case SETTINGS_CMLT_IPSM:
        return true;
    default:
        return false;
    }
}

fault_code_t techniques_check(const scene_t *scene, const settings_t *settings, bool automatic, fault_t *fault)
{
    effects_t effects;
    effects_analyse(&effects, scene, settings);
    const effect_t *list = effects.list;
    const bool hit = list[EFFECT_AREA_LIGHTS].present ||
                     (list[EFFECT_ENVIRONMENT].present && !settings_forbids(settings, SETTINGS_ENVIRONMENT)),
               seen = hit && !settings_forbids(settings, SETTINGS_EMISSION),
               joined = list[EFFECT_DIFFUSE].present || list[EFFECT_DIFFUSE_TRANSMISSION].present ||
                        list[EFFECT_GLOSSY].present,
               longer = settings->max_path_length > 1 && (joined || hit);
    if (!seen && settings->max_path_length == 1)
        return fault_set(fault, FAULT_NO_LIGHT, "max_path_length: 1, but %s; expected 2 or more",
                         hit ? "effects.emission is \"off\"" : "no light has an extent, to be seen itself");
    if (!seen && !longer)
        return fault_set(fault, FAULT_NO_LIGHT,
                         "scene: every surface is specular, and no light %s an extent: no path can arrive at one; "
                         "expected a surface that is diffuse or glossy, or an area or infinite light",
                         list[EFFECT_ENVIRONMENT].present ? "that is not off has" : "has");
    if (!automatic && techniques_are_moved_between(settings) && settings->max_path_length > 1 && !joined)
        return fault_set(
            fault, FAULT_UNSUPPORTED,
            "algorithm: \"%s\" moves between the techniques of a path, but here every surface is "
            "specular, so that paths of two and more segments have one only (s = 0); expected \"mmlt\", "
            "\"pssmlt\", \"bdpt\", \"pt\" or \"auto\"",
            settings_algorithm_name(settings->algorithm));
    return FAULT_NONE;
}
