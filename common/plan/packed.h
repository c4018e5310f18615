/* packed.h: arrays in a checkpoint: u32 size, one zstd frame. Numbers are as the machine has them: a checkpoint is
 * read by the program that wrote it. */
#ifndef PLAN_PACKED_H
#define PLAN_PACKED_H

#include "base/wire.h"

/* Null: no array, of size 0. */
void packed_put(wire_writer_t *out, const char *field, const void *from, size_t size);

/* Hostile bytes: fills exactly `size` octets or fails. Null: there must be no array. */
fault_code_t packed_get(wire_reader_t *in, const char *field, void *to, size_t size);

#endif
