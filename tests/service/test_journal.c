/* The journal: whatever of it is left after a crash is replayed, no more and no less. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/file.h"
#include "base/random.h"
#include "master/journal.h"
#include "service/service_fixture.h"

enum { RECORDS = 5 };

static const size_t sizes[RECORDS] = {17, 0, 301, 1, 90};

static void fill(uint8_t *data, size_t size, uint64_t unit)
{
    for (size_t i = 0; i < size; i++)
        data[i] = (uint8_t)random_u64(unit, i);
}

typedef struct seen {
    size_t count;
} seen_t;

/* Each record must be the next one that was written. */
static fault_code_t check_record(void *context, uint64_t unit, double seconds, const uint8_t *data, size_t size,
                                 fault_t *fault)
{
    (void)fault;
    seen_t *seen = context;
    uint8_t expected[512];
    assert_true(seen->count < RECORDS);
    assert_int_equal(unit, 100 + seen->count);
    assert_true(seconds == 0.5 * (double)seen->count);
    assert_int_equal(size, sizes[seen->count]);
    fill(expected, size, unit);
    assert_memory_equal(data, expected, size);
    seen->count++;
    return FAULT_NONE;
}

static void append(journal_t *journal, size_t from, size_t to)
{
    fault_t fault = {0};
    for (size_t i = from; i < to; i++) {
        uint8_t data[512];
        fill(data, sizes[i], 100 + i);
        assert_int_equal(journal_append(journal, 100 + i, 0.5 * (double)i, data, sizes[i], &fault), FAULT_NONE);
    }
    assert_int_equal(journal_sync(journal, &fault), FAULT_NONE);
}

static journal_t *open_journal(const char *path, size_t *records, uint64_t *cut)
{
    journal_t *journal;
    seen_t seen = {0};
    fault_t fault = {0};
    if (journal_open(&journal, path, true, check_record, &seen, cut, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    *records = seen.count;
    return journal;
}

static void make_journal(const char *path, uint8_t **bytes, size_t *size)
{
    size_t records;
    fault_t fault = {0};
    unlink(path);
    journal_t *journal = open_journal(path, &records, NULL);
    assert_int_equal(records, 0);
    append(journal, 0, RECORDS);
    journal_close(&journal);
    assert_int_equal(file_read(path, 1 << 20, bytes, size, &fault), FAULT_NONE);
}

/* How many records end at or before the byte. */
static size_t whole_before(size_t byte)
{
    size_t end = 0, count = 0;
    while (count < RECORDS && (end += JOURNAL_HEADER_SIZE + sizes[count]) <= byte)
        count++;
    return count;
}

static size_t end_of(size_t records)
{
    size_t end = 0;
    for (size_t i = 0; i < records; i++)
        end += JOURNAL_HEADER_SIZE + sizes[i];
    return end;
}

static void what_is_written_is_replayed(void **state)
{
    (void)state;
    const char *path = fixture_path("journal");
    uint8_t *bytes;
    size_t size, records;
    make_journal(path, &bytes, &size);
    assert_int_equal(size, end_of(RECORDS));
    uint64_t cut = 1;
    journal_t *journal = open_journal(path, &records, &cut);
    assert_int_equal(records, RECORDS);
    assert_int_equal(cut, 0);
    assert_int_equal(journal_bytes(journal), size);
    journal_close(&journal);
    free(bytes);
}

static void a_tail_torn_at_any_byte_is_cut(void **state)
{
    (void)state;
    const char *path = fixture_path("journal");
    uint8_t *bytes;
    size_t size, records;
    make_journal(path, &bytes, &size);
    for (size_t length = 0; length <= size; length++) {
        fault_t fault = {0};
        assert_int_equal(file_write(path, bytes, length, &fault), FAULT_NONE);
        uint64_t cut = 0;
        journal_t *journal = open_journal(path, &records, &cut);
        assert_int_equal(records, whole_before(length));
        assert_int_equal(cut, length - end_of(records));
        append(journal, records, RECORDS); /* and one can go on from there */
        journal_close(&journal);
        uint8_t *again;
        size_t again_size;
        assert_int_equal(file_read(path, 1 << 20, &again, &again_size, &fault), FAULT_NONE);
        assert_int_equal(again_size, size);
        assert_memory_equal(again, bytes, size);
        free(again);
    }
    free(bytes);
}

static void a_flipped_bit_ends_the_replay_before_its_record(void **state)
{
    (void)state;
    const char *path = fixture_path("journal");
    uint8_t *bytes;
    size_t size, records;
    make_journal(path, &bytes, &size);
    for (size_t at = 0; at < size; at++) {
        fault_t fault = {0};
        bytes[at] ^= (uint8_t)(1u << (at % 8));
        assert_int_equal(file_write(path, bytes, size, &fault), FAULT_NONE);
        bytes[at] ^= (uint8_t)(1u << (at % 8));
        journal_t *journal = open_journal(path, &records, NULL);
        assert_int_equal(records, whole_before(at));
        journal_close(&journal);
    }
    free(bytes);
}

static void a_reset_empties_it(void **state)
{
    (void)state;
    const char *path = fixture_path("journal");
    fault_t fault = {0};
    size_t records;
    unlink(path);
    journal_t *journal = open_journal(path, &records, NULL);
    append(journal, 0, 3);
    assert_int_equal(journal_reset(journal, &fault), FAULT_NONE);
    assert_int_equal(journal_bytes(journal), 0);
    append(journal, 0, 2);
    journal_close(&journal);
    journal = open_journal(path, &records, NULL);
    assert_int_equal(records, 2);
    journal_close(&journal);
}

/* The limit on file sizes stands in for a full disk: a write stops half way. */
static void limit_files(rlim_t size)
{
    const struct rlimit limit = {size, RLIM_INFINITY};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static void a_full_disk_leaves_the_journal_as_it_was(void **state)
{
    (void)state;
    const char *path = fixture_path("journal");
    fault_t fault = {0};
    size_t records;
    signal(SIGXFSZ, SIG_IGN);
    unlink(path);
    journal_t *journal = open_journal(path, &records, NULL);
    append(journal, 0, 2);
    uint8_t data[512];
    fill(data, sizes[2], 102);
    for (rlim_t room = 0; room < JOURNAL_HEADER_SIZE + sizes[2]; room += 7) {
        limit_files(end_of(2) + room);
        assert_int_equal(journal_append(journal, 102, 1, data, sizes[2], &fault), FAULT_IO);
        limit_files(RLIM_INFINITY);
        assert_int_equal(journal_bytes(journal), end_of(2));
    }
    append(journal, 2, RECORDS);
    journal_close(&journal);
    journal = open_journal(path, &records, NULL);
    assert_int_equal(records, RECORDS);
    journal_close(&journal);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_is_replayed), cmocka_unit_test(a_tail_torn_at_any_byte_is_cut),
        cmocka_unit_test(a_flipped_bit_ends_the_replay_before_its_record), cmocka_unit_test(a_reset_empties_it),
        cmocka_unit_test(a_full_disk_leaves_the_journal_as_it_was)};
    return cmocka_run_group_tests(tests, fixture_setup, fixture_teardown);
}
