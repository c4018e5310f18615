#include "base/digest.h"

#include <assert.h>
#include <sodium.h>
#include <string.h>

static_assert(DIGEST_SIZE == crypto_generichash_BYTES, "BLAKE2b-256");

void digest_of(digest_t *out, const void *data, size_t size)
{
    const int ready = sodium_init(); /* thread-safe, idempotent: picks the fastest implementation; a failure */
    (void)ready;                     /* concerns its random numbers only */
    crypto_generichash(out->bytes, sizeof out->bytes, data, size, NULL, 0);
}

bool digest_equal(const digest_t *a, const digest_t *b)
{
    return memcmp(a->bytes, b->bytes, sizeof a->bytes) == 0;
}

void digest_print(const digest_t *digest, char text[DIGEST_TEXT_SIZE])
{
    sodium_bin2hex(text, DIGEST_TEXT_SIZE, digest->bytes, sizeof digest->bytes);
}

static int hex_value(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    if (c >= 'A' && c <= 'F')
        return c - 'A' + 10;
    return -1;
}

bool digest_parse(digest_t *out, const char *text)
{
    digest_t digest;
    for (int i = 0; i < DIGEST_SIZE; i++) {
        const int high = hex_value(text[2 * i]);
        const int low = high < 0 ? -1 : hex_value(text[2 * i + 1]);
        if (low < 0)
            return false;
        digest.bytes[i] = (uint8_t)(high << 4 | low);
    }
    if (text[2 * DIGEST_SIZE] != '\0')
        return false;
    *out = digest;
    return true;
}
