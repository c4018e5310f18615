/* vertex.h: a vertex of a path, as a walk leaves it behind.
 *
 * A path of length k has k segments and k+1 vertices. Technique s makes vertices y_0 .. y_{s-1} by a walk from a
 * light and z_0 .. z_{t-1}, t = k+1-s, by a walk from the camera (docs/transport.md). Hot data: four cache lines
 * and a half.
 *
 * Densities are per area of the surface at the vertex. Exceptions: a vertex at infinity has a density per solid
 * angle; delta positions (pinhole, point light) and delta directions (distant light) a discrete probability. After
 * a specular scattering at vertex i the densities of i+1 (this walk) and i-1 (the reversed walk) share one delta
 * function, taken with respect to n^2 |cos| d omega at vertex i on either side; only their ratio is ever used.
 */
#ifndef PATH_VERTEX_H
#define PATH_VERTEX_H

#include "math/frame.h"
#include "scene/bsdf.h"

typedef enum path_vertex_kind {
    PATH_SURFACE = 0,
    PATH_LENS = 1,
    PATH_LIGHT = 2,   /* y_0 at a finite place */
    PATH_INFINITE = 3 /* on a light at infinity: ng is the unit direction from the scene to it */
} path_vertex_kind_t;

#define PATH_NO_EMITTER UINT32_MAX

typedef struct path_vertex {
    vec3_t position;
    vec3_t ng;     /* unit geometric normal; zero on a point light */
    frame_t frame; /* shading; incomplete where a Lambertian vertex ends its walk: path_frame */
    vec3_t wo;     /* local unit direction to the previous vertex of the walk (only z is set there) */
    rgb_t beta;    /* throughput of the walk up to here: importance or radiance over density */
    double pdf;    /* density with which this walk made the vertex */
    double ratio;  /* density of the reversed walk over pdf: known once the walk has scattered at the next vertex */
    double to_previous; /* |cos at the previous vertex| / distance^2: solid angle here to area there */
    double correction;  /* light walks: |wo.ns| / |wo.ng| (Veach 1997, 5.3.2) */
    double epsilon;     /* how far rays start off the surface */
    const bsdf_t *bsdf; /* null where nothing scatters: lens, light, infinity */
    uint32_t emitter;   /* index into the light set, or PATH_NO_EMITTER */
    uint8_t kind;       /* path_vertex_kind_t */
    uint8_t specular;   /* the walk scattered specularly here */
    uint8_t delta;      /* the vertex cannot be hit: point, spot, distant lights */
    uint8_t lobe;       /* that the walk scattered with here; or what is there of the frame (path_frame_kind_t) */
} path_vertex_t;

/* In place of a lobe where a Lambertian vertex ends its walk: */
typedef enum path_frame_kind {
    PATH_FRAME_OF_NORMAL = 254, /* only n is set: the frame is frame_of_normal's */
    PATH_FRAME_OF_TANGENT = 255 /* n is set and s is the tangent: frame_of_normal_tangent's */
} path_frame_kind_t;

/* The whole frame of a vertex on a surface that scatters. */
static inline frame_t path_frame(const path_vertex_t *v)
{
    switch (v->lobe) {
    case PATH_FRAME_OF_NORMAL:
        return frame_of_normal(v->frame.n);
    case PATH_FRAME_OF_TANGENT:
        return frame_of_normal_tangent(v->frame.n, v->frame.s);
    default:
        return v->frame;
    }
}

/* Whether the vertex can end a walk that is joined to another: it is on a lens or a light, or scatters not only
 * specularly. */
static inline bool path_can_join(const path_vertex_t *v)
{
    return v->kind != PATH_SURFACE || (v->bsdf && (v->bsdf->flags & BSDF_HAS_SMOOTH));
}

#endif
