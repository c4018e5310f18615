/* inverse_trip.h: a scene with room for a path and its way back, for the tests of path/inverse.h. */
#ifndef TESTS_TRANSPORT_INVERSE_TRIP_H
#define TESTS_TRANSPORT_INVERSE_TRIP_H

#include "chain/target.h"
#include "path/inverse.h"

typedef struct trip {
    path_scene_t ps;
    path_space_t *x, *y, *z; /* the path, the path made again, and once more on the way back */
    target_t target;
    double camera[PATH_MAX_DIMENSIONS], light[PATH_MAX_DIMENSIONS];         /* x's numbers */
    double camera_new[PATH_MAX_DIMENSIONS], light_new[PATH_MAX_DIMENSIONS]; /* y's */
} trip_t;

/* A scene of inverse_scenes.h; fails the test if there is none. */
void trip_begin(trip_t *trip, const char *scene);
/* The same for a scene of the caller's, with trip_close for trip_end. */
void trip_open(trip_t *trip, const scene_t *scene);
void trip_length(trip_t *trip, uint32_t k);
void trip_close(trip_t *trip);
void trip_end(trip_t *trip);

/* Uniform numbers; with `extreme` one in ten is 0 and one in ten the largest below 1. */
void trip_numbers(trip_t *trip, uint64_t key, bool extreme);
/* x by technique s from its numbers; its contribution, 0 if none. */
double trip_make(trip_t *trip, uint32_t s);
/* Whether technique j can make x, of technique s: it joins nothing specular and hits no delta light. */
bool trip_possible(const trip_t *trip, uint32_t s, uint32_t j);
/* x_i of the path made by technique s. */
const path_vertex_t *trip_vertex(const trip_t *trip, uint32_t s, uint32_t i);
/* Numbers of technique j for x, from the key alone. */
bool trip_invert(trip_t *trip, uint32_t s, uint32_t j, uint64_t key);

#endif
