/* connect.h: joins two walks into a path, with its contribution and its balance-heuristic weight.
 *
 * For the path of technique (s, t): value = w_s(x) f(x) / p_s(x) (linear RGB; pixels times radiance,
 * light-transport's C before the scalar target is taken), the same for every technique that can make x.
 *
 * Weights: w_s = 1 / sum_j p_j / p_s over the techniques j that the length's mask allows and that do not join at a
 * specular vertex (Veach 1997, 10.2.1, in ratios: r_i = reverse density / density at vertex i; sums by Horner's
 * rule from the outer end, so that nothing is multiplied out). A sum that leaves double's range is done again in
 * extended precision.
 */
#ifndef PATH_CONNECT_H
#define PATH_CONNECT_H

#include "path/walk.h"

typedef struct path_value {
    rgb_t value;   /* w f / p */
    vec2_t raster; /* in the camera's sampled domain */
} path_value_t;

/* Classes of paths that may be left out. A path is in a class whichever technique makes it, so that leaving one out
 * changes no weight. */
enum {
    PATH_CLASS_CAUSTIC = 1,  /* the first vertex after the light scatters specularly, some later one does not */
    PATH_CLASS_INFINITE = 2, /* the light is an infinite one: not a distant light */
    PATH_CLASS_SETS = 4      /* sets of them, 0 among these */
};

/* Which techniques s of a length take part: allowed[s], s = 0 .. k, 1 or 0; and which paths do not: PATH_CLASS_...
 */
typedef struct path_techniques {
    uint8_t allowed[PATH_MAX_VERTICES];
    uint8_t left_out;
} path_techniques_t;

/* Joins the first s vertices of the light walk and the first t of the camera walk, s + t >= 2, t >= 1. `y0`, if not
 * null, stands in for the light walk's first vertex (s = 1 only). For t = 1 the camera walk is the lens sample.
 * False if the path carries nothing. */
bool path_connect(const path_scene_t *scene, path_space_t *space, uint32_t s, uint32_t t, const path_vertex_t *y0,
                  const path_techniques_t *techniques, path_value_t *out);

/* The classes, added up, of the path that path_connect joins from the same arguments. */
uint8_t path_classes(const path_space_t *space, uint32_t s, uint32_t t, const path_vertex_t *y0);

/* The balance-heuristic weights of all techniques for the path that the last call of path_connect joined from (s,
 * t) and y0 in this space: weights[j], j = 0 .. s + t - 1; they sum to one. False where they leave double's
 * range. */
bool path_technique_weights(const path_space_t *space, uint32_t s, uint32_t t, const path_vertex_t *y0,
                            const path_techniques_t *techniques, double *weights);

#endif
