/* probe_list.h: what the parts of a build's list of probes share. */
#ifndef EXTENDED_PROBE_LIST_H
#define EXTENDED_PROBE_LIST_H

#include "math/vec.h"
#include "probe.h"

typedef struct probe {
    probe_info_t info;
    bool (*run)(const double *in, double *out);
} probe_t;

/* One list a file; each ends with a null name. */
extern const probe_t probe_maps[], probe_scattering[], probe_coats[], probe_places[], probe_lights[];

static inline vec3_t probe_vec(const double *in)
{
    return vec3(in[0], in[1], in[2]);
}

static inline void probe_put(double *out, vec3_t v)
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

#endif
