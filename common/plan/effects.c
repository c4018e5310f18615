/* effects.c: one look at every record that shapes refer to. */
#include "plan/effects.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

typedef struct effect_words {
    const char *name, *with, *without; /* consequences */
} effect_words_t;

static const effect_words_t words[EFFECT_COUNT] = {
    [EFFECT_DIFFUSE] = {"diffuse", "vertices that can be connected", "no Lambertian lobe is made"},
    [EFFECT_DIFFUSE_TRANSMISSION] = {"diffuse_transmission", "walks may go on behind a surface",
                                     "no such lobe is made"},
    [EFFECT_GLOSSY] = {"glossy", "microfacet lobes are sampled and evaluated", "no microfacets are evaluated"},
    [EFFECT_SPECULAR_REFLECTION] = {"specular_reflection", "such vertices are not connected, walks go on",
                                    "no vertex is excepted from connections for it"},
    [EFFECT_SPECULAR_TRANSMISSION] = {"specular_transmission", "such vertices are not connected, walks go on",
                                      "no refraction is followed"},
    [EFFECT_CAUSTICS] = {"caustics", "some light arrives only by walks through specular or glossy vertices",
                         "no light is focused onto diffuse surfaces"},
    [EFFECT_AREA_LIGHTS] = {"area_lights", "walks can hit a light (s = 0)", "no walk can hit a lit surface"},
    [EFFECT_POINT_LIGHTS] = {"point_lights", "in the table of lights; no walk can hit them",
                             "not in the table of lights"},
    [EFFECT_SPOT_LIGHTS] = {"spot_lights", "in the table of lights; no walk can hit them",
                            "not in the table of lights"},
    [EFFECT_DISTANT_LIGHTS] = {"distant_lights", "in the table of lights; no walk can hit them",
                               "not in the table of lights"},
    [EFFECT_ENVIRONMENT] = {"environment", "walks that leave the scene find light (s = 0)",
                            "walks that leave the scene end without light"},
    [EFFECT_APERTURE] = {"aperture", "camera paths begin on the lens", "camera paths begin in one point"},
    [EFFECT_IMAGE_TEXTURES] = {"image_textures", "their materials are resolved at every hit",
                               "no texel is looked up"},
    [EFFECT_PROCEDURAL_TEXTURES] = {"procedural_textures", "their materials are resolved at every hit",
                                    "no pattern is evaluated"},
    [EFFECT_OPACITY] = {"opacity", "hits on such shapes are tested", "the first hit of a ray counts"},
    [EFFECT_INTERPOLATED_NORMALS] = {"interpolated_normals", "shading and geometric normals differ",
                                     "meshes shade by their geometric normal"},
    [EFFECT_PIXEL_FILTER] = {"pixel_filter", "a sample may lie in a neighbouring pixel's support",
                             "a sample is of its pixel alone"},
    [EFFECT_INDIRECT] = {"indirect", "paths of three and more segments are made", "only light that is direct"},
    [EFFECT_EMISSION] = {"emission", "lights are seen themselves", "no light is seen itself"},
    [EFFECT_LENS_HITS] = {"lens_hits", "", "the technique t = 0 is no part of weights or states"},
    [EFFECT_ALL_TECHNIQUES] = {"all_techniques", "weights and states have them all",
                               "the others' weights make up for those that are left out"},
    [EFFECT_TECHNIQUE_STEPS] = {"technique_steps", "small steps may draw the technique anew", "none are proposed"},
    [EFFECT_JUMPS] = {"jumps", "chains change technique at the same path", "no path is inverted for a jump"},
    [EFFECT_EXCHANGES] = {"exchanges", "chains of neighbouring techniques swap states", "none are proposed"},
    [EFFECT_INVERSE_STEPS] = {"inverse_steps", "paths are moved in the space of another technique",
                              "none are proposed"},
    [EFFECT_SPLIT] = {"split", "samples bring what they sample well, chains the rest",
                      "one estimator brings all light"},
    [EFFECT_IMPORTANCE] = {"importance", "dark parts of the image get more mutations",
                           "mutations go where the light is"}};

static const effect_kind_t switched[SETTINGS_EFFECTS] = {
    [SETTINGS_CAUSTICS] = EFFECT_CAUSTICS, [SETTINGS_ENVIRONMENT] = EFFECT_ENVIRONMENT,
    [SETTINGS_APERTURE] = EFFECT_APERTURE, [SETTINGS_INDIRECT] = EFFECT_INDIRECT,
    [SETTINGS_EMISSION] = EFFECT_EMISSION, [SETTINGS_ALL_TECHNIQUES] = EFFECT_ALL_TECHNIQUES};

/* What is found before it is put in words: how many records of each. */
typedef struct facts {
    uint32_t counts[EFFECT_COUNT];
    uint8_t materials[SCENE_MAX_MATERIALS], textures[SCENE_MAX_TEXTURES]; /* 1: referred to */
} facts_t;

const char *effects_name(effect_kind_t kind)
{
    return words[kind].name;
}

static bool is_dark(const float value[3])
{
    return value[0] == 0 && value[1] == 0 && value[2] == 0;
}

static void facts_add_param(facts_t *facts, const scene_param_t *param)
{
    if (param->texture != SCENE_NONE)
        facts->textures[param->texture] = 1;
}

/* A lobe of this roughness: specular, glossy, or, if it is textured, maybe either. */
static void facts_add_roughness(facts_t *facts, const scene_param_t *u, const scene_param_t *v, bool transmits)
{
    const bool textured = u->texture != SCENE_NONE || v->texture != SCENE_NONE,
               smooth = u->value[0] < SCENE_ALPHA_SMOOTH && v->value[0] < SCENE_ALPHA_SMOOTH;
    facts_add_param(facts, u);
    facts_add_param(facts, v);
    facts->counts[EFFECT_GLOSSY] += textured || !smooth;
    facts->counts[EFFECT_SPECULAR_REFLECTION] += textured || smooth;
    facts->counts[EFFECT_SPECULAR_TRANSMISSION] += transmits && (textured || smooth);
}

static void facts_add_lambert(facts_t *facts, const scene_param_t *param, effect_kind_t kind)
{
    facts_add_param(facts, param);
    facts->counts[kind] += !is_dark(param->value);
}

static void facts_add_material(facts_t *facts, const scene_material_t *m)
{
    switch ((scene_material_kind_t)m->kind) {
    case SCENE_MATERIAL_DIFFUSE:
        facts_add_lambert(facts, &m->reflectance, EFFECT_DIFFUSE);
        break;
    case SCENE_MATERIAL_COATED_DIFFUSE:
        facts_add_lambert(facts, &m->reflectance, EFFECT_DIFFUSE);
        facts_add_roughness(facts, &m->coat_alpha_u, &m->coat_alpha_v, false);
        break;
    case SCENE_MATERIAL_CONDUCTOR:
        facts_add_roughness(facts, &m->alpha_u, &m->alpha_v, false);
        break;
    case SCENE_MATERIAL_COATED_CONDUCTOR:
        facts_add_roughness(facts, &m->alpha_u, &m->alpha_v, false);
        facts_add_roughness(facts, &m->coat_alpha_u, &m->coat_alpha_v, false);
        break;
    case SCENE_MATERIAL_DIELECTRIC:
        facts_add_roughness(facts, &m->alpha_u, &m->alpha_v, true);
        break;
    case SCENE_MATERIAL_THIN_DIELECTRIC:
        facts->counts[EFFECT_SPECULAR_REFLECTION]++;
        facts->counts[EFFECT_SPECULAR_TRANSMISSION]++;
        break;
    case SCENE_MATERIAL_DIFFUSE_TRANSMISSION:
        facts_add_lambert(facts, &m->reflectance, EFFECT_DIFFUSE);
        facts_add_lambert(facts, &m->transmittance, EFFECT_DIFFUSE_TRANSMISSION);
        break;
    case SCENE_MATERIAL_MIX:
        facts_add_param(facts, &m->mix);
        facts->materials[m->first] = facts->materials[m->second] = 1; /* both below this one's index */
        break;
    case SCENE_MATERIAL_INTERFACE: /* in a mix: what light passes straight through */
    case SCENE_MATERIAL_KINDS:
        break;
    }
}

static void facts_add_shapes(facts_t *facts, const scene_t *scene)
{
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const scene_shape_t *shape = &scene->shapes[i];
        if (scene->materials[shape->material].kind == SCENE_MATERIAL_INTERFACE)
            continue;
        facts->materials[shape->material] = 1;
        facts_add_param(facts, &shape->alpha);
        facts->counts[EFFECT_OPACITY] += shape->area_light == SCENE_NONE && /* what radiates is opaque */
                                         (shape->alpha.texture != SCENE_NONE || shape->alpha.value[0] < 1);
        facts->counts[EFFECT_INTERPOLATED_NORMALS] += (shape->flags & SCENE_SHAPE_NORMALS) != 0;
        facts->counts[EFFECT_AREA_LIGHTS] +=
            shape->area_light != SCENE_NONE && !is_dark(scene->lights[shape->area_light].radiance);
    }
}

static void facts_add_textures(facts_t *facts, const scene_t *scene)
{
    for (uint32_t i = scene->texture_count; i-- > 0;) {
        if (!facts->textures[i])
            continue;
        const scene_texture_t *texture = &scene->textures[i];
        if (texture->kind == SCENE_TEXTURE_IMAGE) {
            facts->counts[EFFECT_IMAGE_TEXTURES]++;
        } else if (texture->kind != SCENE_TEXTURE_CONSTANT) {
            facts->counts[EFFECT_PROCEDURAL_TEXTURES]++;
            facts_add_param(facts, &texture->a);
            facts_add_param(facts, &texture->b);
            facts_add_param(facts, &texture->m);
        }
    }
}

static void facts_add_lights(facts_t *facts, const scene_t *scene)
{
    static const effect_kind_t kinds[SCENE_LIGHT_KINDS] = {[SCENE_LIGHT_INFINITE] = EFFECT_ENVIRONMENT,
                                                           [SCENE_LIGHT_DISTANT] = EFFECT_DISTANT_LIGHTS,
                                                           [SCENE_LIGHT_POINT] = EFFECT_POINT_LIGHTS,
                                                           [SCENE_LIGHT_SPOT] = EFFECT_SPOT_LIGHTS};
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].kind != SCENE_LIGHT_AREA) /* those count by their shapes */
            facts->counts[kinds[scene->lights[i].kind]] += !is_dark(scene->lights[i].radiance);
}

static void say(effects_t *out, effect_kind_t kind, bool present, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
static void say(effects_t *out, effect_kind_t kind, bool present, const char *format, ...)
{
    out->list[kind].present = present;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(out->list[kind].reason, EFFECT_REASON_SIZE, format, arguments);
    va_end(arguments);
}

static void say_count(effects_t *out, const facts_t *facts, effect_kind_t kind, const char *what)
{
    if (facts->counts[kind] > 0)
        say(out, kind, true, "%s: %u", what, facts->counts[kind]);
    else
        say(out, kind, false, "%s: none", what);
}

static void say_caustics(effects_t *out, const facts_t *facts)
{
    const uint32_t *n = facts->counts;
    const bool focus = n[EFFECT_SPECULAR_REFLECTION] || n[EFFECT_SPECULAR_TRANSMISSION] || n[EFFECT_GLOSSY],
               screen = n[EFFECT_DIFFUSE] || n[EFFECT_DIFFUSE_TRANSMISSION];
    say(out, EFFECT_CAUSTICS, focus && screen, "%s",
        !focus    ? "nothing is specular or glossy"
        : !screen ? "nothing is diffuse"
                  : "specular or glossy materials beside diffuse ones");
}

static void say_camera(effects_t *out, const scene_camera_t *camera, const settings_t *settings)
{
    const int filter = settings->filter < 0 ? (int)camera->filter : settings->filter;
    say(out, EFFECT_APERTURE, camera->lens_radius > 0, "the lens' radius is %g", camera->lens_radius);
    say(out, EFFECT_PIXEL_FILTER, filter != SCENE_FILTER_BOX, "the filter is %s",
        filter == SCENE_FILTER_BOX        ? "a box"
        : filter == SCENE_FILTER_TRIANGLE ? "a triangle"
                                          : "a Gaussian");
    say(out, EFFECT_LENS_HITS, false,
        "walks from lights are connected to the lens, which they do not hit by chance");
}

static void say_emission(effects_t *out, const facts_t *facts)
{
    const bool seen = facts->counts[EFFECT_AREA_LIGHTS] > 0 || facts->counts[EFFECT_ENVIRONMENT] > 0;
    say(out, EFFECT_EMISSION, seen, "lights with an extent: %s", seen ? "some" : "none");
}

static void say_moves(effects_t *out, const settings_t *s)
{
    const settings_algorithm_t a = s->algorithm;
    const char *name = settings_algorithm_name(a);
    const bool chains = settings_is_chains(a);
    if (settings_forbids(s, SETTINGS_INDIRECT))
        say(out, EFFECT_INDIRECT, true, "the job asks for direct light");
    else
        say(out, EFFECT_INDIRECT, s->max_path_length > 2, "paths have at most %u segments", s->max_path_length);
    say(out, EFFECT_ALL_TECHNIQUES, true, "%s", settings_is_chains(a) ? "none is known to be negligible" : name);
    say(out, EFFECT_TECHNIQUE_STEPS, a == SETTINGS_MMLT && s->technique_step > 0, "%s, chains.technique_step = %g",
        name, s->technique_step);
    say(out, EFFECT_JUMPS, settings_jumps(a) && s->jump_step > 0, "%s, chains.jump_step = %g", name, s->jump_step);
    say(out, EFFECT_EXCHANGES, a == SETTINGS_CMLT_REX && s->jump_step > 0, "%s, chains.jump_step = %g", name,
        s->jump_step);
    say(out, EFFECT_INVERSE_STEPS, a == SETTINGS_CMLT_IPSM, "the algorithm is %s", name);
    say(out, EFFECT_SPLIT, chains && !settings_joins_all(a) && s->split > 0, "%s, chains.split = %g", name,
        s->split);
    say(out, EFFECT_IMPORTANCE, chains && s->equalize > 0, "%s, chains.equalize = %g", name, s->equalize);
}

void effects_analyse(effects_t *out, const scene_t *scene, const settings_t *settings)
{
    facts_t facts = {0};
    facts_add_shapes(&facts, scene);
    for (uint32_t i = scene->material_count; i-- > 0;)
        if (facts.materials[i])
            facts_add_material(&facts, &scene->materials[i]);
    facts_add_textures(&facts, scene);
    facts_add_lights(&facts, scene);
    memset(out, 0, sizeof *out);
    say_count(out, &facts, EFFECT_DIFFUSE, "materials with a Lambertian lobe");
    say_count(out, &facts, EFFECT_DIFFUSE_TRANSMISSION, "materials that let light through diffusely");
    say_count(out, &facts, EFFECT_GLOSSY, "rough microfacet surfaces");
    say_count(out, &facts, EFFECT_SPECULAR_REFLECTION, "surfaces that mirror");
    say_count(out, &facts, EFFECT_SPECULAR_TRANSMISSION, "surfaces that refract or pass sharply");
    say_count(out, &facts, EFFECT_AREA_LIGHTS, "shapes that radiate");
    say_count(out, &facts, EFFECT_POINT_LIGHTS, "point lights");
    say_count(out, &facts, EFFECT_SPOT_LIGHTS, "spot lights");
    say_count(out, &facts, EFFECT_DISTANT_LIGHTS, "distant lights");
    say_count(out, &facts, EFFECT_ENVIRONMENT, "infinite lights");
    say_count(out, &facts, EFFECT_IMAGE_TEXTURES, "image textures in use");
    say_count(out, &facts, EFFECT_PROCEDURAL_TEXTURES, "checkerboards, mixtures, products in use");
    say_count(out, &facts, EFFECT_OPACITY, "shapes with opacity below one");
    say_count(out, &facts, EFFECT_INTERPOLATED_NORMALS, "meshes with vertex normals");
    say_caustics(out, &facts);
    say_camera(out, scene->camera, settings);
    say_emission(out, &facts);
    say_moves(out, settings);
    for (int i = 0; i < SETTINGS_EFFECTS; i++)
        out->list[switched[i]].set = (settings_switch_t)settings->effects[i];
}

fault_code_t effects_check(const scene_t *scene, const settings_t *settings, fault_t *fault)
{
    effects_t effects;
    effects_analyse(&effects, scene, settings);
    for (int i = 0; i < SETTINGS_EFFECTS; i++) {
        const effect_t *effect = &effects.list[switched[i]];
        if (effect->set == SETTINGS_SWITCH_ON && !effect->present)
            return fault_set(fault, FAULT_UNSUPPORTED, "effects.%s: \"on\", but it is absent (%s)",
                             words[switched[i]].name, effect->reason);
    }
    return FAULT_NONE;
}

effect_kind_t effects_switched(settings_effect_t effect)
{
    return switched[effect];
}

/* A switch says nothing of what is absent anyway. */
static const char *effect_state(const effect_t *effect)
{
    return !effect->present                     ? "absent"
           : effect->set == SETTINGS_SWITCH_ON  ? "forced"
           : effect->set == SETTINGS_SWITCH_OFF ? "forbidden"
                                                : "present";
}

json_t *effects_json(const effects_t *effects, const effect_energy_t *energy)
{
    json_t *list = json_new_array();
    for (int kind = 0; kind < EFFECT_COUNT; kind++) {
        const effect_t *effect = &effects->list[kind];
        const bool known = energy && effect->present, forbidden = effect->set == SETTINGS_SWITCH_OFF;
        json_t *object = json_new_object();
        json_add_string(object, "name", words[kind].name);
        json_add_string(object, "state", effect_state(effect));
        json_add_string(object, "reason", effect->reason);
        json_add_number(object, "energy", known ? energy[kind].share : (double)NAN);
        json_add_number(object, "energy_error", known ? energy[kind].error : (double)NAN);
        json_add_string(object, "consequence",
                        !effect->present ? words[kind].without
                        : forbidden      ? "the image lacks it, because the job says so"
                                         : words[kind].with);
        json_append(list, object);
    }
    return list;
}
