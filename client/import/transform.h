/* transform.h: affine and projective 4x4 matrices for scene readers, in double precision.
 *
 * Matrices act on column vectors; m[row][column]. Pure; any thread.
 */
#ifndef IMPORT_TRANSFORM_H
#define IMPORT_TRANSFORM_H

#include <stdbool.h>

#include "math/vec.h"

typedef struct transform {
    double m[4][4];
} transform_t;

transform_t transform_identity(void);
transform_t transform_mul(const transform_t *a, const transform_t *b); /* a b: b acts first */
transform_t transform_translate(double x, double y, double z);
transform_t transform_scale(double x, double y, double z);
/* Rotation by `degrees` about an axis that is not zero (Rodrigues). */
transform_t transform_rotate(double degrees, vec3_t axis);
/* World -> camera at `eye` that looks at `target` along +z with `up` upwards and a left-handed camera space, as
 * pbrt has it. False if the directions do not span a frame. */
bool transform_look_at(vec3_t eye, vec3_t target, vec3_t up, transform_t *out);
/* False if the matrix is singular or has numbers that are not finite. */
bool transform_invert(const transform_t *a, transform_t *out);
bool transform_finite(const transform_t *a);
/* True if the last row is (0,0,0,1): no perspective. */
bool transform_affine(const transform_t *a);

vec3_t transform_point(const transform_t *a, vec3_t p); /* affine part only */
vec3_t transform_vector(const transform_t *a, vec3_t v);
/* The transpose applied to v: with a = inverse(M), how M carries normals (not of unit length). */
vec3_t transform_transposed(const transform_t *a, vec3_t v);
double transform_determinant(const transform_t *a); /* of the upper left 3x3 */
/* True if the upper 3x3 is a rotation or mirror image times a scale (to about 1e-5, single-precision files); the
 * scale goes to *scale. */
bool transform_similarity(const transform_t *a, double *scale);

#endif
