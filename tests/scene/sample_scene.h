/* sample_scene.h: a small scene with every kind of record, for the tests of builder, checks and bundles. */
#ifndef TESTS_SAMPLE_SCENE_H
#define TESTS_SAMPLE_SCENE_H

#include "scene/builder.h"

/* What is where in the sample. */
enum {
    SAMPLE_MESH_PLAIN = 0, /* a quad without normals and coordinates */
    SAMPLE_MESH_FULL = 1,  /* a triangle with both */
    SAMPLE_SPHERE = 2,     /* with an area light */
    SAMPLE_DISK = 3,
    SAMPLE_SHAPES = 4,
    SAMPLE_MATERIAL_MIX = SCENE_MATERIAL_MIX,   /* material i is of kind i */
    SAMPLE_TEXTURE_IMAGE = SCENE_TEXTURE_IMAGE, /* texture i is of kind i */
    SAMPLE_IMAGE_SRGB = 0,                      /* 3 x 2, 3 channels */
    SAMPLE_IMAGE_ALPHA = 1,                     /* 2 x 2, 4 channels */
    SAMPLE_IMAGE_SKY = 2,                       /* 2 x 2, 3 floats a texel */
    SAMPLE_IMAGES = 3                           /* light i is of kind i */
};

/* The builder, filled; fails the test if it cannot. With `dirty`, all that a reader may leave unset holds rubbish.
 */
scene_builder_t *sample_scene_build(int dirty);

/* Reads everything that a renderer would; returns a sum that depends on all of it. For scenes that passed
 * scene_check. */
double sample_scene_touch(const scene_t *scene);

#endif
