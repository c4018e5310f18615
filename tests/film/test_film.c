#include "support.h"

#include <math.h>
#include <zstd.h>

#include "film/film.h"

enum { WIDTH = 37, HEIGHT = 29, SPLATS = 20000, PARTS = 7 };

typedef struct splat {
    double x, y;
    rgb_t value;
} splat_t;

/* Mostly ordinary, one in 4 so large that nine of them in one pixel saturate it on average: of 19 splats a pixel
 * that makes five, so that some pixels saturate and most do not. */
static splat_t splat_at(uint64_t i)
{
    const uint64_t key = random_key(1, RANDOM_PURPOSE_TEST, 0, i);
    const double size = random_u64(key, 9) % 4 == 0 ? 0x1p33 : 13.857;
    return (splat_t){random_double(key, 0) * WIDTH,
                     random_double(key, 1) * HEIGHT,
                     {random_double(key, 2) * size, random_double(key, 3) * size, random_double(key, 4) * size}};
}

static void shuffled(uint32_t *order, uint32_t count, uint64_t stream)
{
    for (uint32_t i = 0; i < count; i++)
        order[i] = i;
    for (uint32_t i = count; i-- > 1;) {
        const uint32_t j = (uint32_t)(uniform(stream, i) * (i + 1)), kept = order[i];
        order[i] = order[j];
        order[j] = kept;
    }
}

/* Each pixel's exact sum in 128 bits, cut to the range at the end: what any order must give. */
static void expect_exact(const film_t *film)
{
    __extension__ static unsigned __int128 exact[WIDTH * HEIGHT * 3];
    memset(exact, 0, sizeof exact);
    for (uint64_t i = 0; i < SPLATS; i++) {
        const splat_t s = splat_at(i);
        const double channels[3] = {s.value.r, s.value.g, s.value.b};
        for (int c = 0; c < 3; c++)
            exact[3 * ((int)s.y * WIDTH + (int)s.x) + c] += (uint64_t)floor(ldexp(channels[c], 28) + 0.5);
    }
    uint64_t limited = 0;
    for (size_t i = 0; i < sizeof exact / sizeof *exact; i++) {
        limited += exact[i] > INT64_MAX;
        assert_int_equal(film->sums[i], exact[i] > INT64_MAX ? INT64_MAX : (int64_t)exact[i]);
    }
    assert_in_range(limited, 1, WIDTH * HEIGHT * 3 - 1); /* both kinds were met */
}

static void any_order_and_partition_gives_the_same_bits(void **state)
{
    (void)state;
    for (uint64_t round = 0; round < 4; round++) {
        film_t parts[PARTS], total;
        static uint32_t order[SPLATS];
        uint32_t merge[PARTS];
        shuffled(order, SPLATS, 100 + round);
        shuffled(merge, PARTS, 200 + round);
        assert_ok(film_init(&total, WIDTH, HEIGHT, fault));
        for (int p = 0; p < PARTS; p++)
            assert_ok(film_init(&parts[p], WIDTH, HEIGHT, fault));
        for (uint32_t i = 0; i < SPLATS; i++) {
            const splat_t s = splat_at(order[i]);
            film_splat(&parts[(size_t)(uniform(300 + round, i) * PARTS)], s.x, s.y, s.value);
        }
        film_add(&parts[merge[0]], &parts[merge[1]]); /* a relay in between */
        for (int p = 0; p < PARTS; p++)
            if (p != 1)
                film_add(&total, &parts[merge[p]]);
        expect_exact(&total);
        assert_int_equal(total.counts.splats, SPLATS);
        assert_true(total.counts.saturated > 0);
        for (int p = 0; p < PARTS; p++)
            film_clear(&parts[p]);
        film_clear(&total);
    }
}

static void what_cannot_enter_is_counted_by_cause(void **state)
{
    (void)state;
    film_t film;
    assert_ok(film_init(&film, WIDTH, HEIGHT, fault));
    const rgb_t good = rgb(1, 2, 3);
    film_splat(&film, -1e-9, 1, good);
    film_splat(&film, WIDTH, 1, good);
    film_splat(&film, 1, -3, good);
    film_splat(&film, 1, HEIGHT, good);
    film_splat(&film, 1e300, 1, good);
    assert_int_equal(film.counts.outside, 5);
    film_splat(&film, NAN, 1, good);
    film_splat(&film, 1, -INFINITY, good);
    film_splat(&film, 1, 1, rgb(1, NAN, 1));
    film_splat(&film, 1, 1, rgb(INFINITY, 1, 1));
    film_splat(&film, 1, 1, rgb(1, 1, -INFINITY));
    assert_int_equal(film.counts.nonfinite, 5);
    film_splat(&film, 1, 1, rgb(1, 1, -1e-300));
    film_splat(&film, 1, 1, rgb(-1, 1e300, 1));
    assert_int_equal(film.counts.negative, 2);
    assert_int_equal(film.counts.splats, 0);
    for (size_t i = 0; i < WIDTH * HEIGHT * 3; i++)
        assert_int_equal(film.sums[i], 0);
    film_splat(&film, 0, 0, rgb(-0.0, 0.25, 0));
    film_splat(&film, nextafter(WIDTH, 0), nextafter(HEIGHT, 0), good);
    assert_int_equal(film.counts.splats, 2);
    assert_int_equal(film.sums[1], (int64_t)1 << 26);
    assert_true(film_value(&film, WIDTH - 1, HEIGHT - 1).b == 3);
    film_reset(&film);
    assert_int_equal(film.counts.outside + film.counts.nonfinite + film.counts.negative + film.counts.splats, 0);
    assert_int_equal(film.sums[1], 0);
    film_clear(&film);
    film_clear(&film);
}

static void values_round_to_the_nearest_step(void **state)
{
    (void)state;
    const double step = 0x1p-28;
    const struct {
        double value;
        int64_t sum;
    } cases[] = {{0, 0},
                 {0.499 * step, 0},
                 {0.5 * step, 1},
                 {1.499 * step, 1},
                 {2.385 * step, 2},
                 {2.515 * step, 3},
                 {13.857, 3719710114}, /* 13.857 * 2^28 = 3719710113.8 */
                 {0x1p33, (int64_t)1 << 61}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        film_t film;
        assert_ok(film_init(&film, 1, 1, fault));
        film_splat(&film, 0.5, 0.5, rgb(0, cases[i].value, 0));
        assert_int_equal(film.sums[1], cases[i].sum);
        assert_int_equal(film.counts.saturated, 0);
        film_clear(&film);
    }
}

static void saturation_holds_the_limit_and_is_counted(void **state)
{
    (void)state;
    film_t film, other;
    assert_ok(film_init(&film, 2, 1, fault));
    assert_ok(film_init(&other, 2, 1, fault));
    film_splat(&film, 0, 0, rgb(1e300, 1, 0)); /* a value beyond the range */
    assert_int_equal(film.counts.saturated, 1);
    assert_int_equal(film.sums[0], (int64_t)1 << 61);
    assert_int_equal(film.sums[1], (int64_t)1 << 28);
    for (int i = 0; i < 3; i++) /* each 256 less than 2^61: just within the range */
        film_splat(&film, 0, 0, rgb(0x1.fffffffffffffp32, 1, 0));
    assert_int_equal(film.counts.saturated, 1);
    assert_true(film.sums[0] == INT64_MAX - 767);
    film_splat(&film, 0, 0, rgb(0x1p-18, 1, 0)); /* 1024 */
    assert_int_equal(film.counts.saturated, 2);
    assert_true(film.sums[0] == INT64_MAX);
    assert_int_equal(film.sums[1], (int64_t)5 << 28);
    assert_int_equal(film.counts.splats, 5);
    film_splat(&other, 0, 0, rgb(1, 0, 0));
    film_splat(&other, 1, 0, rgb(1, 0, 0));
    film_add(&other, &film);
    assert_int_equal(other.sums[0], INT64_MAX);
    assert_int_equal(other.sums[3], (int64_t)1 << 28);
    assert_int_equal(other.counts.saturated, 3);
    film.counts.outside = UINT64_MAX - 1;
    other.counts.outside = 3;
    film_add(&film, &other);
    assert_true(film.counts.outside == UINT64_MAX);
    film_clear(&film);
    film_clear(&other);
}

/* By 1 nothing changes; else to the nearest, and never below zero or beyond the range. */
static void films_are_scaled_to_the_nearest(void **state)
{
    (void)state;
    film_t film;
    assert_ok(film_init(&film, 1, 1, fault));
    film.sums[0] = 2385;
    film.sums[1] = 3;
    film.sums[2] = INT64_C(1) << 62;
    film_scale(&film, 1);
    assert_true(film.sums[0] == 2385 && film.sums[1] == 3 && film.sums[2] == INT64_C(1) << 62);
    film_scale(&film, 0.125); /* 298.125, 0.375 */
    assert_true(film.sums[0] == 298 && film.sums[1] == 0 && film.sums[2] == INT64_C(1) << 59);
    assert_int_equal(film.counts.saturated, 0);
    film_scale(&film, 16);
    assert_true(film.sums[0] == 4768 && film.sums[2] == INT64_MAX);
    assert_int_equal(film.counts.saturated, 1);
    film_clear(&film);
}

static void sizes_out_of_range_are_refused(void **state)
{
    (void)state;
    film_t film;
    assert_fault(FAULT_RANGE, "0 x 5", film_init(&film, 0, 5, fault));
    assert_fault(FAULT_RANGE, "5 x 0", film_init(&film, 5, 0, fault));
    assert_fault(FAULT_RANGE, "32769", film_init(&film, FILM_MAX_SIDE + 1, 1, fault));
    assert_null(film.sums);
    film_clear(&film);
}

/* `share` of the pixels hold something; sums of all magnitudes, the limit included. */
static void make_film(film_t *film, uint32_t width, uint32_t height, double share, uint64_t stream)
{
    assert_ok(film_init(film, width, height, fault));
    for (size_t i = 0; i < (size_t)width * height * 3; i++)
        if (uniform(stream, i / 3) < share)
            film->sums[i] = (int64_t)(random_u64(stream, i) >> (1 + random_u64(stream, ~i) % 63));
    film->counts = (film_counts_t){stream + 1, 2, UINT64_MAX, 4, 5};
    film->sums[0] = share > 0 ? INT64_MAX : 0;
}

static void assert_same(const film_t *a, const film_t *b)
{
    assert_int_equal(a->width, b->width);
    assert_memory_equal(a->sums, b->sums, (size_t)a->width * a->height * 3 * sizeof *a->sums);
    assert_memory_equal(&a->counts, &b->counts, sizeof a->counts);
}

static void encoding_round_trips(void **state)
{
    (void)state;
    const struct {
        uint32_t width, height;
        double share;
    } cases[] = {{1, 1, 1},    {1, 1, 0},    {32, 32, 1},      {31, 33, 1},   {33, 31, 0.5},
                 {64, 1, 0.1}, {1, 64, 0.1}, {257, 130, 0.01}, {300, 200, 0}, {300, 200, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        film_t film, back;
        make_film(&film, cases[i].width, cases[i].height, cases[i].share, i);
        make_film(&back, cases[i].width, cases[i].height, 1, 50 + i); /* what was there before is gone */
        uint8_t *data, *again;
        size_t size, again_size;
        assert_ok(film_encode(&film, &data, &size, fault));
        assert_ok(film_encode(&film, &again, &again_size, fault));
        assert_int_equal(size, again_size);
        assert_memory_equal(data, again, size);
        assert_ok(film_decode(&back, data, size, fault));
        assert_same(&film, &back);
        if (cases[i].share == 0)
            assert_in_range(size, 1, 100); /* empty tiles are left out */
        free(data);
        free(again);
        film_clear(&film);
        film_clear(&back);
    }
}

static void cut_data_is_refused_and_leaves_the_film_alone(void **state)
{
    (void)state;
    film_t film, target, before;
    make_film(&film, 40, 35, 0.05, 7);
    make_film(&target, 40, 35, 0.5, 8);
    make_film(&before, 40, 35, 0.5, 8);
    uint8_t *data;
    size_t size;
    assert_ok(film_encode(&film, &data, &size, fault));
    for (size_t cut = 0; cut < size; cut++) {
        uint8_t *exact = malloc(cut ? cut : 1); /* a sanitizer then sees a read past the end */
        memcpy(exact, data, cut);
        assert_fault(FAULT_FORMAT, "film data", film_decode(&target, exact, cut, fault));
        free(exact);
    }
    assert_same(&target, &before);
    data = realloc(data, size + 1);
    data[size] = 0;
    assert_fault(FAULT_FORMAT, "one whole zstd frame", film_decode(&target, data, size + 1, fault));
    assert_same(&target, &before);
    free(data);
    film_clear(&film);
    film_clear(&target);
    film_clear(&before);
}

/* zstd ignores some bits, and some only choose between equal ways to the same content (which of two equal matches
 * is copied): then the film must be the right one. The checksum refuses the rest. */
static void no_flipped_bit_passes_as_another_film(void **state)
{
    (void)state;
    film_t film, target;
    make_film(&film, 20, 35, 0.1, 9);
    assert_ok(film_init(&target, 20, 35, fault));
    uint8_t *data;
    size_t size, refused = 0;
    assert_ok(film_encode(&film, &data, &size, fault));
    for (size_t bit = 0; bit < 8 * size; bit++) {
        data[bit / 8] ^= (uint8_t)(1u << (bit % 8));
        fault_t fault = {0};
        if (film_decode(&target, data, size, &fault) == FAULT_NONE)
            assert_same(&film, &target);
        else
            refused++;
        data[bit / 8] ^= (uint8_t)(1u << (bit % 8));
    }
    assert_in_range(refused, 8 * size - size / 2, 8 * size); /* 15 of 16 */
    free(data);
    film_clear(&film);
    film_clear(&target);
}

/* A header of the given size before a whole, well-formed frame of this payload. */
static size_t wrap(uint8_t *out, size_t capacity, uint32_t width, uint32_t height, uint64_t stated,
                   const uint8_t *payload, size_t size)
{
    memcpy(out, "GFLM\1\0\0\0", 8);
    for (int i = 0; i < 4; i++) {
        out[8 + i] = (uint8_t)(width >> (8 * i));
        out[12 + i] = (uint8_t)(height >> (8 * i));
    }
    for (int i = 0; i < 8; i++)
        out[16 + i] = (uint8_t)(stated >> (8 * i));
    const size_t packed = ZSTD_compress(out + 24, capacity - 24, payload, size, 1);
    assert_false(ZSTD_isError(packed));
    return 24 + packed;
}

static void well_packed_nonsense_is_refused(void **state)
{
    (void)state;
    film_t film;
    assert_ok(film_init(&film, 2, 1, fault));
    uint8_t data[512], payload[128] = {0};
    enum { MAP = 40, TILE = 41 };
    size_t size;
#define TRY_PAYLOAD(piece, stated, length)                                                                         \
    size = wrap(data, sizeof data, 2, 1, stated, payload, length);                                                 \
    assert_fault(FAULT_FORMAT, piece, film_decode(&film, data, size, fault))
    payload[MAP] = 2; /* the second of one tile */
    TRY_PAYLOAD("tile 1", 41, 41);
    payload[MAP] = 1;
    TRY_PAYLOAD("0 bytes left", 41, 41);
    payload[TILE] = 9;
    TRY_PAYLOAD("9 byte planes", 44, 44);
    payload[TILE] = 8;
    TRY_PAYLOAD("18 bytes left, 19 expected", 59, 59);
    payload[TILE + 3 + 15] = 0x80; /* top byte of the second pixel's red */
    TRY_PAYLOAD("negative sum", 60, 60);
    payload[TILE + 3 + 15] = 0x7f;
    TRY_PAYLOAD("2 bytes after the last tile", 62, 62);
    TRY_PAYLOAD("no zstd frame of 61 bytes", 61, 60);
    TRY_PAYLOAD("payload of 4611686018427387904 bytes", UINT64_C(1) << 62, 60);
    TRY_PAYLOAD("payload of 40 bytes", 40, 40);
#undef TRY_PAYLOAD
    size = wrap(data, sizeof data, 2, 1, 60, payload, 60);
    assert_ok(film_decode(&film, data, size, fault));
    assert_true(film.sums[3] == INT64_C(0x7f00000000000000));
    size = wrap(data, sizeof data, 1, 2, 60, payload, 60);
    assert_fault(FAULT_FORMAT, "1 x 2 pixels found, 2 x 1 expected", film_decode(&film, data, size, fault));
    data[4] = 2;
    assert_fault(FAULT_VERSION, "version 2.0", film_decode(&film, data, size, fault));
    data[0] = 'X';
    assert_fault(FAULT_FORMAT, "byte 0", film_decode(&film, data, size, fault));
    film_clear(&film);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_order_and_partition_gives_the_same_bits),
        cmocka_unit_test(what_cannot_enter_is_counted_by_cause),
        cmocka_unit_test(values_round_to_the_nearest_step),
        cmocka_unit_test(saturation_holds_the_limit_and_is_counted),
        cmocka_unit_test(films_are_scaled_to_the_nearest),
        cmocka_unit_test(sizes_out_of_range_are_refused),
        cmocka_unit_test(encoding_round_trips),
        cmocka_unit_test(cut_data_is_refused_and_leaves_the_film_alone),
        cmocka_unit_test(no_flipped_bit_passes_as_another_film),
        cmocka_unit_test(well_packed_nonsense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
