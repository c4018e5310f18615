/* The bundle cache: nothing is used that is not what its name says, and nothing unfinished is left. */
#include <dirent.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <cmocka.h>

#include "base/file.h"
#include "scene/sample_scene.h"
#include "worker/cache.h"

static char folder[64];
static uint8_t *bytes;
static size_t size;
static digest_t digest;
static fault_t fault;

static void ok(fault_code_t code)
{
    if (code)
        fail_msg("code %d: %s", code, fault.text);
}

static int count_files(const char *path)
{
    int count = 0;
    DIR *directory = opendir(path);
    if (!directory)
        return -1;
    for (struct dirent *entry; (entry = readdir(directory));)
        count += entry->d_name[0] != '.';
    closedir(directory);
    return count;
}

static void download(cache_t *cache, const digest_t *name, const uint8_t *data, size_t length)
{
    cache_download_t *d;
    ok(cache_download_begin(&d, cache, name, length, &fault));
    for (size_t at = 0; at < length; at += 1000) {
        assert_int_equal(cache_download_have(d), at);
        assert_false(cache_has(cache, name));
        ok(cache_download_write(d, data + at, length - at < 1000 ? length - at : 1000, &fault));
    }
    ok(cache_download_finish(&d, &fault));
    assert_null(d);
    assert_true(cache_has(cache, name));
}

static void a_downloaded_bundle_is_opened(void **state)
{
    (void)state;
    cache_t *cache;
    ok(cache_open(&cache, folder, 0, &fault));
    assert_false(cache_has(cache, &digest));
    download(cache, &digest, bytes, size);
    for (int i = 0; i < 2; i++) { /* the second time under its final name */
        bundle_t *bundle;
        ok(cache_admit(cache, &digest, &bundle, &fault));
        size_t length;
        assert_memory_equal(bundle_bytes(bundle, &length), bytes, size);
        assert_int_equal(length, size);
        bundle_destroy(&bundle);
    }
    cache_close(&cache);
    ok(cache_open(&cache, folder, 0, &fault)); /* it stays for the next worker */
    assert_true(cache_has(cache, &digest));
    cache_close(&cache);
}

static void a_flipped_bit_is_found_and_the_file_removed(void **state)
{
    (void)state;
    cache_t *cache;
    ok(cache_open(&cache, folder, 0, &fault));
    uint8_t *damaged = malloc(size);
    memcpy(damaged, bytes, size);
    damaged[size / 2] ^= 1;
    download(cache, &digest, damaged, size);
    free(damaged);
    bundle_t *bundle;
    assert_int_not_equal(cache_admit(cache, &digest, &bundle, &fault), FAULT_NONE);
    assert_null(bundle);
    assert_false(cache_has(cache, &digest));
    assert_int_equal(count_files(folder), 0);
    cache_close(&cache);
}

static void damage_on_disk_is_found(void **state)
{
    (void)state;
    cache_t *cache;
    bundle_t *bundle;
    ok(cache_open(&cache, folder, 0, &fault));
    download(cache, &digest, bytes, size);
    ok(cache_admit(cache, &digest, &bundle, &fault));
    bundle_destroy(&bundle);
    char name[DIGEST_TEXT_SIZE], path[256];
    digest_print(&digest, name);
    snprintf(path, sizeof path, "%s/%s.bundle", folder, name);
    assert_int_equal(truncate(path, (off_t)size - 1), 0);
    assert_int_not_equal(cache_admit(cache, &digest, &bundle, &fault), FAULT_NONE);
    assert_false(cache_has(cache, &digest));
    cache_close(&cache);
}

static void another_bundle_under_the_name_is_refused(void **state)
{
    (void)state;
    cache_t *cache;
    bundle_t *bundle;
    digest_t other = digest;
    other.bytes[0] ^= 1;
    ok(cache_open(&cache, folder, 0, &fault));
    download(cache, &other, bytes, size);
    assert_int_equal(cache_admit(cache, &other, &bundle, &fault), FAULT_FORMAT);
    char name[DIGEST_TEXT_SIZE];
    digest_print(&digest, name);
    assert_non_null(strstr(fault.text, name));
    assert_false(cache_has(cache, &other));
    assert_int_equal(cache_admit(cache, &other, &bundle, &fault), FAULT_NOT_FOUND);
    cache_close(&cache);
}

static void unfinished_downloads_leave_nothing(void **state)
{
    (void)state;
    cache_t *cache;
    cache_download_t *d;
    ok(cache_open(&cache, folder, 0, &fault));
    ok(cache_download_begin(&d, cache, &digest, 10, &fault));
    ok(cache_download_write(d, "1234567", 7, &fault));
    assert_int_equal(cache_download_write(d, "8901", 4, &fault), FAULT_RANGE);
    assert_int_equal(cache_download_finish(&d, &fault), FAULT_FORMAT);
    assert_null(d);
    assert_int_equal(count_files(folder), 0);
    ok(cache_download_begin(&d, cache, &digest, 10, &fault));
    assert_int_equal(count_files(folder), 1);
    cache_download_abort(&d);
    cache_download_abort(&d);
    assert_int_equal(count_files(folder), 0);
    cache_close(&cache);
}

/* Files as other processes may have left them; only what is ours and stale goes. */
static void stale_parts_are_removed_and_others_kept(void **state)
{
    (void)state;
    char name[DIGEST_TEXT_SIZE], path[4][256];
    digest_print(&digest, name);
    snprintf(path[0], sizeof path[0], "%s/%s.1.part", folder, name);
    snprintf(path[1], sizeof path[1], "%s/%s.2.part", folder, name);
    snprintf(path[2], sizeof path[2], "%s/letter.part", folder);
    snprintf(path[3], sizeof path[3], "%s/%s.notes", folder, name);
    const struct timespec old[2] = {{time(NULL) - 200000, 0}, {time(NULL) - 200000, 0}};
    for (int i = 0; i < 4; i++) {
        ok(file_write(path[i], "x", 1, &fault));
        if (i != 1)
            assert_int_equal(utimensat(AT_FDCWD, path[i], old, 0), 0);
    }
    cache_t *cache;
    ok(cache_open(&cache, folder, 0, &fault));
    assert_false(file_exists(path[0]));
    for (int i = 1; i < 4; i++) {
        assert_true(file_exists(path[i]));
        unlink(path[i]);
    }
    cache_close(&cache);
}

static void the_oldest_bundles_make_room(void **state)
{
    (void)state;
    char path[3][256];
    for (int i = 0; i < 3; i++) {
        digest_t name = {{(uint8_t)(i + 1)}};
        char text[DIGEST_TEXT_SIZE];
        digest_print(&name, text);
        snprintf(path[i], sizeof path[i], "%s/%s.bundle", folder, text);
        ok(file_write(path[i], bytes, size, &fault));
        const struct timespec when[2] = {{1000000 + i, 0}, {1000000 + i, 0}};
        assert_int_equal(utimensat(AT_FDCWD, path[i], when, 0), 0);
    }
    cache_t *cache;
    bundle_t *bundle;
    ok(cache_open(&cache, folder, 2 * size + 1, &fault)); /* room for two */
    download(cache, &digest, bytes, size);
    ok(cache_admit(cache, &digest, &bundle, &fault));
    assert_false(file_exists(path[0]));
    assert_false(file_exists(path[1]));
    assert_true(file_exists(path[2]));
    assert_true(cache_has(cache, &digest));
    bundle_destroy(&bundle);
    cache_close(&cache);
}

static void a_private_folder_is_removed(void **state)
{
    (void)state;
    cache_t *cache;
    char path[256];
    ok(cache_open(&cache, NULL, 0, &fault));
    snprintf(path, sizeof path, "%s", cache_folder(cache));
    assert_int_equal(count_files(path), 0);
    download(cache, &digest, bytes, size);
    assert_int_equal(count_files(path), 1);
    cache_close(&cache);
    assert_int_equal(count_files(path), -1);
    assert_int_not_equal(cache_open(&cache, "/proc/no/such/folder", 0, &fault), FAULT_NONE);
    assert_non_null(strstr(fault.text, "/proc/no"));
    assert_null(cache);
}

static int fresh_folder(void **state)
{
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/garland-cache-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    DIR *directory = opendir(folder);
    for (struct dirent *entry; directory && (entry = readdir(directory));)
        if (entry->d_name[0] != '.')
            unlinkat(dirfd(directory), entry->d_name, 0);
    if (directory)
        closedir(directory);
    return rmdir(folder);
}

static int make_bundle(void **state)
{
    (void)state;
    scene_builder_t *builder = sample_scene_build(0);
    const scene_t scene = scene_builder_view(builder);
    const fault_code_t code = bundle_encode(&scene, &bytes, &size, &digest, &fault);
    scene_builder_destroy(&builder);
    return code ? -1 : 0;
}

static int free_bundle(void **state)
{
    (void)state;
    free(bytes);
    return 0;
}

#define CACHE_TEST(name) cmocka_unit_test_setup_teardown(name, fresh_folder, remove_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        CACHE_TEST(a_downloaded_bundle_is_opened),
        CACHE_TEST(a_flipped_bit_is_found_and_the_file_removed),
        CACHE_TEST(damage_on_disk_is_found),
        CACHE_TEST(another_bundle_under_the_name_is_refused),
        CACHE_TEST(unfinished_downloads_leave_nothing),
        CACHE_TEST(stale_parts_are_removed_and_others_kept),
        CACHE_TEST(the_oldest_bundles_make_room),
        CACHE_TEST(a_private_folder_is_removed),
    };
    return cmocka_run_group_tests(tests, make_bundle, free_bundle);
}
