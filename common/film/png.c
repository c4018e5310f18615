#include "film/png.h"

#include <math.h>
#include <stdlib.h>

#include "base/file.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

/* stb counts bytes in int and doubles its buffers. */
enum { PNG_MAX_BYTES = 1 << 29 };

/* IEC 61966-2-1, equation 9, and quantised. */
static uint8_t srgb_byte(double linear)
{
    if (!(linear > 0))
        return 0;
    if (linear >= 1)
        return 255;
    const double curved = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (uint8_t)(255 * curved + 0.5);
}

fault_code_t png_encode(const image_t *image, double exposure, uint8_t **data, size_t *size, fault_t *fault)
{
    *data = NULL;
    *size = 0;
    const float *planes[3];
    TRY(image_find_rgb(image, planes, fault));
    if (!(exposure > 0) || !isfinite(exposure))
        return fault_set(fault, FAULT_RANGE, "PNG: exposure %g found, a positive number expected", exposure);
    const size_t pixels = (size_t)image->width * image->height;
    if (3 * pixels + image->height > PNG_MAX_BYTES)
        return fault_set(fault, FAULT_LIMIT, "PNG of %u x %u pixels: more than %d bytes", image->width,
                         image->height, PNG_MAX_BYTES);
    uint8_t *bytes = malloc(3 * pixels);
    if (!bytes)
        return fault_set(fault, FAULT_MEMORY, "PNG of %u x %u pixels: out of memory", image->width, image->height);
    for (size_t i = 0; i < pixels; i++)
        for (size_t c = 0; c < 3; c++)
            bytes[3 * i + c] = srgb_byte(exposure * (double)planes[c][i]);
    int length = 0;
    *data =
        stbi_write_png_to_mem(bytes, (int)(3 * image->width), (int)image->width, (int)image->height, 3, &length);
    free(bytes);
    if (!*data)
        return fault_set(fault, FAULT_MEMORY, "PNG of %u x %u pixels: out of memory", image->width, image->height);
    *size = (size_t)length;
    return FAULT_NONE;
}

fault_code_t png_write(const image_t *image, double exposure, const char *path, fault_t *fault)
{
    uint8_t *data;
    size_t size;
    const fault_code_t encoded = png_encode(image, exposure, &data, &size, fault);
    if (encoded != FAULT_NONE)
        return fault_prefix(fault, encoded, "%s", path);
    const fault_code_t code = file_write(path, data, size, fault);
    free(data);
    return code;
}
