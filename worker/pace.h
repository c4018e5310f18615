/* pace.h: how many units a worker keeps at hand beyond those that run.
 *
 * A master that adds up results, waits for its disk or estimates an error answers some hundredths of a second late.
 * Units last from milliseconds to seconds: of long ones two at hand are enough, of short ones it is as many as the
 * threads do in that time. Not more: what is at hand here is missed elsewhere where the units of a stage run out.
 * Who runs which unit has no part in a result.
 *
 *     pace_t pace = {0};
 *     pace_note(&pace, clock_now());   whenever a unit has ended
 *     pace_ahead(&pace)
 */
#ifndef WORKER_PACE_H
#define WORKER_PACE_H

enum { PACE_LEAST = 2, PACE_MOST = 16 };

/* All zero: nothing is known. */
typedef struct pace {
    double last, interval; /* when a unit ended; seconds from one end to the next, the mean of the latest */
} pace_t;

void pace_note(pace_t *pace, double now);
/* PACE_LEAST to PACE_MOST. */
unsigned pace_ahead(const pace_t *pace);

#endif
