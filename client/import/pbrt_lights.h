/* pbrt_lights.h: light sources of a pbrt-v4 file. Internal to client/import.
 *
 * Brightness, as in pbrt-v4: an rgb colour counts as it is; a spectrum or black body is first scaled to the
 * luminance 1; then `scale`; `power` and `illuminance` say what the luminance adds up to. With the default film a
 * light of the radiance (r,g,b) that the camera sees gives the pixel value (r,g,b). */
#ifndef IMPORT_PBRT_LIGHTS_H
#define IMPORT_PBRT_LIGHTS_H

#include "client/import/pbrt_state.h"

fault_code_t pbrt_light(pbrt_state_t *state, const char *kind, pbrt_params_t *params);
/* AreaLightSource: for the shapes that follow in the attribute block. */
fault_code_t pbrt_area_light(pbrt_state_t *state, const char *kind, pbrt_params_t *params);

#endif
