#include "client/import/ply.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/import/stored_file.h"
#include "scene/scene.h"

enum { MAX_ELEMENTS = 16, MAX_PROPERTIES = 64, NAME_SIZE = 32, WORD_SIZE = 64, MAX_CORNERS = 1 << 16 };

typedef enum ply_format { ASCII, LITTLE, BIG } ply_format_t;
typedef enum ply_type { I8, U8, I16, U16, I32, U32, F32, F64, TYPES } ply_type_t;
typedef enum ply_slot { X, Y, Z, NX, NY, NZ, U, V, CORNERS, IGNORED } ply_slot_t;

static const size_t type_sizes[TYPES] = {1, 1, 2, 2, 4, 4, 4, 8};

typedef struct property {
    ply_type_t type, count_type; /* count_type: of a list's length */
    bool list;
    ply_slot_t slot;
} property_t;

typedef struct element {
    char name[NAME_SIZE];
    uint64_t count;
    int properties;
    property_t property[MAX_PROPERTIES];
} element_t;

typedef struct reader {
    const uint8_t *data;
    size_t size, at;
    uint64_t line; /* ascii and header */
    ply_format_t format;
    int elements;
    element_t element[MAX_ELEMENTS];
    ply_mesh_t *out;
    uint64_t index_capacity; /* in triangles */
    fault_t *fault;
} reader_t;

void ply_mesh_clear(ply_mesh_t *mesh)
{
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->uvs);
    free(mesh->indices);
    memset(mesh, 0, sizeof *mesh);
}

/* ---- header ---- */

/* The next line's words, at most `limit`; false if one of them is too long (it is cut). */
static bool next_line(reader_t *r, char words[][WORD_SIZE], int limit, int *count)
{
    const uint8_t *end = memchr(r->data + r->at, '\n', r->size - r->at);
    const size_t stop = end ? (size_t)(end - r->data) : r->size;
    bool fits = true;
    r->line++;
    *count = 0;
    for (size_t i = r->at; i < stop && *count < limit; i++) {
        size_t length = 0;
        while (i < stop && (r->data[i] == ' ' || r->data[i] == '\t' || r->data[i] == '\r'))
            i++;
        for (; i < stop && r->data[i] != ' ' && r->data[i] != '\t' && r->data[i] != '\r'; i++)
            if (length < WORD_SIZE - 1)
                words[*count][length++] = (char)r->data[i];
            else
                fits = false;
        words[*count][length] = 0;
        *count += length > 0;
    }
    r->at = end ? stop + 1 : r->size;
    return fits;
}

static bool parse_type(const char *word, ply_type_t *type)
{
    static const struct {
        const char *name;
        ply_type_t type;
    } names[] = {{"char", I8},   {"int8", I8},     {"uchar", U8},   {"uint8", U8},
                 {"short", I16}, {"int16", I16},   {"ushort", U16}, {"uint16", U16},
                 {"int", I32},   {"int32", I32},   {"uint", U32},   {"uint32", U32},
                 {"float", F32}, {"float32", F32}, {"double", F64}, {"float64", F64}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(word, names[i].name) == 0) {
            *type = names[i].type;
            return true;
        }
    return false;
}

static ply_slot_t slot_of(const char *element, const char *name, bool list)
{
    static const struct {
        const char *name;
        ply_slot_t slot;
    } names[] = {{"x", X},         {"y", Y},         {"z", Z},         {"nx", NX},      {"ny", NY},
                 {"nz", NZ},       {"u", U},         {"v", V},         {"s", U},        {"t", V},
                 {"texture_u", U}, {"texture_v", V}, {"texture_s", U}, {"texture_t", V}};
    if (strcmp(element, "face") == 0)
        return list && (strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0) ? CORNERS
                                                                                                  : IGNORED;
    if (strcmp(element, "vertex") != 0 || list)
        return IGNORED;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(name, names[i].name) == 0)
            return names[i].slot;
    return IGNORED;
}

static fault_code_t header_fault(reader_t *r, const char *what, const char *found)
{
    return fault_set(r->fault, FAULT_FORMAT, "line %llu of the PLY header: %s%s%s%s", (unsigned long long)r->line,
                     what, found ? " \"" : "", found ? found : "", found ? "\"" : "");
}

static fault_code_t add_element(reader_t *r, const char *name, const char *count)
{
    char *end;
    if (r->elements == MAX_ELEMENTS)
        return header_fault(r, "too many elements", NULL);
    element_t *e = &r->element[r->elements++];
    memset(e, 0, sizeof *e);
    snprintf(e->name, sizeof e->name, "%.*s", NAME_SIZE - 1, name);
    e->count = strtoull(count, &end, 10);
    if (*end || count[0] < '0' || count[0] > '9' || e->count > SCENE_MAX_VERTICES)
        return header_fault(r, "an element count, found", count);
    return FAULT_NONE;
}

static fault_code_t add_property(reader_t *r, char words[][WORD_SIZE], int count)
{
    if (r->elements == 0)
        return header_fault(r, "a property before any element", NULL);
    element_t *e = &r->element[r->elements - 1];
    if (e->properties == MAX_PROPERTIES)
        return header_fault(r, "too many properties", NULL);
    property_t p = {.list = strcmp(words[1], "list") == 0};
    if (count != (p.list ? 5 : 3))
        return header_fault(r, "a property of unexpected form", NULL);
    if (p.list && (!parse_type(words[2], &p.count_type) || p.count_type >= F32))
        return header_fault(r, "expected an integer type, found", words[2]);
    const char *type = words[p.list ? 3 : 1];
    if (!parse_type(type, &p.type))
        return header_fault(r, "unknown type", type);
    p.slot = slot_of(e->name, words[p.list ? 4 : 2], p.list);
    for (int i = 0; i < e->properties; i++)
        if (p.slot != IGNORED && e->property[i].slot == p.slot)
            return header_fault(r, "a property that is there twice", words[p.list ? 4 : 2]);
    e->property[e->properties++] = p;
    return FAULT_NONE;
}

static fault_code_t read_format(reader_t *r, const char *word, const char *version)
{
    if (strcmp(word, "ascii") == 0)
        r->format = ASCII;
    else if (strcmp(word, "binary_little_endian") == 0)
        r->format = LITTLE;
    else if (strcmp(word, "binary_big_endian") == 0)
        r->format = BIG;
    else
        return header_fault(r, "expected ascii, binary_little_endian or binary_big_endian, found", word);
    if (strcmp(version, "1.0") != 0)
        return header_fault(r, "expected version 1.0, found", version);
    return FAULT_NONE;
}

static fault_code_t read_header(reader_t *r)
{
    char words[6][WORD_SIZE];
    int count;
    bool format = false;
    if (r->size == 0 || !next_line(r, words, 6, &count) || count != 1 || strcmp(words[0], "ply") != 0)
        return fault_set(r->fault, FAULT_FORMAT, "not a PLY file: expected \"ply\" in the first line");
    for (;;) {
        if (r->line > 1000 || (r->at >= r->size))
            return header_fault(r, "expected end_header", NULL);
        const bool fits = next_line(r, words, 6, &count);
        if (count == 0 || strcmp(words[0], "comment") == 0 || strcmp(words[0], "obj_info") == 0)
            continue;
        if (!fits)
            return header_fault(r, "a word that is too long", NULL);
        if (strcmp(words[0], "end_header") == 0)
            break;
        if (strcmp(words[0], "format") == 0 && count == 3 && !format) {
            TRY(read_format(r, words[1], words[2]));
            format = true;
        } else if (strcmp(words[0], "element") == 0 && count == 3) {
            TRY(add_element(r, words[1], words[2]));
        } else if (strcmp(words[0], "property") == 0 && count >= 3) {
            TRY(add_property(r, words, count));
        } else {
            return header_fault(r, "unexpected", words[0]);
        }
    }
    if (!format)
        return header_fault(r, "the format is missing", NULL);
    r->line++;
    return FAULT_NONE;
}

/* ---- values ---- */

static fault_code_t ends_early(reader_t *r, const element_t *e, uint64_t i)
{
    return fault_set(r->fault, FAULT_FORMAT, "the PLY file ends in %s %llu of %llu", e->name, (unsigned long long)i,
                     (unsigned long long)e->count);
}

static double binary_value(const uint8_t *data, ply_type_t type, bool swap)
{
    uint64_t bits = 0;
    const size_t size = type_sizes[type];
    for (size_t i = 0; i < size; i++)
        bits |= (uint64_t)data[swap ? size - 1 - i : i] << (8 * i);
    float f;
    double d;
    switch (type) {
    case I8:
        return (int8_t)bits;
    case I16:
        return (int16_t)bits;
    case I32:
        return (int32_t)bits;
    case F32:
        memcpy(&f, &(uint32_t){(uint32_t)bits}, 4);
        return f;
    case F64:
        memcpy(&d, &bits, 8);
        return d;
    default:
        return (double)bits;
    }
}

static bool is_space(uint8_t c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

static fault_code_t ascii_value(reader_t *r, const element_t *e, uint64_t i, double *value)
{
    while (r->at < r->size && is_space(r->data[r->at]))
        r->line += r->data[r->at++] == '\n';
    char word[WORD_SIZE], *end;
    size_t length = 0;
    while (r->at < r->size && !is_space(r->data[r->at]) && length < WORD_SIZE - 1)
        word[length++] = (char)r->data[r->at++];
    word[length] = 0;
    if (length == 0)
        return ends_early(r, e, i);
    *value = strtod(word, &end);
    if (*end || end == word || strpbrk(word, "xXnN"))
        return fault_set(r->fault, FAULT_FORMAT, "line %llu of the PLY file: expected a number, found \"%.20s\"",
                         (unsigned long long)r->line, word);
    return FAULT_NONE;
}

static fault_code_t next_value(reader_t *r, const element_t *e, uint64_t i, ply_type_t type, double *value)
{
    if (r->format == ASCII)
        return ascii_value(r, e, i, value);
    if (r->size - r->at < type_sizes[type])
        return ends_early(r, e, i);
    *value = binary_value(r->data + r->at, type, r->format == BIG);
    r->at += type_sizes[type];
    return FAULT_NONE;
}

/* The fewest bytes that one record of the element takes. */
static uint64_t smallest_record(const reader_t *r, const element_t *e)
{
    uint64_t bytes = 0;
    for (int i = 0; i < e->properties; i++) {
        const property_t *p = &e->property[i];
        bytes += r->format == ASCII ? 2 : type_sizes[p->list ? p->count_type : p->type];
    }
    return bytes;
}

static fault_code_t check_count(reader_t *r, const element_t *e)
{
    const uint64_t bytes = smallest_record(r, e);
    /* The last number of an ascii file needs no white space after it. */
    if (e->properties == 0 && e->count > 0)
        return fault_set(r->fault, FAULT_FORMAT, "the PLY element %s has no properties", e->name);
    if (e->count > 0 && e->count > (r->size - r->at + 1) / bytes)
        return fault_set(r->fault, FAULT_FORMAT, "%llu records of the PLY element %s do not fit into %zu bytes",
                         (unsigned long long)e->count, e->name, r->size - r->at);
    return FAULT_NONE;
}

/* ---- elements ---- */

static bool has_slots(const element_t *e, ply_slot_t first, int count)
{
    int found = 0;
    for (int i = 0; i < e->properties; i++)
        found += e->property[i].slot >= first && (int)e->property[i].slot < (int)first + count;
    return found == count;
}

static fault_code_t allocate_vertices(reader_t *r, const element_t *e)
{
    ply_mesh_t *out = r->out;
    if (!has_slots(e, X, 3))
        return fault_set(r->fault, FAULT_FORMAT, "the PLY vertices have no x, y, z");
    if (out->positions)
        return fault_set(r->fault, FAULT_FORMAT, "the PLY file has vertices twice");
    out->vertices = e->count;
    out->positions = malloc((size_t)(3 * e->count + 1) * sizeof(float));
    if (has_slots(e, NX, 3))
        out->normals = malloc((size_t)(3 * e->count + 1) * sizeof(float));
    if (has_slots(e, U, 2))
        out->uvs = malloc((size_t)(2 * e->count + 1) * sizeof(float));
    if (!out->positions || (has_slots(e, NX, 3) && !out->normals) || (has_slots(e, U, 2) && !out->uvs))
        return fault_set(r->fault, FAULT_MEMORY, "no memory for %llu vertices", (unsigned long long)e->count);
    return FAULT_NONE;
}

static fault_code_t skip_list(reader_t *r, const element_t *e, uint64_t i, const property_t *p)
{
    double length, value;
    TRY(next_value(r, e, i, p->count_type, &length));
    if (!(length >= 0 && length <= UINT32_MAX))
        return fault_set(r->fault, FAULT_FORMAT, "a list of %g values in %s %llu", length, e->name,
                         (unsigned long long)i);
    for (uint64_t j = 0; j < (uint64_t)length; j++)
        TRY(next_value(r, e, i, p->type, &value));
    return FAULT_NONE;
}

static fault_code_t read_vertex(reader_t *r, const element_t *e, uint64_t i)
{
    double value[IGNORED + 1] = {0};
    for (int j = 0; j < e->properties; j++) {
        const property_t *p = &e->property[j];
        if (p->list)
            TRY(skip_list(r, e, i, p));
        else
            TRY(next_value(r, e, i, p->type, &value[p->slot]));
    }
    for (int j = X; j <= V; j++)
        if (!(fabs(value[j]) <= 3e38))
            return fault_set(r->fault, FAULT_FORMAT, "a number of vertex %llu is not finite",
                             (unsigned long long)i);
    ply_mesh_t *out = r->out;
    for (int j = 0; j < 3; j++)
        out->positions[3 * i + (uint64_t)j] = (float)value[X + j];
    for (int j = 0; out->normals && j < 3; j++)
        out->normals[3 * i + (uint64_t)j] = (float)value[NX + j];
    for (int j = 0; out->uvs && j < 2; j++)
        out->uvs[2 * i + (uint64_t)j] = (float)value[U + j];
    return FAULT_NONE;
}

static fault_code_t add_triangle(reader_t *r, uint32_t a, uint32_t b, uint32_t c)
{
    ply_mesh_t *out = r->out;
    if (out->triangles == r->index_capacity) {
        const uint64_t capacity = r->index_capacity ? 2 * r->index_capacity : 1024;
        uint32_t *indices = capacity > 2 * SCENE_MAX_TRIANGLES
                                ? NULL
                                : realloc(out->indices, (size_t)(3 * capacity) * sizeof *indices);
        if (!indices)
            return fault_set(r->fault, FAULT_MEMORY, "no memory for %llu triangles", (unsigned long long)capacity);
        out->indices = indices;
        r->index_capacity = capacity;
    }
    uint32_t *to = out->indices + 3 * out->triangles++;
    to[0] = a;
    to[1] = b;
    to[2] = c;
    return FAULT_NONE;
}

static fault_code_t read_polygon(reader_t *r, const element_t *e, uint64_t i, const property_t *p)
{
    double length, value;
    uint32_t first = 0, last = 0;
    TRY(next_value(r, e, i, p->count_type, &length));
    if (!(length >= 0 && length <= MAX_CORNERS))
        return fault_set(r->fault, FAULT_FORMAT, "face %llu has %g corners: expected at most %d",
                         (unsigned long long)i, length, MAX_CORNERS);
    const uint32_t corners = (uint32_t)length;
    for (uint32_t j = 0; j < corners; j++) {
        TRY(next_value(r, e, i, p->type, &value));
        if (!(value >= 0 && value < 4294967295.0) || value != floor(value))
            return fault_set(r->fault, FAULT_FORMAT, "face %llu names the vertex %g", (unsigned long long)i, value);
        const uint32_t corner = (uint32_t)value;
        if (j >= 2)
            TRY(add_triangle(r, first, last, corner));
        if (j == 0)
            first = corner;
        last = corner;
    }
    r->out->small_faces += corners < 3;
    return FAULT_NONE;
}

static fault_code_t read_element(reader_t *r, const element_t *e)
{
    const bool vertex = strcmp(e->name, "vertex") == 0;
    TRY(check_count(r, e));
    if (vertex)
        TRY(allocate_vertices(r, e));
    for (uint64_t i = 0; i < e->count; i++) {
        if (vertex) {
            TRY(read_vertex(r, e, i));
            continue;
        }
        for (int j = 0; j < e->properties; j++) {
            const property_t *p = &e->property[j];
            double value;
            if (p->slot == CORNERS)
                TRY(read_polygon(r, e, i, p));
            else if (p->list)
                TRY(skip_list(r, e, i, p));
            else
                TRY(next_value(r, e, i, p->type, &value));
        }
    }
    return FAULT_NONE;
}

static fault_code_t check_mesh(const reader_t *r)
{
    const ply_mesh_t *out = r->out;
    if (!out->positions)
        return fault_set(r->fault, FAULT_FORMAT, "the PLY file has no vertices");
    for (uint64_t i = 0; i < 3 * out->triangles; i++)
        if (out->indices[i] >= out->vertices)
            return fault_set(r->fault, FAULT_FORMAT, "a face names vertex %u, but there are %llu", out->indices[i],
                             (unsigned long long)out->vertices);
    return FAULT_NONE;
}

static fault_code_t parse(reader_t *r)
{
    TRY(read_header(r));
    for (int i = 0; i < r->elements; i++)
        TRY(read_element(r, &r->element[i]));
    return check_mesh(r);
}

fault_code_t ply_parse(const uint8_t *data, size_t size, ply_mesh_t *out, fault_t *fault)
{
    memset(out, 0, sizeof *out);
    reader_t *reader = calloc(1, sizeof *reader);
    if (!reader)
        return fault_set(fault, FAULT_MEMORY, "no memory for a PLY reader");
    reader->data = data;
    reader->size = size;
    reader->out = out;
    reader->fault = fault;
    const fault_code_t code = parse(reader);
    if (code)
        ply_mesh_clear(out);
    free(reader);
    return code;
}

fault_code_t ply_read(const char *path, ply_mesh_t *out, fault_t *fault)
{
    memset(out, 0, sizeof *out);
    uint8_t *data = NULL;
    size_t size = 0;
    TRY(stored_file_read(path, &data, &size, fault));
    const fault_code_t code = ply_parse(data, size, out, fault);
    free(data);
    return fault_prefix(fault, code, "%s", path);
}
