/* Any octets: decoding either names a fault or gives a message that encodes to the same octets. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/message.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(int condition, const char *what, const char *detail)
{
    if (condition)
        return;
    fprintf(stderr, "fuzz_message: %s: %s\n", what, detail);
    abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t *exact = malloc(size ? size : 1); /* its own end, so that a read beyond is seen */
    memcpy(exact, data, size);
    message_t message;
    fault_t fault = {0};
    const fault_code_t code = message_decode(&message, exact, size, &fault);
    if (code) {
        require(fault.code == code && fault.text[0], "a refused frame has no reason",
                message_type_name(message.type));
    } else if (memcmp(exact + 4, "\1\0", 2) == 0) { /* a REFUSED of another version is read in part */
        uint8_t *again;
        size_t again_size;
        require(message_encode(&message, &again, &again_size, &fault) == FAULT_NONE, "cannot encode", fault.text);
        require(again_size == size && memcmp(again, exact, size) == 0, "encodes differently",
                message_type_name(message.type));
        free(again);
    }
    free(exact);
    return 0;
}
