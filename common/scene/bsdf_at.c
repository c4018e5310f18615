/* Resolving materials into lobes, and the tables made beforehand. */
#include "scene/bsdf.h"

#include <stdlib.h>

#include "scene/bsdf_coat.h"
#include "scene/fresnel.h"
#include "scene/texture.h"

enum { NO_COAT = -1, MAX_COAT_ROWS = 2048 };

/* An index this near to 1 bends light by less than 1e-6: a rough surface of it is a specular one. */
#define MATCHED_INDEX 1e-6

typedef struct resolve {
    const scene_t *scene;
    const bsdf_tables_t *tables;
    double u, v;
    bsdf_t *out;
} resolve_t;

/* ---- parameters ---- */

/* Textures may exceed what a surface can do: not a number counts as 0. */
static double unit_range(double x)
{
    return x > 0 ? (x < 1 ? x : 1) : 0;
}

static rgb_t param_color(const resolve_t *r, const scene_param_t *p)
{
    const rgb_t c = texture_param_color(r->scene, p, r->u, r->v);
    return rgb(unit_range(c.r), unit_range(c.g), unit_range(c.b));
}

static double param_alpha(const resolve_t *r, const scene_material_t *m, const scene_param_t *p)
{
    const double x = unit_range(texture_param_scalar(r->scene, p, r->u, r->v));
    return p->texture >= 0 && m->remap_roughness ? sqrt(x) : x;
}

static bool alpha_smooth(double alpha_u, double alpha_v)
{
    return alpha_u < (double)SCENE_ALPHA_SMOOTH && alpha_v < (double)SCENE_ALPHA_SMOOTH;
}

static double alpha_rough(double alpha)
{
    return alpha < (double)SCENE_ALPHA_SMOOTH ? (double)SCENE_ALPHA_SMOOTH : alpha;
}

static double index_of(float eta)
{
    return eta > 0 ? (double)eta : 1;
}

/* ---- lobes ---- */

static bsdf_lobe_t *lobe_add(resolve_t *r, bsdf_lobe_kind_t kind, rgb_t color, double select)
{
    bsdf_lobe_t *lobe = &r->out->lobes[r->out->count++];
    *lobe = (bsdf_lobe_t){.kind = kind, .select = select, .color = color, .eta = 1};
    return lobe;
}

/* Kinds that differ by their colour alone become one lobe. */
static void lobe_merge(resolve_t *r, bsdf_lobe_kind_t kind, rgb_t color)
{
    if (rgb_black(color))
        return;
    for (uint32_t l = 0; l < r->out->count; l++) {
        bsdf_lobe_t *lobe = &r->out->lobes[l];
        if (lobe->kind == (uint32_t)kind) {
            lobe->color = rgb_add(lobe->color, color);
            lobe->select = rgb_max(lobe->color);
            return;
        }
    }
    lobe_add(r, kind, color, rgb_max(color));
}

static void add_dielectric(resolve_t *r, const scene_material_t *m, double share)
{
    const double eta = index_of(m->eta[0]);
    if (eta == 1) {
        lobe_merge(r, BSDF_PASS, rgb_gray(share));
        return;
    }
    const double alpha_u = param_alpha(r, m, &m->alpha_u), alpha_v = param_alpha(r, m, &m->alpha_v);
    const bool mirror = alpha_smooth(alpha_u, alpha_v) || fabs(eta - 1) < MATCHED_INDEX;
    bsdf_lobe_t *lobe = lobe_add(r, mirror ? BSDF_MIRROR_DIELECTRIC : BSDF_DIELECTRIC, rgb_gray(share), share);
    lobe->alpha_u = alpha_rough(alpha_u);
    lobe->alpha_v = alpha_rough(alpha_v);
    lobe->eta = eta;
}

static void add_thin(resolve_t *r, const scene_material_t *m, double share)
{
    const double eta = index_of(m->eta[0]);
    if (eta == 1)
        lobe_merge(r, BSDF_PASS, rgb_gray(share));
    else
        lobe_add(r, BSDF_MIRROR_THIN, rgb_gray(share), share)->eta = eta;
}

/* Chosen by the reflectance at normal incidence; at least 0.05 of the share, for the grazing rise. */
static bsdf_lobe_t *add_metal(resolve_t *r, bsdf_lobe_kind_t kind, const scene_material_t *m, double coat_eta,
                              double share)
{
    bsdf_lobe_t *lobe = lobe_add(r, kind, rgb_gray(share), share);
    const double s = 1 / coat_eta;
    lobe->eta3 = rgb((double)m->eta[0] * s, (double)m->eta[1] * s, (double)m->eta[2] * s);
    lobe->k3 = rgb((double)m->k[0] * s, (double)m->k[1] * s, (double)m->k[2] * s);
    lobe->select = share * fmax(rgb_max(fresnel_conductor(1, lobe->eta3, lobe->k3)), 0.05);
    return lobe;
}

static void add_conductor(resolve_t *r, const scene_material_t *m, double share)
{
    const double alpha_u = param_alpha(r, m, &m->alpha_u), alpha_v = param_alpha(r, m, &m->alpha_v);
    const bool mirror = alpha_smooth(alpha_u, alpha_v);
    bsdf_lobe_t *lobe = add_metal(r, mirror ? BSDF_MIRROR_CONDUCTOR : BSDF_CONDUCTOR, m, 1, share);
    lobe->alpha_u = alpha_rough(alpha_u);
    lobe->alpha_v = alpha_rough(alpha_v);
}

/* ---- coats ---- */

typedef struct coat_place {
    uint32_t index;
    double alpha_u, alpha_v, row, eta;
    bool mirror;
} coat_place_t;

static coat_place_t coat_at(const resolve_t *r, uint32_t material)
{
    const scene_material_t *m = &r->scene->materials[material];
    coat_place_t at = {.index = r->tables->coat_of[material], .eta = index_of(m->coat_eta)};
    at.alpha_u = param_alpha(r, m, &m->coat_alpha_u);
    at.alpha_v = param_alpha(r, m, &m->coat_alpha_v);
    at.mirror = alpha_smooth(at.alpha_u, at.alpha_v);
    at.alpha_u = alpha_rough(at.alpha_u);
    at.alpha_v = alpha_rough(at.alpha_v);
    if (!at.mirror)
        at.row = bsdf_coat_row(&r->tables->coats[at.index], at.alpha_u, at.alpha_v);
    return at;
}

static void lobe_set_coat(bsdf_lobe_t *lobe, const coat_place_t *at)
{
    lobe->coat = at->index;
    lobe->coat_row = at->row;
    lobe->eta = at->eta;
}

static void add_coat(resolve_t *r, const coat_place_t *at, double share)
{
    bsdf_lobe_t *lobe = lobe_add(r, at->mirror ? BSDF_MIRROR_COAT : BSDF_COAT, rgb_gray(share), share);
    lobe_set_coat(lobe, at);
    lobe->alpha_u = at->alpha_u;
    lobe->alpha_v = at->alpha_v;
}

static void add_coated_diffuse(resolve_t *r, uint32_t material, double share)
{
    const scene_material_t *m = &r->scene->materials[material];
    const rgb_t rho = param_color(r, &m->reflectance);
    if (r->tables->coat_of[material] == (uint32_t)NO_COAT) {
        lobe_merge(r, BSDF_DIFFUSE, rgb_scale(rho, share));
        return;
    }
    const coat_place_t at = coat_at(r, material);
    add_coat(r, &at, share);
    if (rgb_black(rho))
        return;
    const double inner = bsdf_coat_inner(&r->tables->coats[at.index], at.row);
    const double s = share / (at.eta * at.eta);
    const rgb_t color =
        rgb(s * rho.r / (1 - rho.r * inner), s * rho.g / (1 - rho.g * inner), s * rho.b / (1 - rho.b * inner));
    const double albedo = rgb_max(color) * at.eta * at.eta * (1 - inner);
    lobe_set_coat(lobe_add(r, BSDF_COATED_BASE, color, albedo), &at);
}

/* The conductor's lobe as it looks from outside. In tangential parts of directions, a conductor slope s deflects by
 * 2 s inside, a coat slope by (1 - 1/eta) s on each passage, and eta times as much is seen outside; independent
 * slopes add in squares. */
static double coated_alpha(double alpha, const coat_place_t *at, double coat_alpha)
{
    const double bend = at->mirror ? 0 : (1 - 1 / at->eta) * coat_alpha;
    const double seen = at->eta * sqrt(alpha * alpha + 0.5 * bend * bend);
    return alpha_rough(fmin(seen, 1));
}

static void add_coated_conductor(resolve_t *r, uint32_t material, double share)
{
    const scene_material_t *m = &r->scene->materials[material];
    if (r->tables->coat_of[material] == (uint32_t)NO_COAT) {
        add_conductor(r, m, share);
        return;
    }
    const coat_place_t at = coat_at(r, material);
    const double alpha_u = param_alpha(r, m, &m->alpha_u), alpha_v = param_alpha(r, m, &m->alpha_v);
    const bool mirror = alpha_smooth(alpha_u, alpha_v);
    if (mirror && at.mirror) {
        lobe_set_coat(add_metal(r, BSDF_MIRROR_COATED_CONDUCTOR, m, at.eta, share), &at);
        return;
    }
    add_coat(r, &at, share);
    bsdf_lobe_t *lobe = add_metal(r, BSDF_COATED_CONDUCTOR, m, at.eta, share);
    lobe_set_coat(lobe, &at);
    lobe->alpha_u = coated_alpha(mirror ? 0 : alpha_u, &at, at.alpha_u);
    lobe->alpha_v = coated_alpha(mirror ? 0 : alpha_v, &at, at.alpha_v);
}

/* ---- materials ---- */

static void add_material(resolve_t *r, uint32_t material, double share)
{
    const scene_material_t *m = &r->scene->materials[material];
    switch ((scene_material_kind_t)m->kind) {
    case SCENE_MATERIAL_DIFFUSE:
        lobe_merge(r, BSDF_DIFFUSE, rgb_scale(param_color(r, &m->reflectance), share));
        break;
    case SCENE_MATERIAL_COATED_DIFFUSE:
        add_coated_diffuse(r, material, share);
        break;
    case SCENE_MATERIAL_CONDUCTOR:
        add_conductor(r, m, share);
        break;
    case SCENE_MATERIAL_COATED_CONDUCTOR:
        add_coated_conductor(r, material, share);
        break;
    case SCENE_MATERIAL_DIELECTRIC:
        add_dielectric(r, m, share);
        break;
    case SCENE_MATERIAL_THIN_DIELECTRIC:
        add_thin(r, m, share);
        break;
    case SCENE_MATERIAL_DIFFUSE_TRANSMISSION:
        lobe_merge(r, BSDF_DIFFUSE, rgb_scale(param_color(r, &m->reflectance), share));
        lobe_merge(r, BSDF_DIFFUSE_TRANSMIT, rgb_scale(param_color(r, &m->transmittance), share));
        break;
    case SCENE_MATERIAL_MIX: { /* at most BSDF_MAX_LOBES deep: each level has another lobe */
        const double second = unit_range(texture_param_scalar(r->scene, &m->mix, r->u, r->v));
        if (second < 1)
            add_material(r, (uint32_t)m->first, share * (1 - second));
        if (second > 0)
            add_material(r, (uint32_t)m->second, share * second);
        break;
    }
    case SCENE_MATERIAL_INTERFACE:
    case SCENE_MATERIAL_KINDS:
        lobe_merge(r, BSDF_PASS, rgb_gray(share));
        break;
    }
}

static uint32_t kind_flags(uint32_t kind)
{
    uint32_t flags = BSDF_KIND_IS_SPECULAR(kind) ? BSDF_HAS_SPECULAR : BSDF_HAS_SMOOTH;
    if (kind == BSDF_DIFFUSE_TRANSMIT || kind == BSDF_DIELECTRIC || kind == BSDF_MIRROR_DIELECTRIC ||
        kind == BSDF_MIRROR_THIN || kind == BSDF_PASS)
        flags |= BSDF_HAS_TRANSMISSION;
    return flags;
}

static void resolve(resolve_t *r, uint32_t material)
{
    r->out->count = 0;
    r->out->flags = 0;
    add_material(r, material, 1);
    for (uint32_t l = 0; l < r->out->count; l++)
        r->out->flags |= kind_flags(r->out->lobes[l].kind);
    if (r->out->count == 1 && r->out->lobes[0].kind == BSDF_DIFFUSE)
        r->out->flags |= BSDF_ONLY_DIFFUSE;
}

void bsdf_at(const scene_t *scene, const bsdf_tables_t *tables, uint32_t material, double u, double v, bsdf_t *out)
{
    const bsdf_t *ready = tables->ready[material];
    if (ready) {
        out->count = ready->count;
        out->flags = ready->flags;
        for (uint32_t l = 0; l < ready->count; l++)
            out->lobes[l] = ready->lobes[l];
        return;
    }
    resolve_t r = {scene, tables, u, v, out};
    resolve(&r, material);
}

/* ---- tables ---- */

typedef struct owner {
    bsdf_tables_t view; /* first: what the caller holds */
    const bsdf_t **ready;
    bsdf_t *resolved;
    uint32_t *flags, *coat_of;
    bsdf_coat_t *coats;
    uint32_t coat_capacity, coat_rows;
    bool *texture_constant; /* while making */
} owner_t;

void bsdf_tables_destroy(bsdf_tables_t **tables)
{
    if (!tables || !*tables)
        return;
    owner_t *owner = (owner_t *)*tables;
    for (uint32_t i = 0; i < owner->view.coat_count; i++)
        bsdf_coat_clear(&owner->coats[i]);
    free(owner->coats);
    free(owner->ready);
    free(owner->resolved);
    free(owner->flags);
    free(owner->coat_of);
    free(owner->texture_constant);
    free(owner);
    *tables = NULL;
}

static bool param_constant(const owner_t *owner, const scene_param_t *p)
{
    return p->texture < 0 || owner->texture_constant[p->texture];
}

/* Operands come before their texture: one pass. */
static void textures_classify(owner_t *owner, const scene_t *scene)
{
    for (uint32_t i = 0; i < scene->texture_count; i++) {
        const scene_texture_t *t = &scene->textures[i];
        const bool a = param_constant(owner, &t->a), b = param_constant(owner, &t->b);
        owner->texture_constant[i] = t->kind == SCENE_TEXTURE_CONSTANT ||
                                     (t->kind == SCENE_TEXTURE_SCALE && a && b) ||
                                     (t->kind == SCENE_TEXTURE_MIX && a && b && param_constant(owner, &t->m));
    }
}

static bool material_coated(const scene_material_t *m)
{
    return (m->kind == SCENE_MATERIAL_COATED_DIFFUSE || m->kind == SCENE_MATERIAL_COATED_CONDUCTOR) &&
           index_of(m->coat_eta) != 1;
}

static bool material_constant(const owner_t *owner, const scene_t *scene, uint32_t i)
{
    const scene_material_t *m = &scene->materials[i];
    if (m->kind == SCENE_MATERIAL_MIX)
        return param_constant(owner, &m->mix) && owner->ready[m->first] && owner->ready[m->second];
    return param_constant(owner, &m->reflectance) && param_constant(owner, &m->transmittance) &&
           param_constant(owner, &m->alpha_u) && param_constant(owner, &m->alpha_v) &&
           param_constant(owner, &m->coat_alpha_u) && param_constant(owner, &m->coat_alpha_v);
}

/* The coat's place, added where it is new: its tables are made when all are known to be few enough. */
static fault_code_t coat_find(owner_t *owner, const bsdf_coat_t *key, uint32_t material, uint32_t *index,
                              fault_t *fault)
{
    for (uint32_t i = 0; i < owner->view.coat_count; i++) {
        const bsdf_coat_t *c = &owner->coats[i];
        if (c->kind == key->kind && c->eta == key->eta && c->alpha_u == key->alpha_u &&
            c->alpha_v == key->alpha_v) {
            *index = i;
            return FAULT_NONE;
        }
    }
    owner->coat_rows += bsdf_coat_rows(key->kind);
    if (owner->coat_rows > MAX_COAT_ROWS)
        return fault_set(
            fault, FAULT_LIMIT,
            "material %u: its rough coat is one too many: the scene's different coats need more than %d "
            "table rows (1 each, %d if anisotropic, %d if textured)",
            material, MAX_COAT_ROWS, BSDF_COAT_ANISOTROPIC_ROWS, BSDF_COAT_TEXTURED_ROWS);
    if (owner->view.coat_count == owner->coat_capacity) {
        const uint32_t capacity = owner->coat_capacity ? 2 * owner->coat_capacity : 16;
        bsdf_coat_t *coats = realloc(owner->coats, capacity * sizeof *coats);
        if (!coats)
            return fault_set(fault, FAULT_MEMORY, "no memory for %u coats", capacity);
        owner->coats = coats;
        owner->coat_capacity = capacity;
    }
    owner->coats[owner->view.coat_count] = *key;
    *index = owner->view.coat_count++;
    owner->view.coats = owner->coats;
    return FAULT_NONE;
}

static fault_code_t coat_make(owner_t *owner, const scene_t *scene, uint32_t material, fault_t *fault)
{
    const scene_material_t *m = &scene->materials[material];
    owner->coat_of[material] = (uint32_t)NO_COAT;
    if (!material_coated(m))
        return FAULT_NONE;
    bsdf_coat_t key = {.kind = BSDF_COAT_TEXTURED, .eta = index_of(m->coat_eta)};
    if (param_constant(owner, &m->coat_alpha_u) && param_constant(owner, &m->coat_alpha_v)) {
        const resolve_t r = {scene, &owner->view, 0, 0, NULL};
        const double alpha_u = param_alpha(&r, m, &m->coat_alpha_u), alpha_v = param_alpha(&r, m, &m->coat_alpha_v);
        key.kind = BSDF_COAT_SMOOTH;
        if (!alpha_smooth(alpha_u, alpha_v)) {
            key.alpha_u = alpha_rough(alpha_u);
            key.alpha_v = alpha_rough(alpha_v);
            key.kind = key.alpha_u == key.alpha_v ? BSDF_COAT_ROUGH : BSDF_COAT_ANISOTROPIC;
        }
    }
    return coat_find(owner, &key, material, &owner->coat_of[material], fault);
}

/* The most lobes that a material can resolve to: a bit for each kind that lobe_merge joins, and the number of
 * others. */
typedef struct lobe_count {
    uint8_t merged, others;
} lobe_count_t;

static lobe_count_t count_lobes(const scene_t *scene, uint32_t i, const lobe_count_t *counts)
{
    enum { DIFFUSE = 1, TRANSMIT = 2, PASS = 4 };
    const scene_material_t *m = &scene->materials[i];
    switch ((scene_material_kind_t)m->kind) {
    case SCENE_MATERIAL_DIFFUSE:
        return (lobe_count_t){DIFFUSE, 0};
    case SCENE_MATERIAL_COATED_DIFFUSE:
        return material_coated(m) ? (lobe_count_t){0, 2} : (lobe_count_t){DIFFUSE, 0};
    case SCENE_MATERIAL_COATED_CONDUCTOR:
        return (lobe_count_t){0, material_coated(m) ? 2 : 1};
    case SCENE_MATERIAL_CONDUCTOR:
        return (lobe_count_t){0, 1};
    case SCENE_MATERIAL_DIELECTRIC:
    case SCENE_MATERIAL_THIN_DIELECTRIC:
        return index_of(m->eta[0]) == 1 ? (lobe_count_t){PASS, 0} : (lobe_count_t){0, 1};
    case SCENE_MATERIAL_DIFFUSE_TRANSMISSION:
        return (lobe_count_t){DIFFUSE | TRANSMIT, 0};
    case SCENE_MATERIAL_MIX: {
        const lobe_count_t a = counts[m->first], b = counts[m->second];
        return (lobe_count_t){a.merged | b.merged, (uint8_t)(a.others + b.others)};
    }
    case SCENE_MATERIAL_INTERFACE:
    case SCENE_MATERIAL_KINDS:
        break;
    }
    return (lobe_count_t){PASS, 0};
}

/* A mixture's depth is bounded by its lobes only if no level merges all it has: mixtures of merged kinds alone
 * could be nested without end, so the depth is limited too. */
static fault_code_t mixtures_check(const scene_t *scene, fault_t *fault)
{
    enum { MAX_DEPTH = 16, MAX_LEAVES = 256 };
    fault_code_t code = FAULT_NONE;
    lobe_count_t *counts = calloc(scene->material_count + 1, sizeof *counts);
    uint16_t *leaves = calloc(scene->material_count + 1, sizeof *leaves);
    uint8_t *depth = calloc(scene->material_count + 1, sizeof *depth);
    if (!counts || !leaves || !depth)
        code = fault_set(fault, FAULT_MEMORY, "no memory for %u materials", scene->material_count);
    for (uint32_t i = 0; !code && i < scene->material_count; i++) {
        const scene_material_t *m = &scene->materials[i];
        counts[i] = count_lobes(scene, i, counts);
        leaves[i] = 1;
        if (m->kind == SCENE_MATERIAL_MIX) {
            leaves[i] = (uint16_t)(leaves[m->first] + leaves[m->second]);
            const uint8_t deeper = depth[m->first] > depth[m->second] ? depth[m->first] : depth[m->second];
            depth[i] = (uint8_t)(deeper + 1);
        }
        const int lobes = __builtin_popcount(counts[i].merged) + counts[i].others;
        if (lobes > BSDF_MAX_LOBES)
            code = fault_set(fault, FAULT_LIMIT, "material %u: its mixture has %d lobes, the most is %d", i, lobes,
                             BSDF_MAX_LOBES);
        else if (depth[i] > MAX_DEPTH || leaves[i] > MAX_LEAVES)
            code = fault_set(fault, FAULT_LIMIT,
                             "material %u: its mixture is of %u materials in %u levels, the most is %d in %d", i,
                             leaves[i], depth[i], MAX_LEAVES, MAX_DEPTH);
    }
    free(counts);
    free(leaves);
    free(depth);
    return code;
}

/* What a material with textures may become. */
static uint32_t possible_flags(const owner_t *owner, const scene_t *scene, uint32_t i)
{
    const scene_material_t *m = &scene->materials[i];
    const bool varies = !param_constant(owner, &m->alpha_u) || !param_constant(owner, &m->alpha_v) ||
                        !param_constant(owner, &m->coat_alpha_u) || !param_constant(owner, &m->coat_alpha_v);
    switch (m->kind) {
    case SCENE_MATERIAL_DIFFUSE:
        return BSDF_HAS_SMOOTH | BSDF_ONLY_DIFFUSE;
    case SCENE_MATERIAL_DIFFUSE_TRANSMISSION:
        return BSDF_HAS_SMOOTH | BSDF_HAS_TRANSMISSION;
    case SCENE_MATERIAL_DIELECTRIC:
        return BSDF_HAS_SMOOTH | BSDF_HAS_SPECULAR | BSDF_HAS_TRANSMISSION;
    case SCENE_MATERIAL_THIN_DIELECTRIC:
        return BSDF_HAS_SPECULAR | BSDF_HAS_TRANSMISSION;
    case SCENE_MATERIAL_COATED_DIFFUSE:
        if (!varies && owner->coat_of[i] != (uint32_t)NO_COAT &&
            owner->coats[owner->coat_of[i]].kind != BSDF_COAT_SMOOTH)
            return BSDF_HAS_SMOOTH;
        return BSDF_HAS_SMOOTH | BSDF_HAS_SPECULAR;
    case SCENE_MATERIAL_MIX:
        return owner->flags[m->first] | owner->flags[m->second];
    default:
        return BSDF_HAS_SMOOTH | BSDF_HAS_SPECULAR;
    }
}

static fault_code_t coats_make(owner_t *owner, const scene_t *scene, fault_t *fault)
{
    for (uint32_t i = 0; i < scene->material_count; i++)
        TRY(coat_make(owner, scene, i, fault));
    for (uint32_t i = 0; i < owner->view.coat_count; i++) {
        const bsdf_coat_t key = owner->coats[i];
        TRY(bsdf_coat_init(&owner->coats[i], key.kind, key.eta, key.alpha_u, key.alpha_v, fault));
    }
    return FAULT_NONE;
}

static void materials_resolve(owner_t *owner, const scene_t *scene)
{
    uint32_t used = 0;
    for (uint32_t i = 0; i < scene->material_count; i++) {
        if (!material_constant(owner, scene, i)) {
            owner->flags[i] = possible_flags(owner, scene, i);
            continue;
        }
        resolve_t r = {scene, &owner->view, 0, 0, &owner->resolved[used++]};
        resolve(&r, i);
        owner->ready[i] = r.out;
        owner->flags[i] = r.out->flags;
    }
}

static fault_code_t owner_make(owner_t *owner, const scene_t *scene, fault_t *fault)
{
    const size_t count = (size_t)scene->material_count + 1;
    owner->ready = calloc(count, sizeof *owner->ready);
    owner->resolved = calloc(count, sizeof *owner->resolved);
    owner->flags = calloc(count, sizeof *owner->flags);
    owner->coat_of = calloc(count, sizeof *owner->coat_of);
    owner->texture_constant = calloc((size_t)scene->texture_count + 1, sizeof *owner->texture_constant);
    if (!owner->ready || !owner->resolved || !owner->flags || !owner->coat_of || !owner->texture_constant)
        return fault_set(fault, FAULT_MEMORY, "no memory for %u materials", scene->material_count);
    owner->view.ready = owner->ready;
    owner->view.flags = owner->flags;
    owner->view.coat_of = owner->coat_of;
    textures_classify(owner, scene);
    TRY(coats_make(owner, scene, fault));
    materials_resolve(owner, scene);
    return FAULT_NONE;
}

fault_code_t bsdf_tables_new(bsdf_tables_t **out, const scene_t *scene, fault_t *fault)
{
    *out = NULL;
    TRY(mixtures_check(scene, fault));
    owner_t *owner = calloc(1, sizeof *owner);
    if (!owner)
        return fault_set(fault, FAULT_MEMORY, "no memory for the tables of materials");
    bsdf_tables_t *tables = &owner->view;
    const fault_code_t code = owner_make(owner, scene, fault);
    if (code) {
        bsdf_tables_destroy(&tables);
        return code;
    }
    free(owner->texture_constant);
    owner->texture_constant = NULL;
    *out = tables;
    return FAULT_NONE;
}
