/* Hostile PFM files: as they come, and as edits of valid ones. What decodes must survive a round trip. */
#include <math.h>

#include "film/pfm.h"
#include "fuzz_edit.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void decode(const uint8_t *data, size_t size)
{
    image_t image, back;
    fault_t fault = {0};
    if (pfm_decode(&image, data, size, &fault) != FAULT_NONE) {
        if (fault.text[0] == '\0' || image.data)
            abort();
        return;
    }
    uint8_t *bytes;
    size_t length;
    if (pfm_encode(&image, &bytes, &length, NULL) != FAULT_NONE ||
        pfm_decode(&back, bytes, length, NULL) != FAULT_NONE || back.width != image.width)
        abort();
    for (size_t i = 0; i < (size_t)image.width * image.height * image.channel_count; i++)
        if (back.data[i] != image.data[i] && !(isnan(back.data[i]) && isnan(image.data[i])))
            abort();
    free(bytes);
    image_clear(&back);
    image_clear(&image);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const headers[] = {"PF\n3 2\n-1.0\n", "Pf\n6 3\n1\n", "PF 1 6 -1e3\t", "Pf\r\n9 2\r-0.5\n"};
    decode(data, size);
    if (size < 4)
        return 0;
    const char *text = headers[(data[0] + data[1] + data[2] + data[3]) % 4];
    uint8_t file[128] = {0};
    const size_t header = strlen(text);
    memcpy(file, text, header);
    const size_t edited = fuzz_edit(file, header + 72, data + 4, size - 4);
    uint8_t *exact = malloc(edited ? edited : 1);
    memcpy(exact, file, edited);
    decode(exact, edited);
    free(exact);
    return 0;
}
