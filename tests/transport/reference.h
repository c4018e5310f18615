/* reference.h: a path's contribution and densities by their definitions, as a second way of computing what
 * path/connect.c gets from ratios: products over vertices in extended precision, nothing shared with the walks but
 * the scattering functions. */
#ifndef TESTS_TRANSPORT_REFERENCE_H
#define TESTS_TRANSPORT_REFERENCE_H

#include "path/connect.h"

typedef struct reference {
    long double f[3];                 /* measurement contribution */
    long double p[PATH_MAX_VERTICES]; /* density of technique s; 0 where it cannot make the path */
    long double sum;                  /* of p over the allowed techniques */
    bool valid;
} reference_t;

/* Of the path that technique (s, t) just made in `space` (its walks have exactly s and t vertices). */
void reference_evaluate(const path_scene_t *ps, const path_space_t *space, uint32_t s, uint32_t t,
                        const path_techniques_t *techniques, reference_t *out);

#endif
