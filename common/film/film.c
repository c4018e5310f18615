#include "film/film.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/pages.h"

fault_code_t film_init(film_t *film, uint32_t width, uint32_t height, fault_t *fault)
{
    *film = (film_t){0};
    if (width == 0 || height == 0 || width > FILM_MAX_SIDE || height > FILM_MAX_SIDE)
        return fault_set(fault, FAULT_RANGE, "film of %u x %u pixels: each side must be 1 to %d", width, height,
                         FILM_MAX_SIDE);
    int64_t *sums = pages_new((size_t)width * height, FILM_CHANNELS * sizeof *sums);
    if (!sums)
        return fault_set(fault, FAULT_MEMORY, "film of %u x %u pixels: out of memory", width, height);
    film->width = width;
    film->height = height;
    film->sums = sums;
    return FAULT_NONE;
}

void film_clear(film_t *film)
{
    free(film->sums);
    *film = (film_t){0};
}

void film_reset(film_t *film)
{
    memset(film->sums, 0, (size_t)film->width * film->height * FILM_CHANNELS * sizeof *film->sums);
    film->counts = (film_counts_t){0};
}

/* *sum += add, at most INT64_MAX; true if that limit was met. Both are non-negative, so the unsigned sum is exact.
 */
static bool add_saturated(int64_t *sum, int64_t add)
{
    const uint64_t exact = (uint64_t)*sum + (uint64_t)add;
    const bool over = exact > INT64_MAX;
    *sum = over ? INT64_MAX : (int64_t)exact;
    return over;
}

void film_splat_rare(film_t *film, double x, double y, rgb_t value)
{
    if (!isfinite(x) || !isfinite(y) || !isfinite(value.r) || !isfinite(value.g) || !isfinite(value.b)) {
        film->counts.nonfinite++;
        return;
    }
    if (value.r < 0 || value.g < 0 || value.b < 0) {
        film->counts.negative++;
        return;
    }
    if (!(x >= 0 && y >= 0 && x < film->width && y < film->height)) {
        film->counts.outside++;
        return;
    }
    int64_t *sum = film->sums + FILM_CHANNELS * ((size_t)(uint32_t)y * film->width + (uint32_t)x);
    const double channels[FILM_CHANNELS] = {value.r, value.g, value.b};
    bool over = false;
    for (int c = 0; c < FILM_CHANNELS; c++) {
        over |= channels[c] > FILM_VALUE_MAX;
        const int64_t add = (int64_t)(fmin(channels[c], FILM_VALUE_MAX) * FILM_ONE + 0.5);
        over |= add_saturated(&sum[c], add);
    }
    film->counts.saturated += over;
    film->counts.splats++;
}

static void add_count(uint64_t *a, uint64_t b)
{
    if (__builtin_add_overflow(*a, b, a))
        *a = UINT64_MAX;
}

void film_add(film_t *a, const film_t *b)
{
    assert(a->width == b->width && a->height == b->height);
    const size_t count = (size_t)a->width * a->height * FILM_CHANNELS;
    int64_t *restrict sum = a->sums;
    const int64_t *restrict more = b->sums;
    uint64_t saturated = 0;
    for (size_t i = 0; i < count; i++)
        saturated += add_saturated(&sum[i], more[i]);
    add_count(&a->counts.splats, b->counts.splats);
    add_count(&a->counts.outside, b->counts.outside);
    add_count(&a->counts.nonfinite, b->counts.nonfinite);
    add_count(&a->counts.negative, b->counts.negative);
    add_count(&a->counts.saturated, b->counts.saturated);
    add_count(&a->counts.saturated, saturated);
}

void film_scale(film_t *film, double factor)
{
    const size_t count = (size_t)film->width * film->height * FILM_CHANNELS;
    for (size_t i = 0; i < count; i++) {
        if (film->sums[i] == 0)
            continue;
        const double scaled = (double)film->sums[i] * factor + 0.5;
        const bool over = scaled >= 0x1p63;
        film->sums[i] = over ? INT64_MAX : (int64_t)scaled;
        film->counts.saturated += over;
    }
}
