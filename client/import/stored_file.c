#include "client/import/stored_file.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "base/file.h"

static int is_gzip(const uint8_t *data, size_t size)
{
    return size >= 2 && data[0] == 0x1f && data[1] == 0x8b;
}

static fault_code_t copy(const uint8_t *data, size_t size, uint8_t **out, size_t *out_size, fault_t *fault)
{
    *out = malloc(size + 1);
    if (!*out)
        return fault_set(fault, FAULT_MEMORY, "no memory for %zu bytes", size);
    memcpy(*out, data, size);
    (*out)[size] = 0;
    *out_size = size;
    return FAULT_NONE;
}

/* Makes room for more output; one byte is kept back for the final zero. */
static fault_code_t grow(uint8_t **out, size_t *capacity, size_t limit, fault_t *fault)
{
    if (*capacity > limit)
        return fault_set(fault, FAULT_LIMIT, "unpacks to more than %zu bytes", limit);
    const size_t wanted = *capacity < limit / 2 ? 2 * *capacity : limit + 1;
    uint8_t *more = realloc(*out, wanted + 1);
    if (!more)
        return fault_set(fault, FAULT_MEMORY, "no memory for %zu bytes", wanted);
    *out = more;
    *capacity = wanted;
    return FAULT_NONE;
}

static fault_code_t inflate_all(z_stream *stream, const uint8_t *data, size_t size, size_t limit, uint8_t **out,
                                size_t *out_size, fault_t *fault)
{
    size_t capacity = limit < 65536 ? limit + 1 : 65536, used = 0, read = 0;
    *out = malloc(capacity + 1);
    if (!*out)
        return fault_set(fault, FAULT_MEMORY, "no memory for %zu bytes", capacity);
    for (;;) {
        const size_t input = size - read < 1 << 30 ? size - read : 1 << 30;
        const size_t room = capacity - used < 1 << 30 ? capacity - used : 1 << 30;
        stream->next_in = (z_const Bytef *)(uintptr_t)(data + read);
        stream->avail_in = (uInt)input;
        stream->next_out = *out + used;
        stream->avail_out = (uInt)room;
        const int status = inflate(stream, Z_NO_FLUSH);
        read += input - stream->avail_in;
        used += room - stream->avail_out;
        if (used > limit)
            return fault_set(fault, FAULT_LIMIT, "unpacks to more than %zu bytes", limit);
        if (status == Z_STREAM_END)
            break;
        if (status != Z_OK && status != Z_BUF_ERROR)
            return fault_set(fault, FAULT_FORMAT, "gzip data is damaged at byte %zu: %s", read,
                             stream->msg ? stream->msg : "unexpected content");
        if (read == size && stream->avail_out > 0)
            return fault_set(fault, FAULT_FORMAT, "gzip data ends early, after %zu bytes", size);
        if (used == capacity)
            TRY(grow(out, &capacity, limit, fault));
    }
    (*out)[used] = 0;
    *out_size = used;
    return FAULT_NONE;
}

fault_code_t stored_file_unpack(const uint8_t *data, size_t size, size_t limit, uint8_t **out, size_t *out_size,
                                fault_t *fault)
{
    *out = NULL;
    *out_size = 0;
    if (!is_gzip(data, size)) {
        if (size > limit)
            return fault_set(fault, FAULT_LIMIT, "%zu bytes are more than the limit of %zu", size, limit);
        return copy(data, size, out, out_size, fault);
    }
    z_stream stream = {0};
    if (inflateInit2(&stream, 15 + 16) != Z_OK) /* the largest window, gzip framing */
        return fault_set(fault, FAULT_MEMORY, "no memory to unpack");
    const fault_code_t code = inflate_all(&stream, data, size, limit, out, out_size, fault);
    inflateEnd(&stream);
    if (code) {
        free(*out);
        *out = NULL;
        *out_size = 0;
    }
    return code;
}

fault_code_t stored_file_read(const char *path, uint8_t **data, size_t *size, fault_t *fault)
{
    *data = NULL;
    *size = 0;
    uint8_t *raw = NULL;
    size_t raw_size = 0;
    TRY(file_read(path, STORED_FILE_MAX, &raw, &raw_size, fault));
    if (!is_gzip(raw, raw_size)) {
        *data = raw;
        *size = raw_size;
        return FAULT_NONE;
    }
    const fault_code_t code = stored_file_unpack(raw, raw_size, STORED_FILE_MAX, data, size, fault);
    free(raw);
    return fault_prefix(fault, code, "%s", path);
}
