/* pbrt_state.h: what the reader of a pbrt-v4 file knows while it reads: graphics state and its stack, names, place.
 *
 * Internal to client/import. Functions that fail describe the fault without its place; the dispatcher (pbrt.c) puts
 * "file:line:column: " before it, from state->line and state->column, which are the directive's unless something
 * nearer to the fault set them.
 */
#ifndef IMPORT_PBRT_STATE_H
#define IMPORT_PBRT_STATE_H

#include "client/import/geometry.h"
#include "client/import/name_table.h"
#include "client/import/notes.h"
#include "client/import/pbrt_params.h"
#include "client/import/transform.h"
#include "scene/builder.h"

enum {
    PBRT_PATH_MAX = 4096,
    PBRT_MAX_INCLUDES = 16, /* files open at a time */
    PBRT_MAX_DEPTH = 1024,  /* AttributeBegin in AttributeBegin */
    PBRT_MAX_OBJECTS = 1 << 20,
    PBRT_MAX_INSTANCED = 1 << 22 /* shapes kept in objects */
};

/* What the Attribute directive gives defaults for. */
typedef enum pbrt_target {
    PBRT_TARGET_SHAPE,
    PBRT_TARGET_LIGHT,
    PBRT_TARGET_MATERIAL,
    PBRT_TARGET_MEDIUM,
    PBRT_TARGET_TEXTURE,
    PBRT_TARGETS
} pbrt_target_t;

/* An AreaLightSource. Without `power` one light serves all its shapes; with it each shape has its own. */
typedef struct pbrt_area {
    rgb_t radiance;
    double power; /* below zero: not given */
    bool two_sided;
    int32_t light; /* SCENE_NONE until the first shape */
} pbrt_area_t;

typedef struct pbrt_graphics {
    transform_t ctm;
    bool reverse;
    bool end_time_only; /* ActiveTransform EndTime: transformations have no effect */
    int32_t material;   /* SCENE_NONE: pbrt's default, made when it is needed */
    int32_t area;       /* index into areas or SCENE_NONE */
    const pbrt_default_t *defaults[PBRT_TARGETS];
    char begun_by; /* 'A'ttributeBegin, 'O'bjectBegin, 'I'mport: what saved it */
} pbrt_graphics_t;

/* A shape inside ObjectBegin ... ObjectEnd. */
typedef struct pbrt_instanced {
    geometry_t geometry; /* owned */
    transform_t ctm;
    bool reverse;
    int32_t material;
    scene_param_t alpha;
} pbrt_instanced_t;

typedef struct pbrt_object {
    size_t first, count; /* in instanced */
} pbrt_object_t;

/* Camera, film and filter as far as they are known before WorldBegin. */
typedef struct pbrt_view {
    bool has_camera, has_filter;
    transform_t camera_from_world;
    double fov, aspect, window[4], lens_radius, focal_distance; /* aspect 0, window[1] <= window[0]: not given */
    int width, height;
    double crop[4]; /* x0, x1, y0, y1 as parts of the film */
    bool has_bounds;
    int bounds[4]; /* the same in pixels */
    double imaging_scale;
    uint32_t filter;
    double filter_radius[2], filter_sigma;
    int max_depth; /* below zero: not given */
} pbrt_view_t;

typedef struct pbrt_loaded_image {
    uint32_t index, channels;
    bool opaque;
} pbrt_loaded_image_t;

typedef struct pbrt_state {
    scene_builder_t *builder;
    import_notes_t *notes;
    fault_t *fault;
    /* place */
    pbrt_lexer_t *lexer;
    const char *file;
    int line, column;
    bool placed;                /* the fault's text names its place already */
    char folder[PBRT_PATH_MAX]; /* of the scene file */
    const char *open_files[PBRT_MAX_INCLUDES];
    int open_count;
    /* graphics state */
    bool in_world;
    pbrt_graphics_t now;
    pbrt_graphics_t *stack;
    size_t depth, capacity;
    pbrt_view_t view;
    /* names; values index the arrays below or the builder's lists */
    name_table_t spaces, materials, color_textures, scalar_textures, images, objects;
    transform_t *space_list;
    size_t space_count;
    scene_texture_t *texture_list; /* as in the builder, by index */
    size_t texture_count;
    pbrt_loaded_image_t *image_list;
    size_t image_count;
    pbrt_object_t *object_list;
    size_t object_count;
    pbrt_instanced_t *instanced;
    size_t instanced_count, instanced_capacity;
    bool in_object;
    pbrt_area_t *areas;
    size_t area_count;
    pbrt_default_t **defaults; /* all of them, for clearing */
    size_t default_count;
    int32_t default_material;
    uint64_t degenerate, no_normal; /* triangles and normals left out so far, noted at the end */
    char degenerate_file[256];      /* where the first of them were */
    int degenerate_line;
} pbrt_state_t;

void pbrt_state_init(pbrt_state_t *state, scene_builder_t *builder, import_notes_t *notes, fault_t *fault);
void pbrt_state_clear(pbrt_state_t *state);

/* A note at the current directive. */
void pbrt_note(pbrt_state_t *state, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Fills the state's fault; returns the code. */
fault_code_t pbrt_fault(pbrt_state_t *state, fault_code_t code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* After a parameter getter's fault: the place becomes the parameter's. Returns `code`. */
fault_code_t pbrt_at_params(pbrt_state_t *state, const pbrt_params_t *params, fault_code_t code);

/* TRY for parameter getters. */
#define PBRT_TRY(state, params, expr) TRY(pbrt_at_params((state), (params), (expr)))

/* The path of a file that the scene names: relative to the scene file's folder, else to that of the file that is
 * being read. FAULT_NOT_FOUND names it as the scene does. */
fault_code_t pbrt_resolve(pbrt_state_t *state, const char *name, char path[PBRT_PATH_MAX]);

fault_code_t pbrt_push(pbrt_state_t *state, char begun_by);
fault_code_t pbrt_pop(pbrt_state_t *state, char begun_by, const char *directive);
fault_code_t pbrt_set_space(pbrt_state_t *state, const char *name, const transform_t *transform);
/* The material of the shapes that come: index into the builder's. */
fault_code_t pbrt_current_material(pbrt_state_t *state, int32_t *material);
/* Moves a parsed parameter into the defaults of a target. */
fault_code_t pbrt_add_default(pbrt_state_t *state, pbrt_target_t target, pbrt_param_t *param);

/* Grows a plain array to hold one more; returns null when out of memory (the old one stays valid). */
void *pbrt_grown(void *array, size_t count, size_t size);

#endif
