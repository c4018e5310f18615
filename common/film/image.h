/* image.h: float images with named channels and text attributes, in memory.
 *
 * Channels are planes: channel c is image_channel(image, c), rows from the top, no padding. Colours are linear Rec.
 * 709 RGB in channels "R", "G", "B"; layers are named "layer.channel" ("stderr.R", "N.X", "Z"), as OpenEXR does;
 * docs/images.md lists what renders carry. Names and attributes belong to the image.
 *
 *     image_t image;
 *     static const char *const names[] = {"R", "G", "B", "samples"};
 *     TRY(image_init(&image, 640, 360, 4, names, fault));
 *     image_channel(&image, 3)[y * image.width + x] = 1;
 *     image_clear(&image);
 */
#ifndef FILM_IMAGE_H
#define FILM_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"

enum {
    IMAGE_MAX_SIDE = 1 << 15,
    IMAGE_MAX_CHANNELS = 1024,
    IMAGE_NAME_SIZE = 256, /* with the zero byte; OpenEXR's own limit */
    IMAGE_MAX_ATTRIBUTES = 1024
};
#define IMAGE_MAX_BYTES (UINT64_C(1) << 36)      /* of all channels */
#define IMAGE_MAX_FILE_BYTES (UINT64_C(1) << 36) /* that a reader takes in */

typedef struct image_attribute {
    char *name, *value;
} image_attribute_t;

typedef struct image {
    uint32_t width, height, channel_count;
    char (*names)[IMAGE_NAME_SIZE]; /* [channel_count] */
    float *data;                    /* [channel_count][height][width] */
    image_attribute_t *attributes;
    uint32_t attribute_count;
} image_t;

/* An image of zeros; image_clear releases it. Names are copied; they must be 1 to 255 bytes long and differ. After
 * a fault the image is zeroed and needs no clearing. FAULT_RANGE, FAULT_LIMIT, FAULT_MEMORY. */
fault_code_t image_init(image_t *image, uint32_t width, uint32_t height, uint32_t channel_count,
                        const char *const *names, fault_t *fault);
/* Channels "R", "G", "B". */
fault_code_t image_init_rgb(image_t *image, uint32_t width, uint32_t height, fault_t *fault);
void image_clear(image_t *image); /* frees; a zeroed image is left as it is */

/* The channel's index, -1 if there is none. */
int image_find(const image_t *image, const char *name);
/* The channel's plane, borrowed. Unchecked. */
static inline float *image_channel(const image_t *image, uint32_t channel)
{
    return image->data + (size_t)channel * image->width * image->height;
}
/* Planes of R, G and B, borrowed; of "Y" three times for a grey image. A fault lists the channels that are there.
 */
fault_code_t image_find_rgb(const image_t *image, const float *planes[3], fault_t *fault);

/* Copies both texts; an attribute of that name is replaced. */
fault_code_t image_set_attribute(image_t *image, const char *name, const char *value, fault_t *fault);
/* The attribute's text, borrowed; null if there is none. */
const char *image_attribute(const image_t *image, const char *name);

#endif
