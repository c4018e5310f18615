/* film_codec.c: films as bytes.
 *
 * Version 1, all numbers little-endian:
 *
 *     0   "GFLM"
 *     4   u16 version, u16 zero
 *     8   u32 width, u32 height
 *     16  u64 size of the payload
 *     24  one zstd frame with checksum, to the end, that holds the payload:
 *
 *     0   u64 splats, outside, nonfinite, negative, saturated
 *     40  bit map of the 32x32 tiles, row by row: bit t % 8 of byte t / 8 is set if tile t holds anything; bits
 * past the last tile are zero
 *     ..  the set tiles in order: u8 planes[3], the number (0 to 8) of low-order bytes that channel's sums need
 * here; then for each channel its byte planes, lowest first, a byte per pixel of the tile, row by row; tiles at the
 * right and bottom edge are cut to the image.
 *
 * Sums are non-negative and mostly of similar size within a tile, so planes that are zero cost nothing, the high
 * ones compress well, and the low ones, which are noise, pass zstd at the speed of a copy.
 */
#include <stdlib.h>
#include <string.h>

#include <zstd.h>

#include "film/film.h"

enum { TILE = 32, VERSION = 1, HEADER_SIZE = 24, COUNTS_SIZE = 40, MAX_PLANES = 8, ZSTD_LEVEL = 1 };

static const char MAGIC[4] = {'G', 'F', 'L', 'M'};

static void put_le(uint8_t *to, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        to[i] = (uint8_t)(value >> (8 * i));
}

static uint64_t get_le(const uint8_t *from, int bytes)
{
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++)
        value |= (uint64_t)from[i] << (8 * i);
    return value;
}

typedef struct tile {
    uint32_t x, y, width, height;
} tile_t;

static uint32_t tiles_across(uint32_t pixels)
{
    return (pixels + TILE - 1) / TILE;
}

static size_t tile_count(const film_t *film)
{
    return (size_t)tiles_across(film->width) * tiles_across(film->height);
}

static tile_t tile_at(const film_t *film, size_t index)
{
    const uint32_t across = tiles_across(film->width);
    tile_t tile = {(uint32_t)(index % across) * TILE, (uint32_t)(index / across) * TILE, TILE, TILE};
    if (tile.x + TILE > film->width)
        tile.width = film->width - tile.x;
    if (tile.y + TILE > film->height)
        tile.height = film->height - tile.y;
    return tile;
}

static size_t map_size(const film_t *film)
{
    return (tile_count(film) + 7) / 8;
}

/* The largest payload that a film of this size can have. */
static size_t payload_limit(const film_t *film)
{
    const size_t sums = (size_t)film->width * film->height * FILM_CHANNELS;
    return COUNTS_SIZE + map_size(film) + tile_count(film) * FILM_CHANNELS + sums * MAX_PLANES;
}

static int64_t *tile_row(const film_t *film, tile_t tile, uint32_t row)
{
    return film->sums + FILM_CHANNELS * ((size_t)(tile.y + row) * film->width + tile.x);
}

/* Number of low-order bytes each channel needs in this tile. */
static void tile_planes(const film_t *film, tile_t tile, uint8_t planes[FILM_CHANNELS])
{
    uint64_t bits[FILM_CHANNELS] = {0};
    for (uint32_t row = 0; row < tile.height; row++) {
        const int64_t *sum = tile_row(film, tile, row);
        for (uint32_t i = 0; i < tile.width; i++)
            for (int c = 0; c < FILM_CHANNELS; c++)
                bits[c] |= (uint64_t)sum[FILM_CHANNELS * i + (uint32_t)c];
    }
    for (int c = 0; c < FILM_CHANNELS; c++)
        planes[c] = bits[c] ? (uint8_t)((64 - __builtin_clzll(bits[c]) + 7) / 8) : 0;
}

static size_t tile_bytes(tile_t tile, const uint8_t planes[FILM_CHANNELS])
{
    return (size_t)tile.width * tile.height * ((size_t)planes[0] + planes[1] + planes[2]);
}

static uint8_t *put_tile(uint8_t *to, const film_t *film, tile_t tile, const uint8_t planes[FILM_CHANNELS])
{
    for (int c = 0; c < FILM_CHANNELS; c++)
        *to++ = planes[c];
    for (uint32_t c = 0; c < FILM_CHANNELS; c++)
        for (int plane = 0; plane < planes[c]; plane++)
            for (uint32_t row = 0; row < tile.height; row++, to += tile.width) {
                const int64_t *sum = tile_row(film, tile, row) + c;
                for (uint32_t i = 0; i < tile.width; i++)
                    to[i] = (uint8_t)((uint64_t)sum[FILM_CHANNELS * i] >> (8 * plane));
            }
    return to;
}

static void put_counts(uint8_t *to, const film_counts_t *counts)
{
    put_le(to, counts->splats, 8);
    put_le(to + 8, counts->outside, 8);
    put_le(to + 16, counts->nonfinite, 8);
    put_le(to + 24, counts->negative, 8);
    put_le(to + 32, counts->saturated, 8);
}

static film_counts_t get_counts(const uint8_t *from)
{
    return (film_counts_t){get_le(from, 8), get_le(from + 8, 8), get_le(from + 16, 8), get_le(from + 24, 8),
                           get_le(from + 32, 8)};
}

/* *payload is the caller's to free(); null if memory ran out. */
static uint8_t *make_payload(const film_t *film, size_t *size)
{
    const size_t tiles = tile_count(film);
    *size = COUNTS_SIZE + map_size(film);
    uint8_t(*planes)[FILM_CHANNELS] = malloc(tiles * sizeof *planes);
    if (!planes)
        return NULL;
    for (size_t t = 0; t < tiles; t++) {
        tile_planes(film, tile_at(film, t), planes[t]);
        const size_t bytes = tile_bytes(tile_at(film, t), planes[t]);
        *size += bytes ? FILM_CHANNELS + bytes : 0;
    }
    uint8_t *payload = malloc(*size);
    if (payload) {
        put_counts(payload, &film->counts);
        uint8_t *map = payload + COUNTS_SIZE, *to = map + map_size(film);
        memset(map, 0, map_size(film));
        for (size_t t = 0; t < tiles; t++)
            if (planes[t][0] | planes[t][1] | planes[t][2]) {
                map[t / 8] |= (uint8_t)(1u << (t % 8));
                to = put_tile(to, film, tile_at(film, t), planes[t]);
            }
    }
    free(planes);
    return payload;
}

/* One frame with checksum and content size; the number of bytes, or an error of zstd. */
static size_t compress(void *to, size_t capacity, const void *from, size_t size)
{
    ZSTD_CCtx *context = ZSTD_createCCtx();
    if (!context)
        return (size_t)-1; /* an error to ZSTD_isError, "Error (generic)" */
    size_t result = ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, ZSTD_LEVEL);
    if (!ZSTD_isError(result))
        result = ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
    if (!ZSTD_isError(result))
        result = ZSTD_compress2(context, to, capacity, from, size);
    ZSTD_freeCCtx(context);
    return result;
}

fault_code_t film_encode(const film_t *film, uint8_t **data, size_t *size, fault_t *fault)
{
    *data = NULL;
    *size = 0;
    size_t payload_size = 0;
    uint8_t *payload = make_payload(film, &payload_size);
    const size_t capacity = payload ? ZSTD_compressBound(payload_size) : 0;
    uint8_t *out = payload ? malloc(HEADER_SIZE + capacity) : NULL;
    if (!out) {
        free(payload);
        return fault_set(fault, FAULT_MEMORY, "encoding a film of %u x %u pixels: out of memory", film->width,
                         film->height);
    }
    const size_t packed = compress(out + HEADER_SIZE, capacity, payload, payload_size);
    free(payload);
    if (ZSTD_isError(packed)) {
        free(out);
        return fault_set(fault, FAULT_MEMORY, "encoding a film of %u x %u pixels: zstd: %s", film->width,
                         film->height, ZSTD_getErrorName(packed));
    }
    memcpy(out, MAGIC, sizeof MAGIC);
    put_le(out + 4, VERSION, 2);
    put_le(out + 6, 0, 2);
    put_le(out + 8, film->width, 4);
    put_le(out + 12, film->height, 4);
    put_le(out + 16, payload_size, 8);
    *data = out;
    *size = HEADER_SIZE + packed;
    return FAULT_NONE;
}

/* Checks the header against the film that is expected; *payload_size is then within the film's own limit. */
static fault_code_t check_header(const film_t *film, const uint8_t *data, size_t size, size_t *payload_size,
                                 fault_t *fault)
{
    if (size < HEADER_SIZE)
        return fault_set(fault, FAULT_FORMAT, "film data: %zu bytes found, at least the header's %d expected", size,
                         HEADER_SIZE);
    if (memcmp(data, MAGIC, sizeof MAGIC) != 0)
        return fault_set(fault, FAULT_FORMAT, "film data, byte 0: found %02x %02x %02x %02x, expected \"GFLM\"",
                         data[0], data[1], data[2], data[3]);
    const unsigned version = (unsigned)get_le(data + 4, 2), reserved = (unsigned)get_le(data + 6, 2);
    if (version != VERSION || reserved != 0)
        return fault_set(fault, FAULT_VERSION, "film data: version %u.%u found, %d.0 expected", version, reserved,
                         VERSION);
    const uint32_t width = (uint32_t)get_le(data + 8, 4), height = (uint32_t)get_le(data + 12, 4);
    if (width != film->width || height != film->height)
        return fault_set(fault, FAULT_FORMAT, "film data: %u x %u pixels found, %u x %u expected", width, height,
                         film->width, film->height);
    const uint64_t found = get_le(data + 16, 8);
    const size_t least = COUNTS_SIZE + map_size(film), most = payload_limit(film);
    if (found < least || found > most)
        return fault_set(fault, FAULT_FORMAT, "film data: payload of %llu bytes found, %zu to %zu expected",
                         (unsigned long long)found, least, most);
    *payload_size = (size_t)found;
    return FAULT_NONE;
}

/* Decompresses exactly `size` bytes from exactly one frame into *payload, which is the caller's to free(). */
static fault_code_t unpack(const uint8_t *frame, size_t frame_size, uint8_t **payload, size_t size, fault_t *fault)
{
    const unsigned long long stated = ZSTD_getFrameContentSize(frame, frame_size);
    if (stated != size)
        return fault_set(fault, FAULT_FORMAT, "film data, byte %d: no zstd frame of %zu bytes", HEADER_SIZE, size);
    const size_t length = ZSTD_findFrameCompressedSize(frame, frame_size);
    if (ZSTD_isError(length) || length != frame_size)
        return fault_set(fault, FAULT_FORMAT, "film data: %zu bytes after the header are not one whole zstd frame",
                         frame_size);
    uint8_t *out = malloc(size);
    if (!out)
        return fault_set(fault, FAULT_MEMORY, "film data: out of memory for %zu bytes", size);
    const size_t got = ZSTD_decompress(out, size, frame, frame_size);
    if (ZSTD_isError(got) || got != size) {
        free(out);
        return fault_set(fault, FAULT_FORMAT, "film data: zstd: %s",
                         ZSTD_isError(got) ? ZSTD_getErrorName(got) : "short frame");
    }
    *payload = out;
    return FAULT_NONE;
}

/* The bytes of a set tile at `at`, checked; *bytes counts all of them. */
static fault_code_t check_tile(tile_t tile, const uint8_t *at, size_t left, size_t *bytes, fault_t *fault)
{
    if (left < FILM_CHANNELS)
        return fault_set(fault, FAULT_FORMAT, "film data, tile at (%u,%u): %zu bytes left, %d expected", tile.x,
                         tile.y, left, FILM_CHANNELS);
    for (int c = 0; c < FILM_CHANNELS; c++)
        if (at[c] > MAX_PLANES)
            return fault_set(fault, FAULT_FORMAT,
                             "film data, tile at (%u,%u): %u byte planes found, at most %d expected", tile.x,
                             tile.y, at[c], MAX_PLANES);
    *bytes = FILM_CHANNELS + tile_bytes(tile, at);
    if (left < *bytes)
        return fault_set(fault, FAULT_FORMAT, "film data, tile at (%u,%u): %zu bytes left, %zu expected", tile.x,
                         tile.y, left, *bytes);
    const size_t area = (size_t)tile.width * tile.height;
    const uint8_t *planes = at + FILM_CHANNELS;
    for (int c = 0; c < FILM_CHANNELS; planes += at[c] * area, c++)
        for (size_t i = 0; at[c] == MAX_PLANES && i < area; i++)
            if (planes[(MAX_PLANES - 1) * area + i] > 0x7f)
                return fault_set(fault, FAULT_FORMAT, "film data, tile at (%u,%u): a negative sum", tile.x, tile.y);
    return FAULT_NONE;
}

static bool map_has(const uint8_t *map, size_t tile)
{
    return map[tile / 8] >> (tile % 8) & 1;
}

static fault_code_t check_payload(const film_t *film, const uint8_t *payload, size_t size, fault_t *fault)
{
    const uint8_t *map = payload + COUNTS_SIZE;
    size_t at = COUNTS_SIZE + map_size(film);
    for (size_t t = 0; t < 8 * map_size(film); t++) {
        if (!map_has(map, t))
            continue;
        if (t >= tile_count(film))
            return fault_set(fault, FAULT_FORMAT, "film data: tile %zu found, only %zu expected", t,
                             tile_count(film));
        size_t bytes = 0;
        TRY(check_tile(tile_at(film, t), payload + at, size - at, &bytes, fault));
        at += bytes;
    }
    if (at != size)
        return fault_set(fault, FAULT_FORMAT, "film data: %zu bytes after the last tile", size - at);
    return FAULT_NONE;
}

static const uint8_t *get_tile(const film_t *film, tile_t tile, const uint8_t *from)
{
    const uint8_t *planes = from;
    from += FILM_CHANNELS;
    for (uint32_t c = 0; c < FILM_CHANNELS; c++)
        for (int plane = 0; plane < planes[c]; plane++)
            for (uint32_t row = 0; row < tile.height; row++, from += tile.width) {
                int64_t *sum = tile_row(film, tile, row) + c;
                for (uint32_t i = 0; i < tile.width; i++)
                    sum[FILM_CHANNELS * i] |= (int64_t)((uint64_t)from[i] << (8 * plane));
            }
    return from;
}

fault_code_t film_decode(film_t *film, const uint8_t *data, size_t size, fault_t *fault)
{
    size_t payload_size = 0;
    uint8_t *payload = NULL;
    TRY(check_header(film, data, size, &payload_size, fault));
    TRY(unpack(data + HEADER_SIZE, size - HEADER_SIZE, &payload, payload_size, fault));
    const fault_code_t code = check_payload(film, payload, payload_size, fault);
    if (code == FAULT_NONE) {
        film_reset(film);
        film->counts = get_counts(payload);
        const uint8_t *map = payload + COUNTS_SIZE, *from = map + map_size(film);
        for (size_t t = 0; t < tile_count(film); t++)
            if (map_has(map, t))
                from = get_tile(film, tile_at(film, t), from);
    }
    free(payload);
    return code;
}
