/* image_file.h: image files by what they are: OpenEXR or PFM. */
#ifndef FILM_IMAGE_FILE_H
#define FILM_IMAGE_FILE_H

#include "film/image.h"

/* Reads an OpenEXR or PFM file, told apart by its first bytes, into an image which the caller clears. */
fault_code_t image_file_read(image_t *image, const char *path, fault_t *fault);
/* Writes by the name's ending: .exr, .pfm or .png (which takes the exposure; the others don't). FAULT_UNKNOWN for
 * another. */
fault_code_t image_file_write(const image_t *image, double exposure, const char *path, fault_t *fault);

#endif
