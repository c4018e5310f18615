/* fuzz_edit.h: a fuzzer's input read as a list of edits of a valid file, so that most of the file stays valid and
 * the search gets past its first checks. */
#ifndef TESTS_FILM_FUZZ_EDIT_H
#define TESTS_FILM_FUZZ_EDIT_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Applies the script, five bytes an edit, to data[0..size); returns the new size, at most the old one. */
static inline size_t fuzz_edit(uint8_t *data, size_t size, const uint8_t *script, size_t script_size)
{
    static const uint32_t words[] = {0,       1,          0x7f,       0x80,       0xff, 0x7fff, 0x8000, 0xffff,
                                     0x10000, 0x7fffffff, 0x80000000, 0xffffffff, 64,   16,     4096,   0xfffffffe};
    for (; script_size >= 5 && size > 0; script += 5, script_size -= 5) {
        const size_t at = ((size_t)script[1] << 8 | script[2]) % size, left = size - at;
        switch (script[0] % 7) {
        case 0: /* so that a script of zeros is the valid file */
            break;
        case 6:
            data[at] = script[3];
            break;
        case 1:
            data[at] ^= (uint8_t)(1u << (script[3] % 8));
            break;
        case 2:
            memcpy(data + at, &words[script[3] % 16], left < 4 ? left : 4);
            break;
        case 3: {
            const size_t length = 1 + script[4] % (left < 64 ? left : 64);
            memmove(data + at, data + at + length, left - length);
            size -= length;
            break;
        }
        case 4: {
            const size_t from = script[3] % size, room = left < size - from ? left : size - from;
            memmove(data + at, data + from, script[4] % 16u < room ? script[4] % 16u : room);
            break;
        }
        default:
            size = script[3] < 16 ? at : size; /* cut, now and then */
        }
    }
    return size;
}

#endif
