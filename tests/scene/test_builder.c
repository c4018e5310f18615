#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <string.h>

#include "scene/sample_scene.h"

static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
static const float normals[9] = {0, 0, 1, 0, 0, 1, 0, 0, 1};
static const uint32_t corners[3] = {0, 1, 2};

static void the_sample_passes_the_checks(void **state)
{
    (void)state;
    fault_t fault = {0};
    for (int dirty = 0; dirty < 2; dirty++) {
        scene_builder_t *b = sample_scene_build(dirty);
        const scene_t scene = scene_builder_view(b);
        if (scene_check(&scene, &fault) != FAULT_NONE)
            fail_msg("%s", fault.text);
        assert_true(sample_scene_touch(&scene) > 0);
        scene_builder_destroy(&b);
        assert_null(b);
        scene_builder_destroy(&b);
    }
}

static void an_empty_builder_shows_an_empty_scene(void **state)
{
    (void)state;
    scene_builder_t *b = scene_builder_new();
    const scene_t scene = scene_builder_view(b);
    assert_null(scene.camera);
    assert_null(scene.normals);
    assert_null(scene.uvs);
    assert_int_equal(scene.vertex_count + scene.shape_count + scene.light_count + scene.texel_bytes, 0);
    scene_builder_destroy(&b);
}

/* Meshes without normals before, between and after those with them. */
static void vertex_data_stays_with_its_vertices(void **state)
{
    (void)state;
    fault_t fault = {0};
    scene_builder_t *b = scene_builder_new();
    const scene_shape_t shape = {.flags = SCENE_SHAPE_FLIP | SCENE_SHAPE_UVS, .area_light = SCENE_NONE};
    for (uint32_t i = 0; i < 100; i++) {
        uint32_t index = 0;
        const int full = i % 3 == 1;
        assert_int_equal(scene_builder_add_mesh(b, &shape, triangle, full ? normals : NULL, full ? triangle : NULL,
                                                3, corners, 1, &index, &fault),
                         FAULT_NONE);
        assert_int_equal(index, i);
        const scene_t scene = scene_builder_view(b);
        const scene_shape_t *s = &scene.shapes[i];
        assert_int_equal(s->flags, SCENE_SHAPE_FLIP | (full ? SCENE_SHAPE_NORMALS | SCENE_SHAPE_UVS : 0));
        assert_int_equal(s->first_vertex, 3 * i);
        assert_int_equal(s->first_triangle, i);
        assert_int_equal(s->vertices, 3);
        assert_int_equal(s->triangles, 1);
    }
    const scene_t scene = scene_builder_view(b);
    assert_int_equal(scene.vertex_count, 300);
    assert_int_equal(scene.triangle_count, 100);
    static const float zeros[9];
    for (uint32_t i = 0; i < 100; i++) {
        assert_memory_equal(scene.positions + 9 * i, triangle, sizeof triangle);
        assert_memory_equal(scene.normals + 9 * i, i % 3 == 1 ? normals : zeros, sizeof normals);
        assert_memory_equal(scene.uvs + 6 * i, i % 3 == 1 ? triangle : zeros, 6 * sizeof(float));
        assert_memory_equal(scene.indices + 3 * i, corners, sizeof corners);
    }
    scene_builder_destroy(&b);
}

static void images_begin_at_aligned_places(void **state)
{
    (void)state;
    fault_t fault = {0};
    scene_builder_t *b = scene_builder_new();
    uint8_t texels[64];
    for (uint32_t i = 0; i < 40; i++) {
        const scene_image_t image = {.offset = 12345, .width = 1 + i, .height = 1, .channels = 1};
        memset(texels, (int)i + 1, sizeof texels);
        assert_int_equal(scene_builder_add_image(b, &image, texels, NULL, &fault), FAULT_NONE);
    }
    const scene_t scene = scene_builder_view(b);
    for (uint32_t i = 0; i < 40; i++) {
        const scene_image_t *image = &scene.images[i];
        assert_int_equal(image->offset % 16, 0);
        assert_int_equal(scene.texels[image->offset], i + 1);
        assert_int_equal(scene.texels[image->offset + i], i + 1);
        const uint64_t end = i < 39 ? image[1].offset : scene.texel_bytes;
        for (uint64_t gap = image->offset + i + 1; gap < end; gap++)
            assert_int_equal(scene.texels[gap], 0);
    }
    scene_builder_destroy(&b);
}

static void limits_are_refused_before_anything_is_read(void **state)
{
    (void)state;
    fault_t fault = {0};
    scene_builder_t *b = scene_builder_new();
    const scene_shape_t shape = {.area_light = SCENE_NONE};
    static const uint64_t huge[] = {SCENE_MAX_VERTICES + 1, UINT64_MAX};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(scene_builder_add_mesh(b, &shape, NULL, NULL, NULL, huge[i], corners, 1, NULL, &fault),
                         FAULT_LIMIT);
        assert_int_equal(scene_builder_add_mesh(b, &shape, triangle, NULL, NULL, 3, NULL, huge[i], NULL, &fault),
                         FAULT_LIMIT);
    }
    static const scene_image_t images[] = {
        {.width = 0, .height = 1, .channels = 1},
        {.width = 1, .height = 1, .channels = 0},
        {.width = SCENE_MAX_IMAGE_SIZE + 1, .height = 1, .channels = 1},
        {.width = 1, .height = UINT32_MAX, .channels = 1},
        {.width = 1, .height = 1, .channels = UINT32_MAX},
    };
    for (size_t i = 0; i < sizeof images / sizeof *images; i++)
        assert_int_equal(scene_builder_add_image(b, &images[i], NULL, NULL, &fault), FAULT_LIMIT);
    const scene_t scene = scene_builder_view(b);
    assert_int_equal(scene.vertex_count + scene.triangle_count + scene.shape_count + scene.image_count, 0);
    scene_builder_destroy(&b);
}

static void records_end_at_their_limit(void **state)
{
    (void)state;
    fault_t fault = {0};
    scene_builder_t *b = scene_builder_new();
    const scene_material_t material = {0};
    uint32_t index = 0;
    for (uint32_t i = 0; i < SCENE_MAX_MATERIALS; i++)
        assert_int_equal(scene_builder_add_material(b, &material, &index, &fault), FAULT_NONE);
    assert_int_equal(index, SCENE_MAX_MATERIALS - 1);
    assert_int_equal(scene_builder_add_material(b, &material, &index, &fault), FAULT_LIMIT);
    assert_string_equal(fault.text, "a scene has more than 65536 materials");
    scene_builder_destroy(&b);
}

static void a_zero_parameter_names_no_texture(void **state)
{
    (void)state;
    fault_t fault = {0};
    scene_builder_t *b = scene_builder_new();
    const scene_material_t material = {.reflectance = {{0, 0, 0.5f}, 3}};
    assert_int_equal(scene_builder_add_material(b, &material, NULL, &fault), FAULT_NONE);
    const scene_t scene = scene_builder_view(b);
    assert_int_equal(scene.materials[0].reflectance.texture, 3);
    assert_int_equal(scene.materials[0].transmittance.texture, SCENE_NONE);
    assert_int_equal(scene.materials[0].mix.texture, SCENE_NONE);
    assert_int_equal(scene.materials[0].first, SCENE_NONE);
    scene_builder_destroy(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sample_passes_the_checks),
        cmocka_unit_test(an_empty_builder_shows_an_empty_scene),
        cmocka_unit_test(vertex_data_stays_with_its_vertices),
        cmocka_unit_test(images_begin_at_aligned_places),
        cmocka_unit_test(limits_are_refused_before_anything_is_read),
        cmocka_unit_test(records_end_at_their_limit),
        cmocka_unit_test(a_zero_parameter_names_no_texture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
