/* hard.h: what the tests of the hard cases share: scenes from generated text, jobs whose refused values are looked
 * at, closed forms, algorithms against each other, the target against its definition.
 *
 * Everything fails the running test where it does not hold and prints what it measured (docs/hard-cases.md).
 */
#ifndef TESTS_HARD_HARD_H
#define TESTS_HARD_HARD_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <setjmp.h>
#include <cmocka.h>

#include "figures.h"
#include "path/connect.h"
#include "render.h"

/* ---- scenes as text ---- */

/* Begins a scene: camera (a LookAt line or other transformation), field of view in degrees, film of side x side
 * pixels with a box filter; the text stands after WorldBegin. */
FILE *hard_begin(const char *camera, double fov, uint32_t side);
/* Reads what was written; the scene lives until the next one, or hard_clear. */
const scene_t *hard_end(const char *name);
/* Reads tests/scenes/NAME.pbrt likewise. */
const scene_t *hard_load(const char *name);
void hard_clear(void);

/* Axis-aligned box [low, high]^3 of 6 quads, normals inwards or outwards. */
void hard_box(FILE *text, vec3_t low, vec3_t high, bool inwards);
void hard_quad(FILE *text, vec3_t a, vec3_t b, vec3_t c, vec3_t d);
/* Lambertian walls that also emit. */
void hard_furnace_walls(FILE *text, double albedo, double emission);

/* ---- jobs ---- */

typedef struct hard_job {
    const char *algorithm;
    uint32_t side, length; /* film of side x side, longest paths */
    double work;           /* mutations or samples a pixel */
    uint64_t seed;
    uint32_t pilot; /* candidates a length; 0: the usual */
} hard_job_t;

/* Runs the job and checks that nothing non-finite or negative reached the film; prints and bounds what was refused
 * before it. The caller clears. */
void hard_render(render_t *render, const char *name, const scene_t *scene, const hard_job_t *job);

/* Sum of b_k over all lengths, divided by the pixels: the mean luminance of the image, with its standard error. */
render_estimate_t hard_mean(const render_t *render, const hard_job_t *job);

/* Largest |z| of a comparison with a closed form: 1e-9 for a normal mean; the error is an estimate itself (10 %).
 */
#define HARD_Z (6.1 * 1.1)

/* The same job by pt, bdpt and mmlt: their means between low and high, within HARD_Z errors. */
void hard_expect_between(const char *name, const scene_t *scene, hard_job_t job, double low, double high);
/* Against `expected`, with the relative slack. */
void hard_expect_mean(const char *name, const scene_t *scene, hard_job_t job, double expected, double slack);
/* b_k of every length k = 1 .. job.length against expected[k], with the relative slack, by all three. */
void hard_expect_lengths(const char *name, const scene_t *scene, hard_job_t job, const double *expected,
                         double slack);

/* b_k of a closed furnace for every length, by all three algorithms: L rho^(k-1) per pixel. */
void hard_expect_furnace(const char *name, const scene_t *scene, hard_job_t job, double albedo, double emission);

/* pt and every algorithm of chains against bdpt by t scores over 20 seeds, in quarters of the image and in the
 * whole.
 */
void hard_agree(const char *name, const scene_t *scene, hard_job_t job);

/* ---- the target ---- */

typedef struct hard_invariance {
    uint32_t shortest, longest; /* path lengths */
    uint32_t paths;             /* tried for each length */
    uint32_t least;             /* to be compared, at least */
    /* Changes the random numbers of one stream, if not null. */
    void (*spoil)(double *u, uint32_t count, uint64_t key);
} hard_invariance_t;

/* w_s f / p_s as paths are made, against f / sum p by definition in extended precision (tests/transport), where p
 * and f come from recomputed directions: they may differ by the path's condition (hard.c). */
void hard_expect_invariance(const char *name, const scene_t *scene, const hard_invariance_t *options);

typedef struct hard_round_trip {
    uint32_t shortest, longest; /* path lengths */
    uint32_t paths;             /* tried for each length */
    uint32_t least;             /* round trips, at least */
    double failing;             /* share of them that may not come back to the path */
    double width;               /* of the narrowest lobe: C may change by 1e-7 over it */
} hard_round_trip_t;

/* S_s'(R_s'(x)) = x with the same C, for paths x of every technique s and every s' that can make them, numbers
 * drawn anew and kept (path/inverse.h): every number in [0,1), every C finite, at most the stated share lost, and
 * of those that come back at most one in 1000 with another C. */
void hard_expect_round_trips(const char *name, const scene_t *scene, const hard_round_trip_t *options);

/* Share of the segments of walks from the camera that leave a closed scene. */
double hard_leaks(const scene_t *scene, uint32_t walks, uint32_t length);

#endif
