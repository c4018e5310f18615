/* exact.h: sums of doubles that do not depend on the order of the summands: 128-bit fixed point in a chosen unit.
 * Each summand is rounded to 2^-40 of the unit; the sum of the rounded values is exact. */
#ifndef STATS_EXACT_H
#define STATS_EXACT_H

#include <stdint.h>

#include "base/wire.h"

/* __extension__: 128-bit integers are GNU C. */
__extension__ typedef __int128 exact_int_t;
__extension__ typedef unsigned __int128 exact_uint_t;

/* To double; most are below 2^64, where the machine does it. */
static inline double exact_double(exact_uint_t x)
{
    return x >> 64 ? (double)x : (double)(uint64_t)x;
}

/* To the nearest integer, of x >= 0; likewise. */
static inline exact_uint_t exact_round(double x)
{
    const double up = x + 0.5;
    return up < 0x1p63 ? (exact_uint_t)(int64_t)up : (exact_uint_t)up;
}

typedef struct exact_sum {
    exact_int_t value;
} exact_sum_t;

/* Adds x / unit; a value beyond 2^85 units counts as that much (what is estimated has no meaning then). */
static inline void exact_add(exact_sum_t *sum, double x, double unit)
{
    double scaled = x / unit * 0x1p40;
    const double limit = 0x1p125;
    scaled = scaled < limit ? scaled : limit;
    scaled = scaled > -limit ? scaled : -limit;
    const exact_int_t add = (exact_int_t)(scaled + (scaled < 0 ? -0.5 : 0.5));
    if (__builtin_add_overflow(sum->value, add, &sum->value))
        sum->value = add;
}

static inline double exact_value(const exact_sum_t *sum, double unit)
{
    return (double)sum->value * 0x1p-40 * unit;
}

/* As bytes: u64 low half, u64 high half. */
static inline void exact_put(wire_writer_t *out, const exact_sum_t *sum)
{
    const exact_uint_t bits = (exact_uint_t)sum->value;
    wire_put_u64(out, (uint64_t)bits);
    wire_put_u64(out, (uint64_t)(bits >> 64));
}

static inline void exact_get(wire_reader_t *in, exact_sum_t *sum)
{
    const uint64_t low = wire_get_u64(in, "sum"), high = wire_get_u64(in, "sum");
    sum->value = (exact_int_t)((exact_uint_t)high << 64 | low);
}

#endif
