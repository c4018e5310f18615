/* calibrate.h: the machine's speed in a unit that other figures can be divided by: million rays per CPU second of
 * one thread along random chords inside a closed tessellated sphere of 20,000 triangles, which stays in the cache,
 * with rtcIntersect1 on a robust scene. Rates of two machines, each divided by this figure measured in the same
 * minutes, can be compared. */
#ifndef TESTS_BENCH_CALIBRATE_H
#define TESTS_BENCH_CALIBRATE_H

/* The figure at which the other renderers' speeds were measured. */
#define CALIBRATE_PEERS 3.0

/* One run of a million rays; take the median of several. NaN if Embree has no memory. */
double calibrate_run(void);

#endif
