#include "chain/work_fixture.h"

#include <stdio.h>
#include <stdlib.h>

static void demand(fault_code_t code, const fault_t *fault)
{
    if (code == FAULT_NONE)
        return;
    fprintf(stderr, "a test's unit of work failed: %s\n", fault->text);
    abort();
}

double work_fixture_weight(const work_result_t *pilot, uint32_t candidate, uint32_t length)
{
    return pilot->weights[candidate * WORK_FIXTURE_LENGTH + length - 1];
}

static void find_seeds(work_fixture_t *fixture)
{
    const work_record_t pilot = {.kind = WORK_PILOT, .count = WORK_FIXTURE_PILOT};
    const atomic_bool cancel = false;
    work_result_t result;
    fault_t fault = {0};
    demand(work_run(fixture->space, &pilot, &cancel, &result, &fault), &fault);
    int found = 0;
    for (uint32_t i = 0; i < WORK_FIXTURE_PILOT && found < WORK_FIXTURE_SEEDS; i++)
        if (work_fixture_weight(&result, i, 3) > 0)
            fixture->seeds[found++] = i;
    if (found < WORK_FIXTURE_SEEDS)
        abort();
}

void work_fixture_make(work_fixture_t *fixture, small_light_t light, settings_algorithm_t algorithm)
{
    fault_t fault = {0};
    *fixture = (work_fixture_t){.renderer = NULL};
    small_scene_box(&fixture->small, light);
    settings_default(&fixture->settings);
    fixture->settings.algorithm = algorithm;
    fixture->settings.max_path_length = WORK_FIXTURE_LENGTH;
    fixture->settings.seed = 2385;
    demand(renderer_new(&fixture->renderer, &fixture->small.scene, &fixture->settings, &fault), &fault);
    demand(work_space_new(&fixture->space, fixture->renderer, &fault), &fault);
    find_seeds(fixture);
}

void work_fixture_clear(work_fixture_t *fixture)
{
    work_space_destroy(&fixture->space);
    renderer_destroy(&fixture->renderer);
    small_scene_clear(&fixture->small);
}

work_record_t work_fixture_record(work_fixture_t *fixture, work_kind_t kind)
{
    static target_idle_t idle[WORK_FIXTURE_LENGTH] = {[4] = {{1 << 3, 0}}}; /* s = 3 of length 5 */
    switch (kind) {
    case WORK_REFINE:
        return (work_record_t){
            .kind = kind, .first = 100, .count = 300, .idle_count = WORK_FIXTURE_LENGTH, .idle = idle};
    case WORK_PILOT:
    case WORK_LEFT_OUT:
        return (work_record_t){.kind = kind, .first = 100, .count = 300};
    case WORK_CHAINS:
    case WORK_TRIAL:
        return (work_record_t){.kind = kind,
                               .length = settings_joins_all(fixture->settings.algorithm) ? 0 : 3,
                               .first = 7,
                               .count = 4,
                               .mutations = 4000,
                               .scale = kind == WORK_TRIAL ? 0.3 : 0,
                               .seeds = fixture->seeds};
    case WORK_SAMPLES:
        return (work_record_t){
            .kind = kind, .first = 1000, .count = 2000, .skip = 6, .sequence = 3, .point = 70, .scale = 0.5};
    default:
        return (work_record_t){.kind = kind, .first = 3, .count = 5, .side = 2};
    }
}

uint8_t *work_fixture_bytes(work_space_t *space, const work_record_t *record, size_t *size)
{
    const atomic_bool cancel = false;
    work_result_t result;
    fault_t fault = {0};
    uint8_t *data = NULL;
    demand(work_run(space, record, &cancel, &result, &fault), &fault);
    result.stats.cpu_seconds = result.stats.tracing_seconds = result.stats.inversion_seconds = 0;
    demand(work_result_encode(&result, &data, size, &fault), &fault);
    return data;
}
