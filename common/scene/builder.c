#include "scene/builder.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { IMAGE_ALIGNMENT = 16 };

/* An array that grows by half; `count` and `capacity` in items. */
typedef struct list {
    void *data;
    size_t item, count, capacity;
} list_t;

struct scene_builder {
    list_t positions, normals, uvs; /* normals and uvs stay empty until a mesh has some, then follow positions */
    list_t indices, shapes, materials, textures, images, texels, lights;
    scene_camera_t camera;
    bool has_camera;
};

/* ---- lists ---- */

/* Makes room for `more` items. The counts are bounded by the limits of scene.h, so that nothing overflows. */
static fault_code_t list_reserve(list_t *list, size_t more, fault_t *fault)
{
    const size_t needed = list->count + more;
    if (needed <= list->capacity)
        return FAULT_NONE;
    size_t capacity = list->capacity + list->capacity / 2;
    capacity = capacity < needed ? needed : capacity;
    capacity = capacity < 16 ? 16 : capacity;
    void *data = realloc(list->data, capacity * list->item);
    if (!data)
        return fault_set(fault, FAULT_MEMORY, "no memory for a scene's array of %zu items of %zu bytes", capacity,
                         list->item);
    list->data = data;
    list->capacity = capacity;
    return FAULT_NONE;
}

/* Room is there. Null items append zeros. */
static void list_append(list_t *list, const void *items, size_t count)
{
    char *end = (char *)list->data + list->count * list->item;
    if (count > 0 && items)
        memcpy(end, items, count * list->item);
    else if (count > 0)
        memset(end, 0, count * list->item);
    list->count += count;
}

static fault_code_t list_add(list_t *list, const void *item, size_t limit, const char *what, uint32_t *index,
                             fault_t *fault)
{
    if (list->count >= limit)
        return fault_set(fault, FAULT_LIMIT, "a scene has more than %zu %s", limit, what);
    TRY(list_reserve(list, 1, fault));
    list_append(list, item, 1);
    if (index)
        *index = (uint32_t)(list->count - 1);
    return FAULT_NONE;
}

/* ---- life ---- */

scene_builder_t *scene_builder_new(void)
{
    scene_builder_t *b = calloc(1, sizeof *b);
    if (!b)
        return NULL;
    b->positions.item = b->normals.item = 3 * sizeof(float);
    b->uvs.item = 2 * sizeof(float);
    b->indices.item = 3 * sizeof(uint32_t);
    b->shapes.item = sizeof(scene_shape_t);
    b->materials.item = sizeof(scene_material_t);
    b->textures.item = sizeof(scene_texture_t);
    b->images.item = sizeof(scene_image_t);
    b->texels.item = 1;
    b->lights.item = sizeof(scene_light_t);
    return b;
}

void scene_builder_destroy(scene_builder_t **builder)
{
    if (!builder || !*builder)
        return;
    scene_builder_t *b = *builder;
    list_t *lists[] = {&b->positions, &b->normals,  &b->uvs,    &b->indices, &b->shapes,
                       &b->materials, &b->textures, &b->images, &b->texels,  &b->lights};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        free(lists[i]->data);
    free(b);
    *builder = NULL;
}

/* ---- adding ---- */

/* A parameter whose value is zero is zero whatever texture it names: the same scene has the same bytes. */
static void tidy_param(scene_param_t *param)
{
    if (param->value[0] == 0 && param->value[1] == 0 && param->value[2] == 0)
        param->texture = SCENE_NONE;
}

/* Follows the vertices with an array that only some meshes have. */
static fault_code_t reserve_optional(list_t *list, const list_t *positions, const float *given, size_t vertices,
                                     fault_t *fault)
{
    if (!given && list->count == 0)
        return FAULT_NONE;
    return list_reserve(list, positions->count - list->count + vertices, fault);
}

static void append_optional(list_t *list, const list_t *positions, const float *given, size_t vertices)
{
    if (!given && list->count == 0)
        return;
    list_append(list, NULL, positions->count - list->count);
    list_append(list, given, vertices);
}

fault_code_t scene_builder_add_mesh(scene_builder_t *b, const scene_shape_t *shape, const float *positions,
                                    const float *normals, const float *uvs, uint64_t vertices,
                                    const uint32_t *indices, uint64_t triangles, uint32_t *index, fault_t *fault)
{
    if (vertices > SCENE_MAX_VERTICES - b->positions.count)
        return fault_set(fault, FAULT_LIMIT, "a scene has more than %llu vertices",
                         (unsigned long long)SCENE_MAX_VERTICES);
    if (triangles > SCENE_MAX_TRIANGLES - b->indices.count)
        return fault_set(fault, FAULT_LIMIT, "a scene has more than %llu triangles",
                         (unsigned long long)SCENE_MAX_TRIANGLES);
    scene_shape_t mesh = {.kind = SCENE_SHAPE_MESH, .material = shape->material, .area_light = shape->area_light};
    mesh.flags =
        (shape->flags & SCENE_SHAPE_FLIP) | (normals ? SCENE_SHAPE_NORMALS : 0u) | (uvs ? SCENE_SHAPE_UVS : 0u);
    mesh.alpha = shape->alpha;
    tidy_param(&mesh.alpha);
    mesh.first_vertex = (uint32_t)b->positions.count;
    mesh.vertices = (uint32_t)vertices;
    mesh.first_triangle = (uint32_t)b->indices.count;
    mesh.triangles = (uint32_t)triangles;
    TRY(list_reserve(&b->positions, vertices, fault));
    TRY(reserve_optional(&b->normals, &b->positions, normals, vertices, fault));
    TRY(reserve_optional(&b->uvs, &b->positions, uvs, vertices, fault));
    TRY(list_reserve(&b->indices, triangles, fault));
    TRY(list_add(&b->shapes, &mesh, SCENE_MAX_SHAPES, "shapes", index, fault));
    append_optional(&b->normals, &b->positions, normals, vertices);
    append_optional(&b->uvs, &b->positions, uvs, vertices);
    list_append(&b->positions, positions, vertices);
    list_append(&b->indices, indices, triangles);
    return FAULT_NONE;
}

fault_code_t scene_builder_add_shape(scene_builder_t *b, const scene_shape_t *shape, uint32_t *index,
                                     fault_t *fault)
{
    scene_shape_t copy = *shape;
    tidy_param(&copy.alpha);
    copy.pad0 = copy.pad1 = 0;
    return list_add(&b->shapes, &copy, SCENE_MAX_SHAPES, "shapes", index, fault);
}

fault_code_t scene_builder_add_material(scene_builder_t *b, const scene_material_t *material, uint32_t *index,
                                        fault_t *fault)
{
    scene_material_t copy = *material;
    scene_param_t *params[] = {&copy.reflectance,  &copy.transmittance, &copy.alpha_u, &copy.alpha_v,
                               &copy.coat_alpha_u, &copy.coat_alpha_v,  &copy.mix};
    for (size_t i = 0; i < sizeof params / sizeof *params; i++)
        tidy_param(params[i]);
    if (copy.kind != SCENE_MATERIAL_MIX)
        copy.first = copy.second = SCENE_NONE;
    return list_add(&b->materials, &copy, SCENE_MAX_MATERIALS, "materials", index, fault);
}

fault_code_t scene_builder_add_texture(scene_builder_t *b, const scene_texture_t *texture, uint32_t *index,
                                       fault_t *fault)
{
    scene_texture_t copy = *texture;
    tidy_param(&copy.a);
    tidy_param(&copy.b);
    tidy_param(&copy.m);
    if (copy.kind != SCENE_TEXTURE_IMAGE)
        copy.image = SCENE_NONE;
    return list_add(&b->textures, &copy, SCENE_MAX_TEXTURES, "textures", index, fault);
}

/* Bytes of the texels; 0 where the record is beyond its limits. */
static uint64_t image_bytes(const scene_image_t *image)
{
    if (image->width > SCENE_MAX_IMAGE_SIZE || image->height > SCENE_MAX_IMAGE_SIZE || image->channels > 4)
        return 0;
    return (uint64_t)image->width * image->height * image->channels *
           (image->texel == SCENE_TEXEL_FLOAT32 ? sizeof(float) : 1u);
}

fault_code_t scene_builder_add_image(scene_builder_t *b, const scene_image_t *image, const void *texels,
                                     uint32_t *index, fault_t *fault)
{
    const uint64_t bytes = image_bytes(image);
    const uint64_t gap = (IMAGE_ALIGNMENT - b->texels.count % IMAGE_ALIGNMENT) % IMAGE_ALIGNMENT;
    if (bytes == 0)
        return fault_set(fault, FAULT_LIMIT,
                         "an image of %u x %u texels and %u channels; expected 1 to %d and 1 to 4", image->width,
                         image->height, image->channels, SCENE_MAX_IMAGE_SIZE);
    if (gap + bytes > SCENE_MAX_TEXEL_BYTES - b->texels.count)
        return fault_set(fault, FAULT_LIMIT, "a scene's images have more than %llu bytes",
                         (unsigned long long)SCENE_MAX_TEXEL_BYTES);
    scene_image_t copy = *image;
    copy.offset = b->texels.count + gap;
    TRY(list_reserve(&b->texels, gap + bytes, fault));
    TRY(list_add(&b->images, &copy, SCENE_MAX_IMAGES, "images", index, fault));
    list_append(&b->texels, NULL, gap);
    list_append(&b->texels, texels, bytes);
    return FAULT_NONE;
}

fault_code_t scene_builder_add_light(scene_builder_t *b, const scene_light_t *light, uint32_t *index,
                                     fault_t *fault)
{
    scene_light_t copy = *light;
    memset(copy.pad, 0, sizeof copy.pad);
    if (copy.kind != SCENE_LIGHT_INFINITE)
        copy.image = SCENE_NONE;
    return list_add(&b->lights, &copy, SCENE_MAX_LIGHTS, "lights", index, fault);
}

void scene_builder_set_camera(scene_builder_t *b, const scene_camera_t *camera)
{
    b->camera = *camera;
    b->has_camera = true;
}

/* An optional array as long as the vertices: later meshes without it end it with zeros. */
static const void *view_optional(const list_t *list)
{
    return list->count ? list->data : NULL;
}

scene_t scene_builder_view(const scene_builder_t *b)
{
    return (scene_t){
        .positions = b->positions.data,
        .normals = view_optional(&b->normals),
        .uvs = view_optional(&b->uvs),
        .indices = b->indices.data,
        .shapes = b->shapes.data,
        .materials = b->materials.data,
        .textures = b->textures.data,
        .images = b->images.data,
        .texels = b->texels.data,
        .lights = b->lights.data,
        .camera = b->has_camera ? &b->camera : NULL,
        .vertex_count = b->positions.count,
        .triangle_count = b->indices.count,
        .texel_bytes = b->texels.count,
        .shape_count = (uint32_t)b->shapes.count,
        .material_count = (uint32_t)b->materials.count,
        .texture_count = (uint32_t)b->textures.count,
        .image_count = (uint32_t)b->images.count,
        .light_count = (uint32_t)b->lights.count,
    };
}
