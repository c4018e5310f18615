#include "master/text.h"

#include <stdint.h>
#include <string.h>

#include "base/wire.h"

void text_clean(char *out, size_t size, const char *in)
{
    size_t left = strlen(in), used = 0;
    while (left > 0) {
        const size_t step = wire_text_character((const uint8_t *)in, left);
        if (used + (step ? step : 1) >= size)
            break;
        if (step)
            memcpy(out + used, in, step);
        else
            out[used] = '?';
        used += step ? step : 1;
        in += step ? step : 1;
        left -= step ? step : 1;
    }
    out[used] = '\0';
}
