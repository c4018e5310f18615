/* stuck.h: chains that stayed on one path for longer than chance explains: found, never moved along.
 *
 * Looked at where a stay ends, and nowhere else. A unit's chains have accepted A of N proposals before; were each
 * proposal accepted with one unknown probability p (uniform beforehand), a stay would have n rejections or more
 * with
 *
 *     P(n) = product over i < n of 1 - (A + 1) / (N + 2 + i)         (Laplace's rule of succession)
 *
 * The stay is stuck if n >= STUCK_LEAST, N >= STUCK_LEAST and P(n) < STUCK_CHANCE: less than one stay in a million
 * is called so without cause. Stuck stays are not counted in A and N, which tell of chains that move.
 *
 *     stuck_t stuck = {0};                                         one a unit
 *     if (stuck_end_stay(&stuck, rejections, accepted))
 *         stuck_add_light, describe the path, stuck_keep it
 *
 * Chains of all lengths at once are on many paths; the brightest of them stands for the state.
 *
 * Of a unit, and of all units, the STUCK_PATHS longest stays are kept; which these are does not depend on the order
 * in which units are added up. */
#ifndef CHAIN_STUCK_H
#define CHAIN_STUCK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"
#include "base/wire.h"

struct path_space;

enum {
    STUCK_PATHS = 8,
    STUCK_LEAST = 64,
    STUCK_MAX_INNER = 126, /* vertices between light and lens */
    STUCK_TEXT = 640       /* octets of a description in words */
};

#define STUCK_CHANCE 1e-6
#define STUCK_LIGHT_ONE 0x1p20

/* How a path scatters at a vertex. */
typedef enum stuck_code {
    STUCK_DIFFUSE = 0,
    STUCK_GLOSSY,
    STUCK_SPECULAR,
    STUCK_DIFFUSE_THROUGH, /* the same to the other side of the surface */
    STUCK_GLOSSY_THROUGH,
    STUCK_SPECULAR_THROUGH,
    STUCK_CODES
} stuck_code_t;

/* A path that a chain was stuck on. */
typedef struct stuck_path {
    uint32_t length, technique;
    uint64_t stay;                  /* rejections in a row */
    uint64_t chain;                 /* id among those of the length */
    double x, y;                    /* where on the film, in pixels */
    double c;                       /* the target's value */
    uint8_t codes[STUCK_MAX_INNER]; /* stuck_code_t of the length - 1 inner vertices, from the light on */
} stuck_path_t;

typedef struct stuck {
    uint64_t steps, accepted;        /* before, without stuck stays: what the criterion knows */
    uint64_t stays;                  /* stuck ones */
    uint64_t rejections;             /* in them, all together */
    uint64_t light;                  /* that their states added to the film, luminance in 1 / STUCK_LIGHT_ONE */
    uint32_t count;                  /* of paths: the lesser of stays and STUCK_PATHS */
    stuck_path_t paths[STUCK_PATHS]; /* the longest stay first; ties by length and chain */
} stuck_t;

/* Whether chance explains a stay of so many rejections after so many of `steps` proposals were accepted. */
bool stuck_is(uint64_t stay, uint64_t accepted, uint64_t steps);

/* A stay has ended, with an acceptance or with the chain. True if it was stuck: it is counted, and its path is to
 * be kept. */
static inline bool stuck_end_stay(stuck_t *stuck, uint64_t stay, bool accepted)
{
    if (stay >= STUCK_LEAST && stuck_is(stay, stuck->accepted, stuck->steps)) {
        stuck->stays++;
        stuck->rejections += stay;
        return true;
    }
    stuck->steps += stay + accepted;
    stuck->accepted += accepted;
    return false;
}

/* Light added up, as much as there is room for. */
static inline uint64_t stuck_sum_light(uint64_t a, uint64_t b)
{
    return a < UINT64_MAX - b ? a + b : UINT64_MAX;
}

/* What the state of a stuck stay has added to the film, as luminance there. */
void stuck_add_light(stuck_t *stuck, double light);

/* Codes of the vertices of the path of this length that technique s made in the space's walks. */
void stuck_encode(const struct path_space *space, uint32_t length, uint32_t s, uint8_t codes[STUCK_MAX_INNER]);

/* Keeps the path if it is among the longest stays. */
void stuck_keep(stuck_t *stuck, const stuck_path_t *path);

/* Adds the stuck stays of `from`. */
void stuck_add(stuck_t *to, const stuck_t *from);

/* "length 5, technique 2, pixel (12, 40), 913 rejections: L S D S E": from the light L to the lens E; D, G and S
 * for diffuse, glossy and specular reflection, Dt, Gt and St for the same through the surface. */
void stuck_print(const stuck_path_t *path, char text[STUCK_TEXT]);

/* Layout: u64 stays, rejections, light; u32 count and that many paths: u32 length, technique; u64 stay, chain; f64
 * x, y, c; u8 code of each inner vertex. What was stuck alone, not what the criterion knows. */
void stuck_put(wire_writer_t *out, const stuck_t *stuck);
/* Hostile bytes; lengths to max_length. */
fault_code_t stuck_get(wire_reader_t *in, stuck_t *stuck, uint32_t max_length);

#endif
