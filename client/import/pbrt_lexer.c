#include "client/import/pbrt_lexer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void pbrt_lexer_init(pbrt_lexer_t *lexer, const char *text, size_t size)
{
    memset(lexer, 0, sizeof *lexer);
    lexer->text = text;
    lexer->size = size;
    lexer->line = 1;
    /* A byte order mark is no part of the text. */
    if (size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0)
        lexer->at = lexer->line_start = 3;
}

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v';
}

static bool ends_word(char c)
{
    return is_space(c) || c == '"' || c == '[' || c == ']' || c == '#';
}

static void skip_space(pbrt_lexer_t *lexer)
{
    while (lexer->at < lexer->size) {
        const char c = lexer->text[lexer->at];
        if (c == '#') {
            while (lexer->at < lexer->size && lexer->text[lexer->at] != '\n')
                lexer->at++;
        } else if (is_space(c)) {
            lexer->at++;
            if (c == '\n') {
                lexer->line++;
                lexer->line_start = lexer->at;
            }
        } else {
            break;
        }
    }
}

static fault_code_t read_string(pbrt_lexer_t *lexer, pbrt_token_t *token, fault_t *fault)
{
    token->kind = PBRT_STRING;
    token->text = lexer->text + ++lexer->at;
    while (lexer->at < lexer->size && lexer->text[lexer->at] != '"' && lexer->text[lexer->at] != '\n')
        lexer->at +=
            lexer->text[lexer->at] == '\\' && lexer->at + 1 < lexer->size && lexer->text[lexer->at + 1] != '\n' ? 2
                                                                                                                : 1;
    if (lexer->at >= lexer->size || lexer->text[lexer->at] != '"') {
        lexer->fault_line = token->line;
        lexer->fault_column = token->column;
        return fault_set(fault, FAULT_SYNTAX, "a string that is not closed in its line");
    }
    token->length = (size_t)(lexer->text + lexer->at - token->text);
    lexer->at++;
    return FAULT_NONE;
}

fault_code_t pbrt_lexer_next(pbrt_lexer_t *lexer, pbrt_token_t *token, fault_t *fault)
{
    if (lexer->peeked) {
        lexer->peeked = false;
        *token = lexer->ahead;
        return FAULT_NONE;
    }
    skip_space(lexer);
    *token =
        (pbrt_token_t){PBRT_END, lexer->text + lexer->at, 0, lexer->line, (int)(lexer->at - lexer->line_start + 1)};
    if (lexer->at >= lexer->size)
        return FAULT_NONE;
    const char c = lexer->text[lexer->at];
    if (c == '"')
        return read_string(lexer, token, fault);
    if (c == '[' || c == ']') {
        token->kind = c == '[' ? PBRT_OPEN : PBRT_CLOSE;
        token->length = 1;
        lexer->at++;
        return FAULT_NONE;
    }
    token->kind = PBRT_WORD;
    while (lexer->at < lexer->size && !ends_word(lexer->text[lexer->at]))
        lexer->at++;
    token->length = (size_t)(lexer->text + lexer->at - token->text);
    return FAULT_NONE;
}

fault_code_t pbrt_lexer_peek(pbrt_lexer_t *lexer, pbrt_token_t *token, fault_t *fault)
{
    if (!lexer->peeked) {
        TRY(pbrt_lexer_next(lexer, &lexer->ahead, fault));
        lexer->peeked = true;
    }
    *token = lexer->ahead;
    return FAULT_NONE;
}

const char *pbrt_token_describe(const pbrt_token_t *token, char *buffer, size_t size)
{
    char shown[41];
    size_t length = 0;
    for (; length < token->length && length < sizeof shown - 1; length++) {
        const char c = token->text[length];
        shown[length] = c >= 32 && c < 127 ? c : '?';
    }
    shown[length] = 0;
    if (token->kind == PBRT_END)
        snprintf(buffer, size, "the end of the file");
    else if (token->kind == PBRT_STRING)
        snprintf(buffer, size, "the string \"%s\"", shown);
    else
        snprintf(buffer, size, "'%s'", shown);
    return buffer;
}

bool pbrt_token_string(const pbrt_token_t *token, char *buffer, size_t size)
{
    static const char escapes[] = "n\nt\tr\rb\bf\f\\\\\"\"''";
    size_t length = 0;
    for (size_t i = 0; i < token->length; i++) {
        char c = token->text[i];
        if (c == '\\') {
            if (++i >= token->length)
                return false;
            const char *found = NULL;
            for (const char *e = escapes; *e && !found; e += 2)
                found = *e == token->text[i] ? e : NULL;
            if (!found)
                return false;
            c = found[1];
        }
        if (c == 0 || length + 1 >= size)
            return false;
        buffer[length++] = c;
    }
    buffer[length] = 0;
    return true;
}

/* Plain decimal numbers of up to 15 digits and small exponents, exactly (Clinger 1990, the fast path); others by
 * strtod. */
static bool fast_number(const char *text, size_t length, double *value)
{
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    size_t i = 0;
    const bool minus = text[0] == '-';
    i += minus || text[0] == '+';
    unsigned long long digits = 0;
    int count = 0, scale = 0;
    bool point = false;
    for (; i < length; i++) {
        if (text[i] >= '0' && text[i] <= '9') {
            digits = 10 * digits + (unsigned long long)(text[i] - '0');
            scale -= point;
            if (++count > 15)
                return false;
        } else if (text[i] == '.' && !point) {
            point = true;
        } else {
            return false;
        }
    }
    if (count == 0)
        return false;
    const double v = (double)digits / powers[-scale];
    *value = minus ? -v : v;
    return true;
}

bool pbrt_token_number(const pbrt_token_t *token, double *value)
{
    char word[128], *end;
    if (token->kind != PBRT_WORD || token->length >= sizeof word)
        return false;
    if (fast_number(token->text, token->length, value))
        return true;
    for (size_t i = 0; i < token->length; i++)
        if (!token->text[i] || !strchr("0123456789+-.eE", token->text[i]))
            return false;
    memcpy(word, token->text, token->length);
    word[token->length] = 0;
    *value = strtod(word, &end);
    return end != word && *end == 0 && isfinite(*value);
}

bool pbrt_token_is(const pbrt_token_t *token, const char *word)
{
    return strlen(word) == token->length && memcmp(token->text, word, token->length) == 0;
}
