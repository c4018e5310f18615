#include "plan/packed.h"

#include <stdlib.h>

#include <zstd.h>

enum { PACKED_LEVEL = 1 };

void packed_put(wire_writer_t *out, const char *field, const void *from, size_t size)
{
    if (!from) {
        wire_put_bytes(out, field, NULL, 0, 0);
        return;
    }
    const size_t room = ZSTD_compressBound(size);
    uint8_t *data = malloc(room);
    const size_t packed = data ? ZSTD_compress(data, room, from, size, PACKED_LEVEL) : 0;
    if (!data)
        wire_writer_fail(out, FAULT_MEMORY, field, "no memory for %zu octets", room);
    else if (ZSTD_isError(packed))
        wire_writer_fail(out, FAULT_MEMORY, field, "zstd: %s", ZSTD_getErrorName(packed));
    else
        wire_put_bytes(out, field, data, packed, UINT32_MAX);
    free(data);
}

fault_code_t packed_get(wire_reader_t *in, const char *field, void *to, size_t size)
{
    size_t packed = 0;
    const uint8_t *data = wire_get_bytes(in, field, to ? UINT32_MAX : 0, &packed);
    if (!data)
        return in->code;
    if (to && ZSTD_decompress(to, size, data, packed) != size)
        return wire_reader_fail(in, FAULT_FORMAT, field, "does not unpack to %zu octets", size);
    return FAULT_NONE;
}
