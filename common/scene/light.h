/* light.h: the scene's light sources as samplers of emission, one entry per emitter.
 *
 * Emitters: each triangle, sphere or disk with an area light, each infinite, distant, point and spot light. One is
 * selected by a piecewise-constant table in proportion to its power (for an infinite or distant light: radiance
 * times the area of the scene's bounding disk), so that one number chooses and an inverse exists.
 *
 * Measures. An emitter at a finite place has vertices with a density per area (1, discrete, for point and spot) and
 * an emission density per solid angle. An infinite or distant light has directions with a density per solid angle
 * (1, discrete, for distant); the photon's start on the disk perpendicular to it has the density 1 / (pi R^2) per
 * area. All densities include the probability of selecting the emitter.
 *
 * Dimensions: select; position 1, 2; direction 1, 2. Infinite and distant lights use the *position* numbers for
 * their direction and the *direction* numbers for the place on the disk: what a connection with s = 1 needs is
 * always select and position.
 *
 * Which surfaces emit. An area light emits from the side of its geometric normal (after the shape's flip; a sphere
 * outwards, flipped inwards), or from both. Triangles of no area, lights of no radiance and shapes of the interface
 * material (which no ray meets) make no emitter. A shape's opacity does not thin its emission: it emits as if
 * opaque.
 *
 * Selection in proportion to power: area * pi * radiance (twice that if two-sided); 4 pi * intensity for a point; a
 * spot's integral over its cone; for lights at infinity what passes the disk: pi R^2 * irradiance, R the bounding
 * sphere's radius, irradiance = 4 pi * the mean radiance for an infinite one. An emitter of less than about 1e-16
 * of the total is never selected: its densities are zero, though it can be hit.
 *
 * Two-sided emitters choose the side by direction 1: [0, 1/2) is the side of the normal, [1/2, 1) the other; the
 * number is stretched to [0,1) within it.
 *
 * Environment images are filtered bilinearly, across the square's edges as the map folds; their table holds each
 * texel's average of that (see environment.h). No spatial dimension of a light depends on a point of reference: one
 * density a vertex, the same in every technique.
 *
 * Accuracy of the inverses: 1e-15 of the largest coordinate in positions (a point just outside its triangle goes to
 * the triangle's nearest point), 1e-15 in directions, but see warp.h for the horizon and table.h for entries of
 * small probability. All functions but init and clear: pure, any thread, nothing checked.
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
    LIGHT_AT_INFINITY = 1,     /* infinite, distant */
    LIGHT_DELTA_POSITION = 2,  /* point, spot: cannot be hit, position is discrete */
    LIGHT_DELTA_DIRECTION = 4, /* distant: cannot be hit, direction is discrete */
    LIGHT_TWO_SIDED = 8,
    LIGHT_INWARD = 16 /* a flipped sphere: its normal points to the centre */
};

typedef struct light_emitter {
    uint32_t kind; /* light_emitter_kind_t */
    uint32_t flags;
    uint32_t light;            /* index into scene->lights */
    uint32_t shape, primitive; /* of area emitters; infinite: its place in light_set_t.infinite in `primitive` */
    rgb_t radiance;            /* or intensity, or irradiance */
    vec3_t position;           /* triangle: first corner; sphere, disk: centre; point, spot: place */
    vec3_t edge1, edge2;       /* triangle: edges; disk: its two unit axes; infinite: with normal, the rows of
                                  the matrix (a rotation, perhaps with a mirror) world -> light */
    vec3_t normal;             /* unit: triangle, disk (emitting side); spot, distant: direction of travel */
    double radius, area;       /* sphere, disk; area of the emitter's surface */
    double cos_start, cos_end;
    double probability; /* of being selected */
} light_emitter_t;

enum { LIGHT_MAX_INFINITE = 8 };

typedef struct light_set {
    uint32_t count;
    light_emitter_t *emitters;
    table1_t selection;
    uint32_t *first_of_shape; /* per shape: its first emitter, UINT32_MAX if it emits nothing. Primitive p of a
                                 mesh: emitter_of_primitive[first + p]; of a sphere or disk: [first] */
    uint32_t *emitter_of_primitive;        /* UINT32_MAX: a triangle of no area */
    int32_t infinite_count;                /* at most LIGHT_MAX_INFINITE */
    uint32_t infinite[LIGHT_MAX_INFINITE]; /* their emitter indices */
    table2_t *infinite_tables;             /* per infinite light with an image; width 0 else */
    vec3_t centre;                         /* of the scene's bounding sphere */
    double scene_radius;
    bool can_hit; /* some emitter can be hit by a camera walk */
    bool has_infinite, has_delta;
} light_set_t;

/* From the scene's lights and shapes (checked by scene_check); the bounding sphere is computed over all shapes and
 * the camera with its lens, and enlarged by 1e-4. No emitter of positive power is FAULT_NO_LIGHT, more than
 * LIGHT_MAX_INFINITE infinite lights FAULT_LIMIT. On a fault the set is clear. */
fault_code_t light_set_init(light_set_t *set, const scene_t *scene, fault_t *fault);
void light_set_clear(light_set_t *set);

typedef struct light_sample {
    uint32_t emitter;
    vec3_t position; /* finite lights; for those at infinity: unused */
    vec3_t normal;   /* surface emitters: unit, on the side that `position` sampling leaves open; else zero */
    vec3_t to_light; /* lights at infinity: unit direction from the scene to the light */
    double pdf;      /* select * (per area | 1 | per solid angle | 1) */
} light_sample_t;

/* A place on a light (or a direction to one at infinity). False if void (a density of zero). */
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

/* Emitted radiance at a light vertex towards unit `w` (leaving the light), and the density per solid angle with
 * which light_sample_direction takes w. For lights at infinity w is the direction of travel and the density is per
 * area of the disk. `normal` is light_sample_t's, and only a sphere's is read: triangles and disks know theirs. */
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

/* Inverses: numbers that make this place, this direction. free_numbers (in [0,1)) resolve ambiguity: [0] the place
 * in the emitter's interval, [1], [2] the unused position numbers of a delta light; those of a direction are not
 * needed. Of `at`, emitter and position (at infinity to_light) are read, nothing else. False if nothing makes it:
 * an emitter that is never selected, a direction to a side or out of a cone without emission, an origin beside the
 * disk. At infinity `origin` may lie anywhere on the ray and w is minus to_light; elsewhere it is not read. */
bool light_invert_position(const light_set_t *set, const scene_t *scene, const light_sample_t *at,
                           const double free_numbers[3], double *select, double position[2]);
bool light_invert_direction(const light_set_t *set, const scene_t *scene, const light_sample_t *at, vec3_t origin,
                            vec3_t w, const double free_numbers[2], double direction[2]);

#endif
