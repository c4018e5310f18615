/* ply.h: polygon files (Turk 1994) as triangles: ascii, binary little and big endian, gzip-compressed.
 *
 * Read are the vertices' x y z, nx ny nz and u v (also s t, texture_u texture_v, texture_s texture_t, of any scalar
 * type) and the faces' vertex_indices (or vertex_index); polygons become fans around their first corner. Other
 * elements and properties are passed over. Counts are checked against the bytes there are before memory is asked
 * for.
 */
#ifndef IMPORT_PLY_H
#define IMPORT_PLY_H

#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"

typedef struct ply_mesh {
    float *positions;  /* 3 a vertex */
    float *normals;    /* 3 a vertex or null */
    float *uvs;        /* 2 a vertex or null */
    uint32_t *indices; /* 3 a triangle */
    uint64_t vertices, triangles;
    uint64_t small_faces; /* faces of fewer than three corners: left out */
} ply_mesh_t;

/* Faults name the path and the line (header, ascii) or the element where it went wrong. */
fault_code_t ply_read(const char *path, ply_mesh_t *out, fault_t *fault);
/* From bytes in memory (borrowed, not compressed). */
fault_code_t ply_parse(const uint8_t *data, size_t size, ply_mesh_t *out, fault_t *fault);
void ply_mesh_clear(ply_mesh_t *mesh);

#endif
