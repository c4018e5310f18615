/* gain_plot.h: bench_gain's figures as pictures (SVG), a panel a scene. The caller frees what is returned. */
#ifndef TESTS_BENCH_GAIN_PLOT_H
#define TESTS_BENCH_GAIN_PLOT_H

#include "gain_data.h"

/* relMSE over CPU time of the variants without a remedy: the median over the seeds, a band from least to most. */
char *gain_plot_time(const gain_scene_t *scenes, size_t count);
/* relMSE at the end of every variant: median, least to most, a tick at the median of the trimmed figure. */
char *gain_plot_end(const gain_scene_t *scenes, size_t count);
/* Standard deviation of a pixel over the seeds: mean with its error, a tick at the 99th percentile. */
char *gain_plot_stability(const gain_scene_t *scenes, size_t count);

#endif
