/* Meters of time: calls are counted, a share of them is timed, times add up. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <x86intrin.h>

#include <cmocka.h>

#include "base/clock.h"
#include "base/stamp.h"

enum { CALLS = 20000, SPIN = 3000 /* ticks */ };

static void spin(void)
{
    const uint64_t end = __rdtsc() + SPIN;
    while (__rdtsc() < end)
        ;
}

static void a_share_of_the_calls_is_timed(void **state)
{
    (void)state;
    stamp_meter_t meter = {0};
    stamp_watch_t watch;
    uint64_t timed = 0;
    stamp_begin(&meter, &watch);
    for (int i = 0; i < CALLS; i++) {
        const uint64_t from = stamp_enter(&meter);
        timed += from != 0;
        stamp_leave(&meter, from);
    }
    /* gaps are 32 to 95, whatever their law */
    assert_in_range(timed, CALLS / (STAMP_LEAST_GAP + STAMP_GAPS), 1 + CALLS / (STAMP_LEAST_GAP + 1));
    assert_true(meter.samples <= timed);
    assert_int_equal(meter.calls + (meter.gap - meter.left), CALLS);
}

/* Every call spins for so many ticks at least, so the estimate cannot be below them but by what is taken off for
 * the reading of the counter, a few tens of ticks of 3000; above it is the time of the whole, of which the calls
 * are half. */
static void calls_take_what_they_take(void **state)
{
    (void)state;
    stamp_meter_t meter = {0};
    stamp_watch_t watch;
    stamp_begin(&meter, &watch);
    for (int i = 0; i < CALLS; i++) {
        const uint64_t from = stamp_enter(&meter);
        spin();
        stamp_leave(&meter, from);
        spin();
    }
    const double estimate = stamp_seconds(&meter, &watch), wall = clock_now() - watch.wall,
                 ticks = (double)(__rdtsc() - watch.ticks), least = wall / ticks * SPIN * CALLS;
    assert_true(estimate >= 0.8 * least);
    assert_true(estimate <= wall);
}

static void what_never_happened_takes_no_time(void **state)
{
    (void)state;
    stamp_meter_t meter = {0};
    stamp_watch_t watch;
    stamp_begin(&meter, &watch);
    assert_true(stamp_seconds(&meter, &watch) == 0);
    stamp_leave(&meter, stamp_enter(&meter));
    stamp_begin(&meter, &watch); /* forgets */
    assert_true(stamp_seconds(&meter, &watch) == 0);
    stamp_leave(&meter, stamp_enter(&meter)); /* one that is not timed */
    assert_true(stamp_seconds(&meter, &watch) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_share_of_the_calls_is_timed),
        cmocka_unit_test(calls_take_what_they_take),
        cmocka_unit_test(what_never_happened_takes_no_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
