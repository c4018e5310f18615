/* bsdf_fixture.h: a scene of nothing but materials, for the tests of scattering. */
#ifndef TESTS_SCENE_BSDF_FIXTURE_H
#define TESTS_SCENE_BSDF_FIXTURE_H

#include "base/random.h"
#include "scene/bsdf.h"
#include "scene/scene.h"

enum { FIXTURE_MAX = 128, FIXTURE_DIRECTIONS = 6 };

typedef struct fixture {
    scene_t scene;
    scene_material_t materials[FIXTURE_MAX];
    scene_texture_t textures[8];
    const char *names[FIXTURE_MAX];
    bool furnace[FIXTURE_MAX]; /* returns all light */
    uint32_t count, texture_count;
    bsdf_tables_t *tables;
} fixture_t;

/* The list of materials all statistical tests go through. */
void fixture_init(fixture_t *f);
void fixture_clear(fixture_t *f);
/* A group's, with the list as its state. */
int fixture_setup(void **state);
int fixture_teardown(void **state);

/* Single materials, for tests of their own: fixture_make after the last one. Each returns its index. */
uint32_t fixture_add(fixture_t *f, const char *name, uint32_t kind);
uint32_t fixture_diffuse(fixture_t *f, const char *name, float r, float g, float b);
uint32_t fixture_conductor(fixture_t *f, const char *name, float alpha_u, float alpha_v);
uint32_t fixture_dielectric(fixture_t *f, const char *name, float eta, float alpha_u, float alpha_v);
uint32_t fixture_coated_diffuse(fixture_t *f, const char *name, float rho, float eta, float alpha_u, float alpha_v);
uint32_t fixture_coated_conductor(fixture_t *f, const char *name, float alpha, float coat_alpha);
uint32_t fixture_mix(fixture_t *f, const char *name, uint32_t first, uint32_t second, float share);
void fixture_make(fixture_t *f);

/* Directions towards the eye, from the normal to cosine 1e-3, on both sides. */
vec3_t fixture_direction(int i);
/* A uniform direction on the sphere. */
vec3_t fixture_random_direction(uint64_t key, uint64_t counter);

/* The resolved material (all of the fixture's list are constant). */
static inline const bsdf_t *fixture_bsdf(const fixture_t *f, uint32_t material)
{
    return f->tables->ready[material];
}

/* Smallest alpha of the smooth lobes, 1 if they have none. */
double fixture_alpha(const bsdf_t *bsdf);
/* Largest eta error amplification: how far rounding of wo and wi, 2^-52 each, may move ln D. See the source. */
double fixture_condition(const bsdf_t *bsdf, vec3_t wo, vec3_t wi);

#endif
