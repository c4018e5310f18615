/* compare.h: how far an image is from a reference, in the one way that every report, plan and bench of the project
 * uses.
 *
 * I is the image, R the reference; linear RGB, N pixels. All are first scaled by the same factor, so that the mean
 * luminance of R is 1.
 *
 *     MSE     = mean over pixels and channels of (I-R)^2
 *     relMSE  = mean over pixels and channels of (I-R)^2 / (R^2 + 0.01);   error = sqrt(relMSE)
 *     bias    = mean luminance of I / mean luminance of R
 *     trimmed = relMSE without the ceil(N/1000) pixels that are worst by their sum of (I-R)^2 / (R^2 + 0.01)
 *
 * With two independent references A and B (halves of one long render) R is (A+B)/2, pixels are still ranked by
 * (I-R)^2 / (R^2 + 0.01), but every (I-R)^2 in a mean becomes (I-A)(I-B): as the errors of A and B are independent
 * its expectation is (I-truth)^2 without the references' own noise. Such means can come out negative when the image
 * is better than the references; the error is then 0.
 *
 * Pixels with a non-finite channel in any of the images are counted, named and left out of everything.
 *
 * Thread rule: no state; results belong to the caller.
 */
#ifndef FILM_COMPARE_H
#define FILM_COMPARE_H

#include "film/image.h"

#define COMPARE_EPSILON 0.01  /* in the denominator, after scaling */
#define COMPARE_TRIM 0.001    /* share of the pixels that the trimmed figure leaves out */
#define COMPARE_HEAT_MIN 0.01 /* relative error that the heat map shows as black */
#define COMPARE_HEAT_MAX 10.0 /* and as white */
enum { COMPARE_GRID = 8, COMPARE_MAX_GRID = 32 };

/* All zero means the project's definitions. */
typedef struct compare_options {
    double trim;          /* share of pixels left out by the trimmed figure, below 1; 0: COMPARE_TRIM */
    uint32_t grid;        /* blocks across and down, at most COMPARE_MAX_GRID; 0: COMPARE_GRID */
    const char *names[3]; /* how messages call image, reference and second reference; null: just that */
} compare_options_t;

typedef struct compare_block {
    uint64_t pixels;         /* finite ones */
    double image, reference; /* mean luminance, scaled */
    double ratio;            /* image / reference; NaN if the reference is black */
} compare_block_t;

typedef struct compare_result {
    uint32_t width, height;
    double scale; /* 1 / mean luminance of the reference, what everything was multiplied by */
    double mse, relmse, error;
    double relmse_trimmed, error_trimmed;
    uint64_t trimmed;                  /* pixels left out by the trimmed figure */
    double bias;                       /* ratio of mean luminances */
    double bias_rgb[3];                /* ratio of means, by channel; NaN if the reference's is zero */
    uint32_t worst_x, worst_y;         /* the pixel that is worst */
    double worst;                      /* its mean over channels of (I-R)^2 / (R^2 + 0.01) */
    uint64_t nonfinite;                /* pixels left out */
    uint32_t nonfinite_x, nonfinite_y; /* the first of them, in reading order */
    const char *nonfinite_name;        /* the image it was found in, from the options; null if there is none */
    uint32_t grid;
    compare_block_t blocks[COMPARE_MAX_GRID *
                           COMPARE_MAX_GRID]; /* [grid][grid], rows from the top; fewer if the image is smaller */
} compare_result_t;

/* Compares image with reference, or with reference and second (null: one reference) as independent halves. options
 * may be null. FAULT_RANGE: sizes differ (both are named), no finite pixel, a reference without light, options out
 * of range; FAULT_NOT_FOUND: an image without R, G, B or Y; FAULT_MEMORY. */
fault_code_t compare_images(compare_result_t *result, const image_t *image, const image_t *reference,
                            const image_t *second, const compare_options_t *options, fault_t *fault);

/* A map of the same comparison: channel "error" is the square root of the mean over channels of (I-R)^2 / (R^2 +
 * 0.01), channels R, G, B show it in colour, ready for png_write with exposure 1: black, blue, red, yellow, white
 * on a logarithmic scale from COMPARE_HEAT_MIN to COMPARE_HEAT_MAX. Pixels that were left out are green, their
 * error NaN. The caller clears *map. */
fault_code_t compare_heat_map(image_t *map, const compare_result_t *result, const image_t *image,
                              const image_t *reference, const image_t *second, fault_t *fault);

#endif
