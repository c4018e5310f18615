/* light.h: the scene's light sources as samplers of emission, one entry per emitter.
 *
 * Emitters: each triangle, sphere or disk with an area light, each infinite, distant, point and spot light. One is
 * selected by a piecewise-constant table in proportion to its power (for an infinite or distant light: radiance times
 * the area of the scene's bounding disk), so that one number chooses and an inverse exists.
 *
 * Measures. An emitter at a finite place has vertices with a density per area (1, discrete, for point and spot) and an emission density per
 * solid angle. An infinite or distant light has directions with a density per solid angle (1, discrete, for distant); the
 * photon's start on the disk perpendicular to it has the density 1 / (pi R^2) per area.
 * All densities include the probability of selecting the emitter.
 *
 * Dimensions: select; position 1, 2; direction 1, 2. Infinite and distant lights use the *position* numbers for their direction
 * and the *direction* numbers for the place on the disk: what a connection with s = 1 needs is always select and
 * position.
 */
#ifndef SCENE_LIGHT_H
#define SCENE_LIGHT_H

#include <stdbool.h>

#include "math/frame.h"
#include "math/table.h"
#include "math/vec.h"
#include "scene/scene.h"

typedef enum light_emitter_kind {
    LIGHT_TRIANGLE = 0,
    LIGHT_SPHERE = 1,
    LIGHT_DISK = 2,
    LIGHT_INFINITE = 3,
    LIGHT_DISTANT = 4,
    LIGHT_POINT = 5,
    LIGHT_SPOT = 6
} light_emitter_kind_t;

enum {
    LIGHT_AT_INFINITY = 1,  /* infinite, distant */
    LIGHT_DELTA_POSITION = 2, /* point, spot: cannot be hit, position is discrete */
    LIGHT_DELTA_DIRECTION = 4, /* distant: cannot be hit, direction is discrete */
    LIGHT_TWO_SIDED = 8
};

typedef struct light_emitter {
    uint32_t kind;  /* light_emitter_kind_t */
    uint32_t flags;
    uint32_t light; /* index into scene->lights */
    uint32_t shape, primitive; /* of area emitters */
    rgb_t radiance; /* or intensity, or irradiance */
    vec3_t position; /* triangle: first corner; sphere, disk: centre; point, spot: place */
    vec3_t edge1, edge2; /* triangle: edges; disk: its two unit axes */
    vec3_t normal;   /* unit: triangle, disk (emitting side); spot, distant: direction of travel */
    double radius, area; /* sphere, disk; area of the emitter's surface */
    double cos_start, cos_end;
    double probability; /* of being selected */
} light_emitter_t;

typedef struct light_set {
    uint32_t count;
    light_emitter_t *emitters;
    table1_t selection;
    uint32_t *first_of_shape; /* per shape: its first emitter, UINT32_MAX if it emits nothing. Primitive p of a mesh:
                                 emitter_of_primitive[first + p]; of a sphere or disk: [first] */
    uint32_t *emitter_of_primitive; /* UINT32_MAX: a triangle of no area */
    int32_t infinite_count;  /* at most LIGHT_MAX_INFINITE */
    uint32_t infinite[8];    /* their emitter indices */
    table2_t *infinite_tables; /* per infinite light with an image; width 0 else */
    vec3_t centre;           /* of the scene's bounding sphere */
    double scene_radius;
    bool can_hit;            /* some emitter can be hit by a camera walk */
    bool has_infinite, has_delta;
} light_set_t;

enum { LIGHT_MAX_INFINITE = 8 };

/* From the scene's lights and shapes; the bounding sphere is computed over all shapes and the camera. No emitter of positive power is
 * FAULT_NO_LIGHT. */
fault_code_t light_set_init(light_set_t *set, const scene_t *scene, fault_t *fault);
void light_set_clear(light_set_t *set);

typedef struct light_sample {
    uint32_t emitter;
    vec3_t position;  /* finite lights; for those at infinity: unused */
    vec3_t normal;    /* surface emitters: unit, on the side that `position` sampling leaves open; else zero */
    vec3_t to_light;  /* lights at infinity: unit direction from the scene to the light */
    double pdf;       /* select * (per area | 1 | per solid angle | 1) */
} light_sample_t;

/* A place on a light (or a direction to one at infinity). False if void (a table's zero entry). */
bool light_sample_position(const light_set_t *set, const scene_t *scene, double select, const double position[2],
                           light_sample_t *out);

/* Emission from that place: for finite lights, direction leaves the surface; for lights at infinity the photon's
 * origin is on the disk just outside the bounding sphere. */
typedef struct light_emission {
    vec3_t origin, direction; /* direction unit, of travel */
    double pdf_direction;     /* per solid angle; at infinity: per area of the disk */
    rgb_t radiance;           /* Le(origin, direction) (intensity or irradiance for delta lights) */
    double cosine;            /* |cos| at the emitter; 1 where there is no surface */
} light_emission_t;
bool light_sample_direction(const light_set_t *set, const scene_t *scene, const light_sample_t *at,
                            const double direction[2], light_emission_t *out);

/* Emitted radiance at a light vertex towards unit `w` (leaving the light), and the density per solid angle with which
 * light_sample_direction takes w. For lights at infinity w is the direction of travel and the density is per area of the disk. */
rgb_t light_eval(const light_set_t *set, const scene_t *scene, uint32_t emitter, vec3_t normal, vec3_t w,
                 double *pdf_direction);

/* The emitter of a hit primitive, or UINT32_MAX. */
static inline uint32_t light_of_primitive(const light_set_t *set, uint32_t shape, uint32_t primitive)
{
    const uint32_t first = set->first_of_shape[shape];
    return first == UINT32_MAX ? UINT32_MAX : set->emitter_of_primitive[first + primitive];
}
/* Density with which light_sample_position makes a given point of a finite emitter: selection / area. */
static inline double light_pdf_position(const light_set_t *set, uint32_t emitter)
{
    const light_emitter_t *e = &set->emitters[emitter];
    return e->flags & LIGHT_DELTA_POSITION ? e->probability : e->probability / e->area;
}
/* Infinite lights: radiance arriving from the unit direction to_light, and the density per solid angle with which
 * light_sample_position takes that direction (selection included). The walk must sum over set->infinite. */
rgb_t light_infinite_radiance(const light_set_t *set, const scene_t *scene, uint32_t emitter, vec3_t to_light,
                              double *pdf);

/* Inverses: numbers that make this place, this direction. free_numbers resolve ambiguity. */
bool light_invert_position(const light_set_t *set, const scene_t *scene, const light_sample_t *at,
                           const double free_numbers[3], double *select, double position[2]);
bool light_invert_direction(const light_set_t *set, const scene_t *scene, const light_sample_t *at, vec3_t origin,
                            vec3_t w, const double free_numbers[2], double direction[2]);

#endif
