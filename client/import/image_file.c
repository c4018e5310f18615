#include "client/import/image_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STBI_NO_STDIO
#include <stb/stb_image.h>

#include "base/file.h"
#include "client/import/image_exr.h"

enum { FILE_MAX = 1 << 30 };

void image_file_clear(image_file_t *image)
{
    free(image->texels);
    memset(image, 0, sizeof *image);
}

static fault_code_t check_size(int64_t width, int64_t height, fault_t *fault)
{
    if (width < 1 || height < 1 || width > SCENE_MAX_IMAGE_SIZE || height > SCENE_MAX_IMAGE_SIZE ||
        (uint64_t)(width * height) > IMAGE_FILE_MAX_TEXELS)
        return fault_set(fault, FAULT_LIMIT, "an image of %lld x %lld texels: expected 1 to %d a side, %llu in all",
                         (long long)width, (long long)height, (int)SCENE_MAX_IMAGE_SIZE,
                         (unsigned long long)IMAGE_FILE_MAX_TEXELS);
    return FAULT_NONE;
}

static double srgb_to_linear(double v) /* IEC 61966-2-1 */
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static double decode(image_coding_t coding, double v)
{
    switch (coding.kind) {
    case IMAGE_CODING_SRGB:
        return srgb_to_linear(v);
    case IMAGE_CODING_GAMMA:
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
static fault_code_t to_floats(image_file_t *out, const void *samples, int depth, image_coding_t coding,
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
static fault_code_t keep(image_file_t *out, void *samples, int depth, image_coding_t coding, fault_t *fault)
{
    if (!samples)
        return failed(fault);
    const size_t count = (size_t)out->width * out->height * out->channels;
    if (depth == 8 && coding.kind != IMAGE_CODING_GAMMA) {
        out->texels = samples;
        out->texel = coding.kind == IMAGE_CODING_SRGB ? SCENE_TEXEL_SRGB8 : SCENE_TEXEL_LINEAR8;
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

static fault_code_t parse_stb(const uint8_t *data, size_t size, image_coding_t coding, image_file_t *out,
                              fault_t *fault)
{
    const int length = (int)size;
    int width = 0, height = 0, found = 0;
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

/* One white-space separated word of a PFM header. */
static bool header_word(const uint8_t *data, size_t size, size_t *at, char word[32])
{
    size_t length = 0;
    while (*at < size && strchr(" \t\r\n", data[*at]) && data[*at])
        (*at)++;
    while (*at < size && data[*at] && !strchr(" \t\r\n", data[*at]) && length < 31)
        word[length++] = (char)data[(*at)++];
    word[length] = 0;
    return length > 0;
}

static float float_at(const uint8_t *data, bool big_endian)
{
    uint32_t bits;
    memcpy(&bits, data, 4);
    if (big_endian)
        bits = __builtin_bswap32(bits);
    float value;
    memcpy(&value, &bits, 4);
    return value;
}

/* Portable float map (Debevec): "PF" or "Pf", width, height, scale (negative: little endian), rows from the bottom.
 */
static fault_code_t parse_pfm(const uint8_t *data, size_t size, image_file_t *out, fault_t *fault)
{
    char word[4][32];
    size_t at = 0;
    for (int i = 0; i < 4; i++)
        if (!header_word(data, size, &at, word[i]))
            return fault_set(fault, FAULT_FORMAT, "a PFM header that ends early");
    const long width = strtol(word[1], NULL, 10), height = strtol(word[2], NULL, 10);
    TRY(check_size(width, height, fault));
    const double scale = strtod(word[3], NULL);
    out->channels = word[0][1] == 'F' ? 3 : 1;
    const size_t row = (size_t)width * out->channels, expected = row * (size_t)height * 4;
    if (at >= size || size - at - 1 < expected)
        return fault_set(fault, FAULT_FORMAT, "a PFM of %ld x %ld with %zu bytes of samples: expected %zu", width,
                         height, at >= size ? 0 : size - at - 1, expected);
    const uint8_t *samples = data + at + 1;
    float *texels = malloc(expected);
    if (!texels)
        return fault_set(fault, FAULT_MEMORY, "no memory for an image of %zu bytes", expected);
    for (long y = 0; y < height; y++)
        for (size_t x = 0; x < row; x++)
            texels[(size_t)y * row + x] = float_at(samples + 4 * ((size_t)(height - 1 - y) * row + x), scale > 0);
    out->width = (uint32_t)width;
    out->height = (uint32_t)height;
    out->texel = SCENE_TEXEL_FLOAT32;
    out->bytes = expected;
    out->texels = texels;
    return FAULT_NONE;
}

static fault_code_t parse_exr(const uint8_t *data, size_t size, image_file_t *out, fault_t *fault)
{
    float *texels = NULL;
    TRY(image_exr_parse(data, size, &out->width, &out->height, &out->channels, &texels, fault));
    out->texel = SCENE_TEXEL_FLOAT32;
    out->bytes = (size_t)out->width * out->height * out->channels * sizeof(float);
    out->texels = texels;
    return FAULT_NONE;
}

static fault_code_t check_finite(const image_file_t *image, fault_t *fault)
{
    const float *samples = image->texels;
    const size_t row = (size_t)image->width * image->channels;
    for (size_t i = 0; image->texel == SCENE_TEXEL_FLOAT32 && i < row * image->height; i++)
        if (!isfinite(samples[i]))
            return fault_set(fault, FAULT_FORMAT, "the texel in column %zu, row %zu is not a finite number",
                             i % row / image->channels, i / row);
    return FAULT_NONE;
}

static bool is_opaque(const image_file_t *image)
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

fault_code_t image_file_parse(const uint8_t *data, size_t size, image_coding_t coding, image_file_t *out,
                              fault_t *fault)
{
    memset(out, 0, sizeof *out);
    fault_code_t code;
    if (size > FILE_MAX)
        return fault_set(fault, FAULT_LIMIT, "an image file of %zu bytes: expected at most %d", size, FILE_MAX);
    if (size >= 4 && memcmp(data, "\x76\x2f\x31\x01", 4) == 0)
        code = parse_exr(data, size, out, fault);
    else if (size >= 3 && data[0] == 'P' && (data[1] == 'F' || data[1] == 'f') && strchr(" \t\r\n", data[2]))
        code = parse_pfm(data, size, out, fault);
    else
        code = parse_stb(data, size, coding, out, fault);
    if (code == FAULT_NONE)
        code = check_finite(out, fault);
    if (code)
        image_file_clear(out);
    else
        out->opaque = is_opaque(out);
    return code;
}

fault_code_t image_file_read(const char *path, image_coding_t coding, image_file_t *out, fault_t *fault)
{
    uint8_t *data = NULL;
    size_t size = 0;
    memset(out, 0, sizeof *out);
    TRY(file_read(path, FILE_MAX, &data, &size, fault));
    const fault_code_t code = image_file_parse(data, size, coding, out, fault);
    free(data);
    if (code)
        fault_prefix(fault, "%s", path);
    return code;
}

void image_file_texel(const image_file_t *image, uint32_t x, uint32_t y, float rgba[4])
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
