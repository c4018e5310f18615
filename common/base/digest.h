/* digest.h: content hashes (BLAKE2b-256, libsodium). A bundle's name is the hash of its bytes. */
#ifndef BASE_DIGEST_H
#define BASE_DIGEST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { DIGEST_SIZE = 32, DIGEST_TEXT_SIZE = 65 };

typedef struct digest {
    uint8_t bytes[DIGEST_SIZE];
} digest_t;

void digest_of(digest_t *out, const void *data, size_t size);
bool digest_equal(const digest_t *a, const digest_t *b);
void digest_print(const digest_t *digest, char text[DIGEST_TEXT_SIZE]); /* lower-case hexadecimal */
bool digest_parse(digest_t *out, const char *text);                     /* exactly 64 hexadecimal digits */

#endif
