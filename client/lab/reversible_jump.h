/* reversible_jump.h: chains that change their sampling technique, rightly and wrongly.
 *
 * The scenario of Bitterli, Jakob, Novak, Jarosz: Reversible Jump Metropolis Light Transport using Inverse Mappings
 * (2017), section 7.1 and figure 3, with the techniques of techniques.h. State: technique i and numbers u; target
 * C_i(u) = w_i(x) f(x) / p_i(x) = f(x) / sum_j p_j(x) with the balance heuristic, x = S_i(u). No large steps. A
 * step is
 *
 *   a jump (probability JUMP_PROBABILITY): another technique j, each with the same probability, numbers v = R_j(x)
 * that give the same point, accepted with C_j(v) |J[R_j](x)| / (C_i(u) |J[R_i](x)|) = p_j(x) / p_i(x) (eq. 19) as
 * C_j(v) = C_i(u) = f / sum p; or a small step: both numbers move by a normal number times `step`, wrapped,
 * accepted with C_i(v) / C_i(u).
 *
 * Right chains spend f(x) on x and w_i(x) of that on technique i. The variants:
 *   JUMP_FULL         as above
 *   JUMP_NO_JACOBIAN  the Jacobians left out: every jump is accepted
 *   JUMP_FIXED_POINT  the inverse returns the start of an ambiguous interval instead of a uniform place in it
 *   JUMP_NEITHER      both mistakes
 *   JUMP_MULTIPLEXED  no jumps: that step redraws the technique and keeps the numbers (multiplexed Metropolis);
 * right
 */
#ifndef LAB_REVERSIBLE_JUMP_H
#define LAB_REVERSIBLE_JUMP_H

#include <stdint.h>

#include "client/lab/histogram.h"
#include "client/lab/stream.h"
#include "client/lab/techniques.h"

#define JUMP_PROBABILITY 0.3
enum { JUMP_BINS = 100 };

typedef enum jump_variant {
    JUMP_FULL = 0,
    JUMP_NO_JACOBIAN = 1,
    JUMP_FIXED_POINT = 2,
    JUMP_NEITHER = 3,
    JUMP_MULTIPLEXED = 4,
    JUMP_VARIANTS = 5
} jump_variant_t;

extern const char *const jump_names[JUMP_VARIANTS];

/* Histograms of a chain's states: all, and those of each technique. */
typedef struct jump_result {
    histogram_t all;
    histogram_t by[TECHNIQUES];
} jump_result_t;

/* One chain of `count` steps from a state drawn from the exact law. Fills *result. */
void jump_run(jump_result_t *result, jump_variant_t variant, double step, uint64_t count, stream_t *stream);
/* Exact probabilities of the bins of `all`. */
void jump_exact(double exact[JUMP_BINS]);

#endif
