/* smooth.h: means over squares of pixels, for filters of the image's statistics.
 *
 * Each pixel costs the same whatever the square's size: sums run along rows, then down columns, a whole row of
 * columns at a time, so that memory is read in its order. */
#ifndef FILM_SMOOTH_H
#define FILM_SMOOTH_H

#include <stddef.h>
#include <stdint.h>

/* Doubles that smooth_square needs beside the plane. */
size_t smooth_scratch(uint32_t width, uint32_t height, uint32_t r);

/* In place: [height][width] values become their means over squares of (2 r + 1)^2 pixels, cut at the image's edge.
 * Hot: checks nothing. `scratch`: smooth_scratch doubles, whatever they hold. */
void smooth_square(double *plane, uint32_t width, uint32_t height, uint32_t r, double *scratch);

#endif
