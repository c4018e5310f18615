/* absent_scene.h: a scene twice more: with features that nothing uses, and with features that change nothing forced
 * on.
 *
 *     absent_scene_t unused;
 *     TRY(absent_scene_unused(&unused, &scene, fault));
 *     ... render unused.scene ...
 *     absent_scene_clear(&unused);
 *
 * Unused: materials of all kinds, textures and an area light that no shape has; point, spot and distant lights
 * without power. Not to be paid for, and the image is the same to the bit.
 *
 * Forced: every parameter of every material has a texture, which is 1, and every shape that does not radiate an
 * opacity to be looked up, which is 1: what a renderer does that does not look at what a scene calls for. The image
 * is the same but for noise: where (u,v) are looked up, tangents are those of the surface. */
#ifndef TESTS_BENCH_ABSENT_SCENE_H
#define TESTS_BENCH_ABSENT_SCENE_H

#include "base/fault.h"
#include "scene/scene.h"

typedef struct absent_scene {
    scene_t scene; /* its arrays are those below, and for the rest the original's */
    scene_shape_t *shapes;
    scene_material_t *materials;
    scene_texture_t *textures;
    scene_light_t *lights;
} absent_scene_t;

/* `from` has passed scene_check and is borrowed for the result's life. */
fault_code_t absent_scene_unused(absent_scene_t *out, const scene_t *from, fault_t *fault);
fault_code_t absent_scene_forced(absent_scene_t *out, const scene_t *from, fault_t *fault);
void absent_scene_clear(absent_scene_t *scene);

#endif
