/* markup.h: text into XML and HTML: nothing that it holds is taken for markup. Any thread. */
#ifndef DRAW_MARKUP_H
#define DRAW_MARKUP_H

#include <stddef.h>
#include <stdio.h>

/* Writes UTF-8 text as content or within an attribute in double quotes: & < > " as references, control
 * characters (which XML does not have) as spaces. */
void markup_escape(FILE *out, const char *text);

/* The same of at most `most` octets: what is longer is cut between characters and ends in an ellipsis. */
void markup_escape_some(FILE *out, const char *text, size_t most);

#endif
