#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <string.h>

#include "base/fault.h"

static void a_fault_carries_code_and_sentence(void **state)
{
    (void)state;
    fault_t fault = {0};
    assert_int_equal(fault_set(&fault, FAULT_RANGE, "film.width: %d", -3), FAULT_RANGE);
    assert_int_equal(fault.code, FAULT_RANGE);
    assert_string_equal(fault.text, "film.width: -3");
}

static void a_null_fault_still_returns_the_code(void **state)
{
    (void)state;
    assert_int_equal(fault_set(NULL, FAULT_IO, "nobody reads this"), FAULT_IO);
}

static void prefixes_stack_from_the_inside_out(void **state)
{
    (void)state;
    fault_t fault = {0};
    fault_set(&fault, FAULT_SYNTAX, "expected ':'");
    fault_prefix(&fault, FAULT_SYNTAX, "line %d", 7);
    assert_int_equal(fault_prefix(&fault, FAULT_SYNTAX, "%s", "job.json"), FAULT_SYNTAX);
    assert_string_equal(fault.text, "job.json: line 7: expected ':'");
    assert_int_equal(fault.code, FAULT_SYNTAX);
}

static void a_prefix_passes_the_code_on_whoever_listens(void **state)
{
    (void)state;
    fault_t fault = {FAULT_NONE, "untouched"};
    assert_int_equal(fault_prefix(&fault, FAULT_NONE, "job.json"), FAULT_NONE);
    assert_string_equal(fault.text, "untouched");
    assert_int_equal(fault_prefix(NULL, FAULT_RANGE, "job.json"), FAULT_RANGE);
    assert_int_equal(fault_prefix(NULL, FAULT_NONE, "job.json"), FAULT_NONE);
}

static void long_texts_are_cut_not_overrun(void **state)
{
    (void)state;
    struct {
        fault_t fault;
        char guard[16];
    } box;
    char text[3 * FAULT_TEXT_SIZE];
    memset(&box, 'g', sizeof box);
    memset(text, 'x', sizeof text);
    text[sizeof text - 1] = '\0';
    fault_set(&box.fault, FAULT_IO, "%s", text);
    assert_int_equal(strlen(box.fault.text), FAULT_TEXT_SIZE - 1);
    fault_prefix(&box.fault, FAULT_IO, "outer");
    assert_int_equal(strlen(box.fault.text), FAULT_TEXT_SIZE - 1);
    assert_memory_equal(box.fault.text, "outer: xxx", 10);
    fault_prefix(&box.fault, FAULT_IO, "%s", text);
    assert_int_equal(strlen(box.fault.text), FAULT_TEXT_SIZE - 1);
    for (size_t i = 0; i < sizeof box.guard; i++)
        assert_int_equal(box.guard[i], 'g');
}

static void every_code_has_its_own_text(void **state)
{
    (void)state;
    for (int a = 0; a < FAULT_COUNT; a++)
        for (int b = 0; b < a; b++)
            assert_string_not_equal(fault_code_text((fault_code_t)a), fault_code_text((fault_code_t)b));
    assert_string_equal(fault_code_text(FAULT_COUNT), "unknown fault");
    assert_string_equal(fault_code_text((fault_code_t)-1), "unknown fault");
}

static fault_code_t fails_inside(int *reached)
{
    TRY(FAULT_NONE);
    (*reached)++;
    TRY(fault_set(NULL, FAULT_TYPE, "stop here"));
    (*reached)++;
    return FAULT_NONE;
}

static void try_returns_at_the_first_failure(void **state)
{
    (void)state;
    int reached = 0;
    assert_int_equal(fails_inside(&reached), FAULT_TYPE);
    assert_int_equal(reached, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_fault_carries_code_and_sentence),
        cmocka_unit_test(a_null_fault_still_returns_the_code),
        cmocka_unit_test(prefixes_stack_from_the_inside_out),
        cmocka_unit_test(a_prefix_passes_the_code_on_whoever_listens),
        cmocka_unit_test(long_texts_are_cut_not_overrun),
        cmocka_unit_test(every_code_has_its_own_text),
        cmocka_unit_test(try_returns_at_the_first_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
