/* Units of work: their bytes, what of hostile bytes is refused, and that a result is a function of its record. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "chain/work_fixture.h"

static work_fixture_t fixture;
static const atomic_bool go = false;

static int make(void **state)
{
    (void)state;
    work_fixture_make(&fixture, SMALL_LIGHT_AREA, SETTINGS_MMLT);
    return 0;
}

static int clear(void **state)
{
    (void)state;
    work_fixture_clear(&fixture);
    return 0;
}

static void assert_fault(fault_code_t code, fault_code_t wanted, const fault_t *fault)
{
    if (code != wanted)
        fail_msg("fault %d (%s), expected %d", (int)code, fault->text, (int)wanted);
    assert_true(strlen(fault->text) > 10);
}

/* ---- records ---- */

static void records_come_back_as_they_were(void **state)
{
    (void)state;
    for (work_kind_t kind = WORK_PILOT; kind < WORK_KINDS; kind++) {
        const work_record_t record = work_fixture_record(&fixture, kind);
        work_record_t back;
        uint8_t *data;
        size_t size;
        fault_t fault = {0};
        assert_int_equal(work_record_encode(&record, &data, &size, &fault), FAULT_NONE);
        assert_true(size <= WORK_RECORD_MAX_BYTES);
        assert_int_equal(work_record_decode(&back, data, size, &fault), FAULT_NONE);
        assert_int_equal(back.kind, record.kind);
        assert_int_equal(back.length, record.length);
        assert_int_equal(back.first, record.first);
        assert_int_equal(back.count, record.count);
        assert_int_equal(back.skip, record.skip);
        assert_int_equal(back.side, record.side);
        assert_int_equal(back.mutations, record.mutations);
        assert_true(back.scale == record.scale);
        assert_int_equal(back.idle_count, record.idle_count);
        assert_true(record.idle_count == 0 ||
                    memcmp(back.idle, record.idle, sizeof *back.idle * back.idle_count) == 0);
        if (work_runs_chains(kind))
            assert_memory_equal(back.seeds, record.seeds, 8 * record.count);
        else
            assert_null(back.seeds);
        work_record_clear(&back);
        for (size_t cut = 0; cut <= size + 1; cut++) { /* and one octet too many */
            uint8_t *bytes = malloc(cut ? cut : 1);
            memcpy(bytes, data, cut < size ? cut : size);
            if (cut > size)
                bytes[size] = 0;
            if (cut != size) {
                assert_true(work_record_decode(&back, bytes, cut, &fault) != FAULT_NONE);
                assert_null(back.seeds);
            }
            free(bytes);
        }
        free(data);
    }
}

static void refuse_record(work_record_t record, fault_code_t code, const char *field)
{
    uint64_t *seeds = calloc(WORK_MAX_CHAINS + 1, sizeof *seeds);
    record.seeds = seeds;
    work_record_t back;
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    assert_int_equal(work_record_encode(&record, &data, &size, &fault), FAULT_NONE);
    assert_fault(work_record_decode(&back, data, size, &fault), code, &fault);
    if (!strstr(fault.text, field))
        fail_msg("\"%s\" does not name %s", fault.text, field);
    free(data);
    free(seeds);
}

static void hostile_records_are_refused(void **state)
{
    (void)state;
    const work_record_t pilot = work_fixture_record(&fixture, WORK_PILOT),
                        chains = work_fixture_record(&fixture, WORK_CHAINS),
                        samples = work_fixture_record(&fixture, WORK_SAMPLES),
                        features = work_fixture_record(&fixture, WORK_FEATURES);
    work_record_t r;
    refuse_record((r = pilot, r.kind = 0, r), FAULT_FORMAT, "kind");
    refuse_record((r = pilot, r.kind = WORK_KINDS, r), FAULT_FORMAT, "kind");
    refuse_record((r = pilot, r.kind = UINT32_MAX, r), FAULT_FORMAT, "kind");
    refuse_record((r = pilot, r.count = 0, r), FAULT_RANGE, "count");
    refuse_record((r = pilot, r.count = WORK_MAX_CANDIDATES + 1, r), FAULT_RANGE, "count");
    refuse_record((r = chains, r.count = WORK_MAX_CHAINS + 1, r.mutations = 1 << 20, r), FAULT_RANGE, "count");
    refuse_record((r = features, r.side = 0, r), FAULT_RANGE, "side");
    refuse_record((r = features, r.side = WORK_MAX_SIDE + 1, r), FAULT_RANGE, "side");
    refuse_record((r = samples, r.count = UINT64_MAX, r), FAULT_RANGE, "count");
    refuse_record((r = features, r.count = FILM_MAX_SIDE + 1, r), FAULT_RANGE, "count");
    refuse_record((r = samples, r.first = UINT64_MAX, r), FAULT_RANGE, "first");
    refuse_record((r = chains, r.length = 128, r), FAULT_RANGE, "length");
    refuse_record((r = pilot, r.length = 1, r), FAULT_RANGE, "length");
    refuse_record((r = pilot, r.kind = WORK_REFINE, r.length = 1, r), FAULT_RANGE, "length");
    refuse_record((r = pilot, r.kind = WORK_REFINE, r.count = UINT64_MAX, r), FAULT_RANGE, "count");
    refuse_record((r = samples, r.length = 1, r), FAULT_RANGE, "length");
    refuse_record((r = features, r.length = 1, r), FAULT_RANGE, "length");
    refuse_record((r = chains, r.mutations = 3, r), FAULT_RANGE, "mutations");
    refuse_record((r = chains, r.mutations = UINT64_MAX, r), FAULT_RANGE, "mutations");
    refuse_record((r = pilot, r.mutations = 1, r), FAULT_RANGE, "mutations");
    refuse_record((r = chains, r.steps = WORK_STEPS + 1, r), FAULT_RANGE, "steps");
    refuse_record((r = chains, r.steps = INT32_MIN, r), FAULT_RANGE, "steps");
    refuse_record((r = chains, r.large = 1, r), FAULT_RANGE, "large");
    refuse_record((r = chains, r.large = -WORK_STEPS - 1, r), FAULT_RANGE, "large");
    refuse_record((r = chains, r.kind = WORK_TRIAL, r.scale = 0, r), FAULT_RANGE, "scale");
    refuse_record((r = samples, r.scale = 0, r), FAULT_RANGE, "scale");
    refuse_record((r = samples, r.scale = -1, r), FAULT_RANGE, "scale");
    refuse_record((r = samples, r.scale = NAN, r), FAULT_RANGE, "scale");
    refuse_record((r = samples, r.scale = INFINITY, r), FAULT_RANGE, "scale");
    refuse_record((r = chains, r.scale = 1, r), FAULT_RANGE, "scale");
    refuse_record((r = samples, r.skip = WORK_MAX_SKIP + 1, r), FAULT_RANGE, "skip");
    refuse_record((r = samples, r.skip = UINT64_MAX, r), FAULT_RANGE, "skip");
    refuse_record((r = samples, r.sequence = WORK_SEQUENCES, r), FAULT_RANGE, "sequence");
    refuse_record((r = samples, r.point = WORK_MAX_POINT + 1, r), FAULT_RANGE, "point");
    refuse_record((r = samples, r.first = INT64_MAX - 7 * r.count + 1, r), FAULT_RANGE, "skip");
    target_idle_t idle[PATH_MAX_LENGTH + 1] = {{{1 << 1, 0}}, {{0, 0}}, {{1 << 3, 0}}};
    refuse_record((r = pilot, r.idle = idle, r.idle_count = PATH_MAX_LENGTH + 1, r), FAULT_FORMAT, "idle");
    refuse_record((r = chains, r.idle = idle, r.idle_count = 2, r), FAULT_FORMAT, "idle");
    idle[1].words[0] = 1 << 3; /* of length 2 */
    refuse_record((r = pilot, r.idle = idle, r.idle_count = 3, r), FAULT_RANGE, "idle");
    idle[1].words[0] = 0;
    idle[2].words[1] = 1;
    refuse_record((r = samples, r.idle = idle, r.idle_count = 3, r), FAULT_RANGE, "idle");
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    assert_int_equal(work_record_encode(&pilot, &data, &size, &fault), FAULT_NONE);
    data[0]++;
    assert_fault(work_record_decode(&r, data, size, &fault), FAULT_VERSION, &fault);
    free(data);
}

/* ---- results ---- */

static fault_code_t decode(work_result_t *result, const work_record_t *record, const uint8_t *data, size_t size,
                           fault_t *fault)
{
    return work_result_decode(result, record, fixture.settings.width ? fixture.settings.width : 24, 24,
                              WORK_FIXTURE_LENGTH, NULL, data, size, fault);
}

static void assert_same_arrays(const work_result_t *a, const work_result_t *b)
{
    assert_int_equal(a->moment_count, b->moment_count);
    if (a->moment_count)
        assert_memory_equal(a->moments, b->moments, sizeof *a->moments * a->moment_count);
    assert_int_equal(a->weight_count, b->weight_count);
    if (a->weight_count)
        assert_memory_equal(a->weights, b->weights, sizeof *a->weights * a->weight_count);
    assert_int_equal(a->has_film, b->has_film);
    if (a->has_film) {
        assert_memory_equal(a->film.sums, b->film.sums, (size_t)24 * 24 * FILM_CHANNELS * sizeof *a->film.sums);
        assert_memory_equal(&a->film.counts, &b->film.counts, sizeof a->film.counts);
    }
    assert_int_equal(a->feature_rows, b->feature_rows);
    if (a->feature_rows)
        assert_memory_equal(a->features, b->features,
                            sizeof(float) * WORK_FEATURE_CHANNELS * a->feature_rows * a->feature_width);
}

static void results_come_back_as_they_were(void **state)
{
    (void)state;
    for (work_kind_t kind = WORK_PILOT; kind < WORK_KINDS; kind++) {
        const work_record_t record = work_fixture_record(&fixture, kind);
        work_result_t result, back;
        uint8_t *data;
        size_t size;
        fault_t fault = {0};
        assert_int_equal(work_run(fixture.space, &record, &go, &result, &fault), FAULT_NONE);
        assert_true(result.stats.evaluations > 0 && result.stats.rays > 0);
        assert_true(result.stats.tracing_seconds >= 0 && result.stats.inversion_seconds >= 0);
        assert_true(result.stats.tracing_seconds + result.stats.inversion_seconds <=
                    result.stats.cpu_seconds * (1 + 1e-12));
        assert_int_equal(work_result_encode(&result, &data, &size, &fault), FAULT_NONE);
        if (decode(&back, &record, data, size, &fault))
            fail_msg("%s", fault.text);
        assert_int_equal(back.kind, kind);
        assert_int_equal(back.length, record.length);
        assert_memory_equal(&back.stats, &result.stats, sizeof back.stats);
        assert_same_arrays(&result, &back);
        work_result_clear(&back);
        for (size_t cut = 0; cut < size; cut++) {
            uint8_t *bytes = malloc(cut ? cut : 1);
            memcpy(bytes, data, cut);
            if (decode(&back, &record, bytes, cut, &fault) == FAULT_NONE)
                fail_msg("%zu of %zu octets of kind %d are accepted", cut, size, (int)kind);
            free(bytes);
        }
        data = realloc(data, size + 1);
        data[size] = 0;
        assert_true(decode(&back, &record, data, size + 1, &fault) != FAULT_NONE);
        free(data);
    }
}

/* A result of this kind with one thing changed. */
static void refuse_result(work_kind_t kind, void (*change)(work_result_t *), fault_code_t code, const char *field)
{
    const work_record_t record = work_fixture_record(&fixture, kind);
    work_result_t result, back;
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    assert_int_equal(work_run(fixture.space, &record, &go, &result, &fault), FAULT_NONE);
    change(&result);
    assert_int_equal(work_result_encode(&result, &data, &size, &fault), FAULT_NONE);
    assert_fault(decode(&back, &record, data, size, &fault), code, &fault);
    if (!strstr(fault.text, field))
        fail_msg("\"%s\" does not name %s", fault.text, field);
    assert_null(back.moments);
    assert_null(back.weights);
    assert_null(back.features);
    assert_null(back.film.sums);
    free(data);
}

#define CHANGE(name, statement)                                                                                    \
    static void name(work_result_t *r)                                                                             \
    {                                                                                                              \
        statement;                                                                                                 \
    }
CHANGE(change_kind, r->kind = r->kind == WORK_CHAINS ? WORK_SAMPLES : WORK_CHAINS)
CHANGE(change_length, r->length++)
CHANGE(change_spread_negative, r->spread = -1e-9)
CHANGE(change_spread_nan, r->spread = NAN)
CHANGE(change_cpu_nan, r->stats.cpu_seconds = NAN)
CHANGE(change_cpu_negative, r->stats.cpu_seconds = -1)
CHANGE(change_tracing_many, r->stats.tracing_seconds = r->stats.cpu_seconds + 1)
CHANGE(change_inversion_many, r->stats.inversion_seconds = r->stats.cpu_seconds - r->stats.tracing_seconds + 1)
CHANGE(change_waiting_nan, r->stats.waiting_seconds = NAN)
CHANGE(change_merging_negative, r->stats.merging_seconds = -1e-9)
CHANGE(change_accepted_nan, r->stats.accepted[1] = NAN)
CHANGE(change_accepted_negative, r->stats.accepted[0] = -1e-3)
CHANGE(change_accepted_many, r->stats.accepted[2] = (double)r->stats.proposed[2] * 1.01)
CHANGE(change_proposed_many, r->stats.proposed[1] = UINT64_MAX / 2)
CHANGE(change_moment_count, r->moment_count--)
CHANGE(change_n_nan, r->moments[0].n = NAN)
CHANGE(change_n_negative, r->moments[1].n = -1)
CHANGE(change_n_large, r->moments[0].n += 1)
CHANGE(change_sum_negative, r->moments[0].sum = -1e-9)
CHANGE(change_sum_infinite, r->moments[1].sum = INFINITY)
CHANGE(change_sum2_negative, r->moments[0].sum2 = -1)
CHANGE(change_sum2_nan, r->moments[0].sum2 = NAN)
CHANGE(change_weight_negative, r->weights[17] = -1e-300)
CHANGE(change_weight_nan, r->weights[0] = NAN)
CHANGE(change_weight_infinite, r->weights[299] = INFINITY)
CHANGE(change_weight_count, r->weight_count--)
CHANGE(change_feature_nan, r->features[33] = NAN)
CHANGE(change_feature_rows, r->feature_rows--)
CHANGE(change_film_size, (r->film.height--, r->film.width--))

static void hostile_results_are_refused(void **state)
{
    (void)state;
    for (work_kind_t kind = WORK_PILOT; kind < WORK_KINDS; kind++) {
        refuse_result(kind, change_length, FAULT_FORMAT, "length");
        refuse_result(kind, change_cpu_nan, FAULT_RANGE, "cpu_seconds");
        refuse_result(kind, change_cpu_negative, FAULT_RANGE, "cpu_seconds");
        refuse_result(kind, change_tracing_many, FAULT_RANGE, "tracing_seconds");
        refuse_result(kind, change_inversion_many, FAULT_RANGE, "inversion_seconds");
        refuse_result(kind, change_waiting_nan, FAULT_RANGE, "waiting_seconds");
        refuse_result(kind, change_merging_negative, FAULT_RANGE, "merging_seconds");
        refuse_result(kind, change_accepted_nan, FAULT_RANGE, "accepted");
        refuse_result(kind, change_accepted_negative, FAULT_RANGE, "accepted");
        if (kind == WORK_FEATURES)
            continue;
        refuse_result(kind, change_moment_count, FAULT_FORMAT, "moment_count");
        refuse_result(kind, change_n_nan, FAULT_RANGE, "moments");
        refuse_result(kind, change_n_negative, FAULT_RANGE, "moments");
        refuse_result(kind, change_n_large, FAULT_RANGE, "moments");
        refuse_result(kind, change_sum_negative, FAULT_RANGE, "moments");
        refuse_result(kind, change_sum_infinite, FAULT_RANGE, "moments");
        refuse_result(kind, change_sum2_negative, FAULT_RANGE, "moments");
        refuse_result(kind, change_sum2_nan, FAULT_RANGE, "moments");
        if (kind == WORK_PILOT || kind == WORK_REFINE || kind == WORK_TRIAL || kind == WORK_LEFT_OUT)
            continue;
        refuse_result(kind, change_kind, FAULT_FORMAT, "kind");
        refuse_result(kind, change_film_size, FAULT_FORMAT, "film");
    }
    refuse_result(WORK_TRIAL, change_spread_negative, FAULT_RANGE, "spread");
    refuse_result(WORK_TRIAL, change_spread_nan, FAULT_RANGE, "spread");
    refuse_result(WORK_CHAINS, change_accepted_many, FAULT_RANGE, "accepted");
    refuse_result(WORK_CHAINS, change_proposed_many, FAULT_RANGE, "proposed");
    refuse_result(WORK_PILOT, change_weight_negative, FAULT_RANGE, "weight");
    refuse_result(WORK_PILOT, change_weight_nan, FAULT_RANGE, "weight");
    refuse_result(WORK_PILOT, change_weight_infinite, FAULT_RANGE, "weight");
    refuse_result(WORK_PILOT, change_weight_count, FAULT_FORMAT, "body");
    refuse_result(WORK_FEATURES, change_feature_nan, FAULT_RANGE, "feature");
    refuse_result(WORK_FEATURES, change_feature_rows, FAULT_FORMAT, "body");
}

/* ---- running ---- */

static void assert_same_bytes(uint8_t *a, size_t a_size, uint8_t *b, size_t b_size)
{
    assert_int_equal(a_size, b_size);
    assert_memory_equal(a, b, a_size);
    free(a);
    free(b);
}

static void results_are_functions_of_their_record(void **state)
{
    (void)state;
    static const small_light_t lights[] = {SMALL_LIGHT_AREA, SMALL_LIGHT_CONSTANT, SMALL_LIGHT_POINT};
    for (size_t l = 0; l < sizeof lights / sizeof *lights; l++) {
        work_fixture_t f;
        work_space_t *other;
        fault_t fault = {0};
        work_fixture_make(&f, lights[l], SETTINGS_MMLT);
        assert_int_equal(work_space_new(&other, f.renderer, &fault), FAULT_NONE);
        for (work_kind_t kind = WORK_PILOT; kind < WORK_KINDS; kind++) {
            const work_record_t record = work_fixture_record(&f, kind);
            size_t sizes[3], size;
            uint8_t *bytes[3];
            bytes[0] = work_fixture_bytes(f.space, &record, &sizes[0]);
            bytes[1] = work_fixture_bytes(f.space, &record, &sizes[1]); /* again */
            for (work_kind_t before = WORK_PILOT; before < WORK_KINDS; before++) {
                work_record_t more = work_fixture_record(&f, before);
                more.first++;
                free(work_fixture_bytes(other, &more, &size)); /* other work first */
            }
            bytes[2] = work_fixture_bytes(other, &record, &sizes[2]);
            assert_int_equal(sizes[1], sizes[0]);
            assert_memory_equal(bytes[1], bytes[0], sizes[0]);
            assert_same_bytes(bytes[2], sizes[2], bytes[0], sizes[0]);
            free(bytes[1]);
        }
        work_space_destroy(&other);
        work_fixture_clear(&f);
    }
}

/* The same work in one unit and in parts: films, weights and rows are the same bits. */
static void splitting_a_unit_changes_nothing(void **state)
{
    (void)state;
    for (work_kind_t kind = WORK_PILOT; kind < WORK_TRIAL; kind++) {
        const work_record_t whole = work_fixture_record(&fixture, kind);
        work_result_t all, part;
        work_space_t *other;
        fault_t fault = {0};
        film_t sum;
        assert_int_equal(film_init(&sum, 24, 24, &fault), FAULT_NONE);
        assert_int_equal(work_space_new(&other, fixture.renderer, &fault), FAULT_NONE);
        assert_int_equal(work_run(fixture.space, &whole, &go, &all, &fault), FAULT_NONE);
        const uint64_t cut = kind == WORK_CHAINS ? 1 : whole.count / 3;
        for (int i = 0; i < 2; i++) {
            const uint64_t begin = i ? cut : 0, count = i ? whole.count - cut : cut;
            work_record_t record = whole;
            record.first += begin * (whole.skip + 1);
            record.count = count;
            if (kind == WORK_SAMPLES)
                record.point += record.first / (24 * 24) - whole.first / (24 * 24);
            record.mutations = whole.mutations / whole.count * count;
            record.seeds += kind == WORK_CHAINS ? begin : 0;
            assert_int_equal(work_run(other, &record, &go, &part, &fault), FAULT_NONE);
            if (part.has_film)
                film_add(&sum, &part.film);
            if (kind == WORK_PILOT)
                assert_memory_equal(part.weights, all.weights + begin * WORK_FIXTURE_LENGTH,
                                    sizeof(double) * WORK_FIXTURE_LENGTH * count);
            if (kind == WORK_FEATURES)
                assert_memory_equal(part.features, all.features + begin * 24 * WORK_FEATURE_CHANNELS,
                                    sizeof(float) * 24 * WORK_FEATURE_CHANNELS * count);
        }
        if (all.has_film) {
            assert_memory_equal(sum.sums, all.film.sums, sizeof *sum.sums * 24 * 24 * FILM_CHANNELS);
            assert_memory_equal(&sum.counts, &all.film.counts, sizeof sum.counts);
        }
        work_space_destroy(&other);
        film_clear(&sum);
    }
}

static double film_weight(const film_t *film)
{
    double weight = 0;
    for (uint32_t y = 0; y < film->height; y++)
        for (uint32_t x = 0; x < film->width; x++)
            weight += rgb_luminance(film_value(film, x, y));
    return weight;
}

/* Each mutation adds a state of luminance 1 in all. Each of its up to two splats is rounded to 2^-28 in each
 * channel. */
static void chains_weigh_as_much_as_their_mutations(void **state)
{
    (void)state;
    for (int light = SMALL_LIGHT_AREA; light <= SMALL_LIGHT_DISTANT; light++) {
        work_fixture_t f;
        work_result_t result;
        fault_t fault = {0};
        work_fixture_make(&f, (small_light_t)light, SETTINGS_MMLT);
        work_record_t record = work_fixture_record(&f, WORK_CHAINS);
        record.count = 7; /* does not divide the mutations */
        record.mutations = 5003;
        assert_int_equal(work_run(f.space, &record, &go, &result, &fault), FAULT_NONE);
        const double weight = film_weight(&result.film), rounding = (double)result.film.counts.splats / FILM_ONE;
        if (!(fabs(weight - 5003) <= rounding))
            fail_msg("light %d: weight %.9f, expected 5003 +- %g", light, weight, rounding);
        assert_int_equal(result.film.counts.outside + result.film.counts.nonfinite + result.film.counts.negative,
                         0);
        uint64_t proposed = 0;
        for (int i = 0; i < WORK_MOVES; i++)
            proposed += result.stats.proposed[i];
        assert_int_equal(proposed, 5003);
        assert_int_equal(result.stats.evaluations, 5003);
        assert_true(result.stats.longest_stay < 5003 / 7 + 2);
        work_fixture_clear(&f);
    }
}

/* Candidates of length 2 that carry light. */
static void find_seeds(work_space_t *space, uint64_t *seeds, uint32_t count)
{
    const work_record_t pilot = {.kind = WORK_PILOT, .count = 1000};
    work_result_t result;
    fault_t fault = {0};
    assert_int_equal(work_run(space, &pilot, &go, &result, &fault), FAULT_NONE);
    for (uint32_t i = 0; count > 0; i++) {
        assert_true(i < 1000);
        if (work_fixture_weight(&result, i, 2) > 0)
            seeds[--count] = i;
    }
}

/* With a filter wider than a pixel some of it falls into the margin around the image, and nothing else is lost: the
 * weights of a triangle of radius 1 add up to one everywhere. In a furnace chains visit the whole film evenly; of
 * its 25 x 25 pixels with the margin 1 - 24^2/25^2 = 0.078 land outside. (Chain states are correlated: within a
 * third of it. A small step moves at most 1/64 of the film, a large one everywhere, 0.3 of the time: each is worth
 * at least a tenth of an independent one, so the standard deviation is below sqrt(10 * 0.078 / 20000) = 0.0063, the
 * third four of them; measured far less.) */
static void a_filter_loses_only_its_margin(void **state)
{
    (void)state;
    small_scene_t furnace;
    work_result_t result;
    renderer_t *renderer;
    work_space_t *space;
    fault_t fault = {0};
    settings_t settings = fixture.settings;
    uint64_t seeds[20];
    settings.filter = SCENE_FILTER_TRIANGLE;
    small_scene_furnace(&furnace, 0.5, 1);
    assert_int_equal(renderer_new(&renderer, &furnace.scene, &settings, &fault), FAULT_NONE);
    assert_int_equal(work_space_new(&space, renderer, &fault), FAULT_NONE);
    find_seeds(space, seeds, 20);
    const work_record_t record = {
        .kind = WORK_CHAINS, .length = 2, .count = 20, .mutations = 20000, .seeds = seeds};
    assert_int_equal(work_run(space, &record, &go, &result, &fault), FAULT_NONE);
    const double share = film_weight(&result.film) / 20000, inside = 24.0 * 24 / (25 * 25);
    assert_true(result.film.counts.outside > 0);
    if (!(fabs(share - inside) < (1 - inside) / 3))
        fail_msg("%g of the weight is inside, expected %g", share, inside);
    work_space_destroy(&space);
    renderer_destroy(&renderer);
    small_scene_clear(&furnace);
}

static void cancelling_stops_and_spoils_nothing(void **state)
{
    (void)state;
    const atomic_bool stop = true;
    for (work_kind_t kind = WORK_PILOT; kind < WORK_KINDS; kind++) {
        const work_record_t record = work_fixture_record(&fixture, kind);
        work_result_t result;
        fault_t fault = {0};
        size_t before_size, after_size;
        uint8_t *before = work_fixture_bytes(fixture.space, &record, &before_size);
        assert_fault(work_run(fixture.space, &record, &stop, &result, &fault), FAULT_CANCELLED,
                     &(fault_t){0, "cancelled it is"});
        uint8_t *after = work_fixture_bytes(fixture.space, &record, &after_size);
        assert_same_bytes(after, after_size, before, before_size);
    }
}

static void refuse_run(work_fixture_t *f, work_record_t record, const char *words)
{
    work_result_t result;
    fault_t fault = {0};
    assert_fault(work_run(f->space, &record, &go, &result, &fault), FAULT_RANGE, &fault);
    if (!strstr(fault.text, words))
        fail_msg("\"%s\" does not say \"%s\"", fault.text, words);
}

static void records_that_do_not_fit_the_scene_are_refused(void **state)
{
    (void)state;
    const work_record_t pilot = work_fixture_record(&fixture, WORK_PILOT),
                        chains = work_fixture_record(&fixture, WORK_CHAINS),
                        features = work_fixture_record(&fixture, WORK_FEATURES);
    work_record_t r;
    refuse_run(&fixture, (r = pilot, r.kind = 0, r), "kind");
    refuse_run(&fixture, (r = pilot, r.kind = WORK_KINDS, r), "kind");
    refuse_run(&fixture, (r = chains, r.length = 0, r), "length 0");
    target_idle_t idle[WORK_FIXTURE_LENGTH] = {{{0, 0}}};
    refuse_run(&fixture, (r = pilot, r.idle = idle, r.idle_count = 2, r), "techniques of 2 lengths");
    idle[0].words[0] = 15; /* all of length 3 */
    refuse_run(&fixture, (r = chains, r.idle = idle, r.idle_count = 1, r), "without a technique for length 3");
    refuse_run(&fixture, (r = chains, r.length = WORK_FIXTURE_LENGTH + 1, r), "1 to 5");
    refuse_run(&fixture, (r = features, r.first = 24, r), "rows 24");
    refuse_run(&fixture, (r = features, r.first = 20, r), "rows 20 to 25");
    refuse_run(&fixture, (r = features, r.count = UINT64_MAX, r), "rows");
    uint64_t dark = 0; /* a candidate without light: most have none */
    const work_record_t candidates = {.kind = WORK_PILOT, .count = 1000};
    work_result_t result;
    fault_t fault = {0};
    assert_int_equal(work_run(fixture.space, &candidates, &go, &result, &fault), FAULT_NONE);
    while (work_fixture_weight(&result, (uint32_t)dark, 3) > 0)
        dark++;
    refuse_run(&fixture, (r = chains, r.count = 1, r.seeds = &dark, r), "carries no light");
    work_fixture_t point;
    work_fixture_make(&point, SMALL_LIGHT_POINT, SETTINGS_MMLT);
    refuse_run(&point, (r = chains, r.length = 1, r.seeds = point.seeds, r), "no technique");
    work_fixture_clear(&point);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(records_come_back_as_they_were),
        cmocka_unit_test(hostile_records_are_refused),
        cmocka_unit_test(results_come_back_as_they_were),
        cmocka_unit_test(hostile_results_are_refused),
        cmocka_unit_test(results_are_functions_of_their_record),
        cmocka_unit_test(splitting_a_unit_changes_nothing),
        cmocka_unit_test(chains_weigh_as_much_as_their_mutations),
        cmocka_unit_test(a_filter_loses_only_its_margin),
        cmocka_unit_test(cancelling_stops_and_spoils_nothing),
        cmocka_unit_test(records_that_do_not_fit_the_scene_are_refused),
    };
    return cmocka_run_group_tests(tests, make, clear);
}
