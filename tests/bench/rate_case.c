#include "rate_case.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "parallel.h"

enum {
    PILOT_CANDIDATES = 16384,
    LOOK_AHEAD = 1 << 25, /* mutations to which the plan is asked for units */
    RECORD_RAYS = 1 << 19,
    RECORD_PART = 16, /* of the work, at most, is recorded and timed by the time stamp counter */
    SAMPLES_SHARE = 4 /* a sample makes paths of every length: so many times dearer than a mutation */
};

static const atomic_bool never = false;

/* ---- the plan's choice ---- */

static fault_code_t rate_job(job_t *job, const rate_case_t *rate, fault_t *fault)
{
    char text[512];
    const peer_scene_t *e = rate->entry;
    snprintf(text, sizeof text,
             "{\"scene\":\"%s\",\"film\":{\"width\":%u,\"height\":%u,\"filter\":\"box\"},\"algorithm\":\"%s\","
             "\"max_path_length\":%u,\"seed\":\"1\",\"chains\":{\"pilot_samples\":%d},\"stop\":{\"seconds\":1e6}}",
             e->name, e->width, e->height, settings_algorithm_name(rate->algorithm), e->max_path_length,
             PILOT_CANDIDATES);
    return job_parse(job, text, strlen(text), "bench", fault);
}

/* What a unit costs: CPU seconds of running it and of encoding and merging it, and its bytes. */
typedef struct rate_unit_cost {
    double run, merge, bytes;
} rate_unit_cost_t;

/* Runs and merges the unit at hand. */
static fault_code_t rate_unit(rate_case_t *rate, plan_t *plan, uint64_t unit, const work_record_t *record,
                              rate_unit_cost_t *cost, fault_t *fault)
{
    work_result_t result;
    uint8_t *data;
    size_t size;
    plan_absorbed_t how;
    const double start = clock_thread_cpu();
    TRY(work_run(rate->space, record, &never, &result, fault));
    const double ran = clock_thread_cpu();
    TRY(work_result_encode(&result, &data, &size, fault));
    const fault_code_t code = plan_absorb(plan, unit, data, size, &how, fault);
    *cost = (rate_unit_cost_t){ran - start, clock_thread_cpu() - ran, (double)size};
    free(data);
    return code;
}

/* What the plan hands out of one kind and length: chains of a length, samples, refining samples. */
typedef struct rate_class {
    double handed; /* mutations, or samples */
    double units;
    rate_unit_cost_t cost; /* of the first */
} rate_class_t;

static double rate_amount(const work_record_t *record)
{
    return (double)(record->kind == WORK_CHAINS ? record->mutations : record->count);
}

/* Keeps a record, its seeds copied. */
static fault_code_t rate_keep(rate_case_t *rate, const work_record_t *record, fault_t *fault)
{
    work_record_t *kept = &rate->records[rate->record_count++];
    *kept = *record;
    kept->seeds = NULL;
    kept->shares = NULL;
    if (record->kind != WORK_CHAINS)
        return FAULT_NONE;
    kept->seeds = malloc(kept->count * sizeof *kept->seeds);
    if (!kept->seeds)
        return fault_set(fault, FAULT_MEMORY, "no memory for the seeds of %llu chains",
                         (unsigned long long)kept->count);
    memcpy(kept->seeds, record->seeds, kept->count * sizeof *kept->seeds);
    if (!record->shares)
        return FAULT_NONE;
    kept->shares = malloc(sizeof *kept->shares * (record->length + 1));
    if (!kept->shares)
        return fault_set(fault, FAULT_MEMORY, "no memory for the shares of %u techniques", record->length + 1);
    memcpy(kept->shares, record->shares, sizeof *kept->shares * (record->length + 1));
    return FAULT_NONE;
}

/* Cuts a record to an amount of work; chains keep their length. */
static void rate_cut(work_record_t *record, double amount)
{
    const double all = rate_amount(record);
    amount = fmax(1, rint(amount));
    record->count = (uint64_t)fmax(1, fmin((double)record->count, rint((double)record->count * amount / all)));
    if (record->kind == WORK_CHAINS)
        record->mutations = (uint64_t)fmax((double)record->count, amount);
}

/* The class of a record: the place of the kept record that is like it; that of the next one if there is none. */
static uint32_t rate_class_of(const rate_case_t *rate, const work_record_t *record)
{
    uint32_t i = 0;
    while (i < rate->record_count &&
           (rate->records[i].kind != record->kind || rate->records[i].length != record->length))
        i++;
    return i;
}

/* The cost of merging: a mean over classes in the ratio of their units. */
static void rate_costs(rate_case_t *rate, const rate_class_t *classes)
{
    double run = 0, merge = 0, bytes = 0, units = 0;
    for (uint32_t i = 0; i < rate->record_count; i++) {
        run += classes[i].units * classes[i].cost.run;
        merge += classes[i].units * classes[i].cost.merge;
        bytes += classes[i].units * classes[i].cost.bytes;
        units += classes[i].units;
    }
    rate->merge_share = merge / run;
    rate->unit_bytes = bytes / units;
}

/* Takes many units from the plan, keeps the first of each class, and cuts it to what the class has of all work. */
static fault_code_t rate_choose(rate_case_t *rate, plan_t *plan, double work, fault_t *fault)
{
    rate_class_t classes[RATE_MAX_RECORDS] = {0};
    double handed = 0; /* mutations; refining samples are no mutations */
    uint64_t unit;
    const work_record_t *record;
    while (handed < LOOK_AHEAD && plan_next(plan, &unit, &record)) {
        const uint32_t at = rate_class_of(rate, record);
        classes[at].handed += rate_amount(record);
        classes[at].units++;
        handed += record->kind == WORK_REFINE ? 0 : rate_amount(record);
        if (at < rate->record_count)
            continue;
        TRY(rate_keep(rate, record, fault));
        TRY(rate_unit(rate, plan, unit, record, &classes[at].cost, fault));
    }
    rate_costs(rate, classes);
    for (uint32_t i = 0; i < rate->record_count; i++) {
        rate_cut(&rate->records[i], work * classes[i].handed / handed);
        if (rate->records[i].kind != WORK_REFINE)
            rate->mutations += rate_amount(&rate->records[i]);
    }
    return FAULT_NONE;
}

static fault_code_t rate_plan(rate_case_t *rate, const scene_t *scene, double work, fault_t *fault)
{
    job_t job;
    plan_t *plan;
    TRY(rate_job(&job, rate, fault));
    TRY(renderer_new(&rate->renderer, scene, &job.settings, fault));
    TRY(work_space_new(&rate->space, rate->renderer, fault));
    TRY(plan_new(&plan, &job, scene, fault));
    fault_code_t code = FAULT_NONE;
    for (plan_progress_t at = {0}; !code && at.phase == PLAN_PILOT; plan_progress(plan, &at)) {
        uint64_t unit;
        const work_record_t *record;
        rate_unit_cost_t cost;
        if (!plan_next(plan, &unit, &record))
            code = fault_set(fault, FAULT_RANGE, "%s: the pilot does not end", rate->entry->name);
        else
            code = rate_unit(rate, plan, unit, record, &cost, fault);
    }
    if (!code)
        code = rate_choose(rate, plan, work, fault);
    plan_destroy(&plan);
    return code;
}

/* ---- running ---- */

/* Runs all records, each with a part of its mutations; chains are numbered from `shift` on. */
static fault_code_t rate_work(const rate_case_t *rate, work_space_t *space, double part, uint64_t shift,
                              double *rays, fault_t *fault)
{
    *rays = 0;
    for (uint32_t i = 0; i < rate->record_count; i++) {
        work_record_t record = rate->records[i];
        work_result_t result;
        record.first += shift;
        rate_cut(&record, part * rate_amount(&record));
        TRY(work_run(space, &record, &never, &result, fault));
        *rays += (double)(result.stats.rays + result.stats.shadow_rays);
    }
    return FAULT_NONE;
}

/* Records a part of the work's rays. */
static fault_code_t rate_record(rate_case_t *rate, fault_t *fault)
{
    double rays;
    if (!rays_log_init(&rate->log, RECORD_RAYS))
        return fault_set(fault, FAULT_MEMORY, "no memory for %d rays", RECORD_RAYS);
    rate->watch_part = fmin(1. / RECORD_PART, 0.9 * RECORD_RAYS / rate->rays);
    rays_start(RAYS_RECORD, &rate->log);
    const fault_code_t code = rate_work(rate, rate->space, rate->watch_part, 0, &rays, fault);
    rays_stop();
    TRY(code);
    if ((double)rate->log.seen != rays)
        return fault_set(fault, FAULT_RANGE, "%s: the renderer counts %.0f rays, Embree was asked for %llu",
                         rate->entry->name, rays, (unsigned long long)rate->log.seen);
    return FAULT_NONE;
}

/* Times the same part ray by ray. */
static fault_code_t rate_time(const rate_case_t *rate, double *share, fault_t *fault)
{
    double rays;
    const double ticks = rays_ticks_per_second();
    rays_start(RAYS_TIME, NULL);
    const double start = clock_thread_cpu();
    const fault_code_t code = rate_work(rate, rate->space, rate->watch_part, 0, &rays, fault);
    *share = (double)rays_ticks_inside() / (ticks * (clock_thread_cpu() - start));
    rays_stop();
    return code;
}

fault_code_t rate_case_init(rate_case_t *rate, const peer_loaded_t *loaded, settings_algorithm_t algorithm,
                            double work, fault_t *fault)
{
    *rate = (rate_case_t){.entry = loaded->entry, .algorithm = algorithm};
    if (loaded->entry->max_path_length + 1 > RATE_MAX_RECORDS)
        return fault_set(fault, FAULT_LIMIT, "%s: paths of more than %d segments", loaded->entry->name,
                         RATE_MAX_RECORDS - 1);
    fault_code_t code =
        rate_plan(rate, &loaded->scene, algorithm == SETTINGS_MMLT ? work : work / SAMPLES_SHARE, fault);
    if (!code)
        code = rate_work(rate, rate->space, 1, 0, &rate->rays, fault);
    if (!code)
        code = rate_record(rate, fault);
    if (code) {
        rate_case_clear(rate);
        return code;
    }
    rate->renderer_bytes = renderer_bytes(rate->renderer);
    rate->film_bytes = (size_t)loaded->entry->width * loaded->entry->height * FILM_CHANNELS * sizeof(int64_t);
    return FAULT_NONE;
}

void rate_case_clear(rate_case_t *rate)
{
    for (uint32_t i = 0; i < rate->record_count; i++)
        work_record_clear(&rate->records[i]);
    rays_log_clear(&rate->log);
    work_space_destroy(&rate->space);
    renderer_destroy(&rate->renderer);
    *rate = (rate_case_t){0};
}

fault_code_t rate_case_run(const rate_case_t *rate, rate_figures_t *figures, fault_t *fault)
{
    double rays;
    const double start = clock_thread_cpu();
    TRY(rate_work(rate, rate->space, 1, 0, &rays, fault));
    const double seconds = clock_thread_cpu() - start;
    const double raw = rays_replay(&rate->log) / (double)rate->log.count;
    *figures = (rate_figures_t){.mutations_per_second = rate->mutations / seconds * 1e-6,
                                .rays_per_second = rays / seconds * 1e-6,
                                .raw_rays_per_second = 1e-6 / raw,
                                .share = rays * raw / seconds};
    return rate_time(rate, &figures->share_timed, fault);
}

/* ---- threads ---- */

typedef struct rate_thread {
    const rate_case_t *rate;
    pthread_barrier_t *barrier;
    pthread_t id;
    uint64_t shift;
    double begin, end, cpu;
    fault_t fault;
} rate_thread_t;

static void *rate_thread_main(void *user)
{
    rate_thread_t *thread = user;
    double rays;
    work_space_t *space;
    fault_code_t code = work_space_new(&space, thread->rate->renderer, &thread->fault);
    if (!code) /* the film and other arrays are made */
        code = rate_work(thread->rate, space, 1e-3, thread->shift, &rays, &thread->fault);
    pthread_barrier_wait(thread->barrier);
    thread->begin = clock_now();
    const double start = clock_thread_cpu();
    if (!code)
        rate_work(thread->rate, space, 1, thread->shift, &rays, &thread->fault);
    thread->cpu = clock_thread_cpu() - start;
    thread->end = clock_now();
    work_space_destroy(&space);
    return NULL;
}

fault_code_t rate_case_threads(const rate_case_t *rate, unsigned threads, double *wall, double *cpu, fault_t *fault)
{
    rate_thread_t thread[PARALLEL_MAX_THREADS] = {0};
    pthread_barrier_t barrier;
    if (threads < 1 || threads > PARALLEL_MAX_THREADS || pthread_barrier_init(&barrier, NULL, threads))
        return fault_set(fault, FAULT_RANGE, "%u threads, expected 1 to %d", threads, PARALLEL_MAX_THREADS);
    for (unsigned i = 0; i < threads; i++) {
        thread[i] = (rate_thread_t){.rate = rate, .barrier = &barrier, .shift = (uint64_t)i << 32};
        if (i > 0 && pthread_create(&thread[i].id, NULL, rate_thread_main, &thread[i]))
            abort(); /* the others would wait for ever */
    }
    rate_thread_main(&thread[0]);
    double begin = INFINITY, end = 0;
    *cpu = 0;
    fault_code_t code = FAULT_NONE;
    for (unsigned i = 0; i < threads; i++) {
        if (i > 0)
            pthread_join(thread[i].id, NULL);
        begin = fmin(begin, thread[i].begin);
        end = fmax(end, thread[i].end);
        *cpu += thread[i].cpu;
        if (thread[i].fault.code) {
            *fault = thread[i].fault;
            code = fault->code;
        }
    }
    pthread_barrier_destroy(&barrier);
    *wall = end - begin;
    return code;
}
