/* builder.h: a scene that grows. Readers fill it; scene_builder_view then shows it as a scene_t.
 *
 *     scene_builder_t *builder = scene_builder_new();
 *     TRY(scene_builder_add_material(builder, &material, &index, fault));
 *     ...
 *     const scene_t scene = scene_builder_view(builder);
 *     TRY(scene_check(&scene, fault));
 *
 * Every add copies its arguments, refuses to grow past the limits of scene.h (FAULT_LIMIT) and reports
 * FAULT_MEMORY; it checks nothing else (scene_check does). One thread at a time.
 */
#ifndef SCENE_BUILDER_H
#define SCENE_BUILDER_H

#include "scene/scene.h"

typedef struct scene_builder scene_builder_t;

scene_builder_t *scene_builder_new(void); /* null when out of memory */
void scene_builder_destroy(scene_builder_t **builder);

/* A mesh in world space. positions: 3 floats a vertex; normals, uvs: 3 and 2 floats a vertex or null; indices: 3 a
 * triangle, relative. `shape` gives flags FLIP, material, area_light and alpha; its kind, ranges and the other
 * flags are filled in. */
fault_code_t scene_builder_add_mesh(scene_builder_t *builder, const scene_shape_t *shape, const float *positions,
                                    const float *normals, const float *uvs, uint64_t vertices,
                                    const uint32_t *indices, uint64_t triangles, uint32_t *index, fault_t *fault);
/* A sphere or disk, as it is. */
fault_code_t scene_builder_add_shape(scene_builder_t *builder, const scene_shape_t *shape, uint32_t *index,
                                     fault_t *fault);
fault_code_t scene_builder_add_material(scene_builder_t *builder, const scene_material_t *material, uint32_t *index,
                                        fault_t *fault);
fault_code_t scene_builder_add_texture(scene_builder_t *builder, const scene_texture_t *texture, uint32_t *index,
                                       fault_t *fault);
/* Texels are copied; `image->offset` is filled in. */
fault_code_t scene_builder_add_image(scene_builder_t *builder, const scene_image_t *image, const void *texels,
                                     uint32_t *index, fault_t *fault);
fault_code_t scene_builder_add_light(scene_builder_t *builder, const scene_light_t *light, uint32_t *index,
                                     fault_t *fault);
void scene_builder_set_camera(scene_builder_t *builder, const scene_camera_t *camera);

/* Points into the builder; valid until the next add or the builder's end. camera is null until it is set. */
scene_t scene_builder_view(const scene_builder_t *builder);

#endif
