/* random_scene.h: small scenes of everything, at the limits of scene_check: a function of a key.
 *
 * Up to a dozen shapes of all kinds (degenerate triangles, needles, random normals, opacity), all materials with
 * extreme indices and roughness, nested mixtures, textures with black fields, all kinds of lights from 1e-10 to
 * 1e10 beside each other, pinholes and lenses, filters, crops; sizes from 1e-6 to 1e6 and up to 1e5 sizes from the
 * origin
 * (`wild`: sizes from 1e-20 to 1e12). */
#ifndef TESTS_HARD_RANDOM_SCENE_H
#define TESTS_HARD_RANDOM_SCENE_H

#include <stdbool.h>

#include "scene/builder.h"

/* Ends the process if the scene cannot be made; the caller destroys it. It passes scene_check. */
scene_builder_t *random_scene_new(uint64_t key, bool wild);

#endif
