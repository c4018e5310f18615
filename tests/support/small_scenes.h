/* small_scenes.h: scenes for tests, made by program: a closed furnace, and an open box with a bit of everything.
 *
 *     small_scene_t small;
 *     small_scene_box(&small, SMALL_LIGHT_AREA);
 *     ... small.scene ...
 *     small_scene_clear(&small);
 *
 * All of them have passed scene_check; whatever fails on the way ends the process with its message: a test cannot
 * go on without. The film has 24 x 24 pixels of a box filter. Lengths are in units of the box's half width.
 */
#ifndef TESTS_SUPPORT_SMALL_SCENES_H
#define TESTS_SUPPORT_SMALL_SCENES_H

#include "scene/builder.h"

typedef enum small_light {
    SMALL_LIGHT_AREA = 0, /* a quad of side 0.3 under where a ceiling would be */
    SMALL_LIGHT_CONSTANT, /* an environment of equal radiance all around */
    SMALL_LIGHT_POINT,
    SMALL_LIGHT_SPOT,
    SMALL_LIGHT_DISTANT,
    SMALL_LIGHT_NONE,
    SMALL_LIGHT_HIDDEN /* the quad of SMALL_LIGHT_AREA in a closed black case that no light leaves */
} small_light_t;

/* Which shape is which in the box: in the order they are added. */
typedef enum small_shape {
    SMALL_FLOOR = 0,
    SMALL_BACK,
    SMALL_LEFT,
    SMALL_RIGHT,
    SMALL_BLOCK, /* five quads in one mesh */
    SMALL_MIRROR,
    SMALL_GLASS,     /* sphere */
    SMALL_CONDUCTOR, /* sphere, rough */
    SMALL_LAMP       /* with the two lights that have one */
} small_shape_t;

typedef struct small_scene {
    scene_builder_t *builder;
    scene_t scene; /* borrows from the builder */
} small_scene_t;

/* The cube [-1,1]^3 from inside: every wall has this albedo and radiates this much; the camera is inside. The
 * radiance over paths of at most K segments is emission * (1 + albedo + ... + albedo^(K-1)) in every direction. */
void small_scene_furnace(small_scene_t *out, double albedo, double emission);

/* Floor, back and side walls, a diffuse block, a mirror quad, a glass sphere, a rough conductor sphere. */
void small_scene_box(small_scene_t *out, small_light_t light);

/* The same without what is specular or rough: diffuse surfaces and the area light only. */
void small_scene_diffuse(small_scene_t *out);

void small_scene_clear(small_scene_t *small);

/* Parts, for tests that put together a scene of their own. */
void small_scene_begin(small_scene_t *out);
uint32_t small_add_diffuse(small_scene_t *small, double r, double g, double b);
uint32_t small_add_material(small_scene_t *small, const scene_material_t *material);
/* Everything that materials have in common: no textures, indices of 1.5. */
scene_material_t small_material(scene_material_kind_t kind);
/* `quads` quads in one mesh, 12 floats each; the normal of corners p0 p1 p2 p3 is (p1 - p0) x (p2 - p0). */
uint32_t small_add_quads(small_scene_t *small, uint32_t material, int32_t light, const float *corners,
                         uint32_t quads);
uint32_t small_add_sphere(small_scene_t *small, uint32_t material, const float centre[3], float radius);
uint32_t small_add_disk(small_scene_t *small, uint32_t material, const float centre[3], const float normal[3],
                        float radius);
uint32_t small_add_light(small_scene_t *small, const scene_light_t *light);
/* Looks from (x, y, z) along -z, `half` the tangent of half the field of view. */
void small_set_camera(small_scene_t *small, double x, double y, double z, double half);
/* Checks the scene and fills `scene`. */
void small_scene_finish(small_scene_t *small);

#endif
