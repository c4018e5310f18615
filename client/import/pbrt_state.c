#include "client/import/pbrt_state.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

void pbrt_state_init(pbrt_state_t *state, scene_builder_t *builder, import_notes_t *notes, fault_t *fault)
{
    memset(state, 0, sizeof *state);
    state->builder = builder;
    state->notes = notes;
    state->fault = fault;
    state->now.ctm = transform_identity();
    state->now.material = state->default_material = SCENE_NONE;
    state->now.area = SCENE_NONE;
    /* pbrt's defaults. */
    state->view = (pbrt_view_t){.camera_from_world = transform_identity(),
                                .fov = 90,
                                .focal_distance = 1e6,
                                .width = 1280,
                                .height = 720,
                                .crop = {0, 1, 0, 1},
                                .imaging_scale = 1,
                                .filter = SCENE_FILTER_GAUSSIAN,
                                .filter_radius = {1.5, 1.5},
                                .filter_sigma = 0.5,
                                .max_depth = -1};
}

void pbrt_state_clear(pbrt_state_t *state)
{
    for (size_t i = 0; i < state->instanced_count; i++)
        geometry_clear(&state->instanced[i].geometry);
    for (size_t i = 0; i < state->default_count; i++) {
        pbrt_param_clear(&state->defaults[i]->param);
        free(state->defaults[i]);
    }
    name_table_t *tables[] = {&state->spaces,          &state->materials, &state->color_textures,
                              &state->scalar_textures, &state->images,    &state->objects};
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        name_table_clear(tables[i]);
    free(state->stack);
    free(state->space_list);
    free(state->texture_list);
    free(state->image_list);
    free(state->object_list);
    free(state->instanced);
    free(state->areas);
    free(state->defaults);
}

void pbrt_note(pbrt_state_t *state, const char *format, ...)
{
    char text[IMPORT_NOTE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    import_notes_add(state->notes, state->file, state->line, "%s", text);
}

fault_code_t pbrt_fault(pbrt_state_t *state, fault_code_t code, const char *format, ...)
{
    char text[FAULT_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return fault_set(state->fault, code, "%s", text);
}

fault_code_t pbrt_at_params(pbrt_state_t *state, const pbrt_params_t *params, fault_code_t code)
{
    if (code && params->fault_line > 0) {
        state->line = params->fault_line;
        state->column = params->fault_column;
    }
    return code;
}

fault_code_t pbrt_resolve(pbrt_state_t *state, const char *name, char path[PBRT_PATH_MAX])
{
    char folder[PBRT_PATH_MAX];
    if (!name[0])
        return pbrt_fault(state, FAULT_NOT_FOUND, "an empty file name");
    TRY(file_join(path, PBRT_PATH_MAX, state->folder, name, state->fault));
    if (file_exists(path))
        return FAULT_NONE;
    TRY(file_folder_of(folder, sizeof folder, state->file, state->fault));
    TRY(file_join(path, PBRT_PATH_MAX, folder, name, state->fault));
    if (file_exists(path))
        return FAULT_NONE;
    return pbrt_fault(state, FAULT_NOT_FOUND, "the file \"%s\" is not in %s%s%s", name, state->folder,
                      strcmp(folder, state->folder) ? " nor in " : "", strcmp(folder, state->folder) ? folder : "");
}

/* Capacities are powers of two: room runs out where the count reaches one. */
void *pbrt_grown(void *array, size_t count, size_t size)
{
    if (count > 0 && (count & (count - 1)) != 0)
        return array;
    return realloc(array, (count ? 2 * count : 1) * size);
}

fault_code_t pbrt_push(pbrt_state_t *state, char begun_by)
{
    if (state->depth == PBRT_MAX_DEPTH)
        return pbrt_fault(state, FAULT_LIMIT, "attributes nested deeper than %d", PBRT_MAX_DEPTH);
    if (state->depth == state->capacity) {
        const size_t capacity = state->capacity ? 2 * state->capacity : 8;
        pbrt_graphics_t *stack = realloc(state->stack, capacity * sizeof *stack);
        if (!stack)
            return pbrt_fault(state, FAULT_MEMORY, "no memory for the graphics state");
        state->stack = stack;
        state->capacity = capacity;
    }
    state->stack[state->depth] = state->now;
    state->stack[state->depth++].begun_by = begun_by;
    return FAULT_NONE;
}

fault_code_t pbrt_pop(pbrt_state_t *state, char begun_by, const char *directive)
{
    if (state->depth == 0 || state->stack[state->depth - 1].begun_by != begun_by)
        return pbrt_fault(state, FAULT_SYNTAX, "%s without its beginning", directive);
    state->now = state->stack[--state->depth];
    return FAULT_NONE;
}

fault_code_t pbrt_set_space(pbrt_state_t *state, const char *name, const transform_t *transform)
{
    const int32_t known = name_table_get(&state->spaces, name, -1);
    if (known >= 0) {
        state->space_list[known] = *transform;
        return FAULT_NONE;
    }
    transform_t *list = pbrt_grown(state->space_list, state->space_count, sizeof *list);
    if (!list)
        return pbrt_fault(state, FAULT_MEMORY, "no memory for a coordinate system");
    state->space_list = list;
    list[state->space_count] = *transform;
    TRY(name_table_set(&state->spaces, name, (int32_t)state->space_count, state->fault));
    state->space_count++;
    return FAULT_NONE;
}

fault_code_t pbrt_current_material(pbrt_state_t *state, int32_t *material)
{
    if (state->now.material != SCENE_NONE) {
        *material = state->now.material;
        return FAULT_NONE;
    }
    if (state->default_material == SCENE_NONE) {
        const scene_param_t zero = {{0, 0, 0}, SCENE_NONE};
        scene_material_t m = {.kind = SCENE_MATERIAL_DIFFUSE, .first = SCENE_NONE, .second = SCENE_NONE};
        uint32_t index;
        m.transmittance = m.mix = m.alpha_u = m.alpha_v = m.coat_alpha_u = m.coat_alpha_v = zero;
        m.reflectance = (scene_param_t){{0.5f, 0.5f, 0.5f}, SCENE_NONE};
        TRY(scene_builder_add_material(state->builder, &m, &index, state->fault));
        state->default_material = (int32_t)index;
    }
    *material = state->default_material;
    return FAULT_NONE;
}

fault_code_t pbrt_add_default(pbrt_state_t *state, pbrt_target_t target, pbrt_param_t *param)
{
    pbrt_default_t **list = pbrt_grown(state->defaults, state->default_count, sizeof *list);
    if (list)
        state->defaults = list;
    pbrt_default_t *entry = list ? calloc(1, sizeof *entry) : NULL;
    if (!entry)
        return pbrt_fault(state, FAULT_MEMORY, "no memory for an attribute");
    entry->param = *param;
    memset(param, 0, sizeof *param);
    entry->next = state->now.defaults[target];
    state->now.defaults[target] = entry;
    state->defaults[state->default_count++] = entry;
    return FAULT_NONE;
}
