/* triangle.h: barycentric coordinates of points in and beside a triangle, for needles too.
 *
 * A triangle is given by its two edges from the first corner; points are relative to that corner; (b1, b2) belong
 * to the ends of the edges. Pure functions; any thread.
 */
#ifndef MATH_TRIANGLE_H
#define MATH_TRIANGLE_H

#include "math/vec.h"

/* Of p's foot in the triangle's plane; may lie outside. */
vec2_t triangle_coordinates(vec3_t e1, vec3_t e2, vec3_t p);

/* The nearest point of the triangle's edges, for p outside by rounding. To clamp the coordinates would move the
 * point along a needle by more than it lies outside, by as much as the needle is longer than wide. */
vec2_t triangle_nearest(vec3_t e1, vec3_t e2, vec3_t p);

#endif
