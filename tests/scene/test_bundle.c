#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/random.h"
#include "scene/bundle.h"
#include "scene/sample_scene.h"

/* The format as docs/bundle.md states it, independent of the code. */
enum { HEADER = 64, ENTRY = 32, SECTIONS = 11, TABLE_END = HEADER + SECTIONS * ENTRY, ALIGNMENT = 64 };
enum { AT_VERSION = 8, AT_SECTIONS = 12, AT_SIZE = 16, ENTRY_OFFSET = 8, ENTRY_COUNT = 16 };

static uint8_t *sample; /* aligned */
static size_t sample_size;
static digest_t sample_digest;
static uint8_t *work; /* a copy to spoil, aligned */

static uint8_t *aligned_copy(const uint8_t *data, size_t size)
{
    uint8_t *copy = aligned_alloc(ALIGNMENT, (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT);
    memcpy(copy, data, size);
    return copy;
}

static int make_sample(void **state)
{
    (void)state;
    uint8_t *data;
    fault_t fault = {0};
    scene_builder_t *b = sample_scene_build(0);
    const scene_t scene = scene_builder_view(b);
    if (bundle_encode(&scene, &data, &sample_size, &sample_digest, &fault) != FAULT_NONE)
        return -1;
    sample = aligned_copy(data, sample_size);
    work = aligned_copy(data, sample_size);
    free(data);
    scene_builder_destroy(&b);
    return 0;
}

static int free_sample(void **state)
{
    (void)state;
    free(sample);
    free(work);
    return 0;
}

static void sign(uint8_t *data, size_t size)
{
    digest_t digest;
    digest_of(&digest, data, size - DIGEST_SIZE);
    memcpy(data + size - DIGEST_SIZE, digest.bytes, DIGEST_SIZE);
}

static void put_u32(uint8_t *at, uint32_t value)
{
    memcpy(at, &value, sizeof value);
}

static void put_u64(uint8_t *at, uint64_t value)
{
    memcpy(at, &value, sizeof value);
}

static uint64_t get_u64(const uint8_t *at)
{
    uint64_t value;
    memcpy(&value, at, sizeof value);
    return value;
}

static void assert_refused(const uint8_t *data, size_t size, const char *what, size_t where)
{
    bundle_t *bundle = NULL;
    fault_t fault = {0};
    const fault_code_t code = bundle_open_memory(&bundle, data, size, &fault);
    if (code == FAULT_NONE || bundle || fault.text[0] == '\0' || fault.code != code)
        fail_msg("%s at %zu: code %d, text \"%s\"", what, where, (int)code, fault.text);
}

/* ---- what is written is read ---- */

static void assert_same_array(const void *a, const void *b, uint64_t count, size_t record)
{
    assert_int_equal(a == NULL, b == NULL);
    if (a)
        assert_memory_equal(a, b, count * record);
}

static void assert_same_scene(const scene_t *a, const scene_t *b)
{
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_int_equal(a->texel_bytes, b->texel_bytes);
    assert_int_equal(a->shape_count, b->shape_count);
    assert_int_equal(a->material_count, b->material_count);
    assert_int_equal(a->texture_count, b->texture_count);
    assert_int_equal(a->image_count, b->image_count);
    assert_int_equal(a->light_count, b->light_count);
    assert_same_array(a->positions, b->positions, a->vertex_count, 12);
    assert_same_array(a->normals, b->normals, a->vertex_count, 12);
    assert_same_array(a->uvs, b->uvs, a->vertex_count, 8);
    assert_same_array(a->indices, b->indices, a->triangle_count, 12);
    assert_same_array(a->shapes, b->shapes, a->shape_count, sizeof *a->shapes);
    assert_same_array(a->materials, b->materials, a->material_count, sizeof *a->materials);
    assert_same_array(a->textures, b->textures, a->texture_count, sizeof *a->textures);
    assert_same_array(a->images, b->images, a->image_count, sizeof *a->images);
    assert_same_array(a->texels, b->texels, a->texel_bytes, 1);
    assert_same_array(a->lights, b->lights, a->light_count, sizeof *a->lights);
    assert_same_array(a->camera, b->camera, 1, sizeof *a->camera);
}

static void a_file_gives_back_the_scene(void **state)
{
    (void)state;
    char path[] = "/tmp/garland-test-XXXXXX";
    fault_t fault = {0};
    digest_t digest;
    bundle_t *bundle = NULL;
    size_t size = 0;
    close(mkstemp(path));
    scene_builder_t *b = sample_scene_build(0);
    const scene_t scene = scene_builder_view(b);
    assert_int_equal(bundle_save(&scene, path, &digest, &fault), FAULT_NONE);
    assert_true(bundle_probe(path));
    if (bundle_open(&bundle, path, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    assert_same_scene(&scene, bundle_scene(bundle));
    assert_true(digest_equal(&digest, bundle_digest(bundle)));
    assert_true(digest_equal(&digest, &sample_digest));
    const uint8_t *bytes = bundle_bytes(bundle, &size);
    assert_int_equal(size, sample_size);
    assert_memory_equal(bytes, sample, size);
    bundle_destroy(&bundle);
    assert_null(bundle);
    bundle_destroy(&bundle);
    scene_builder_destroy(&b);
    unlink(path);
}

static void a_scene_without_meshes_images_or_lights_is_kept(void **state)
{
    (void)state;
    fault_t fault = {0};
    digest_t digest;
    uint8_t *data;
    size_t size;
    bundle_t *bundle = NULL;
    scene_builder_t *b = sample_scene_build(0), *bare = scene_builder_new();
    const scene_t full = scene_builder_view(b);
    scene_builder_set_camera(bare, full.camera);
    const scene_t scene = scene_builder_view(bare);
    assert_int_equal(bundle_encode(&scene, &data, &size, &digest, &fault), FAULT_NONE);
    uint8_t *copy = aligned_copy(data, size);
    if (bundle_open_memory(&bundle, copy, size, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    assert_int_equal(bundle_scene(bundle)->shape_count, 0);
    assert_null(bundle_scene(bundle)->positions);
    assert_memory_equal(bundle_scene(bundle)->camera, full.camera, sizeof *full.camera);
    bundle_destroy(&bundle);
    scene_builder_destroy(&b);
    scene_builder_destroy(&bare);
    free(copy);
    free(data);
}

static void the_same_scene_has_the_same_digest(void **state)
{
    (void)state;
    fault_t fault = {0};
    for (int dirty = 0; dirty < 2; dirty++) {
        digest_t digest;
        uint8_t *data;
        size_t size;
        scene_builder_t *b = sample_scene_build(dirty);
        const scene_t scene = scene_builder_view(b);
        assert_int_equal(bundle_encode(&scene, &data, &size, &digest, &fault), FAULT_NONE);
        assert_true(digest_equal(&digest, &sample_digest));
        assert_memory_equal(data, sample, size);
        free(data);
        scene_builder_destroy(&b);
    }
}

static void a_scene_that_fails_the_checks_is_not_saved(void **state)
{
    (void)state;
    fault_t fault = {0};
    digest_t digest;
    scene_builder_t *b = scene_builder_new();
    const scene_t scene = scene_builder_view(b);
    assert_int_equal(bundle_save(&scene, "/tmp/garland-test-never", &digest, &fault), FAULT_FORMAT);
    assert_string_equal(fault.text, "the scene has no camera");
    assert_false(file_exists("/tmp/garland-test-never"));
    scene_builder_destroy(&b);
}

static void the_layout_is_the_documented_one(void **state)
{
    (void)state;
    static const uint32_t records[SECTIONS] = {12, 12, 8, 12, 96, 156, 96, 24, 1, 104, 208};
    uint64_t end = TABLE_END;
    assert_memory_equal(sample, "\x89GLND\r\n\x1a\x01\0\0\0\x0b\0\0\0", 16);
    assert_int_equal(get_u64(sample + AT_SIZE), sample_size);
    for (uint32_t i = 0; i < SECTIONS; i++) {
        const uint8_t *entry = sample + HEADER + i * ENTRY;
        const uint64_t offset = (end + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
        assert_int_equal(get_u64(entry), (i + 1) | (uint64_t)records[i] << 32);
        assert_int_equal(get_u64(entry + ENTRY_OFFSET), offset);
        end = offset + get_u64(entry + ENTRY_COUNT) * records[i];
    }
    assert_int_equal(end + DIGEST_SIZE, sample_size);
}

/* ---- what is damaged is refused ---- */

static void every_cut_is_refused(void **state)
{
    (void)state;
    for (size_t size = 0; size < sample_size; size++) {
        uint8_t *cut = aligned_copy(sample, size); /* of its own, so that a sanitizer sees a read beyond */
        assert_refused(cut, size, "cut", size);
        if (size >= HEADER) { /* a shorter file that claims its own size, signed anew */
            put_u64(cut + AT_SIZE, size);
            if (size >= TABLE_END + DIGEST_SIZE)
                sign(cut, size);
            assert_refused(cut, size, "cut and signed", size);
        }
        free(cut);
    }
}

static void appended_bytes_are_refused(void **state)
{
    (void)state;
    const size_t size = sample_size + ALIGNMENT;
    uint8_t *longer = aligned_alloc(ALIGNMENT, (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT);
    memset(longer, 0, size);
    memcpy(longer, sample, sample_size);
    assert_refused(longer, size, "appended", size);
    put_u64(longer + AT_SIZE, size);
    sign(longer, size);
    assert_refused(longer, size, "appended and signed", size);
    free(longer);
}

static void every_flipped_bit_is_refused(void **state)
{
    (void)state;
    for (size_t bit = 0; bit < 8 * sample_size; bit++) {
        work[bit / 8] ^= (uint8_t)(1u << bit % 8);
        assert_refused(work, sample_size, "bit", bit);
        work[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    assert_memory_equal(work, sample, sample_size);
}

static void version_and_magic_have_their_messages(void **state)
{
    (void)state;
    fault_t fault = {0};
    bundle_t *bundle = NULL;
    put_u32(work + AT_VERSION, BUNDLE_VERSION + 1);
    assert_int_equal(bundle_open_memory(&bundle, work, sample_size, &fault), FAULT_VERSION);
    assert_string_equal(fault.text, "the bundle has format version 2, expected 1");
    memcpy(work, sample, sample_size);
    work[0] = 'x';
    assert_int_equal(bundle_open_memory(&bundle, work, sample_size, &fault), FAULT_FORMAT);
    assert_non_null(strstr(fault.text, "not a bundle"));
    memcpy(work, sample, sample_size);
    work[sample_size / 2] ^= 4;
    assert_int_equal(bundle_open_memory(&bundle, work, sample_size, &fault), FAULT_FORMAT);
    assert_non_null(strstr(fault.text, "is damaged"));
    memcpy(work, sample, sample_size);
    assert_int_equal(bundle_open_memory(&bundle, sample + 1, sample_size - 1, &fault), FAULT_USAGE);
}

static void what_is_no_bundle_file_says_so(void **state)
{
    (void)state;
    char path[] = "/tmp/garland-test-XXXXXX";
    fault_t fault = {0};
    bundle_t *bundle = NULL;
    close(mkstemp(path));
    assert_int_equal(bundle_open(&bundle, path, &fault), FAULT_FORMAT);
    assert_non_null(strstr(fault.text, "the file is empty"));
    assert_false(bundle_probe(path));
    assert_int_equal(file_write(path, "{\"scene\": 1}", 12, &fault), FAULT_NONE);
    assert_int_equal(bundle_open(&bundle, path, &fault), FAULT_FORMAT);
    assert_non_null(strstr(fault.text, path));
    assert_non_null(strstr(fault.text, "not a bundle"));
    assert_false(bundle_probe(path));
    unlink(path);
    assert_int_equal(bundle_open(&bundle, path, &fault), FAULT_NOT_FOUND);
    assert_false(bundle_probe(path));
    assert_int_equal(bundle_open(&bundle, "/tmp", &fault), FAULT_IO);
    assert_false(bundle_probe("/tmp"));
}

/* ---- what is hostile, signed as if it were right ---- */

static void header_and_table_allow_no_other_value(void **state)
{
    (void)state;
    for (size_t bit = 0; bit < 8 * TABLE_END; bit++) {
        work[bit / 8] ^= (uint8_t)(1u << bit % 8);
        sign(work, sample_size);
        assert_refused(work, sample_size, "signed bit", bit);
        work[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    sign(work, sample_size);
    assert_memory_equal(work, sample, sample_size);
}

static void hostile_table_entries_are_refused(void **state)
{
    (void)state;
    static const uint64_t values[] = {0,
                                      1,
                                      63,
                                      64,
                                      1u << 31,
                                      UINT64_C(1) << 32,
                                      UINT64_C(1) << 60,
                                      UINT64_C(1) << 63,
                                      UINT64_MAX - 63,
                                      UINT64_MAX,
                                      UINT64_MAX / 12 + 1};
    for (size_t i = 0; i < SECTIONS; i++) {
        uint8_t *entry = work + HEADER + i * ENTRY;
        for (size_t a = 0; a < sizeof values / sizeof *values; a++) {
            for (size_t b = 0; b < sizeof values / sizeof *values; b++) {
                put_u64(entry + ENTRY_OFFSET, values[a]);
                put_u64(entry + ENTRY_COUNT, values[b]);
                sign(work, sample_size);
                assert_refused(work, sample_size, "section", i);
            }
            memcpy(work, sample, sample_size);
            put_u64(entry + ENTRY_COUNT, values[a]);
            if (memcmp(work, sample, sample_size - DIGEST_SIZE) != 0) { /* one camera is right */
                sign(work, sample_size);
                assert_refused(work, sample_size, "count of section", i);
            }
            memcpy(work, sample, sample_size);
        }
    }
}

/* Accepted only if everything in it can be used, and then it is the encoding of the scene that it holds. */
static void assert_refused_or_whole(const uint8_t *data, size_t size)
{
    bundle_t *bundle = NULL;
    fault_t fault = {0};
    uint8_t *again;
    size_t again_size;
    digest_t digest;
    if (bundle_open_memory(&bundle, data, size, &fault) != FAULT_NONE) {
        assert_int_not_equal(fault.text[0], '\0');
        return;
    }
    const double sum = sample_scene_touch(bundle_scene(bundle));
    assert_true(sum - sum == 0);
    assert_int_equal(bundle_encode(bundle_scene(bundle), &again, &again_size, &digest, &fault), FAULT_NONE);
    assert_int_equal(again_size, size);
    assert_memory_equal(again, data, size);
    free(again);
    bundle_destroy(&bundle);
}

static void signed_bits_of_the_content_are_refused_or_harmless(void **state)
{
    (void)state;
    for (size_t bit = 8 * TABLE_END; bit < 8 * (sample_size - DIGEST_SIZE); bit++) {
        work[bit / 8] ^= (uint8_t)(1u << bit % 8);
        sign(work, sample_size);
        assert_refused_or_whole(work, sample_size);
        work[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    sign(work, sample_size);
    assert_memory_equal(work, sample, sample_size);
}

static void signed_random_words_are_refused_or_harmless(void **state)
{
    (void)state;
    for (uint64_t trial = 0; trial < 20000; trial++) {
        const uint64_t key = random_key(4, RANDOM_PURPOSE_TEST, 0, trial);
        const uint64_t edits = 1 + random_u64(key, 0) % 3;
        static const uint32_t odd[] = {0,          1,          UINT32_MAX, 0x7fffffff,
                                       0x80000000, 0x7f800000, 0x7fc00000, 0x7149f2ca};
        for (uint64_t e = 0; e < edits; e++) {
            const size_t words = (sample_size - DIGEST_SIZE) / 4,
                         at = 4 * (size_t)(random_u64(key, 3 * e + 1) % words);
            const uint64_t value = random_u64(key, 3 * e + 2);
            put_u32(work + at, value & 1 ? (uint32_t)(value >> 32) : odd[value >> 1 & 7]);
        }
        sign(work, sample_size);
        assert_refused_or_whole(work, sample_size);
        memcpy(work, sample, sample_size);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_gives_back_the_scene),
        cmocka_unit_test(a_scene_without_meshes_images_or_lights_is_kept),
        cmocka_unit_test(the_same_scene_has_the_same_digest),
        cmocka_unit_test(a_scene_that_fails_the_checks_is_not_saved),
        cmocka_unit_test(the_layout_is_the_documented_one),
        cmocka_unit_test(every_cut_is_refused),
        cmocka_unit_test(appended_bytes_are_refused),
        cmocka_unit_test(every_flipped_bit_is_refused),
        cmocka_unit_test(version_and_magic_have_their_messages),
        cmocka_unit_test(what_is_no_bundle_file_says_so),
        cmocka_unit_test(header_and_table_allow_no_other_value),
        cmocka_unit_test(hostile_table_entries_are_refused),
        cmocka_unit_test(signed_bits_of_the_content_are_refused_or_harmless),
        cmocka_unit_test(signed_random_words_are_refused_or_harmless),
    };
    return cmocka_run_group_tests(tests, make_sample, free_sample);
}
