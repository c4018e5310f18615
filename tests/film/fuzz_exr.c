/* Hostile OpenEXR files: as they come, and as edits of valid ones of every kind. */
#include "exr_samples.h"
#include "film/exr.h"
#include "fuzz_edit.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void decode(const uint8_t *data, size_t size)
{
    image_t image;
    fault_t fault = {0};
    const fault_code_t code = exr_decode(&image, data, size, &fault);
    if (code != FAULT_NONE && (fault.text[0] == '\0' || fault.code != code || image.data))
        abort();
    volatile float sum = 0; /* every pixel can be read */
    for (size_t i = 0; i < (size_t)image.width * image.height * image.channel_count; i++)
        sum = sum + image.data[i];
    image_clear(&image);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t *samples[EXR_SAMPLE_COUNT];
    static size_t sizes[EXR_SAMPLE_COUNT];
    decode(data, size);
    if (size < 4)
        return 0;
    const size_t which = (data[0] + data[1] + data[2] + data[3]) % EXR_SAMPLE_COUNT;
    if (!samples[which])
        samples[which] = exr_sample_make(&exr_samples[which], &sizes[which]);
    uint8_t *file = malloc(sizes[which]);
    memcpy(file, samples[which], sizes[which]);
    const size_t edited = fuzz_edit(file, sizes[which], data + 4, size - 4);
    uint8_t *exact = malloc(edited ? edited : 1);
    memcpy(exact, file, edited);
    decode(exact, edited);
    free(exact);
    free(file);
    return 0;
}
