/* Light shared between samples and chains: what one gets the other lacks, to the last digit and in records. And
 * samples that go to long paths only now and then: as often as they should, evenly, and without bias. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "chain/cutoff.h"
#include "chain/net.h"
#include "chain/split.h"
#include "chain/work_fixture.h"

enum { SAMPLES = 24 * 24 * 8, K = WORK_FIXTURE_LENGTH };

static work_fixture_t fixture;
static const atomic_bool go = false;

/* The fixture's own renderer is of a job without split; one more, of a job with it. */
static renderer_t *renderer;
static work_space_t *space;

static int make(void **state)
{
    (void)state;
    fault_t fault = {0};
    work_fixture_make(&fixture, SMALL_LIGHT_AREA, SETTINGS_MMLT);
    settings_t settings = fixture.settings;
    settings.split = 10;
    return renderer_new(&renderer, &fixture.small.scene, &settings, &fault) ||
           work_space_new(&space, renderer, &fault);
}

static int clear(void **state)
{
    (void)state;
    work_space_destroy(&space);
    renderer_destroy(&renderer);
    work_fixture_clear(&fixture);
    return 0;
}

static void the_parts_add_up(void **state)
{
    (void)state;
    const uint64_t key = random_key(2385, RANDOM_PURPOSE_TEST, 21, 0);
    for (uint64_t i = 0; i < 10000; i++) {
        const double c = pow(10, 20 * random_double(key, 2 * i) - 10),
                     cap = i % 10 == 0   ? 0
                           : i % 10 == 1 ? INFINITY
                                         : c * pow(10, 4 * random_double(key, 2 * i + 1) - 2),
                     kept = split_kept(c, cap), excess = split_excess(c, cap);
        assert_true(kept >= 0 && kept <= 1 && kept * c <= cap * (1 + 1e-15));
        if (!(fabs(kept * c + fmax(excess, 0) - c) <= 4e-16 * c))
            fail_msg("%g and %g of %g at the cap %g", kept * c, excess, c, cap);
    }
}

/* Sums of a unit of samples: the film's luminance over the scale, and what chains would follow. */
typedef struct parts {
    double film, chains[K + 1], squares;
} parts_t;

static parts_t parts_of(const double *caps, const double *rates, uint64_t first)
{
    double copy[K], copied[K];
    work_record_t record = {
        .kind = WORK_SAMPLES, .first = first, .count = SAMPLES, .point = first / (24 * 24), .scale = 0x1p-10};
    work_result_t result;
    fault_t fault = {0};
    parts_t parts = {0};
    if (caps) {
        memcpy(copy, caps, sizeof copy);
        record.caps = copy;
        record.cap_count = K;
    }
    if (rates) {
        memcpy(copied, rates, sizeof copied);
        record.rates = copied;
        record.rate_count = K;
    }
    if (work_run(caps || rates ? space : fixture.space, &record, &go, &result, &fault))
        fail_msg("%s", fault.text);
    for (uint32_t y = 0; y < result.film.height; y++)
        for (uint32_t x = 0; x < result.film.width; x++)
            parts.film += rgb_luminance(film_value(&result.film, x, y)) / record.scale;
    for (uint32_t k = 1; k <= K; k++) {
        parts.chains[k] = result.moments[work_samples_moment(k)].sum;
        parts.squares += result.moments[work_samples_moment(k)].sum2;
    }
    return parts;
}

static double total(const parts_t *parts)
{
    double sum = 0;
    for (uint32_t k = 1; k <= K; k++)
        sum += parts->chains[k];
    return sum;
}

/* The same samples under different caps: film and excess add up to the samples' whole light. Rounding in the film
 * is 2^-28 of its unit a splat. */
static void what_samples_leave_is_what_chains_follow(void **state)
{
    (void)state;
    const parts_t whole = parts_of(NULL, NULL, 0);
    const double rounding = 3.0 * SAMPLES * (K + 1) * 0x1p-28 / 0x1p-10 + 1e-9 * whole.film;
    assert_true(fabs(whole.film - total(&whole)) < rounding); /* a box filter: all of it is in the image */
    static const double sizes[] = {0, 0.1, 1, 10, 1e3, INFINITY};
    double before = -1;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        double caps[K];
        for (uint32_t k = 1; k <= K; k++)
            caps[k - 1] = sizes[i] * whole.chains[k] / SAMPLES;
        const parts_t parts = parts_of(caps, NULL, 0);
        if (!(fabs(parts.film + total(&parts) - whole.film) < rounding))
            fail_msg("caps of %g means: %g of samples and %g of chains, expected %g", sizes[i], parts.film,
                     total(&parts), whole.film);
        assert_true(i < 4 ? parts.film > before
                          : parts.film >= before); /* the higher, the more is left to samples */
        before = parts.film;
        if (sizes[i] == 0)
            assert_true(parts.film == 0 && parts.squares == whole.squares);
        if (sizes[i] == INFINITY)
            assert_true(parts.film == whole.film && total(&parts) == 0);
    }
}

/* Film and excess of samples with rates against those without, from the same walks, over 64 units: z below 4.5 for
 * seven figures (false alarms: 5e-5). Rates of 1 are none, to the bit, and without caps samples bring all light. */
static void samples_that_are_cut_off_are_unbiased(void **state)
{
    (void)state;
    enum { UNITS = 64 };
    static const double rates[K] = {1, 0.7, 0.7, 0.3, 0.1}, ones[K] = {1, 1, 1, 1, 1};
    const parts_t whole = parts_of(NULL, NULL, 0);
    double caps[K], sum[K + 2] = {0}, squares[K + 2] = {0};
    for (uint32_t k = 1; k <= K; k++)
        caps[k - 1] = 3 * whole.chains[k] / SAMPLES;
    const parts_t plain = parts_of(caps, NULL, 0), same = parts_of(caps, ones, 0), all = parts_of(NULL, ones, 0);
    assert_memory_equal(&plain, &same, sizeof plain);
    assert_memory_equal(&whole, &all, sizeof whole);
    for (uint64_t u = 0; u < UNITS; u++) {
        const parts_t a = parts_of(caps, NULL, u * SAMPLES), b = parts_of(caps, rates, u * SAMPLES);
        for (uint32_t k = 0; k <= K + 1; k++) {
            const double d = k == 0 ? b.film - a.film : k <= K ? b.chains[k] - a.chains[k] : total(&b) - total(&a);
            sum[k] += d;
            squares[k] += d * d;
        }
    }
    for (uint32_t k = 0; k <= K + 1; k++) {
        const double mean = sum[k] / UNITS, error = sqrt((squares[k] / UNITS - mean * mean) / (UNITS - 1));
        if (k == 1 ? mean != 0 : !(fabs(mean) < 4.5 * error))
            fail_msg("%s %u: %g +- %g off", k == 0 ? "film" : k <= K ? "length" : "all", k, mean, error);
    }
}

/* The image's weights share out the light of a path anew and leave its sum (sampler.h): by length, against the sum
 * over techniques by the balance heuristic of the same samples, over 64 units: z below 4.5 for two figures (false
 * alarms: 1.4e-5). Longer paths have one kind of weights, to the last digits. */
static void weights_of_the_image_leave_the_light(void **state)
{
    (void)state;
    enum { UNITS = 64 };
    double sum[K + 1] = {0}, squares[K + 1] = {0}, light[K + 1] = {0};
    for (uint64_t u = 0; u < UNITS; u++) {
        const work_record_t record = {.kind = WORK_SAMPLES,
                                      .first = u * SAMPLES,
                                      .count = SAMPLES,
                                      .point = u * SAMPLES / (24 * 24),
                                      .scale = 0x1p-10};
        work_result_t result;
        fault_t fault = {0};
        if (work_run(fixture.space, &record, &go, &result, &fault))
            fail_msg("%s", fault.text);
        for (uint32_t k = 1; k <= K; k++) {
            const work_moments_t *moments = &result.moments[work_samples_moment(k)];
            double balanced = 0;
            for (uint32_t s = 0; s <= k; s++)
                balanced += moments[1 + s].sum;
            sum[k] += moments->sum - balanced;
            squares[k] += (moments->sum - balanced) * (moments->sum - balanced);
            light[k] += balanced;
        }
    }
    for (uint32_t k = 1; k <= K; k++) {
        const double mean = sum[k] / UNITS, error = sqrt((squares[k] / UNITS - mean * mean) / (UNITS - 1));
        if (k > 2 ? !(fabs(sum[k]) < 1e-12 * light[k]) : !(fabs(mean) < 4.5 * error))
            fail_msg("length %u: %g +- %g off, of %g", k, mean, error, light[k] / UNITS);
        if (k <= 2) /* they do differ, and it would be seen if one technique had a tenth too much */
            assert_true(error > 1e-5 * light[k] / UNITS && error < 0.003 * light[k] / UNITS);
    }
}

/* Of any n passes in a row over a pixel as many go to a length as its rate says, give or take three: what
 * a net's discrepancy allows for an interval and n up to 64. */
static void cutoffs_are_spread_evenly(void **state)
{
    (void)state;
    static const double rates[] = {1, 0.8, 0.8, 0.5, 0.11, 0.0625};
    for (uint64_t pixel = 0; pixel < 200; pixel++)
        for (uint32_t n = 1; n <= 64; n++) {
            uint32_t reached[7] = {0};
            for (uint64_t pass = pixel; pass < pixel + n; pass++) {
                const net_t net = net_at(2385, 0, pixel, pass);
                double place = random_double(random_key(2385, RANDOM_PURPOSE_TEST, pass, pixel), 0);
                net_place_one(&net, 0, &place);
                reached[cutoff_length(rates, 6, place)]++;
            }
            for (uint32_t k = 6, sum = 0; k >= 1; k--) {
                sum += reached[k];
                if (!(fabs(sum - n * rates[k - 1]) < (k == 1 ? 1e-9 : 3)))
                    fail_msg("pixel %d: %u of %u samples go to length %u", (int)pixel, sum, n, k);
            }
        }
}

static void refuse(const work_record_t *record, work_space_t *of, const char *expected)
{
    work_result_t result;
    fault_t fault = {0};
    assert_int_equal(work_run(of, record, &go, &result, &fault), FAULT_RANGE);
    if (!strstr(fault.text, expected))
        fail_msg("\"%s\", expected \"%s\" in it", fault.text, expected);
}

static void caps_that_do_not_fit_are_refused(void **state)
{
    (void)state;
    double caps[K + 1] = {1, 1, 1, 1, 1, 1};
    work_record_t record = {.kind = WORK_SAMPLES, .count = 10, .scale = 1, .cap_count = K, .caps = caps};
    refuse(&record, fixture.space, "caps");
    record.cap_count = K + 1;
    refuse(&record, space, "caps");
    double rates[K + 1] = {1, 1, 1, 1, 1, 1};
    record.cap_count = K;
    record.rates = rates;
    record.rate_count = K + 1;
    refuse(&record, space, "rates");
}

/* The record as bytes and back; the caller clears. */
static fault_code_t there_and_back(const work_record_t *record, work_record_t *back, fault_t *fault)
{
    uint8_t *data;
    size_t size;
    assert_int_equal(work_record_encode(record, &data, &size, fault), FAULT_NONE);
    const fault_code_t code = work_record_decode(back, data, size, fault);
    free(data);
    return code;
}

static void records_keep_their_caps(void **state)
{
    (void)state;
    static const double values[] = {2.385, 0, INFINITY, -1, NAN};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        double caps[3] = {1, values[i], 1e300};
        const work_record_t record = {.kind = WORK_REFINE, .count = 10, .cap_count = 3, .caps = caps};
        work_record_t back;
        fault_t fault = {0};
        const fault_code_t code = there_and_back(&record, &back, &fault);
        if (values[i] >= 0) {
            assert_int_equal(code, FAULT_NONE);
            assert_int_equal(back.cap_count, 3);
            assert_memory_equal(back.caps, caps, sizeof caps);
        } else {
            assert_int_equal(code, FAULT_RANGE);
            assert_non_null(strstr(fault.text, "caps"));
        }
        work_record_clear(&back);
    }
}

static void records_keep_their_rates(void **state)
{
    (void)state;
    static const double values[][3] = {{1, 0.5, 0.5}, {1, 1, 1e-6},  {1, 0.5, 0.6}, {0.9, 0.5, 0.5},
                                       {1, 0.5, 0},   {1, NAN, 0.5}, {2, 1, 1}};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        double rates[3];
        memcpy(rates, values[i], sizeof rates);
        const work_record_t record = {
            .kind = WORK_SAMPLES, .count = 10, .scale = 1, .rate_count = 3, .rates = rates};
        work_record_t back;
        fault_t fault = {0};
        assert_int_equal(there_and_back(&record, &back, &fault), i < 2 ? FAULT_NONE : FAULT_RANGE);
        if (i < 2)
            assert_memory_equal(back.rates, rates, sizeof rates);
        else
            assert_non_null(strstr(fault.text, "rates"));
        work_record_clear(&back);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_parts_add_up),
        cmocka_unit_test(what_samples_leave_is_what_chains_follow),
        cmocka_unit_test(caps_that_do_not_fit_are_refused),
        cmocka_unit_test(records_keep_their_caps),
        cmocka_unit_test(samples_that_are_cut_off_are_unbiased),
        cmocka_unit_test(weights_of_the_image_leave_the_light),
        cmocka_unit_test(cutoffs_are_spread_evenly),
        cmocka_unit_test(records_keep_their_rates),
    };
    return cmocka_run_group_tests(tests, make, clear);
}
