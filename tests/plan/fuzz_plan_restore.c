/* Hostile checkpoints: as they come, another job's, and edits of valid ones, during the pilot and after it. A plan
 * that comes back must go on: hand out its units, show its image, report and save itself. */
#include <stdlib.h>
#include <string.h>

#include "film/fuzz_edit.h"
#include "plan/plan_fixture.h"
#include "plan/plan_state.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { SAVES = 16, ERAS = 13, SHORTER = 15 };

static small_scene_t small;
static job_t jobs[SAVES];
static uint8_t *saves[SAVES];
static size_t save_sizes[SAVES];

/* Chains, samples, chains of all lengths, chains with samples beside them, a job that leaves out something, a
 * survey of techniques, one whose shares shift with results that wait, one whose chains are shorter than usual,
 * each in the middle of the pilot and of the rendering; 4 x 3 pixels, lengths to 2. */
static void prepare(void)
{
    static const char *const texts[SAVES / 2] = {
        "{'scene':'x','algorithm':'mmlt','max_path_length':2,'film':{'width':4,'"
        "height':3},'stop':{'mutations_per_pixel':20},"
        "'chains':{'pilot_samples':500}}",
        "{'scene':'x','algorithm':'bdpt','max_path_length':2,'film':{'width':4,'"
        "height':3},'stop':{'mutations_per_pixel':20},"
        "'chains':{'pilot_samples':500}}",
        "{'scene':'x','algorithm':'pssmlt','max_path_length':2,'film':{'width':4,'"
        "height':3},'stop':{'mutations_per_pixel':20},"
        "'chains':{'pilot_samples':500}}",
        "{'scene':'x','algorithm':'auto','max_path_length':2,'film':{'width':4,'"
        "height':3},'stop':{'mutations_per_pixel':60},"
        "'chains':{'pilot_samples':500}}",
        "{'scene':'x','algorithm':'mmlt','max_path_length':3,'film':{'width':4,'"
        "height':3},'stop':{'mutations_per_pixel':20},'effects':{'indirect':'off'},"
        "'chains':{'pilot_samples':500}}",
        "{'scene':'x','algorithm':'mmlt','max_path_length':2,'film':{'width':4,'"
        "height':3},'stop':{'mutations_per_pixel':20},"
        "'chains':{'pilot_samples':65536}}",
        "{'scene':'x','algorithm':'mmlt','max_path_length':2,'film':{'width':4,'"
        "height':3},'stop':{'mutations_per_pixel':800},"
        "'chains':{'pilot_samples':500,'shift':true,'length':32}}",
        "{'scene':'x','algorithm':'mmlt','max_path_length':2,'film':{'width':4,'"
        "height':3},'stop':{'mutations_per_pixel':8000},"
        "'chains':{'pilot_samples':500}}"};
    small_scene_diffuse(&small);
    for (int i = 0; i < SAVES; i++) {
        plan_worker_t worker;
        fault_t fault = {0};
        jobs[i] = plan_fixture_job(texts[i / 2]);
        plan_worker_make(&worker, &jobs[i], &small.scene);
        plan_t *plan = plan_fixture_new(&jobs[i], &small.scene);
        for (int step = 0; step < (i % 2 ? 10 : 2); step++)
            plan_fixture_step(plan, &worker);
        uint64_t unit;
        const work_record_t *record;
        plan_next(plan, &unit, &record); /* and one is out */
        for (int step = 0; i == ERAS && step < 20; step++)
            plan_fixture_step(plan, &worker);
        if ((i == ERAS) != (plan->eras.pending.count > 0))
            abort();
        json_t *shorter = plan_shorten_json(plan);
        if (i == SHORTER && json_size(shorter) == 0)
            abort();
        json_destroy(&shorter);
        if (plan_save(plan, &saves[i], &save_sizes[i], &fault))
            abort();
        plan_destroy(&plan);
        plan_worker_clear(&worker);
    }
}

static void go_on(plan_t *plan)
{
    uint64_t unit;
    const work_record_t *record;
    plan_progress_t progress;
    image_t image;
    uint8_t *data;
    size_t size;
    for (int i = 0; i < 100 && plan_next(plan, &unit, &record); i++)
        if (record->count == 0 || record->kind >= WORK_KINDS)
            abort();
    plan_check_stop(plan, 1);
    plan_progress(plan, &progress);
    if (plan_image(plan, &image, NULL) == FAULT_NONE)
        image_clear(&image);
    json_t *report = plan_report(plan);
    free(json_print(report, false));
    json_destroy(&report);
    if (plan_save(plan, &data, &size, NULL) != FAULT_NONE)
        abort();
    free(data);
}

static void try_restore(const job_t *job, const uint8_t *data, size_t size)
{
    plan_t *plan = NULL;
    fault_t fault = {0};
    if (plan_restore(&plan, job, &small.scene, data, size, &fault) != FAULT_NONE) {
        if (plan || fault.text[0] == '\0')
            abort();
        return;
    }
    go_on(plan);
    plan_destroy(&plan);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!saves[0]) {
        prepare();
        for (int i = 0; i < SAVES; i++)
            try_restore(&jobs[(i + 2) % SAVES], saves[i], save_sizes[i]); /* another job's */
    }
    uint32_t sum = 0; /* of all octets: every input has its turn, whichever of them differ from others' */
    for (size_t at = 0; at < size; at++)
        sum += data[at];
    const uint32_t i = sum % SAVES;
    if (sum / SAVES % 8 == 0) {
        try_restore(&jobs[i], data, size);
        return 0;
    }
    uint8_t *edited = malloc(save_sizes[i]);
    memcpy(edited, saves[i], save_sizes[i]);
    try_restore(&jobs[i], edited, fuzz_edit(edited, save_sizes[i], data, size));
    free(edited);
    return 0;
}
