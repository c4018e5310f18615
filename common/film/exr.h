/* exr.h: images as OpenEXR files. The only place that knows OpenEXRCore.
 *
 * Writing: one part, scan lines, ZIP, every channel float32; the image's attributes become string attributes of the
 * header. Names of channels and attributes up to 255 bytes long are marked as long names.
 *
 * Reading: the first part, scan lines or tiles (level 0), channels of any type as float, string attributes. The
 * image is the data window; where it lies in the display window is not kept. Deep files and subsampled channels are
 * not supported (FAULT_UNSUPPORTED).
 *
 * Files come from anywhere: sizes, windows, chunks and every allocation are bounded before the library acts on
 * them. Still the library decompresses in C, so foreign files are read in the user's own process only (pack,
 * compare), never by master or worker. */
#ifndef FILM_EXR_H
#define FILM_EXR_H

#include "film/image.h"

/* *data is the caller's to free(). FAULT_RANGE for an attribute whose name OpenEXR reserves. */
fault_code_t exr_encode(const image_t *image, uint8_t **data, size_t *size, fault_t *fault);
fault_code_t exr_write(const image_t *image, const char *path, fault_t *fault);
/* Into an image which the caller clears; zeroed after a fault. */
fault_code_t exr_decode(image_t *image, const uint8_t *data, size_t size, fault_t *fault);
fault_code_t exr_read(image_t *image, const char *path, fault_t *fault);

#endif
