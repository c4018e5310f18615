/* progress_bar.h: a job's progress on standard error: a line that is rewritten on a terminal, else a new line every
 * few seconds. */
#ifndef CLIENT_PROGRESS_BAR_H
#define CLIENT_PROGRESS_BAR_H

#include <stdbool.h>

#include "base/json.h"

typedef struct progress_bar {
    bool terminal, shown, quiet;
    double next;                            /* when to write again */
    double last_seen, last_mutations, rate; /* mutations a second, smoothed */
    char trouble[256];                      /* the latest that was said */
} progress_bar_t;

/* quiet: only troubles are said. */
void progress_bar_begin(progress_bar_t *bar, bool quiet);
/* `status` as in PROGRESS and in status' jobs. */
void progress_bar_show(progress_bar_t *bar, const json_t *status);
/* A line of its own, above the bar. */
void progress_bar_say(progress_bar_t *bar, const char *text);
/* Leaves the terminal's line clean. */
void progress_bar_end(progress_bar_t *bar);

/* "1:05" or "2:01:07"; "-" for NaN. */
void progress_bar_time(double seconds, char *text, unsigned size);

#endif
