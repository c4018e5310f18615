/* work_fixture.h: a small scene with its renderer and work spaces, and records that fit it; for tests of units of
 * work. What fails on the way ends the process with its message. */
#ifndef TESTS_CHAIN_WORK_FIXTURE_H
#define TESTS_CHAIN_WORK_FIXTURE_H

#include "chain/work.h"
#include "support/small_scenes.h"

enum { WORK_FIXTURE_LENGTH = 5, WORK_FIXTURE_SEEDS = 64, WORK_FIXTURE_PILOT = 4096 };

typedef struct work_fixture {
    small_scene_t small;
    settings_t settings;
    renderer_t *renderer;
    work_space_t *space;
    uint64_t seeds[WORK_FIXTURE_SEEDS]; /* candidates of length 3 that carry light */
} work_fixture_t;

/* The box under this light, 24 x 24 pixels, lengths to 5. */
void work_fixture_make(work_fixture_t *fixture, small_light_t light, settings_algorithm_t algorithm);
void work_fixture_clear(work_fixture_t *fixture);

/* The weight for a length of a pilot's candidate. */
double work_fixture_weight(const work_result_t *pilot, uint32_t candidate, uint32_t length);

/* A record of this kind that fits: samples of every kind, chains of length 3 or of all, some feature rows. Seeds
 * are borrowed from the fixture: not to be cleared. */
work_record_t work_fixture_record(work_fixture_t *fixture, work_kind_t kind);

/* Runs and encodes, with no time in it; the caller frees. */
uint8_t *work_fixture_bytes(work_space_t *space, const work_record_t *record, size_t *size);

#endif
