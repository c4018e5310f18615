/* stream.h: the laboratory's random numbers, one after the other: uniform and normal.
 *
 * A stream is told by a seed and a number; two of them share nothing. The stream belongs to one caller.
 */
#ifndef LAB_STREAM_H
#define LAB_STREAM_H

#include <math.h>
#include <stdint.h>

#include "base/random.h"
#include "math/vec.h"

typedef struct stream {
    uint64_t key, next;
    double spare; /* the second number of the last pair of normal ones */
    int has_spare;
} stream_t;

static inline stream_t stream_of(uint64_t seed, uint64_t number)
{
    return (stream_t){.key = random_step(random_mix(seed + RANDOM_GAMMA), number)};
}

/* In [0,1). */
static inline double stream_uniform(stream_t *stream)
{
    return random_double(stream->key, stream->next++);
}

/* Standard normal (Box and Muller 1958), made in pairs. */
static inline double stream_normal(stream_t *stream)
{
    if (stream->has_spare) {
        stream->has_spare = 0;
        return stream->spare;
    }
    const double radius = sqrt(-2 * log(1 - stream_uniform(stream)));
    const double angle = 2 * MATH_PI * stream_uniform(stream);
    stream->spare = radius * sin(angle);
    stream->has_spare = 1;
    return radius * cos(angle);
}

#endif
