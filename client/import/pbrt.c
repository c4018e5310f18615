#include "client/import/pbrt.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "client/import/pbrt_camera.h"
#include "client/import/pbrt_lights.h"
#include "client/import/pbrt_materials.h"
#include "client/import/pbrt_shapes.h"
#include "client/import/pbrt_state.h"
#include "client/import/pbrt_textures.h"
#include "client/import/stored_file.h"

/* ---- words and numbers after a directive ---- */

static fault_code_t next_token(pbrt_state_t *state, pbrt_token_t *token)
{
    const fault_code_t code = pbrt_lexer_next(state->lexer, token, state->fault);
    if (code) {
        state->line = state->lexer->fault_line;
        state->column = state->lexer->fault_column;
    }
    return code;
}

static fault_code_t unexpected(pbrt_state_t *state, const pbrt_token_t *token, const char *expected)
{
    char shown[64];
    state->line = token->line;
    state->column = token->column;
    return pbrt_fault(state, FAULT_SYNTAX, "expected %s, found %s", expected,
                      pbrt_token_describe(token, shown, sizeof shown));
}

static fault_code_t next_string(pbrt_state_t *state, char *text, size_t size, const char *expected)
{
    pbrt_token_t token;
    TRY(next_token(state, &token));
    if (token.kind != PBRT_STRING || !pbrt_token_string(&token, text, size))
        return unexpected(state, &token, expected);
    return FAULT_NONE;
}

/* `count` numbers, with or without brackets around them. */
static fault_code_t next_numbers(pbrt_state_t *state, double *values, int count)
{
    pbrt_token_t token;
    TRY(next_token(state, &token));
    const bool brackets = token.kind == PBRT_OPEN;
    if (brackets)
        TRY(next_token(state, &token));
    for (int i = 0; i < count; i++) {
        if (!pbrt_token_number(&token, &values[i]))
            return unexpected(state, &token, "a number");
        if (i + 1 < count || brackets)
            TRY(next_token(state, &token));
    }
    return brackets && token.kind != PBRT_CLOSE ? unexpected(state, &token, "']'") : FAULT_NONE;
}

/* Reads the parameters of `directive "kind"`. */
static fault_code_t next_params(pbrt_state_t *state, pbrt_params_t *params, const char *directive, const char *kind,
                                const pbrt_default_t *defaults)
{
    memset(params, 0, sizeof *params);
    snprintf(params->what, sizeof params->what, "%s \"%.200s\"", directive, kind);
    params->file = state->file;
    params->line = state->line;
    params->defaults = defaults;
    const fault_code_t code = pbrt_at_params(state, params, pbrt_params_parse(state->lexer, params, state->fault));
    if (code)
        pbrt_params_clear(params);
    return code;
}

/* ---- transformations ---- */

static fault_code_t set_ctm(pbrt_state_t *state, const transform_t *ctm)
{
    if (!transform_finite(ctm))
        return pbrt_fault(state, FAULT_RANGE, "the transformation's numbers are too large");
    if (!state->now.end_time_only)
        state->now.ctm = *ctm;
    return FAULT_NONE;
}

static fault_code_t concatenate(pbrt_state_t *state, const transform_t *more)
{
    const transform_t ctm = transform_mul(&state->now.ctm, more);
    return set_ctm(state, &ctm);
}

/* The file has the columns one after the other; a last row (0,0,0,w) is divided out. */
static fault_code_t next_matrix(pbrt_state_t *state, transform_t *out)
{
    double v[16];
    TRY(next_numbers(state, v, 16));
    const double w = v[3] == 0 && v[7] == 0 && v[11] == 0 && v[15] != 0 ? v[15] : 1;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            out->m[i][j] = v[4 * j + i] / w;
    return FAULT_NONE;
}

static fault_code_t do_transform(pbrt_state_t *state)
{
    transform_t m;
    TRY(next_matrix(state, &m));
    return set_ctm(state, &m);
}

static fault_code_t do_concat_transform(pbrt_state_t *state)
{
    transform_t m;
    TRY(next_matrix(state, &m));
    return concatenate(state, &m);
}

static fault_code_t do_identity(pbrt_state_t *state)
{
    const transform_t m = transform_identity();
    return set_ctm(state, &m);
}

static fault_code_t do_translate(pbrt_state_t *state)
{
    double v[3];
    TRY(next_numbers(state, v, 3));
    const transform_t m = transform_translate(v[0], v[1], v[2]);
    return concatenate(state, &m);
}

static fault_code_t do_scale(pbrt_state_t *state)
{
    double v[3];
    TRY(next_numbers(state, v, 3));
    const transform_t m = transform_scale(v[0], v[1], v[2]);
    return concatenate(state, &m);
}

static fault_code_t do_rotate(pbrt_state_t *state)
{
    double v[4];
    TRY(next_numbers(state, v, 4));
    const vec3_t axis = vec3(v[1], v[2], v[3]);
    if (!(vec3_length(axis) > 0) || !isfinite(vec3_length(axis)))
        return pbrt_fault(state, FAULT_RANGE, "Rotate about the axis (%g, %g, %g)", v[1], v[2], v[3]);
    const transform_t m = transform_rotate(v[0], axis);
    return concatenate(state, &m);
}

static fault_code_t do_look_at(pbrt_state_t *state)
{
    double v[9];
    transform_t m;
    TRY(next_numbers(state, v, 9));
    if (!transform_look_at(vec3(v[0], v[1], v[2]), vec3(v[3], v[4], v[5]), vec3(v[6], v[7], v[8]), &m))
        return pbrt_fault(state, FAULT_RANGE, "LookAt: eye, target and up do not give a direction and an upright");
    return concatenate(state, &m);
}

static fault_code_t do_coordinate_system(pbrt_state_t *state)
{
    char name[PBRT_NAME_MAX];
    TRY(next_string(state, name, sizeof name, "the coordinate system's name"));
    return pbrt_set_space(state, name, &state->now.ctm);
}

static fault_code_t do_coord_sys_transform(pbrt_state_t *state)
{
    char name[PBRT_NAME_MAX];
    TRY(next_string(state, name, sizeof name, "the coordinate system's name"));
    const int32_t index = name_table_get(&state->spaces, name, -1);
    if (index < 0) {
        pbrt_note(state, "there is no coordinate system \"%s\": CoordSysTransform has no effect", name);
        return FAULT_NONE;
    }
    return set_ctm(state, &state->space_list[index]);
}

static fault_code_t do_transform_times(pbrt_state_t *state)
{
    double v[2];
    TRY(next_numbers(state, v, 2));
    pbrt_note(state, "motion is not supported: everything stands as at the start");
    return FAULT_NONE;
}

static fault_code_t do_active_transform(pbrt_state_t *state)
{
    pbrt_token_t token;
    TRY(next_token(state, &token));
    const bool end = pbrt_token_is(&token, "EndTime");
    if (!end && !pbrt_token_is(&token, "StartTime") && !pbrt_token_is(&token, "All"))
        return unexpected(state, &token, "StartTime, EndTime or All");
    if (end)
        pbrt_note(state, "motion is not supported: everything stands as at the start");
    state->now.end_time_only = end;
    return FAULT_NONE;
}

static fault_code_t do_reverse_orientation(pbrt_state_t *state)
{
    state->now.reverse = !state->now.reverse;
    return FAULT_NONE;
}

/* ---- attributes ---- */

static fault_code_t do_attribute_begin(pbrt_state_t *state)
{
    return pbrt_push(state, 'A');
}

static fault_code_t do_attribute_end(pbrt_state_t *state)
{
    return pbrt_pop(state, 'A', "AttributeEnd");
}

static fault_code_t do_transform_begin(pbrt_state_t *state)
{
    pbrt_note(state, "TransformBegin is read as AttributeBegin, as pbrt-v4 does");
    return pbrt_push(state, 'A');
}

static fault_code_t do_transform_end(pbrt_state_t *state)
{
    return pbrt_pop(state, 'A', "TransformEnd");
}

static fault_code_t do_attribute(pbrt_state_t *state)
{
    static const char *const targets[PBRT_TARGETS] = {"shape", "light", "material", "medium", "texture"};
    char name[PBRT_NAME_MAX];
    pbrt_params_t params;
    int target = 0;
    TRY(next_string(state, name, sizeof name, "what the attributes are for"));
    while (target < PBRT_TARGETS && strcmp(name, targets[target]) != 0)
        target++;
    if (target == PBRT_TARGETS)
        return pbrt_fault(
            state, FAULT_UNKNOWN,
            "Attribute \"%s\": expected \"shape\", \"light\", \"material\", \"medium\" or \"texture\"", name);
    TRY(next_params(state, &params, "Attribute", name, NULL));
    fault_code_t code = FAULT_NONE;
    for (size_t i = 0; code == FAULT_NONE && i < params.count; i++)
        code = pbrt_add_default(state, (pbrt_target_t)target, &params.items[i]);
    pbrt_params_clear(&params);
    return code;
}

/* ---- directives with parameters ---- */

typedef fault_code_t params_fn(pbrt_state_t *state, const char *kind, pbrt_params_t *params);

/* `directive "kind" parameters`: reads them, does it, notes what was not understood. */
static fault_code_t with_params(pbrt_state_t *state, const char *directive, const pbrt_default_t *defaults,
                                params_fn *act)
{
    char kind[PBRT_NAME_MAX];
    pbrt_params_t params;
    TRY(next_string(state, kind, sizeof kind, "the kind, a string"));
    TRY(next_params(state, &params, directive, kind, defaults));
    const fault_code_t code = act(state, kind, &params);
    if (code == FAULT_NONE)
        pbrt_params_report(&params, state->notes);
    pbrt_params_clear(&params);
    return code;
}

static fault_code_t ignore_params(pbrt_state_t *state, const char *kind, pbrt_params_t *params)
{
    (void)state, (void)kind;
    for (size_t i = 0; i < params->count; i++)
        params->items[i].used = true;
    return FAULT_NONE;
}

static fault_code_t do_camera(pbrt_state_t *state)
{
    return with_params(state, "Camera", NULL, pbrt_camera);
}

static fault_code_t do_film(pbrt_state_t *state)
{
    return with_params(state, "Film", NULL, pbrt_film);
}

static fault_code_t do_pixel_filter(pbrt_state_t *state)
{
    return with_params(state, "PixelFilter", NULL, pbrt_filter);
}

static fault_code_t do_integrator(pbrt_state_t *state)
{
    return with_params(state, "Integrator", NULL, pbrt_integrator);
}

static fault_code_t do_sampler(pbrt_state_t *state)
{
    return with_params(state, "Sampler", NULL, ignore_params);
}

static fault_code_t do_accelerator(pbrt_state_t *state)
{
    return with_params(state, "Accelerator", NULL, ignore_params);
}

static fault_code_t do_shape(pbrt_state_t *state)
{
    return with_params(state, "Shape", state->now.defaults[PBRT_TARGET_SHAPE], pbrt_shape);
}

static fault_code_t do_light_source(pbrt_state_t *state)
{
    return with_params(state, "LightSource", state->now.defaults[PBRT_TARGET_LIGHT], pbrt_light);
}

static fault_code_t do_area_light_source(pbrt_state_t *state)
{
    return with_params(state, "AreaLightSource", state->now.defaults[PBRT_TARGET_LIGHT], pbrt_area_light);
}

static fault_code_t act_material(pbrt_state_t *state, const char *kind, pbrt_params_t *params)
{
    return pbrt_material(state, kind, params, &state->now.material);
}

static fault_code_t do_material(pbrt_state_t *state)
{
    return with_params(state, "Material", state->now.defaults[PBRT_TARGET_MATERIAL], act_material);
}

static fault_code_t act_named_material(pbrt_state_t *state, const char *name, pbrt_params_t *params)
{
    const char *kind = NULL;
    int32_t index;
    PBRT_TRY(state, params, pbrt_params_string(params, "type", &kind, state->fault));
    if (!kind)
        return pbrt_fault(state, FAULT_FORMAT, "%s has no \"string type\"", params->what);
    if (name_table_get(&state->materials, name, -1) >= 0)
        return pbrt_fault(state, FAULT_SYNTAX, "the material \"%s\" is defined twice", name);
    TRY(pbrt_material(state, kind, params, &index));
    return name_table_set(&state->materials, name, index, state->fault);
}

static fault_code_t do_make_named_material(pbrt_state_t *state)
{
    return with_params(state, "MakeNamedMaterial", state->now.defaults[PBRT_TARGET_MATERIAL], act_named_material);
}

static fault_code_t do_named_material(pbrt_state_t *state)
{
    char name[PBRT_NAME_MAX];
    TRY(next_string(state, name, sizeof name, "the material's name"));
    const int32_t index = name_table_get(&state->materials, name, -1);
    if (index < 0)
        return pbrt_fault(state, FAULT_UNKNOWN, "there is no material \"%s\" before this line", name);
    state->now.material = index;
    return FAULT_NONE;
}

static fault_code_t act_medium(pbrt_state_t *state, const char *name, pbrt_params_t *params)
{
    pbrt_note(state, "participating media are not supported and are ignored");
    return ignore_params(state, name, params);
}

static fault_code_t do_make_named_medium(pbrt_state_t *state)
{
    return with_params(state, "MakeNamedMedium", NULL, act_medium);
}

/* One name for both sides, or one for each. */
static fault_code_t do_medium_interface(pbrt_state_t *state)
{
    char inside[PBRT_NAME_MAX], outside[PBRT_NAME_MAX] = "";
    pbrt_token_t token;
    TRY(next_string(state, inside, sizeof inside, "the inner medium's name"));
    const fault_code_t code = pbrt_lexer_peek(state->lexer, &token, state->fault);
    if (code) {
        state->line = state->lexer->fault_line;
        state->column = state->lexer->fault_column;
        return code;
    }
    if (token.kind == PBRT_STRING)
        TRY(next_string(state, outside, sizeof outside, "the outer medium's name"));
    if (inside[0] || outside[0])
        pbrt_note(state, "participating media are not supported and are ignored");
    return FAULT_NONE;
}

static fault_code_t do_texture(pbrt_state_t *state)
{
    char name[PBRT_NAME_MAX], type[PBRT_NAME_MAX], kind[PBRT_NAME_MAX];
    pbrt_params_t params;
    TRY(next_string(state, name, sizeof name, "the texture's name"));
    TRY(next_string(state, type, sizeof type, "\"float\" or \"spectrum\""));
    TRY(next_string(state, kind, sizeof kind, "the kind of texture"));
    TRY(next_params(state, &params, "Texture", kind, state->now.defaults[PBRT_TARGET_TEXTURE]));
    const fault_code_t code = pbrt_texture(state, name, type, kind, &params);
    if (code == FAULT_NONE)
        pbrt_params_report(&params, state->notes);
    pbrt_params_clear(&params);
    return code;
}

static fault_code_t do_option(pbrt_state_t *state)
{
    pbrt_params_t params;
    TRY(next_params(state, &params, "Option", "", NULL));
    for (size_t i = 0; i < params.count; i++)
        pbrt_note(state, "Option \"%s\" is ignored", params.items[i].name);
    pbrt_params_clear(&params);
    return FAULT_NONE;
}

static fault_code_t do_color_space(pbrt_state_t *state)
{
    char name[PBRT_NAME_MAX];
    TRY(next_string(state, name, sizeof name, "the colour space's name"));
    if (strcmp(name, "srgb") != 0)
        pbrt_note(state, "ColorSpace \"%s\" is not supported: \"srgb\" is used", name);
    return FAULT_NONE;
}

/* ---- objects and world ---- */

static fault_code_t do_object_begin(pbrt_state_t *state)
{
    char name[PBRT_NAME_MAX];
    TRY(next_string(state, name, sizeof name, "the object's name"));
    return pbrt_object_begin(state, name);
}

static fault_code_t do_object_end(pbrt_state_t *state)
{
    return pbrt_object_end(state);
}

static fault_code_t do_object_instance(pbrt_state_t *state)
{
    char name[PBRT_NAME_MAX];
    TRY(next_string(state, name, sizeof name, "the object's name"));
    return pbrt_object_instance(state, name);
}

static fault_code_t do_world_begin(pbrt_state_t *state)
{
    const transform_t identity = transform_identity();
    TRY(pbrt_set_camera(state));
    state->in_world = true;
    state->now.ctm = identity;
    state->now.end_time_only = false;
    return pbrt_set_space(state, "world", &identity);
}

static fault_code_t do_world_end(pbrt_state_t *state)
{
    pbrt_note(state, "WorldEnd is not part of pbrt-v4 and is ignored");
    return FAULT_NONE;
}

/* ---- files ---- */

static fault_code_t read_file(pbrt_state_t *state, const char *path);

static fault_code_t do_include(pbrt_state_t *state)
{
    char name[PBRT_STRING_MAX], path[PBRT_PATH_MAX];
    TRY(next_string(state, name, sizeof name, "a file name"));
    TRY(pbrt_resolve(state, name, path));
    return read_file(state, path);
}

/* As Include, but what the file does to the graphics state ends with it. */
static fault_code_t do_import(pbrt_state_t *state)
{
    char name[PBRT_STRING_MAX], path[PBRT_PATH_MAX];
    TRY(next_string(state, name, sizeof name, "a file name"));
    TRY(pbrt_resolve(state, name, path));
    TRY(pbrt_push(state, 'I'));
    TRY(read_file(state, path));
    return pbrt_pop(state, 'I', "the end of an imported file that leaves attributes open");
}

typedef enum where { ANYWHERE, BEFORE_WORLD, IN_WORLD } where_t;

static const struct {
    const char *name;
    where_t where;
    fault_code_t (*act)(pbrt_state_t *state);
} directives[] = {
    {"Shape", IN_WORLD, do_shape},
    {"NamedMaterial", ANYWHERE, do_named_material},
    {"Material", ANYWHERE, do_material},
    {"AttributeBegin", IN_WORLD, do_attribute_begin},
    {"AttributeEnd", IN_WORLD, do_attribute_end},
    {"ObjectInstance", IN_WORLD, do_object_instance},
    {"Transform", ANYWHERE, do_transform},
    {"ConcatTransform", ANYWHERE, do_concat_transform},
    {"Translate", ANYWHERE, do_translate},
    {"Rotate", ANYWHERE, do_rotate},
    {"Scale", ANYWHERE, do_scale},
    {"Identity", ANYWHERE, do_identity},
    {"LookAt", ANYWHERE, do_look_at},
    {"ReverseOrientation", IN_WORLD, do_reverse_orientation},
    {"MakeNamedMaterial", IN_WORLD, do_make_named_material},
    {"Texture", IN_WORLD, do_texture},
    {"AreaLightSource", IN_WORLD, do_area_light_source},
    {"LightSource", IN_WORLD, do_light_source},
    {"ObjectBegin", IN_WORLD, do_object_begin},
    {"ObjectEnd", IN_WORLD, do_object_end},
    {"Attribute", ANYWHERE, do_attribute},
    {"CoordinateSystem", ANYWHERE, do_coordinate_system},
    {"CoordSysTransform", ANYWHERE, do_coord_sys_transform},
    {"TransformTimes", BEFORE_WORLD, do_transform_times},
    {"ActiveTransform", ANYWHERE, do_active_transform},
    {"TransformBegin", IN_WORLD, do_transform_begin},
    {"TransformEnd", IN_WORLD, do_transform_end},
    {"MakeNamedMedium", ANYWHERE, do_make_named_medium},
    {"MediumInterface", ANYWHERE, do_medium_interface},
    {"Include", ANYWHERE, do_include},
    {"Import", IN_WORLD, do_import},
    {"Option", BEFORE_WORLD, do_option},
    {"ColorSpace", ANYWHERE, do_color_space},
    {"Camera", BEFORE_WORLD, do_camera},
    {"Film", BEFORE_WORLD, do_film},
    {"PixelFilter", BEFORE_WORLD, do_pixel_filter},
    {"Integrator", BEFORE_WORLD, do_integrator},
    {"Sampler", BEFORE_WORLD, do_sampler},
    {"Accelerator", BEFORE_WORLD, do_accelerator},
    {"WorldBegin", BEFORE_WORLD, do_world_begin},
    {"WorldEnd", IN_WORLD, do_world_end},
};

static fault_code_t act_on(pbrt_state_t *state, const pbrt_token_t *token)
{
    if (token->kind != PBRT_WORD)
        return unexpected(state, token, "a directive");
    for (size_t i = 0; i < sizeof directives / sizeof *directives; i++) {
        if (!pbrt_token_is(token, directives[i].name))
            continue;
        if (directives[i].where == IN_WORLD && !state->in_world)
            return pbrt_fault(state, FAULT_SYNTAX, "%s before WorldBegin", directives[i].name);
        if (directives[i].where == BEFORE_WORLD && state->in_world)
            return pbrt_fault(state, FAULT_SYNTAX, "%s after WorldBegin", directives[i].name);
        return directives[i].act(state);
    }
    return unexpected(state, token, "a directive");
}

/* The innermost place goes before the fault's text, once. */
static fault_code_t placed(pbrt_state_t *state, fault_code_t code)
{
    if (code && !state->placed) {
        state->placed = true;
        fault_prefix(state->fault, code, "%s:%d:%d", state->file, state->line, state->column);
    }
    return code;
}

static fault_code_t read_directives(pbrt_state_t *state)
{
    for (;;) {
        pbrt_token_t token;
        TRY(placed(state, next_token(state, &token)));
        state->line = token.line;
        state->column = token.column;
        if (token.kind == PBRT_END)
            return FAULT_NONE;
        TRY(placed(state, act_on(state, &token)));
    }
}

/* Reads the text as the file `name`; afterwards the place is again that of the directive that asked for it. */
static fault_code_t read_text(pbrt_state_t *state, const char *name, const char *text, size_t size)
{
    pbrt_lexer_t lexer, *const outer_lexer = state->lexer;
    const char *const outer_file = state->file;
    const int outer_line = state->line, outer_column = state->column;
    pbrt_lexer_init(&lexer, text, size);
    state->open_files[state->open_count++] = name;
    state->lexer = &lexer;
    state->file = name;
    const fault_code_t code = read_directives(state);
    state->open_count--;
    state->lexer = outer_lexer;
    state->file = outer_file;
    state->line = outer_line;
    state->column = outer_column;
    return code;
}

static fault_code_t read_file(pbrt_state_t *state, const char *path)
{
    uint8_t *data;
    size_t size;
    if (state->open_count == PBRT_MAX_INCLUDES)
        return pbrt_fault(state, FAULT_LIMIT, "more than %d files inside each other", PBRT_MAX_INCLUDES);
    for (int i = 0; i < state->open_count; i++)
        if (strcmp(state->open_files[i], path) == 0)
            return pbrt_fault(state, FAULT_SYNTAX, "the file %s includes itself", path);
    TRY(stored_file_read(path, &data, &size, state->fault));
    const fault_code_t code = read_text(state, path, (const char *)data, size);
    free(data);
    return code;
}

/* What the whole file must have, and what is said of all of it. */
static fault_code_t finish(pbrt_state_t *state, const char *name)
{
    fault_code_t code = FAULT_NONE;
    if (!state->in_world)
        code = pbrt_fault(state, FAULT_SYNTAX, "%s: the file ends without WorldBegin: it is no whole scene", name);
    else if (state->depth > 0)
        code = pbrt_fault(state, FAULT_SYNTAX, "%s: the file ends with %zu AttributeBegin or ObjectBegin open",
                          name, state->depth);
    TRY(code);
    if (state->degenerate > 0)
        import_notes_add(state->notes, state->degenerate_file, state->degenerate_line,
                         "%llu triangles of no area are left out", (unsigned long long)state->degenerate);
    if (state->no_normal > 0)
        import_notes_add(state->notes, state->degenerate_file, state->degenerate_line,
                         "%llu vertex normals have no length: those of their triangles are used",
                         (unsigned long long)state->no_normal);
    const scene_t scene = scene_builder_view(state->builder);
    return fault_prefix(state->fault, scene_check(&scene, state->fault), "%s: the scene it describes", name);
}

fault_code_t pbrt_read_text(const char *name, const char *folder, const char *text, size_t size,
                            scene_builder_t *builder, import_notes_t *notes, fault_t *fault)
{
    fault_t own;
    pbrt_state_t *state = malloc(sizeof *state);
    if (!state)
        return fault_set(fault, FAULT_MEMORY, "no memory to read %s", name);
    pbrt_state_init(state, builder, notes, fault ? fault : &own);
    snprintf(state->folder, sizeof state->folder, "%s", folder);
    fault_code_t code = read_text(state, name, text, size);
    if (code == FAULT_NONE)
        code = finish(state, name);
    pbrt_state_clear(state);
    free(state);
    return code;
}

fault_code_t pbrt_read(const char *path, scene_builder_t *builder, import_notes_t *notes, fault_t *fault)
{
    char folder[PBRT_PATH_MAX];
    uint8_t *data;
    size_t size;
    TRY(file_folder_of(folder, sizeof folder, path, fault));
    TRY(stored_file_read(path, &data, &size, fault));
    const fault_code_t code = pbrt_read_text(path, folder, (const char *)data, size, builder, notes, fault);
    free(data);
    return code;
}
