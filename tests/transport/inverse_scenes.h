/* inverse_scenes.h: scenes for the inverse path sampler's tests: those of tests/scenes by name, and some made here.
 */
#ifndef TESTS_TRANSPORT_INVERSE_SCENES_H
#define TESTS_TRANSPORT_INVERSE_SCENES_H

#include "scene/scene.h"

/* The scene lives until the next one, or inverse_scene_clear. Made here:
 *     glass-furnace   the closed furnace with glass, mirrors, coats and mixtures in it
 *     skies           two environment lights, one from an image, and a textured floor
 *     lamps           a sphere, a disk and two-sided triangles as lights, anisotropic and coated metal
 *     narrow          lobes of alpha 1e-3 and 1e-4, glass of index 1.0001
 */
const scene_t *inverse_scene(const char *name);
void inverse_scene_clear(void);

#endif
