/* Hostile records and results: as they come, and as edits of valid bytes. A record that decodes must survive a
 * round trip; a result that decodes must hold only what its record allows. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "chain/work_fixture.h"
#include "film/fuzz_edit.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static work_record_t records[WORK_KINDS];
static uint8_t *record_bytes[WORK_KINDS], *result_bytes[WORK_KINDS];
static size_t record_sizes[WORK_KINDS], result_sizes[WORK_KINDS];

static void prepare(void)
{
    static work_fixture_t fixture; /* records borrow its seeds: kept */
    work_fixture_make(&fixture, SMALL_LIGHT_AREA, SETTINGS_MMLT);
    for (work_kind_t kind = WORK_PILOT; kind < WORK_KINDS; kind++) {
        records[kind] = work_fixture_record(&fixture, kind);
        result_bytes[kind] = work_fixture_bytes(fixture.space, &records[kind], &result_sizes[kind]);
        if (work_record_encode(&records[kind], &record_bytes[kind], &record_sizes[kind], NULL))
            abort();
    }
}

static void try_record(const uint8_t *data, size_t size)
{
    work_record_t record;
    fault_t fault = {0};
    if (work_record_decode(&record, data, size, &fault) != FAULT_NONE) {
        if (fault.text[0] == '\0' || record.seeds)
            abort();
        return;
    }
    uint8_t *again;
    size_t again_size;
    if (record.kind == 0 || record.kind >= WORK_KINDS || record.count == 0 ||
        work_record_encode(&record, &again, &again_size, NULL) || again_size != size ||
        memcmp(again, data, size) != 0)
        abort();
    free(again);
    work_record_clear(&record);
}

static void try_result(work_kind_t kind, const uint8_t *data, size_t size)
{
    work_result_t result;
    fault_t fault = {0};
    if (work_result_decode(&result, &records[kind], 24, 24, WORK_FIXTURE_LENGTH, NULL, data, size, &fault) !=
        FAULT_NONE) {
        if (fault.text[0] == '\0' || result.moments || result.weights || result.features || result.film.sums)
            abort();
        return;
    }
    for (uint32_t i = 0; i < result.moment_count; i++)
        if (!(result.moments[i].n >= 0 && result.moments[i].sum >= 0 && isfinite(result.moments[i].sum2)))
            abort();
    for (uint32_t i = 0; i < result.weight_count; i++)
        if (!(result.weights[i] >= 0))
            abort();
    if (result.has_film && (result.film.width != 24 || result.film.height != 24))
        abort();
    work_result_clear(&result);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!record_bytes[WORK_PILOT])
        prepare();
    try_record(data, size);
    for (work_kind_t kind = WORK_PILOT; kind < WORK_KINDS; kind++) {
        try_result(kind, data, size);
        const size_t most = record_sizes[kind] > result_sizes[kind] ? record_sizes[kind] : result_sizes[kind];
        uint8_t *edited = malloc(most);
        memcpy(edited, record_bytes[kind], record_sizes[kind]);
        try_record(edited, fuzz_edit(edited, record_sizes[kind], data, size));
        memcpy(edited, result_bytes[kind], result_sizes[kind]);
        try_result(kind, edited, fuzz_edit(edited, result_sizes[kind], data, size));
        free(edited);
    }
    return 0;
}
