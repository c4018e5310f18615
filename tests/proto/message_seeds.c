/* Writes two valid frames of each message type into a folder: seeds of fuzz_message. */
#include <stdio.h>
#include <stdlib.h>

#include "proto/random_message.h"

static int write_seed(const char *folder, unsigned type, unsigned index)
{
    static random_message_t random;
    random_message_fill(&random, type, index);
    uint8_t *data;
    size_t size;
    fault_t fault;
    if (message_encode(&random.message, &data, &size, &fault)) {
        fprintf(stderr, "message_seeds: %s\n", fault.text);
        return 1;
    }
    char path[4096];
    snprintf(path, sizeof path, "%s/%s_%u", folder, message_type_name(type), index);
    FILE *file = fopen(path, "wb");
    const int failed = !file || fwrite(data, 1, size, file) != size;
    if (failed)
        perror(path);
    if (file)
        fclose(file);
    free(data);
    return failed;
}

int main(int count, char **arguments)
{
    if (count != 2) {
        fprintf(stderr, "usage: message_seeds FOLDER\n");
        return 2;
    }
    for (unsigned type = 0; type < RANDOM_MESSAGE_TYPES; type++)
        for (unsigned index = 0; message_senders(type) && index < 2; index++)
            if (write_seed(arguments[1], type, index))
                return 1;
    return 0;
}
