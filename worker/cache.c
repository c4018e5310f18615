#include "worker/cache.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/file.h"
#include "base/log.h"

enum {
    PATH_SIZE = 4096,
    NAME_SIZE = DIGEST_TEXT_SIZE + 40,
    STALE_SECONDS = 86400 /* unfinished files older than this belong to a process that died */
};

struct cache {
    char folder[PATH_SIZE];
    bool is_private;
    uint64_t limit;
    pthread_mutex_t admitting; /* one check at a time: two of the same bundle would race for its name */
};

struct cache_download {
    cache_t *cache;
    digest_t digest;
    int file;
    uint64_t total, have;
};

/* ---- names ---- */

typedef enum stage { STAGE_PART, STAGE_UNCHECKED, STAGE_FINAL } stage_t;

static void path_of(const cache_t *cache, const digest_t *digest, stage_t stage, char path[PATH_SIZE + NAME_SIZE])
{
    char name[DIGEST_TEXT_SIZE];
    digest_print(digest, name);
    if (stage == STAGE_FINAL)
        snprintf(path, PATH_SIZE + NAME_SIZE, "%s/%s.bundle", cache->folder, name);
    else
        snprintf(path, PATH_SIZE + NAME_SIZE, "%s/%s.%ld.%s", cache->folder, name, (long)getpid(),
                 stage == STAGE_PART ? "part" : "unchecked");
}

static bool ends_with(const char *name, const char *end)
{
    const size_t length = strlen(name), tail = strlen(end);
    return length > tail && strcmp(name + length - tail, end) == 0;
}

/* A file that a cache made: a digest, then one of the endings. */
static bool is_unfinished(const char *name)
{
    return strspn(name, "0123456789abcdef") == DIGEST_TEXT_SIZE - 1 &&
           (ends_with(name, ".part") || ends_with(name, ".unchecked"));
}

static bool is_final(const char *name)
{
    return strspn(name, "0123456789abcdef") == DIGEST_TEXT_SIZE - 1 &&
           strcmp(name + DIGEST_TEXT_SIZE - 1, ".bundle") == 0;
}

/* ---- the folder ---- */

typedef struct folder_file {
    char name[NAME_SIZE];
    uint64_t size;
    struct timespec changed;
} folder_file_t;

/* The regular files that pass; the caller frees *files. An unreadable folder counts as empty. */
static size_t list_folder(const char *folder, bool (*passes)(const char *name), folder_file_t **files)
{
    size_t count = 0, room = 0;
    *files = NULL;
    DIR *directory = opendir(folder);
    if (!directory)
        return 0;
    for (struct dirent *entry; (entry = readdir(directory));) {
        struct stat info;
        if (strlen(entry->d_name) >= NAME_SIZE || !passes(entry->d_name) ||
            fstatat(dirfd(directory), entry->d_name, &info, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(info.st_mode))
            continue;
        if (count == room) {
            room = room ? 2 * room : 16;
            folder_file_t *more = realloc(*files, room * sizeof *more);
            if (!more)
                break;
            *files = more;
        }
        folder_file_t *file = &(*files)[count++];
        memcpy(file->name, entry->d_name, strlen(entry->d_name) + 1); /* its length has been checked */
        file->size = (uint64_t)info.st_size;
        file->changed = info.st_mtim;
    }
    closedir(directory);
    return count;
}

static void remove_file(const cache_t *cache, const char *name)
{
    char path[PATH_SIZE + NAME_SIZE];
    snprintf(path, sizeof path, "%s/%s", cache->folder, name);
    unlink(path);
}

static void remove_stale(const cache_t *cache)
{
    folder_file_t *files;
    const size_t count = list_folder(cache->folder, is_unfinished, &files);
    for (size_t i = 0; i < count; i++)
        if (files[i].changed.tv_sec + STALE_SECONDS < time(NULL))
            remove_file(cache, files[i].name);
    free(files);
}

static int by_age(const void *a, const void *b)
{
    const folder_file_t *x = a, *y = b;
    if (x->changed.tv_sec != y->changed.tv_sec)
        return x->changed.tv_sec < y->changed.tv_sec ? -1 : 1;
    return (x->changed.tv_nsec > y->changed.tv_nsec) - (x->changed.tv_nsec < y->changed.tv_nsec);
}

/* Removes the bundles longest unused until the rest fits; never the one that was just admitted. */
static void trim(const cache_t *cache, const digest_t *keep)
{
    char kept[DIGEST_TEXT_SIZE];
    digest_print(keep, kept);
    folder_file_t *files;
    const size_t count = list_folder(cache->folder, is_final, &files);
    uint64_t total = 0;
    for (size_t i = 0; i < count; i++)
        total += files[i].size;
    if (count)
        qsort(files, count, sizeof *files, by_age);
    for (size_t i = 0; i < count && total > cache->limit; i++) {
        if (strncmp(files[i].name, kept, DIGEST_TEXT_SIZE - 1) == 0)
            continue;
        remove_file(cache, files[i].name);
        total -= files[i].size;
    }
    free(files);
}

static fault_code_t make_private(cache_t *cache, fault_t *fault)
{
    const char *base = getenv("TMPDIR");
    const int length =
        snprintf(cache->folder, sizeof cache->folder, "%s/garland-worker-XXXXXX", base && *base ? base : "/tmp");
    if (length < 0 || (size_t)length >= sizeof cache->folder)
        return fault_set(fault, FAULT_LIMIT, "the temporary folder's path is too long");
    if (!mkdtemp(cache->folder))
        return fault_set(fault, FAULT_IO, "cannot make a temporary folder %s: %s", cache->folder, strerror(errno));
    cache->is_private = true;
    return FAULT_NONE;
}

static fault_code_t use_folder(cache_t *cache, const char *folder, fault_t *fault)
{
    const int length = snprintf(cache->folder, sizeof cache->folder, "%s", folder);
    if (length < 0 || (size_t)length >= sizeof cache->folder)
        return fault_set(fault, FAULT_LIMIT, "the cache folder's path is too long");
    TRY(file_make_folder(folder, fault));
    if (access(folder, W_OK | X_OK) != 0)
        return fault_set(fault, FAULT_IO, "cannot write to the cache folder %s: %s", folder, strerror(errno));
    remove_stale(cache);
    return FAULT_NONE;
}

fault_code_t cache_open(cache_t **out, const char *folder, uint64_t limit, fault_t *fault)
{
    *out = NULL;
    cache_t *cache = calloc(1, sizeof *cache);
    if (!cache)
        return fault_set(fault, FAULT_MEMORY, "no memory for the bundle cache");
    cache->limit = limit ? limit : CACHE_LIMIT_BYTES;
    const fault_code_t code = folder ? use_folder(cache, folder, fault) : make_private(cache, fault);
    if (code) {
        free(cache);
        return code;
    }
    pthread_mutex_init(&cache->admitting, NULL);
    *out = cache;
    return FAULT_NONE;
}

static bool is_ours(const char *name)
{
    return is_final(name) || is_unfinished(name);
}

void cache_close(cache_t **cache)
{
    cache_t *c = *cache;
    *cache = NULL;
    if (!c)
        return;
    if (c->is_private) {
        folder_file_t *files;
        const size_t count = list_folder(c->folder, is_ours, &files);
        for (size_t i = 0; i < count; i++)
            remove_file(c, files[i].name);
        free(files);
        rmdir(c->folder);
    }
    pthread_mutex_destroy(&c->admitting);
    free(c);
}

const char *cache_folder(const cache_t *cache)
{
    return cache->folder;
}

bool cache_has(cache_t *cache, const digest_t *digest)
{
    char path[PATH_SIZE + NAME_SIZE];
    path_of(cache, digest, STAGE_FINAL, path);
    if (access(path, R_OK) == 0)
        return true;
    path_of(cache, digest, STAGE_UNCHECKED, path);
    return access(path, R_OK) == 0;
}

/* ---- admission ---- */

/* Opens the file as the bundle of that digest; removes it if it is not. */
static fault_code_t open_checked(const char *path, const digest_t *digest, bundle_t **out, fault_t *fault)
{
    fault_code_t code = bundle_open(out, path, fault);
    if (code == FAULT_NONE && !digest_equal(bundle_digest(*out), digest)) {
        char expected[DIGEST_TEXT_SIZE], found[DIGEST_TEXT_SIZE];
        digest_print(digest, expected);
        digest_print(bundle_digest(*out), found);
        bundle_destroy(out);
        code = fault_set(fault, FAULT_FORMAT, "bundle %s: the content is that of %s", expected, found);
    }
    if (code) {
        *out = NULL;
        unlink(path);
    }
    return code;
}

static fault_code_t admit(cache_t *cache, const digest_t *digest, bundle_t **out, fault_t *fault)
{
    char final[PATH_SIZE + NAME_SIZE], unchecked[PATH_SIZE + NAME_SIZE];
    path_of(cache, digest, STAGE_FINAL, final);
    path_of(cache, digest, STAGE_UNCHECKED, unchecked);
    if (access(unchecked, R_OK) != 0) {
        TRY(open_checked(final, digest, out, fault));
        utimensat(AT_FDCWD, final, NULL, 0); /* used just now; a failure only makes it look older */
        return FAULT_NONE;
    }
    TRY(open_checked(unchecked, digest, out, fault));
    if (rename(unchecked, final) != 0) {
        bundle_destroy(out);
        return fault_set(fault, FAULT_IO, "cannot rename %s to %s: %s", unchecked, final, strerror(errno));
    }
    trim(cache, digest);
    return FAULT_NONE;
}

fault_code_t cache_admit(cache_t *cache, const digest_t *digest, bundle_t **out, fault_t *fault)
{
    *out = NULL;
    pthread_mutex_lock(&cache->admitting);
    const fault_code_t code = admit(cache, digest, out, fault);
    pthread_mutex_unlock(&cache->admitting);
    return code;
}

/* ---- downloads ---- */

fault_code_t cache_download_begin(cache_download_t **out, cache_t *cache, const digest_t *digest, uint64_t total,
                                  fault_t *fault)
{
    *out = NULL;
    char path[PATH_SIZE + NAME_SIZE];
    path_of(cache, digest, STAGE_PART, path);
    const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (file < 0)
        return fault_set(fault, FAULT_IO, "cannot make %s: %s", path, strerror(errno));
    cache_download_t *download = calloc(1, sizeof *download);
    if (!download) {
        close(file);
        unlink(path);
        return fault_set(fault, FAULT_MEMORY, "no memory for a download");
    }
    *download = (cache_download_t){.cache = cache, .digest = *digest, .file = file, .total = total};
    *out = download;
    return FAULT_NONE;
}

fault_code_t cache_download_write(cache_download_t *download, const void *data, size_t size, fault_t *fault)
{
    if (size > download->total - download->have)
        return fault_set(fault, FAULT_RANGE, "%zu octets at %llu end beyond the bundle's %llu", size,
                         (unsigned long long)download->have, (unsigned long long)download->total);
    const uint8_t *at = data;
    while (size > 0) {
        const ssize_t written = write(download->file, at, size);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return fault_set(fault, FAULT_IO, "cannot write a bundle to %s: %s", download->cache->folder,
                             strerror(errno));
        at += written;
        size -= (size_t)written;
        download->have += (uint64_t)written;
    }
    return FAULT_NONE;
}

uint64_t cache_download_have(const cache_download_t *download)
{
    return download->have;
}

fault_code_t cache_download_finish(cache_download_t **download, fault_t *fault)
{
    cache_download_t *d = *download;
    if (d->have != d->total) {
        const fault_code_t code = fault_set(fault, FAULT_FORMAT, "a bundle ended after %llu of %llu octets",
                                            (unsigned long long)d->have, (unsigned long long)d->total);
        cache_download_abort(download);
        return code;
    }
    char part[PATH_SIZE + NAME_SIZE], unchecked[PATH_SIZE + NAME_SIZE];
    path_of(d->cache, &d->digest, STAGE_PART, part);
    path_of(d->cache, &d->digest, STAGE_UNCHECKED, unchecked);
    const int closed = close(d->file);
    d->file = -1;
    if (closed != 0 || rename(part, unchecked) != 0) {
        const fault_code_t code = fault_set(fault, FAULT_IO, "cannot finish %s: %s", part, strerror(errno));
        cache_download_abort(download);
        return code;
    }
    free(d);
    *download = NULL;
    return FAULT_NONE;
}

void cache_download_abort(cache_download_t **download)
{
    cache_download_t *d = *download;
    *download = NULL;
    if (!d)
        return;
    if (d->file >= 0)
        close(d->file);
    char path[PATH_SIZE + NAME_SIZE];
    path_of(d->cache, &d->digest, STAGE_PART, path);
    unlink(path);
    free(d);
}
