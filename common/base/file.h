/* file.h: whole files, read with a limit and written so that a reader never sees half of one. */
#ifndef BASE_FILE_H
#define BASE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"

/* Reads a regular file of at most `limit` bytes. *data has one zero byte past its end and is the caller's to
 * free(); an empty file gives a one-byte allocation. Faults: FAULT_NOT_FOUND, FAULT_IO, FAULT_LIMIT, FAULT_MEMORY.
 */
fault_code_t file_read(const char *path, size_t limit, uint8_t **data, size_t *size, fault_t *fault);

/* Writes beside the target (same folder), syncs, renames over it. On failure nothing is left behind. */
fault_code_t file_write(const char *path, const void *data, size_t size, fault_t *fault);

bool file_exists(const char *path);
/* Makes the folder and its parents; an existing folder is success. */
fault_code_t file_make_folder(const char *path, fault_t *fault);
/* "folder/name" of the path into out; name is copied as is when it is absolute. FAULT_LIMIT if it does not fit. */
fault_code_t file_join(char *out, size_t size, const char *folder, const char *name, fault_t *fault);
/* The folder part of a path ("." if there is none). */
fault_code_t file_folder_of(char *out, size_t size, const char *path, fault_t *fault);

#endif
