/* load.h: the project's own scenes, for tests. */
#ifndef TESTS_TRANSPORT_LOAD_H
#define TESTS_TRANSPORT_LOAD_H

#include "scene/scene.h"

/* Reads tests/scenes/NAME.pbrt; fails the test if it cannot. The scene lives until the next load. */
const scene_t *load_scene(const char *name);
void load_clear(void);

#endif
