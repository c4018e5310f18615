/* The state folder: one master at a time, uploads piece by piece, files of jobs. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "master/store.h"
#include "service/service_fixture.h"

static store_t *open_store(void)
{
    store_t *store;
    fault_t fault = {0};
    if (store_open(&store, fixture_path("state"), true, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    return store;
}

static int clean(void **state)
{
    (void)state;
    fixture_remove("state");
    return 0;
}

static void a_second_master_is_refused(void **state)
{
    (void)state;
    store_t *store = open_store(), *second;
    fault_t fault = {0};
    assert_int_equal(store_open(&second, fixture_path("state"), true, &fault), FAULT_USAGE);
    assert_non_null(strstr(fault.text, "another master"));
    store_close(&store);
    store = open_store();
    store_close(&store);
}

static uint8_t *read_bundle(size_t *size)
{
    uint8_t *data;
    fault_t fault = {0};
    assert_int_equal(file_read(fixture_bundle, 1 << 24, &data, size, &fault), FAULT_NONE);
    return data;
}

static void a_bundle_arrives_piece_by_piece(void **state)
{
    (void)state;
    enum { PIECE = 1000 };
    store_t *store = open_store();
    fault_t fault = {0};
    size_t size;
    uint8_t *data = read_bundle(&size);
    uint64_t next = 0;
    for (size_t at = 0; at < size; at += PIECE) {
        const size_t length = size - at < PIECE ? size - at : PIECE;
        assert_false(store_has_bundle(store, &fixture_digest));
        assert_int_equal(store_bundle_part(store, &fixture_digest), at);
        assert_int_equal(store_put_bundle(store, &fixture_digest, size, at, data + at, length, &next, &fault),
                         FAULT_NONE);
        assert_int_equal(next, at + length);
        if (at == PIECE) { /* the same again, as after a lost answer; and one too far ahead */
            assert_int_equal(store_put_bundle(store, &fixture_digest, size, at, data + at, length, &next, &fault),
                             FAULT_NONE);
            assert_int_equal(next, at + length);
            assert_int_equal(store_put_bundle(store, &fixture_digest, size, at + 5 * PIECE, data, 1, &next, &fault),
                             FAULT_RANGE);
        }
        if (at == 2 * PIECE) { /* a restart in between */
            store_close(&store);
            store = open_store();
        }
    }
    assert_true(store_has_bundle(store, &fixture_digest));
    assert_int_equal(store_put_bundle(store, &fixture_digest, size, 0, data, 10, &next, &fault), FAULT_NONE);
    assert_int_equal(next, size);
    free(data);
    store_close(&store);
}

static void a_bundle_of_other_content_is_removed(void **state)
{
    (void)state;
    store_t *store = open_store();
    fault_t fault = {0};
    size_t size;
    uint64_t next;
    uint8_t *data = read_bundle(&size);
    digest_t wrong = fixture_digest;
    wrong.bytes[3] ^= 1;
    assert_int_not_equal(store_put_bundle(store, &wrong, size, 0, data, size, &next, &fault), FAULT_NONE);
    assert_non_null(strstr(fault.text, "digest"));
    assert_false(store_has_bundle(store, &wrong));
    data[size / 2] ^= 4;
    assert_int_not_equal(store_put_bundle(store, &fixture_digest, size, 0, data, size, &next, &fault), FAULT_NONE);
    assert_false(store_has_bundle(store, &fixture_digest));
    assert_int_equal(store_bundle_part(store, &fixture_digest), 0);
    data[size / 2] ^= 4;
    assert_int_equal(store_put_bundle(store, &fixture_digest, size, 0, data, size, &next, &fault), FAULT_NONE);
    assert_true(store_has_bundle(store, &fixture_digest));
    free(data);
    store_close(&store);
}

static void jobs_are_listed_and_removed(void **state)
{
    (void)state;
    store_t *store = open_store();
    fault_t fault = {0};
    const uint64_t numbers[] = {7, 281474976710655, 12};
    uint64_t *ids, sum = 0;
    size_t count;
    for (int i = 0; i < 3; i++) {
        assert_int_equal(store_make_job(store, numbers[i], &fault), FAULT_NONE);
        assert_int_equal(store_write(store, numbers[i], "job.json", "{}", 2, &fault), FAULT_NONE);
    }
    assert_int_equal(store_make_job(store, 7, &fault), FAULT_IO);
    assert_int_equal(file_make_folder(fixture_path("state/jobs/no number"), &fault), FAULT_NONE);
    assert_int_equal(store_list_jobs(store, &ids, &count, &fault), FAULT_NONE);
    assert_int_equal(count, 3);
    for (size_t i = 0; i < count; i++)
        sum += ids[i];
    assert_int_equal(sum, numbers[0] + numbers[1] + numbers[2]);
    free(ids);
    store_remove_job(store, 7);
    assert_int_equal(store_list_jobs(store, &ids, &count, &fault), FAULT_NONE);
    assert_int_equal(count, 2);
    free(ids);
    store_close(&store);
}

static void pieces_of_files_stay_within_them(void **state)
{
    (void)state;
    store_t *store = open_store();
    fault_t fault = {0};
    char path[STORE_PATH_SIZE];
    uint8_t data[16];
    size_t got;
    uint64_t total, revision, later;
    assert_int_equal(store_make_job(store, 5, &fault), FAULT_NONE);
    assert_int_equal(store_job_path(store, 5, "image.exr", path, &fault), FAULT_NONE);
    assert_int_equal(store_read_piece(path, 0, data, 16, &got, &total, &revision, &fault), FAULT_NOT_FOUND);
    assert_int_equal(store_write(store, 5, "image.exr", "0123456789", 10, &fault), FAULT_NONE);
    assert_int_equal(store_read_piece(path, 7, data, 16, &got, &total, &revision, &fault), FAULT_NONE);
    assert_int_equal(got, 3);
    assert_int_equal(total, 10);
    assert_memory_equal(data, "789", 3);
    assert_int_equal(store_read_piece(path, 10, data, 16, &got, &total, &revision, &fault), FAULT_NONE);
    assert_int_equal(got, 0);
    assert_int_equal(store_read_piece(path, 11, data, 16, &got, &total, &revision, &fault), FAULT_RANGE);
    assert_int_equal(store_write(store, 5, "image.exr", "abcdefghij", 10, &fault), FAULT_NONE);
    assert_int_equal(store_read_piece(path, 0, data, 16, &got, &total, &later, &fault), FAULT_NONE);
    assert_true(later != revision);
    store_close(&store);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(a_second_master_is_refused, clean),
                                       cmocka_unit_test_teardown(a_bundle_arrives_piece_by_piece, clean),
                                       cmocka_unit_test_teardown(a_bundle_of_other_content_is_removed, clean),
                                       cmocka_unit_test_teardown(jobs_are_listed_and_removed, clean),
                                       cmocka_unit_test_teardown(pieces_of_files_stay_within_them, clean)};
    return cmocka_run_group_tests(tests, fixture_setup, fixture_teardown);
}
