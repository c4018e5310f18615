/* journal.h: results of one job, appended as they are merged, so that a master that goes down can merge them again.
 *
 * Record: "GJR1", length u32, unit u64, seconds f64 (the job's clock at the merge), BLAKE2b-256 over unit, seconds
 * and bytes, then `length` bytes of the result; little endian. A tail that is cut short or damaged ends the replay
 * and is cut off; a record behind it can only be one that was never acknowledged.
 *
 *     journal_open (replays) -> { journal_append ... journal_sync } -> journal_reset after a snapshot
 *
 * An append that fails (disk full) leaves the journal as it was. A sync that fails means that the journal can no
 * longer be trusted on this disk: the caller saves a snapshot and resets. One thread at a time.
 */
#ifndef MASTER_JOURNAL_H
#define MASTER_JOURNAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"

typedef struct journal journal_t;

enum { JOURNAL_HEADER_SIZE = 56, JOURNAL_MAX_RECORD = 1 << 30 };

/* Called for each whole record in order. A fault ends the replay and journal_open fails with it. */
typedef fault_code_t (*journal_replay_t)(void *context, uint64_t unit, double seconds, const uint8_t *data,
                                         size_t size, fault_t *fault);

/* Opens or creates. *cut (may be null) is the number of bytes of a torn tail that were cut off. sync false:
 * journal_sync does nothing (the folder is temporary). */
fault_code_t journal_open(journal_t **out, const char *path, bool sync, journal_replay_t replay, void *context,
                          uint64_t *cut, fault_t *fault);
void journal_close(journal_t **journal);

fault_code_t journal_append(journal_t *journal, uint64_t unit, double seconds, const uint8_t *data, size_t size,
                            fault_t *fault);
/* Everything appended is on the disk when this returns. */
fault_code_t journal_sync(journal_t *journal, fault_t *fault);
/* Empties the journal, once a snapshot holds what it held. */
fault_code_t journal_reset(journal_t *journal, fault_t *fault);

uint64_t journal_bytes(const journal_t *journal);
bool journal_is_dirty(const journal_t *journal); /* appended and not yet synced */

#endif
