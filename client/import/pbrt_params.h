/* pbrt_params.h: the typed parameters of one directive: "type name" followed by a value or [ values ].
 *
 *     TRY(pbrt_params_parse(lexer, &params, fault));
 *     double radius = 1;
 *     TRY(pbrt_params_float(&params, "radius", 0, INFINITY, &radius, fault));
 *     ...
 *     pbrt_params_report(&params, notes);   // what nobody asked for
 *     pbrt_params_clear(&params);
 *
 * Getters leave the value alone where the parameter is absent, mark what they find as used, and on a fault set
 * params->fault_line and fault_column to the parameter's place. Where a directive gives no value, the defaults of
 * Attribute directives count.
 */
#ifndef IMPORT_PBRT_PARAMS_H
#define IMPORT_PBRT_PARAMS_H

#include "client/import/notes.h"
#include "client/import/pbrt_lexer.h"
#include "math/vec.h"

typedef enum pbrt_type {
    PBRT_INTEGER,
    PBRT_FLOAT,
    PBRT_POINT2,
    PBRT_VECTOR2,
    PBRT_POINT3,
    PBRT_VECTOR3,
    PBRT_NORMAL,
    PBRT_BOOL,
    PBRT_TEXT, /* "string" */
    PBRT_TEXTURE,
    PBRT_RGB,
    PBRT_SPECTRUM, /* numbers in pairs, or one name */
    PBRT_BLACKBODY,
    PBRT_TYPES
} pbrt_type_t;

#define PBRT_MASK(type) (1u << (type))

enum { PBRT_NAME_MAX = 256, PBRT_STRING_MAX = 4096, PBRT_PARAMS_MAX = 256 };

typedef struct pbrt_param {
    char name[PBRT_NAME_MAX];
    pbrt_type_t type;
    int line, column;
    bool used;
    size_t count;    /* numbers or strings */
    double *numbers; /* booleans are 0 or 1; owned */
    char **strings;  /* owned; null where there are numbers */
} pbrt_param_t;

/* Defaults by Attribute directives: a list that only grows at its head, shared between graphics states. */
typedef struct pbrt_default {
    pbrt_param_t param;
    const struct pbrt_default *next;
} pbrt_default_t;

typedef struct pbrt_params {
    pbrt_param_t *items;
    size_t count;
    const pbrt_default_t *defaults; /* borrowed */
    char what[PBRT_NAME_MAX + 32];  /* 'Shape "sphere"': for messages */
    const char *file;               /* borrowed */
    int line;
    int fault_line, fault_column;
} pbrt_params_t;

/* Reads parameters up to the next directive. params->what, file, line and defaults are set by the caller;
 * fault_line and fault_column are set on a fault. */
fault_code_t pbrt_params_parse(pbrt_lexer_t *lexer, pbrt_params_t *params, fault_t *fault);
void pbrt_params_clear(pbrt_params_t *params);
void pbrt_param_clear(pbrt_param_t *param);

/* The parameter of that name or null; marks it as used. */
const pbrt_param_t *pbrt_params_find(pbrt_params_t *params, const char *name);
/* Fault at the parameter's place: 'parameter "x" of Shape "y": ' and the text. Returns the code. */
fault_code_t pbrt_params_fault(pbrt_params_t *params, const pbrt_param_t *param, fault_t *fault, fault_code_t code,
                               const char *format, ...) __attribute__((format(printf, 5, 6)));
/* As find, but a fault if its type is not in the mask of PBRT_MASK()s. *out is null if absent. */
fault_code_t pbrt_params_typed(pbrt_params_t *params, const char *name, unsigned types, const pbrt_param_t **out,
                               fault_t *fault);

fault_code_t pbrt_params_int(pbrt_params_t *params, const char *name, int lo, int hi, int *value, fault_t *fault);
fault_code_t pbrt_params_float(pbrt_params_t *params, const char *name, double lo, double hi, double *value,
                               fault_t *fault);
fault_code_t pbrt_params_bool(pbrt_params_t *params, const char *name, bool *value, fault_t *fault);
fault_code_t pbrt_params_string(pbrt_params_t *params, const char *name, const char **value, fault_t *fault);
fault_code_t pbrt_params_point(pbrt_params_t *params, const char *name, vec3_t *value, fault_t *fault);
/* A list of numbers of the types in the mask; *count is in tuples of `width` numbers. *values is null if absent. */
fault_code_t pbrt_params_numbers(pbrt_params_t *params, const char *name, unsigned types, size_t width,
                                 const double **values, size_t *count, fault_t *fault);

/* Marks a parameter as known and without effect. */
void pbrt_params_ignore(pbrt_params_t *params, const char *name);
/* Notes for every parameter that was not used. */
void pbrt_params_report(const pbrt_params_t *params, import_notes_t *notes);

const char *pbrt_type_name(pbrt_type_t type);

#endif
