#include "draw/markup.h"

#include <string.h>

static void escape_octet(FILE *out, unsigned char c)
{
    switch (c) {
    case '&':
        fputs("&amp;", out);
        break;
    case '<':
        fputs("&lt;", out);
        break;
    case '>':
        fputs("&gt;", out);
        break;
    case '"':
        fputs("&quot;", out);
        break;
    default:
        fputc(c < ' ' ? ' ' : c, out);
    }
}

void markup_escape(FILE *out, const char *text)
{
    for (const char *c = text; *c; c++)
        escape_octet(out, (unsigned char)*c);
}

void markup_escape_some(FILE *out, const char *text, size_t most)
{
    size_t end = strnlen(text, most + 1);
    const int cut = end > most;
    if (cut)
        for (end = most; end > 0 && ((unsigned char)text[end] & 0xc0) == 0x80;)
            end--; /* not within a character */
    for (size_t i = 0; i < end; i++)
        escape_octet(out, (unsigned char)text[i]);
    if (cut)
        fputs("\xe2\x80\xa6", out);
}
