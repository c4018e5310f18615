/* charted_chains.h: six ways to run Metropolis chains over two charts, rightly and wrongly.
 *
 * The algorithms of Pantaleoni: Charted Metropolis Light Transport (2017), section 7.1, over charted_scene.h:
 *
 *   CHARTED_PSSMLT_1  one chain in the chart of the light, target f* / p_1
 *   CHARTED_PSSMLT_2  one chain in the chart of the direction, target f* / p_2
 *   CHARTED_AVERAGE   both, half of the samples each; a sample of chain i counts w_i
 *   CHARTED_MIX       two chains with the targets w_i f* / p_i = f* / (p_1 + p_2)
 *   CHARTED_IPSM      one chain of paths, target f*: u = R_i(x), a step to v, y = S_i(v), accepted with
 *                     f*(y) p_i(x) / (f*(x) p_i(y)); the charts take turns
 *   CHARTED_CMLT      CHARTED_MIX, and after every CHARTED_SWAP_EVERY steps of both chains an exchange of their
 *                     paths x and y, accepted with p_1(y) p_2(x) / (p_1(x) p_2(y)) (eq. 24)
 *
 * The paper leaves the steps open. Here a step is a large one (four fresh numbers) with probability `large`, else
 * each number moves by Kelemen et al.'s law, 1/1024 to 1/64, wrapped. Both states count by expected values: the
 * proposal a, the state 1 - a. Exchanges are not samples. Chains start from their exact law, so that every step's
 * expectation is the picture.
 */
#ifndef LAB_CHARTED_CHAINS_H
#define LAB_CHARTED_CHAINS_H

#include <stdbool.h>
#include <stdint.h>

#include "client/lab/charted_reference.h"
#include "client/lab/stream.h"

typedef enum charted_algorithm {
    CHARTED_PSSMLT_1 = 0,
    CHARTED_PSSMLT_2 = 1,
    CHARTED_AVERAGE = 2,
    CHARTED_MIX = 3,
    CHARTED_IPSM = 4,
    CHARTED_CMLT = 5,
    CHARTED_ALGORITHMS = 6
} charted_algorithm_t;

extern const char *const charted_names[CHARTED_ALGORITHMS];

enum { CHARTED_SWAP_EVERY = 4 };

/* Acceptance ratios that look harmless, to see that they are not. */
typedef enum charted_mistake {
    CHARTED_RIGHT = 0,
    CHARTED_SWAP_ALWAYS,     /* CHARTED_CMLT: every exchange accepted */
    CHARTED_WITHOUT_DENSITY, /* CHARTED_IPSM: f*(y) / f*(x) */
    CHARTED_MISTAKES
} charted_mistake_t;

typedef struct charted_setup {
    charted_constants_t constants;
    double large; /* probability of a large step; positive, or chains do not reach everything */
    charted_mistake_t mistake;
} charted_setup_t;

typedef struct charted_result {
    charted_picture_t picture;
    uint64_t steps, swaps;           /* tried */
    double accepted, swaps_accepted; /* of the steps: the sum of a; of the exchanges: their number */
    /* Sums over the samples in a chart: of 1, and of w_1, whose mean an exchange on wrong terms would shift. */
    double samples[CHARTED_CHARTS], weights[CHARTED_CHARTS];
} charted_result_t;

typedef struct charted_chain {
    double u[CHARTED_NUMBERS];
    charted_path_t path;
} charted_chain_t;

/* A path with the density f* / b; with w_chart f* / b_chart where chart is not negative. By rejection, exact. */
charted_path_t charted_draw(int chart, stream_t *stream);
/* Exchanges the paths of the chain in chart 0 and the one in chart 1, or not; true if it was accepted. */
bool charted_swap(charted_chain_t chains[CHARTED_CHARTS], charted_mistake_t mistake, stream_t *stream);
/* Fills *result with the picture of `samples` steps in all (at least 2). */
void charted_run(charted_result_t *result, charted_algorithm_t algorithm, const charted_setup_t *setup,
                 uint64_t samples, stream_t *stream);

#endif
