/* charted_scene.h: a ground lit by two area lights, and two charts of its paths with exact inverses.
 *
 * After Pantaleoni: Charted Metropolis Light Transport (2017), section 7.1. The paper tells the scene in words; the
 * numbers here are
 *
 *     ground    the unit square 0 <= x, y <= 1 of the plane z = 0, white, seen from above
 *     light 1   the unit square 0 <= y, z <= 1 of the plane x = 0, radiance 0.5 exp(3 y) of the colour (1, y, 1-y)
 *     strip     black, upright on the ground at x = 1/8, 13/16 <= y <= 7/8, as high as the lights
 *     light 2   the unit square 0 <= y, z <= 1 of the plane x = 1.25, radiance 10 of the colour (0.1, 1, 0.1)
 *     screen    the plane x = 1, black, with a hole of 0.08 x 0.08 around y = 0.35, z = 0.25
 *
 * Light 1 touches the ground: the geometric term has a singularity at their common edge, as in the paper's
 * discussion. A path is a point on the ground and a point on a light. Both charts take the point on the ground from
 * numbers 0 and 1; then
 *
 *   CHARTED_LIGHT      number 2 is the place along y of the two lights laid end to end, by inversion of the
 *                      radiance's CDF, number 3 the place along z: p = L / (integral of L over both), per area
 *   CHARTED_DIRECTION  numbers 2 and 3 are a direction from the ground by its cosine, followed to a light:
 *                      p = G / pi, per area
 *
 * with f* = L G V / pi: the largest component of the radiance in place of the radiance (section 3.4). Pure
 * functions; any thread; numbers in [0,1), unchecked.
 */
#ifndef LAB_CHARTED_SCENE_H
#define LAB_CHARTED_SCENE_H

#include "math/vec.h"

enum { CHARTED_LIGHT = 0, CHARTED_DIRECTION = 1, CHARTED_CHARTS = 2 };
enum { CHARTED_NUMBERS = 4, CHARTED_LIGHTS = 2 };

#define CHARTED_STRIP_X 0.125
#define CHARTED_STRIP_Y0 0.8125
#define CHARTED_STRIP_Y1 0.875
#define CHARTED_SCREEN_X 1.0
#define CHARTED_HOLE_Y0 0.31
#define CHARTED_HOLE_Y1 0.39
#define CHARTED_HOLE_Z0 0.21
#define CHARTED_HOLE_Z1 0.29
#define CHARTED_LIGHT2_X 1.25

typedef struct charted_path {
    double x, y;   /* on the ground */
    double across; /* y and */
    double up;     /* z on the light */
    int light;     /* 0 or 1 */
    double target; /* f*, per area of ground and light; 0: the light is not reached, and densities are not set */
    double density[CHARTED_CHARTS]; /* per area of ground and light */
} charted_path_t;

/* The largest component of the radiance, at y = across. */
double charted_radiance(int light, double across);
/* The radiance's largest value over both lights: of f* / p of CHARTED_DIRECTION, too. */
double charted_radiance_bound(void);
/* The colour f / f*; its largest component is 1. */
rgb_t charted_colour(int light, double across);

charted_path_t charted_sample(int chart, const double u[CHARTED_NUMBERS]);
/* Numbers with charted_sample(chart, u) = path, to rounding; path->target > 0. */
void charted_invert(int chart, const charted_path_t *path, double u[CHARTED_NUMBERS]);

/* w of the balance heuristic; target > 0. */
static inline double charted_weight(const charted_path_t *path, int chart)
{
    return path->density[chart] / (path->density[0] + path->density[1]);
}

#endif
