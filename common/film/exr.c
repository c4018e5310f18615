#include "film/exr.h"

#include <openexr.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

/* A file in memory, and the first thing the library had to say about it. */
typedef struct stream {
    uint8_t *bytes;
    size_t size, capacity;
    char message[256];
} stream_t;

/* No single allocation of the library may be larger: a chunk is far smaller, and a whole image never passes through
 * it. */
#define EXR_MAX_ALLOCATION ((size_t)1 << 32)
/* An image may be this many times as large as its file (every codec's best case is well below), plus the slack. */
#define EXR_MAX_RATIO UINT64_C(65536)
#define EXR_RATIO_SLACK (UINT64_C(1) << 24)

/* Zeroed: the library's decoders can leave the end of their buffers unset when a chunk's data is cut short or
 * corrupt, and pixels must not show what was in memory before. */
static void *allocate(size_t bytes)
{
    return bytes <= EXR_MAX_ALLOCATION ? calloc(1, bytes) : NULL;
}

static stream_t *stream_of(exr_const_context_t context)
{
    void *data = NULL;
    return exr_get_user_data(context, &data) == EXR_ERR_SUCCESS ? data : NULL;
}

static void on_error(exr_const_context_t context, exr_result_t code, const char *message)
{
    (void)code;
    stream_t *stream = context ? stream_of(context) : NULL;
    if (stream && stream->message[0] == '\0' && message) {
        strncpy(stream->message, message, sizeof stream->message - 1);
        for (char *c = stream->message; *c; c++)
            if ((unsigned char)*c < ' ')
                *c = ' ';
    }
}

static int64_t on_size(exr_const_context_t context, void *data)
{
    (void)context;
    const stream_t *stream = data;
    return (int64_t)stream->size;
}

static int64_t on_read(exr_const_context_t context, void *data, void *buffer, uint64_t size, uint64_t offset,
                       exr_stream_error_func_ptr_t error)
{
    (void)context;
    (void)error;
    const stream_t *stream = data;
    if (offset >= stream->size)
        return 0;
    const size_t left = stream->size - (size_t)offset, count = size < left ? (size_t)size : left;
    memcpy(buffer, stream->bytes + offset, count);
    return (int64_t)count;
}

static int64_t on_write(exr_const_context_t context, void *data, const void *buffer, uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t error)
{
    stream_t *stream = data;
    const uint64_t end = offset + size;
    if (end > stream->capacity) {
        const size_t capacity = end < 4096 ? 4096 : (size_t)end + (size_t)end / 2;
        uint8_t *grown = realloc(stream->bytes, capacity);
        if (!grown) {
            error(context, EXR_ERR_OUT_OF_MEMORY, "out of memory for %llu bytes", (unsigned long long)end);
            return -1;
        }
        stream->bytes = grown;
        stream->capacity = capacity;
    }
    if (offset > stream->size)
        memset(stream->bytes + stream->size, 0, (size_t)offset - stream->size);
    memcpy(stream->bytes + offset, buffer, (size_t)size);
    if (end > stream->size)
        stream->size = (size_t)end;
    return (int64_t)size;
}

static exr_context_initializer_t initializer(stream_t *stream)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = on_error;
    init.alloc_fn = allocate;
    init.free_fn = free;
    init.user_data = stream;
    init.max_image_width = IMAGE_MAX_SIDE;
    init.max_image_height = IMAGE_MAX_SIDE;
    init.max_tile_width = IMAGE_MAX_SIDE;
    init.max_tile_height = IMAGE_MAX_SIDE;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    return init;
}

static fault_code_t library_fault(const stream_t *stream, exr_result_t result, const char *doing, fault_t *fault)
{
    if (result == EXR_ERR_SUCCESS)
        result = EXR_ERR_INVALID_ATTR; /* the call went well, what it gave is impossible */
    const char *text = stream->message[0] ? stream->message : exr_get_default_error_message(result);
    return fault_set(fault, result == EXR_ERR_OUT_OF_MEMORY ? FAULT_MEMORY : FAULT_FORMAT, "OpenEXR, %s: %s", doing,
                     text);
}

/* ---- writing ---- */

/* Of images with noise level 6, zlib's usual one, makes files 2 % smaller than this, in twice the time. */
enum { ZIP_LEVEL = 2 };

static exr_result_t describe(exr_context_t context, const image_t *image)
{
    int part = 0;
    exr_result_t result = exr_set_longname_support(context, 1);
    if (result == EXR_ERR_SUCCESS)
        result = exr_add_part(context, "image", EXR_STORAGE_SCANLINE, &part);
    if (result == EXR_ERR_SUCCESS)
        result = exr_initialize_required_attr_simple(context, part, (int32_t)image->width, (int32_t)image->height,
                                                     EXR_COMPRESSION_ZIP);
    if (result == EXR_ERR_SUCCESS)
        result = exr_set_zip_compression_level(context, part, ZIP_LEVEL);
    for (uint32_t c = 0; c < image->channel_count && result == EXR_ERR_SUCCESS; c++)
        result =
            exr_add_channel(context, part, image->names[c], EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    for (uint32_t i = 0; i < image->attribute_count && result == EXR_ERR_SUCCESS; i++)
        result = exr_attr_set_string(context, part, image->attributes[i].name, image->attributes[i].value);
    return result;
}

/* The library hands its channels over sorted by name; each is pointed at its plane, row y on. */
static exr_result_t point_at_rows(exr_encode_pipeline_t *pipe, const image_t *image, uint32_t y)
{
    for (int16_t i = 0; i < pipe->channel_count; i++) {
        exr_coding_channel_info_t *channel = &pipe->channels[i];
        const int index = image_find(image, channel->channel_name);
        if (index < 0)
            return EXR_ERR_INVALID_ARGUMENT;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = (int32_t)(image->width * sizeof(float));
        channel->encode_from_ptr =
            (const uint8_t *)(image_channel(image, (uint32_t)index) + (size_t)y * image->width);
    }
    return EXR_ERR_SUCCESS;
}

static exr_result_t write_chunks(exr_context_t context, exr_encode_pipeline_t *pipe, const image_t *image)
{
    int32_t lines = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(context, 0, &lines);
    for (int32_t y = 0; y < (int32_t)image->height && result == EXR_ERR_SUCCESS; y += lines) {
        exr_chunk_info_t chunk = {0};
        result = exr_write_scanline_chunk_info(context, 0, y, &chunk);
        if (result == EXR_ERR_SUCCESS)
            result = y == 0 ? exr_encoding_initialize(context, 0, &chunk, pipe)
                            : exr_encoding_update(context, 0, &chunk, pipe);
        if (result == EXR_ERR_SUCCESS)
            result = point_at_rows(pipe, image, (uint32_t)y);
        if (result == EXR_ERR_SUCCESS && y == 0)
            result = exr_encoding_choose_default_routines(context, 0, pipe);
        if (result == EXR_ERR_SUCCESS)
            result = exr_encoding_run(context, 0, pipe);
    }
    return result;
}

static fault_code_t check_attributes(const image_t *image, fault_t *fault)
{
    static const char *const reserved[] = {"name",
                                           "type",
                                           "version",
                                           "chunkCount",
                                           "channels",
                                           "compression",
                                           "dataWindow",
                                           "displayWindow",
                                           "lineOrder",
                                           "tiles",
                                           "pixelAspectRatio",
                                           "screenWindowCenter",
                                           "screenWindowWidth"};
    for (uint32_t i = 0; i < image->attribute_count; i++)
        for (size_t r = 0; r < sizeof reserved / sizeof *reserved; r++)
            if (strcmp(image->attributes[i].name, reserved[r]) == 0)
                return fault_set(fault, FAULT_RANGE, "OpenEXR: attribute name \"%s\" is reserved", reserved[r]);
    return FAULT_NONE;
}

fault_code_t exr_encode(const image_t *image, uint8_t **data, size_t *size, fault_t *fault)
{
    *data = NULL;
    *size = 0;
    TRY(check_attributes(image, fault));
    stream_t stream = {0};
    exr_context_initializer_t init = initializer(&stream);
    init.write_fn = on_write;
    exr_context_t context = NULL;
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    const char *doing = "writing the header";
    exr_result_t result = exr_start_write(&context, "image", EXR_WRITE_FILE_DIRECTLY, &init);
    if (result == EXR_ERR_SUCCESS)
        result = describe(context, image);
    if (result == EXR_ERR_SUCCESS)
        result = exr_write_header(context);
    if (result == EXR_ERR_SUCCESS) {
        doing = "writing pixels";
        result = write_chunks(context, &pipe, image);
        const exr_result_t destroyed = exr_encoding_destroy(context, &pipe);
        result = result == EXR_ERR_SUCCESS ? destroyed : result;
    }
    if (context) {
        const exr_result_t finished = exr_finish(&context);
        result = result == EXR_ERR_SUCCESS ? finished : result;
    }
    if (result != EXR_ERR_SUCCESS) {
        free(stream.bytes);
        return library_fault(&stream, result, doing, fault);
    }
    *data = stream.bytes;
    *size = stream.size;
    return FAULT_NONE;
}

fault_code_t exr_write(const image_t *image, const char *path, fault_t *fault)
{
    uint8_t *data;
    size_t size;
    const fault_code_t encoded = exr_encode(image, &data, &size, fault);
    if (encoded != FAULT_NONE)
        return fault_prefix(fault, encoded, "%s", path);
    const fault_code_t code = file_write(path, data, size, fault);
    free(data);
    return code;
}

/* ---- reading ---- */

typedef struct reader {
    exr_context_t context;
    stream_t *stream;
    exr_decode_pipeline_t pipe;
    bool piped; /* the pipeline has its routines */
    exr_attr_box2i_t window;
    image_t *image;
} reader_t;

/* Channel count and kinds, then the image itself. */
static fault_code_t make_image(reader_t *reader, fault_t *fault)
{
    const exr_attr_chlist_t *list = NULL;
    exr_result_t result = exr_get_channels(reader->context, 0, &list);
    if (result == EXR_ERR_SUCCESS)
        result = exr_get_data_window(reader->context, 0, &reader->window);
    if (result != EXR_ERR_SUCCESS)
        return library_fault(reader->stream, result, "reading the header", fault);
    const exr_attr_box2i_t *w = &reader->window;
    const int64_t width = (int64_t)w->max.x - w->min.x + 1, height = (int64_t)w->max.y - w->min.y + 1;
    if (width < 1 || height < 1 || width > IMAGE_MAX_SIDE || height > IMAGE_MAX_SIDE)
        return fault_set(fault, FAULT_RANGE,
                         "OpenEXR: data window of %lld x %lld pixels, each side must be 1 to %d", (long long)width,
                         (long long)height, IMAGE_MAX_SIDE);
    if (list->num_channels < 1 || list->num_channels > IMAGE_MAX_CHANNELS)
        return fault_set(fault, FAULT_RANGE, "OpenEXR: %d channels found, 1 to %d expected", list->num_channels,
                         IMAGE_MAX_CHANNELS);
    const uint64_t bytes = (uint64_t)width * (uint64_t)height * (uint64_t)list->num_channels * sizeof(float);
    if (bytes > EXR_RATIO_SLACK && (bytes - EXR_RATIO_SLACK) / EXR_MAX_RATIO > reader->stream->size)
        return fault_set(fault, FAULT_LIMIT, "OpenEXR: %zu bytes claim to hold %lld x %lld pixels with %d channels",
                         reader->stream->size, (long long)width, (long long)height, list->num_channels);
    const char *names[IMAGE_MAX_CHANNELS];
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        names[i] = entry->name.str;
        if (entry->x_sampling != 1 || entry->y_sampling != 1)
            return fault_set(fault, FAULT_UNSUPPORTED,
                             "OpenEXR: channel \"%s\" is subsampled by %d x %d, only 1 x 1 "
                             "is supported",
                             names[i], entry->x_sampling, entry->y_sampling);
    }
    return image_init(reader->image, (uint32_t)width, (uint32_t)height, (uint32_t)list->num_channels, names, fault);
}

static fault_code_t copy_attributes(reader_t *reader, fault_t *fault)
{
    int32_t count = 0;
    exr_result_t result = exr_get_attribute_count(reader->context, 0, &count);
    for (int32_t i = 0; i < count && result == EXR_ERR_SUCCESS; i++) {
        const exr_attribute_t *attribute = NULL;
        result = exr_get_attribute_by_index(reader->context, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute);
        if (result != EXR_ERR_SUCCESS || attribute->type != EXR_ATTR_STRING ||
            strcmp(attribute->name, "name") == 0 || strcmp(attribute->name, "type") == 0)
            continue;
        char *value = strndup(attribute->string->str, (size_t)attribute->string->length);
        if (!value)
            return fault_set(fault, FAULT_MEMORY, "OpenEXR: out of memory");
        const fault_code_t code = image_set_attribute(reader->image, attribute->name, value, fault);
        free(value);
        TRY(code);
    }
    return result == EXR_ERR_SUCCESS ? FAULT_NONE
                                     : library_fault(reader->stream, result, "reading the attributes", fault);
}

/* Points the pipeline's channels at pixel (x,y) of the image's planes. */
static bool point_into_planes(reader_t *reader, uint32_t x, uint32_t y)
{
    const image_t *image = reader->image;
    if (reader->pipe.channel_count != (int)image->channel_count)
        return false;
    for (uint32_t c = 0; c < image->channel_count; c++) {
        exr_coding_channel_info_t *channel = &reader->pipe.channels[c];
        if (strcmp(channel->channel_name, image->names[c]) != 0)
            return false;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = (int32_t)(image->width * sizeof(float));
        channel->decode_to_ptr = (uint8_t *)(image_channel(image, c) + (size_t)y * image->width + x);
    }
    return true;
}

/* Decodes a chunk into the rectangle at (x,y) of the image, which must hold it. */
static fault_code_t read_chunk(reader_t *reader, const exr_chunk_info_t *chunk, uint32_t x, uint32_t y,
                               fault_t *fault)
{
    const image_t *image = reader->image;
    if (chunk->width < 1 || chunk->height < 1 || (uint32_t)chunk->width > image->width - x ||
        (uint32_t)chunk->height > image->height - y ||
        chunk->unpacked_size > (uint64_t)chunk->width * (uint64_t)chunk->height * image->channel_count * 4 ||
        chunk->packed_size > reader->stream->size)
        return fault_set(fault, FAULT_FORMAT, "OpenEXR: chunk of %d x %d pixels at (%u,%u) leaves the image",
                         chunk->width, chunk->height, x, y);
    exr_result_t result = reader->piped ? exr_decoding_update(reader->context, 0, chunk, &reader->pipe)
                                        : exr_decoding_initialize(reader->context, 0, chunk, &reader->pipe);
    if (result == EXR_ERR_SUCCESS && !point_into_planes(reader, x, y))
        result = EXR_ERR_CORRUPT_CHUNK;
    if (result == EXR_ERR_SUCCESS && !reader->piped) {
        result = exr_decoding_choose_default_routines(reader->context, 0, &reader->pipe);
        reader->piped = true;
    }
    if (result == EXR_ERR_SUCCESS)
        result = exr_decoding_run(reader->context, 0, &reader->pipe);
    if (result == EXR_ERR_SUCCESS)
        return FAULT_NONE;
    const fault_code_t code = library_fault(reader->stream, result, "reading pixels", fault);
    return fault_prefix(fault, code, "chunk at (%u,%u)", x, y);
}

static fault_code_t read_scanlines(reader_t *reader, fault_t *fault)
{
    int32_t lines = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(reader->context, 0, &lines);
    if (result != EXR_ERR_SUCCESS || lines < 1)
        return library_fault(reader->stream, result, "reading the header", fault);
    for (uint32_t y = 0; y < reader->image->height; y += (uint32_t)lines) {
        exr_chunk_info_t chunk = {0};
        result = exr_read_scanline_chunk_info(reader->context, 0, reader->window.min.y + (int32_t)y, &chunk);
        if (result != EXR_ERR_SUCCESS)
            return library_fault(reader->stream, result, "looking for scan lines", fault);
        if ((uint32_t)chunk.width != reader->image->width || chunk.start_y != reader->window.min.y + (int32_t)y)
            return fault_set(fault, FAULT_FORMAT, "OpenEXR: scan lines at %d: found %d pixels at %d",
                             reader->window.min.y + (int32_t)y, chunk.width, chunk.start_y);
        TRY(read_chunk(reader, &chunk, 0, y, fault));
    }
    return FAULT_NONE;
}

static fault_code_t read_tiles(reader_t *reader, fault_t *fault)
{
    int32_t tile_width = 0, tile_height = 0;
    exr_result_t result = exr_get_tile_sizes(reader->context, 0, 0, 0, &tile_width, &tile_height);
    if (result != EXR_ERR_SUCCESS || tile_width < 1 || tile_height < 1)
        return library_fault(reader->stream, result, "reading the tile sizes", fault);
    const uint32_t w = (uint32_t)tile_width, h = (uint32_t)tile_height;
    for (uint32_t y = 0; y < reader->image->height; y += h)
        for (uint32_t x = 0; x < reader->image->width; x += w) {
            exr_chunk_info_t chunk = {0};
            result = exr_read_tile_chunk_info(reader->context, 0, (int)(x / w), (int)(y / h), 0, 0, &chunk);
            if (result != EXR_ERR_SUCCESS)
                return library_fault(reader->stream, result, "looking for tiles", fault);
            TRY(read_chunk(reader, &chunk, x, y, fault));
        }
    return FAULT_NONE;
}

static fault_code_t read_part(reader_t *reader, fault_t *fault)
{
    exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
    const exr_result_t result = exr_get_storage(reader->context, 0, &storage);
    if (result != EXR_ERR_SUCCESS)
        return library_fault(reader->stream, result, "reading the header", fault);
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return fault_set(fault, FAULT_UNSUPPORTED, "OpenEXR: deep images are not supported");
    TRY(make_image(reader, fault));
    TRY(copy_attributes(reader, fault));
    return storage == EXR_STORAGE_SCANLINE ? read_scanlines(reader, fault) : read_tiles(reader, fault);
}

fault_code_t exr_decode(image_t *image, const uint8_t *data, size_t size, fault_t *fault)
{
    *image = (image_t){0};
    static const uint8_t magic[4] = {0x76, 0x2f, 0x31, 0x01};
    if (size < sizeof magic || memcmp(data, magic, sizeof magic) != 0)
        return fault_set(fault, FAULT_FORMAT, "byte 0: not an OpenEXR file");
    /* The stream is only read from. */
    stream_t stream = {.size = size};
    memcpy(&stream.bytes, &data, sizeof data);
    exr_context_initializer_t init = initializer(&stream);
    init.read_fn = on_read;
    init.size_fn = on_size;
    reader_t reader = {.stream = &stream, .pipe = EXR_DECODE_PIPELINE_INITIALIZER, .image = image};
    const exr_result_t result = exr_start_read(&reader.context, "image", &init);
    if (result != EXR_ERR_SUCCESS)
        return library_fault(&stream, result, "reading the header", fault);
    const fault_code_t code = read_part(&reader, fault);
    exr_decoding_destroy(reader.context, &reader.pipe);
    exr_finish(&reader.context);
    if (code != FAULT_NONE)
        image_clear(image);
    return code;
}

fault_code_t exr_read(image_t *image, const char *path, fault_t *fault)
{
    *image = (image_t){0};
    uint8_t *data;
    size_t size;
    TRY(file_read(path, IMAGE_MAX_FILE_BYTES, &data, &size, fault));
    const fault_code_t code = exr_decode(image, data, size, fault);
    free(data);
    return fault_prefix(fault, code, "%s", path);
}
