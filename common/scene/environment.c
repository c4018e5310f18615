#include "scene/environment.h"

#include <stdlib.h>
#include <string.h>

#include "scene/texel.h"

/* The texel at (x,y), each at most one beyond the image: there the square folds. */
static rgb_t folded_texel(const scene_t *scene, const scene_image_t *image, int64_t x, int64_t y)
{
    const int64_t width = image->width, height = image->height;
    if (x < 0 || x >= width) {
        x = x < 0 ? -1 - x : 2 * width - 1 - x;
        y = height - 1 - y;
    }
    if (y < 0 || y >= height) {
        y = y < 0 ? -1 - y : 2 * height - 1 - y;
        x = width - 1 - x;
    }
    const rgb_t c = texel_rgb(scene, image, (uint32_t)x, (uint32_t)y);
    return rgb(fmax(c.r, 0), fmax(c.g, 0), fmax(c.b, 0));
}

rgb_t environment_radiance(const scene_t *scene, const scene_image_t *image, rgb_t scale, double x, double y)
{
    const double px = x * image->width - 0.5, py = y * image->height - 0.5;
    const double floor_x = floor(px), floor_y = floor(py);
    const double fx = px - floor_x, fy = py - floor_y;
    const int64_t ix = (int64_t)floor_x, iy = (int64_t)floor_y;
    rgb_t sum = rgb_scale(folded_texel(scene, image, ix, iy), (1 - fx) * (1 - fy));
    sum = rgb_mad(sum, fx * (1 - fy), folded_texel(scene, image, ix + 1, iy));
    sum = rgb_mad(sum, (1 - fx) * fy, folded_texel(scene, image, ix, iy + 1));
    sum = rgb_mad(sum, fx * fy, folded_texel(scene, image, ix + 1, iy + 1));
    return rgb_mul(sum, scale);
}

/* Integral of the bilinear luminance over the texel's own area, in texels. */
static double texel_integral(const scene_t *scene, const scene_image_t *image, rgb_t scale, int64_t x, int64_t y)
{
    static const double weight[3] = {0.125, 0.75, 0.125};
    double sum = 0;
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++)
            sum += weight[i] * weight[j] *
                   rgb_luminance(rgb_mul(scale, folded_texel(scene, image, x + i - 1, y + j - 1)));
    return sum;
}

/* Texel i of n over cells of a table of m <= n: the first cell it meets and its share of it; the rest is the next
 * cell's. */
static uint32_t first_cell(uint32_t i, uint32_t n, uint32_t m, double *share)
{
    const uint64_t begin = (uint64_t)i * m, end = begin + m; /* in units of 1 / (n m) */
    const uint64_t cell = begin / n, border = (cell + 1) * n;
    *share = end <= border ? 1 : (double)(border - begin) / m;
    return (uint32_t)cell;
}

static void add_texels(const scene_t *scene, const scene_image_t *image, rgb_t scale, uint32_t width,
                       uint32_t height, double *weights)
{
    for (uint32_t y = 0; y < image->height; y++) {
        double share_y;
        const uint32_t row = first_cell(y, image->height, height, &share_y);
        for (uint32_t x = 0; x < image->width; x++) {
            double share_x;
            const uint32_t column = first_cell(x, image->width, width, &share_x);
            const double value = texel_integral(scene, image, scale, x, y);
            double *const cell = weights + (size_t)row * width + column;
            cell[0] += value * share_x * share_y;
            if (share_x < 1)
                cell[1] += value * (1 - share_x) * share_y;
            if (share_y < 1)
                cell[width] += value * share_x * (1 - share_y);
            if (share_x < 1 && share_y < 1)
                cell[width + 1] += value * (1 - share_x) * (1 - share_y);
        }
    }
}

fault_code_t environment_table(const scene_t *scene, const scene_image_t *image, rgb_t scale, table2_t *table,
                               double *mean, fault_t *fault)
{
    memset(table, 0, sizeof *table);
    *mean = 0;
    const uint32_t width = image->width < ENVIRONMENT_MAX_TABLE ? image->width : ENVIRONMENT_MAX_TABLE;
    const uint32_t height = image->height < ENVIRONMENT_MAX_TABLE ? image->height : ENVIRONMENT_MAX_TABLE;
    double *weights = calloc((size_t)width * height, sizeof *weights);
    if (!weights)
        return fault_set(fault, FAULT_MEMORY, "environment: no memory for a table of %ux%u", width, height);
    add_texels(scene, image, scale, width, height, weights);
    double sum = 0;
    for (size_t i = 0; i < (size_t)width * height; i++)
        sum += weights[i];
    fault_code_t code = FAULT_NONE;
    if (sum != 0)
        code = table2_init(table, weights, width, height, fault);
    if (code == FAULT_NONE)
        *mean = sum / ((double)image->width * image->height);
    free(weights);
    return fault_prefix(fault, code, "environment");
}
