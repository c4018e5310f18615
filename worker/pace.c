#include "worker/pace.h"

static const double pace_seconds = 0.1; /* that what is at hand is to last */
static const double pace_newest = 0.25; /* weight of the latest interval in the mean */

void pace_note(pace_t *pace, double now)
{
    const double interval = now - pace->last;
    if (pace->last > 0)
        pace->interval += (pace->interval > 0 ? pace_newest : 1) * (interval - pace->interval);
    pace->last = now;
}

unsigned pace_ahead(const pace_t *pace)
{
    if (!(pace->interval > 0))
        return PACE_LEAST;
    const double ahead = pace_seconds / pace->interval;
    return ahead > PACE_MOST ? PACE_MOST : ahead > PACE_LEAST ? (unsigned)ahead : PACE_LEAST;
}
