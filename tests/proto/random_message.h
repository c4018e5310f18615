/* random_message.h: messages with random but valid contents, made from the table of fields; for tests and seeds. */
#ifndef TESTS_PROTO_RANDOM_MESSAGE_H
#define TESTS_PROTO_RANDOM_MESSAGE_H

#include "proto/message.h"

enum { RANDOM_MESSAGE_MEMORY = 1 << 14, RANDOM_MESSAGE_LENGTH = 90, RANDOM_MESSAGE_TYPES = 64 };

typedef struct random_message {
    message_t message; /* points into memory */
    uint8_t memory[RANDOM_MESSAGE_MEMORY];
    size_t used;
} random_message_t;

/* The message number `index` of a type; texts and bytes hold at most RANDOM_MESSAGE_LENGTH octets. */
void random_message_fill(random_message_t *out, unsigned type, uint64_t index);

#endif
