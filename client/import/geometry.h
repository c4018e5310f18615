/* geometry.h: a surface in object space, and how it is placed in the world.
 *
 * geometry_place transforms a surface, turns its triangles the right way round, drops what has no area, and says
 * how large it is; geometry_add then hands it to the scene builder. Between the two the caller fills in material,
 * area light and alpha.
 *
 * Orientation. Without vertex normals the side of (p1-p0) x (p2-p0) is kept through mirroring transforms, and
 * reversed if `reverse`: both through SCENE_SHAPE_FLIP. With vertex normals these decide (turned round if
 * `reverse`): the corners of a triangle whose geometric normal points away from the sum of its vertices' normals
 * are exchanged, and nothing is flipped. Spheres face outwards and disks along their axis unless `reverse`,
 * mirrored or not.
 */
#ifndef IMPORT_GEOMETRY_H
#define IMPORT_GEOMETRY_H

#include <stdbool.h>

#include "client/import/transform.h"
#include "scene/builder.h"

typedef struct geometry {
    uint32_t kind; /* scene_shape_kind_t */
    /* mesh; owned: geometry_clear. normals, uvs may be null. Indices are below `vertices`. */
    float *positions, *normals, *uvs;
    uint32_t *indices;
    uint64_t vertices, triangles;
    bool generated;        /* triangles of no area (at poles) are nobody's mistake */
    double radius, height; /* sphere about the origin; disk at z = height */
} geometry_t;

/* Makes room for a mesh; the arrays are the caller's to fill. */
fault_code_t geometry_new_mesh(geometry_t *out, uint64_t vertices, uint64_t triangles, bool normals, bool uvs,
                               fault_t *fault);
void geometry_clear(geometry_t *geometry);

typedef struct placed {
    scene_shape_t shape;        /* as it is added; the caller sets material, area_light, alpha */
    float *positions, *normals; /* world space; owned: placed_clear */
    const float *uvs;           /* the geometry's, or uvs_owned */
    float *uvs_owned;
    uint32_t *indices;
    uint64_t vertices, triangles;
    double area;         /* world units squared */
    uint64_t degenerate; /* triangles of no area, left out */
    uint64_t no_normal;  /* vertex normals of no length, replaced */
    bool tessellated;    /* a sphere or disk that the transform makes neither */
} placed_t;

/* FAULT_RANGE if the transform is singular or a coordinate leaves SCENE_MAX_COORDINATE. The geometry must outlive
 * *out. A mesh that lost all its triangles has triangles = 0 and must not be added. */
fault_code_t geometry_place(const geometry_t *geometry, const transform_t *to_world, bool reverse, placed_t *out,
                            fault_t *fault);
/* Vertex normals that are everywhere their triangle's own are left out. */
fault_code_t geometry_add(const placed_t *placed, scene_builder_t *builder, fault_t *fault);
void placed_clear(placed_t *placed);

#endif
