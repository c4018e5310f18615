/* pbrt_camera.h: camera, film and pixel filter of a pbrt-v4 file. Internal to client/import. */
#ifndef IMPORT_PBRT_CAMERA_H
#define IMPORT_PBRT_CAMERA_H

#include "client/import/pbrt_state.h"

fault_code_t pbrt_camera(pbrt_state_t *state, const char *kind, pbrt_params_t *params);
fault_code_t pbrt_film(pbrt_state_t *state, const char *kind, pbrt_params_t *params);
fault_code_t pbrt_filter(pbrt_state_t *state, const char *kind, pbrt_params_t *params);
fault_code_t pbrt_integrator(pbrt_state_t *state, const char *kind, pbrt_params_t *params);

/* At WorldBegin: what was given becomes the scene's camera. */
fault_code_t pbrt_set_camera(pbrt_state_t *state);

#endif
