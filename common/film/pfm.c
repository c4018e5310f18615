#include "film/pfm.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

typedef struct header {
    uint32_t width, height, channels;
    double scale; /* negative: little-endian */
    size_t size;  /* bytes up to the numbers */
} header_t;

enum { MAX_WORD = 32 };

static bool is_space(uint8_t c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* The next word and the one white-space byte that ends it; false at the end of the data or if it is too long. */
static bool next_word(const uint8_t *data, size_t size, size_t *at, char word[MAX_WORD])
{
    while (*at < size && is_space(data[*at]))
        (*at)++;
    size_t length = 0;
    while (*at < size && !is_space(data[*at]) && length + 1 < MAX_WORD)
        word[length++] = (char)data[(*at)++];
    word[length] = '\0';
    if (length == 0 || *at == size || !is_space(data[*at]))
        return false;
    (*at)++;
    return true;
}

static bool parse_side(const char *word, uint32_t *out)
{
    char *end;
    if (word[0] < '0' || word[0] > '9')
        return false;
    const unsigned long value = strtoul(word, &end, 10);
    *out = value > UINT32_MAX ? UINT32_MAX : (uint32_t)value;
    return *end == '\0';
}

static fault_code_t parse_header(header_t *header, const uint8_t *data, size_t size, fault_t *fault)
{
    char word[MAX_WORD];
    size_t at = 0;
    if (size < 2 || data[0] != 'P' || (data[1] != 'F' && data[1] != 'f') || !next_word(data, size, &at, word) ||
        word[2] != '\0')
        return fault_set(fault, FAULT_FORMAT, "PFM, byte 0: expected a line \"PF\" or \"Pf\"");
    header->channels = data[1] == 'F' ? 3 : 1;
    if (!next_word(data, size, &at, word) || !parse_side(word, &header->width))
        return fault_set(fault, FAULT_FORMAT, "PFM, byte %zu: width \"%s\", a whole number expected", at, word);
    if (!next_word(data, size, &at, word) || !parse_side(word, &header->height))
        return fault_set(fault, FAULT_FORMAT, "PFM, byte %zu: height \"%s\", a whole number expected", at, word);
    char *end = word;
    const bool whole = next_word(data, size, &at, word);
    header->scale = strtod(word, &end);
    if (!whole || end == word || *end != '\0' || !isfinite(header->scale) || header->scale == 0)
        return fault_set(fault, FAULT_FORMAT, "PFM, byte %zu: scale \"%s\", a number other than zero expected", at,
                         word);
    header->size = at;
    return FAULT_NONE;
}

static float get_float(const uint8_t *from, bool little)
{
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++)
        bits |= (uint32_t)from[i] << (little ? 8 * i : 24 - 8 * i);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void put_float(uint8_t *to, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t)(bits >> (8 * i));
}

static void get_rows(const image_t *image, const header_t *header, const uint8_t *from)
{
    const bool little = header->scale < 0;
    const float unit = (float)fabs(header->scale);
    for (uint32_t y = image->height; y-- > 0;)
        for (uint32_t x = 0; x < image->width; x++)
            for (uint32_t c = 0; c < image->channel_count; c++, from += 4)
                image_channel(image, c)[(size_t)y * image->width + x] = unit * get_float(from, little);
}

fault_code_t pfm_decode(image_t *image, const uint8_t *data, size_t size, fault_t *fault)
{
    *image = (image_t){0};
    header_t header = {0};
    TRY(parse_header(&header, data, size, fault));
    const unsigned long long need = header.size + 4ull * header.channels * header.width * header.height;
    if (header.width <= IMAGE_MAX_SIDE && header.height <= IMAGE_MAX_SIDE && size != need)
        return fault_set(fault, FAULT_FORMAT, "PFM of %u x %u pixels: %zu bytes found, %llu expected", header.width,
                         header.height, size, need);
    static const char *const colour[] = {"R", "G", "B"}, *const grey[] = {"Y"};
    TRY(image_init(image, header.width, header.height, header.channels, header.channels == 3 ? colour : grey,
                   fault));
    get_rows(image, &header, data + header.size);
    return FAULT_NONE;
}

fault_code_t pfm_read(image_t *image, const char *path, fault_t *fault)
{
    *image = (image_t){0};
    uint8_t *data;
    size_t size;
    TRY(file_read(path, IMAGE_MAX_FILE_BYTES, &data, &size, fault));
    const fault_code_t code = pfm_decode(image, data, size, fault);
    free(data);
    return fault_prefix(fault, code, "%s", path);
}

fault_code_t pfm_encode(const image_t *image, uint8_t **data, size_t *size, fault_t *fault)
{
    *data = NULL;
    *size = 0;
    const float *planes[3];
    TRY(image_find_rgb(image, planes, fault));
    const uint32_t channels = planes[0] == planes[1] && planes[1] == planes[2] ? 1 : 3;
    char header[64];
    const int length = snprintf(header, sizeof header, "%s\n%u %u\n-1\n", channels == 3 ? "PF" : "Pf", image->width,
                                image->height);
    const size_t total = (size_t)length + (size_t)4 * channels * image->width * image->height;
    uint8_t *out = malloc(total);
    if (!out)
        return fault_set(fault, FAULT_MEMORY, "PFM of %u x %u pixels: out of memory", image->width, image->height);
    memcpy(out, header, (size_t)length);
    uint8_t *to = out + length;
    for (uint32_t y = image->height; y-- > 0;)
        for (uint32_t x = 0; x < image->width; x++)
            for (uint32_t c = 0; c < channels; c++, to += 4)
                put_float(to, planes[c][(size_t)y * image->width + x]);
    *data = out;
    *size = total;
    return FAULT_NONE;
}

fault_code_t pfm_write(const image_t *image, const char *path, fault_t *fault)
{
    uint8_t *data;
    size_t size;
    const fault_code_t encoded = pfm_encode(image, &data, &size, fault);
    if (encoded != FAULT_NONE)
        return fault_prefix(fault, encoded, "%s", path);
    const fault_code_t code = file_write(path, data, size, fault);
    free(data);
    return code;
}
