#include "client/import/image_exr.h"

#include <stdlib.h>
#include <string.h>

#include <openexr.h>

#include "client/import/image_file.h"

typedef struct source {
    const uint8_t *data;
    size_t size;
    char problem[256]; /* the library's last complaint */
} source_t;

typedef struct target {
    int x0, y0; /* of the data window */
    uint32_t width, height, channels;
    float *texels;
} target_t;

static void remember_problem(exr_const_context_t context, exr_result_t code, const char *text)
{
    void *user = NULL;
    (void)code;
    if (exr_get_user_data(context, &user) == EXR_ERR_SUCCESS && user) {
        source_t *source = user;
        strncpy(source->problem, text, sizeof source->problem - 1);
    }
}

static int64_t read_bytes(exr_const_context_t context, void *user, void *buffer, uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t report)
{
    const source_t *source = user;
    if (offset > source->size || size > source->size - offset) {
        report(context, EXR_ERR_READ_IO, "the file ends early");
        return -1;
    }
    memcpy(buffer, source->data + offset, size);
    return (int64_t)size;
}

static int64_t count_bytes(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((const source_t *)user)->size;
}

/* Where channel `name` goes among the interleaved ones, or -1. */
static int channel_slot(const char *name, uint32_t channels)
{
    static const char *const names[] = {"R", "G", "B", "A"};
    if (channels == 1)
        return strcmp(name, "Y") == 0 ? 0 : -1;
    for (int i = 0; i < (int)channels; i++)
        if (strcmp(name, names[i]) == 0)
            return i;
    return -1;
}

/* 4, 3 or 1 by the channels there are; 0 if there is no picture in them. */
static uint32_t count_channels(const exr_attr_chlist_t *list)
{
    uint32_t found = 0, grey = 0;
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        if (entry->x_sampling != 1 || entry->y_sampling != 1)
            continue;
        const int slot = channel_slot(entry->name.str, 4);
        if (slot >= 0)
            found |= 1u << slot;
        grey |= strcmp(entry->name.str, "Y") == 0;
    }
    return found == 15 ? 4 : (found & 7) == 7 ? 3 : grey ? 1 : 0;
}

/* Decodes one chunk into the target at (x, y) of the data window. */
static exr_result_t decode_chunk(exr_context_t context, const exr_chunk_info_t *chunk,
                                 exr_decode_pipeline_t *pipeline, bool first, const target_t *target, uint32_t x,
                                 uint32_t y)
{
    exr_result_t code = first ? exr_decoding_initialize(context, 0, chunk, pipeline)
                              : exr_decoding_update(context, 0, chunk, pipeline);
    if (code != EXR_ERR_SUCCESS)
        return code;
    if (x + (uint64_t)chunk->width > target->width || y + (uint64_t)chunk->height > target->height)
        return EXR_ERR_BAD_CHUNK_LEADER;
    for (int c = 0; c < pipeline->channel_count; c++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[c];
        const int slot = channel_slot(channel->channel_name, target->channels);
        channel->decode_to_ptr = NULL;
        if (slot < 0 || channel->x_samples != 1 || channel->y_samples != 1)
            continue;
        float *to = target->texels + ((size_t)y * target->width + x) * target->channels + slot;
        channel->decode_to_ptr = (uint8_t *)to;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = 4;
        channel->user_pixel_stride = (int32_t)(4 * target->channels);
        channel->user_line_stride = (int32_t)(4 * target->channels * target->width);
    }
    code = exr_decoding_choose_default_routines(context, 0, pipeline);
    return code == EXR_ERR_SUCCESS ? exr_decoding_run(context, 0, pipeline) : code;
}

static exr_result_t decode_lines(exr_context_t context, exr_decode_pipeline_t *pipeline, bool *started,
                                 const target_t *target)
{
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(context, 0, &lines);
    if (code == EXR_ERR_SUCCESS && lines < 1)
        return EXR_ERR_INVALID_ATTR;
    for (uint32_t y = 0; code == EXR_ERR_SUCCESS && y < target->height; y += (uint32_t)lines) {
        exr_chunk_info_t chunk;
        code = exr_read_scanline_chunk_info(context, 0, target->y0 + (int)y, &chunk);
        if (code == EXR_ERR_SUCCESS) {
            code = decode_chunk(context, &chunk, pipeline, !*started, target, 0, y);
            *started = true;
        }
    }
    return code;
}

static exr_result_t decode_tiles(exr_context_t context, exr_decode_pipeline_t *pipeline, bool *started,
                                 const target_t *target)
{
    int32_t tile_w = 0, tile_h = 0;
    exr_result_t code = exr_get_tile_sizes(context, 0, 0, 0, &tile_w, &tile_h);
    if (code == EXR_ERR_SUCCESS && (tile_w < 1 || tile_h < 1))
        return EXR_ERR_INVALID_ATTR;
    for (uint32_t y = 0; code == EXR_ERR_SUCCESS && y < target->height; y += (uint32_t)tile_h)
        for (uint32_t x = 0; code == EXR_ERR_SUCCESS && x < target->width; x += (uint32_t)tile_w) {
            exr_chunk_info_t chunk;
            code = exr_read_tile_chunk_info(context, 0, (int)(x / (uint32_t)tile_w), (int)(y / (uint32_t)tile_h), 0,
                                            0, &chunk);
            if (code == EXR_ERR_SUCCESS) {
                code = decode_chunk(context, &chunk, pipeline, !*started, target, x, y);
                *started = true;
            }
        }
    return code;
}

static fault_code_t complain(const source_t *source, exr_result_t code, fault_t *fault)
{
    return fault_set(fault, FAULT_FORMAT, "OpenEXR file that cannot be read: %s",
                     source->problem[0] ? source->problem : exr_get_default_error_message(code));
}

static fault_code_t read_part(exr_context_t context, const source_t *source, target_t *target, fault_t *fault)
{
    exr_storage_t storage;
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *list = NULL;
    exr_result_t code = exr_get_storage(context, 0, &storage);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_data_window(context, 0, &window);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_channels(context, 0, &list);
    if (code != EXR_ERR_SUCCESS)
        return complain(source, code, fault);
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return fault_set(fault, FAULT_UNSUPPORTED, "a deep OpenEXR file: expected scan lines or tiles");
    const int64_t width = (int64_t)window.max.x - window.min.x + 1,
                  height = (int64_t)window.max.y - window.min.y + 1;
    if (width < 1 || height < 1 || width > SCENE_MAX_IMAGE_SIZE || height > SCENE_MAX_IMAGE_SIZE ||
        (uint64_t)(width * height) > IMAGE_FILE_MAX_TEXELS)
        return fault_set(fault, FAULT_LIMIT, "an OpenEXR data window of %lld x %lld texels", (long long)width,
                         (long long)height);
    *target = (target_t){window.min.x, window.min.y, (uint32_t)width, (uint32_t)height, count_channels(list), NULL};
    if (target->channels == 0)
        return fault_set(fault, FAULT_FORMAT, "an OpenEXR file without channels R, G, B or Y");
    target->texels = calloc((size_t)width * (size_t)height * target->channels, sizeof(float));
    if (!target->texels)
        return fault_set(fault, FAULT_MEMORY, "no memory for an image of %u x %u", target->width, target->height);
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    bool started = false;
    code = storage == EXR_STORAGE_TILED ? decode_tiles(context, &pipeline, &started, target)
                                        : decode_lines(context, &pipeline, &started, target);
    if (started)
        exr_decoding_destroy(context, &pipeline);
    return code == EXR_ERR_SUCCESS ? FAULT_NONE : complain(source, code, fault);
}

fault_code_t image_exr_parse(const uint8_t *data, size_t size, uint32_t *width, uint32_t *height,
                             uint32_t *channels, float **texels, fault_t *fault)
{
    source_t source = {data, size, ""};
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = remember_problem;
    setup.user_data = &source;
    setup.read_fn = read_bytes;
    setup.size_fn = count_bytes;
    setup.max_image_width = setup.max_image_height = SCENE_MAX_IMAGE_SIZE;
    exr_context_t context = NULL;
    const exr_result_t code = exr_start_read(&context, "image", &setup);
    if (code != EXR_ERR_SUCCESS)
        return complain(&source, code, fault);
    target_t target = {0};
    const fault_code_t result = read_part(context, &source, &target, fault);
    exr_finish(&context);
    if (result) {
        free(target.texels);
        return result;
    }
    *width = target.width;
    *height = target.height;
    *channels = target.channels;
    *texels = target.texels;
    return FAULT_NONE;
}
