#include "regions.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "film/compare.h"
#include "math/vec.h"

static double pixel_luminance(const float *const planes[3], size_t p)
{
    return rgb_luminance(rgb(planes[0][p], planes[1][p], planes[2][p]));
}

static void image_planes(const image_t *image, const float *planes[3])
{
    fault_t fault;
    if (image_find_rgb(image, planes, &fault)) /* not from a render or a PFM file */
        planes[0] = planes[1] = planes[2] = image->data;
}

static size_t block_of(const image_t *image, uint32_t x, uint32_t y)
{
    return (size_t)(y * REGIONS_GRID / image->height * REGIONS_GRID + x * REGIONS_GRID / image->width);
}

static void image_means(const image_t *image, double means[REGIONS])
{
    const float *planes[3];
    double pixels[REGIONS] = {0};
    image_planes(image, planes);
    for (int i = 0; i < REGIONS; i++)
        means[i] = 0;
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++) {
            const double value = pixel_luminance(planes, (size_t)y * image->width + x);
            const size_t block = block_of(image, x, y);
            means[block] += value;
            means[REGIONS_WHOLE] += value;
            pixels[block]++;
            pixels[REGIONS_WHOLE]++;
        }
    for (int i = 0; i < REGIONS; i++)
        means[i] /= pixels[i];
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void regions_of_seeds(regions_t *regions, const image_t *images, unsigned count)
{
    double sum[REGIONS] = {0}, sum2[REGIONS] = {0}, relative[REGIONS];
    for (unsigned i = 0; i < count; i++) {
        double means[REGIONS];
        image_means(&images[i], means);
        for (int r = 0; r < REGIONS; r++) {
            sum[r] += means[r];
            sum2[r] += means[r] * means[r];
        }
    }
    for (int r = 0; r < REGIONS; r++) {
        const double mean = sum[r] / count;
        regions->mean[r] = mean;
        regions->variance[r] = fmax(0, sum2[r] / count - mean * mean) / (count - 1);
        relative[r] = regions->variance[r] / (mean * mean);
    }
    qsort(relative, REGIONS_WHOLE, sizeof *relative, ascending);
    for (int r = 0; r < REGIONS_WHOLE; r++)
        regions->variance[r] =
            fmax(regions->variance[r], relative[REGIONS_WHOLE / 2] * regions->mean[r] * regions->mean[r]);
}

/* Sums over a region's pixels of ((a - b) / 2)^2: n^2 times the variance of the mean of independent pixels. */
static void halves_variance(const image_t *a, const image_t *b, double variance[REGIONS])
{
    const float *of_a[3], *of_b[3];
    double pixels[REGIONS] = {0};
    image_planes(a, of_a);
    image_planes(b, of_b);
    for (int r = 0; r < REGIONS; r++)
        variance[r] = 0;
    for (uint32_t y = 0; y < a->height; y++)
        for (uint32_t x = 0; x < a->width; x++) {
            const size_t p = (size_t)y * a->width + x, block = block_of(a, x, y);
            const double half = 0.5 * (pixel_luminance(of_a, p) - pixel_luminance(of_b, p));
            variance[block] += half * half;
            variance[REGIONS_WHOLE] += half * half;
            pixels[block]++;
            pixels[REGIONS_WHOLE]++;
        }
    for (int r = 0; r < REGIONS; r++)
        variance[r] /= pixels[r] * pixels[r];
}

void regions_of_halves(regions_t *regions, const image_t *a, const image_t *b)
{
    double of_a[REGIONS], of_b[REGIONS], seen = 0, expected = 0;
    image_means(a, of_a);
    image_means(b, of_b);
    halves_variance(a, b, regions->variance);
    for (int r = 0; r < REGIONS_WHOLE; r++) {
        const double mean = 0.5 * (of_a[r] + of_b[r]), half = 0.5 * (of_a[r] - of_b[r]);
        seen += half * half / (mean * mean);
        expected += regions->variance[r] / (mean * mean);
    }
    const double beyond = fmax(1, seen / expected);
    for (int r = 0; r < REGIONS; r++) {
        regions->mean[r] = 0.5 * (of_a[r] + of_b[r]);
        regions->variance[r] *= beyond;
    }
}

double regions_worst(const regions_t *a, const regions_t *b, int *where)
{
    double worst = -1;
    for (int r = 0; r < REGIONS; r++) {
        const double z = fabs(a->mean[r] - b->mean[r]) / sqrt(a->variance[r] + b->variance[r]);
        if (!(z <= worst)) { /* NaN is the worst of all */
            worst = z;
            *where = r;
        }
    }
    return worst;
}

/* Mean luminance of (a + b) / 2. */
static double halves_luminance(const image_t halves[2])
{
    double of_a[REGIONS], of_b[REGIONS];
    image_means(&halves[0], of_a);
    image_means(&halves[1], of_b);
    return 0.5 * (of_a[REGIONS_WHOLE] + of_b[REGIONS_WHOLE]);
}

/* One pair's mean, its two ways of taking the halves averaged: with e_i = I_i - R and d = (A - B) / 2 that is
 * e_i e_j - d^2. */
static double floor_of_pair(const image_t *i, const image_t *j, const image_t halves[2], double scale)
{
    const size_t values = (size_t)3 * i->width * i->height;
    double sum = 0;
    for (size_t p = 0; p < values; p++) {
        const double a = halves[0].data[p], b = halves[1].data[p], r = 0.5 * (a + b), d = 0.5 * (a - b);
        const double product = (i->data[p] - r) * (j->data[p] - r) - d * d;
        sum += product * scale * scale / (r * r * scale * scale + COMPARE_EPSILON);
    }
    return sum / (double)values;
}

double regions_floor(const image_t *images, unsigned count, const image_t halves[2], double *error)
{
    const double scale = 1 / halves_luminance(halves);
    double sum = 0, sum2 = 0, pairs = 0;
    for (unsigned i = 0; i < count; i++)
        for (unsigned j = 0; j < i; j++) {
            const double value = floor_of_pair(&images[i], &images[j], halves, scale);
            sum += value;
            sum2 += value * value;
            pairs++;
        }
    const double mean = sum / pairs;
    *error = sqrt(fmax(0, sum2 / pairs - mean * mean) / (pairs - 1));
    return mean;
}

void regions_print(const char *title, const regions_t *a, const regions_t *b)
{
    printf("%s: ratio of the blocks' means\n", title);
    for (int y = 0; y < REGIONS_GRID; y++) {
        for (int x = 0; x < REGIONS_GRID; x++)
            printf(" %7.4f", a->mean[y * REGIONS_GRID + x] / b->mean[y * REGIONS_GRID + x]);
        putchar('\n');
    }
    fflush(stdout);
}

fault_code_t regions_shrink(image_t *out, const image_t *image, uint32_t factor, fault_t *fault)
{
    const float *planes[3];
    TRY(image_find_rgb(image, planes, fault));
    TRY(image_init_rgb(out, image->width / factor, image->height / factor, fault));
    for (uint32_t c = 0; c < 3; c++)
        for (uint32_t y = 0; y < out->height * factor; y++)
            for (uint32_t x = 0; x < out->width * factor; x++)
                image_channel(out, c)[(size_t)(y / factor) * out->width + x / factor] +=
                    planes[c][(size_t)y * image->width + x] / (float)(factor * factor);
    return FAULT_NONE;
}
