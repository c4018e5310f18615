#include "master/ledger.h"

#include <stdlib.h>
#include <string.h>

typedef struct lease {
    uint64_t attempt; /* 0: none */
    uint64_t worker;
    double issued, renewed, expires;
} lease_t;

typedef struct entry {
    bool used;
    uint64_t unit;
    uint32_t failures;
    uint64_t failed_with[LEDGER_MAX_FAILURES]; /* workers */
    lease_t leases[LEDGER_COPIES];
} entry_t;

/* Open addressing with linear probing; capacity a power of two, at most half full. */
struct ledger {
    entry_t *entries;
    size_t capacity, used;
    size_t leases, lost;
    uint64_t next_attempt;
    double lease;
    double age_sum;
    uint64_t age_count;
};

enum { LEDGER_FIRST_CAPACITY = 256 };

ledger_t *ledger_new(uint64_t first_attempt, double lease)
{
    ledger_t *ledger = calloc(1, sizeof *ledger);
    if (!ledger)
        return NULL;
    ledger->entries = calloc(LEDGER_FIRST_CAPACITY, sizeof *ledger->entries);
    if (!ledger->entries) {
        free(ledger);
        return NULL;
    }
    ledger->capacity = LEDGER_FIRST_CAPACITY;
    ledger->next_attempt = first_attempt ? first_attempt : 1;
    ledger->lease = lease;
    return ledger;
}

void ledger_destroy(ledger_t **ledger)
{
    if (!*ledger)
        return;
    free((*ledger)->entries);
    free(*ledger);
    *ledger = NULL;
}

static size_t home_of(uint64_t unit, size_t capacity)
{
    return (size_t)((unit * UINT64_C(0x9e3779b97f4a7c15)) >> 32) & (capacity - 1);
}

/* The unit's slot, or the free slot where it would go. */
static entry_t *slot_of(entry_t *entries, size_t capacity, uint64_t unit)
{
    size_t at = home_of(unit, capacity);
    while (entries[at].used && entries[at].unit != unit)
        at = (at + 1) & (capacity - 1);
    return &entries[at];
}

static entry_t *find(const ledger_t *ledger, uint64_t unit)
{
    entry_t *entry = slot_of(ledger->entries, ledger->capacity, unit);
    return entry->used ? entry : NULL;
}

static size_t copies_of(const entry_t *entry)
{
    size_t copies = 0;
    for (int i = 0; i < LEDGER_COPIES; i++)
        copies += entry->leases[i].attempt != 0;
    return copies;
}

static bool is_lost(const entry_t *entry)
{
    return entry->used && copies_of(entry) == 0;
}

static fault_code_t grow(ledger_t *ledger, fault_t *fault)
{
    const size_t capacity = ledger->capacity * 2;
    entry_t *entries = calloc(capacity, sizeof *entries);
    if (!entries)
        return fault_set(fault, FAULT_MEMORY, "ledger: no memory for %zu units", capacity);
    for (size_t i = 0; i < ledger->capacity; i++)
        if (ledger->entries[i].used)
            *slot_of(entries, capacity, ledger->entries[i].unit) = ledger->entries[i];
    free(ledger->entries);
    ledger->entries = entries;
    ledger->capacity = capacity;
    return FAULT_NONE;
}

/* The unit's entry; a new one begins as lost. */
static fault_code_t find_or_add(ledger_t *ledger, uint64_t unit, entry_t **out, fault_t *fault)
{
    entry_t *entry = slot_of(ledger->entries, ledger->capacity, unit);
    if (!entry->used) {
        if (2 * (ledger->used + 1) > ledger->capacity) {
            TRY(grow(ledger, fault));
            entry = slot_of(ledger->entries, ledger->capacity, unit);
        }
        *entry = (entry_t){.used = true, .unit = unit};
        ledger->used++;
        ledger->lost++;
    }
    *out = entry;
    return FAULT_NONE;
}

/* Removes an entry and moves those behind it forward, so that no probe sequence has a hole (Knuth 6.4, algorithm
 * R). */
static void take_out(ledger_t *ledger, entry_t *entry)
{
    const size_t mask = ledger->capacity - 1;
    size_t hole = (size_t)(entry - ledger->entries);
    for (size_t at = (hole + 1) & mask; ledger->entries[at].used; at = (at + 1) & mask) {
        const size_t home = home_of(ledger->entries[at].unit, ledger->capacity);
        if (((at - home) & mask) >= ((at - hole) & mask)) {
            ledger->entries[hole] = ledger->entries[at];
            hole = at;
        }
    }
    memset(&ledger->entries[hole], 0, sizeof ledger->entries[hole]);
    ledger->used--;
}

fault_code_t ledger_issue(ledger_t *ledger, uint64_t unit, uint64_t worker, double now, uint64_t *attempt,
                          fault_t *fault)
{
    entry_t *entry;
    TRY(find_or_add(ledger, unit, &entry, fault));
    for (int i = 0; i < LEDGER_COPIES; i++) {
        lease_t *lease = &entry->leases[i];
        if (lease->attempt != 0)
            continue;
        if (is_lost(entry))
            ledger->lost--;
        *lease = (lease_t){.attempt = ledger->next_attempt++,
                           .worker = worker,
                           .issued = now,
                           .renewed = now,
                           .expires = now + ledger->lease};
        ledger->leases++;
        *attempt = lease->attempt;
        return FAULT_NONE;
    }
    return fault_set(fault, FAULT_RANGE, "unit %llu is out in %d copies already", (unsigned long long)unit,
                     LEDGER_COPIES);
}

fault_code_t ledger_add_lost(ledger_t *ledger, uint64_t unit, fault_t *fault)
{
    entry_t *entry;
    return find_or_add(ledger, unit, &entry, fault);
}

static bool failed_with(const entry_t *entry, uint64_t worker)
{
    for (uint32_t i = 0; i < entry->failures && i < LEDGER_MAX_FAILURES; i++)
        if (entry->failed_with[i] == worker)
            return true;
    return false;
}

bool ledger_next_lost(const ledger_t *ledger, uint64_t worker, size_t workers, uint64_t *unit)
{
    if (ledger->lost == 0)
        return false;
    const entry_t *best = NULL;
    for (size_t i = 0; i < ledger->capacity; i++) {
        const entry_t *entry = &ledger->entries[i];
        if (!is_lost(entry) || (best && best->unit <= entry->unit))
            continue;
        if (entry->failures < workers && failed_with(entry, worker))
            continue;
        best = entry;
    }
    if (best)
        *unit = best->unit;
    return best != NULL;
}

bool ledger_next_straggler(const ledger_t *ledger, uint64_t worker, double now, double min_age, uint64_t *unit)
{
    const lease_t *oldest = NULL;
    for (size_t i = 0; i < ledger->capacity; i++) {
        const entry_t *entry = &ledger->entries[i];
        if (!entry->used || copies_of(entry) != 1)
            continue;
        const lease_t *lease = &entry->leases[entry->leases[0].attempt ? 0 : 1];
        if (lease->worker == worker || now - lease->issued < min_age || (oldest && oldest->issued <= lease->issued))
            continue;
        oldest = lease;
        *unit = entry->unit;
    }
    return oldest != NULL;
}

static void end_lease(ledger_t *ledger, entry_t *entry, lease_t *lease)
{
    memset(lease, 0, sizeof *lease);
    ledger->leases--;
    if (is_lost(entry))
        ledger->lost++;
}

bool ledger_finish(ledger_t *ledger, uint64_t unit)
{
    entry_t *entry = find(ledger, unit);
    if (!entry)
        return false;
    if (is_lost(entry))
        ledger->lost--;
    ledger->leases -= copies_of(entry);
    take_out(ledger, entry);
    return true;
}

static lease_t *find_attempt(entry_t *entry, uint64_t attempt)
{
    for (int i = 0; entry && i < LEDGER_COPIES; i++)
        if (attempt != 0 && entry->leases[i].attempt == attempt)
            return &entry->leases[i];
    return NULL;
}

uint32_t ledger_fail(ledger_t *ledger, uint64_t unit, uint64_t attempt)
{
    entry_t *entry = find(ledger, unit);
    lease_t *lease = find_attempt(entry, attempt);
    if (!lease)
        return 0;
    if (entry->failures < LEDGER_MAX_FAILURES)
        entry->failed_with[entry->failures] = lease->worker;
    end_lease(ledger, entry, lease);
    return ++entry->failures;
}

bool ledger_renew(ledger_t *ledger, uint64_t unit, uint64_t attempt, uint64_t worker, double now)
{
    lease_t *lease = find_attempt(find(ledger, unit), attempt);
    if (!lease || lease->worker != worker)
        return false;
    lease->renewed = now;
    lease->expires = now + ledger->lease;
    return true;
}

size_t ledger_drop_unnamed(ledger_t *ledger, uint64_t worker, double now, double before)
{
    size_t dropped = 0;
    for (size_t i = 0; i < ledger->capacity; i++)
        for (int j = 0; j < LEDGER_COPIES; j++) {
            lease_t *lease = &ledger->entries[i].leases[j];
            if (lease->attempt == 0 || lease->worker != worker || lease->renewed >= now || lease->issued >= before)
                continue;
            end_lease(ledger, &ledger->entries[i], lease);
            dropped++;
        }
    return dropped;
}

bool ledger_return(ledger_t *ledger, uint64_t unit, uint64_t attempt)
{
    entry_t *entry = find(ledger, unit);
    lease_t *lease = find_attempt(entry, attempt);
    if (lease)
        end_lease(ledger, entry, lease);
    return lease != NULL;
}

size_t ledger_drop_worker(ledger_t *ledger, uint64_t worker)
{
    size_t dropped = 0;
    for (size_t i = 0; i < ledger->capacity; i++)
        for (int j = 0; j < LEDGER_COPIES; j++) {
            lease_t *lease = &ledger->entries[i].leases[j];
            if (lease->attempt != 0 && lease->worker == worker) {
                end_lease(ledger, &ledger->entries[i], lease);
                dropped++;
            }
        }
    return dropped;
}

size_t ledger_expire(ledger_t *ledger, double now)
{
    size_t expired = 0;
    for (size_t i = 0; i < ledger->capacity; i++)
        for (int j = 0; j < LEDGER_COPIES; j++) {
            lease_t *lease = &ledger->entries[i].leases[j];
            if (lease->attempt != 0 && lease->expires <= now) {
                end_lease(ledger, &ledger->entries[i], lease);
                expired++;
            }
        }
    return expired;
}

size_t ledger_leases(const ledger_t *ledger)
{
    return ledger->leases;
}

size_t ledger_lost(const ledger_t *ledger)
{
    return ledger->lost;
}

double ledger_mean_age(const ledger_t *ledger)
{
    return ledger->age_count ? ledger->age_sum / (double)ledger->age_count : 0;
}

void ledger_note_age(ledger_t *ledger, uint64_t unit, double now)
{
    const entry_t *entry = find(ledger, unit);
    double oldest = -1;
    for (int i = 0; entry && i < LEDGER_COPIES; i++) {
        const lease_t *lease = &entry->leases[i];
        if (lease->attempt != 0 && now - lease->issued > oldest)
            oldest = now - lease->issued;
    }
    if (oldest >= 0) {
        ledger->age_sum += oldest;
        ledger->age_count++;
    }
}
