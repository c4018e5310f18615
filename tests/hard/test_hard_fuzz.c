/* Random scenes at the limits of what is allowed: pilot, chains and samples run on each; nothing non-finite or
 * negative comes out, what is refused inside is counted by cause. Run under the sanitizers too. */
#include "hard.h"

#include <math.h>
#include <stdlib.h>

#include "base/random.h"
#include "chain/work.h"
#include "random_scene.h"

enum { SCENES = 200, LENGTHS = 6, CANDIDATES = 160, MUTATIONS = 500, SAMPLES = 160 };

typedef struct tally {
    uint64_t dark, limited, rendered, lit; /* limited: a mixture of too many lobes */
    uint64_t evaluations, rejects[WORK_REJECTS], splats, outside, saturated;
} tally_t;

static const atomic_bool never = false;

/* Everything that leaves a unit is finite; what does not enter the film says why. */
static void check_result(tally_t *tally, uint64_t index, const work_result_t *result)
{
    tally->evaluations += result->stats.evaluations;
    for (int i = 0; i < WORK_REJECTS; i++)
        tally->rejects[i] += result->stats.rejects[i];
    for (uint32_t i = 0; i < result->moment_count; i++)
        if (!(result->moments[i].sum >= 0 && result->moments[i].sum <= 1e300))
            fail_msg("scene %llu, kind %u, length %u: moment %u is %g, %g", (unsigned long long)index, result->kind,
                     result->length, i, result->moments[i].sum, result->moments[i].sum2);
    for (uint32_t i = 0; i < result->weight_count; i++)
        if (!(result->weights[i] >= 0 && result->weights[i] <= 1e300))
            fail_msg("scene %llu, length %u: weight %u is %g", (unsigned long long)index, result->length, i,
                     result->weights[i]);
    if (!result->has_film)
        return;
    const film_counts_t *counts = &result->film.counts;
    if (counts->nonfinite != 0 || counts->negative != 0)
        fail_msg("scene %llu: the film met %llu non-finite and %llu negative values", (unsigned long long)index,
                 (unsigned long long)counts->nonfinite, (unsigned long long)counts->negative);
    tally->splats += counts->splats;
    tally->outside += counts->outside;
    tally->saturated += counts->saturated;
    for (size_t i = 0; i < (size_t)FILM_CHANNELS * result->film.width * result->film.height; i++)
        assert_true(result->film.sums[i] >= 0);
    fault_t fault = {0};
    uint8_t *data;
    size_t size;
    if (work_result_encode(result, &data, &size, &fault))
        fail_msg("scene %llu: %s", (unsigned long long)index, fault.text);
    free(data);
}

static void run(tally_t *tally, uint64_t index, work_space_t *space, const work_record_t *record,
                work_result_t *result)
{
    fault_t fault = {0};
    if (work_run(space, record, &never, result, &fault))
        fail_msg("scene %llu, kind %u, length %u: %s", (unsigned long long)index, record->kind, record->length,
                 fault.text);
    check_result(tally, index, result);
}

/* A pilot, then chains of each length, or of all at once, from every lit candidate. Returns the sum of b_k. */
static double run_chains(tally_t *tally, uint64_t index, work_space_t *space, settings_algorithm_t algorithm)
{
    work_result_t result;
    uint64_t seeds[LENGTHS + 1][CANDIDATES], counts[LENGTHS + 1] = {0};
    double b = 0;
    run(tally, index, space, &(work_record_t){.kind = WORK_PILOT, .count = CANDIDATES}, &result);
    assert_int_equal(result.weight_count, work_pilot_weights(CANDIDATES, LENGTHS));
    const bool all = settings_joins_all(algorithm);
    for (uint32_t i = 0; i < CANDIDATES; i++) {
        double sum = 0;
        for (uint32_t k = 1; k <= LENGTHS; k++) {
            const double weight = result.weights[i * LENGTHS + k - 1];
            sum += weight;
            if (weight > 0 && !all)
                seeds[k][counts[k]++] = i;
        }
        b += sum / CANDIDATES;
        if (sum > 0 && all)
            seeds[0][counts[0]++] = i;
    }
    for (uint32_t k = all ? 0 : 1; k <= (all ? 0 : LENGTHS); k++) {
        tally->lit += counts[k];
        double shares[LENGTHS + 1], importance[IMPORTANCE_BLOCKS];
        for (int i = 0; i < IMPORTANCE_BLOCKS; i++)
            importance[i] = exp2(i % 21 - 10);
        for (uint32_t s = 0; s <= k; s++)
            shares[s] = 1.0 / (k + 1);
        const work_record_t record = {.kind = WORK_CHAINS,
                                      .length = k,
                                      .count = counts[k],
                                      .mutations = MUTATIONS,
                                      .seeds = seeds[k],
                                      .shares = settings_wants_shares(algorithm) ? shares : NULL,
                                      .importance = index & 32 ? importance : NULL};
        if (counts[k] > 0)
            run(tally, index, space, &record, &result);
    }
    return b;
}

/* Any wild scene of five is larger or smaller than single precision's products carry: there hits go wrong, and the
 * paths are refused. */
static bool is_wild(uint64_t index)
{
    return index % 5 == 4;
}

static void run_scene(tally_t *tally, uint64_t index)
{
    scene_builder_t *builder = random_scene_new(random_key(51, RANDOM_PURPOSE_TEST, 0, index), is_wild(index));
    const scene_t scene = scene_builder_view(builder);
    fault_t fault = {0};
    settings_t settings;
    settings_default(&settings);
    settings.algorithm = SETTINGS_MMLT + index % (SETTINGS_ALGORITHMS - SETTINGS_MMLT);
    const bool all = settings_joins_all(settings.algorithm);
    settings.equalize = index & 32 ? 1 : 0;
    settings.partial_step = index & 4 && !all ? 0.4 : 0;
    settings.failures = index & 8 && settings.algorithm != SETTINGS_CMLT_IPSM && !all ? SETTINGS_FAILURES_DELAYED
                                                                                      : SETTINGS_FAILURES_PLAIN;
    settings.auxiliary_step = index & 16 && settings.algorithm <= SETTINGS_CMLT ? 0.1 : 0;
    settings.max_path_length = LENGTHS;
    settings.target = index & 1 ? SETTINGS_TARGET_MAXIMUM : SETTINGS_TARGET_LUMINANCE;
    settings.kernel = index & 2 ? SETTINGS_KERNEL_GAUSSIAN : SETTINGS_KERNEL_KELEMEN;
    renderer_t *renderer = NULL;
    work_space_t *space = NULL;
    const fault_code_t code = renderer_new(&renderer, &scene, &settings, &fault);
    if (code == FAULT_NO_LIGHT || code == FAULT_LIMIT) {
        ++*(code == FAULT_LIMIT ? &tally->limited : &tally->dark);
    } else if (code != FAULT_NONE || work_space_new(&space, renderer, &fault)) {
        fail_msg("scene %llu: %s", (unsigned long long)index, fault.text);
    } else {
        work_result_t result;
        const double b = run_chains(tally, index, space, settings.algorithm);
        run(tally, index, space,
            &(work_record_t){.kind = WORK_SAMPLES, .count = SAMPLES, .scale = b > 0 ? exp2(-rint(log2(b))) : 1},
            &result);
        tally->rendered++;
    }
    work_space_destroy(&space);
    renderer_destroy(&renderer);
    scene_builder_destroy(&builder);
}

static void print_tally(const char *name, const tally_t *t)
{
    typedef unsigned long long wide_t;
    print_message(
        "%s: %llu rendered, %llu without light, %llu refused; %llu lit candidates, %llu evaluations; refused: %llu "
        "rays, %llu weights, %llu values, %llu negative; film: %llu splats, %llu outside, %llu saturated\n",
        name, (wide_t)t->rendered, (wide_t)t->dark, (wide_t)t->limited, (wide_t)t->lit, (wide_t)t->evaluations,
        (wide_t)t->rejects[0], (wide_t)t->rejects[1], (wide_t)t->rejects[2], (wide_t)t->rejects[3],
        (wide_t)t->splats, (wide_t)t->outside, (wide_t)t->saturated);
    hard_record(HARD_REFUSED, (double)t->evaluations,
                (double)(t->rejects[0] + t->rejects[1] + t->rejects[2] + t->rejects[3]));
}

static void random_scenes(void **state)
{
    (void)state;
    hard_case("random");
    tally_t usual = {0}, wild = {0};
    for (uint64_t i = 0; i < SCENES; i++)
        run_scene(is_wild(i) ? &wild : &usual, i);
    print_tally("sizes 1e-6 to 1e6", &usual);
    hard_case("random, wild");
    print_tally("sizes 1e-20 to 1e12", &wild);
    assert_true(usual.rendered + wild.rendered >= SCENES * 3 / 4);
    assert_true(usual.lit >= 10 * SCENES);
    for (int i = 0; i < WORK_REJECTS; i++)
        assert_true(usual.rejects[i] <= 1e-5 * usual.evaluations);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_scenes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
