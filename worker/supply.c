#include "worker/supply.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"

enum {
    WINDOW = 4,       /* pieces of a bundle under way */
    KEPT_ENTRIES = 64 /* jobs remembered though no unit waits for them */
};

typedef struct entry {
    struct entry *next;
    uint64_t job;
    digest_t job_digest, bundle_digest; /* as WORK named them */
    source_t *source;                   /* null until the text has come */
    bool asked, failed;
    double asked_at;
    uint64_t used; /* supply's clock */
    fault_t fault;
} entry_t;

/* The bundle that is being fetched. */
typedef struct fetch {
    bool active;
    digest_t digest;
    cache_download_t *download; /* null until the first piece says how long it is */
    uint64_t total, requested;  /* requested: end of what has been asked for */
    double asked_at;            /* or answered */
} fetch_t;

struct supply {
    cache_t *cache;
    entry_t *entries;
    uint64_t clock;
    fetch_t fetch;
};

fault_code_t supply_new(supply_t **out, cache_t *cache, fault_t *fault)
{
    supply_t *supply = *out = calloc(1, sizeof *supply);
    if (!supply)
        return fault_set(fault, FAULT_MEMORY, "no memory for the list of jobs");
    supply->cache = cache;
    return FAULT_NONE;
}

static void remove_entry(entry_t **link)
{
    entry_t *entry = *link;
    *link = entry->next;
    source_release(&entry->source);
    free(entry);
}

void supply_destroy(supply_t **supply)
{
    supply_t *s = *supply;
    *supply = NULL;
    if (!s)
        return;
    while (s->entries)
        remove_entry(&s->entries);
    cache_download_abort(&s->fetch.download);
    free(s);
}

/* ---- what units need ---- */

static entry_t *find_entry(supply_t *supply, uint64_t job)
{
    for (entry_t *entry = supply->entries; entry; entry = entry->next)
        if (entry->job == job)
            return entry;
    return NULL;
}

/* Keeps the list short: removes the job longest unused beyond those kept, unless it has just been used. */
static void forget_oldest(supply_t *supply)
{
    entry_t **oldest = NULL;
    unsigned count = 0;
    for (entry_t **link = &supply->entries; *link; link = &(*link)->next) {
        count++;
        if (!oldest || (*link)->used < (*oldest)->used)
            oldest = link;
    }
    /* each waiting unit passes through supply_get in every round, so that a used entry is at most so old */
    if (count > KEPT_ENTRIES && (*oldest)->used + MESSAGE_MAX_LEASES < supply->clock)
        remove_entry(oldest);
}

static entry_t *add_entry(supply_t *supply, const held_t *held)
{
    entry_t *entry = calloc(1, sizeof *entry);
    if (!entry)
        return NULL;
    entry->job = held->lease.job;
    entry->job_digest = held->job_digest;
    entry->bundle_digest = held->bundle_digest;
    entry->used = supply->clock;
    entry->next = supply->entries;
    supply->entries = entry;
    forget_oldest(supply);
    return entry;
}

static void begin_fetch(supply_t *supply, const digest_t *digest)
{
    if (!supply->fetch.active)
        supply->fetch = (fetch_t){.active = true, .digest = *digest};
}

supply_state_t supply_get(supply_t *supply, const held_t *held, source_t **source, fault_t *fault)
{
    *source = NULL;
    entry_t *entry = find_entry(supply, held->lease.job);
    if (!entry)
        entry = add_entry(supply, held);
    if (!entry) {
        fault_set(fault, FAULT_MEMORY, "no memory for another job");
        return SUPPLY_FAILED;
    }
    entry->used = ++supply->clock;
    if (!digest_equal(&entry->job_digest, &held->job_digest) ||
        !digest_equal(&entry->bundle_digest, &held->bundle_digest)) {
        fault_set(fault, FAULT_FORMAT, "two units of job %llu name different texts or bundles",
                  (unsigned long long)held->lease.job);
        return SUPPLY_FAILED;
    }
    if (entry->failed) {
        *fault = entry->fault;
        return SUPPLY_FAILED;
    }
    if (!entry->source)
        return SUPPLY_PENDING;
    if (!cache_has(supply->cache, &entry->bundle_digest)) {
        begin_fetch(supply, &entry->bundle_digest);
        return SUPPLY_PENDING;
    }
    *source = entry->source;
    return SUPPLY_READY;
}

void supply_forget_failures(supply_t *supply)
{
    for (entry_t **link = &supply->entries; *link;)
        if ((*link)->failed)
            remove_entry(link);
        else
            link = &(*link)->next;
}

static void fail_entry(entry_t *entry, const fault_t *fault)
{
    entry->failed = true;
    entry->fault = *fault;
}

static void fail_fetch(supply_t *supply, const fault_t *fault)
{
    log_warn("bundle: %s", fault->text);
    for (entry_t *entry = supply->entries; entry; entry = entry->next)
        if (digest_equal(&entry->bundle_digest, &supply->fetch.digest))
            fail_entry(entry, fault);
    cache_download_abort(&supply->fetch.download);
    supply->fetch.active = false;
}

/* ---- requests ---- */

static uint64_t fetch_have(const fetch_t *fetch)
{
    return fetch->download ? cache_download_have(fetch->download) : 0;
}

/* Asks for further pieces; before the first answer for one alone. */
static void pump_fetch(fetch_t *fetch, transport_t *transport, double retry_seconds)
{
    const double now = clock_now();
    const uint64_t have = fetch_have(fetch);
    if (fetch->requested > have && now - fetch->asked_at > retry_seconds)
        fetch->requested = have;
    const uint64_t window = fetch->download ? (uint64_t)WINDOW * MESSAGE_MAX_CHUNK : MESSAGE_MAX_CHUNK;
    const uint64_t end = fetch->download ? fetch->total : MESSAGE_MAX_CHUNK;
    while (fetch->requested < end && fetch->requested < have + window) {
        message_t get = {.type = MESSAGE_BUNDLE_GET};
        get.bundle_get.digest = fetch->digest;
        get.bundle_get.offset = fetch->requested;
        get.bundle_get.length = MESSAGE_MAX_CHUNK;
        if (transport_send(transport, TRANSPORT_MASTER, &get, NULL))
            return;
        fetch->requested += MESSAGE_MAX_CHUNK;
        fetch->asked_at = now;
    }
}

void supply_pump(supply_t *supply, transport_t *transport, double retry_seconds)
{
    const double now = clock_now();
    for (entry_t *entry = supply->entries; entry; entry = entry->next) {
        if (entry->source || entry->failed || (entry->asked && now - entry->asked_at < retry_seconds))
            continue;
        message_t query = {.type = MESSAGE_JOB_QUERY};
        query.job.job = entry->job;
        if (transport_send(transport, TRANSPORT_MASTER, &query, NULL))
            return;
        entry->asked = true;
        entry->asked_at = now;
    }
    if (supply->fetch.active)
        pump_fetch(&supply->fetch, transport, retry_seconds);
}

void supply_restart(supply_t *supply)
{
    for (entry_t *entry = supply->entries; entry; entry = entry->next)
        entry->asked = false;
    supply->fetch.requested = fetch_have(&supply->fetch);
}

/* ---- answers ---- */

void supply_take_job(supply_t *supply, const message_job_data_t *data)
{
    entry_t *entry = find_entry(supply, data->job);
    if (!entry || entry->source || entry->failed)
        return;
    fault_t fault = {0};
    source_t *source;
    if (source_new(&source, data->text, &data->bundle_digest, &fault)) {
        fail_entry(entry, &fault);
    } else if (!digest_equal(source_digest(source), &entry->job_digest) ||
               !digest_equal(&data->bundle_digest, &entry->bundle_digest)) {
        fault_set(&fault, FAULT_FORMAT, "the text or bundle of job %llu is not the one its unit names",
                  (unsigned long long)data->job);
        source_release(&source);
        fail_entry(entry, &fault);
    } else {
        entry->source = source;
    }
}

static fault_code_t take_chunk(supply_t *supply, const message_chunk_t *chunk, fault_t *fault)
{
    fetch_t *fetch = &supply->fetch;
    if (!fetch->download) {
        TRY(cache_download_begin(&fetch->download, supply->cache, &fetch->digest, chunk->total, fault));
        fetch->total = chunk->total;
    }
    const bool last = chunk->offset + chunk->bytes.size == chunk->total;
    if (chunk->total != fetch->total || (!last && chunk->bytes.size != MESSAGE_MAX_CHUNK))
        return fault_set(fault, FAULT_PROTOCOL,
                         "a piece of %zu octets at %llu of a bundle of %llu (%llu at first): expected %d octets",
                         chunk->bytes.size, (unsigned long long)chunk->offset, (unsigned long long)chunk->total,
                         (unsigned long long)fetch->total, MESSAGE_MAX_CHUNK);
    TRY(cache_download_write(fetch->download, chunk->bytes.data, chunk->bytes.size, fault));
    fetch->asked_at = clock_now();
    if (!last)
        return FAULT_NONE;
    TRY(cache_download_finish(&fetch->download, fault));
    fetch->active = false;
    return FAULT_NONE;
}

void supply_take_chunk(supply_t *supply, const message_chunk_t *chunk)
{
    const fetch_t *fetch = &supply->fetch;
    if (!fetch->active || !digest_equal(&chunk->digest, &fetch->digest) || chunk->offset != fetch_have(fetch))
        return; /* of an earlier request that was sent twice */
    fault_t fault = {0};
    if (take_chunk(supply, chunk, &fault))
        fail_fetch(supply, &fault);
}

void supply_take_refusal(supply_t *supply, const message_refused_t *refused)
{
    fault_t fault = {0};
    const fault_code_t code = message_fault_code(refused->code);
    fault_set(&fault, code ? code : FAULT_PROTOCOL, "the master refused: %.900s", refused->text);
    if (refused->request == MESSAGE_BUNDLE_GET && supply->fetch.active)
        fail_fetch(supply, &fault);
    entry_t *entry = find_entry(supply, refused->job);
    if (refused->request == MESSAGE_JOB_QUERY && entry && !entry->source)
        fail_entry(entry, &fault);
}
