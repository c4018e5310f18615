#include "base/pages.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

void *pages_new(size_t count, size_t size)
{
    const size_t page = (size_t)1 << 21;
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX - page)
        return NULL;
    if (bytes < page)
        return calloc(count ? count : 1, size ? size : 1);
    bytes = (bytes + page - 1) / page * page;
    void *block = aligned_alloc(page, bytes);
    if (!block)
        return NULL;
    (void)madvise(block, bytes,
                  MADV_HUGEPAGE); /* advice only: without huge pages the block is as good, but slower */
    return memset(block, 0, bytes);
}
