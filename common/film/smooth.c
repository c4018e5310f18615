#include "film/smooth.h"

size_t smooth_scratch(uint32_t width, uint32_t height, uint32_t r)
{
    const size_t kept = r < height ? r + 1 : height; /* rows */
    return width * (1 + kept);
}

/* How many of n values are within r of the i-th. */
static double smooth_count(uint32_t i, uint32_t n, uint32_t r)
{
    const uint32_t low = i > r ? i - r : 0, high = i + r < n ? i + r : n - 1;
    return high - low + 1;
}

static void smooth_row(double *row, uint32_t n, uint32_t r, double *line)
{
    double sum = 0;
    for (uint32_t i = 0; i < n; i++)
        line[i] = row[i];
    for (uint32_t i = 0; i < r && i < n; i++)
        sum += line[i];
    for (uint32_t i = 0; i < n; i++) {
        sum += i + r < n ? line[i + r] : 0;
        sum -= i > r ? line[i - r - 1] : 0;
        row[i] = sum / smooth_count(i, n, r);
    }
}

static void smooth_add(double *restrict sums, const double *restrict row, uint32_t width)
{
    for (uint32_t x = 0; x < width; x++)
        sums[x] += row[x];
}

static void smooth_subtract(double *restrict sums, const double *restrict row, uint32_t width)
{
    for (uint32_t x = 0; x < width; x++)
        sums[x] -= row[x];
}

/* Keeps a row, and puts the means in its place. */
static void smooth_means(double *restrict row, double *restrict kept, const double *restrict sums, double count,
                         uint32_t width)
{
    for (uint32_t x = 0; x < width; x++) {
        kept[x] = row[x];
        row[x] = sums[x] / count;
    }
}

/* A row leaves the sums r + 1 rows after its means have taken its place: `kept` holds the last so many. */
static void smooth_columns(double *plane, uint32_t width, uint32_t height, uint32_t r, double *sums, double *kept)
{
    for (uint32_t x = 0; x < width; x++)
        sums[x] = 0;
    for (uint32_t y = 0; y < r && y < height; y++)
        smooth_add(sums, plane + (size_t)width * y, width);
    for (uint32_t y = 0; y < height; y++) {
        double *old = kept + (size_t)width * (y % (r + 1));
        if (y + r < height)
            smooth_add(sums, plane + (size_t)width * (y + r), width);
        if (y > r)
            smooth_subtract(sums, old, width);
        smooth_means(plane + (size_t)width * y, old, sums, smooth_count(y, height, r), width);
    }
}

void smooth_square(double *plane, uint32_t width, uint32_t height, uint32_t r, double *scratch)
{
    for (uint32_t y = 0; y < height; y++)
        smooth_row(plane + (size_t)width * y, width, r, scratch);
    smooth_columns(plane, width, height, r, scratch, scratch + width);
}
