#include "exr_samples.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const exr_sample_t exr_samples[EXR_SAMPLE_COUNT] = {
    {"uncompressed half", EXR_COMPRESSION_NONE, EXR_PIXEL_HALF, 0, 0, 0, 0, 33, 21, 0},
    {"uncompressed float", EXR_COMPRESSION_NONE, EXR_PIXEL_FLOAT, 0, 0, 0, 0, 33, 21, 0},
    {"rle uint", EXR_COMPRESSION_RLE, EXR_PIXEL_UINT, 0, 0, 0, 0, 33, 21, 0},
    {"zips half", EXR_COMPRESSION_ZIPS, EXR_PIXEL_HALF, 0, 0, 0, 0, 33, 21, 0},
    {"zip uint", EXR_COMPRESSION_ZIP, EXR_PIXEL_UINT, 0, 0, 0, 0, 33, 21, 0},
    {"zip half with an odd window", EXR_COMPRESSION_ZIP, EXR_PIXEL_HALF, 0, 0, -7, 13, 21, 40, 0},
    {"piz half", EXR_COMPRESSION_PIZ, EXR_PIXEL_HALF, 0, 0, 0, 0, 33, 40, 0},
    {"piz float", EXR_COMPRESSION_PIZ, EXR_PIXEL_FLOAT, 0, 0, 3, -5, 33, 40, 0},
    {"pxr24 float", EXR_COMPRESSION_PXR24, EXR_PIXEL_FLOAT, 0, 0, 0, 0, 33, 21, 0},
    {"zip float in tiles", EXR_COMPRESSION_ZIP, EXR_PIXEL_FLOAT, 16, 0, 0, 0, 40, 21, 0},
    {"uncompressed half in tiles", EXR_COMPRESSION_NONE, EXR_PIXEL_HALF, 64, 0, 0, 0, 33, 21, 0},
    {"piz half in tiles with an odd window", EXR_COMPRESSION_PIZ, EXR_PIXEL_HALF, 16, 0, -20, 3, 40, 33, 0},
    {"b44 half", EXR_COMPRESSION_B44, EXR_PIXEL_HALF, 0, 0, 0, 0, 33, 40, 64},
    {"zip half in tiles with levels", EXR_COMPRESSION_ZIP, EXR_PIXEL_HALF, 16, 1, 0, 0, 33, 33, 0},
};

typedef struct memory {
    uint8_t *bytes;
    size_t size;
} memory_t;

static int64_t on_write(exr_const_context_t context, void *data, const void *buffer, uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t error)
{
    (void)context;
    (void)error;
    memory_t *memory = data;
    if (offset + size > memory->size) {
        memory->bytes = realloc(memory->bytes, offset + size);
        if (!memory->bytes)
            abort();
        memset(memory->bytes + memory->size, 0, offset + size - memory->size);
        memory->size = offset + size;
    }
    memcpy(memory->bytes + offset, buffer, size);
    return (int64_t)size;
}

static void silent(exr_const_context_t context, exr_result_t code, const char *message)
{
    (void)context;
    (void)code;
    (void)message;
}

static void must(exr_result_t result, const char *what)
{
    if (result != EXR_ERR_SUCCESS) {
        fprintf(stderr, "OpenEXR sample, %s: %s\n", what, exr_get_default_error_message(result));
        abort();
    }
}
#define MUST(call) must((call), #call)

/* Of a whole number below 2048, exactly. */
static uint16_t half_of(double value)
{
    if (value == 0)
        return 0;
    int exponent = 0;
    unsigned whole = (unsigned)value;
    while (whole >> (exponent + 1))
        exponent++;
    return (uint16_t)((unsigned)(exponent + 15) << 10 | ((whole << (10 - exponent)) & 0x3ff));
}

static void put_value(uint8_t *to, exr_pixel_type_t type, double value)
{
    const uint16_t half = half_of(value);
    const float single = (float)value;
    const uint32_t whole = (uint32_t)value;
    memcpy(to,
           type == EXR_PIXEL_HALF    ? (const void *)&half
           : type == EXR_PIXEL_FLOAT ? (const void *)&single
                                     : &whole,
           type == EXR_PIXEL_HALF ? 2 : 4);
}

/* Encodes one chunk whose first pixel is (x,y) of the level. */
static void write_chunk(exr_context_t context, const exr_chunk_info_t *chunk, int32_t x, int32_t y)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    MUST(exr_encoding_initialize(context, 0, chunk, &pipe));
    uint8_t *planes[EXR_SAMPLE_CHANNELS];
    for (int c = 0; c < pipe.channel_count; c++) {
        exr_coding_channel_info_t *channel = &pipe.channels[c];
        const size_t bytes = (size_t)channel->bytes_per_element;
        planes[c] = malloc((size_t)chunk->width * (size_t)chunk->height * bytes);
        for (int32_t row = 0; row < chunk->height; row++)
            for (int32_t i = 0; i < chunk->width; i++)
                put_value(planes[c] + bytes * (size_t)(row * chunk->width + i), channel->data_type,
                          exr_sample_value(c, x + i, y + row));
        channel->user_data_type = channel->data_type;
        channel->user_bytes_per_element = channel->bytes_per_element;
        channel->user_pixel_stride = channel->bytes_per_element;
        channel->user_line_stride = channel->bytes_per_element * chunk->width;
        channel->encode_from_ptr = planes[c];
    }
    MUST(exr_encoding_choose_default_routines(context, 0, &pipe));
    MUST(exr_encoding_run(context, 0, &pipe));
    for (int c = 0; c < pipe.channel_count; c++)
        free(planes[c]);
    MUST(exr_encoding_destroy(context, &pipe));
}

static void write_lines(exr_context_t context, const exr_sample_t *sample)
{
    int32_t lines = 0;
    MUST(exr_get_scanlines_per_chunk(context, 0, &lines));
    for (int32_t y = 0; y < sample->height; y += lines) {
        exr_chunk_info_t chunk = {0};
        MUST(exr_write_scanline_chunk_info(context, 0, sample->y + y, &chunk));
        write_chunk(context, &chunk, 0, y);
    }
}

static void write_tiles(exr_context_t context, const exr_sample_t *sample)
{
    int32_t levels = 1, unused = 1;
    MUST(exr_get_tile_levels(context, 0, &levels, &unused));
    for (int level = 0; level < levels; level++) {
        int32_t width = 0, height = 0;
        const int32_t side = (int32_t)sample->tile;
        MUST(exr_get_level_sizes(context, 0, level, level, &width, &height));
        for (int32_t y = 0; y < height; y += side)
            for (int32_t x = 0; x < width; x += side) {
                exr_chunk_info_t chunk = {0};
                MUST(exr_write_tile_chunk_info(context, 0, x / side, y / side, level, level, &chunk));
                write_chunk(context, &chunk, x, y);
            }
    }
}

static exr_context_t start(memory_t *memory)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = silent;
    init.user_data = memory;
    init.write_fn = on_write;
    exr_context_t context = NULL;
    MUST(exr_start_write(&context, "sample", EXR_WRITE_FILE_DIRECTLY, &init));
    return context;
}

static void describe(exr_context_t context, exr_storage_t storage, const exr_sample_t *sample, int subsampling)
{
    int part = 0;
    const exr_attr_box2i_t window = {{{{sample->x, sample->y}}},
                                     {{{sample->x + sample->width - 1, sample->y + sample->height - 1}}}};
    const exr_attr_v2f_t centre = {{{0, 0}}};
    MUST(exr_add_part(context, "part", storage, &part));
    MUST(exr_initialize_required_attr(context, part, &window, &window, 1, &centre, 1, EXR_LINEORDER_INCREASING_Y,
                                      sample->compression));
    static const char *const names[] = {"B", "G", "R"};
    for (int c = 0; c < 3; c++)
        MUST(exr_add_channel(context, part, names[c], sample->type, EXR_PERCEPTUALLY_LOGARITHMIC, subsampling,
                             subsampling));
    MUST(exr_add_channel(context, part, "layer.A", EXR_PIXEL_HALF, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    MUST(exr_attr_set_string(context, part, "comments", "a sample"));
    MUST(exr_attr_set_float(context, part, "exposure", 2.385f));
    if (sample->tile)
        MUST(exr_set_tile_descriptor(context, part, sample->tile, sample->tile,
                                     sample->mipmap ? EXR_TILE_MIPMAP_LEVELS : EXR_TILE_ONE_LEVEL,
                                     EXR_TILE_ROUND_DOWN));
    MUST(exr_write_header(context));
}

uint8_t *exr_sample_make(const exr_sample_t *sample, size_t *size)
{
    memory_t memory = {0};
    exr_context_t context = start(&memory);
    describe(context, sample->tile ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, sample, 1);
    if (sample->tile)
        write_tiles(context, sample);
    else
        write_lines(context, sample);
    MUST(exr_finish(&context));
    *size = memory.size;
    return memory.bytes;
}

uint8_t *exr_sample_make_header(int deep, size_t *size)
{
    static const exr_sample_t sample = {"header", EXR_COMPRESSION_NONE, EXR_PIXEL_HALF, 0, 0, 0, 0, 4, 4, 0};
    memory_t memory = {0};
    exr_context_t context = start(&memory);
    describe(context, deep ? EXR_STORAGE_DEEP_SCANLINE : EXR_STORAGE_SCANLINE, &sample, deep ? 1 : 2);
    exr_finish(&context); /* may complain that no chunk was written */
    memory.bytes = realloc(memory.bytes, memory.size + 4 * 8);
    memset(memory.bytes + memory.size, 0, 4 * 8); /* the chunk table */
    *size = memory.size + 4 * 8;
    return memory.bytes;
}
