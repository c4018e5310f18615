/* How many units a worker keeps at hand: by the time they take. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "worker/pace.h"

static unsigned ahead_of(double interval, int count)
{
    pace_t pace = {0};
    for (int i = 0; i <= count; i++)
        pace_note(&pace, 1000 + interval * i);
    return pace_ahead(&pace);
}

static void nothing_is_known_at_first(void **state)
{
    (void)state;
    assert_int_equal(ahead_of(0, 0), PACE_LEAST);
    assert_int_equal(ahead_of(0.001, 0), PACE_LEAST); /* one end is no interval */
}

static void a_tenth_of_a_second_is_at_hand(void **state)
{
    (void)state;
    assert_int_equal(ahead_of(2, 8), PACE_LEAST);
    assert_int_equal(ahead_of(0.016, 8), 6);
    assert_int_equal(ahead_of(0.001, 8), PACE_MOST);
}

/* One long unit makes it few, short ones after it many again. */
static void the_latest_count_for_most(void **state)
{
    (void)state;
    pace_t pace = {0};
    double now = 5;
    for (int i = 0; i < 8; i++)
        pace_note(&pace, now += 0.01);
    assert_true(pace_ahead(&pace) >= 9);
    pace_note(&pace, now += 2);
    assert_int_equal(pace_ahead(&pace), PACE_LEAST);
    for (int i = 0; i < 24; i++)
        pace_note(&pace, now += 0.01);
    assert_true(pace_ahead(&pace) >= 9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(nothing_is_known_at_first),
                                       cmocka_unit_test(a_tenth_of_a_second_is_at_hand),
                                       cmocka_unit_test(the_latest_count_for_most)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
