/* random.h: random numbers as a function of their place, not of the order of calls.
 *
 * A number is a function of (key, counter): key = random_key(seed, a, b, c) names a chain step or a sample
 * (job seed, purpose and path length, chain or sample, step), the counter is the dimension. The generator is
 * SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014, figure 16): the
 * finaliser of MurmurHash3 in Stafford's variant 13 over a Weyl sequence. It is counter-based as it stands: output
 * n of a stream that starts at `key` is mix(key + (n+1) gamma).
 *
 * Doubles are multiples of 2^-53 in [0,1): u = 1 never occurs, u = 0 does.
 */
#ifndef BASE_RANDOM_H
#define BASE_RANDOM_H

#include <stdint.h>

#define RANDOM_GAMMA UINT64_C(0x9e3779b97f4a7c15)

static inline uint64_t random_mix(uint64_t z)
{
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* What a stream is for: keeps streams of the same numbers apart. Values are part of the record format. */
typedef enum random_purpose {
    RANDOM_PURPOSE_PILOT = 1,    /* candidates of a pilot unit */
    RANDOM_PURPOSE_CHAIN = 2,    /* steps of a Markov chain */
    RANDOM_PURPOSE_SAMPLES = 3,  /* independent samples of pt and bdpt */
    RANDOM_PURPOSE_RESAMPLE = 4, /* the offset of systematic resampling */
    RANDOM_PURPOSE_FEATURES = 5, /* albedo, normal and depth layers */
    RANDOM_PURPOSE_REFINE = 6,   /* samples that refine b_k */
    RANDOM_PURPOSE_TEST = 7,
    RANDOM_PURPOSE_PAIRS = 8,     /* pixels of a pilot's pairs of samples */
    RANDOM_PURPOSE_LEFT_OUT = 10, /* samples of what a job leaves out */
    RANDOM_PURPOSE_PASSES = 11,   /* which part of a pass comes first */
    RANDOM_PURPOSE_NETS = 12      /* how the nets of samples are scrambled */
} random_purpose_t;

/* The key of a family of streams; each word passes through the mixer, so that neighbouring values share nothing. */
static inline uint64_t random_key(uint64_t seed, random_purpose_t purpose, uint64_t length, uint64_t index)
{
    uint64_t key = random_mix(seed + RANDOM_GAMMA);
    key = random_mix(key ^ (((uint64_t)purpose << 32 | length) + RANDOM_GAMMA));
    return random_mix(key ^ random_mix(index + RANDOM_GAMMA));
}

/* The key of one step of a family. */
static inline uint64_t random_step(uint64_t key, uint64_t step)
{
    return random_mix(key + (step + 1) * UINT64_C(0xd1342543de82ef95));
}

static inline uint64_t random_u64(uint64_t key, uint64_t counter)
{
    return random_mix(key + (counter + 1) * RANDOM_GAMMA);
}

static inline double random_double_of(uint64_t bits)
{
    return (double)(bits >> 11) * 0x1p-53;
}

/* Uniform in [0,1). */
static inline double random_double(uint64_t key, uint64_t counter)
{
    return random_double_of(random_u64(key, counter));
}

#endif
