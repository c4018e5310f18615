/* image_exr.h: the first part of an OpenEXR file as floats. The only file here that knows OpenEXR. Any thread. */
#ifndef IMPORT_IMAGE_EXR_H
#define IMPORT_IMAGE_EXR_H

#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"

/* Reads channels R, G, B (and A), or Y, of scan lines or of a tiled image's finest level from bytes in memory
 * (borrowed). *texels is the caller's to free(): rows from the top of the data window, 1, 3 or 4 channels
 * interleaved. */
fault_code_t image_exr_parse(const uint8_t *data, size_t size, uint32_t *width, uint32_t *height,
                             uint32_t *channels, float **texels, fault_t *fault);

#endif
