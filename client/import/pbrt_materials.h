/* pbrt_materials.h: the materials of a pbrt-v4 file. Internal to client/import. */
#ifndef IMPORT_PBRT_MATERIALS_H
#define IMPORT_PBRT_MATERIALS_H

#include "client/import/pbrt_state.h"

/* Adds a material of the kind to the scene. Kinds that are not supported become diffuse, with a note. */
fault_code_t pbrt_material(pbrt_state_t *state, const char *kind, pbrt_params_t *params, int32_t *index);

#endif
