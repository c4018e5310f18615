/* exr_samples.h: OpenEXR files of kinds that Garland doesn't write but others do, made with OpenEXRCore directly.
 */
#ifndef TESTS_FILM_EXR_SAMPLES_H
#define TESTS_FILM_EXR_SAMPLES_H

#include <stddef.h>
#include <stdint.h>

#include <openexr.h>

typedef struct exr_sample {
    const char *name;
    exr_compression_t compression;
    exr_pixel_type_t type;       /* of channels "B", "G" and "R"; "layer.A" is half in every sample */
    uint32_t tile;               /* its side; 0: scan lines */
    int mipmap;                  /* tiled: with levels */
    int32_t x, y, width, height; /* data window */
    double tolerance;            /* of what a reader gets, for lossy kinds */
} exr_sample_t;

enum { EXR_SAMPLE_CHANNELS = 4, EXR_SAMPLE_COUNT = 14 };
extern const exr_sample_t exr_samples[EXR_SAMPLE_COUNT];

/* What pixel (x,y) of channel c (in order of name) holds: a whole number below 2048, which every type can hold. */
static inline double exr_sample_value(int c, int32_t x, int32_t y)
{
    return (x * 3 + y * 41 + c * 97) % 1999;
}

/* The file's bytes, the caller's to free(); aborts if the library fails. */
uint8_t *exr_sample_make(const exr_sample_t *sample, size_t *size);

/* Only a header (and an empty chunk table): deep, or with a channel subsampled by 2. */
uint8_t *exr_sample_make_header(int deep, size_t *size);

#endif
