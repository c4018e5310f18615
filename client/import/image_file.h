/* image_file.h: pictures as texels: PNG, JPEG, TGA, BMP, Radiance HDR (through stb_image, which only this module
 * knows), PFM, and OpenEXR (image_exr.h).
 *
 *     image_file_t image = {0};
 *     TRY(image_file_read(path, (image_coding_t){IMAGE_CODING_SRGB, 0}, &image, fault));
 *     ... image.texels, image.width ...
 *     image_file_clear(&image);
 *
 * What a file is follows from its first bytes, not from its name (TGA has no mark: it is what nothing else
 * claims). Limits: SCENE_MAX_IMAGE_SIZE texels a side, IMAGE_FILE_MAX_TEXELS in all.
 */
#ifndef IMPORT_IMAGE_FILE_H
#define IMPORT_IMAGE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"
#include "scene/scene.h"

#define IMAGE_FILE_MAX_TEXELS (UINT64_C(1) << 28)

/* How integer samples are meant. Floating-point files are linear whatever this says. */
typedef enum image_coding_kind {
    IMAGE_CODING_SRGB = 0,
    IMAGE_CODING_LINEAR = 1,
    IMAGE_CODING_GAMMA = 2
} image_coding_kind_t;

typedef struct image_coding {
    image_coding_kind_t kind;
    double gamma; /* linear = sample^gamma, for IMAGE_CODING_GAMMA */
} image_coding_t;

typedef struct image_file {
    uint32_t width, height;
    uint32_t channels; /* 1, 3 or 4 */
    uint32_t texel;    /* scene_texel_t */
    bool opaque;       /* fewer than 4 channels, or the fourth is 1 everywhere */
    size_t bytes;
    void *texels; /* rows from the top, channels interleaved; owned: image_file_clear */
} image_file_t;

/* Fills *out; on a fault nothing is to be cleared. */
fault_code_t image_file_read(const char *path, image_coding_t coding, image_file_t *out, fault_t *fault);
/* The same from bytes in memory (borrowed). */
fault_code_t image_file_parse(const uint8_t *data, size_t size, image_coding_t coding, image_file_t *out,
                              fault_t *fault);
void image_file_clear(image_file_t *image);

/* The texel's channels as linear numbers; missing ones are filled (grey to three, alpha 1). */
void image_file_texel(const image_file_t *image, uint32_t x, uint32_t y, float rgba[4]);

#endif
