/* probe.h: functions of common/math and common/scene as maps from numbers to numbers, twice: as they are, and in
 * extended precision.
 *
 * probe.c and probe_*.c are compiled with each build; their lists are the same. The extended one
 * is a shared library that shows only its three functions here, so that both sets of symbols live in one program.
 *
 *     const probe_info_t *info = probe_info_double(i);             null beyond the last
 *     bool valid = probe_run_double(i, in, out), wanted = probe_run_extended(i, in, other);
 *
 * Pure functions, but for those that fill tables for the call.
 */
#ifndef EXTENDED_PROBE_H
#define EXTENDED_PROBE_H

#include <stdbool.h>
#include <stdint.h>

/* Wide enough for either build. */
typedef long double probe_number_t;

enum { PROBE_MAX_INPUTS = 24, PROBE_MAX_OUTPUTS = 24, PROBE_MAX_GROUPS = 8 };

/* Outputs that are one quantity: their error is that of a vector, relative to its length, or to `least` if that is
 * more: places in the unit square are as good as its size says. */
typedef struct probe_group {
    const char *name;
    uint32_t size;
    double least;
} probe_group_t;

/* `inputs` has one letter for each quantity that goes in, in their order (test_hard_precision.c makes them):
 *     u  a random number      a  alpha             e  relative index        i, k  a conductor's n, k
 *     c  a cosine in (0,1]    w  a unit vector above the plane (3)          d  any unit vector (3)
 *     g  a facet of the last alphas (3)             m  the last w reflected by such a facet (3)
 *     r  the last w refracted by a facet of the last alphas and index (3)
 *     p  a place in the unit cube times the scale of the scene (3)
 *     t  a triangle's corners, in single precision (9)
 *     s  a sphere's centre and radius, in single precision (4)     o  a disk's, in the plane z = const (4)
 *     q  a point of the last of these shapes (3)   h  unit vector from the last place to such a point (3)
 *     f  tangent of half a field of view           v  unit vector in the field around the last d (3)
 *     l  radius of a lens, in units of the distance of focus
 *     x  nine texels, in single precision           b  rows of a rotation, in single precision (9)
 *     y  cosines of a cone, of its inside and its rim, in single precision (2)
 *     z  a vector about unit, in single precision (3)      j  a unit vector in the last cone around it (3) */
typedef struct probe_info {
    const char *name, *inputs;
    probe_group_t outputs[PROBE_MAX_GROUPS];
    uint32_t one_in; /* only so many of the cases, as it takes long; 0: all */
} probe_info_t;

const probe_info_t *probe_info_double(uint32_t which);
/* False if the function says that there is nothing: outputs are then undefined. */
bool probe_run_double(uint32_t which, const probe_number_t *in, probe_number_t *out);

const probe_info_t *probe_info_extended(uint32_t which);
bool probe_run_extended(uint32_t which, const probe_number_t *in, probe_number_t *out);

#endif
