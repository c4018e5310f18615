/* pages.h: large blocks of memory that are read and written at random places.
 *
 * With pages of 4 KB nearly every access to a film or a table of a few megabytes misses the translation buffer too;
 * with huge pages (2 MB, where the system grants them on request) none does: 2 to 3 % of the time of a render.
 */
#ifndef BASE_PAGES_H
#define BASE_PAGES_H

#include <stddef.h>

/* A zeroed block, aligned to 16 bytes at least, released with free(). Blocks of 2 MB and more are aligned and
 * rounded up to huge pages. Null when out of memory or where count * size overflows. */
void *pages_new(size_t count, size_t size);

#endif
