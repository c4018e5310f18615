/* cache.h: bundles on a worker's disk, by digest.
 *
 * A bundle arrives in pieces in a file of its own (.part), which becomes .unchecked when whole and .bundle only
 * after bundle_open has found its content right and its digest to be the one asked for. Several workers may share a
 * folder: unfinished files carry the process's id, and finished ones are renamed into place, the same content under
 * the same name.
 *
 * Thread rule: cache_admit and cache_has may be called by any thread; downloads belong to one thread.
 */
#ifndef WORKER_CACHE_H
#define WORKER_CACHE_H

#include <stdbool.h>

#include "base/digest.h"
#include "base/fault.h"
#include "scene/bundle.h"

typedef struct cache cache_t;
typedef struct cache_download cache_download_t;

#define CACHE_LIMIT_BYTES (UINT64_C(64) << 30) /* default of what is kept */

/* folder null: a private temporary one, removed by cache_close. The oldest bundles beyond `limit` bytes (0: the
 * default) are removed as new ones come. */
fault_code_t cache_open(cache_t **out, const char *folder, uint64_t limit, fault_t *fault);
void cache_close(cache_t **cache);
const char *cache_folder(const cache_t *cache);

/* Whether the bundle's bytes are here, checked or not: cache_admit will tell. */
bool cache_has(cache_t *cache, const digest_t *digest);

/* Opens a bundle that cache_has. A file that is damaged or holds something else is removed and a fault. The caller
 * destroys the bundle; that the cache drops its file meanwhile does not harm it. Hashes the whole: may take
 * seconds. */
fault_code_t cache_admit(cache_t *cache, const digest_t *digest, bundle_t **out, fault_t *fault);

fault_code_t cache_download_begin(cache_download_t **out, cache_t *cache, const digest_t *digest, uint64_t total,
                                  fault_t *fault);
/* The next bytes, in order; FAULT_RANGE beyond the total. */
fault_code_t cache_download_write(cache_download_t *download, const void *data, size_t size, fault_t *fault);
uint64_t cache_download_have(const cache_download_t *download);
/* All bytes are written: cache_has is true from now on. Destroys the download whether it succeeds or not. */
fault_code_t cache_download_finish(cache_download_t **download, fault_t *fault);
/* Gives up: removes the file. Accepts null. */
void cache_download_abort(cache_download_t **download);

#endif
