/* results_plot.h: a bench's errors over CPU time as one picture (SVG), a panel a scene: medians over the seeds as
 * lines, bands from the least to the most. */
#ifndef CLIENT_BENCH_RESULTS_PLOT_H
#define CLIENT_BENCH_RESULTS_PLOT_H

#include "client/bench/results.h"

/* The caller frees it. */
char *results_plot(const results_t *results);

#endif
