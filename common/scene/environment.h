/* environment.h: an image of the sphere of directions as a light: equal-area octahedral map, bilinear radiance, and
 * a table to sample it. Used by light.c; directions here are in the light's own space.
 *
 * The square's edges fold onto themselves (a point at y on the left or right edge is the one at 1 - y), and the
 * filter follows: a texel beyond an edge is the one it folds to, so radiance is continuous over the whole sphere.
 *
 * The table's weight of a cell is the luminance's integral over it, exact for the bilinear function: of the 3x3
 * texels around, with (1/8, 3/4, 1/8) along each axis. It is positive wherever radiance is. An image of more than
 * ENVIRONMENT_MAX_TABLE texels a side has a table of that many cells; each holds its texels' integrals in
 * proportion to the area they share with it.
 */
#ifndef SCENE_ENVIRONMENT_H
#define SCENE_ENVIRONMENT_H

#include "math/table.h"
#include "math/vec.h"
#include "scene/scene.h"

enum { ENVIRONMENT_MAX_TABLE = 2048 };

/* Radiance of the image, times `scale`, at (x,y) in [0,1)^2; negative texels count as zero. */
rgb_t environment_radiance(const scene_t *scene, const scene_image_t *image, rgb_t scale, double x, double y);

/* The table and the mean luminance over the sphere. An image without light leaves the table clear and the mean
 * zero. */
fault_code_t environment_table(const scene_t *scene, const scene_image_t *image, rgb_t scale, table2_t *table,
                               double *mean, fault_t *fault);

#endif
