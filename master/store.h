/* store.h: the master's state folder.
 *
 *     lock                     held (flock) while a master runs
 *     bundles/HASH             whole and checked; HASH.part: on its way
 *     jobs/ID/job.json         the job's canonical text, as submitted
 *     jobs/ID/state.json       state, bundle, times; written last at submission: a folder without it is no job
 *     jobs/ID/snapshot         the plan's bytes (run.h), and
 *     jobs/ID/journal          the results since (journal.h); both go when the job ends
 *     jobs/ID/image.exr ...    the outputs
 *
 * Every file but the journal is written beside and renamed. The store itself is one thread's; functions that take
 * it as const only read it and may run elsewhere at the same time.
 */
#ifndef MASTER_STORE_H
#define MASTER_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/digest.h"
#include "base/fault.h"

enum { STORE_PATH_SIZE = 4096 };

typedef struct store store_t;

/* Makes the folders where missing and takes the lock. FAULT_USAGE: another master has it. sync false: nothing is
 * worth an fdatasync here. */
fault_code_t store_open(store_t **out, const char *folder, bool sync, fault_t *fault);
void store_close(store_t **store);
const char *store_folder(const store_t *store);
bool store_syncs(const store_t *store);

/* ---- bundles ---- */

fault_code_t store_bundle_path(const store_t *store, const digest_t *digest, char out[STORE_PATH_SIZE],
                               fault_t *fault);
bool store_has_bundle(const store_t *store, const digest_t *digest);
/* How much of an upload has arrived; 0 if nothing. */
uint64_t store_bundle_part(const store_t *store, const digest_t *digest);
/* Takes the piece at offset of a bundle of `total` bytes. *next is where the next one should begin; at `total` the
 * bundle was checked and is in place. FAULT_RANGE: a piece beyond what has arrived. A bundle that fails its check
 * is removed. */
fault_code_t store_put_bundle(store_t *store, const digest_t *digest, uint64_t total, uint64_t offset,
                              const uint8_t *data, size_t size, uint64_t *next, fault_t *fault);

/* ---- jobs ---- */

/* All jobs' ids, in no order; the caller frees. */
fault_code_t store_list_jobs(const store_t *store, uint64_t **ids, size_t *count, fault_t *fault);
fault_code_t store_make_job(store_t *store, uint64_t job, fault_t *fault);
/* Removes a job's folder with the files in it. */
void store_remove_job(store_t *store, uint64_t job);
fault_code_t store_job_path(const store_t *store, uint64_t job, const char *name, char out[STORE_PATH_SIZE],
                            fault_t *fault);
fault_code_t store_write(const store_t *store, uint64_t job, const char *name, const void *data, size_t size,
                         fault_t *fault);
fault_code_t store_read(const store_t *store, uint64_t job, const char *name, size_t limit, uint8_t **data,
                        size_t *size, fault_t *fault);
/* Removes a job's file; one that is not there is no fault. */
void store_remove(const store_t *store, uint64_t job, const char *name);
/* Makes renames in the job's folder last through a power cut. */
fault_code_t store_sync_job(const store_t *store, uint64_t job, fault_t *fault);

/* ---- pieces of files ---- */

/* Reads at most `size` bytes at offset of any file; *total is the file's size, *revision changes with its content.
 * FAULT_RANGE: offset beyond the end. */
fault_code_t store_read_piece(const char *path, uint64_t offset, uint8_t *data, size_t size, size_t *got,
                              uint64_t *total, uint64_t *revision, fault_t *fault);

#endif
