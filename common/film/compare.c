#include "film/compare.h"

#include <math.h>
#include <stdlib.h>

#include "math/vec.h"

static const char *const DEFAULT_NAMES[3] = {"image", "reference", "second reference"};

/* The planes of the two or three images; with one reference A and B are the same. */
typedef struct planes {
    size_t pixels;
    uint32_t width;
    const float *image[3], *a[3], *b[3];
    bool two;
} planes_t;

static rgb_t pixel_of(const float *const planes[3], size_t i)
{
    return rgb((double)planes[0][i], (double)planes[1][i], (double)planes[2][i]);
}

static bool all_finite(rgb_t c)
{
    return isfinite(c.r) && isfinite(c.g) && isfinite(c.b);
}

/* 0, 1, 2: the image in which pixel i is not finite; -1: all are. */
static int nonfinite_in(const planes_t *p, size_t i)
{
    if (!all_finite(pixel_of(p->image, i)))
        return 0;
    if (!all_finite(pixel_of(p->a, i)))
        return 1;
    return all_finite(pixel_of(p->b, i)) ? -1 : 2;
}

static rgb_t reference_at(const planes_t *p, size_t i)
{
    return rgb_scale(rgb_add(pixel_of(p->a, i), pixel_of(p->b, i)), 0.5);
}

static fault_code_t find_planes(planes_t *p, const image_t *const images[3], const char *const names[3],
                                fault_t *fault)
{
    *p = (planes_t){
        (size_t)images[0]->width * images[0]->height, images[0]->width, {0}, {0}, {0}, images[2] != NULL};
    const float **planes[3] = {p->image, p->a, p->b};
    for (int i = 0; i < 3; i++) {
        const image_t *image = images[i] ? images[i] : images[1];
        if (image->width != images[0]->width || image->height != images[0]->height)
            return fault_set(fault, FAULT_RANGE, "sizes differ: %s has %u x %u pixels, %s %u x %u", names[0],
                             images[0]->width, images[0]->height, names[i], image->width, image->height);
        TRY(fault_prefix(fault, image_find_rgb(image, planes[i], fault), "%s", names[i]));
    }
    return FAULT_NONE;
}

/* Sums of the finite pixels, of the image and of the reference. */
typedef struct totals {
    uint64_t pixels;
    rgb_t image, reference;
} totals_t;

static fault_code_t sum_up(const planes_t *p, totals_t *totals, compare_result_t *result,
                           const char *const names[3], fault_t *fault)
{
    *totals = (totals_t){0};
    for (size_t i = 0; i < p->pixels; i++) {
        const int where = nonfinite_in(p, i);
        if (where >= 0) {
            if (result->nonfinite++ == 0) {
                result->nonfinite_x = (uint32_t)(i % p->width);
                result->nonfinite_y = (uint32_t)(i / p->width);
                result->nonfinite_name = names[where];
            }
            continue;
        }
        totals->pixels++;
        totals->image = rgb_add(totals->image, pixel_of(p->image, i));
        totals->reference = rgb_add(totals->reference, reference_at(p, i));
    }
    if (totals->pixels == 0)
        return fault_set(fault, FAULT_RANGE, "%s and %s have no pixel in common that is finite", names[0],
                         names[1]);
    const double mean = rgb_luminance(totals->reference) / (double)totals->pixels;
    result->scale = 1 / mean;
    if (!(mean > 0) || !isfinite(result->scale))
        return fault_set(fault, FAULT_RANGE, "%s: mean luminance is %g, a positive number is needed", names[1],
                         mean);
    return FAULT_NONE;
}

/* One pixel's sums over the three channels. */
typedef struct pixel_error {
    double rank;     /* (I-R)^2 / (R^2 + eps) */
    double squared;  /* (I-A)(I-B) */
    double relative; /* (I-A)(I-B) / (R^2 + eps) */
} pixel_error_t;

static pixel_error_t pixel_error(const planes_t *p, double scale, size_t i)
{
    pixel_error_t e = {0};
    for (int c = 0; c < 3; c++) {
        const double v = scale * (double)p->image[c][i], a = scale * (double)p->a[c][i],
                     b = scale * (double)p->b[c][i], r = 0.5 * (a + b);
        const double weight = 1 / (r * r + COMPARE_EPSILON);
        e.rank += (v - r) * (v - r) * weight;
        e.squared += (v - a) * (v - b);
        e.relative += (v - a) * (v - b) * weight;
    }
    return e;
}

/* A pixel among the ranked: worst first, ties in reading order, so that the choice is the same everywhere. */
typedef struct ranked {
    double rank, relative;
    size_t index;
} ranked_t;

static int by_rank(const void *pa, const void *pb)
{
    const ranked_t *a = pa, *b = pb;
    if (a->rank != b->rank)
        return a->rank > b->rank ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

static double root(double mean)
{
    return mean > 0 ? sqrt(mean) : 0;
}

/* ceil(trim * count), but one pixel stays. The product of a decimal fraction like 0.001 may exceed the whole number
 * it stands for by some 1e-16 of it: that is no reason to take one more. */
static uint64_t trim_count(double trim, uint64_t count)
{
    const double share = trim * (double)count;
    const uint64_t left_out = (uint64_t)ceil(share - 1e-12 * share);
    return left_out < count ? left_out : count - 1;
}

static fault_code_t rank_errors(const planes_t *p, double trim, uint64_t pixels, compare_result_t *result,
                                fault_t *fault)
{
    ranked_t *ranked = malloc(pixels * sizeof *ranked);
    if (!ranked)
        return fault_set(fault, FAULT_MEMORY, "comparing %llu pixels: out of memory", (unsigned long long)pixels);
    double squared = 0, relative = 0, kept = 0;
    size_t count = 0;
    for (size_t i = 0; i < p->pixels; i++) {
        if (nonfinite_in(p, i) >= 0)
            continue;
        const pixel_error_t e = pixel_error(p, result->scale, i);
        squared += e.squared;
        relative += e.relative;
        ranked[count++] = (ranked_t){e.rank, e.relative, i};
    }
    qsort(ranked, count, sizeof *ranked, by_rank);
    result->trimmed = trim_count(trim, count);
    for (size_t i = count; i-- > result->trimmed;)
        kept += ranked[i].relative;
    result->mse = squared / (3 * (double)count);
    result->relmse = relative / (3 * (double)count);
    result->error = root(result->relmse);
    result->relmse_trimmed = kept / (3 * (double)(count - result->trimmed));
    result->error_trimmed = root(result->relmse_trimmed);
    result->worst = ranked[0].rank / 3;
    result->worst_x = (uint32_t)(ranked[0].index % p->width);
    result->worst_y = (uint32_t)(ranked[0].index / p->width);
    free(ranked);
    return FAULT_NONE;
}

static void fill_blocks(const planes_t *p, compare_result_t *result)
{
    const uint32_t grid = result->grid;
    for (size_t i = 0; i < p->pixels; i++) {
        if (nonfinite_in(p, i) >= 0)
            continue;
        const size_t x = i % p->width, y = i / p->width;
        compare_block_t *block = &result->blocks[y * grid / result->height * grid + x * grid / result->width];
        block->pixels++;
        block->image += rgb_luminance(pixel_of(p->image, i));
        block->reference += rgb_luminance(reference_at(p, i));
    }
    for (uint32_t i = 0; i < grid * grid; i++) {
        compare_block_t *block = &result->blocks[i];
        block->ratio = block->reference != 0 ? block->image / block->reference : NAN;
        if (block->pixels > 0) {
            block->image *= result->scale / (double)block->pixels;
            block->reference *= result->scale / (double)block->pixels;
        }
    }
}

static fault_code_t check_options(const compare_options_t *options, fault_t *fault)
{
    if (!(options->trim >= 0 && options->trim < 1))
        return fault_set(fault, FAULT_RANGE, "trim: %g found, a share below 1 expected", options->trim);
    if (options->grid > COMPARE_MAX_GRID)
        return fault_set(fault, FAULT_RANGE, "grid: %u found, at most %d expected", options->grid,
                         COMPARE_MAX_GRID);
    return FAULT_NONE;
}

static double ratio(double image, double reference)
{
    return reference != 0 ? image / reference : NAN;
}

fault_code_t compare_images(compare_result_t *result, const image_t *image, const image_t *reference,
                            const image_t *second, const compare_options_t *options, fault_t *fault)
{
    const compare_options_t chosen = options ? *options : (compare_options_t){0};
    *result = (compare_result_t){.width = image->width, .height = image->height};
    TRY(check_options(&chosen, fault));
    const char *names[3];
    for (int i = 0; i < 3; i++)
        names[i] = chosen.names[i] ? chosen.names[i] : DEFAULT_NAMES[i];
    const image_t *const images[3] = {image, reference, second};
    planes_t planes;
    totals_t totals;
    TRY(find_planes(&planes, images, names, fault));
    TRY(sum_up(&planes, &totals, result, names, fault));
    TRY(rank_errors(&planes, chosen.trim > 0 ? chosen.trim : COMPARE_TRIM, totals.pixels, result, fault));
    result->bias = rgb_luminance(totals.image) / rgb_luminance(totals.reference);
    result->bias_rgb[0] = ratio(totals.image.r, totals.reference.r);
    result->bias_rgb[1] = ratio(totals.image.g, totals.reference.g);
    result->bias_rgb[2] = ratio(totals.image.b, totals.reference.b);
    result->grid = chosen.grid ? chosen.grid : COMPARE_GRID;
    fill_blocks(&planes, result);
    return FAULT_NONE;
}

/* Black, blue, red, yellow, white at 0, 1/4, 1/2, 3/4, 1, linear between. */
static rgb_t heat_colour(double t)
{
    static const rgb_t stops[] = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}};
    const double scaled = 4 * fmin(fmax(t, 0), 1);
    const int i = scaled < 3 ? (int)scaled : 3;
    return rgb_mad(rgb_scale(stops[i], 1 - (scaled - i)), scaled - i, stops[i + 1]);
}

fault_code_t compare_heat_map(image_t *map, const compare_result_t *result, const image_t *image,
                              const image_t *reference, const image_t *second, fault_t *fault)
{
    *map = (image_t){0};
    const image_t *const images[3] = {image, reference, second};
    planes_t planes;
    TRY(find_planes(&planes, images, DEFAULT_NAMES, fault));
    static const char *const names[] = {"R", "G", "B", "error"};
    TRY(image_init(map, image->width, image->height, 4, names, fault));
    for (size_t i = 0; i < planes.pixels; i++) {
        double error = NAN;
        rgb_t colour = rgb(0, 1, 0);
        if (nonfinite_in(&planes, i) < 0) {
            error = sqrt(pixel_error(&planes, result->scale, i).rank / 3);
            colour = heat_colour(log(error / COMPARE_HEAT_MIN) / log(COMPARE_HEAT_MAX / COMPARE_HEAT_MIN));
        }
        image_channel(map, 0)[i] = (float)colour.r;
        image_channel(map, 1)[i] = (float)colour.g;
        image_channel(map, 2)[i] = (float)colour.b;
        image_channel(map, 3)[i] = (float)error;
    }
    return FAULT_NONE;
}
