/* text.h: text from elsewhere, made fit for messages and JSON. */
#ifndef MASTER_TEXT_H
#define MASTER_TEXT_H

#include <stddef.h>

/* Copies what fits, cut between characters; what the protocol does not take as text (wire.h) becomes '?'. */
void text_clean(char *out, size_t size, const char *in);

#endif
