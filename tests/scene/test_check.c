#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/sample_scene.h"

/* ---- a scene that can be spoilt ---- */

typedef struct spoilt {
    scene_t scene;
    float *positions, *normals, *uvs;
    uint32_t *indices;
    scene_shape_t *shapes;
    scene_material_t *materials;
    scene_texture_t *textures;
    scene_image_t *images;
    uint8_t *texels;
    scene_light_t *lights;
    scene_camera_t *camera;
} spoilt_t;

static scene_builder_t *builder;

static void *copy_of(const void *data, uint64_t count, size_t record)
{
    void *copy = malloc(count * record);
    memcpy(copy, data, count * record);
    return copy;
}

static spoilt_t *spoilt_new(void)
{
    spoilt_t *s = malloc(sizeof *s);
    scene_t *v = &s->scene;
    *v = scene_builder_view(builder);
    v->positions = s->positions = copy_of(v->positions, v->vertex_count, 12);
    v->normals = s->normals = copy_of(v->normals, v->vertex_count, 12);
    v->uvs = s->uvs = copy_of(v->uvs, v->vertex_count, 8);
    v->indices = s->indices = copy_of(v->indices, v->triangle_count, 12);
    v->shapes = s->shapes = copy_of(v->shapes, v->shape_count, sizeof *v->shapes);
    v->materials = s->materials = copy_of(v->materials, v->material_count, sizeof *v->materials);
    v->textures = s->textures = copy_of(v->textures, v->texture_count, sizeof *v->textures);
    v->images = s->images = copy_of(v->images, v->image_count, sizeof *v->images);
    v->texels = s->texels = copy_of(v->texels, v->texel_bytes, 1);
    v->lights = s->lights = copy_of(v->lights, v->light_count, sizeof *v->lights);
    v->camera = s->camera = copy_of(v->camera, 1, sizeof *v->camera);
    return s;
}

static void spoilt_free(spoilt_t *s)
{
    void *arrays[] = {s->positions, s->normals, s->uvs,    s->indices, s->shapes, s->materials,
                      s->textures,  s->images,  s->texels, s->lights,  s->camera, s};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        free(arrays[i]);
}

/* What the checks say must be `code` and begin with `text`. */
static void assert_says(const spoilt_t *s, fault_code_t code, const char *text)
{
    fault_t fault = {0};
    const fault_code_t got = scene_check(&s->scene, &fault);
    if (got != code || strncmp(fault.text, text, strlen(text)) != 0)
        fail_msg("got %d \"%s\", expected %d \"%s...\"", (int)got, fault.text, (int)code, text);
    assert_int_equal(scene_check(&s->scene, NULL), code);
}

/* ---- one field at a time ---- */

typedef enum array { SHAPE, MATERIAL, TEXTURE, IMAGE, LIGHT, CAMERA, POSITION, NORMAL, UV, INDEX } array_t;
typedef enum type { WORD, FLOAT, DOUBLE, LONG } type_t; /* uint32_t, float, double, uint64_t */

typedef struct spoil {
    array_t array;
    uint32_t record;
    size_t offset;
    type_t type;
    double value;
    fault_code_t code;
    const char *text;
} spoil_t;

static uint8_t *record_of(spoilt_t *s, const spoil_t *how)
{
    switch (how->array) {
    case SHAPE:
        return (uint8_t *)&s->shapes[how->record];
    case MATERIAL:
        return (uint8_t *)&s->materials[how->record];
    case TEXTURE:
        return (uint8_t *)&s->textures[how->record];
    case IMAGE:
        return (uint8_t *)&s->images[how->record];
    case LIGHT:
        return (uint8_t *)&s->lights[how->record];
    case CAMERA:
        return (uint8_t *)s->camera;
    case POSITION:
        return (uint8_t *)&s->positions[3 * how->record];
    case NORMAL:
        return (uint8_t *)&s->normals[3 * how->record];
    case UV:
        return (uint8_t *)&s->uvs[2 * how->record];
    default:
        return (uint8_t *)&s->indices[3 * how->record];
    }
}

static void apply(spoilt_t *s, const spoil_t *how)
{
    uint8_t *at = record_of(s, how) + how->offset;
    const uint32_t word = (uint32_t)(int64_t)how->value;
    const uint64_t wide = (uint64_t)how->value;
    const float single = (float)how->value;
    switch (how->type) {
    case WORD:
        memcpy(at, &word, sizeof word);
        break;
    case FLOAT:
        memcpy(at, &single, sizeof single);
        break;
    case DOUBLE:
        memcpy(at, &how->value, sizeof how->value);
        break;
    default:
        memcpy(at, &wide, sizeof wide);
    }
}

#define IN(type, field) offsetof(scene_##type##_t, field)
/* Entries of m[4][3] in the camera's matrix. */
#define MATRIX(row, column) (IN(camera, to_world) + 8 * (4 * (row) + (column)))

static const spoil_t spoils[] = {
    {SHAPE, 0, IN(shape, kind), WORD, 3, FAULT_RANGE, "shape 0: kind is 3, expected 0 to 2"},
    {SHAPE, 1, IN(shape, flags), WORD, 8, FAULT_RANGE, "shape 1: flags is 8, expected 0 to 7"},
    {SHAPE, 1, IN(shape, material), WORD, SCENE_MATERIAL_KINDS, FAULT_RANGE, "shape 1: material is 9"},
    {SHAPE, 1, IN(shape, material), WORD, -1, FAULT_RANGE, "shape 1: material is -1, expected an index below 9"},
    {SHAPE, 0, IN(shape, area_light), WORD, 5, FAULT_RANGE,
     "shape 0: area light is 5, expected an index below 5 or"},
    {SHAPE, 0, IN(shape, area_light), WORD, -2, FAULT_RANGE, "shape 0: area light is -2"},
    {SHAPE, 0, IN(shape, area_light), WORD, 1, FAULT_FORMAT, "shape 0: its area light 1 is of another kind"},
    {SHAPE, 2, IN(shape, alpha.value), FLOAT, 1.01, FAULT_RANGE, "shape 2: alpha[0] is 1.01, expected 0 to 1"},
    {SHAPE, 2, IN(shape, alpha.value), FLOAT, NAN, FAULT_RANGE, "shape 2: alpha[0] is "},
    {SHAPE, 2, IN(shape, alpha.texture), WORD, 5, FAULT_RANGE, "shape 2: alpha has the texture 5"},
    {SHAPE, 0, IN(shape, centre[1]), FLOAT, NAN, FAULT_RANGE, "shape 0: centre[1] is "},
    {SHAPE, 0, IN(shape, radius), FLOAT, -1, FAULT_RANGE, "shape 0: radius is -1"},
    {SHAPE, 0, IN(shape, normal[2]), FLOAT, INFINITY, FAULT_RANGE, "shape 0: normal[2] is inf"},
    {SHAPE, 0, IN(shape, tangent[2]), FLOAT, INFINITY, FAULT_RANGE, "shape 0: tangent[2] is inf"},
    {SHAPE, 2, IN(shape, pad0), FLOAT, 1, FAULT_FORMAT, "shape 2: reserved bytes"},
    {SHAPE, 2, IN(shape, pad1), FLOAT, NAN, FAULT_FORMAT, "shape 2: reserved bytes"},
    {SHAPE, 1, IN(shape, first_vertex), WORD, 3, FAULT_FORMAT,
     "shape 1: begins at vertex 3 and triangle 2, expected 4"},
    {SHAPE, 1, IN(shape, first_triangle), WORD, 0, FAULT_FORMAT, "shape 1: begins at vertex 4 and triangle 0"},
    {SHAPE, 1, IN(shape, vertices), WORD, 4, FAULT_RANGE, "shape 1: 4 vertices from vertex 4 on, the scene has 7"},
    {SHAPE, 1, IN(shape, vertices), WORD, 4294967295.0, FAULT_RANGE, "shape 1: 4294967295 vertices"},
    {SHAPE, 1, IN(shape, triangles), WORD, 2, FAULT_RANGE,
     "shape 1: 2 triangles from triangle 2 on, the scene has 3"},
    {SHAPE, 1, IN(shape, triangles), WORD, 0, FAULT_RANGE, "shape 1: a mesh without triangles"},
    {SHAPE, 1, IN(shape, vertices), WORD, 2, FAULT_RANGE,
     "shape 1: index 2 of triangle 0 is beyond its 2 vertices"},
    {SHAPE, 1, IN(shape, kind), WORD, SCENE_SHAPE_DISK, FAULT_FORMAT, "shape 1: flags 7, expected no vertex data"},
    {SHAPE, 2, IN(shape, radius), FLOAT, 0, FAULT_RANGE, "shape 2: radius is 0"},
    {SHAPE, 2, IN(shape, centre[0]), FLOAT, 1.1e15, FAULT_RANGE, "shape 2: centre[0] is 1.1e+15"},
    {SHAPE, 2, IN(shape, normal[2]), FLOAT, 1.002, FAULT_RANGE,
     "shape 2: normal (0, 0, 1.002) has the length 1.002"},
    {SHAPE, 3, IN(shape, tangent[0]), FLOAT, 0, FAULT_RANGE, "shape 3: tangent (0, 0, 0) has the length 0"},
    {SHAPE, 3, IN(shape, tangent[2]), FLOAT, 0.002, FAULT_RANGE,
     "shape 3: normal and tangent are not perpendicular"},
    {POSITION, 5, 4, FLOAT, 1.1e15, FAULT_RANGE, "shape 1: vertex 1 lies at (1, 1.1e+15, 0), expected magnitudes"},
    {POSITION, 0, 0, FLOAT, NAN, FAULT_RANGE, "shape 0: vertex 0 lies at ("},
    {NORMAL, 6, 8, FLOAT, 0.9, FAULT_RANGE, "shape 1: the normal of vertex 2 is not of unit length"},
    {NORMAL, 6, 8, FLOAT, NAN, FAULT_RANGE, "shape 1: the normal of vertex 2"},
    {UV, 4, 0, FLOAT, INFINITY, FAULT_RANGE, "shape 1: the texture coordinates of vertex 0"},
    {UV, 4, 4, FLOAT, NAN, FAULT_RANGE, "shape 1: the texture coordinates of vertex 0"},
    {INDEX, 1, 8, WORD, 4, FAULT_RANGE, "shape 0: index 4 of triangle 1 is beyond its 4 vertices"},

    {MATERIAL, 0, IN(material, kind), WORD, 9, FAULT_RANGE, "material 0: kind is 9"},
    {MATERIAL, 0, IN(material, remap_roughness), WORD, 2, FAULT_RANGE, "material 0: remap_roughness is 2"},
    {MATERIAL, 1, IN(material, reflectance.value[1]), FLOAT, 1.5, FAULT_RANGE, "material 1: reflectance[1] is 1.5"},
    {MATERIAL, 1, IN(material, reflectance.texture), WORD, 5, FAULT_RANGE,
     "material 1: reflectance has the texture 5"},
    {MATERIAL, 1, IN(material, reflectance.texture), WORD, -2, FAULT_RANGE,
     "material 1: reflectance has the texture -2"},
    {MATERIAL, 6, IN(material, transmittance.value[2]), FLOAT, -0.1, FAULT_RANGE,
     "material 6: transmittance[2] is -0.1"},
    {MATERIAL, 2, IN(material, alpha_u.value), FLOAT, 2, FAULT_RANGE, "material 2: alpha_u[0] is 2"},
    {MATERIAL, 2, IN(material, alpha_v.value), FLOAT, NAN, FAULT_RANGE, "material 2: alpha_v[0] is "},
    {MATERIAL, 1, IN(material, coat_alpha_u.value), FLOAT, -1, FAULT_RANGE, "material 1: coat_alpha_u[0] is -1"},
    {MATERIAL, 1, IN(material, coat_alpha_v.texture), WORD, 7, FAULT_RANGE,
     "material 1: coat_alpha_v has the texture 7"},
    {MATERIAL, 7, IN(material, mix.value), FLOAT, 1.25, FAULT_RANGE, "material 7: mix[0] is 1.25"},
    {MATERIAL, 4, IN(material, eta), FLOAT, 0, FAULT_RANGE, "material 4: eta[0] is 0"},
    {MATERIAL, 5, IN(material, eta), FLOAT, 0, FAULT_RANGE, "material 5: eta[0] is 0"},
    {MATERIAL, 2, IN(material, eta[2]), FLOAT, 0, FAULT_RANGE, "material 2: eta[2] is 0"},
    {MATERIAL, 0, IN(material, eta[1]), FLOAT, NAN, FAULT_RANGE, "material 0: eta[1] is "},
    {MATERIAL, 3, IN(material, k[1]), FLOAT, -1, FAULT_RANGE, "material 3: k[1] is -1"},
    {MATERIAL, 1, IN(material, coat_eta), FLOAT, 0, FAULT_RANGE, "material 1: coat_eta is 0"},
    {MATERIAL, 3, IN(material, coat_eta), FLOAT, 0, FAULT_RANGE, "material 3: coat_eta is 0"},
    {MATERIAL, 0, IN(material, first), WORD, 0, FAULT_RANGE,
     "material 0: first is 0, expected an index below 0 or -1"},
    {MATERIAL, 7, IN(material, first), WORD, 7, FAULT_RANGE, "material 7: first is 7, expected an index below 7"},
    {MATERIAL, 7, IN(material, second), WORD, 8, FAULT_RANGE, "material 7: second is 8"},
    {MATERIAL, 7, IN(material, second), WORD, -1, FAULT_RANGE, "material 7: second is -1"},

    {TEXTURE, 0, IN(texture, kind), WORD, 5, FAULT_RANGE, "texture 0: kind is 5"},
    {TEXTURE, 1, IN(texture, wrap), WORD, 3, FAULT_RANGE, "texture 1: wrap is 3"},
    {TEXTURE, 1, IN(texture, invert), WORD, 2, FAULT_RANGE, "texture 1: invert is 2"},
    {TEXTURE, 1, IN(texture, image), WORD, SAMPLE_IMAGES, FAULT_RANGE,
     "texture 1: image is 3, expected an index below 3"},
    {TEXTURE, 1, IN(texture, image), WORD, -1, FAULT_RANGE, "texture 1: image is -1"},
    {TEXTURE, 0, IN(texture, image), WORD, 0, FAULT_RANGE, "texture 0: image is 0"},
    {TEXTURE, 1, IN(texture, alpha_channel), WORD, -1, FAULT_RANGE, "texture 1: alpha_channel is 4294967295"},
    {TEXTURE, 1, IN(texture, image), WORD, 0, FAULT_FORMAT,
     "texture 1: wants the fourth channel of image 0, which has 3"},
    {TEXTURE, 1, IN(texture, scale_u), FLOAT, NAN, FAULT_RANGE, "texture 1: scale and offset[0] is "},
    {TEXTURE, 1, IN(texture, offset_v), FLOAT, INFINITY, FAULT_RANGE, "texture 1: scale and offset[3] is inf"},
    {TEXTURE, 0, IN(texture, value[2]), FLOAT, -1, FAULT_RANGE, "texture 0: value[2] is -1"},
    {TEXTURE, 2, IN(texture, a.texture), WORD, 2, FAULT_RANGE,
     "texture 2: operand a has the texture 2, expected one before 2"},
    {TEXTURE, 3, IN(texture, b.texture), WORD, 4, FAULT_RANGE, "texture 3: operand b has the texture 4"},
    {TEXTURE, 4, IN(texture, m.texture), WORD, -2, FAULT_RANGE, "texture 4: operand m has the texture -2"},
    {TEXTURE, 2, IN(texture, b.value[1]), FLOAT, NAN, FAULT_RANGE, "texture 2: operand b[1] is "},
    {TEXTURE, 0, IN(texture, value[0]), FLOAT, 1e31, FAULT_RANGE,
     "texture 0: its values may reach 1e+31, more than 1e+30"},
    {TEXTURE, 2, IN(texture, b.value[0]), FLOAT, 3e30, FAULT_RANGE, "texture 2: its values may reach "},
    {TEXTURE, 4, IN(texture, b.value[0]), FLOAT, 3e30, FAULT_RANGE, "texture 4: its values may reach "},

    {IMAGE, 0, IN(image, width), WORD, 0, FAULT_RANGE, "image 0: width is 0, expected 1 to 32768"},
    {IMAGE, 0, IN(image, height), WORD, 32769, FAULT_RANGE, "image 0: height is 32769"},
    {IMAGE, 0, IN(image, channels), WORD, 2, FAULT_RANGE, "image 0: 2 channels, expected 1, 3 or 4"},
    {IMAGE, 0, IN(image, texel), WORD, 3, FAULT_RANGE, "image 0: texel is 3"},
    {IMAGE, 1, IN(image, offset), LONG, 16, FAULT_FORMAT, "image 1: begins at byte 16 of the texels, expected 32"},
    {IMAGE, 2, IN(image, width), WORD, 32768, FAULT_RANGE,
     "image 2: needs 786432 bytes from 48 on, the scene has 96"},
    {IMAGE, 2, IN(image, width), WORD, 1, FAULT_FORMAT, "the images have 72 bytes of texels, the scene has 96"},

    {LIGHT, 0, IN(light, kind), WORD, 5, FAULT_RANGE, "light 0: kind is 5"},
    {LIGHT, 0, IN(light, two_sided), WORD, 2, FAULT_RANGE, "light 0: two_sided is 2"},
    {LIGHT, 3, IN(light, radiance[1]), FLOAT, -1, FAULT_RANGE, "light 3: radiance[1] is -1"},
    {LIGHT, 3, IN(light, radiance[2]), FLOAT, INFINITY, FAULT_RANGE, "light 3: radiance[2] is inf"},
    {LIGHT, 3, IN(light, position[0]), FLOAT, -2e15, FAULT_RANGE, "light 3: position[0] is -2e+15"},
    {LIGHT, 0, IN(light, direction[0]), FLOAT, NAN, FAULT_RANGE, "light 0: direction[0] is "},
    {LIGHT, 2, IN(light, direction[1]), FLOAT, -0.998, FAULT_RANGE,
     "light 2: direction (0, -0.998, 0) has the length"},
    {LIGHT, 4, IN(light, direction[1]), FLOAT, 0, FAULT_RANGE, "light 4: direction (0, 0, 0) has the length 0"},
    {LIGHT, 4, IN(light, cos_start), FLOAT, 0.7, FAULT_RANGE, "light 4: cos_start is 0.7, expected 0.8 to 1"},
    {LIGHT, 4, IN(light, cos_end), FLOAT, -1.1, FAULT_RANGE, "light 4: cos_end is -1.1"},
    {LIGHT, 0, IN(light, to_light[4]), FLOAT, NAN, FAULT_RANGE, "light 0: to_light[4] is "},
    {LIGHT, 1, IN(light, to_light[5]), FLOAT, 0.5, FAULT_RANGE,
     "light 1: row of to_light (0, 0, 0.5) has the length"},
    {LIGHT, 1, IN(light, to_light[4]), FLOAT, 0.002, FAULT_RANGE,
     "light 1: rows of to_light are not perpendicular"},
    {LIGHT, 1, IN(light, image), WORD, SAMPLE_IMAGES, FAULT_RANGE, "light 1: image is 3"},
    {LIGHT, 1, IN(light, image), WORD, SAMPLE_IMAGE_SRGB, FAULT_FORMAT,
     "light 1: its image 0 has 3 x 2 texels, expected a square"},
    {LIGHT, 2, IN(light, image), WORD, 0, FAULT_RANGE, "light 2: image is 0"},
    {LIGHT, 2, IN(light, pad[2]), WORD, 1, FAULT_FORMAT, "light 2: reserved bytes"},

    {CAMERA, 0, MATRIX(1, 3), DOUBLE, NAN, FAULT_RANGE, "camera: an entry of to_world is "},
    {CAMERA, 0, MATRIX(1, 3), DOUBLE, 2e15, FAULT_RANGE, "camera: an entry of to_world is 2e+15"},
    {CAMERA, 0, MATRIX(0, 0), DOUBLE, 0, FAULT_RANGE, "camera: the length of a column of to_world is 0"},
    {CAMERA, 0, MATRIX(1, 0), DOUBLE, 1e9, FAULT_RANGE, "camera: to_world cannot be inverted"},
    {CAMERA, 0, IN(camera, screen[0]), DOUBLE, 0.5, FAULT_RANGE,
     "camera: the screen x 0.5 to 0.5, y -0.25 to 0.25 is empty"},
    {CAMERA, 0, IN(camera, screen[3]), DOUBLE, -0.5, FAULT_RANGE,
     "camera: the screen x -0.5 to 0.5, y -0.25 to -0.5 is"},
    {CAMERA, 0, IN(camera, screen[1]), DOUBLE, INFINITY, FAULT_RANGE, "camera: an edge of the screen is inf"},
    {CAMERA, 0, IN(camera, lens_radius), DOUBLE, -0.1, FAULT_RANGE, "camera: lens_radius is -0.1"},
    {CAMERA, 0, IN(camera, focal_distance), DOUBLE, 0, FAULT_RANGE, "camera: focal_distance is 0"},
    {CAMERA, 0, IN(camera, width), WORD, 0, FAULT_RANGE, "camera: width is 0"},
    {CAMERA, 0, IN(camera, height), WORD, 32769, FAULT_RANGE, "camera: height is 32769"},
    {CAMERA, 0, IN(camera, crop[0]), WORD, 64, FAULT_RANGE,
     "camera: the crop window x 64 to 64, y 8 to 32 is empty"},
    {CAMERA, 0, IN(camera, crop[1]), WORD, 65, FAULT_RANGE, "camera: the crop window x 0 to 65"},
    {CAMERA, 0, IN(camera, crop[2]), WORD, 33, FAULT_RANGE, "camera: the crop window x 0 to 64, y 33 to 32"},
    {CAMERA, 0, IN(camera, crop[3]), WORD, 33, FAULT_RANGE, "camera: the crop window x 0 to 64, y 8 to 33"},
    {CAMERA, 0, IN(camera, filter), WORD, 3, FAULT_RANGE, "camera: filter is 3"},
    {CAMERA, 0, IN(camera, filter_radius[0]), DOUBLE, 0, FAULT_RANGE, "camera: filter_radius[0] is 0"},
    {CAMERA, 0, IN(camera, filter_radius[1]), DOUBLE, 16.1, FAULT_RANGE, "camera: filter_radius[1] is 16.1"},
    {CAMERA, 0, IN(camera, filter_sigma), DOUBLE, 0, FAULT_RANGE, "camera: filter_sigma is 0"},
    {CAMERA, 0, IN(camera, imaging_scale), DOUBLE, 0, FAULT_RANGE, "camera: imaging_scale is 0"},
    {CAMERA, 0, IN(camera, imaging_scale), DOUBLE, NAN, FAULT_RANGE, "camera: imaging_scale is "},
};

static void every_field_out_of_order_is_named(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof spoils / sizeof *spoils; i++) {
        spoilt_t *s = spoilt_new();
        assert_int_equal(scene_check(&s->scene, NULL), FAULT_NONE);
        apply(s, &spoils[i]);
        assert_says(s, spoils[i].code, spoils[i].text);
        spoilt_free(s);
    }
}

/* The nearest values that are still right. */
static const spoil_t allowed[] = {
    {SHAPE, 2, IN(shape, normal[2]), FLOAT, 1.0009, FAULT_NONE, ""},
    {SHAPE, 2, IN(shape, alpha.value), FLOAT, 0, FAULT_NONE, ""},
    {SHAPE, 0, IN(shape, flags), WORD, SCENE_SHAPE_FLIP, FAULT_NONE, ""},
    {POSITION, 5, 4, FLOAT, -9.9e14, FAULT_NONE, ""},
    {NORMAL, 0, 0, FLOAT, 0.3, FAULT_NONE, ""},                    /* of a mesh without normals: not read */
    {INDEX, 1, 8, WORD, 0, FAULT_NONE, ""},                        /* a triangle without area */
    {MATERIAL, 0, IN(material, eta[0]), FLOAT, 0, FAULT_NONE, ""}, /* not used by its kind */
    {MATERIAL, 4, IN(material, eta[0]), FLOAT, 0.002, FAULT_NONE, ""},
    {MATERIAL, 7, IN(material, second), WORD, 0, FAULT_NONE, ""}, /* both parts the same */
    {MATERIAL, 7, IN(material, second), WORD, SCENE_MATERIAL_DIFFUSE_TRANSMISSION, FAULT_NONE, ""},
    {TEXTURE, 0, IN(texture, value[0]), FLOAT, 1e9, FAULT_NONE, ""},
    {LIGHT, 1, IN(light, image), WORD, -1, FAULT_NONE, ""},
    {LIGHT, 1, IN(light, to_light[5]), FLOAT, -1, FAULT_NONE, ""}, /* mirrored */
    {LIGHT, 4, IN(light, cos_start), FLOAT, 0.8, FAULT_NONE, ""},
    {LIGHT, 3, IN(light, radiance[0]), FLOAT, 0, FAULT_NONE, ""},
    {CAMERA, 0, MATRIX(0, 0), DOUBLE, -1e-3, FAULT_NONE, ""}, /* scaled and mirrored */
    {CAMERA, 0, IN(camera, lens_radius), DOUBLE, 0, FAULT_NONE, ""},
    {CAMERA, 0, IN(camera, crop[0]), WORD, 63, FAULT_NONE, ""},
    {CAMERA, 0, IN(camera, filter_radius[1]), DOUBLE, 16, FAULT_NONE, ""},
};

static void values_at_the_limits_pass(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof allowed / sizeof *allowed; i++) {
        spoilt_t *s = spoilt_new();
        fault_t fault = {0};
        apply(s, &allowed[i]);
        if (scene_check(&s->scene, &fault) != FAULT_NONE)
            fail_msg("row %zu: %s", i, fault.text);
        spoilt_free(s);
    }
}

/* ---- what takes more than a field ---- */

static void float_texels_are_finite_and_not_negative(void **state)
{
    (void)state;
    static const float wrong[] = {NAN, INFINITY, -1e-30f};
    for (size_t i = 0; i < 3; i++) {
        spoilt_t *s = spoilt_new();
        memcpy(s->texels + s->images[SAMPLE_IMAGE_SKY].offset + 5 * sizeof(float), &wrong[i], sizeof(float));
        assert_says(s, FAULT_RANGE, "image 2: channel 2 of texel 1 is ");
        spoilt_free(s);
    }
}

static void large_texels_count_in_the_bound_of_textures(void **state)
{
    (void)state;
    const float large = 1e35f;
    spoilt_t *s = spoilt_new();
    memcpy(s->texels + s->images[SAMPLE_IMAGE_SKY].offset, &large, sizeof large);
    assert_int_equal(scene_check(&s->scene, NULL), FAULT_NONE); /* a sky may be as bright */
    s->textures[SAMPLE_TEXTURE_IMAGE].image = SAMPLE_IMAGE_SKY;
    s->textures[SAMPLE_TEXTURE_IMAGE].alpha_channel = 0;
    assert_says(s, FAULT_RANGE, "texture 1: its values may reach 7e+34");
    spoilt_free(s);
}

static void missing_arrays_are_found(void **state)
{
    (void)state;
    spoilt_t *s = spoilt_new();
    const scene_t whole = s->scene;
    s->scene.camera = NULL;
    assert_says(s, FAULT_FORMAT, "the scene has no camera");
    s->scene = whole;
    s->scene.normals = NULL;
    assert_says(s, FAULT_FORMAT, "shape 1: has vertex normals, the scene has none");
    s->scene = whole;
    s->scene.uvs = NULL;
    assert_says(s, FAULT_FORMAT, "shape 1: has texture coordinates, the scene has none");
    s->scene = whole;
    s->scene.positions = NULL;
    assert_says(s, FAULT_FORMAT, "the scene has no array for its 7 vertices");
    s->scene = whole;
    s->scene.lights = NULL;
    assert_says(s, FAULT_FORMAT, "the scene has no array for its 5 lights");
    s->scene = whole;
    spoilt_free(s);
}

static void counts_beyond_the_limits_are_refused(void **state)
{
    (void)state;
    spoilt_t *s = spoilt_new();
    const scene_t whole = s->scene;
    s->scene.vertex_count = SCENE_MAX_VERTICES + 1;
    assert_says(s, FAULT_LIMIT, "the scene has 2000000001 vertices");
    s->scene = whole;
    s->scene.triangle_count = UINT64_MAX;
    assert_says(s, FAULT_LIMIT, "the scene has 18446744073709551615 triangles");
    s->scene = whole;
    s->scene.shape_count = SCENE_MAX_SHAPES + 1;
    assert_says(s, FAULT_LIMIT, "the scene has 4194305 shapes");
    s->scene = whole;
    s->scene.material_count = SCENE_MAX_MATERIALS + 1;
    assert_says(s, FAULT_LIMIT, "the scene has 65537 materials");
    s->scene = whole;
    s->scene.texture_count = SCENE_MAX_TEXTURES + 1;
    assert_says(s, FAULT_LIMIT, "the scene has 65537 textures");
    s->scene = whole;
    s->scene.image_count = SCENE_MAX_IMAGES + 1;
    assert_says(s, FAULT_LIMIT, "the scene has 16385 images");
    s->scene = whole;
    s->scene.texel_bytes = SCENE_MAX_TEXEL_BYTES + 1;
    assert_says(s, FAULT_LIMIT, "the scene has 68719476737 bytes of texels");
    s->scene = whole;
    s->scene.light_count = SCENE_MAX_LIGHTS + 1;
    assert_says(s, FAULT_LIMIT, "the scene has 1048577 lights");
    s->scene = whole;
    spoilt_free(s);
}

static void vertices_of_nobody_are_refused(void **state)
{
    (void)state;
    spoilt_t *s = spoilt_new();
    s->scene.shape_count = 1;
    assert_says(s, FAULT_FORMAT, "the meshes have 4 vertices and 2 triangles, the scene has 7 and 3");
    spoilt_free(s);
}

/* Each texture doubles the work of the one before: without a limit 2^64 look-ups. */
static void textures_cannot_multiply(void **state)
{
    (void)state;
    enum { COUNT = 64 };
    static scene_texture_t textures[COUNT];
    spoilt_t *s = spoilt_new();
    for (int32_t i = 0; i < COUNT; i++) {
        textures[i] =
            (scene_texture_t){.kind = i ? SCENE_TEXTURE_SCALE : SCENE_TEXTURE_CONSTANT, .image = SCENE_NONE};
        textures[i].value[0] = 1;
        textures[i].a = textures[i].b = textures[i].m = (scene_param_t){{1, 1, 1}, i - 1};
        textures[i].m.texture = SCENE_NONE;
    }
    s->scene.textures = textures;
    s->scene.texture_count = 8; /* 1, 3, 7, ... 255 visits */
    assert_int_equal(scene_check(&s->scene, NULL), FAULT_NONE);
    s->scene.texture_count = COUNT;
    assert_says(s, FAULT_LIMIT, "texture 8: looking it up visits more than 256 textures");
    spoilt_free(s);
}

static void mixes_cannot_multiply(void **state)
{
    (void)state;
    enum { COUNT = 64 };
    static scene_material_t materials[COUNT];
    spoilt_t *s = spoilt_new();
    for (int32_t i = 0; i < COUNT; i++) {
        materials[i] = s->materials[i ? SCENE_MATERIAL_MIX : SCENE_MATERIAL_DIFFUSE];
        materials[i].first = materials[i].second = i - 1;
    }
    s->scene.materials = materials;
    s->scene.material_count = COUNT;
    assert_says(s, FAULT_LIMIT, "material 9: a mix of 512 materials in 9 levels, at most 256 in 16 are allowed");
    for (int32_t i = 2; i < COUNT; i++) /* a chain instead of a tree */
        materials[i].second = 0;
    assert_says(s, FAULT_LIMIT, "material 17: a mix of 18 materials in 17 levels");
    spoilt_free(s);
}

static void infinite_lights_are_counted(void **state)
{
    (void)state;
    scene_light_t lights[9];
    spoilt_t *s = spoilt_new();
    for (int i = 0; i < 9; i++)
        lights[i] = s->lights[SCENE_LIGHT_INFINITE];
    s->shapes[SAMPLE_SPHERE].area_light = SCENE_NONE;
    s->scene.lights = lights;
    s->scene.light_count = 8;
    assert_int_equal(scene_check(&s->scene, NULL), FAULT_NONE);
    s->scene.light_count = 9;
    assert_says(s, FAULT_LIMIT, "light 8: more than 8 infinite lights");
    spoilt_free(s);
}

static int build(void **state)
{
    (void)state;
    builder = sample_scene_build(0);
    return 0;
}

static int destroy(void **state)
{
    (void)state;
    scene_builder_destroy(&builder);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_field_out_of_order_is_named),
        cmocka_unit_test(values_at_the_limits_pass),
        cmocka_unit_test(float_texels_are_finite_and_not_negative),
        cmocka_unit_test(large_texels_count_in_the_bound_of_textures),
        cmocka_unit_test(missing_arrays_are_found),
        cmocka_unit_test(counts_beyond_the_limits_are_refused),
        cmocka_unit_test(vertices_of_nobody_are_refused),
        cmocka_unit_test(textures_cannot_multiply),
        cmocka_unit_test(mixes_cannot_multiply),
        cmocka_unit_test(infinite_lights_are_counted),
    };
    return cmocka_run_group_tests(tests, build, destroy);
}
