/* film.h: an image as exact sums. 64-bit fixed point, three channels a pixel, so that addition is associative: any
 * order and any number of partial films give the same bits.
 *
 * Unit and range. A splat's value is in units of the caller's choice (for chains: target-normalised contribution,
 * f/f* times the weight of the state, so at most FILM_CHANNEL_MAX a mutation). The sum holds value * 2^28, rounded
 * to nearest: resolution 3.7e-9 of one mutation's weight, range 3.4e10, that is 2.4e9 mutations of the worst colour
 * in one pixel. A value or a sum beyond the range saturates and is counted; a negative or non-finite one is refused
 * and counted. Saturating addition of non-negative numbers is min(limit, a + b): associative too, so that the sums
 * don't depend on the order even then. Only `saturated` does: it counts the additions that met the limit, and is
 * zero in every order or in none.
 *
 * Thread rule: a film belongs to one thread.
 *
 *     film_t film;
 *     TRY(film_init(&film, 640, 360, fault));
 *     film_splat(&film, 12.5, 7.25, rgb(0.2, 0.5, 0.1));
 *     film_add(&total, &film);
 *     film_clear(&film);
 */
#ifndef FILM_FILM_H
#define FILM_FILM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"
#include "math/vec.h"

#define FILM_ONE 268435456.0 /* 2^28 */
/* max over colours of unit luminance of a channel: 1 / 0.072169 */
#define FILM_CHANNEL_MAX 13.857
/* A splat's largest channel; value * 2^28 is then 2^61, and a sum and a value never exceed 64 bits. */
#define FILM_VALUE_MAX 0x1p33

enum { FILM_CHANNELS = 3, FILM_MAX_SIDE = 1 << 15 };

typedef struct film_counts {
    uint64_t splats;    /* that entered */
    uint64_t outside;   /* of the image: the filter's margin */
    uint64_t nonfinite; /* refused: value or place */
    uint64_t negative;  /* refused */
    uint64_t saturated; /* additions clamped to the range */
} film_counts_t;

typedef struct film {
    uint32_t width, height;
    int64_t *sums; /* [height][width][3], rows from the top, never negative */
    film_counts_t counts;
} film_t;

/* All zero; film_clear releases it. FAULT_RANGE for a side that is 0 or above FILM_MAX_SIDE, FAULT_MEMORY. */
fault_code_t film_init(film_t *film, uint32_t width, uint32_t height, fault_t *fault);
void film_clear(film_t *film); /* frees; a zeroed film is left as it is */
void film_reset(film_t *film); /* zeros sums and counts */

/* The seldom part of film_splat: a splat outside, refused or saturated. Same arguments. */
void film_splat_rare(film_t *film, double x, double y, rgb_t value);

/* Adds value at raster (x,y), pixel (floor x, floor y). About 10 ns while the film is in the cache, 20 to 40 ns at
 * 1920x1080 with random places, nearly all of it memory: the checks cost nothing that could be measured (all of the
 * comparisons share one branch, and so do the three overflows: a sum of two numbers below 2^63 has its sign in bit
 * 63). */
static inline void film_splat(film_t *film, double x, double y, rgb_t value)
{
    if (__builtin_expect(!(x >= 0 && y >= 0 && x < film->width && y < film->height && value.r >= 0 &&
                           value.g >= 0 && value.b >= 0 && value.r < FILM_VALUE_MAX && value.g < FILM_VALUE_MAX &&
                           value.b < FILM_VALUE_MAX),
                         0)) {
        film_splat_rare(film, x, y, value);
        return;
    }
    int64_t *sum = film->sums + FILM_CHANNELS * ((size_t)(uint32_t)y * film->width + (uint32_t)x);
    const uint64_t r = (uint64_t)sum[0] + (uint64_t)(int64_t)(value.r * FILM_ONE + 0.5);
    const uint64_t g = (uint64_t)sum[1] + (uint64_t)(int64_t)(value.g * FILM_ONE + 0.5);
    const uint64_t b = (uint64_t)sum[2] + (uint64_t)(int64_t)(value.b * FILM_ONE + 0.5);
    if (__builtin_expect((r | g | b) >> 63 != 0, 0)) {
        film_splat_rare(film, x, y, value);
        return;
    }
    sum[0] = (int64_t)r;
    sum[1] = (int64_t)g;
    sum[2] = (int64_t)b;
    film->counts.splats++;
}

/* The sums of pixel (x,y), in the unit of the splats. Unchecked. */
static inline rgb_t film_value(const film_t *film, uint32_t x, uint32_t y)
{
    const int64_t *sum = film->sums + FILM_CHANNELS * ((size_t)y * film->width + x);
    return rgb((double)sum[0] * (1 / FILM_ONE), (double)sum[1] * (1 / FILM_ONE), (double)sum[2] * (1 / FILM_ONE));
}

/* a += b, saturating and counted; counts too. Sizes must agree (asserted). */
void film_add(film_t *a, const film_t *b);
/* Multiplies all sums by a factor >= 0, each rounded to the nearest; saturating and counted. */
void film_scale(film_t *film, double factor);

/* The film as bytes for the wire and for checkpoints: 32x32 tiles, empty ones left out, byte planes, zstd with a
 * checksum (the layout is described in film_codec.c). The same film gives the same bytes with the same zstd.
 * *data is the caller's to free(). */
fault_code_t film_encode(const film_t *film, uint8_t **data, size_t *size, fault_t *fault);
/* Decodes into a film that is already of the expected size (set, not added). Every length and index is checked,
 * sums must not be negative, and no more memory is taken than a film of this size can need. After a fault
 * (FAULT_FORMAT, FAULT_VERSION, FAULT_MEMORY) the film is as it was. */
fault_code_t film_decode(film_t *film, const uint8_t *data, size_t size, fault_t *fault);

#endif
