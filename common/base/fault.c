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

fault_code_t fault_prefix(fault_t *fault, const char *format, ...)
{
    if (!fault)
        return FAULT_NONE;
    char text[FAULT_TEXT_SIZE];
    va_list args;
    va_start(args, format);
    int length = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (length < 0)
        length = 0;
    if ((size_t)length < sizeof text)
        snprintf(text + length, sizeof text - (size_t)length, ": %s", fault->text);
    memcpy(fault->text, text, sizeof text);
    fault->text[sizeof fault->text - 1] = '\0';
    return fault->code;
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
