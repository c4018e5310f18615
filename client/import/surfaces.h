/* surfaces.h: curved surfaces as triangles in object space, with normals and texture coordinates as pbrt has them:
 * u around the z axis from +x, v along it. The caller clears *out (geometry_clear).
 *
 * Resolution: a full turn is SURFACES_AROUND facets. A sphere's silhouette then lies within 0.03 % of its radius.
 */
#ifndef IMPORT_SURFACES_H
#define IMPORT_SURFACES_H

#include "client/import/geometry.h"

enum { SURFACES_AROUND = 128, SURFACES_ALONG = 64, SURFACES_PATCH = 16 };

/* The part of the sphere between heights z_min and z_max, from angle 0 to phi_max (radians). */
fault_code_t surfaces_sphere(geometry_t *out, double radius, double z_min, double z_max, double phi_max,
                             fault_t *fault);
/* A disk, ring or sector at z = height, facing +z. */
fault_code_t surfaces_disk(geometry_t *out, double height, double radius, double inner_radius, double phi_max,
                           fault_t *fault);
fault_code_t surfaces_cylinder(geometry_t *out, double radius, double z_min, double z_max, double phi_max,
                               fault_t *fault);

/* Bilinear patches: four corners each, (u,v) = (0,0), (1,0), (0,1), (1,1). Parallelograms become two triangles,
 * others SURFACES_PATCH^2 quads; *curved counts those. indices are below the number of points; normals, uvs may be
 * null. */
fault_code_t surfaces_patches(geometry_t *out, const double *points, const double *normals, const double *uvs,
                              const uint32_t *indices, uint64_t patches, uint64_t *curved, fault_t *fault);

#endif
