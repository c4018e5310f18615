/* The course of a plan: results in any order, twice, malformed, across restarts; budgets; stop rules; no light. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "plan/plan_fixture.h"
#include "plan/plan_estimate.h"
#include "plan/plan_state.h"
#include "support/sanitized.h"

enum { MMLT, BDPT, PSSMLT, PT, ALGORITHMS };
static const char *const algorithms[ALGORITHMS] = {"mmlt", "bdpt", "pssmlt", "pt"};

/* Every algorithm, with an importance and without, chains with samples beside them, and effects left out. */
typedef struct course {
    const char *algorithm;
    double equalize, split;
    bool adapt;
    const char *effects;
    int pilot;   /* 0: 20000 candidates; 65536 are enough for a survey of techniques */
    double gain; /* split_gain, with as many candidates as the plan chooses; 0: the default */
    int eras;    /* mutations a chain where shares shift while the render runs; 0: they do not */
} course_t;
static const course_t courses[] = {{"mmlt", 0, 0, false, "", 0, 0, 0},
                                   {"mmlt", 1, 0, false, "", 0, 0, 0},
                                   {"mmlt", 0, 20, false, "", 0, 0, 0},
                                   {"mmlt", 0.5, 3, true, "'caustics':'off'", 0, 0, 0},
                                   {"bdpt", 0, 0, false, "", 0, 0, 0},
                                   {"pssmlt", 0, 0, false, "", 0, 0, 0},
                                   {"pt", 0, 0, false, "'emission':'off','indirect':'off'", 0, 0, 0},
                                   {"pssmlt", 0.5, 0, false, "", 0, 0, 0},
                                   {"rjmlt", 1, 500, false, "", 0, 0, 0},
                                   {"rjmlt", 1, 20, true, "", 0, 0, 0},
                                   {"cmlt", 0, 0, true, "", 0, 0, 0},
                                   {"cmlt", 1, 3, true, "'emission':'off'", 65536, 0, 0},
                                   {"rjmlt", 1, 20, true, "", 0, 1e6, 0},
                                   {"mmlt", 0, 0, false, "", 0, 0, 40},
                                   {"cmlt-rex", 1, 0, false, "", 0, 0, 40},
                                   {"rjmlt", 1, 20, false, "", 0, 0, 40}};
enum { COURSES = sizeof courses / sizeof *courses };

static uint64_t counter;

static uint64_t draw(uint64_t below)
{
    return random_u64(random_key(2385, RANDOM_PURPOSE_TEST, SANITIZED, 0), counter++) % below;
}

static job_t job_with(const course_t *course, const char *stop, const char *more)
{
    char text[512];
    snprintf(text, sizeof text,
             "{'scene':'x','algorithm':'%s','max_path_length':5,'seed':'31','stop':{%s},'chains':{'%s':"
             "%g,'equalize':%g,'split':%g,'adapt':%s,'shift':%s%s%.0d},'effects':{%s}%s}",
             course->algorithm, stop, course->gain > 0 ? "split_gain" : "pilot_samples",
             course->gain > 0 ? course->gain
             : course->pilot  ? course->pilot
                              : 20000,
             course->equalize, course->split, course->adapt ? "true" : "false", course->eras ? "true" : "false",
             course->eras ? ",'length':" : "", course->eras, course->effects, more);
    return plan_fixture_job(text);
}

static job_t job_of(const char *algorithm, const char *stop, const char *more)
{
    return job_with(&(course_t){algorithm, 0, 0, false, "", 0, 0, 0}, stop, more);
}

/* ---- order, repetition, restarts ---- */

static json_t *report_copy(const json_t *length)
{
    static const char *const names[] = {"length", "b",         "techniques",  "idle",  "idle_energy",
                                        "share",  "mutations", "chains",      "moves", "zero_contribution",
                                        "eras",   "relmse",    "longest_stay"};
    json_t *object = json_new_object();
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (json_get(length, names[i]))
            json_add(object, names[i], json_copy(json_get(length, names[i])));
    return object;
}

/* What of a report does not depend on how long things took. */
static char *report_text(const plan_t *plan)
{
    json_t *report = plan_report(plan), *kept = json_new_object();
    const json_t *lengths = json_get(report, "lengths");
    json_t *list = json_new_array();
    for (const json_t *length = json_first(lengths); length; length = json_next(length))
        json_append(list, report_copy(length));
    json_add(kept, "lengths", list);
    if (json_get(report, "chains"))
        json_add(kept, "chains", report_copy(json_get(report, "chains")));
    if (json_get(report, "stratification"))
        json_add(kept, "stratification", json_copy(json_get(report, "stratification")));
    json_add(kept, "effects", json_copy(json_get(report, "effects")));
    if (json_get(report, "left_out"))
        json_add(kept, "left_out", json_copy(json_get(report, "left_out")));
    json_add(kept, "error", json_copy(json_get(report, "error")));
    json_add(kept, "rejected", json_copy(json_get(report, "rejected")));
    json_add(kept, "job", json_copy(json_get(report, "job")));
    char *text = json_print(kept, false);
    json_destroy(&report);
    json_destroy(&kept);
    return text;
}

static void assert_same_outcome(const plan_t *a, const plan_t *b)
{
    image_t x, y;
    fault_t fault = {0};
    assert_int_equal(plan_image(a, &x, &fault), FAULT_NONE);
    assert_int_equal(plan_image(b, &y, &fault), FAULT_NONE);
    assert_int_equal(x.channel_count, y.channel_count);
    for (uint32_t c = 0; c < x.channel_count; c++)
        if (memcmp(image_channel(&x, c), image_channel(&y, c), sizeof(float) * x.width * x.height) != 0)
            fail_msg("layer %s differs", x.names[c]);
    image_clear(&x);
    image_clear(&y);
    char *one = report_text(a), *other = report_text(b);
    assert_string_equal(one, other);
    free(one);
    free(other);
}

typedef struct result {
    uint64_t unit;
    uint8_t *data;
    size_t size;
} result_t;

enum { RESULTS = 64 };

/* Results on their way to the plan. */
typedef struct flight {
    result_t results[RESULTS];
    uint32_t count;
    uint64_t merged, duplicates, restarts, pilot_restarts;
    uint64_t pending_restarts; /* with results that wait for the end of an era */
} flight_t;

static void flight_drop(flight_t *flight, uint32_t i)
{
    free(flight->results[i].data);
    flight->results[i] = flight->results[--flight->count];
}

static void flight_absorb(flight_t *flight, plan_t *plan)
{
    const uint32_t i = (uint32_t)draw(flight->count);
    const result_t *result = &flight->results[i];
    const bool out = plan_record(plan, result->unit) != NULL;
    plan_absorbed_t how;
    fault_t fault = {0};
    if (plan_absorb(plan, result->unit, result->data, result->size, &how, &fault))
        fail_msg("%s", fault.text);
    assert_int_equal(how, out ? PLAN_MERGED : PLAN_DUPLICATE);
    assert_null(plan_record(plan, result->unit));
    flight->merged += how == PLAN_MERGED;
    flight->duplicates += how == PLAN_DUPLICATE;
    if (how == PLAN_DUPLICATE || draw(3) > 0) /* now and then it comes again */
        flight_drop(flight, i);
}

/* The master dies and is restarted from its checkpoint; some results get lost with it. */
static void flight_restart(flight_t *flight, plan_t **plan, const job_t *job, const scene_t *scene)
{
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    plan_progress_t before, after;
    plan_progress(*plan, &before);
    const bool pending = (*plan)->eras.pending.count > 0;
    assert_int_equal(plan_save(*plan, &data, &size, &fault), FAULT_NONE);
    plan_destroy(plan);
    if (plan_restore(plan, job, scene, data, size, &fault))
        fail_msg("%s", fault.text);
    plan_progress(*plan, &after);
    assert_int_equal(after.phase, before.phase);
    assert_int_equal(after.units_in, before.units_in);
    assert_true(after.mutations == before.mutations);
    free(data);
    for (uint32_t i = flight->count; i-- > 0;)
        if (draw(2))
            flight_drop(flight, i);
    flight->restarts++;
    flight->pending_restarts += pending;
    flight->pilot_restarts += before.phase == PLAN_PILOT;
}

static plan_t *run_wildly(const job_t *job, const scene_t *scene, plan_worker_t *worker, flight_t *flight)
{
    plan_t *plan = plan_fixture_new(job, scene);
    const work_record_t *record;
    while (!plan_finished(plan)) {
        uint64_t unit;
        if (draw(12) == 0)
            flight_restart(flight, &plan, job, scene);
        const bool full = flight->count == RESULTS;
        if (!full && draw(5) < 3 && plan_next(plan, &unit, &record)) {
            result_t *result = &flight->results[flight->count++];
            result->unit = unit;
            result->data = plan_worker_run(worker, record, &result->size);
        } else if (flight->count > 0) {
            flight_absorb(flight, plan);
        }
        plan_check_stop(plan, 1);
    }
    while (flight->count > 0) /* late ones change nothing */
        flight_absorb(flight, plan);
    return plan;
}

/* Whether an era's shares are not those of the one before. */
static bool has_shifted(const plan_t *plan)
{
    for (uint32_t r = 2; r <= plan->eras.current; r++)
        for (uint32_t k = plan_first(plan); k <= plan_last(plan); k++) {
            const plan_part_t *a = plan_eras_part(plan, r, k), *b = plan_eras_part(plan, r - 1, k);
            if (a->work > 0 && b->work > 0 && fabs(a->share / b->share - 1) > 0.1)
                return true;
        }
    return false;
}

/* Each job is run in an order of its own, with a restart after every twelfth step: 250 restarts in all, some with
 * results that wait, 300 results twice. Under the sanitizers in another order. */
static void order_repetition_and_restarts_leave_no_trace(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_box(&small, SMALL_LIGHT_AREA);
    flight_t flight = {.count = 0};
    int shifts = 0;
    for (int a = 0; a < COURSES; a++) {
        const double budget = courses[a].adapt       ? 700
                              : courses[a].eras      ? 200
                              : courses[a].split > 0 ? 60
                                                     : 20; /* else there is no room for trials and samples */
        char rule[64];
        snprintf(rule, sizeof rule, "'mutations_per_pixel':%g", budget);
        const job_t job = job_with(&courses[a], rule, ",'film':{'filter':'gaussian'}");
        plan_worker_t worker;
        plan_worker_make(&worker, &job, &small.scene);
        plan_t *reference = plan_fixture_new(&job, &small.scene);
        plan_fixture_run(reference, &worker, 0);
        assert_true(courses[a].eras ? reference->eras.current >= 4 : reference->eras.current == 0);
        shifts += has_shifted(reference);
        plan_t *plan = run_wildly(&job, &small.scene, &worker, &flight);
        plan_progress_t progress;
        plan_progress(plan, &progress);
        assert_true(progress.mutations == budget * 24 * 24);
        assert_string_equal(progress.stopped_by, "mutations_per_pixel");
        assert_same_outcome(plan, reference);
        plan_destroy(&plan);
        plan_destroy(&reference);
        plan_worker_clear(&worker);
    }
    print_message("%llu merged, %llu duplicates, %llu restarts, %llu of them during the pilot, %llu with results "
                  "that wait; shares shift in %d of 3 jobs\n",
                  (unsigned long long)flight.merged, (unsigned long long)flight.duplicates,
                  (unsigned long long)flight.restarts, (unsigned long long)flight.pilot_restarts,
                  (unsigned long long)flight.pending_restarts, shifts);
    assert_true(flight.pending_restarts > 2 && shifts > 1);
    assert_true(flight.duplicates > 50 && flight.pilot_restarts > 5 && flight.restarts > flight.pilot_restarts + 5);
    small_scene_clear(&small);
}

/* A checkpoint of a restored plan is the checkpoint it was restored from. */
static void checkpoints_come_back_as_they_were(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_box(&small, SMALL_LIGHT_AREA);
    for (int a = 0; a < COURSES; a++) {
        const job_t job = job_with(&courses[a], "'mutations_per_pixel':45", "");
        plan_worker_t worker;
        plan_worker_make(&worker, &job, &small.scene);
        plan_t *plan = plan_fixture_new(&job, &small.scene);
        for (int step = 0; !plan_finished(plan); step++) {
            plan_fixture_step(plan, &worker);
            plan_check_stop(plan, step);
            if (step % (SANITIZED ? 20 : 5))
                continue;
            uint8_t *data, *again;
            size_t size, again_size;
            fault_t fault = {0};
            plan_t *back;
            assert_int_equal(plan_save(plan, &data, &size, &fault), FAULT_NONE);
            assert_int_equal(plan_restore(&back, &job, &small.scene, data, size, &fault), FAULT_NONE);
            assert_int_equal(plan_save(back, &again, &again_size, &fault), FAULT_NONE);
            assert_int_equal(again_size, size);
            assert_memory_equal(again, data, size);
            plan_destroy(&back);
            free(data);
            free(again);
        }
        plan_destroy(&plan);
        plan_worker_clear(&worker);
    }
    small_scene_clear(&small);
}

/* ---- malformed results ---- */

static void refuse(plan_t *plan, uint64_t unit, const uint8_t *data, size_t size)
{
    uint8_t *before, *after;
    size_t before_size, after_size;
    fault_t fault = {0};
    plan_absorbed_t how;
    assert_int_equal(plan_save(plan, &before, &before_size, &fault), FAULT_NONE);
    if (plan_absorb(plan, unit, data, size, &how, &fault) == FAULT_NONE)
        fail_msg("%zu octets are accepted for unit %llu", size, (unsigned long long)unit);
    assert_true(strlen(fault.text) > 10);
    assert_int_not_equal(how, PLAN_MERGED);
    assert_non_null(plan_record(plan, unit));
    assert_int_equal(plan_save(plan, &after, &after_size, &fault), FAULT_NONE);
    assert_int_equal(after_size, before_size);
    assert_memory_equal(after, before, before_size);
    free(before);
    free(after);
}

static void malformed_results_change_nothing(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_box(&small, SMALL_LIGHT_AREA);
    for (int a = 0; a < PT; a++) {
        const job_t job = job_of(algorithms[a], "'mutations_per_pixel':5", "");
        plan_worker_t worker;
        plan_worker_make(&worker, &job, &small.scene);
        plan_t *plan = plan_fixture_new(&job, &small.scene);
        uint8_t *last = NULL; /* of another unit: other length or kind */
        int refused = 0;
        size_t last_size = 0;
        while (!plan_finished(plan)) {
            const work_record_t *record;
            uint64_t unit;
            if (plan_next(plan, &unit, &record)) {
                size_t size;
                fault_t fault = {0};
                plan_absorbed_t how;
                uint8_t *data = plan_worker_run(&worker, record, &size);
                const uint32_t kind = record->kind, length = record->length;
                if (unit % 2 == 0) { /* of some units: saving before and after takes its time */
                    refuse(plan, unit, data, 0);
                    refuse(plan, unit, data, draw(size));
                    refuse(plan, unit, data, size - 1);
                    data[0] ^= 0x40; /* the version */
                    refuse(plan, unit, data, size);
                    data[0] ^= 0x40;
                    refused++;
                }
                if (last && draw(2) == 0 && memcmp(last + 4, data + 4, 8) != 0)
                    refuse(plan, unit, last, last_size);
                assert_int_equal(plan_absorb(plan, unit + 1, data, size, &how, &fault), FAULT_NONE);
                assert_int_equal(how, PLAN_UNKNOWN); /* not handed out yet */
                assert_int_equal(plan_absorb(plan, UINT64_MAX, data, size, &how, &fault), FAULT_NONE);
                assert_int_equal(how, PLAN_UNKNOWN);
                assert_int_equal(plan_record(plan, unit)->kind, kind);
                assert_int_equal(plan_record(plan, unit)->length, length);
                assert_int_equal(plan_absorb(plan, unit, data, size, &how, &fault), FAULT_NONE);
                assert_int_equal(how, PLAN_MERGED);
                free(last);
                last = data;
                last_size = size;
            }
            plan_check_stop(plan, 0);
        }
        free(last);
        assert_true(refused > 2);
        plan_t *reference = plan_fixture_new(&job, &small.scene);
        plan_fixture_run(reference, &worker, 0);
        assert_same_outcome(plan, reference);
        plan_destroy(&reference);
        plan_destroy(&plan);
        plan_worker_clear(&worker);
    }
    small_scene_clear(&small);
}

/* ---- budgets ---- */

static double film_weight(const film_t *film)
{
    double weight = 0;
    for (uint32_t y = 0; y < film->height; y++)
        for (uint32_t x = 0; x < film->width; x++)
            weight += rgb_luminance(film_value(film, x, y));
    return weight;
}

static void as_many_mutations_are_made_as_asked(void **state)
{
    (void)state;
    static const char *const asked[] = {"20", "0.7", "3.3", "7.77", "0.001", "33"};
    small_scene_t small;
    small_scene_box(&small, SMALL_LIGHT_CONSTANT);
    for (int a = 0; a < ALGORITHMS; a++) {
        const bool chains = a == MMLT || a == PSSMLT;
        for (size_t i = 0; i < sizeof asked / sizeof *asked; i++) {
            char stop[64];
            snprintf(stop, sizeof stop, "'mutations_per_pixel':%s", asked[i]);
            const job_t job = job_of(algorithms[a], stop, i % 2 ? "" : ",'film':{'width':17,'height':9}");
            const double pixels = i % 2 ? 24 * 24 : 17 * 9, each = strtod(asked[i], NULL),
                         total = chains ? ceil(each * pixels) : ceil(each) * pixels; /* whole passes */
            plan_worker_t worker;
            plan_worker_make(&worker, &job, &small.scene);
            plan_t *plan = plan_fixture_new(&job, &small.scene);
            plan_fixture_run(plan, &worker, 0);
            plan_progress_t progress;
            plan_progress(plan, &progress);
            assert_true(progress.mutations == total);
            assert_true(progress.fraction == 1);
            assert_true(progress.phase == PLAN_DONE);
            double merged = 0;
            for (uint32_t k = 0; k <= 5 && chains; k++) {
                const plan_length_t *length = &plan->lengths[k];
                merged += (double)length->merged;
                if (length->merged > 0) { /* each splat is rounded to 2^-28 a channel */
                    const double off = film_weight(&length->film) - (double)length->merged;
                    assert_true(fabs(off) <= (double)length->film.counts.splats / FILM_ONE);
                    /* a budget is within a mutation of its share */
                    assert_true(fabs((double)length->merged - length->share * total) <= 5);
                }
            }
            assert_true(!chains || merged == total);
            assert_true((plan->lengths[0].merged > 0) == (a != MMLT));
            plan_destroy(&plan);
            plan_worker_clear(&worker);
        }
    }
    small_scene_clear(&small);
}

/* Ids of units are consecutive; records of one kind and length do not overlap and leave nothing out. */
static void check_cover(const char *algorithm, const char *stop, uint32_t first, uint32_t last)
{
    small_scene_t small;
    small_scene_box(&small, SMALL_LIGHT_AREA);
    const job_t job = job_of(algorithm, stop, "");
    plan_worker_t worker;
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    uint64_t next[WORK_KINDS][6] = {{0}}, expected = 0;
    while (!plan_finished(plan)) {
        const work_record_t *record;
        uint64_t unit;
        if (plan_next(plan, &unit, &record)) {
            size_t size;
            fault_t fault = {0};
            plan_absorbed_t how;
            assert_int_equal(unit, expected++);
            assert_int_equal(record->first, next[record->kind][record->length]);
            next[record->kind][record->length] += record->count;
            uint8_t *data = plan_worker_run(&worker, record, &size);
            assert_int_equal(plan_absorb(plan, unit, data, size, &how, &fault), FAULT_NONE);
            free(data);
        }
        plan_check_stop(plan, 0);
    }
    assert_int_equal(next[WORK_FEATURES][0], 24);
    assert_int_equal(next[WORK_PILOT][0], plan->candidates);
    assert_true(plan->candidates >= 20000);
    assert_int_equal(next[WORK_REFINE][0], plan->refine_handed);
    assert_true(plan->refine_handed > 0);
    for (uint32_t k = 0; k <= 5; k++) {
        assert_int_equal(next[WORK_CHAINS][k], plan->lengths[k].chains);
        if (k >= first && k <= last)
            assert_true(plan->lengths[k].units_in >= 16 && plan->lengths[k].units_in <= 32);
        else
            assert_int_equal(plan->lengths[k].units_in, 0);
    }
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    small_scene_clear(&small);
}

/* As much work as makes a unit of refinement. */
static void units_cover_everything_once(void **state)
{
    (void)state;
    check_cover("mmlt", "'mutations_per_pixel':2900", 1, 5);
    check_cover("pssmlt", "'mutations_per_pixel':330", 0, 0);
}

/* ---- stop rules ---- */

static void a_rule_of_time_stops_once_there_is_an_image(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_diffuse(&small);
    const job_t job = job_of("bdpt", "'seconds':100", "");
    plan_worker_t worker;
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    plan_progress_t progress;
    do { /* the pilot: far over time, and yet no image */
        assert_false(plan_check_stop(plan, 1000));
        plan_progress(plan, &progress);
        assert_true(progress.fraction >= 0 && progress.fraction <= 1);
        if (progress.phase == PLAN_PILOT) {
            assert_true(isnan(progress.seconds_left));
            assert_true(plan_fixture_step(plan, &worker));
        }
    } while (progress.phase == PLAN_PILOT);
    const work_record_t *record;
    uint64_t late;
    assert_true(plan_next(plan, &late, &record)); /* out when it stops */
    size_t size;
    uint8_t *data = plan_worker_run(&worker, record, &size);
    assert_true(plan_fixture_step(plan, &worker));
    assert_false(plan_check_stop(plan, 99.9));
    plan_progress(plan, &progress);
    assert_true(fabs(progress.fraction - 0.999) < 1e-12 && fabs(progress.seconds_left - 0.1) < 1e-9);
    assert_false(plan_finished(plan));
    assert_true(plan_check_stop(plan, 100));
    assert_false(plan_check_stop(plan, 101)); /* just stopped, once */
    assert_true(plan_finished(plan));
    plan_progress(plan, &progress);
    assert_string_equal(progress.stopped_by, "seconds");
    assert_int_equal(progress.phase, PLAN_DONE);
    assert_int_equal(progress.units_out, 1);
    uint64_t unit;
    assert_false(plan_next(plan, &unit, &record));
    const double before = progress.mutations;
    plan_absorbed_t how;
    fault_t fault = {0};
    assert_int_equal(plan_absorb(plan, late, data, size, &how, &fault), FAULT_NONE);
    assert_int_equal(how, PLAN_MERGED);
    plan_progress(plan, &progress);
    assert_true(progress.mutations > before);
    free(data);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    small_scene_clear(&small);
}

static void the_first_rule_met_stops(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_diffuse(&small);
    for (int i = 0; i < 4; i++) {
        const bool slow = i % 2;
        const job_t job = job_of(i < 2 ? "mmlt" : "pssmlt", "'mutations_per_pixel':40,'seconds':10", "");
        plan_worker_t worker;
        plan_worker_make(&worker, &job, &small.scene);
        plan_t *plan = plan_fixture_new(&job, &small.scene);
        plan_fixture_run(plan, &worker, slow ? 0.8 : 0.01);
        plan_progress_t progress;
        plan_progress(plan, &progress);
        assert_string_equal(progress.stopped_by, slow ? "seconds" : "mutations_per_pixel");
        assert_true((progress.mutations == 40 * 24 * 24) == !slow);
        plan_destroy(&plan);
        plan_worker_clear(&worker);
    }
    small_scene_clear(&small);
}

/* The error falls as one over the root of the work: from what it was after the first look one knows when to expect
 * the end, within what rounds of a tenth of the work and the estimate's own noise make of it. */
static void a_rule_of_error_stops_when_it_is_met(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_diffuse(&small);
    const job_t job = job_of("bdpt", "'error':0.01", "");
    plan_worker_t worker;
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    plan_progress_t progress = {.error = NAN};
    double first_error = NAN, first_mutations = 0;
    while (!plan_finished(plan)) {
        assert_true(plan_fixture_step(plan, &worker));
        plan_check_stop(plan, 1);
        plan_progress(plan, &progress);
        assert_true(plan_finished(plan) == (progress.error <= 0.01));
        if (isnan(first_error) && !isnan(progress.error)) {
            first_error = progress.error;
            first_mutations = progress.mutations;
        }
    }
    assert_string_equal(progress.stopped_by, "error");
    assert_true(first_error > 0.01); /* else this test says nothing */
    const double expected = first_mutations * first_error * first_error / (0.01 * 0.01);
    if (!(progress.mutations > 0.8 * expected && progress.mutations < 1.5 * expected))
        fail_msg("error %g after %g samples, stopped after %g, expected %g", first_error, first_mutations,
                 progress.mutations, expected);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    small_scene_clear(&small);
}

/* ---- no light ---- */

static void scenes_without_light_are_refused(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_box(&small, SMALL_LIGHT_NONE);
    for (int a = 0; a < ALGORITHMS; a++) {
        const job_t job = job_of(algorithms[a], "'mutations_per_pixel':1", "");
        plan_t *plan;
        fault_t fault = {0};
        assert_int_equal(plan_new(&plan, &job, &small.scene, &fault), FAULT_NO_LIGHT);
        assert_null(plan);
        assert_non_null(strstr(fault.text, "the scene has no light"));
    }
    small_scene_clear(&small);
}

static void a_camera_that_sees_no_light_is_told_so(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_box(&small, SMALL_LIGHT_HIDDEN);
    for (int a = 0; a < ALGORITHMS; a++) {
        const job_t job = job_of(algorithms[a], "'mutations_per_pixel':1", "");
        plan_worker_t worker;
        plan_worker_make(&worker, &job, &small.scene);
        plan_t *plan = plan_fixture_new(&job, &small.scene);
        fault_code_t code = FAULT_NONE;
        fault_t fault = {0};
        while (!code) {
            const work_record_t *record;
            uint64_t unit;
            size_t size;
            plan_absorbed_t how;
            assert_true(plan_next(plan, &unit, &record));
            uint8_t *data = plan_worker_run(&worker, record, &size);
            code = plan_absorb(plan, unit, data, size, &how, &fault);
            assert_int_equal(how, PLAN_MERGED);
            free(data);
        }
        assert_int_equal(code, FAULT_NO_LIGHT);
        assert_non_null(strstr(fault.text, "no light reaches the camera"));
        assert_non_null(strstr(fault.text, "1 to 5"));
        assert_true(plan_finished(plan));
        uint64_t unit;
        const work_record_t *record;
        assert_false(plan_next(plan, &unit, &record));
        plan_destroy(&plan);
        plan_worker_clear(&worker);
    }
    small_scene_clear(&small);
}

/* ---- the scale of it all ---- */

/* In a furnace every pixel is emission * (1 + albedo + ... + albedo^4). Chains: the image's mean is the sum of b_k
 * over the pixels, whose errors the report tells; samples: their estimate of the error of each pixel. 6 standard
 * errors: a false alarm in 2e-9 each. */
static void a_furnace_is_as_bright_as_it_must_be(void **state)
{
    (void)state;
    small_scene_t furnace;
    small_scene_furnace(&furnace, 0.5, 3);
    const double wanted = 3 * (1 + 0.5 + 0.25 + 0.125 + 0.0625);
    for (int a = 0; a < ALGORITHMS; a++) {
        const job_t job = job_of(algorithms[a], "'mutations_per_pixel':40", "");
        plan_worker_t worker;
        plan_worker_make(&worker, &job, &furnace.scene);
        plan_t *plan = plan_fixture_new(&job, &furnace.scene);
        plan_fixture_run(plan, &worker, 0);
        plan_pixels_t pixels;
        plan_pixels_init(&pixels, plan);
        double mean = 0, variance = 0, value[3], part[3];
        for (size_t p = 0; p < plan->pixels; p++) {
            plan_pixel(&pixels, p, value, part);
            mean += value[1] / (double)plan->pixels;
            variance += part[1] / (double)plan->pixels / (double)plan->pixels;
        }
        if (a == PSSMLT) { /* of lengths that were sampled together: the sum of their errors */
            double error;
            plan_length_b(plan, 0, &error);
            variance = error * error / (double)plan->pixels / (double)plan->pixels;
        }
        if (a == MMLT) {
            variance = 0;
            for (uint32_t k = 1; k <= 5; k++) {
                double error;
                plan_length_b(plan, k, &error);
                variance += error * error / (double)plan->pixels / (double)plan->pixels;
            }
        }
        if (!(fabs(mean - wanted) <= 6 * sqrt(variance) + 1e-9))
            fail_msg("%s: %.6f, expected %.6f +- %.6f", algorithms[a], mean, wanted, sqrt(variance));
        assert_true(sqrt(variance) < 0.02 * wanted);
        plan_destroy(&plan);
        plan_worker_clear(&worker);
    }
    small_scene_clear(&furnace);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(order_repetition_and_restarts_leave_no_trace),
        cmocka_unit_test(checkpoints_come_back_as_they_were),
        cmocka_unit_test(malformed_results_change_nothing),
        cmocka_unit_test(as_many_mutations_are_made_as_asked),
        cmocka_unit_test(units_cover_everything_once),
        cmocka_unit_test(a_rule_of_time_stops_once_there_is_an_image),
        cmocka_unit_test(the_first_rule_met_stops),
        cmocka_unit_test(a_rule_of_error_stops_when_it_is_met),
        cmocka_unit_test(scenes_without_light_are_refused),
        cmocka_unit_test(a_camera_that_sees_no_light_is_told_so),
        cmocka_unit_test(a_furnace_is_as_bright_as_it_must_be),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
