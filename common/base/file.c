#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static fault_code_t system_fault(fault_t *fault, const char *path, const char *deed)
{
    const int error = errno;
    char buffer[128];
    const fault_code_t code = error == ENOENT || error == ENOTDIR ? FAULT_NOT_FOUND : FAULT_IO;
    return fault_set(fault, code, "%s: cannot %s: %s", path, deed, strerror_r(error, buffer, sizeof buffer));
}

/* Reads until `size` bytes are there or the file ends; *got tells how many came. */
static bool read_all(int file, uint8_t *data, size_t size, size_t *got)
{
    *got = 0;
    while (*got < size) {
        const ssize_t n = read(file, data + *got, size - *got);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return false;
        if (n == 0)
            break;
        *got += (size_t)n;
    }
    return true;
}

static fault_code_t read_open_file(int file, const char *path, size_t limit, uint8_t **data, size_t *size,
                                   fault_t *fault)
{
    struct stat info;
    if (fstat(file, &info) != 0)
        return system_fault(fault, path, "examine");
    if (!S_ISREG(info.st_mode))
        return fault_set(fault, FAULT_IO, "%s: not a regular file", path);
    if ((uint64_t)info.st_size > limit)
        return fault_set(fault, FAULT_LIMIT, "%s: %lld bytes, more than the %zu allowed", path,
                         (long long)info.st_size, limit);
    const size_t expected = (size_t)info.st_size;
    uint8_t *bytes = malloc(expected + 1);
    if (!bytes)
        return fault_set(fault, FAULT_MEMORY, "%s: no memory for %zu bytes", path, expected);
    size_t got = 0;
    if (!read_all(file, bytes, expected, &got)) {
        free(bytes);
        return system_fault(fault, path, "read");
    }
    bytes[got] = 0;
    *data = bytes;
    *size = got;
    return FAULT_NONE;
}

fault_code_t file_read(const char *path, size_t limit, uint8_t **data, size_t *size, fault_t *fault)
{
    /* Not blocking: opening a pipe must not wait for its writer; regular files are not concerned. */
    const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0)
        return system_fault(fault, path, "open");
    const fault_code_t code = read_open_file(file, path, limit, data, size, fault);
    close(file);
    return code;
}

static bool write_all(int file, const uint8_t *data, size_t size)
{
    for (size_t done = 0; done < size;) {
        const ssize_t n = write(file, data + done, size - done);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return false;
        done += (size_t)n;
    }
    return true;
}

/* Creates a file of a new name in the folder; its name is short, so that it fits wherever the target's does. */
static int create_beside(char *name, size_t size, const char *folder)
{
    static atomic_uint counter;
    for (int attempt = 0; attempt < 1000; attempt++) {
        const unsigned number = atomic_fetch_add(&counter, 1);
        if (snprintf(name, size, "%s/.garland-%ld-%u", folder, (long)getpid(), number) >= (int)size) {
            errno = ENAMETOOLONG;
            return -1;
        }
        const int file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file >= 0 || errno != EEXIST)
            return file;
    }
    return -1;
}

/* The rename lasts only once the folder is on disk; file systems that cannot do it have their own guarantees. */
static void sync_folder(const char *folder)
{
    const int file = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file >= 0) {
        (void)fsync(file);
        close(file);
    }
}

fault_code_t file_write(const char *path, const void *data, size_t size, fault_t *fault)
{
    char folder[PATH_MAX], beside[PATH_MAX];
    TRY(file_folder_of(folder, sizeof folder, path, fault));
    const int file = create_beside(beside, sizeof beside, folder);
    if (file < 0)
        return system_fault(fault, path, "create a file beside it");
    fault_code_t code = FAULT_NONE;
    if (!write_all(file, data, size) || fsync(file) != 0)
        code = system_fault(fault, path, "write");
    if (close(file) != 0 && code == FAULT_NONE)
        code = system_fault(fault, path, "write");
    if (code == FAULT_NONE && rename(beside, path) != 0)
        code = system_fault(fault, path, "replace");
    if (code != FAULT_NONE) {
        unlink(beside);
        return code;
    }
    sync_folder(folder);
    return FAULT_NONE;
}

bool file_exists(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0;
}

static fault_code_t make_one_folder(const char *path, fault_t *fault)
{
    struct stat info;
    if (mkdir(path, 0777) == 0)
        return FAULT_NONE;
    const int error = errno;
    if (stat(path, &info) == 0) {
        if (S_ISDIR(info.st_mode))
            return FAULT_NONE;
        return fault_set(fault, FAULT_IO, "%s: expected a folder, found a file", path);
    }
    errno = error;
    return system_fault(fault, path, "make the folder");
}

fault_code_t file_make_folder(const char *path, fault_t *fault)
{
    char part[PATH_MAX];
    const size_t length = strlen(path);
    if (length == 0)
        return fault_set(fault, FAULT_USAGE, "a folder's path is empty");
    if (length >= sizeof part)
        return fault_set(fault, FAULT_LIMIT, "%.80s...: path of %zu bytes, more than %zu", path, length,
                         sizeof part - 1);
    for (size_t i = 1; i <= length; i++) {
        if ((path[i] != '/' && path[i] != '\0') || path[i - 1] == '/')
            continue;
        memcpy(part, path, i);
        part[i] = '\0';
        TRY(make_one_folder(part, fault));
    }
    return FAULT_NONE;
}

static fault_code_t path_too_long(const char *path, size_t size, fault_t *fault)
{
    return fault_set(fault, FAULT_LIMIT, "%.80s...: the path does not fit into %zu bytes", path, size);
}

fault_code_t file_join(char *out, size_t size, const char *folder, const char *name, fault_t *fault)
{
    const size_t length = strlen(folder);
    const char *separator = length == 0 || folder[length - 1] == '/' ? "" : "/";
    const int written =
        name[0] == '/' ? snprintf(out, size, "%s", name) : snprintf(out, size, "%s%s%s", folder, separator, name);
    return written < 0 || (size_t)written >= size ? path_too_long(name, size, fault) : FAULT_NONE;
}

fault_code_t file_folder_of(char *out, size_t size, const char *path, fault_t *fault)
{
    const char *slash = strrchr(path, '/');
    const char *folder = slash ? path : ".";
    size_t length = slash ? (size_t)(slash - path) : 1;
    while (length > 1 && folder[length - 1] == '/') /* "a//b" */
        length--;
    if (length == 0) /* "/b" */
        length = 1;
    if (length >= size)
        return path_too_long(path, size, fault);
    memmove(out, folder, length);
    out[length] = '\0';
    return FAULT_NONE;
}
