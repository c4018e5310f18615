#include "base/fault.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

fault_code_t fault_set(fault_t *fault, fault_code_t code, const char *format, ...)
{
    if (fault) {
        va_list args;
        va_start(args, format);
        vsnprintf(fault->text, sizeof fault->text, format, args);
        va_end(args);
        fault->code = code;
    }
    return code;
}

fault_code_t fault_prefix(fault_t *fault, fault_code_t code, const char *format, ...)
{
    if (!fault || code == FAULT_NONE)
        return code;
    char inner[FAULT_TEXT_SIZE];
    memcpy(inner, fault->text, sizeof inner);
    va_list args;
    va_start(args, format);
    const int length = vsnprintf(fault->text, sizeof fault->text, format, args);
    va_end(args);
    const char *const parts[] = {": ", inner};
    size_t at = length < 0 ? 0 : (size_t)length;
    for (int i = 0; i < 2; i++)
        for (const char *c = parts[i]; *c && at + 1 < sizeof fault->text; c++)
            fault->text[at++] = *c;
    fault->text[at + 1 < sizeof fault->text ? at : sizeof fault->text - 1] = '\0';
    return code;
}

const char *fault_code_text(fault_code_t code)
{
    static const char *const texts[] = {
#define FAULT_TEXT(name, text) text,
        FAULT_CODES(FAULT_TEXT)
#undef FAULT_TEXT
    };
    return (unsigned)code < FAULT_COUNT ? texts[code] : "unknown fault";
}
