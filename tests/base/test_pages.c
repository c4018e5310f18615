/* Blocks of every size class: zeroed, writable to the last byte, aligned where huge pages are asked for; sizes that
 * cannot be had refused. */
#include "base/pages.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void blocks_are_zeroed_and_whole(void **state)
{
    (void)state;
    const size_t sizes[] = {0, 1, 4096, ((size_t)1 << 21) - 1, (size_t)1 << 21, ((size_t)5 << 20) + 3};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        uint8_t *block = pages_new(sizes[i], 1);
        assert_non_null(block);
        assert_int_equal((uintptr_t)block % 16, 0);
        if (sizes[i] >= (size_t)1 << 21)
            assert_int_equal((uintptr_t)block % ((size_t)1 << 21), 0);
        for (size_t j = 0; j < sizes[i]; j++)
            assert_int_equal(block[j], 0);
        memset(block, 255, sizes[i]);
        free(block);
    }
}

static void impossible_sizes_are_refused(void **state)
{
    (void)state;
    assert_null(pages_new(SIZE_MAX, 2));
    assert_null(pages_new(SIZE_MAX, 1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_zeroed_and_whole),
        cmocka_unit_test(impossible_sizes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
