/* walk.h: random walks from the camera and from the lights.
 *
 * A walk is a function of its stream of numbers in [0,1). Streams have a fixed number of dimensions per vertex, so
 * that a change in one vertex's numbers never shifts another's:
 *
 *     camera: film x, film y, (lens 1, lens 2 unless the camera is a pinhole), then 3 for scattering at z_1, z_2,
 * ... light:  select, position 1, 2, direction 1, 2, then 3 for scattering at y_1, y_2, ...
 *
 * Threads: a path_scene_t is immutable and shared; a path_space_t belongs to one thread.
 */
#ifndef PATH_WALK_H
#define PATH_WALK_H

#include "base/stamp.h"
#include "path/vertex.h"
#include "scene/accel.h"
#include "scene/camera.h"
#include "scene/light.h"
#include "scene/surface.h"

enum {
    PATH_MAX_LENGTH = 127, /* segments */
    PATH_MAX_VERTICES = PATH_MAX_LENGTH + 1,
    PATH_LIGHT_DIMENSIONS = 5, /* before the first scattering */
    PATH_MAX_DIMENSIONS = 5 + BSDF_DIMENSIONS * PATH_MAX_LENGTH
};

/* What walks need to know of a shape before they look at where they hit it. */
enum {
    PATH_SHAPE_JOINS = 1, /* a walk that ends here may be joined to another: its material may scatter not only
                             specularly */
    PATH_SHAPE_EMITS = 2,
    PATH_SHAPE_WANTS_UV = 4 /* its material needs (u,v) or a tangent */
};

/* Where the last vertex of a walk is of use; elsewhere it is not made, as if the ray had missed. */
typedef enum path_ends {
    PATH_ENDS_JOINED = PATH_SHAPE_JOINS,
    PATH_ENDS_ON_LIGHT = PATH_SHAPE_EMITS,
    PATH_ENDS_ANYWHERE = 255
} path_ends_t;

/* Everything that paths are made in. */
typedef struct path_scene {
    const scene_t *scene;         /* the one borrowed, or `moved`'s */
    struct path_recentred *moved; /* a copy near the origin of a scene that lies far from it; else null */
    accel_t *accel;
    light_set_t lights;
    camera_t camera;
    bsdf_tables_t *tables;
    double *emitter_epsilon;    /* per emitter: how far rays start off it */
    uint8_t *shape_flags;       /* per shape: PATH_SHAPE_... */
    uint32_t camera_dimensions; /* before the first scattering: 2 for a pinhole, else 4 */
} path_scene_t;

/* `scene` is borrowed for the result's life; `camera` stands in for the scene's own, with a film of width x height
 * (0: its own). */
fault_code_t path_scene_init(path_scene_t *out, const scene_t *scene, const scene_camera_t *camera, uint32_t width,
                             uint32_t height, fault_t *fault);
void path_scene_clear(path_scene_t *scene);

/* Why a path was thrown away; indices of path_space_t.rejects. */
typedef enum path_reject {
    PATH_REJECT_RAY = 0, /* not finite: never traced */
    PATH_REJECT_WEIGHT,  /* the weight's sum was not finite even in extended precision */
    PATH_REJECT_VALUE,   /* not finite */
    PATH_REJECT_NEGATIVE,
    PATH_REJECTS
} path_reject_t;

/* Room for a walk: its vertices, and their materials where those have textures (else untouched). */
typedef struct path_trail {
    path_vertex_t vertices[PATH_MAX_VERTICES];
    bsdf_t bsdfs[PATH_MAX_VERTICES];
} path_trail_t;

/* Room for two walks, and a thread's counts. Spaces may trade walks (path_space_swap_...): a space owns two trails,
 * which may have got to another one. */
typedef struct path_space {
    path_vertex_t *camera, *light; /* the vertices of the trails in use */
    bsdf_t *camera_bsdf, *light_bsdf;
    vec2_t raster; /* of the camera walk */
    uint64_t rays, shadow_rays, rejects[PATH_REJECTS];
    stamp_meter_t tracing; /* of all of these rays */
    /* Of the last connection that carried light: reverse density over density at y_{s-1}, y_{s-2}, z_{t-1},
     * z_{t-2}. */
    double end_ratios[4];
    path_trail_t trails[2];
} path_space_t;

/* Of a zeroed space: its own trails. A space must not be moved afterwards. */
static inline void path_space_init(path_space_t *space)
{
    space->camera = space->trails[0].vertices;
    space->camera_bsdf = space->trails[0].bsdfs;
    space->light = space->trails[1].vertices;
    space->light_bsdf = space->trails[1].bsdfs;
}

/* A zeroed space with its trails; released with free(). Null when out of memory. */
path_space_t *path_space_new(void);

/* Trades the camera walks, or the light walks, of two spaces; nothing is copied. */
static inline void path_space_swap_camera(path_space_t *a, path_space_t *b)
{
    path_vertex_t *vertices = a->camera;
    bsdf_t *bsdfs = a->camera_bsdf;
    const vec2_t raster = a->raster;
    a->camera = b->camera;
    a->camera_bsdf = b->camera_bsdf;
    a->raster = b->raster;
    b->camera = vertices;
    b->camera_bsdf = bsdfs;
    b->raster = raster;
}
static inline void path_space_swap_light(path_space_t *a, path_space_t *b)
{
    path_vertex_t *vertices = a->light;
    bsdf_t *bsdfs = a->light_bsdf;
    a->light = b->light;
    a->light_bsdf = b->light_bsdf;
    b->light = vertices;
    b->light_bsdf = bsdfs;
}

/* Numbers that a walk of so many vertices uses. */
static inline uint32_t path_camera_dimensions(const path_scene_t *scene, uint32_t vertices)
{
    return vertices > 1                    ? scene->camera_dimensions + BSDF_DIMENSIONS * (vertices - 2)
           : scene->camera_dimensions == 2 ? 0
                                           : 4;
}
static inline uint32_t path_light_dimensions(uint32_t vertices)
{
    return vertices > 1 ? PATH_LIGHT_DIMENSIONS + BSDF_DIMENSIONS * (vertices - 2) : 3 * vertices;
}

/* Walks from the camera to at most `vertices` vertices (>= 1) and returns how many it reached. A ray that leaves
 * the scene ends in a vertex of kind PATH_INFINITE if there are lights at infinity to hit. The last vertex asked
 * for is not scattered at, and left out where `ends` says that it is of no use there. With one vertex only the lens
 * is sampled. */
uint32_t path_walk_camera(const path_scene_t *scene, path_space_t *space, const double *u, uint32_t vertices,
                          path_ends_t ends);

/* The same from a light; vertices >= 1. 0 if no light was found. */
uint32_t path_walk_light(const path_scene_t *scene, path_space_t *space, const double *u, uint32_t vertices,
                         path_ends_t ends);

/* Only y_0, from its three numbers (select, position). */
bool path_light_origin(const path_scene_t *scene, const double u[3], path_vertex_t *y);

#endif
