#include "master/journal.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include "base/digest.h"
#include "base/wire.h"

static const char record_magic[4] = {'G', 'J', 'R', '1'};

struct journal {
    char *path;
    int file;
    bool sync, dirty;
    uint64_t bytes; /* of whole records */
};

/* Hash over what a record says: 16 bytes of header fields, then the digest of the bytes. */
static void checksum_of(digest_t *out, const uint8_t fields[16], const uint8_t *data, size_t size)
{
    digest_t inner;
    digest_of(&inner, data, size);
    uint8_t joined[16 + DIGEST_SIZE];
    memcpy(joined, fields, 16);
    memcpy(joined + 16, inner.bytes, DIGEST_SIZE);
    digest_of(out, joined, sizeof joined);
}

static void write_header(uint8_t header[JOURNAL_HEADER_SIZE], uint64_t unit, double seconds, const uint8_t *data,
                         size_t size)
{
    wire_writer_t out;
    wire_writer_init(&out, header, JOURNAL_HEADER_SIZE, "journal record", NULL);
    wire_put_raw(&out, record_magic, sizeof record_magic);
    wire_put_u32(&out, (uint32_t)size);
    wire_put_u64(&out, unit);
    wire_put_f64(&out, seconds);
    digest_t checksum;
    checksum_of(&checksum, header + 8, data, size);
    wire_put_digest(&out, &checksum);
}

static bool read_fully(int file, uint8_t *data, size_t size, uint64_t offset)
{
    size_t done = 0;
    while (done < size) {
        const ssize_t got = pread(file, data + done, size - done, (off_t)(offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return false;
        done += (size_t)got;
    }
    return true;
}

/* Replays the record at the journal's end of whole records; *whole is false if there is no further whole record. */
static fault_code_t replay_one(journal_t *journal, uint64_t file_size, uint8_t **buffer, size_t *capacity,
                               journal_replay_t replay, void *context, bool *whole, fault_t *fault)
{
    *whole = false;
    uint8_t header[JOURNAL_HEADER_SIZE];
    if (file_size - journal->bytes < sizeof header ||
        !read_fully(journal->file, header, sizeof header, journal->bytes))
        return FAULT_NONE;
    wire_reader_t in;
    wire_reader_init(&in, header, sizeof header, "journal record", NULL);
    const uint8_t *magic = wire_get_raw(&in, "magic", sizeof record_magic);
    const size_t size = wire_get_u32(&in, "length");
    const uint64_t unit = wire_get_u64(&in, "unit");
    const double seconds = wire_get_f64(&in, "seconds");
    digest_t expected, checksum;
    wire_get_digest(&in, "checksum", &expected);
    if (!magic || memcmp(magic, record_magic, sizeof record_magic) != 0 || size > JOURNAL_MAX_RECORD ||
        file_size - journal->bytes - sizeof header < size)
        return FAULT_NONE;
    if (size > *capacity) {
        uint8_t *grown = realloc(*buffer, size);
        if (!grown)
            return fault_set(fault, FAULT_MEMORY, "%s: no memory for a record of %zu bytes", journal->path, size);
        *buffer = grown;
        *capacity = size;
    }
    if (!read_fully(journal->file, *buffer, size, journal->bytes + sizeof header))
        return FAULT_NONE;
    checksum_of(&checksum, header + 8, *buffer, size);
    if (!digest_equal(&expected, &checksum))
        return FAULT_NONE;
    TRY(replay(context, unit, seconds, *buffer, size, fault));
    journal->bytes += sizeof header + size;
    *whole = true;
    return FAULT_NONE;
}

static fault_code_t replay_all(journal_t *journal, journal_replay_t replay, void *context, uint64_t *cut,
                               fault_t *fault)
{
    struct stat info;
    if (fstat(journal->file, &info) != 0)
        return fault_set(fault, FAULT_IO, "%s: %s", journal->path, strerror(errno));
    const uint64_t file_size = (uint64_t)info.st_size;
    uint8_t *buffer = malloc(4096);
    size_t capacity = buffer ? 4096 : 0;
    bool whole = true;
    fault_code_t code = FAULT_NONE;
    while (code == FAULT_NONE && whole)
        code = replay_one(journal, file_size, &buffer, &capacity, replay, context, &whole, fault);
    free(buffer);
    TRY(code);
    if (cut)
        *cut = file_size - journal->bytes;
    if (file_size > journal->bytes && ftruncate(journal->file, (off_t)journal->bytes) != 0)
        return fault_set(fault, FAULT_IO, "%s: cannot cut its torn tail: %s", journal->path, strerror(errno));
    return FAULT_NONE;
}

fault_code_t journal_open(journal_t **out, const char *path, bool sync, journal_replay_t replay, void *context,
                          uint64_t *cut, fault_t *fault)
{
    *out = NULL;
    journal_t *journal = calloc(1, sizeof *journal);
    if (!journal || !(journal->path = strdup(path))) {
        free(journal);
        return fault_set(fault, FAULT_MEMORY, "%s: no memory for a journal", path);
    }
    journal->sync = sync;
    journal->file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    fault_code_t code = FAULT_NONE;
    if (journal->file < 0)
        code = fault_set(fault, FAULT_IO, "%s: %s", path, strerror(errno));
    else
        code = replay_all(journal, replay, context, cut, fault);
    if (code != FAULT_NONE) {
        journal_close(&journal);
        return code;
    }
    *out = journal;
    return FAULT_NONE;
}

void journal_close(journal_t **journal)
{
    if (!*journal)
        return;
    if ((*journal)->file >= 0)
        close((*journal)->file);
    free((*journal)->path);
    free(*journal);
    *journal = NULL;
}

/* Writes both parts at an offset; false with errno set if not all of it went in. */
static bool write_parts(int file, struct iovec parts[2], uint64_t offset)
{
    size_t left = parts[0].iov_len + parts[1].iov_len;
    while (left > 0) {
        const ssize_t put = pwritev(file, parts, 2, (off_t)offset);
        if (put < 0 && errno == EINTR)
            continue;
        if (put < 0)
            return false;
        if (put == 0) {
            errno = ENOSPC;
            return false;
        }
        offset += (uint64_t)put;
        left -= (size_t)put;
        size_t gone = (size_t)put;
        for (int i = 0; i < 2; i++) {
            const size_t step = gone < parts[i].iov_len ? gone : parts[i].iov_len;
            parts[i].iov_base = (uint8_t *)parts[i].iov_base + step;
            parts[i].iov_len -= step;
            gone -= step;
        }
    }
    return true;
}

fault_code_t journal_append(journal_t *journal, uint64_t unit, double seconds, const uint8_t *data, size_t size,
                            fault_t *fault)
{
    if (size > JOURNAL_MAX_RECORD)
        return fault_set(fault, FAULT_LIMIT, "%s: a result of %zu bytes, at most %d expected", journal->path, size,
                         JOURNAL_MAX_RECORD);
    uint8_t header[JOURNAL_HEADER_SIZE];
    write_header(header, unit, seconds, data, size);
    union {
        const uint8_t *in;
        void *out;
    } bytes = {.in = data}; /* pwritev only reads it */
    struct iovec parts[2] = {{header, sizeof header}, {bytes.out, size}};
    if (!write_parts(journal->file, parts, journal->bytes)) {
        const int error = errno;
        if (ftruncate(journal->file, (off_t)journal->bytes) != 0)
            return fault_set(fault, FAULT_IO, "%s: %s; and cannot cut the half-written record: %s", journal->path,
                             strerror(error), strerror(errno));
        return fault_set(fault, FAULT_IO, "%s: %s", journal->path, strerror(error));
    }
    journal->bytes += sizeof header + size;
    journal->dirty = true;
    return FAULT_NONE;
}

fault_code_t journal_sync(journal_t *journal, fault_t *fault)
{
    if (journal->dirty && journal->sync && fdatasync(journal->file) != 0)
        return fault_set(fault, FAULT_IO, "%s: cannot sync: %s", journal->path, strerror(errno));
    journal->dirty = false;
    return FAULT_NONE;
}

fault_code_t journal_reset(journal_t *journal, fault_t *fault)
{
    if (ftruncate(journal->file, 0) != 0 || (journal->sync && fdatasync(journal->file) != 0))
        return fault_set(fault, FAULT_IO, "%s: cannot empty it: %s", journal->path, strerror(errno));
    journal->bytes = 0;
    journal->dirty = false;
    return FAULT_NONE;
}

uint64_t journal_bytes(const journal_t *journal)
{
    return journal->bytes;
}

bool journal_is_dirty(const journal_t *journal)
{
    return journal->dirty;
}
