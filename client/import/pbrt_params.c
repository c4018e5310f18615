#include "client/import/pbrt_params.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    pbrt_type_t type;
} type_names[] = {
    {"integer", PBRT_INTEGER},     {"float", PBRT_FLOAT},     {"point2", PBRT_POINT2},  {"vector2", PBRT_VECTOR2},
    {"point3", PBRT_POINT3},       {"vector3", PBRT_VECTOR3}, {"normal", PBRT_NORMAL},  {"bool", PBRT_BOOL},
    {"string", PBRT_TEXT},         {"texture", PBRT_TEXTURE}, {"rgb", PBRT_RGB},        {"spectrum", PBRT_SPECTRUM},
    {"blackbody", PBRT_BLACKBODY}, {"point", PBRT_POINT3},    {"vector", PBRT_VECTOR3}, {"normal3", PBRT_NORMAL}};

const char *pbrt_type_name(pbrt_type_t type)
{
    return type_names[type].name; /* the first ones stand in the enum's order */
}

void pbrt_param_clear(pbrt_param_t *param)
{
    for (size_t i = 0; param->strings && i < param->count; i++)
        free(param->strings[i]);
    free(param->strings);
    free(param->numbers);
    memset(param, 0, sizeof *param);
}

void pbrt_params_clear(pbrt_params_t *params)
{
    for (size_t i = 0; i < params->count; i++)
        pbrt_param_clear(&params->items[i]);
    free(params->items);
    params->items = NULL;
    params->count = 0;
}

/* ---- parsing ---- */

static fault_code_t at_token(pbrt_params_t *params, const pbrt_token_t *token, fault_code_t code)
{
    params->fault_line = token->line;
    params->fault_column = token->column;
    return code;
}

static fault_code_t next(pbrt_lexer_t *lexer, pbrt_params_t *params, pbrt_token_t *token, fault_t *fault)
{
    const fault_code_t code = pbrt_lexer_next(lexer, token, fault);
    if (code) {
        params->fault_line = lexer->fault_line;
        params->fault_column = lexer->fault_column;
    }
    return code;
}

/* "type name" -> both; white space around and between them does not matter. */
static fault_code_t parse_declaration(pbrt_params_t *params, const pbrt_token_t *token, pbrt_param_t *param,
                                      fault_t *fault)
{
    char text[PBRT_NAME_MAX], type[32] = "", extra[2] = "";
    if (!pbrt_token_string(token, text, sizeof text) || strlen(text) >= PBRT_NAME_MAX - 1)
        return at_token(params, token,
                        fault_set(fault, FAULT_SYNTAX, "a parameter's declaration that is too long"));
    if (sscanf(text, " %31s %255s %1s", type, param->name, extra) != 2)
        return at_token(
            params, token,
            fault_set(fault, FAULT_SYNTAX, "expected a parameter as \"type name\", found \"%.40s\"", text));
    for (size_t i = 0; i < sizeof type_names / sizeof *type_names; i++)
        if (strcmp(type, type_names[i].name) == 0) {
            param->type = type_names[i].type;
            return FAULT_NONE;
        }
    return at_token(
        params, token,
        fault_set(fault, FAULT_SYNTAX, "unknown parameter type \"%.40s\" (of \"%.40s\")", type, param->name));
}

static bool takes_strings(pbrt_type_t type)
{
    return type == PBRT_TEXT || type == PBRT_TEXTURE || type == PBRT_SPECTRUM;
}

static fault_code_t unexpected(pbrt_params_t *params, const pbrt_param_t *param, const pbrt_token_t *token,
                               fault_t *fault)
{
    char shown[64];
    const char *expected = param->type == PBRT_BOOL                                  ? "true or false"
                           : param->type == PBRT_TEXT || param->type == PBRT_TEXTURE ? "a string"
                           : param->type == PBRT_SPECTRUM                            ? "numbers or one string"
                                                                                     : "a finite number";
    return at_token(params, token,
                    fault_set(fault, FAULT_SYNTAX, "parameter \"%s %s\": expected %s, found %s",
                              pbrt_type_name(param->type), param->name, expected,
                              pbrt_token_describe(token, shown, sizeof shown)));
}

/* Grows an array that doubles when its count reaches a power of two. */
static void *grown(void *array, size_t count, size_t size)
{
    if (count == 0)
        return realloc(array, size);
    if ((count & (count - 1)) == 0)
        return count > SIZE_MAX / 2 / size ? NULL : realloc(array, 2 * count * size);
    return array;
}

static fault_code_t add_number(pbrt_param_t *param, double value, fault_t *fault)
{
    double *numbers = grown(param->numbers, param->count, sizeof *numbers);
    if (!numbers)
        return fault_set(fault, FAULT_MEMORY, "no memory for %zu numbers", param->count);
    param->numbers = numbers;
    numbers[param->count++] = value;
    return FAULT_NONE;
}

static fault_code_t add_string(pbrt_params_t *params, pbrt_param_t *param, const pbrt_token_t *token,
                               fault_t *fault)
{
    char text[PBRT_STRING_MAX];
    if (!pbrt_token_string(token, text, sizeof text))
        return at_token(params, token,
                        fault_set(fault, FAULT_SYNTAX, "a string that is too long or has an unknown escape"));
    char **strings = grown(param->strings, param->count, sizeof *strings);
    if (!strings)
        return fault_set(fault, FAULT_MEMORY, "no memory for %zu strings", param->count);
    param->strings = strings;
    strings[param->count] = strdup(text);
    if (!strings[param->count])
        return fault_set(fault, FAULT_MEMORY, "no memory for a string");
    param->count++;
    return FAULT_NONE;
}

static fault_code_t add_value(pbrt_params_t *params, pbrt_param_t *param, const pbrt_token_t *token, fault_t *fault)
{
    double value;
    if (param->type == PBRT_BOOL) {
        const bool yes = pbrt_token_is(token, "true"), no = pbrt_token_is(token, "false");
        if ((token->kind != PBRT_WORD && token->kind != PBRT_STRING) || !(yes || no))
            return unexpected(params, param, token, fault);
        return add_number(param, yes, fault);
    }
    if (token->kind == PBRT_STRING && takes_strings(param->type) && !param->numbers)
        return add_string(params, param, token, fault);
    if (param->type == PBRT_TEXT || param->type == PBRT_TEXTURE || param->strings ||
        !pbrt_token_number(token, &value))
        return unexpected(params, param, token, fault);
    if (param->type == PBRT_INTEGER && !(value == floor(value) && fabs(value) <= 2147483647.0))
        return at_token(params, token,
                        fault_set(fault, FAULT_SYNTAX, "parameter \"%s\": expected an integer of 32 bits, found %g",
                                  param->name, value));
    return add_number(param, value, fault);
}

static size_t tuple_of(pbrt_type_t type)
{
    switch (type) {
    case PBRT_POINT2:
    case PBRT_VECTOR2:
        return 2;
    case PBRT_POINT3:
    case PBRT_VECTOR3:
    case PBRT_NORMAL:
    case PBRT_RGB:
        return 3;
    default:
        return 1;
    }
}

static fault_code_t parse_values(pbrt_lexer_t *lexer, pbrt_params_t *params, pbrt_param_t *param, fault_t *fault)
{
    pbrt_token_t token;
    TRY(next(lexer, params, &token, fault));
    if (token.kind != PBRT_OPEN)
        TRY(add_value(params, param, &token, fault));
    else
        for (;;) {
            TRY(next(lexer, params, &token, fault));
            if (token.kind == PBRT_CLOSE)
                break;
            TRY(add_value(params, param, &token, fault));
        }
    const size_t tuple = param->type == PBRT_SPECTRUM && param->numbers ? 2 : tuple_of(param->type);
    if (param->count == 0 || param->count % tuple != 0)
        return at_token(params, &token,
                        fault_set(fault, FAULT_SYNTAX,
                                  "parameter \"%s %s\": expected a multiple of %zu values, found %zu",
                                  pbrt_type_name(param->type), param->name, tuple, param->count));
    return FAULT_NONE;
}

static fault_code_t add_param(pbrt_params_t *params, const pbrt_token_t *token, pbrt_param_t **out, fault_t *fault)
{
    if (params->count == PBRT_PARAMS_MAX)
        return at_token(params, token,
                        fault_set(fault, FAULT_LIMIT, "more than %d parameters in one directive", PBRT_PARAMS_MAX));
    pbrt_param_t *items = realloc(params->items, (params->count + 1) * sizeof *items);
    if (!items)
        return fault_set(fault, FAULT_MEMORY, "no memory for a parameter");
    params->items = items;
    *out = &items[params->count++];
    memset(*out, 0, sizeof **out);
    (*out)->line = token->line;
    (*out)->column = token->column;
    return FAULT_NONE;
}

fault_code_t pbrt_params_parse(pbrt_lexer_t *lexer, pbrt_params_t *params, fault_t *fault)
{
    for (;;) {
        pbrt_token_t token;
        pbrt_param_t *param = NULL;
        const fault_code_t code = pbrt_lexer_peek(lexer, &token, fault);
        if (code) {
            params->fault_line = lexer->fault_line;
            params->fault_column = lexer->fault_column;
            return code;
        }
        if (token.kind != PBRT_STRING)
            return FAULT_NONE;
        TRY(next(lexer, params, &token, fault));
        TRY(add_param(params, &token, &param, fault));
        TRY(parse_declaration(params, &token, param, fault));
        for (size_t i = 0; i + 1 < params->count; i++)
            if (strcmp(params->items[i].name, param->name) == 0)
                return at_token(params, &token,
                                fault_set(fault, FAULT_SYNTAX, "parameter \"%s\" is given twice", param->name));
        TRY(parse_values(lexer, params, param, fault));
    }
}

/* ---- getters ---- */

const pbrt_param_t *pbrt_params_find(pbrt_params_t *params, const char *name)
{
    for (size_t i = 0; i < params->count; i++)
        if (strcmp(params->items[i].name, name) == 0) {
            params->items[i].used = true;
            return &params->items[i];
        }
    for (const pbrt_default_t *d = params->defaults; d; d = d->next)
        if (strcmp(d->param.name, name) == 0)
            return &d->param;
    return NULL;
}

fault_code_t pbrt_params_fault(pbrt_params_t *params, const pbrt_param_t *param, fault_t *fault, fault_code_t code,
                               const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    params->fault_line = param->line;
    params->fault_column = param->column;
    return fault_set(fault, code, "parameter \"%s\" of %s: %s", param->name, params->what, text);
}

static void list_types(unsigned types, char *text, size_t size)
{
    size_t length = 0;
    text[0] = 0;
    for (int i = 0; i < PBRT_TYPES; i++)
        if (types & PBRT_MASK(i) && length < size)
            length += (size_t)snprintf(text + length, size - length, "%s%s", length ? " or " : "",
                                       pbrt_type_name((pbrt_type_t)i));
}

fault_code_t pbrt_params_typed(pbrt_params_t *params, const char *name, unsigned types, const pbrt_param_t **out,
                               fault_t *fault)
{
    *out = pbrt_params_find(params, name);
    if (!*out || types & PBRT_MASK((*out)->type))
        return FAULT_NONE;
    char expected[160];
    list_types(types, expected, sizeof expected);
    return pbrt_params_fault(params, *out, fault, FAULT_TYPE, "found the type %s, expected %s",
                             pbrt_type_name((*out)->type), expected);
}

/* One value (or tuple) of a type. */
static fault_code_t single(pbrt_params_t *params, const char *name, unsigned types, size_t width,
                           const pbrt_param_t **out, fault_t *fault)
{
    TRY(pbrt_params_typed(params, name, types, out, fault));
    if (*out && (*out)->count != width)
        return pbrt_params_fault(params, *out, fault, FAULT_FORMAT, "found %zu values, expected %zu", (*out)->count,
                                 width);
    return FAULT_NONE;
}

fault_code_t pbrt_params_int(pbrt_params_t *params, const char *name, int lo, int hi, int *value, fault_t *fault)
{
    const pbrt_param_t *param;
    TRY(single(params, name, PBRT_MASK(PBRT_INTEGER), 1, &param, fault));
    if (!param)
        return FAULT_NONE;
    if (!(param->numbers[0] >= lo && param->numbers[0] <= hi))
        return pbrt_params_fault(params, param, fault, FAULT_RANGE, "found %.0f, expected %d to %d",
                                 param->numbers[0], lo, hi);
    *value = (int)param->numbers[0];
    return FAULT_NONE;
}

fault_code_t pbrt_params_float(pbrt_params_t *params, const char *name, double lo, double hi, double *value,
                               fault_t *fault)
{
    const pbrt_param_t *param;
    TRY(single(params, name, PBRT_MASK(PBRT_FLOAT), 1, &param, fault));
    if (!param)
        return FAULT_NONE;
    if (!(param->numbers[0] >= lo && param->numbers[0] <= hi))
        return pbrt_params_fault(params, param, fault, FAULT_RANGE, "found %g, expected %g to %g",
                                 param->numbers[0], lo, hi);
    *value = param->numbers[0];
    return FAULT_NONE;
}

fault_code_t pbrt_params_bool(pbrt_params_t *params, const char *name, bool *value, fault_t *fault)
{
    const pbrt_param_t *param;
    TRY(single(params, name, PBRT_MASK(PBRT_BOOL), 1, &param, fault));
    if (param)
        *value = param->numbers[0] != 0;
    return FAULT_NONE;
}

fault_code_t pbrt_params_string(pbrt_params_t *params, const char *name, const char **value, fault_t *fault)
{
    const pbrt_param_t *param;
    TRY(single(params, name, PBRT_MASK(PBRT_TEXT), 1, &param, fault));
    if (param)
        *value = param->strings[0];
    return FAULT_NONE;
}

fault_code_t pbrt_params_point(pbrt_params_t *params, const char *name, vec3_t *value, fault_t *fault)
{
    const pbrt_param_t *param;
    TRY(single(params, name, PBRT_MASK(PBRT_POINT3) | PBRT_MASK(PBRT_VECTOR3), 3, &param, fault));
    if (param)
        *value = vec3(param->numbers[0], param->numbers[1], param->numbers[2]);
    return FAULT_NONE;
}

fault_code_t pbrt_params_numbers(pbrt_params_t *params, const char *name, unsigned types, size_t width,
                                 const double **values, size_t *count, fault_t *fault)
{
    const pbrt_param_t *param;
    *values = NULL;
    *count = 0;
    TRY(pbrt_params_typed(params, name, types, &param, fault));
    if (!param)
        return FAULT_NONE;
    if (param->count % width != 0)
        return pbrt_params_fault(params, param, fault, FAULT_FORMAT, "found %zu values, expected a multiple of %zu",
                                 param->count, width);
    *values = param->numbers;
    *count = param->count / width;
    return FAULT_NONE;
}

void pbrt_params_ignore(pbrt_params_t *params, const char *name)
{
    (void)pbrt_params_find(params, name);
}

void pbrt_params_report(const pbrt_params_t *params, import_notes_t *notes)
{
    for (size_t i = 0; i < params->count; i++)
        if (!params->items[i].used)
            import_notes_add(notes, params->file, params->items[i].line,
                             "parameter \"%s\" of %s is not known and is ignored", params->items[i].name,
                             params->what);
}
