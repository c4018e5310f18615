#include "bsdf_fixture.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/fault.h"

static scene_param_t scalar(float value)
{
    return (scene_param_t){{value, value, value}, SCENE_NONE};
}

uint32_t fixture_add(fixture_t *f, const char *name, uint32_t kind)
{
    const uint32_t i = f->count++;
    f->names[i] = name;
    f->materials[i] = (scene_material_t){.kind = kind,
                                         .reflectance = scalar(0),
                                         .transmittance = scalar(0),
                                         .alpha_u = scalar(0),
                                         .alpha_v = scalar(0),
                                         .eta = {1.5F, 1.5F, 1.5F},
                                         .coat_eta = 1.5F,
                                         .coat_alpha_u = scalar(0),
                                         .coat_alpha_v = scalar(0),
                                         .mix = scalar(0),
                                         .first = SCENE_NONE,
                                         .second = SCENE_NONE};
    return i;
}

uint32_t fixture_diffuse(fixture_t *f, const char *name, float r, float g, float b)
{
    const uint32_t i = fixture_add(f, name, SCENE_MATERIAL_DIFFUSE);
    f->materials[i].reflectance = (scene_param_t){{r, g, b}, SCENE_NONE};
    return i;
}

static void set_copper(scene_material_t *m)
{
    const float eta[3] = {0.21F, 0.97F, 1.18F}, k[3] = {3.59F, 2.49F, 2.31F};
    for (int c = 0; c < 3; c++) {
        m->eta[c] = eta[c];
        m->k[c] = k[c];
    }
}

uint32_t fixture_conductor(fixture_t *f, const char *name, float alpha_u, float alpha_v)
{
    const uint32_t i = fixture_add(f, name, SCENE_MATERIAL_CONDUCTOR);
    set_copper(&f->materials[i]);
    f->materials[i].alpha_u = scalar(alpha_u);
    f->materials[i].alpha_v = scalar(alpha_v);
    return i;
}

uint32_t fixture_dielectric(fixture_t *f, const char *name, float eta, float alpha_u, float alpha_v)
{
    const uint32_t i = fixture_add(f, name, SCENE_MATERIAL_DIELECTRIC);
    f->materials[i].eta[0] = eta;
    f->materials[i].alpha_u = scalar(alpha_u);
    f->materials[i].alpha_v = scalar(alpha_v);
    return i;
}

uint32_t fixture_coated_diffuse(fixture_t *f, const char *name, float rho, float eta, float alpha_u, float alpha_v)
{
    const uint32_t i = fixture_add(f, name, SCENE_MATERIAL_COATED_DIFFUSE);
    f->materials[i].reflectance = (scene_param_t){{rho, 0.5F * rho, rho}, SCENE_NONE};
    if (rho == 1)
        f->materials[i].reflectance = scalar(1);
    f->materials[i].coat_eta = eta;
    f->materials[i].coat_alpha_u = scalar(alpha_u);
    f->materials[i].coat_alpha_v = scalar(alpha_v);
    return i;
}

uint32_t fixture_coated_conductor(fixture_t *f, const char *name, float alpha, float coat_alpha)
{
    const uint32_t i = fixture_add(f, name, SCENE_MATERIAL_COATED_CONDUCTOR);
    set_copper(&f->materials[i]);
    f->materials[i].alpha_u = f->materials[i].alpha_v = scalar(alpha);
    f->materials[i].coat_alpha_u = f->materials[i].coat_alpha_v = scalar(coat_alpha);
    return i;
}

uint32_t fixture_mix(fixture_t *f, const char *name, uint32_t first, uint32_t second, float share)
{
    const uint32_t i = fixture_add(f, name, SCENE_MATERIAL_MIX);
    f->materials[i].first = (int32_t)first;
    f->materials[i].second = (int32_t)second;
    f->materials[i].mix = scalar(share);
    return i;
}

void fixture_make(fixture_t *f)
{
    fault_t fault = {0};
    f->scene.materials = f->materials;
    f->scene.material_count = f->count;
    f->scene.textures = f->textures;
    f->scene.texture_count = f->texture_count;
    if (bsdf_tables_new(&f->tables, &f->scene, &fault)) {
        fprintf(stderr, "fixture: %s\n", fault.text);
        abort();
    }
}

static void add_conductors(fixture_t *f)
{
    fixture_conductor(f, "conductor 1", 1, 1);
    fixture_conductor(f, "conductor 0.3", 0.3F, 0.3F);
    fixture_conductor(f, "conductor 0.05", 0.05F, 0.05F);
    fixture_conductor(f, "conductor 1e-2", 1e-2F, 1e-2F);
    fixture_conductor(f, "conductor 1e-3", 1e-3F, 1e-3F);
    fixture_conductor(f, "conductor 1e-4", 1e-4F, 1e-4F);
    fixture_conductor(f, "conductor 0.4 x 0.02", 0.4F, 0.02F);
    fixture_conductor(f, "conductor 1e-3 x 1", 1e-3F, 1);
    fixture_conductor(f, "mirror", 0, 0);
    const uint32_t perfect = fixture_conductor(f, "perfect mirror", 0, 0);
    for (int c = 0; c < 3; c++) {
        f->materials[perfect].eta[c] = 1e-3F; /* F = 1 - 4 n / (n^2 + k^2) = 1 - 4e-9 */
        f->materials[perfect].k[c] = 1000;
    }
    f->furnace[perfect] = true;
}

static void add_dielectrics(fixture_t *f)
{
    fixture_dielectric(f, "glass 1", 1.5F, 1, 1);
    fixture_dielectric(f, "glass 0.3", 1.5F, 0.3F, 0.3F);
    fixture_dielectric(f, "glass 0.05", 1.5F, 0.05F, 0.05F);
    fixture_dielectric(f, "glass 1e-2", 1.5F, 1e-2F, 1e-2F);
    fixture_dielectric(f, "glass 1e-3", 1.5F, 1e-3F, 1e-3F);
    fixture_dielectric(f, "glass 1e-4", 1.5F, 1e-4F, 1e-4F);
    fixture_dielectric(f, "glass 0.4 x 0.02", 1.5F, 0.4F, 0.02F);
    fixture_dielectric(f, "bubble 0.3", 1 / 1.5F, 0.3F, 0.3F);
    fixture_dielectric(f, "diamond 0.1", 2.4F, 0.1F, 0.1F);
    fixture_dielectric(f, "diamond 1e-3", 2.4F, 1e-3F, 1e-3F);
    fixture_dielectric(f, "matched 0.3", 1.0001F, 0.3F, 0.3F);
    fixture_dielectric(f, "matched 1e-3", 1.0001F, 1e-3F, 1e-3F);
    fixture_dielectric(f, "matched 1e-4", 1.0001F, 1e-4F, 1e-4F);
    f->furnace[fixture_dielectric(f, "glass", 1.5F, 0, 0)] = true;
    f->furnace[fixture_dielectric(f, "diamond", 2.4F, 0, 0)] = true;
    f->furnace[fixture_dielectric(f, "matched", 1.0001F, 0, 0)] = true;
    f->furnace[fixture_dielectric(f, "index 1", 1, 0.3F, 0.3F)] = true;
    f->furnace[fixture_add(f, "pane", SCENE_MATERIAL_THIN_DIELECTRIC)] = true;
}

static void add_coats(fixture_t *f)
{
    fixture_coated_diffuse(f, "lacquer", 0.6F, 1.5F, 0, 0);
    fixture_coated_diffuse(f, "lacquer 0.3", 0.6F, 1.5F, 0.3F, 0.3F);
    fixture_coated_diffuse(f, "lacquer 0.05", 0.6F, 1.5F, 0.05F, 0.05F);
    fixture_coated_diffuse(f, "lacquer 1e-3", 0.6F, 1.5F, 1e-3F, 1e-3F);
    fixture_coated_diffuse(f, "lacquer 0.4 x 0.1", 0.6F, 1.5F, 0.4F, 0.1F);
    fixture_coated_diffuse(f, "lacquer on black", 0, 1.5F, 0.2F, 0.2F);
    f->furnace[fixture_coated_diffuse(f, "white lacquer", 1, 1.5F, 0, 0)] = true;
    f->furnace[fixture_coated_diffuse(f, "white lacquer 0.1", 1, 1.5F, 0.1F, 0.1F)] = true;
    f->furnace[fixture_coated_diffuse(f, "white lacquer 1", 1, 2.4F, 1, 1)] = true;
    f->furnace[fixture_coated_diffuse(f, "white lacquer 0.4 x 0.1", 1, 1.5F, 0.4F, 0.1F)] = true;
    fixture_coated_conductor(f, "varnished mirror", 0, 0);
    fixture_coated_conductor(f, "smooth varnish on 0.2", 0.2F, 0);
    fixture_coated_conductor(f, "varnish 0.1 on mirror", 0, 0.1F);
    fixture_coated_conductor(f, "varnish 0.3 on 0.3", 0.3F, 0.3F);
    const uint32_t perfect = fixture_coated_conductor(f, "varnished perfect mirror", 0, 0);
    for (int c = 0; c < 3; c++) {
        f->materials[perfect].eta[c] = 1e-3F;
        f->materials[perfect].k[c] = 1000;
    }
    f->furnace[perfect] = true;
}

static uint32_t find(const fixture_t *f, const char *name)
{
    for (uint32_t i = 0; i < f->count; i++)
        if (f->names[i] == name)
            return i;
    abort();
}

static void add_mixtures(fixture_t *f)
{
    static const char *const metal = "metal of mixtures", *const paint = "paint of mixtures";
    static const char *const glass = "glass of mixtures";
    fixture_conductor(f, metal, 0.1F, 0.1F);
    fixture_coated_diffuse(f, paint, 0.8F, 1.4F, 0.02F, 0.02F);
    fixture_dielectric(f, glass, 1.5F, 0.2F, 0.2F);
    const uint32_t rust = fixture_diffuse(f, "rust", 0.5F, 0.2F, 0.1F);
    const uint32_t hole = fixture_add(f, "hole", SCENE_MATERIAL_INTERFACE);
    const uint32_t pane = fixture_add(f, "pane of mixtures", SCENE_MATERIAL_THIN_DIELECTRIC);
    fixture_mix(f, "rust on metal", find(f, metal), rust, 0.3F);
    fixture_mix(f, "rust with holes", rust, hole, 0.25F);
    fixture_mix(f, "glass and rust", find(f, glass), rust, 0.5F);
    const uint32_t inner = fixture_mix(f, "paint and glass", find(f, paint), find(f, glass), 0.6F);
    fixture_mix(f, "paint, glass and pane", pane, inner, 0.7F);
    f->furnace[hole] = f->furnace[pane] = true;
}

void fixture_init(fixture_t *f)
{
    *f = (fixture_t){0};
    fixture_diffuse(f, "diffuse", 0.5F, 0.3F, 0.7F);
    f->furnace[fixture_diffuse(f, "white", 1, 1, 1)] = true;
    const uint32_t leaf = fixture_add(f, "leaf", SCENE_MATERIAL_DIFFUSE_TRANSMISSION);
    f->materials[leaf].reflectance = scalar(0.3F);
    f->materials[leaf].transmittance = (scene_param_t){{0.1F, 0.5F, 0.2F}, SCENE_NONE};
    add_conductors(f);
    add_dielectrics(f);
    add_coats(f);
    add_mixtures(f);
    fixture_make(f);
}

void fixture_clear(fixture_t *f)
{
    bsdf_tables_destroy(&f->tables);
}

int fixture_setup(void **state)
{
    static fixture_t fixture;
    fixture_init(&fixture);
    *state = &fixture;
    return 0;
}

int fixture_teardown(void **state)
{
    fixture_clear(*state);
    return 0;
}

vec3_t fixture_direction(int i)
{
    static const double cosines[FIXTURE_DIRECTIONS] = {1, 0.7, 0.15, 1e-3, -0.8, -0.3};
    const double z = cosines[i], r = sqrt((1 - z) * (1 + z)), azimuth = 0.7 + 1.9 * i;
    return vec3(r * cos(azimuth), r * sin(azimuth), z);
}

vec3_t fixture_random_direction(uint64_t key, uint64_t counter)
{
    return warp_sphere(random_double(key, 2 * counter), random_double(key, 2 * counter + 1));
}

double fixture_alpha(const bsdf_t *bsdf)
{
    double least = 1;
    for (uint32_t l = 0; l < bsdf->count; l++) {
        const bsdf_lobe_t *lobe = &bsdf->lobes[l];
        if (lobe->kind >= BSDF_CONDUCTOR && !BSDF_KIND_IS_SPECULAR(lobe->kind))
            least = fmin(least, fmin(lobe->alpha_u, lobe->alpha_v));
    }
    return least;
}

/* D is a function of |S^-1 m|, which is at least 1 for alpha <= 1: moving the unit vector m by d changes ln D by at
 * most 4 d / alpha. m is the direction of h = wo + eta wi, and rounding moves it by about 2^-52 / |h|. */
double fixture_condition(const bsdf_t *bsdf, vec3_t wo, vec3_t wi)
{
    double eta = 1;
    for (uint32_t l = 0; l < bsdf->count; l++)
        if (bsdf->lobes[l].kind == BSDF_DIELECTRIC && wo.z * wi.z < 0)
            eta = wo.z > 0 ? bsdf->lobes[l].eta : 1 / bsdf->lobes[l].eta;
    const double h = vec3_length(vec3_mad(wo, eta, wi));
    return 4 * 0x1p-52 / (fixture_alpha(bsdf) * h);
}
