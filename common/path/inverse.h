/* inverse.h: from a path back to the numbers that make it: right inverses of the walks.
 *
 * S_s maps numbers u to a path x; path_invert is an R_s with S_s(R_s(x)) = x, for a technique s of the caller's
 * choice whatever technique made x. Where many numbers make the same path one is drawn, by these laws:
 *
 *     unused number (pinhole, delta light, specular direction)       uniform in [0,1)
 *     discrete choice: light, reflection or refraction, emitter side  uniform in the interval that makes it
 *     smooth lobe                                                    l with probability alpha_l p_l / sum alpha p
 *     which of several environment lights made a direction           i with probability p_i / sum p
 *
 * If x comes from uniform u by technique s, R_s(x) is uniform again, and R_s'(x) is what technique s' would have
 * used for x: in the densities of a move that draws v = R_s'(x) nothing is left but p_s'(x), lobes and choices
 * included. A specular vertex keeps its lobe, which is part of the path. All numbers that some technique of the
 * length may use are set, those that s' does not use uniformly: a state (s', v) has no memory of s beyond x.
 *
 * A jump x -> (s', v) is a jump only if S_s'(v) is x to rounding and carries light. path_verify looks:
 *
 *     path_walk_..., path_connect ...                       x = (s, t) in `space`
 *     if (path_invert(ps, space, s, t, s_new, key, camera, light) &&
 *         !path_verify(ps, space, s, t, other, s_new, camera, light, techniques, &check)) ...   y, check.value
 *
 * Symmetric use. The distance of x and y is looked at, which is the same for x -> y and y -> x; but that way back
 * draws other numbers and rounds differently. A chain that is to be exact also inverts y to s (space `other`, a key
 * of its own) and verifies that against the y it came from, and stays at x if that fails: then every jump made has
 * a way back, and what is refused is refused both ways. With the forward check alone the bias is at most the share
 * of way-backs that fail, to be counted (path_inverse_failure_t; tests/transport/test_inverse.c measures
 * it). C of x and y differ by the same roundings: ratios of targets take check.value, not x's.
 *
 * What does not come back: a walk amplifies rounding, 1e-16, by distance / radius of curvature at every curved
 * vertex. Surfaces of an opacity between 0 and 1 let a ray pass by a hash of its bits: a path that crosses such
 * surfaces comes back only by chance.
 *
 * Cost: one direction and one inverse for each vertex, no allocation, no rays; path_verify is two walks and a
 * connection. Threads: as path_space_t.
 */
#ifndef PATH_INVERSE_H
#define PATH_INVERSE_H

#include "path/connect.h"

/* Numbers with which technique s_new makes the path that technique (s, t) made; s + t >= 2, t >= 1, s_new < s + t.
 * `space` holds the two walks, of s and t vertices or more; the path carries light. Fills camera with
 * path_camera_dimensions(scene, s + t) numbers, light with path_light_dimensions(s + t - 1): those of every
 * technique of the length. Free numbers are functions of key. False if s_new cannot make the path (it would join at
 * a specular vertex, or hit a delta light; the light is never selected; rounding has moved a direction to where
 * nothing scatters): the numbers are then undefined. */
bool path_invert(const path_scene_t *scene, const path_space_t *space, uint32_t s, uint32_t t, uint32_t s_new,
                 uint64_t key, double *camera, double *light);

/* The same for a state whose numbers are known: camera and light hold on entry those with which (s, t) made the
 * path, and what both techniques draw in the same way keeps them: the numbers of the first min(s, s_new) and min(t,
 * t_new) vertices of either walk. As these follow the laws above already, the result's law is path_invert's for a
 * state in equilibrium; only |s - s_new| vertices are inverted, and the kept part of the path comes back to the
 * bit. */
bool path_invert_jump(const path_scene_t *scene, const path_space_t *space, uint32_t s, uint32_t t, uint32_t s_new,
                      uint64_t key, double *camera, double *light);

/* Why a way back was refused; 0 if it was not. */
typedef enum path_inverse_failure {
    PATH_INVERSE_AGREES = 0,
    PATH_INVERSE_VOID,            /* path_invert said so; for callers' counts */
    PATH_INVERSE_SHORT,           /* a walk ended before its last vertex */
    PATH_INVERSE_KIND,            /* another emitter, lobe kind or infinity than before */
    PATH_INVERSE_MOVED,           /* a vertex lies beyond the tolerance */
    PATH_INVERSE_CARRIES_NOTHING, /* the ends do not see each other, or no light passes */
    PATH_INVERSE_FAILURES
} path_inverse_failure_t;

/* A vertex agrees if it moved by at most this fraction of the shorter of its segments (relative to one for
 * directions to infinity), but in any case if by at most PATH_INVERSE_FLOOR of its largest coordinate: rays start
 * 2^-20 of a coordinate off their surface, and what rounding puts outside a triangle is moved by up to that. */
#define PATH_INVERSE_TOLERANCE 0x1p-16
#define PATH_INVERSE_FLOOR 0x1p-36

typedef struct path_check {
    double error;       /* largest movement of a vertex, of the shorter of its segments */
    path_value_t value; /* of the path as made again; set if it agrees */
} path_check_t;

/* Makes the path again by technique s_new from its numbers, in `other`, and compares it with that of (s, t) in
 * `space`. */
path_inverse_failure_t path_verify(const path_scene_t *scene, const path_space_t *space, uint32_t s, uint32_t t,
                                   path_space_t *other, uint32_t s_new, const double *camera, const double *light,
                                   const path_techniques_t *techniques, path_check_t *out);

#endif
