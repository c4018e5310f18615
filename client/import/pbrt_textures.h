/* pbrt_textures.h: colours, scalars and textures of a pbrt-v4 file. Internal to client/import. */
#ifndef IMPORT_PBRT_TEXTURES_H
#define IMPORT_PBRT_TEXTURES_H

#include "client/import/pbrt_state.h"
#include "client/import/spectra.h"

/* The Texture directive: `type` is "float" or "spectrum". */
fault_code_t pbrt_texture(pbrt_state_t *state, const char *name, const char *type, const char *kind,
                          pbrt_params_t *params);

/* A constant colour given as rgb, spectrum or blackbody; *given tells whether it is there. Leaves *value alone if
 * not. */
fault_code_t pbrt_color(pbrt_state_t *state, pbrt_params_t *params, const char *name, spectra_use_t use,
                        rgb_t *value, bool *given);
/* As pbrt_color, but also a float or texture, which give an index of refraction: 589 nm of a table. */
fault_code_t pbrt_index_of_refraction(pbrt_state_t *state, pbrt_params_t *params, const char *name, double *value);

/* A colour in [0,1] or a texture of the kind "spectrum"; constant textures are folded into the value. */
fault_code_t pbrt_color_param(pbrt_state_t *state, pbrt_params_t *params, const char *name, double absent,
                              scene_param_t *out, bool *given);
/* A float in [0,1] or a texture of the kind "float"; what is larger is cut, with a note. */
fault_code_t pbrt_scalar_param(pbrt_state_t *state, pbrt_params_t *params, const char *name, double absent,
                               scene_param_t *out, bool *given);

#endif
