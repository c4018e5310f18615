/* The ledger: each rule by itself, then random calls against a plain list that knows the same rules. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "master/ledger.h"

static uint64_t issue(ledger_t *ledger, uint64_t unit, uint64_t worker, double now)
{
    uint64_t attempt = 0;
    fault_t fault = {0};
    assert_int_equal(ledger_issue(ledger, unit, worker, now, &attempt, &fault), FAULT_NONE);
    return attempt;
}

static void attempts_differ_and_grow(void **state)
{
    (void)state;
    ledger_t *ledger = ledger_new(1000, 10);
    assert_int_equal(issue(ledger, 5, 1, 0), 1000);
    assert_int_equal(issue(ledger, 6, 1, 0), 1001);
    assert_int_equal(issue(ledger, 5, 2, 0), 1002);
    ledger_destroy(&ledger);
    assert_null(ledger);
    ledger_destroy(&ledger);
}

static void a_unit_is_out_in_two_copies_at_most(void **state)
{
    (void)state;
    ledger_t *ledger = ledger_new(1, 10);
    uint64_t attempt;
    fault_t fault = {0};
    issue(ledger, 5, 1, 0);
    issue(ledger, 5, 2, 0);
    assert_int_equal(ledger_issue(ledger, 5, 3, 0, &attempt, &fault), FAULT_RANGE);
    assert_int_equal(ledger_leases(ledger), 2);
    assert_true(ledger_finish(ledger, 5));
    assert_int_equal(ledger_leases(ledger), 0);
    assert_false(ledger_finish(ledger, 5));
    ledger_destroy(&ledger);
}

static void an_expired_lease_makes_the_unit_lost(void **state)
{
    (void)state;
    ledger_t *ledger = ledger_new(1, 10);
    uint64_t unit = 0;
    const uint64_t attempt = issue(ledger, 7, 1, 100);
    assert_int_equal(ledger_expire(ledger, 109.9), 0);
    assert_false(ledger_next_lost(ledger, 2, 2, &unit));
    assert_true(ledger_renew(ledger, 7, attempt, 1, 109));
    assert_false(ledger_renew(ledger, 7, attempt, 2, 109)); /* another's lease */
    assert_false(ledger_renew(ledger, 7, attempt + 1, 1, 109));
    assert_int_equal(ledger_expire(ledger, 118.9), 0);
    assert_int_equal(ledger_expire(ledger, 119), 1);
    assert_true(ledger_next_lost(ledger, 2, 2, &unit));
    assert_int_equal(unit, 7);
    assert_int_equal(ledger_lost(ledger), 1);
    issue(ledger, 7, 2, 120);
    assert_int_equal(ledger_lost(ledger), 0);
    ledger_destroy(&ledger);
}

static void the_loss_of_one_copy_loses_nothing(void **state)
{
    (void)state;
    ledger_t *ledger = ledger_new(1, 10);
    uint64_t unit;
    issue(ledger, 7, 1, 0);
    issue(ledger, 7, 2, 0);
    assert_int_equal(ledger_drop_worker(ledger, 1), 1);
    assert_false(ledger_next_lost(ledger, 3, 3, &unit));
    assert_int_equal(ledger_drop_worker(ledger, 2), 1);
    assert_true(ledger_next_lost(ledger, 3, 3, &unit));
    ledger_destroy(&ledger);
}

static void a_heartbeat_that_does_not_name_a_lease_ends_it(void **state)
{
    (void)state;
    ledger_t *ledger = ledger_new(1, 60);
    const uint64_t kept = issue(ledger, 1, 9, 0);
    issue(ledger, 2, 9, 0);
    issue(ledger, 3, 9, 8); /* too young to be missed */
    issue(ledger, 4, 8, 0); /* another worker's */
    assert_true(ledger_renew(ledger, 1, kept, 9, 10));
    assert_int_equal(ledger_drop_unnamed(ledger, 9, 10, 6), 1);
    uint64_t unit = 0;
    assert_true(ledger_next_lost(ledger, 5, 1, &unit));
    assert_int_equal(unit, 2);
    assert_int_equal(ledger_leases(ledger), 3);
    ledger_destroy(&ledger);
}

static void a_failed_unit_goes_to_another_worker_if_there_is_one(void **state)
{
    (void)state;
    ledger_t *ledger = ledger_new(1, 10);
    uint64_t unit = 0;
    assert_int_equal(ledger_fail(ledger, 4, issue(ledger, 4, 1, 0)), 1);
    assert_false(ledger_next_lost(ledger, 1, 2, &unit));
    assert_true(ledger_next_lost(ledger, 2, 2, &unit));
    assert_true(ledger_next_lost(ledger, 1, 1, &unit)); /* nobody else */
    assert_int_equal(ledger_fail(ledger, 4, issue(ledger, 4, 2, 0)), 2);
    assert_true(ledger_next_lost(ledger, 1, 2, &unit)); /* it has failed with all there are */
    assert_false(ledger_next_lost(ledger, 1, 3, &unit));
    const uint64_t third = issue(ledger, 4, 3, 0);
    assert_int_equal(ledger_fail(ledger, 4, third), LEDGER_MAX_FAILURES);
    assert_int_equal(ledger_fail(ledger, 4, third), 0); /* no such attempt any more */
    ledger_destroy(&ledger);
}

static void a_returned_attempt_counts_as_no_failure(void **state)
{
    (void)state;
    ledger_t *ledger = ledger_new(1, 10);
    for (int i = 0; i < 10; i++)
        assert_true(ledger_return(ledger, 4, issue(ledger, 4, 1, 0)));
    assert_int_equal(ledger_fail(ledger, 4, issue(ledger, 4, 1, 0)), 1);
    ledger_destroy(&ledger);
}

static void the_straggler_is_the_one_that_is_out_longest(void **state)
{
    (void)state;
    ledger_t *ledger = ledger_new(1, 100);
    uint64_t unit = 0;
    issue(ledger, 1, 1, 5);
    issue(ledger, 2, 2, 3);
    issue(ledger, 3, 1, 4);
    assert_false(ledger_next_straggler(ledger, 3, 6, 4, &unit)); /* none is old enough */
    assert_true(ledger_next_straggler(ledger, 3, 10, 4, &unit));
    assert_int_equal(unit, 2);
    assert_true(ledger_next_straggler(ledger, 2, 10, 4, &unit)); /* not its own */
    assert_int_equal(unit, 3);
    issue(ledger, 2, 3, 10);
    assert_true(ledger_next_straggler(ledger, 3, 10, 4, &unit)); /* 2 is out twice */
    assert_int_equal(unit, 3);
    ledger_destroy(&ledger);
}

static void ages_are_measured_from_the_first_issue(void **state)
{
    (void)state;
    ledger_t *ledger = ledger_new(1, 100);
    assert_true(ledger_mean_age(ledger) == 0);
    issue(ledger, 1, 1, 5);
    issue(ledger, 1, 2, 8);
    ledger_note_age(ledger, 1, 10);
    assert_true(ledger_mean_age(ledger) == 5);
    ledger_note_age(ledger, 99, 10); /* not there: nothing */
    assert_true(ledger_mean_age(ledger) == 5);
    ledger_destroy(&ledger);
}

/* ---- random calls against a list ---- */

enum { UNITS = 600, WORKERS = 5, CALLS = 60000 };

typedef struct model_unit {
    bool known;
    uint64_t attempts[LEDGER_COPIES], workers[LEDGER_COPIES];
    double expires[LEDGER_COPIES];
} model_unit_t;

static model_unit_t model[UNITS];

static size_t model_leases(void)
{
    size_t count = 0;
    for (int u = 0; u < UNITS; u++)
        for (int i = 0; i < LEDGER_COPIES; i++)
            count += model[u].attempts[i] != 0;
    return count;
}

static size_t model_lost(uint64_t *first)
{
    size_t count = 0;
    for (int u = UNITS - 1; u >= 0; u--)
        if (model[u].known && !model[u].attempts[0] && !model[u].attempts[1]) {
            *first = (uint64_t)u;
            count++;
        }
    return count;
}

static void model_issue(ledger_t *ledger, uint64_t u, uint64_t worker, double now)
{
    uint64_t attempt = 0;
    fault_t fault = {0};
    const int copy = !model[u].attempts[0] ? 0 : !model[u].attempts[1] ? 1 : -1;
    const fault_code_t code = ledger_issue(ledger, u, worker, now, &attempt, &fault);
    assert_int_equal(code, copy < 0 ? FAULT_RANGE : FAULT_NONE);
    if (copy < 0)
        return;
    model[u].known = true;
    model[u].attempts[copy] = attempt;
    model[u].workers[copy] = worker;
    model[u].expires[copy] = now + 10;
}

static void model_end(uint64_t worker, double now)
{
    for (int u = 0; u < UNITS; u++)
        for (int i = 0; i < LEDGER_COPIES; i++)
            if (model[u].attempts[i] && (model[u].workers[i] == worker || model[u].expires[i] <= now))
                model[u].attempts[i] = 0;
}

static void random_calls_agree_with_a_list(void **state)
{
    (void)state;
    ledger_t *ledger = ledger_new(1, 10);
    memset(model, 0, sizeof model);
    double now = 0;
    for (uint64_t call = 0; call < CALLS; call++) {
        const uint64_t key = random_key(1, RANDOM_PURPOSE_TEST, 0, call);
        const uint64_t what = random_u64(key, 0) % 100, u = random_u64(key, 1) % UNITS;
        const uint64_t worker = 1 + random_u64(key, 2) % WORKERS;
        const int copy = (int)(random_u64(key, 3) % LEDGER_COPIES);
        const uint64_t attempt = model[u].attempts[copy];
        now += 0.01;
        if (what < 50) {
            model_issue(ledger, u, worker, now);
        } else if (what < 80) {
            assert_int_equal(ledger_finish(ledger, u), model[u].known);
            memset(&model[u], 0, sizeof model[u]);
        } else if (what < 90) {
            assert_int_equal(ledger_return(ledger, u, attempt), attempt != 0);
            model[u].attempts[copy] = 0;
        } else if (what < 97) {
            assert_int_equal(ledger_renew(ledger, u, attempt, model[u].workers[copy], now), attempt != 0);
            model[u].expires[copy] = now + 10;
        } else if (what < 98) {
            ledger_drop_worker(ledger, worker);
            model_end(worker, -1);
        } else {
            ledger_expire(ledger, now);
            model_end(0, now);
        }
        uint64_t unit = 0, first = 0;
        const size_t lost = model_lost(&first);
        assert_int_equal(ledger_leases(ledger), model_leases());
        assert_int_equal(ledger_lost(ledger), lost);
        assert_int_equal(ledger_next_lost(ledger, 0, WORKERS, &unit), lost > 0);
        assert_int_equal(unit, lost > 0 ? first : 0);
    }
    ledger_destroy(&ledger);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(attempts_differ_and_grow),
                                       cmocka_unit_test(a_unit_is_out_in_two_copies_at_most),
                                       cmocka_unit_test(an_expired_lease_makes_the_unit_lost),
                                       cmocka_unit_test(the_loss_of_one_copy_loses_nothing),
                                       cmocka_unit_test(a_heartbeat_that_does_not_name_a_lease_ends_it),
                                       cmocka_unit_test(a_failed_unit_goes_to_another_worker_if_there_is_one),
                                       cmocka_unit_test(a_returned_attempt_counts_as_no_failure),
                                       cmocka_unit_test(the_straggler_is_the_one_that_is_out_longest),
                                       cmocka_unit_test(ages_are_measured_from_the_first_issue),
                                       cmocka_unit_test(random_calls_agree_with_a_list)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
