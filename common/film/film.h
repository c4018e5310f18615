/* film.h: an image as exact sums. 64-bit fixed point, three channels a pixel, so that addition is associative: any order and any number
 * of partial films give the same bits.
 *
 * Unit and range. A splat's value is in units of the caller's choice (for chains: target-normalised contribution,
 * f/f* times the weight of the state, so at most FILM_CHANNEL_MAX a mutation). The sum holds value * 2^28, rounded to
 * nearest: resolution 3.7e-9 of one mutation's weight, range 3.4e10, that is 2.4e9 mutations of the worst colour in one
 * pixel. A value or a sum beyond the range saturates and is counted; a negative or non-finite one is refused and counted. */
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

enum { FILM_CHANNELS = 3 };

typedef struct film_counts {
    uint64_t splats;     /* that entered */
    uint64_t outside;    /* of the image: the filter's margin */
    uint64_t nonfinite;  /* refused */
    uint64_t negative;   /* refused */
    uint64_t saturated;  /* clamped to the range */
} film_counts_t;

typedef struct film {
    uint32_t width, height;
    int64_t *sums; /* [height][width][3], rows from the top */
    film_counts_t counts;
} film_t;

fault_code_t film_init(film_t *film, uint32_t width, uint32_t height, fault_t *fault); /* all zero */
void film_clear(film_t *film);  /* frees */
void film_reset(film_t *film);  /* zeros sums and counts */

/* Adds value at raster (x,y), pixel (floor x, floor y). Inline in film_splat.h's fast form for the inner loop. */
static inline void film_splat(film_t *film, double x, double y, rgb_t value)
{
    if (!(x >= 0 && y >= 0 && x < film->width && y < film->height)) {
        film->counts.outside++;
        return;
    }
    const double limit = 0x1p33; /* value * 2^28 stays below 2^61 */
    if (__builtin_expect(!(value.r >= 0 && value.g >= 0 && value.b >= 0 && value.r < limit && value.g < limit &&
                           value.b < limit), 0)) {
        if (!isfinite(value.r) || !isfinite(value.g) || !isfinite(value.b))
            { film->counts.nonfinite++; return; }
        if (value.r < 0 || value.g < 0 || value.b < 0)
            { film->counts.negative++; return; }
        film->counts.saturated++;
        value = rgb(fmin(value.r, limit), fmin(value.g, limit), fmin(value.b, limit));
    }
    int64_t *sum = film->sums + FILM_CHANNELS * ((size_t)(uint32_t)y * film->width + (uint32_t)x);
    const int64_t add[FILM_CHANNELS] = {(int64_t)(value.r * FILM_ONE + 0.5), (int64_t)(value.g * FILM_ONE + 0.5),
                                        (int64_t)(value.b * FILM_ONE + 0.5)};
    for (int c = 0; c < FILM_CHANNELS; c++)
        if (__builtin_expect(__builtin_add_overflow(sum[c], add[c], &sum[c]), 0)) {
            sum[c] = INT64_MAX;
            film->counts.saturated++;
        }
    film->counts.splats++;
}

/* a += b, saturating and counted; sizes must agree (asserted). */
void film_add(film_t *a, const film_t *b);

/* The film as bytes for the wire and for checkpoints: rows in tiles, empty tiles left out, byte planes, zstd. *data is the caller's to free(). */
fault_code_t film_encode(const film_t *film, uint8_t **data, size_t *size, fault_t *fault);
/* Decodes into a film that is already of the expected size (set, not added); every length and index is checked, sums
 * must not be negative. */
fault_code_t film_decode(film_t *film, const uint8_t *data, size_t size, fault_t *fault);

#endif
