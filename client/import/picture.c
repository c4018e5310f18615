#include "client/import/picture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STBI_NO_STDIO
#include <stb/stb_image.h>

#include "base/file.h"
#include "film/exr.h"
#include "film/pfm.h"

enum { FILE_MAX = 1 << 30 };

void picture_clear(picture_t *image)
{
    free(image->texels);
    memset(image, 0, sizeof *image);
}

static fault_code_t check_size(int64_t width, int64_t height, fault_t *fault)
{
    if (width < 1 || height < 1 || width > SCENE_MAX_IMAGE_SIZE || height > SCENE_MAX_IMAGE_SIZE ||
        (uint64_t)(width * height) > PICTURE_MAX_TEXELS)
        return fault_set(fault, FAULT_LIMIT, "an image of %lld x %lld texels: expected 1 to %d a side, %llu in all",
                         (long long)width, (long long)height, (int)SCENE_MAX_IMAGE_SIZE,
                         (unsigned long long)PICTURE_MAX_TEXELS);
    return FAULT_NONE;
}

static double srgb_to_linear(double v) /* IEC 61966-2-1 */
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static double decode(picture_coding_t coding, double v)
{
    switch (coding.kind) {
    case PICTURE_CODING_SRGB:
        return srgb_to_linear(v);
    case PICTURE_CODING_GAMMA:
        return pow(v, coding.gamma);
    default:
        return v;
    }
}

/* Grey with alpha is not a layout of scenes: to four channels. */
static int wanted_channels(int found)
{
    return found == 2 ? 4 : found;
}

static fault_code_t failed(fault_t *fault)
{
    const char *reason = stbi_failure_reason();
    return fault_set(fault, FAULT_FORMAT,
                     "not an image that can be read (%s): expected PNG, JPEG, TGA, BMP, HDR, "
                     "PFM or OpenEXR",
                     reason ? reason : "unknown format");
}

/* Integer samples of `depth` 8 or 16 bits to floats. */
static fault_code_t to_floats(picture_t *out, const void *samples, int depth, picture_coding_t coding,
                              fault_t *fault)
{
    const size_t count = (size_t)out->width * out->height * out->channels;
    const int levels = depth == 8 ? 256 : 65536;
    float *linear = malloc((size_t)levels * sizeof *linear), *texels = malloc(count * sizeof *texels);
    if (!linear || !texels) {
        free(linear);
        free(texels);
        return fault_set(fault, FAULT_MEMORY, "no memory for an image of %zu samples", count);
    }
    for (int i = 0; i < levels; i++)
        linear[i] = (float)decode(coding, i / (double)(levels - 1));
    for (size_t i = 0; i < count; i++) {
        const unsigned sample = depth == 8 ? ((const uint8_t *)samples)[i] : ((const uint16_t *)samples)[i];
        const bool alpha = out->channels == 4 && i % 4 == 3;
        texels[i] = alpha ? (float)sample / (float)(levels - 1) : linear[sample];
    }
    free(linear);
    out->texels = texels;
    out->texel = SCENE_TEXEL_FLOAT32;
    out->bytes = count * sizeof *texels;
    return FAULT_NONE;
}

/* Takes `samples` (stb's, which come from malloc) as the image's texels or converts and frees them. */
static fault_code_t keep(picture_t *out, void *samples, int depth, picture_coding_t coding, fault_t *fault)
{
    if (!samples)
        return failed(fault);
    const size_t count = (size_t)out->width * out->height * out->channels;
    if (depth == 8 && coding.kind != PICTURE_CODING_GAMMA) {
        out->texels = samples;
        out->texel = coding.kind == PICTURE_CODING_SRGB ? SCENE_TEXEL_SRGB8 : SCENE_TEXEL_LINEAR8;
        out->bytes = count;
        return FAULT_NONE;
    }
    if (depth == 32) {
        out->texels = samples;
        out->texel = SCENE_TEXEL_FLOAT32;
        out->bytes = count * sizeof(float);
        return FAULT_NONE;
    }
    const fault_code_t code = to_floats(out, samples, depth, coding, fault);
    stbi_image_free(samples);
    return code;
}

/* PNG, JPEG, BMP or HDR by their marks. Other formats that stb_image knows are left alone. */
static bool has_mark(const uint8_t *data, size_t size)
{
    return (size >= 8 && memcmp(data, "\x89PNG\r\n\x1a\n", 8) == 0) ||
           (size >= 3 && memcmp(data, "\xff\xd8\xff", 3) == 0) || (size >= 2 && memcmp(data, "BM", 2) == 0) ||
           (size >= 2 && memcmp(data, "#?", 2) == 0);
}

/* True if the bytes can be a Targa file and hold all of its picture, which stb_image does not check. */
static bool is_whole_tga(const uint8_t *d, size_t size)
{
    enum { HEADER = 18 };
    if (size <= HEADER || d[1] > 1)
        return false;
    const uint32_t kind = d[2] & 7u, packed = d[2] & 8u, bits = d[16];
    const uint64_t map = d[1] ? (d[5] | (uint64_t)d[6] << 8) * ((d[7] + 7u) / 8) : 0;
    const uint64_t count = (uint64_t)(d[12] | d[13] << 8) * (uint64_t)(d[14] | d[15] << 8);
    if (kind < 1 || kind > 3 || (d[2] & ~11u) ||
        (bits != 8 && bits != 15 && bits != 16 && bits != 24 && bits != 32))
        return false;
    /* A packet of run-length coding has a byte and a texel for at most 128 texels. */
    const uint64_t texel = (bits + 7) / 8, needed = packed ? (count + 127) / 128 * (1 + texel) : count * texel;
    return size - HEADER >= d[0] + map + needed;
}

static fault_code_t parse_stb(const uint8_t *data, size_t size, picture_coding_t coding, picture_t *out,
                              fault_t *fault)
{
    const int length = (int)size;
    int width = 0, height = 0, found = 0;
    if (!has_mark(data, size) && !is_whole_tga(data, size))
        return fault_set(fault, FAULT_FORMAT,
                         "not an image that can be read: expected PNG, JPEG, TGA, BMP, HDR, PFM or OpenEXR");
    if (!stbi_info_from_memory(data, length, &width, &height, &found))
        return failed(fault);
    TRY(check_size(width, height, fault));
    const int channels = wanted_channels(found);
    if (channels != 1 && channels != 3 && channels != 4)
        return fault_set(fault, FAULT_FORMAT, "an image of %d channels: expected 1 to 4", found);
    out->channels = (uint32_t)channels;
    void *samples;
    int depth = 8;
    if (stbi_is_hdr_from_memory(data, length)) {
        depth = 32;
        samples = stbi_loadf_from_memory(data, length, &width, &height, &found, channels);
    } else if (stbi_is_16_bit_from_memory(data, length)) {
        depth = 16;
        samples = stbi_load_16_from_memory(data, length, &width, &height, &found, channels);
    } else {
        samples = stbi_load_from_memory(data, length, &width, &height, &found, channels);
    }
    out->width = (uint32_t)width;
    out->height = (uint32_t)height;
    return keep(out, samples, depth, coding, fault);
}

/* Which planes make the texels: R, G, B, perhaps A, or Y. Returns their number, 0 if there is no picture in them.
 */
static uint32_t find_planes(const image_t *image, const float *planes[4])
{
    static const char *const names[] = {"R", "G", "B", "A"};
    uint32_t found = 0;
    for (; found < 4; found++) {
        const int c = image_find(image, names[found]);
        if (c < 0)
            break;
        planes[found] = image_channel(image, (uint32_t)c);
    }
    if (found >= 3)
        return found;
    const int grey = image_find(image, "Y");
    if (grey < 0)
        return 0;
    planes[0] = image_channel(image, (uint32_t)grey);
    return 1;
}

static fault_code_t from_planes(const image_t *image, picture_t *out, fault_t *fault)
{
    const float *planes[4];
    TRY(check_size(image->width, image->height, fault));
    const uint32_t channels = find_planes(image, planes);
    if (channels == 0)
        return fault_set(fault, FAULT_FORMAT, "an image without channels R, G, B or Y");
    const size_t count = (size_t)image->width * image->height;
    float *texels = malloc(count * channels * sizeof *texels);
    if (!texels)
        return fault_set(fault, FAULT_MEMORY, "no memory for an image of %zu texels", count);
    for (size_t i = 0; i < count; i++)
        for (uint32_t c = 0; c < channels; c++)
            texels[i * channels + c] = planes[c][i];
    out->width = image->width;
    out->height = image->height;
    out->channels = channels;
    out->texel = SCENE_TEXEL_FLOAT32;
    out->bytes = count * channels * sizeof *texels;
    out->texels = texels;
    return FAULT_NONE;
}

static fault_code_t parse_planes(const uint8_t *data, size_t size, bool exr, picture_t *out, fault_t *fault)
{
    image_t image;
    TRY(exr ? exr_decode(&image, data, size, fault) : pfm_decode(&image, data, size, fault));
    const fault_code_t code = from_planes(&image, out, fault);
    image_clear(&image);
    return code;
}

static fault_code_t check_finite(const picture_t *image, fault_t *fault)
{
    const float *samples = image->texels;
    const size_t row = (size_t)image->width * image->channels;
    for (size_t i = 0; image->texel == SCENE_TEXEL_FLOAT32 && i < row * image->height; i++)
        if (!isfinite(samples[i]))
            return fault_set(fault, FAULT_FORMAT, "the texel in column %zu, row %zu is not a finite number",
                             i % row / image->channels, i / row);
    return FAULT_NONE;
}

static bool is_opaque(const picture_t *image)
{
    const size_t count = (size_t)image->width * image->height;
    if (image->channels < 4)
        return true;
    for (size_t i = 0; i < count; i++)
        if (image->texel == SCENE_TEXEL_FLOAT32 ? ((const float *)image->texels)[4 * i + 3] < 1
                                                : ((const uint8_t *)image->texels)[4 * i + 3] < 255)
            return false;
    return true;
}

fault_code_t picture_parse(const uint8_t *data, size_t size, picture_coding_t coding, picture_t *out,
                           fault_t *fault)
{
    memset(out, 0, sizeof *out);
    fault_code_t code;
    if (size > FILE_MAX)
        return fault_set(fault, FAULT_LIMIT, "an image file of %zu bytes: expected at most %d", size, FILE_MAX);
    if (size >= 4 && memcmp(data, "\x76\x2f\x31\x01", 4) == 0)
        code = parse_planes(data, size, true, out, fault);
    else if (size >= 3 && data[0] == 'P' && (data[1] == 'F' || data[1] == 'f') && strchr(" \t\r\n", data[2]))
        code = parse_planes(data, size, false, out, fault);
    else
        code = parse_stb(data, size, coding, out, fault);
    if (code == FAULT_NONE)
        code = check_finite(out, fault);
    if (code)
        picture_clear(out);
    else
        out->opaque = is_opaque(out);
    return code;
}

fault_code_t picture_read(const char *path, picture_coding_t coding, picture_t *out, fault_t *fault)
{
    uint8_t *data = NULL;
    size_t size = 0;
    memset(out, 0, sizeof *out);
    TRY(file_read(path, FILE_MAX, &data, &size, fault));
    const fault_code_t code = picture_parse(data, size, coding, out, fault);
    free(data);
    return fault_prefix(fault, code, "%s", path);
}

void picture_texel(const picture_t *image, uint32_t x, uint32_t y, float rgba[4])
{
    const size_t at = ((size_t)y * image->width + x) * image->channels;
    for (uint32_t c = 0; c < 4; c++) {
        const uint32_t source = image->channels == 1 && c < 3 ? 0 : c;
        if (source >= image->channels)
            rgba[c] = 1;
        else if (image->texel == SCENE_TEXEL_FLOAT32)
            rgba[c] = ((const float *)image->texels)[at + source];
        else if (image->texel == SCENE_TEXEL_SRGB8 && source < 3)
            rgba[c] = (float)srgb_to_linear(((const uint8_t *)image->texels)[at + source] / 255.0);
        else
            rgba[c] = (float)((const uint8_t *)image->texels)[at + source] / 255.0f;
    }
}
