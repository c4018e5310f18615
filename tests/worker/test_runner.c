/* The pool of threads: one outcome a unit, cancellation, scenes opened once and bounded in number. */
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

#include "base/clock.h"
#include "worker/runner.h"
#include "worker/toy_engine.h"

enum { PATIENCE_MS = 10000, MAX_UNITS = 256 };

static toy_t toy;
static fault_t fault;

static void ok(fault_code_t code)
{
    if (code)
        fail_msg("code %d: %s", code, fault.text);
}

static runner_t *start(unsigned threads, unsigned open_scenes)
{
    const engine_t engine = toy_engine(&toy);
    runner_t *runner;
    ok(runner_new(&runner, &(runner_options_t){threads, open_scenes}, &engine, &fault));
    return runner;
}

static void stop(runner_t *runner)
{
    runner_destroy(&runner);
    assert_null(runner);
    assert_int_equal(atomic_load(&toy.opened), atomic_load(&toy.closed));
    assert_int_equal(atomic_load(&toy.spaces), 0);
}

static void submit(runner_t *runner, const char *text, message_lease_t lease, const void *record, size_t size)
{
    source_t *source;
    const digest_t bundle = {{1}};
    ok(source_new(&source, text, &bundle, &fault));
    ok(runner_submit(runner, &(runner_unit_t){lease, source, {record, size}}, &fault));
    source_release(&source);
}

static runner_outcome_t take(runner_t *runner)
{
    runner_outcome_t outcome;
    struct pollfd poller = {.fd = runner_wake_fd(runner), .events = POLLIN};
    while (!runner_take(runner, &outcome))
        if (poll(&poller, 1, PATIENCE_MS) <= 0)
            fail_msg("no outcome within %d ms", PATIENCE_MS);
    return outcome;
}

static void wait_for(const atomic_int *value, int wanted)
{
    const double end = clock_now() + 1e-3 * PATIENCE_MS;
    while (atomic_load(value) != wanted) {
        if (clock_now() > end)
            fail_msg("%d, expected %d", atomic_load(value), wanted);
        usleep(1000);
    }
}

static const char *text_of(unsigned i, char text[32])
{
    snprintf(text, 32, "job %u", i);
    return text;
}

static void every_unit_has_one_right_outcome(void **state)
{
    (void)state;
    runner_t *runner = start(3, 2);
    char text[32];
    for (unsigned i = 0; i < MAX_UNITS; i++) {
        const uint8_t record[] = {i % 7 == 6 ? 'f' : 'r', (uint8_t)(i % 5), (uint8_t)i};
        submit(runner, text_of(i % 3, text), (message_lease_t){1 + i % 3, i, 1000 + i}, record, sizeof record);
    }
    bool seen[MAX_UNITS] = {false};
    for (unsigned n = 0; n < MAX_UNITS; n++) {
        runner_outcome_t outcome = take(runner);
        const unsigned i = (unsigned)outcome.lease.unit;
        assert_true(i < MAX_UNITS && !seen[i]);
        seen[i] = true;
        assert_int_equal(outcome.lease.job, 1 + i % 3);
        assert_int_equal(outcome.lease.attempt, 1000 + i);
        const uint8_t record[] = {'r', (uint8_t)(i % 5), (uint8_t)i};
        if (i % 7 == 6) {
            assert_int_equal(outcome.fault.code, FAULT_RANGE);
            assert_null(outcome.result);
        } else {
            uint8_t *expected;
            size_t size;
            toy_expected(text_of(i % 3, text), record, sizeof record, &expected, &size);
            assert_int_equal(outcome.fault.code, FAULT_NONE);
            assert_int_equal(outcome.size, size);
            assert_memory_equal(outcome.result, expected, size);
            free(expected);
        }
        free(outcome.result);
    }
    runner_outcome_t none;
    assert_false(runner_take(runner, &none));
    stop(runner);
}

static void one_scene_is_opened_once_for_all_threads(void **state)
{
    (void)state;
    runner_t *runner = start(4, 4);
    for (unsigned i = 0; i < 40; i++) /* sources of equal content, not the same one */
        submit(runner, "job", (message_lease_t){1, i, 1}, "r\1", 2);
    for (unsigned i = 0; i < 40; i++)
        free(take(runner).result);
    assert_int_equal(atomic_load(&toy.opened), 1);
    assert_int_equal(runner_open_scenes(runner), 1);
    stop(runner);
}

static void open_scenes_are_bounded(void **state)
{
    (void)state;
    runner_t *runner = start(2, 2);
    char text[32];
    for (unsigned round = 0; round < 2; round++)
        for (unsigned i = 0; i < 12; i++) {
            submit(runner, text_of(i, text), (message_lease_t){1 + i, round, 1}, "r\1", 2);
            free(take(runner).result);
        }
    /* two kept, and at most one more in the hands of each thread */
    assert_in_range(atomic_load(&toy.most_open), 1, 4);
    assert_in_range(runner_open_scenes(runner), 1, 4);
    assert_true(atomic_load(&toy.opened) >= 12);
    stop(runner);
}

static void a_scene_that_fails_fails_its_units_only(void **state)
{
    (void)state;
    runner_t *runner = start(2, 2);
    for (unsigned i = 0; i < 10; i++)
        submit(runner, i % 2 ? "bad job" : "good job", (message_lease_t){1 + i % 2, i, 1}, "r\1", 2);
    for (unsigned i = 0; i < 10; i++) {
        runner_outcome_t outcome = take(runner);
        assert_int_equal(outcome.fault.code, outcome.lease.unit % 2 ? FAULT_FORMAT : FAULT_NONE);
        if (outcome.lease.unit % 2)
            assert_string_equal(outcome.fault.text, "toy scene is bad");
        free(outcome.result);
    }
    assert_int_equal(runner_open_scenes(runner), 1);
    stop(runner);
}

static void cancelling_a_job_ends_its_units(void **state)
{
    (void)state;
    runner_t *runner = start(2, 2);
    for (unsigned i = 0; i < 6; i++) /* two run, four wait */
        submit(runner, "job", (message_lease_t){7, i, 1}, "w", 1);
    submit(runner, "job", (message_lease_t){8, 0, 1}, "r\1", 2);
    wait_for(&toy.waiting, 2);
    runner_cancel(runner, 9); /* nobody's */
    runner_cancel(runner, 7);
    unsigned cancelled = 0, finished = 0;
    for (unsigned i = 0; i < 7; i++) {
        runner_outcome_t outcome = take(runner);
        cancelled += outcome.lease.job == 7 && outcome.fault.code == FAULT_CANCELLED && !outcome.result;
        finished += outcome.lease.job == 8 && outcome.fault.code == FAULT_NONE;
        free(outcome.result);
    }
    assert_int_equal(cancelled, 6);
    assert_int_equal(finished, 1);
    stop(runner);
}

static void destroying_does_not_wait_for_units(void **state)
{
    (void)state;
    runner_t *runner = start(2, 2);
    for (unsigned i = 0; i < 5; i++)
        submit(runner, "job", (message_lease_t){7, i, 1}, "w", 1);
    wait_for(&toy.waiting, 2);
    const double before = clock_now();
    stop(runner);
    assert_true(clock_now() - before < 1e-3 * PATIENCE_MS);
}

static void numbers_of_threads_are_checked(void **state)
{
    (void)state;
    const engine_t engine = toy_engine(&toy);
    const unsigned bad[] = {0, RUNNER_MAX_THREADS + 1};
    for (int i = 0; i < 2; i++) {
        runner_t *runner;
        assert_int_equal(runner_new(&runner, &(runner_options_t){bad[i], 0}, &engine, &fault), FAULT_RANGE);
        assert_null(runner);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_unit_has_one_right_outcome),
        cmocka_unit_test(one_scene_is_opened_once_for_all_threads),
        cmocka_unit_test(open_scenes_are_bounded),
        cmocka_unit_test(a_scene_that_fails_fails_its_units_only),
        cmocka_unit_test(cancelling_a_job_ends_its_units),
        cmocka_unit_test(destroying_does_not_wait_for_units),
        cmocka_unit_test(numbers_of_threads_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
