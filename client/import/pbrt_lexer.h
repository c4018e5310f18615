/* pbrt_lexer.h: the words of a pbrt-v4 scene file with their places.
 *
 * A token is a quoted string, an opening or closing bracket, or a bare word (a directive, a number, true or false);
 * comments run from # to the end of the line. Tokens point into the text. Faults set lexer->line and column.
 */
#ifndef IMPORT_PBRT_LEXER_H
#define IMPORT_PBRT_LEXER_H

#include <stdbool.h>
#include <stddef.h>

#include "base/fault.h"

typedef enum pbrt_token_kind { PBRT_END, PBRT_WORD, PBRT_STRING, PBRT_OPEN, PBRT_CLOSE } pbrt_token_kind_t;

typedef struct pbrt_token {
    pbrt_token_kind_t kind;
    const char *text; /* not terminated; of strings: without the quotes, escapes as written */
    size_t length;
    int line, column; /* from 1; columns count bytes */
} pbrt_token_t;

typedef struct pbrt_lexer {
    const char *text;
    size_t size, at;
    size_t line_start;
    int line;
    bool peeked;
    pbrt_token_t ahead;
    int fault_line, fault_column; /* where the last fault is */
} pbrt_lexer_t;

void pbrt_lexer_init(pbrt_lexer_t *lexer, const char *text, size_t size); /* text is borrowed */
/* The next token is taken, or only looked at. PBRT_END at the end, again and again. */
fault_code_t pbrt_lexer_next(pbrt_lexer_t *lexer, pbrt_token_t *token, fault_t *fault);
fault_code_t pbrt_lexer_peek(pbrt_lexer_t *lexer, pbrt_token_t *token, fault_t *fault);

/* "the string \"abc\"", "the end of the file", ...: for messages. Returns `buffer`. */
const char *pbrt_token_describe(const pbrt_token_t *token, char *buffer, size_t size);
/* Writes a string token's content, escapes resolved; false if it does not fit or holds a zero byte or an unknown
 * escape. */
bool pbrt_token_string(const pbrt_token_t *token, char *buffer, size_t size);
/* A word as a finite number; false if it is none. */
bool pbrt_token_number(const pbrt_token_t *token, double *value);
bool pbrt_token_is(const pbrt_token_t *token, const char *word);

#endif
