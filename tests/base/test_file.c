#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <dirent.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"

static char folder[] = "/tmp/garland-test-XXXXXX";

static const char *in_folder(const char *name)
{
    static char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int entries_in_folder(void)
{
    int count = 0;
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    while (readdir(dir))
        count++;
    closedir(dir);
    return count - 2; /* . and .. */
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char command[PATH_MAX];
    snprintf(command, sizeof command, "rm -r '%s'", folder);
    return system(command);
}

static void what_is_written_is_read(void **state)
{
    (void)state;
    enum { MOST = 3000000 };
    static const size_t sizes[] = {0, 1, 4095, 4096, MOST};
    uint8_t *data = malloc(MOST), *back = NULL;
    for (size_t i = 0; i < MOST; i++)
        data[i] = (uint8_t)(i * 2654435761u >> 13);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        size_t size = 99;
        fault_t fault = {0};
        assert_int_equal(file_write(in_folder("data"), data, sizes[i], &fault), FAULT_NONE);
        assert_int_equal(file_read(in_folder("data"), MOST, &back, &size, &fault), FAULT_NONE);
        assert_int_equal(size, sizes[i]);
        assert_memory_equal(back, data, size);
        assert_int_equal(back[size], 0);
        free(back);
        assert_int_equal(entries_in_folder(), 1);
    }
    free(data);
    unlink(in_folder("data"));
}

static void the_limit_is_exact(void **state)
{
    (void)state;
    uint8_t *data = NULL;
    size_t size = 0;
    fault_t fault = {0};
    assert_int_equal(file_write(in_folder("ten"), "0123456789", 10, &fault), FAULT_NONE);
    assert_int_equal(file_read(in_folder("ten"), 9, &data, &size, &fault), FAULT_LIMIT);
    assert_non_null(strstr(fault.text, "10 bytes"));
    assert_null(data);
    assert_int_equal(file_read(in_folder("ten"), 10, &data, &size, &fault), FAULT_NONE);
    free(data);
    unlink(in_folder("ten"));
}

static void what_cannot_be_read_says_why(void **state)
{
    (void)state;
    uint8_t *data = NULL;
    size_t size = 0;
    fault_t fault = {0};
    assert_int_equal(file_read(in_folder("absent"), 10, &data, &size, &fault), FAULT_NOT_FOUND);
    assert_non_null(strstr(fault.text, "absent"));
    assert_int_equal(file_read(folder, 10, &data, &size, &fault), FAULT_IO);
    assert_non_null(strstr(fault.text, "not a regular file"));
    assert_int_equal(mkfifo(in_folder("pipe"), 0600), 0);
    assert_int_equal(file_read(in_folder("pipe"), 10, &data, &size, &fault), FAULT_IO); /* and does not wait */
    unlink(in_folder("pipe"));
    assert_int_equal(file_read("/dev/zero", 10, &data, &size, &fault), FAULT_IO);
}

static void a_failed_write_leaves_nothing_behind(void **state)
{
    (void)state;
    fault_t fault = {0};
    assert_int_equal(file_write(in_folder("no/such/place"), "x", 1, &fault), FAULT_NOT_FOUND);
    assert_int_equal(mkdir(in_folder("taken"), 0700), 0);
    assert_int_equal(mkdir(in_folder("taken/inner"), 0700), 0);
    assert_int_equal(file_write(in_folder("taken"), "x", 1, &fault), FAULT_IO); /* a folder cannot be replaced */
    assert_non_null(strstr(fault.text, "cannot replace"));
    assert_int_equal(entries_in_folder(), 1);
    rmdir(in_folder("taken/inner"));
    rmdir(in_folder("taken"));
}

static void an_open_reader_keeps_the_old_content(void **state)
{
    (void)state;
    fault_t fault = {0};
    char text[8] = "";
    assert_int_equal(file_write(in_folder("live"), "before", 6, &fault), FAULT_NONE);
    FILE *reader = fopen(in_folder("live"), "rb");
    assert_non_null(reader);
    assert_int_equal(file_write(in_folder("live"), "after!", 6, &fault), FAULT_NONE);
    assert_int_equal(fread(text, 1, 6, reader), 6);
    assert_string_equal(text, "before");
    fclose(reader);
    unlink(in_folder("live"));
}

static void names_as_long_as_the_system_allows_can_be_written(void **state)
{
    (void)state;
    char name[NAME_MAX + 1];
    fault_t fault = {0};
    memset(name, 'n', NAME_MAX);
    name[NAME_MAX] = '\0';
    assert_int_equal(file_write(in_folder(name), "x", 1, &fault), FAULT_NONE);
    assert_true(file_exists(in_folder(name)));
    unlink(in_folder(name));
    assert_false(file_exists(in_folder(name)));
}

static void folders_are_made_with_their_parents(void **state)
{
    (void)state;
    fault_t fault = {0};
    struct stat info;
    assert_int_equal(file_make_folder(in_folder("a//b/c/"), &fault), FAULT_NONE);
    assert_int_equal(file_make_folder(in_folder("a/b/c"), &fault), FAULT_NONE); /* again */
    assert_int_equal(stat(in_folder("a/b/c"), &info), 0);
    assert_true(S_ISDIR(info.st_mode));
    assert_int_equal(file_write(in_folder("a/file"), "x", 1, &fault), FAULT_NONE);
    assert_int_equal(file_make_folder(in_folder("a/file/d"), &fault), FAULT_IO);
    assert_non_null(strstr(fault.text, "found a file"));
    assert_int_equal(file_make_folder("", &fault), FAULT_USAGE);
    assert_int_equal(file_make_folder("/", &fault), FAULT_NONE);
    unlink(in_folder("a/file"));
    rmdir(in_folder("a/b/c"));
    rmdir(in_folder("a/b"));
    rmdir(in_folder("a"));
}

static void paths_are_joined_and_split(void **state)
{
    (void)state;
    static const struct {
        const char *folder, *name, *joined;
    } joins[] = {{"a", "b", "a/b"}, {"a/", "b", "a/b"}, {"/", "b", "/b"}, {"", "b", "b"}, {"a", "/b", "/b"}};
    static const struct {
        const char *path, *folder;
    } splits[] = {{"b", "."}, {"a/b", "a"}, {"/b", "/"}, {"//b", "/"}, {"a//b", "a"}, {"a/b/", "a/b"}, {"", "."}};
    char out[8];
    fault_t fault = {0};
    for (size_t i = 0; i < sizeof joins / sizeof *joins; i++) {
        assert_int_equal(file_join(out, sizeof out, joins[i].folder, joins[i].name, &fault), FAULT_NONE);
        assert_string_equal(out, joins[i].joined);
    }
    for (size_t i = 0; i < sizeof splits / sizeof *splits; i++) {
        assert_int_equal(file_folder_of(out, sizeof out, splits[i].path, &fault), FAULT_NONE);
        assert_string_equal(out, splits[i].folder);
    }
    assert_int_equal(file_join(out, sizeof out, "abc", "def", &fault), FAULT_NONE); /* 7 characters fit */
    assert_int_equal(file_join(out, sizeof out, "abcd", "def", &fault), FAULT_LIMIT);
    assert_int_equal(file_folder_of(out, sizeof out, "abcdefg/x", &fault), FAULT_NONE);
    assert_int_equal(file_folder_of(out, sizeof out, "abcdefgh/x", &fault), FAULT_LIMIT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_is_read),
        cmocka_unit_test(the_limit_is_exact),
        cmocka_unit_test(what_cannot_be_read_says_why),
        cmocka_unit_test(a_failed_write_leaves_nothing_behind),
        cmocka_unit_test(an_open_reader_keeps_the_old_content),
        cmocka_unit_test(names_as_long_as_the_system_allows_can_be_written),
        cmocka_unit_test(folders_are_made_with_their_parents),
        cmocka_unit_test(paths_are_joined_and_split),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
