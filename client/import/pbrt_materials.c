#include "client/import/pbrt_materials.h"

#include <stdio.h>
#include <string.h>

#include "client/import/pbrt_textures.h"

typedef struct maker {
    pbrt_state_t *state;
    pbrt_params_t *params;
    scene_material_t *m;
} maker_t;

/* Indices of refraction that are not vacuum's limit; conductors' tables come close to it. */
#define LEAST_INDEX 1e-3

static void set(scene_param_t *param, double value)
{
    *param = (scene_param_t){{(float)value, (float)value, (float)value}, SCENE_NONE};
}

static fault_code_t reflectance(maker_t *k, const char *name, double absent, scene_param_t *out)
{
    bool given;
    return pbrt_color_param(k->state, k->params, name, absent, out, &given);
}

/* pbrt's remapping: alpha = sqrt(roughness). */
static void remap(scene_param_t *param)
{
    if (param->texture < 0)
        set(param, sqrt((double)param->value[0]));
}

/* `prefix`roughness gives both, `prefix`uroughness and `prefix`vroughness each its own. */
static fault_code_t roughness(maker_t *k, const char *prefix, bool remapped, scene_param_t *u, scene_param_t *v)
{
    char name[64];
    bool given;
    scene_param_t both;
    snprintf(name, sizeof name, "%sroughness", prefix);
    TRY(pbrt_scalar_param(k->state, k->params, name, 0, &both, &given));
    snprintf(name, sizeof name, "%suroughness", prefix);
    TRY(pbrt_scalar_param(k->state, k->params, name, 0, u, &given));
    if (!given)
        *u = both;
    snprintf(name, sizeof name, "%svroughness", prefix);
    TRY(pbrt_scalar_param(k->state, k->params, name, 0, v, &given));
    if (!given)
        *v = both;
    if (remapped) {
        remap(u);
        remap(v);
    }
    return FAULT_NONE;
}

static fault_code_t remaproughness(maker_t *k, bool *remapped)
{
    *remapped = true;
    PBRT_TRY(k->state, k->params, pbrt_params_bool(k->params, "remaproughness", remapped, k->state->fault));
    k->m->remap_roughness = *remapped;
    return FAULT_NONE;
}

/* What goes on inside a coat beyond refraction and reflection: pbrt's random walk has a medium; here there is none.
 */
static fault_code_t coat_inside(maker_t *k)
{
    static const char *const silent[] = {"maxdepth", "nsamples", "thickness"};
    double g = 0;
    bool given;
    scene_param_t albedo;
    for (size_t i = 0; i < sizeof silent / sizeof *silent; i++)
        pbrt_params_ignore(k->params, silent[i]);
    PBRT_TRY(k->state, k->params, pbrt_params_float(k->params, "g", -1, 1, &g, k->state->fault));
    TRY(pbrt_color_param(k->state, k->params, "albedo", 0, &albedo, &given));
    if (albedo.texture >= 0 || albedo.value[0] > 0 || albedo.value[1] > 0 || albedo.value[2] > 0)
        pbrt_note(k->state, "the medium inside coats (\"albedo\" of %s) is not supported: coats are clear",
                  k->params->what);
    return FAULT_NONE;
}

static void to_floats(float to[3], rgb_t c)
{
    to[0] = (float)c.r;
    to[1] = (float)c.g;
    to[2] = (float)c.b;
}

static rgb_t within(rgb_t c, double lo, double hi)
{
    return rgb(fmin(fmax(c.r, lo), hi), fmin(fmax(c.g, lo), hi), fmin(fmax(c.b, lo), hi));
}

/* eta = 1 and this k give the reflectance r at normal incidence: r = k^2 / (4 + k^2). */
static double extinction_of(double r)
{
    const double least_gap = 1e-4; /* r = 1 would want k infinite */
    r = fmin(fmax(r, 0), 1 - least_gap);
    return 2 * sqrt(r) / sqrt(1 - r);
}

static fault_code_t conductor_of_reflectance(maker_t *k, bool *given)
{
    scene_param_t r;
    TRY(pbrt_color_param(k->state, k->params, "reflectance", 0.5, &r, given));
    if (!*given)
        return FAULT_NONE;
    if (r.texture >= 0) {
        pbrt_note(k->state, "a texture as \"reflectance\" of %s is not supported: 0.5 is used", k->params->what);
        set(&r, 0.5);
    }
    to_floats(k->m->eta, rgb(1, 1, 1));
    for (int i = 0; i < 3; i++)
        k->m->k[i] = (float)extinction_of((double)r.value[i]);
    return FAULT_NONE;
}

/* `prefix`eta and `prefix`k, copper by default, or reflectance. */
static fault_code_t conductor_index(maker_t *m, const char *prefix)
{
    char name[64];
    rgb_t eta, k;
    bool by_reflectance, eta_given, k_given;
    (void)spectra_named("metal-Cu-eta", SPECTRA_UNBOUNDED, &eta);
    (void)spectra_named("metal-Cu-k", SPECTRA_UNBOUNDED, &k);
    TRY(conductor_of_reflectance(m, &by_reflectance));
    snprintf(name, sizeof name, "%seta", prefix);
    TRY(pbrt_color(m->state, m->params, name, SPECTRA_UNBOUNDED, &eta, &eta_given));
    snprintf(name, sizeof name, "%sk", prefix);
    TRY(pbrt_color(m->state, m->params, name, SPECTRA_UNBOUNDED, &k, &k_given));
    if (by_reflectance && (eta_given || k_given))
        return pbrt_fault(m->state, FAULT_FORMAT, "%s has both \"reflectance\" and an index of refraction",
                          m->params->what);
    if (by_reflectance)
        return FAULT_NONE;
    to_floats(m->m->eta, within(eta, LEAST_INDEX, 1000));
    to_floats(m->m->k, within(k, 0, 1000));
    return FAULT_NONE;
}

/* ---- the kinds ---- */

static fault_code_t make_diffuse(maker_t *k)
{
    k->m->kind = SCENE_MATERIAL_DIFFUSE;
    return reflectance(k, "reflectance", 0.5, &k->m->reflectance);
}

static fault_code_t make_coated_diffuse(maker_t *k)
{
    bool remapped;
    double eta = 1.5;
    k->m->kind = SCENE_MATERIAL_COATED_DIFFUSE;
    TRY(reflectance(k, "reflectance", 0.5, &k->m->reflectance));
    TRY(remaproughness(k, &remapped));
    TRY(roughness(k, "", remapped, &k->m->coat_alpha_u, &k->m->coat_alpha_v));
    TRY(pbrt_index_of_refraction(k->state, k->params, "eta", &eta));
    k->m->coat_eta = (float)fmax(eta, LEAST_INDEX);
    return coat_inside(k);
}

static fault_code_t make_conductor(maker_t *k)
{
    bool remapped;
    k->m->kind = SCENE_MATERIAL_CONDUCTOR;
    TRY(conductor_index(k, ""));
    TRY(remaproughness(k, &remapped));
    return roughness(k, "", remapped, &k->m->alpha_u, &k->m->alpha_v);
}

static fault_code_t make_coated_conductor(maker_t *k)
{
    bool remapped;
    double eta = 1.5;
    k->m->kind = SCENE_MATERIAL_COATED_CONDUCTOR;
    TRY(conductor_index(k, "conductor."));
    TRY(remaproughness(k, &remapped));
    TRY(roughness(k, "conductor.", remapped, &k->m->alpha_u, &k->m->alpha_v));
    TRY(roughness(k, "interface.", remapped, &k->m->coat_alpha_u, &k->m->coat_alpha_v));
    TRY(pbrt_index_of_refraction(k->state, k->params, "interface.eta", &eta));
    k->m->coat_eta = (float)fmax(eta, LEAST_INDEX);
    return coat_inside(k);
}

static fault_code_t make_dielectric(maker_t *k)
{
    bool remapped;
    double eta = 1.5;
    k->m->kind = SCENE_MATERIAL_DIELECTRIC;
    TRY(remaproughness(k, &remapped));
    TRY(roughness(k, "", remapped, &k->m->alpha_u, &k->m->alpha_v));
    TRY(pbrt_index_of_refraction(k->state, k->params, "eta", &eta));
    to_floats(k->m->eta, rgb_gray(fmax(eta, LEAST_INDEX)));
    return FAULT_NONE;
}

static fault_code_t make_thin_dielectric(maker_t *k)
{
    double eta = 1.5;
    k->m->kind = SCENE_MATERIAL_THIN_DIELECTRIC;
    TRY(pbrt_index_of_refraction(k->state, k->params, "eta", &eta));
    to_floats(k->m->eta, rgb_gray(fmax(eta, LEAST_INDEX)));
    return FAULT_NONE;
}

static fault_code_t make_diffuse_transmission(maker_t *k)
{
    double scale = 1;
    k->m->kind = SCENE_MATERIAL_DIFFUSE_TRANSMISSION;
    TRY(reflectance(k, "reflectance", 0.25, &k->m->reflectance));
    TRY(reflectance(k, "transmittance", 0.25, &k->m->transmittance));
    PBRT_TRY(k->state, k->params, pbrt_params_float(k->params, "scale", 0, 1e6, &scale, k->state->fault));
    scene_param_t *parts[2] = {&k->m->reflectance, &k->m->transmittance};
    for (int i = 0; i < 6; i++) {
        float *value = &parts[i / 3]->value[i % 3];
        if ((double)*value * scale > 1)
            pbrt_note(k->state, "the \"scale\" of %s makes a reflectance of more than 1: cut", k->params->what);
        *value = (float)fmin((double)*value * scale, 1);
    }
    return FAULT_NONE;
}

static fault_code_t make_mix(maker_t *k)
{
    const pbrt_param_t *names;
    int32_t index[2];
    bool given;
    k->m->kind = SCENE_MATERIAL_MIX;
    PBRT_TRY(k->state, k->params,
             pbrt_params_typed(k->params, "materials", PBRT_MASK(PBRT_TEXT), &names, k->state->fault));
    if (!names || names->count != 2)
        return pbrt_fault(k->state, FAULT_FORMAT, "%s needs \"string materials\" with two names", k->params->what);
    for (int i = 0; i < 2; i++) {
        index[i] = name_table_get(&k->state->materials, names->strings[i], -1);
        if (index[i] < 0)
            return pbrt_at_params(k->state, k->params,
                                  pbrt_params_fault(k->params, names, k->state->fault, FAULT_UNKNOWN,
                                                    "there is no material \"%s\" before this line",
                                                    names->strings[i]));
    }
    k->m->first = index[0];
    k->m->second = index[1];
    return pbrt_scalar_param(k->state, k->params, "amount", 0.5, &k->m->mix, &given);
}

static fault_code_t make_interface(maker_t *k)
{
    k->m->kind = SCENE_MATERIAL_INTERFACE;
    return FAULT_NONE;
}

static const struct {
    const char *name;
    fault_code_t (*make)(maker_t *k);
} kinds[] = {{"diffuse", make_diffuse},
             {"coateddiffuse", make_coated_diffuse},
             {"conductor", make_conductor},
             {"coatedconductor", make_coated_conductor},
             {"dielectric", make_dielectric},
             {"thindielectric", make_thin_dielectric},
             {"diffusetransmission", make_diffuse_transmission},
             {"mix", make_mix},
             {"interface", make_interface},
             {"none", make_interface},
             {"", make_interface}};

/* The reflectance of a kind that is not known, as far as it has a parameter of that name that can be read. */
static fault_code_t make_substitute(maker_t *k, const char *kind)
{
    const pbrt_param_t *param = pbrt_params_find(k->params, "reflectance");
    const unsigned readable = PBRT_MASK(PBRT_RGB) | PBRT_MASK(PBRT_SPECTRUM) | PBRT_MASK(PBRT_TEXTURE);
    pbrt_note(k->state, "materials of the kind \"%s\" are not supported: diffuse is used", kind);
    k->m->kind = SCENE_MATERIAL_DIFFUSE;
    set(&k->m->reflectance, 0.5);
    if (param && readable & PBRT_MASK(param->type))
        TRY(reflectance(k, "reflectance", 0.5, &k->m->reflectance));
    for (size_t i = 0; i < k->params->count; i++)
        k->params->items[i].used = true;
    return FAULT_NONE;
}

/* Bumps change no light transport here; a scene that has them looks different. */
static void note_bumps(maker_t *k)
{
    static const char *const names[] = {"normalmap", "displacement", "bumpmap"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (pbrt_params_find(k->params, names[i]))
            pbrt_note(k->state, "\"%s\" of materials is not supported and is ignored", names[i]);
}

fault_code_t pbrt_material(pbrt_state_t *state, const char *kind, pbrt_params_t *params, int32_t *index)
{
    scene_material_t m = {.first = SCENE_NONE, .second = SCENE_NONE};
    maker_t k = {state, params, &m};
    scene_param_t *constants[] = {&m.alpha_u, &m.alpha_v,     &m.coat_alpha_u, &m.coat_alpha_v,
                                  &m.mix,     &m.reflectance, &m.transmittance};
    for (size_t i = 0; i < sizeof constants / sizeof *constants; i++)
        set(constants[i], 0);
    size_t i = 0;
    while (i < sizeof kinds / sizeof *kinds && strcmp(kind, kinds[i].name) != 0)
        i++;
    note_bumps(&k);
    TRY(i < sizeof kinds / sizeof *kinds ? kinds[i].make(&k) : make_substitute(&k, kind));
    uint32_t added;
    TRY(scene_builder_add_material(state->builder, &m, &added, state->fault));
    *index = (int32_t)added;
    return FAULT_NONE;
}
