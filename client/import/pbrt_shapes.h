/* pbrt_shapes.h: shapes, objects and their instances of a pbrt-v4 file. Internal to client/import. */
#ifndef IMPORT_PBRT_SHAPES_H
#define IMPORT_PBRT_SHAPES_H

#include "client/import/pbrt_state.h"

/* A Shape: placed in the world, or kept in the object that is being defined. */
fault_code_t pbrt_shape(pbrt_state_t *state, const char *kind, pbrt_params_t *params);

fault_code_t pbrt_object_begin(pbrt_state_t *state, const char *name);
fault_code_t pbrt_object_end(pbrt_state_t *state);
/* Places the object's shapes under the current transformation. */
fault_code_t pbrt_object_instance(pbrt_state_t *state, const char *name);

#endif
