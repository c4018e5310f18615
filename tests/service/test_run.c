/* A job in a master, without sockets: what is acknowledged survives, nothing is counted twice, and the image is the
 * one that the plan alone gives, bit for bit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/file.h"
#include "master/run.h"
#include "scene/bundle.h"
#include "service/service_fixture.h"

enum { WORKER = 9, MUTATIONS = 1000, JOB = 77 };

static bundle_t *bundle;
static renderer_t *renderer;
static digest_t expected;

static int setup(void **state)
{
    if (fixture_setup(state) != 0)
        return -1;
    fixture_direct(fixture_job(MUTATIONS, 1), &expected);
    fixture_renderer(&bundle, &renderer);
    return 0;
}

static int teardown(void **state)
{
    renderer_destroy(&renderer);
    bundle_destroy(&bundle);
    return fixture_teardown(state);
}

static int clean(void **state)
{
    (void)state;
    fixture_remove("state");
    return 0;
}

/* ---- a master of one job ---- */

typedef struct stage {
    store_t *store;
    run_t *run;
    size_t acknowledged, duplicates;
} stage_t;

static void acknowledge(void *context, uint64_t worker, const message_lease_t *lease, message_ack_t outcome)
{
    stage_t *stage = context;
    assert_int_equal(worker, WORKER);
    assert_int_equal(lease->job, JOB);
    stage->acknowledged += outcome == MESSAGE_ACK_MERGED;
    stage->duplicates += outcome == MESSAGE_ACK_DUPLICATE;
}

static void open_store(stage_t *stage)
{
    fault_t fault = {0};
    *stage = (stage_t){0};
    if (store_open(&stage->store, fixture_path("state"), true, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
}

static void await(stage_t *stage, run_state_t wanted)
{
    const double end = clock_now() + 60;
    while (run_get_state(stage->run) != wanted) {
        run_poll(stage->run, clock_now(), true);
        run_flush(stage->run, clock_now(), true, acknowledge, stage);
        if (run_has_ended(stage->run) && run_get_state(stage->run) != wanted)
            fail_msg("the job is %s: %s", run_state_name(run_get_state(stage->run)), run_failure(stage->run));
        if (clock_now() > end)
            fail_msg("the job is %s for a minute", run_state_name(run_get_state(stage->run)));
        usleep(1000);
    }
}

static void start(stage_t *stage)
{
    const run_options_t options = {.wake_fd = -1, .lease_seconds = 10, .first_attempt = 1};
    run_start(stage->run, &options);
    await(stage, RUN_RUNNING);
}

static void begin(stage_t *stage)
{
    fault_t fault = {0};
    uint64_t next;
    size_t size;
    const uint8_t *data = bundle_bytes(bundle, &size);
    open_store(stage);
    assert_int_equal(store_put_bundle(stage->store, &fixture_digest, size, 0, data, size, &next, &fault),
                     FAULT_NONE);
    if (run_new(&stage->run, stage->store, JOB, fixture_job(MUTATIONS, 1), &fixture_digest, 1, &fault) !=
        FAULT_NONE)
        fail_msg("%s", fault.text);
    start(stage);
}

/* As a crash would: nothing is saved. */
static void drop(stage_t *stage)
{
    run_destroy(&stage->run);
    store_close(&stage->store);
}

static void restart(stage_t *stage)
{
    fault_t fault = {0};
    open_store(stage);
    if (run_load(&stage->run, stage->store, JOB, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    start(stage);
}

/* Takes a unit and renders it; false if none is to be had. */
static bool take(stage_t *stage, message_lease_t *lease, uint8_t **data, size_t *size)
{
    const work_record_t *record;
    if (!run_issue(stage->run, WORKER, 1, clock_now(), lease, &record))
        return false;
    fixture_run_unit(renderer, record, data, size);
    return true;
}

static bool deliver(stage_t *stage, const message_lease_t *lease, const uint8_t *data, size_t size)
{
    bool merged, later;
    message_ack_t outcome;
    fault_t fault = {0};
    if (run_absorb(stage->run, WORKER, lease, data, size, clock_now(), &merged, &later, &outcome, &fault) !=
        FAULT_NONE)
        fail_msg("%s", fault.text);
    assert_true(later);
    return merged;
}

static size_t work(stage_t *stage, size_t units)
{
    size_t done = 0;
    for (; done < units; done++) {
        message_lease_t lease;
        uint8_t *data;
        size_t size;
        if (!take(stage, &lease, &data, &size))
            break;
        assert_true(deliver(stage, &lease, data, size));
        free(data);
    }
    return done;
}

static void finish(stage_t *stage)
{
    work(stage, SIZE_MAX);
    await(stage, RUN_DONE);
    digest_t pixels;
    char path[STORE_PATH_SIZE];
    fault_t fault = {0};
    assert_int_equal(store_job_path(stage->store, JOB, "image.exr", path, &fault), FAULT_NONE);
    fixture_pixels(path, &pixels);
    assert_true(digest_equal(&pixels, &expected));
    assert_true(file_exists(fixture_path("state/jobs/77/preview.png")));
    assert_true(file_exists(fixture_path("state/jobs/77/report.json")));
    assert_false(file_exists(fixture_path("state/jobs/77/journal")));
    assert_false(file_exists(fixture_path("state/jobs/77/snapshot")));
    drop(stage);
}

/* ---- tests ---- */

static void the_image_is_the_plan_s_own(void **state)
{
    (void)state;
    stage_t stage;
    begin(&stage);
    finish(&stage);
}

static void an_ended_job_is_remembered(void **state)
{
    (void)state;
    stage_t stage;
    fault_t fault = {0};
    begin(&stage);
    finish(&stage);
    open_store(&stage);
    assert_int_equal(run_load(&stage.run, stage.store, JOB, &fault), FAULT_NONE);
    assert_int_equal(run_get_state(stage.run), RUN_DONE);
    drop(&stage);
}

static void acknowledged_results_survive_and_the_rest_is_done_again(void **state)
{
    (void)state;
    for (size_t units = 0; units < 28; units += 4) {
        stage_t stage;
        begin(&stage);
        const size_t done = work(&stage, units);
        run_flush(stage.run, clock_now(), true, acknowledge, &stage);
        assert_int_equal(stage.acknowledged, done);
        drop(&stage);
        restart(&stage);
        json_t *status = run_status(stage.run);
        assert_true(json_number(json_get(status, "units_in")) == (double)done);
        json_destroy(&status);
        finish(&stage);
        clean(state);
    }
}

static void a_checkpoint_and_what_came_after_it_make_the_whole(void **state)
{
    (void)state;
    stage_t stage;
    fault_t fault = {0};
    begin(&stage);
    work(&stage, 11);
    assert_int_equal(run_checkpoint(stage.run, &fault), FAULT_NONE);
    assert_true(file_exists(fixture_path("state/jobs/77/snapshot")));
    work(&stage, 13);
    drop(&stage);
    restart(&stage);
    work(&stage, 5);
    drop(&stage);
    restart(&stage);
    finish(&stage);
}

/* A crash between the snapshot and the emptying of the journal leaves results in both. */
static void results_in_both_snapshot_and_journal_count_once(void **state)
{
    (void)state;
    stage_t stage;
    fault_t fault = {0};
    uint8_t *journal;
    size_t size;
    begin(&stage);
    work(&stage, 20);
    run_flush(stage.run, clock_now(), true, acknowledge, &stage);
    assert_int_equal(store_read(stage.store, JOB, "journal", 1 << 28, &journal, &size, &fault), FAULT_NONE);
    assert_int_equal(run_checkpoint(stage.run, &fault), FAULT_NONE);
    assert_int_equal(store_write(stage.store, JOB, "journal", journal, size, &fault), FAULT_NONE);
    free(journal);
    drop(&stage);
    restart(&stage);
    finish(&stage);
}

static void a_late_result_from_before_a_restart_counts_once(void **state)
{
    (void)state;
    stage_t stage;
    message_lease_t lease;
    uint8_t *data;
    size_t size;
    begin(&stage);
    work(&stage, 3);
    assert_true(take(&stage, &lease, &data, &size));
    drop(&stage);
    restart(&stage);
    assert_true(deliver(&stage, &lease, data, size));
    assert_false(deliver(&stage, &lease, data, size));
    free(data);
    run_flush(stage.run, clock_now(), true, acknowledge, &stage);
    assert_int_equal(stage.acknowledged, 1);
    assert_int_equal(stage.duplicates, 1);
    finish(&stage);
}

static void damaged_results_fail_the_attempt_and_change_nothing(void **state)
{
    (void)state;
    stage_t stage;
    message_lease_t lease;
    uint8_t *data;
    size_t size;
    begin(&stage);
    for (int i = 0; i < LEDGER_MAX_FAILURES - 1; i++) {
        bool merged, later;
        message_ack_t outcome;
        fault_t fault = {0};
        assert_true(take(&stage, &lease, &data, &size));
        assert_int_not_equal(run_absorb(stage.run, WORKER, &lease, data, size - 1 - (size_t)i, clock_now(), &merged,
                                        &later, &outcome, &fault),
                             FAULT_NONE);
        assert_false(merged);
        assert_false(later);
        assert_int_equal(outcome, MESSAGE_ACK_UNKNOWN);
        free(data);
    }
    finish(&stage);
}

static void a_unit_that_fails_three_times_fails_the_job_with_its_words(void **state)
{
    (void)state;
    stage_t stage;
    fault_t fault = {0};
    begin(&stage);
    for (int i = 0; i < LEDGER_MAX_FAILURES; i++) {
        message_lease_t lease;
        const work_record_t *record;
        assert_int_equal(run_get_state(stage.run), RUN_RUNNING);
        assert_true(run_issue(stage.run, WORKER, 1, clock_now(), &lease, &record));
        assert_int_equal(lease.unit, 0); /* what failed comes before what is new */
        run_fail_attempt(stage.run, &lease, FAULT_RANGE, "the moon is in the way");
    }
    assert_int_equal(run_get_state(stage.run), RUN_FAILED);
    assert_non_null(strstr(run_failure(stage.run), "the moon is in the way"));
    drop(&stage);
    open_store(&stage);
    assert_int_equal(run_load(&stage.run, stage.store, JOB, &fault), FAULT_NONE);
    assert_int_equal(run_get_state(stage.run), RUN_FAILED);
    assert_non_null(strstr(run_failure(stage.run), "the moon is in the way"));
    drop(&stage);
}

static void limit_files(rlim_t size)
{
    const struct rlimit limit = {size, RLIM_INFINITY};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static void a_full_disk_delays_and_loses_nothing(void **state)
{
    (void)state;
    stage_t stage;
    message_lease_t leases[4];
    uint8_t *data[4];
    size_t sizes[4];
    begin(&stage);
    const size_t before = work(&stage, 12); /* past the pilot */
    run_flush(stage.run, clock_now(), true, acknowledge, &stage);
    assert_int_equal(stage.acknowledged, before);
    for (int i = 0; i < 4; i++)
        assert_true(take(&stage, &leases[i], &data[i], &sizes[i]));
    limit_files(100); /* less than any record */
    for (int i = 0; i < 4; i++) {
        assert_true(deliver(&stage, &leases[i], data[i], sizes[i]));
        free(data[i]);
    }
    const double wake = run_flush(stage.run, clock_now(), true, acknowledge, &stage);
    assert_true(isfinite(wake)); /* it will try again */
    assert_int_equal(stage.acknowledged, before);
    message_lease_t lease;
    const work_record_t *record;
    assert_false(run_issue(stage.run, WORKER, 1, clock_now(), &lease, &record));
    json_t *status = run_status(stage.run);
    assert_true(json_string(json_get(status, "trouble"))[0] != '\0');
    json_destroy(&status);
    limit_files(RLIM_INFINITY);
    assert_true(isinf(run_flush(stage.run, wake, false, acknowledge, &stage)));
    assert_int_equal(stage.acknowledged, before + 4);
    drop(&stage);
    restart(&stage);
    finish(&stage);
}

static void outputs_that_cannot_be_written_are_written_later(void **state)
{
    (void)state;
    stage_t stage;
    begin(&stage);
    work(&stage, SIZE_MAX);
    run_flush(stage.run, clock_now(), true, acknowledge, &stage);
    limit_files(100);
    run_poll(stage.run, clock_now(), true);
    for (int i = 0; i < 100; i++) {
        run_poll(stage.run, clock_now(), true);
        usleep(1000);
    }
    assert_int_equal(run_get_state(stage.run), RUN_FINISHING);
    limit_files(RLIM_INFINITY);
    finish(&stage);
}

static void a_cancelled_job_takes_no_more(void **state)
{
    (void)state;
    stage_t stage;
    message_lease_t lease;
    uint8_t *data;
    size_t size;
    bool merged, later;
    message_ack_t outcome;
    fault_t fault = {0};
    const work_record_t *record;
    begin(&stage);
    assert_true(take(&stage, &lease, &data, &size));
    run_cancel(stage.run);
    assert_int_equal(run_get_state(stage.run), RUN_CANCELLED);
    assert_int_equal(
        run_absorb(stage.run, WORKER, &lease, data, size, clock_now(), &merged, &later, &outcome, &fault),
        FAULT_NONE);
    assert_false(later);
    assert_int_equal(outcome, MESSAGE_ACK_UNKNOWN);
    assert_false(run_issue(stage.run, WORKER, 1, clock_now(), &lease, &record));
    free(data);
    drop(&stage);
}

int main(void)
{
    signal(SIGXFSZ, SIG_IGN);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(the_image_is_the_plan_s_own, clean),
        cmocka_unit_test_teardown(an_ended_job_is_remembered, clean),
        cmocka_unit_test_teardown(acknowledged_results_survive_and_the_rest_is_done_again, clean),
        cmocka_unit_test_teardown(a_checkpoint_and_what_came_after_it_make_the_whole, clean),
        cmocka_unit_test_teardown(results_in_both_snapshot_and_journal_count_once, clean),
        cmocka_unit_test_teardown(a_late_result_from_before_a_restart_counts_once, clean),
        cmocka_unit_test_teardown(damaged_results_fail_the_attempt_and_change_nothing, clean),
        cmocka_unit_test_teardown(a_unit_that_fails_three_times_fails_the_job_with_its_words, clean),
        cmocka_unit_test_teardown(a_full_disk_delays_and_loses_nothing, clean),
        cmocka_unit_test_teardown(outputs_that_cannot_be_written_are_written_later, clean),
        cmocka_unit_test_teardown(a_cancelled_job_takes_no_more, clean)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
