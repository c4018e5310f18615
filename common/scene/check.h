/* check.h: the parts of scene_check. Private to check.c and check_material.c.
 *
 * A check_t carries the scene, the fault and the name of the record in hand ("material 7"), with which every
 * message begins.
 */
#ifndef SCENE_CHECK_H
#define SCENE_CHECK_H

#include "scene/scene.h"

/* Texture look-ups that one look-up may lead to, all operands counted: bounds depth and work. */
enum { CHECK_MAX_TEXTURE_VISITS = 256 };
/* Materials that a mix comes to, with repetition, and the levels of mixes in mixes: likewise. */
enum { CHECK_MAX_MIXED = 256, CHECK_MAX_MIX_LEVELS = 16 };
/* Refractive indices, and extinction coefficients, lie below. */
#define CHECK_MAX_ETA 1000.0f
/* How far a vector's length may be from 1, a product of unit vectors from 0. */
#define CHECK_UNIT_TOLERANCE 1e-3
/* Values of textures stay below, so that no product of them overflows. */
#define CHECK_MAX_TEXTURE_VALUE 1e30

typedef struct check {
    const scene_t *scene;
    fault_t *fault;
    char record[48];
} check_t;

/* Names the record in hand: "kind index". */
void check_begin(check_t *c, const char *kind, uint64_t index);
/* Fault text "record: ..."; returns code. */
fault_code_t check_refuse(check_t *c, fault_code_t code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* lo <= value <= hi, so not NaN. */
fault_code_t check_number(check_t *c, const char *field, double value, double lo, double hi);
fault_code_t check_numbers(check_t *c, const char *field, const float *values, int count, double lo, double hi);
/* A word that counts 0 to limit - 1. */
fault_code_t check_word(check_t *c, const char *field, uint32_t value, uint32_t limit);
/* An index below count, or SCENE_NONE where `optional`. */
fault_code_t check_index(check_t *c, const char *field, int32_t index, uint32_t count, int optional);
/* Values in [0,1], texture one of the first `textures` or SCENE_NONE. */
fault_code_t check_param(check_t *c, const char *field, const scene_param_t *param, uint32_t textures);

fault_code_t check_images(check_t *c);
fault_code_t check_textures(check_t *c);
fault_code_t check_materials(check_t *c);

#endif
