/* pfm.h: portable float maps: "PF" (R, G, B) and "Pf" (one channel, "Y"), rows from the bottom, either byte order.
 *
 * The header is "PF\nwidth height\nscale\n": a negative scale means little-endian, its absolute value is a unit by
 * which the numbers are multiplied. Writing uses scale -1. */
#ifndef FILM_PFM_H
#define FILM_PFM_H

#include "film/image.h"

/* Decodes bytes into an image, which the caller clears. FAULT_FORMAT (also for bytes that miss or are left over),
 * FAULT_RANGE, FAULT_LIMIT, FAULT_MEMORY. */
fault_code_t pfm_decode(image_t *image, const uint8_t *data, size_t size, fault_t *fault);
fault_code_t pfm_read(image_t *image, const char *path, fault_t *fault);
/* R, G and B as "PF"; an image with "Y" only as "Pf". *data is the caller's to free(). Other channels are left out.
 */
fault_code_t pfm_encode(const image_t *image, uint8_t **data, size_t *size, fault_t *fault);
fault_code_t pfm_write(const image_t *image, const char *path, fault_t *fault);

#endif
