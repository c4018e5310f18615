/* picture.h: image files as texels: PNG, JPEG, TGA, BMP, Radiance HDR (through stb_image, which only this module
 * knows), PFM and OpenEXR (through film/).
 *
 *     picture_t image = {0};
 *     TRY(picture_read(path, (picture_coding_t){PICTURE_CODING_SRGB, 0}, &image, fault));
 *     ... image.texels, image.width ...
 *     picture_clear(&image);
 *
 * What a file is follows from its first bytes, not from its name (TGA has no mark: it is what nothing else
 * claims). Limits: SCENE_MAX_IMAGE_SIZE texels a side, PICTURE_MAX_TEXELS in all.
 */
#ifndef IMPORT_PICTURE_H
#define IMPORT_PICTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"
#include "scene/scene.h"

#define PICTURE_MAX_TEXELS (UINT64_C(1) << 28)

/* How integer samples are meant. Floating-point files are linear whatever this says. */
typedef enum picture_coding_kind {
    PICTURE_CODING_SRGB = 0,
    PICTURE_CODING_LINEAR = 1,
    PICTURE_CODING_GAMMA = 2
} picture_coding_kind_t;

typedef struct picture_coding {
    picture_coding_kind_t kind;
    double gamma; /* linear = sample^gamma, for PICTURE_CODING_GAMMA */
} picture_coding_t;

typedef struct picture {
    uint32_t width, height;
    uint32_t channels; /* 1, 3 or 4 */
    uint32_t texel;    /* scene_texel_t */
    bool opaque;       /* fewer than 4 channels, or the fourth is 1 everywhere */
    size_t bytes;
    void *texels; /* rows from the top, channels interleaved; owned: picture_clear */
} picture_t;

/* Fills *out; on a fault nothing is to be cleared. */
fault_code_t picture_read(const char *path, picture_coding_t coding, picture_t *out, fault_t *fault);
/* The same from bytes in memory (borrowed). */
fault_code_t picture_parse(const uint8_t *data, size_t size, picture_coding_t coding, picture_t *out,
                           fault_t *fault);
void picture_clear(picture_t *image);

/* The texel's channels as linear numbers; missing ones are filled (grey to three, alpha 1). */
void picture_texel(const picture_t *image, uint32_t x, uint32_t y, float rgba[4]);

#endif
