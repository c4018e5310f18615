/* stored_file.h: whole files that may be gzip-compressed (RFC 1952), with a limit on what they unpack to. The only
 * file that knows zlib. Any thread. */
#ifndef IMPORT_STORED_FILE_H
#define IMPORT_STORED_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"

/* Largest file read, and largest content unpacked. */
#define STORED_FILE_MAX ((size_t)4 << 30)

/* Reads and, if the first bytes are gzip's, unpacks. *data ends with one zero byte past its size; the caller frees
 * it. */
fault_code_t stored_file_read(const char *path, uint8_t **data, size_t *size, fault_t *fault);

/* The same for bytes in memory (borrowed): *out is a copy or the unpacked content, of at most `limit` bytes. */
fault_code_t stored_file_unpack(const uint8_t *data, size_t size, size_t limit, uint8_t **out, size_t *out_size,
                                fault_t *fault);

#endif
