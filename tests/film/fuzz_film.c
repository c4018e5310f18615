/* Hostile film data: as it comes; as edits of a valid encoding; as the payload of a well-formed frame (a checksum
 * would stop most edits before they reach the tiles). A film that decodes must hold no negative sum and survive a
 * round trip. */
#include <stdio.h>
#include <zstd.h>

#include "film/film.h"
#include "fuzz_edit.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { WIDTH = 35, HEIGHT = 40, MAX_BYTES = 1 << 17 };

static void check(const film_t *film)
{
    uint8_t *bytes;
    size_t size;
    film_t back;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT * FILM_CHANNELS; i++)
        if (film->sums[i] < 0)
            abort();
    if (film_encode(film, &bytes, &size, NULL) != FAULT_NONE ||
        film_init(&back, WIDTH, HEIGHT, NULL) != FAULT_NONE ||
        film_decode(&back, bytes, size, NULL) != FAULT_NONE ||
        memcmp(film->sums, back.sums, (size_t)WIDTH * HEIGHT * FILM_CHANNELS * sizeof *back.sums) != 0)
        abort();
    free(bytes);
    film_clear(&back);
}

static void decode(const uint8_t *data, size_t size)
{
    film_t film;
    fault_t fault = {0};
    if (film_init(&film, WIDTH, HEIGHT, NULL) != FAULT_NONE)
        abort();
    if (film_decode(&film, data, size, &fault) == FAULT_NONE)
        check(&film);
    else if (fault.text[0] == '\0')
        abort();
    film_clear(&film);
}

/* A payload with both kinds of tile, as edited. */
static size_t make_payload(uint8_t *payload, const uint8_t *script, size_t script_size)
{
    const size_t size = 41 + 2 * 3 + 1024 * 2 + 3 * 32 * 8;
    memset(payload, 0, size);
    payload[40] = 3; /* tile 0: 32 x 32, planes 1, 1, 0; tile 1: 3 x 32, planes 8, 0, 0 */
    payload[41] = payload[42] = 1;
    payload[41 + 3 + 2048] = 8;
    return fuzz_edit(payload, size, script, script_size);
}

static size_t wrap(uint8_t *out, const uint8_t *payload, size_t size)
{
    static const uint8_t start[16] = {'G', 'F', 'L', 'M', 1, 0, 0, 0, WIDTH, 0, 0, 0, HEIGHT, 0, 0, 0};
    memcpy(out, start, sizeof start);
    for (int i = 0; i < 8; i++)
        out[16 + i] = (uint8_t)((uint64_t)size >> (8 * i));
    return 24 + ZSTD_compress(out + 24, MAX_BYTES - 24, payload, size, 1);
}

static size_t make_valid(uint8_t *out)
{
    film_t film;
    uint8_t *bytes;
    size_t size;
    if (film_init(&film, WIDTH, HEIGHT, NULL) != FAULT_NONE)
        abort();
    for (int i = 0; i < 100; i++)
        film_splat(&film, i * 7 % WIDTH, i * 3 % HEIGHT, rgb(0.1 * i, 1, i));
    if (film_encode(&film, &bytes, &size, NULL) != FAULT_NONE)
        abort();
    memcpy(out, bytes, size);
    free(bytes);
    film_clear(&film);
    return size;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t bytes[MAX_BYTES], payload[1 << 14];
    decode(data, size);
    if (size < 4)
        return 0;
    if ((data[0] + data[1] + data[2] + data[3]) % 4 == 0)
        decode(bytes, fuzz_edit(bytes, make_valid(bytes), data + 4, size - 4));
    else
        decode(bytes, wrap(bytes, payload, make_payload(payload, data + 4, size - 4)));
    return 0;
}
