/* png.h: 8-bit previews. A pixel is the sRGB curve (IEC 61966-2-1) of exposure * value, clamped to [0,1], times
 * 255, rounded to nearest; there is no other tone mapping and no dither. NaN becomes 0. The only place that knows
 * stb_image_write. */
#ifndef FILM_PNG_H
#define FILM_PNG_H

#include "film/image.h"

/* R, G and B (or Y) of the image. exposure must be finite and positive. *data is the caller's to free(). */
fault_code_t png_encode(const image_t *image, double exposure, uint8_t **data, size_t *size, fault_t *fault);
fault_code_t png_write(const image_t *image, double exposure, const char *path, fault_t *fault);

#endif
