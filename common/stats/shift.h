/* shift.h: how the work that is still to be done is shared among path lengths, by what was measured so far.
 *
 * N_k mutations of length k bring relMSE a part v_k / N_k and cost c_k each. At a given cost in all the error is
 * least where N_k is in proportion to sqrt(v_k / c_k). v_k is measured from few units, and what they have not met
 * it does not know: it is drawn to what the pilot's shares imply, as if that were some units more; no share moves
 * by more than a factor at once or falls below a floor; and where little is to be won all stays as it is.
 *
 * Samples of all lengths beside the chains are one more length. Pure arithmetic: nothing here knows of a plan. */
#ifndef STATS_SHIFT_H
#define STATS_SHIFT_H

#include <stdbool.h>
#include <stdint.h>

typedef struct shift_length {
    double prior;    /* the share of the work that the pilot gave it; 0: it has none and gets none */
    double last;     /* that it has now */
    double variance; /* v_k; not counted while units < 2 */
    double cost;     /* c_k, above 0 */
    double units;    /* that v_k was measured from, as many as they are worth */
    double least;    /* share */
} shift_length_t;

/* Shares of the `count` lengths, at most SHIFT_MOST: they add up to what `last` does. False, and shares[] as
 * `last` is, where no variance is known or less than a few percent are to be won. */
enum { SHIFT_MOST = 128 };
bool shift_shares(const shift_length_t *lengths, uint32_t count, double *shares);

#endif
