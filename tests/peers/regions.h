/* regions.h: the mean luminances of an image's 8 x 8 blocks and of the whole, from renders with many seeds and from
 * references, each with its variance: what agreement is judged by.
 *
 * Thread rule: plain data.
 */
#ifndef TESTS_PEERS_REGIONS_H
#define TESTS_PEERS_REGIONS_H

#include "film/image.h"

enum { REGIONS_GRID = 8, REGIONS_WHOLE = REGIONS_GRID * REGIONS_GRID, REGIONS = REGIONS_WHOLE + 1 };

typedef struct regions {
    double mean[REGIONS];     /* block (x,y) at y * REGIONS_GRID + x, the whole image last */
    double variance[REGIONS]; /* of the mean */
} regions_t;

/* Mean over the images of independent seeds; variances from their spread, count - 1 degrees of freedom each, but no
 * block's relative variance is taken to be less than the median of all blocks': an underestimate from few seeds
 * would look like a disagreement. */
void regions_of_seeds(regions_t *regions, const image_t *images, unsigned count);

/* Of a reference in two independent halves, both of the images' size. The variance is that of pixels which are
 * independent, times what the blocks' own differences show beyond it (64 degrees of freedom): pixels of Metropolis
 * renders are not. */
void regions_of_halves(regions_t *regions, const image_t *a, const image_t *b);

/* The largest |a - b| over its standard error; where it is. */
double regions_worst(const regions_t *a, const regions_t *b, int *where);

/* What does not average out: the mean over pairs of seeds of the mean over pixels and channels of e_i e_j / (R^2 +
 * 0.01), scaled as relMSE is, R the mean of the two halves of the reference, e_i the error of image i against one
 * of them, e_j against the other. Its expectation is that of the squared bias of a pixel. Pairs are uncorrelated if
 * there is none (a degenerate U-statistic: Hoeffding 1948, section 5), and their spread then gives the standard
 * error. */
double regions_floor(const image_t *images, unsigned count, const image_t halves[2], double *error);

/* Prints the ratio a / b of every block, a row a line. */
void regions_print(const char *title, const regions_t *a, const regions_t *b);

/* The image with factor x factor pixels averaged into one; sides must be multiples. The caller clears. */
fault_code_t regions_shrink(image_t *out, const image_t *image, uint32_t factor, fault_t *fault);

#endif
