#include "master/store.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/log.h"
#include "scene/bundle.h"

struct store {
    char *folder;
    int lock;
    bool sync;
};

static fault_code_t path_of(char out[STORE_PATH_SIZE], fault_t *fault, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static fault_code_t path_of(char out[STORE_PATH_SIZE], fault_t *fault, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    const int length = vsnprintf(out, STORE_PATH_SIZE, format, args);
    va_end(args);
    if (length < 0 || length >= STORE_PATH_SIZE)
        return fault_set(fault, FAULT_LIMIT, "a path in the state folder exceeds %d bytes", STORE_PATH_SIZE - 1);
    return FAULT_NONE;
}

static fault_code_t take_lock(store_t *store, fault_t *fault)
{
    char path[STORE_PATH_SIZE];
    TRY(path_of(path, fault, "%s/lock", store->folder));
    store->lock = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (store->lock < 0)
        return fault_set(fault, FAULT_IO, "%s: %s", path, strerror(errno));
    if (flock(store->lock, LOCK_EX | LOCK_NB) != 0)
        return fault_set(fault, FAULT_USAGE, "%s: another master uses this state folder", store->folder);
    return FAULT_NONE;
}

static fault_code_t make_folders(const store_t *store, fault_t *fault)
{
    char path[STORE_PATH_SIZE];
    TRY(file_make_folder(store->folder, fault));
    TRY(path_of(path, fault, "%s/bundles", store->folder));
    TRY(file_make_folder(path, fault));
    TRY(path_of(path, fault, "%s/jobs", store->folder));
    return file_make_folder(path, fault);
}

fault_code_t store_open(store_t **out, const char *folder, bool sync, fault_t *fault)
{
    *out = NULL;
    store_t *store = calloc(1, sizeof *store);
    if (!store || !(store->folder = strdup(folder))) {
        free(store);
        return fault_set(fault, FAULT_MEMORY, "%s: no memory for the store", folder);
    }
    store->lock = -1;
    store->sync = sync;
    fault_code_t code = make_folders(store, fault);
    if (code == FAULT_NONE)
        code = take_lock(store, fault);
    if (code != FAULT_NONE) {
        store_close(&store);
        return code;
    }
    *out = store;
    return FAULT_NONE;
}

void store_close(store_t **store)
{
    if (!*store)
        return;
    if ((*store)->lock >= 0)
        close((*store)->lock);
    free((*store)->folder);
    free(*store);
    *store = NULL;
}

const char *store_folder(const store_t *store)
{
    return store->folder;
}

bool store_syncs(const store_t *store)
{
    return store->sync;
}

/* ---- bundles ---- */

fault_code_t store_bundle_path(const store_t *store, const digest_t *digest, char out[STORE_PATH_SIZE],
                               fault_t *fault)
{
    char text[DIGEST_TEXT_SIZE];
    digest_print(digest, text);
    return path_of(out, fault, "%s/bundles/%s", store->folder, text);
}

static fault_code_t part_path(const store_t *store, const digest_t *digest, char out[STORE_PATH_SIZE],
                              fault_t *fault)
{
    char text[DIGEST_TEXT_SIZE];
    digest_print(digest, text);
    return path_of(out, fault, "%s/bundles/%s.part", store->folder, text);
}

bool store_has_bundle(const store_t *store, const digest_t *digest)
{
    char path[STORE_PATH_SIZE];
    return store_bundle_path(store, digest, path, NULL) == FAULT_NONE && file_exists(path);
}

uint64_t store_bundle_part(const store_t *store, const digest_t *digest)
{
    char path[STORE_PATH_SIZE];
    struct stat info;
    if (part_path(store, digest, path, NULL) != FAULT_NONE || stat(path, &info) != 0)
        return 0;
    return (uint64_t)info.st_size;
}

static fault_code_t write_all(int file, const char *path, const uint8_t *data, size_t size, uint64_t offset,
                              fault_t *fault)
{
    size_t done = 0;
    while (done < size) {
        const ssize_t put = pwrite(file, data + done, size - done, (off_t)(offset + done));
        if (put < 0 && errno == EINTR)
            continue;
        if (put <= 0) {
            const int error = put < 0 ? errno : ENOSPC;
            if (ftruncate(file, (off_t)offset) != 0)
                log_debug("%s: %s", path, strerror(errno));
            return fault_set(fault, FAULT_IO, "%s: %s", path, strerror(error));
        }
        done += (size_t)put;
    }
    return FAULT_NONE;
}

/* Checks a bundle that has arrived whole and gives it its name. */
static fault_code_t accept_bundle(const store_t *store, const digest_t *digest, const char *part, fault_t *fault)
{
    char path[STORE_PATH_SIZE];
    TRY(store_bundle_path(store, digest, path, fault));
    bundle_t *bundle = NULL;
    fault_code_t code = bundle_open(&bundle, part, fault);
    if (code == FAULT_NONE && !digest_equal(bundle_digest(bundle), digest))
        code = fault_set(fault, FAULT_FORMAT, "the bundle's digest is not the one that was announced");
    bundle_destroy(&bundle);
    if (code == FAULT_NONE && rename(part, path) != 0)
        code = fault_set(fault, FAULT_IO, "%s: %s", path, strerror(errno));
    if (code != FAULT_NONE)
        unlink(part);
    return code;
}

fault_code_t store_put_bundle(store_t *store, const digest_t *digest, uint64_t total, uint64_t offset,
                              const uint8_t *data, size_t size, uint64_t *next, fault_t *fault)
{
    if (store_has_bundle(store, digest)) {
        *next = total;
        return FAULT_NONE;
    }
    char part[STORE_PATH_SIZE];
    TRY(part_path(store, digest, part, fault));
    const uint64_t have = store_bundle_part(store, digest);
    if (offset > have || size > total || offset > total - size)
        return fault_set(fault, FAULT_RANGE, "bundle piece at %" PRIu64 ": expected one at %" PRIu64, offset, have);
    if (have > total) {
        unlink(part);
        return fault_set(fault, FAULT_FORMAT, "bundle of %" PRIu64 " bytes: more had arrived before", total);
    }
    if (offset + size > have) {
        const int file = open(part, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
        if (file < 0)
            return fault_set(fault, FAULT_IO, "%s: %s", part, strerror(errno));
        const size_t known = (size_t)(have - offset);
        fault_code_t code = write_all(file, part, data + known, size - known, have, fault);
        if (code == FAULT_NONE && offset + size == total && store->sync && fdatasync(file) != 0)
            code = fault_set(fault, FAULT_IO, "%s: %s", part, strerror(errno));
        close(file);
        TRY(code);
    }
    *next = offset + size > have ? offset + size : have;
    return *next == total ? accept_bundle(store, digest, part, fault) : FAULT_NONE;
}

/* ---- jobs ---- */

fault_code_t store_job_path(const store_t *store, uint64_t job, const char *name, char out[STORE_PATH_SIZE],
                            fault_t *fault)
{
    return path_of(out, fault, "%s/jobs/%" PRIu64 "/%s", store->folder, job, name);
}

/* A folder's name as a job's id; 0 if it is none. */
static uint64_t id_of(const char *name)
{
    if (name[0] < '1' || name[0] > '9')
        return 0;
    char *end;
    errno = 0;
    const uint64_t id = strtoull(name, &end, 10);
    return *end == '\0' && errno == 0 ? id : 0;
}

fault_code_t store_list_jobs(const store_t *store, uint64_t **ids, size_t *count, fault_t *fault)
{
    *ids = NULL;
    *count = 0;
    char path[STORE_PATH_SIZE];
    TRY(path_of(path, fault, "%s/jobs", store->folder));
    DIR *folder = opendir(path);
    if (!folder)
        return fault_set(fault, FAULT_IO, "%s: %s", path, strerror(errno));
    size_t capacity = 0;
    fault_code_t code = FAULT_NONE;
    for (struct dirent *entry; code == FAULT_NONE && (entry = readdir(folder));) {
        const uint64_t id = id_of(entry->d_name);
        if (id == 0)
            continue;
        if (*count == capacity) {
            capacity = capacity ? 2 * capacity : 64;
            uint64_t *grown = realloc(*ids, capacity * sizeof **ids);
            if (!grown) {
                code = fault_set(fault, FAULT_MEMORY, "no memory for a list of %zu jobs", capacity);
                break;
            }
            *ids = grown;
        }
        (*ids)[(*count)++] = id;
    }
    closedir(folder);
    if (code != FAULT_NONE) {
        free(*ids);
        *ids = NULL;
        *count = 0;
    }
    return code;
}

fault_code_t store_make_job(store_t *store, uint64_t job, fault_t *fault)
{
    char path[STORE_PATH_SIZE];
    TRY(path_of(path, fault, "%s/jobs/%" PRIu64, store->folder, job));
    if (mkdir(path, 0777) != 0)
        return fault_set(fault, FAULT_IO, "%s: %s", path, strerror(errno));
    return FAULT_NONE;
}

void store_remove_job(store_t *store, uint64_t job)
{
    char path[STORE_PATH_SIZE], file[STORE_PATH_SIZE];
    if (path_of(path, NULL, "%s/jobs/%" PRIu64, store->folder, job) != FAULT_NONE)
        return;
    DIR *folder = opendir(path);
    for (struct dirent *entry; folder && (entry = readdir(folder));)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0 &&
            store_job_path(store, job, entry->d_name, file, NULL) == FAULT_NONE)
            unlink(file);
    if (folder)
        closedir(folder);
    if (rmdir(path) != 0)
        log_debug("%s: %s", path, strerror(errno));
}

fault_code_t store_write(const store_t *store, uint64_t job, const char *name, const void *data, size_t size,
                         fault_t *fault)
{
    char path[STORE_PATH_SIZE];
    TRY(store_job_path(store, job, name, path, fault));
    return file_write(path, data, size, fault);
}

fault_code_t store_read(const store_t *store, uint64_t job, const char *name, size_t limit, uint8_t **data,
                        size_t *size, fault_t *fault)
{
    char path[STORE_PATH_SIZE];
    TRY(store_job_path(store, job, name, path, fault));
    return file_read(path, limit, data, size, fault);
}

void store_remove(const store_t *store, uint64_t job, const char *name)
{
    char path[STORE_PATH_SIZE];
    if (store_job_path(store, job, name, path, NULL) == FAULT_NONE && unlink(path) != 0 && errno != ENOENT)
        log_debug("%s: %s", path, strerror(errno));
}

fault_code_t store_sync_job(const store_t *store, uint64_t job, fault_t *fault)
{
    if (!store->sync)
        return FAULT_NONE;
    char path[STORE_PATH_SIZE];
    TRY(path_of(path, fault, "%s/jobs/%" PRIu64, store->folder, job));
    const int folder = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0)
        return fault_set(fault, FAULT_IO, "%s: %s", path, strerror(errno));
    const int synced = fsync(folder), error = errno;
    close(folder);
    if (synced != 0)
        return fault_set(fault, FAULT_IO, "%s: %s", path, strerror(error));
    return FAULT_NONE;
}

/* ---- pieces of files ---- */

fault_code_t store_read_piece(const char *path, uint64_t offset, uint8_t *data, size_t size, size_t *got,
                              uint64_t *total, uint64_t *revision, fault_t *fault)
{
    *got = 0;
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return fault_set(fault, errno == ENOENT ? FAULT_NOT_FOUND : FAULT_IO, "%s: %s", path, strerror(errno));
    struct stat info;
    fault_code_t code = FAULT_NONE;
    if (fstat(file, &info) != 0)
        code = fault_set(fault, FAULT_IO, "%s: %s", path, strerror(errno));
    else if (offset > (uint64_t)info.st_size)
        code = fault_set(fault, FAULT_RANGE, "%s: offset %" PRIu64 " is beyond its %" PRIu64 " bytes", path, offset,
                         (uint64_t)info.st_size);
    else {
        *total = (uint64_t)info.st_size;
        *revision = (uint64_t)info.st_ino ^ ((uint64_t)info.st_mtim.tv_sec << 20) ^ (uint64_t)info.st_mtim.tv_nsec;
        while (code == FAULT_NONE && *got < size && offset + *got < *total) {
            const ssize_t step = pread(file, data + *got, size - *got, (off_t)(offset + *got));
            if (step < 0 && errno == EINTR)
                continue;
            if (step <= 0)
                code = fault_set(fault, FAULT_IO, "%s: %s", path, step < 0 ? strerror(errno) : "cut short");
            else
                *got += (size_t)step;
        }
    }
    close(file);
    return code;
}
