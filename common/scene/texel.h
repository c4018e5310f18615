/* texel.h: one texel of an image as numbers, whatever its type. Inline: the look-ups of textures and of the
 * environment filter what these return.
 *
 * x < width, y < height; rows from the top. Nothing is checked. The scene's texels are as scene_check left them:
 * finite.
 */
#ifndef SCENE_TEXEL_H
#define SCENE_TEXEL_H

#include <string.h>

#include "math/vec.h"
#include "scene/scene.h"

/* The linear value of an 8-bit sRGB code (IEC 61966-2-1: v/12.92 up to 0.04045, ((v + 0.055) / 1.055)^2.4 beyond).
 */
extern const double texel_srgb[256];

/* Channel c < channels of the texel, linear; the fourth channel is never sRGB-encoded. */
static inline double texel_channel(const scene_t *scene, const scene_image_t *image, uint32_t x, uint32_t y,
                                   uint32_t c)
{
    const uint64_t at = ((uint64_t)y * image->width + x) * image->channels + c;
    const uint8_t *const data = scene->texels + image->offset;
    if (image->texel == SCENE_TEXEL_FLOAT32) {
        float value;
        memcpy(&value, data + at * sizeof value, sizeof value);
        return value;
    }
    if (image->texel == SCENE_TEXEL_SRGB8 && c < 3)
        return texel_srgb[data[at]];
    return data[at] * (1.0 / 255.0);
}

/* The colour; an image of one channel is gray. */
static inline rgb_t texel_rgb(const scene_t *scene, const scene_image_t *image, uint32_t x, uint32_t y)
{
    const double r = texel_channel(scene, image, x, y, 0);
    if (image->channels < 3)
        return rgb_gray(r);
    return rgb(r, texel_channel(scene, image, x, y, 1), texel_channel(scene, image, x, y, 2));
}

#endif
