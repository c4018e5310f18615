#include "film/image.h"

#include <stdlib.h>
#include <string.h>

static fault_code_t check_size(uint32_t width, uint32_t height, uint32_t channel_count, fault_t *fault)
{
    if (width == 0 || height == 0 || width > IMAGE_MAX_SIDE || height > IMAGE_MAX_SIDE)
        return fault_set(fault, FAULT_RANGE, "image of %u x %u pixels: each side must be 1 to %d", width, height,
                         IMAGE_MAX_SIDE);
    if (channel_count == 0 || channel_count > IMAGE_MAX_CHANNELS)
        return fault_set(fault, FAULT_RANGE, "image with %u channels: 1 to %d expected", channel_count,
                         IMAGE_MAX_CHANNELS);
    if ((uint64_t)width * height * channel_count * sizeof(float) > IMAGE_MAX_BYTES)
        return fault_set(fault, FAULT_LIMIT, "image of %u x %u pixels with %u channels: more than %llu bytes",
                         width, height, channel_count, (unsigned long long)IMAGE_MAX_BYTES);
    return FAULT_NONE;
}

static fault_code_t set_names(image_t *image, uint32_t count, const char *const *names, fault_t *fault)
{
    for (uint32_t c = 0; c < count; c++) {
        const size_t length = strlen(names[c]);
        if (length == 0 || length >= IMAGE_NAME_SIZE)
            return fault_set(fault, FAULT_RANGE, "image channel %u: name of %zu bytes, 1 to %d expected", c, length,
                             IMAGE_NAME_SIZE - 1);
        image->channel_count = c;
        if (image_find(image, names[c]) >= 0)
            return fault_set(fault, FAULT_RANGE, "image channel %u: name \"%s\" occurs twice", c, names[c]);
        memcpy(image->names[c], names[c], length + 1);
    }
    image->channel_count = count;
    return FAULT_NONE;
}

fault_code_t image_init(image_t *image, uint32_t width, uint32_t height, uint32_t channel_count,
                        const char *const *names, fault_t *fault)
{
    *image = (image_t){0};
    TRY(check_size(width, height, channel_count, fault));
    image->width = width;
    image->height = height;
    image->names = calloc(channel_count, sizeof *image->names);
    image->data = calloc((size_t)width * height, channel_count * sizeof *image->data);
    fault_code_t code = FAULT_NONE;
    if (!image->names || !image->data)
        code = fault_set(fault, FAULT_MEMORY, "image of %u x %u pixels with %u channels: out of memory", width,
                         height, channel_count);
    else
        code = set_names(image, channel_count, names, fault);
    if (code != FAULT_NONE)
        image_clear(image);
    return code;
}

fault_code_t image_init_rgb(image_t *image, uint32_t width, uint32_t height, fault_t *fault)
{
    static const char *const names[] = {"R", "G", "B"};
    return image_init(image, width, height, 3, names, fault);
}

void image_clear(image_t *image)
{
    for (uint32_t i = 0; i < image->attribute_count; i++) {
        free(image->attributes[i].name);
        free(image->attributes[i].value);
    }
    free(image->attributes);
    free(image->names);
    free(image->data);
    *image = (image_t){0};
}

int image_find(const image_t *image, const char *name)
{
    for (uint32_t c = 0; c < image->channel_count; c++)
        if (strcmp(image->names[c], name) == 0)
            return (int)c;
    return -1;
}

/* "A, B, C" of the channels' names, cut short where it doesn't fit. */
static void list_names(const image_t *image, char *text, size_t size)
{
    size_t at = 0;
    text[0] = '\0';
    for (uint32_t c = 0; c < image->channel_count; c++) {
        const char *gap = c ? ", " : "";
        const size_t need = strlen(gap) + strlen(image->names[c]);
        if (at + need + sizeof ", ..." > size) {
            strcpy(text + at, ", ...");
            return;
        }
        strcpy(text + at, gap);
        strcat(text + at, image->names[c]);
        at += need;
    }
}

fault_code_t image_find_rgb(const image_t *image, const float *planes[3], fault_t *fault)
{
    static const char *const names[] = {"R", "G", "B"};
    const int grey = image_find(image, "Y");
    for (int c = 0; c < 3; c++) {
        int index = image_find(image, names[c]);
        if (index < 0)
            index = grey;
        if (index < 0) {
            char found[300];
            list_names(image, found, sizeof found);
            return fault_set(fault, FAULT_NOT_FOUND, "no channel \"%s\" nor \"Y\": found %s", names[c], found);
        }
        planes[c] = image_channel(image, (uint32_t)index);
    }
    return FAULT_NONE;
}

static image_attribute_t *find_attribute(const image_t *image, const char *name)
{
    for (uint32_t i = 0; i < image->attribute_count; i++)
        if (strcmp(image->attributes[i].name, name) == 0)
            return &image->attributes[i];
    return NULL;
}

static fault_code_t add_attribute(image_t *image, const char *name, char *value, fault_t *fault)
{
    if (image->attribute_count == IMAGE_MAX_ATTRIBUTES)
        return fault_set(fault, FAULT_LIMIT, "image attribute \"%s\": more than %d attributes", name,
                         IMAGE_MAX_ATTRIBUTES);
    image_attribute_t *grown = realloc(image->attributes, (image->attribute_count + 1) * sizeof *grown);
    if (grown)
        image->attributes = grown;
    char *copy = grown ? strdup(name) : NULL;
    if (!copy)
        return fault_set(fault, FAULT_MEMORY, "image attribute \"%s\": out of memory", name);
    image->attributes[image->attribute_count++] = (image_attribute_t){copy, value};
    return FAULT_NONE;
}

fault_code_t image_set_attribute(image_t *image, const char *name, const char *value, fault_t *fault)
{
    const size_t length = strlen(name);
    if (length == 0 || length >= IMAGE_NAME_SIZE)
        return fault_set(fault, FAULT_RANGE, "image attribute: name of %zu bytes, 1 to %d expected", length,
                         IMAGE_NAME_SIZE - 1);
    char *copy = strdup(value);
    if (!copy)
        return fault_set(fault, FAULT_MEMORY, "image attribute \"%s\": out of memory", name);
    image_attribute_t *present = find_attribute(image, name);
    if (present) {
        free(present->value);
        present->value = copy;
        return FAULT_NONE;
    }
    const fault_code_t code = add_attribute(image, name, copy, fault);
    if (code != FAULT_NONE)
        free(copy);
    return code;
}

const char *image_attribute(const image_t *image, const char *name)
{
    const image_attribute_t *attribute = find_attribute(image, name);
    return attribute ? attribute->value : NULL;
}
