/* Polygon files: every encoding of one mesh gives the same mesh; damaged and hostile ones give faults. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "client/import/ply.h"
#include "client/import/stored_file.h"

enum { VERTICES = 5, MOST = 4096 };

/* A quad and a triangle, with normals, coordinates of texture and things to pass over. */
static const float vertex[VERTICES][8] = {{0, 0, 0.25f, 0, 0, 1, 0, 0},
                                          {1, 0, 0.25f, 0, 0, 1, 1, 0},
                                          {1, 1, 0.25f, 0, 0, 1, 1, 1},
                                          {0, 1, -0.5f, 0, 1, 0, 0, 1},
                                          {2, 2.385f, 0, 1, 0, 0, 0.5f, 0.5f}};
static const uint32_t expected_indices[9] = {0, 1, 2, 0, 2, 3, 1, 4, 2};

typedef struct bytes {
    uint8_t data[MOST];
    size_t size;
} bytes_t;

static void put(bytes_t *b, const void *data, size_t size, int swap)
{
    for (size_t i = 0; i < size; i++)
        b->data[b->size + i] = ((const uint8_t *)data)[swap ? size - 1 - i : i];
    b->size += size;
}

static void put_header(bytes_t *b, const char *format)
{
    b->size = (size_t)snprintf(
        (char *)b->data, MOST,
        "ply\nformat %s 1.0\ncomment made by a program with a name that is longer than any word in a header may "
        "be_and_without_any_white_space_so_that_it_is_one_word_of_more_than_sixty_four_bytes\nelement vertex "
        "%d\nproperty float x\nproperty "
        "double y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
        "property uchar red\nproperty list uchar short tags\nproperty float s\nproperty float t\n"
        "element edge 2\nproperty int a\nelement face 2\nproperty int8 flags\nproperty list "
        "uint8 uint32 vertex_indices\nend_header\n",
        format, VERTICES);
}

static void put_binary(bytes_t *b, int big)
{
    put_header(b, big ? "binary_big_endian" : "binary_little_endian");
    for (int i = 0; i < VERTICES; i++) {
        const uint8_t red = 200, tags = 2;
        const double y = (double)vertex[i][1];
        put(b, &vertex[i][0], 4, big);
        put(b, &y, 8, big);
        for (int j = 2; j < 6; j++)
            put(b, &vertex[i][j], 4, big);
        put(b, &red, 1, big);
        put(b, &tags, 1, big);
        for (int16_t j = -1; j < 1; j++)
            put(b, &j, 2, big);
        put(b, &vertex[i][6], 4, big);
        put(b, &vertex[i][7], 4, big);
    }
    for (int32_t i = 0; i < 2; i++)
        put(b, &i, 4, big);
    static const uint32_t quad[4] = {0, 1, 2, 3}, triangle[3] = {1, 4, 2};
    const int8_t flags = -1;
    const uint8_t four = 4, three = 3;
    put(b, &flags, 1, big);
    put(b, &four, 1, big);
    for (int i = 0; i < 4; i++)
        put(b, &quad[i], 4, big);
    put(b, &flags, 1, big);
    put(b, &three, 1, big);
    for (int i = 0; i < 3; i++)
        put(b, &triangle[i], 4, big);
}

static void put_ascii(bytes_t *b)
{
    put_header(b, "ascii");
    char *text = (char *)b->data;
    for (int i = 0; i < VERTICES; i++) {
        const float *v = vertex[i];
        b->size += (size_t)snprintf(text + b->size, MOST - b->size, "%.9g %.9g %.9g %g %g %g 200 2 -1 0 %g %g\n",
                                    (double)v[0], (double)v[1], (double)v[2], (double)v[3], (double)v[4],
                                    (double)v[5], (double)v[6], (double)v[7]);
    }
    b->size += (size_t)snprintf(text + b->size, MOST - b->size, "0\r\n1\r\n-1 4 0 1 2 3\r\n-1 3 1 4 2");
}

static void expect_mesh(const ply_mesh_t *mesh)
{
    assert_int_equal(mesh->vertices, VERTICES);
    assert_int_equal(mesh->triangles, 3);
    assert_memory_equal(mesh->indices, expected_indices, sizeof expected_indices);
    assert_non_null(mesh->normals);
    assert_non_null(mesh->uvs);
    for (int i = 0; i < VERTICES; i++) {
        assert_memory_equal(mesh->positions + 3 * i, vertex[i], 3 * sizeof(float));
        assert_memory_equal(mesh->normals + 3 * i, vertex[i] + 3, 3 * sizeof(float));
        assert_memory_equal(mesh->uvs + 2 * i, vertex[i] + 6, 2 * sizeof(float));
    }
}

static void make(bytes_t *b, int format)
{
    if (format == 0)
        put_ascii(b);
    else
        put_binary(b, format == 2);
}

static void every_encoding_gives_the_same_mesh(void **state)
{
    (void)state;
    for (int format = 0; format < 3; format++) {
        static bytes_t b;
        ply_mesh_t mesh;
        fault_t fault = {0};
        make(&b, format);
        if (ply_parse(b.data, b.size, &mesh, &fault))
            fail_msg("%s", fault.text);
        expect_mesh(&mesh);
        ply_mesh_clear(&mesh);
    }
}

static void compressed_files_are_unpacked(void **state)
{
    (void)state;
    static bytes_t b;
    char path[] = "/tmp/garland-ply-XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    put_binary(&b, 0);
    gzFile packed = gzdopen(file, "wb");
    assert_non_null(packed);
    assert_int_equal(gzwrite(packed, b.data, (unsigned)b.size), (int)b.size);
    gzclose(packed);
    ply_mesh_t mesh;
    fault_t fault = {0};
    if (ply_read(path, &mesh, &fault))
        fail_msg("%s", fault.text);
    expect_mesh(&mesh);
    ply_mesh_clear(&mesh);
    unlink(path);
    assert_int_equal(ply_read(path, &mesh, &fault), FAULT_NOT_FOUND);
}

static void what_unpacks_to_too_much_or_is_cut_is_refused(void **state)
{
    (void)state;
    enum { SIZE = 100000 };
    static uint8_t zeros[SIZE], packed[SIZE];
    z_stream z = {0};
    assert_int_equal(deflateInit2(&z, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
    z.next_in = zeros;
    z.avail_in = SIZE;
    z.next_out = packed;
    z.avail_out = SIZE;
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    const size_t size = SIZE - z.avail_out;
    deflateEnd(&z);
    uint8_t *out;
    size_t out_size;
    fault_t fault = {0};
    assert_int_equal(stored_file_unpack(packed, size, SIZE, &out, &out_size, &fault), FAULT_NONE);
    assert_int_equal(out_size, SIZE);
    assert_memory_equal(out, zeros, SIZE);
    free(out);
    assert_int_equal(stored_file_unpack(packed, size, SIZE - 1, &out, &out_size, &fault), FAULT_LIMIT);
    assert_int_equal(stored_file_unpack(packed, size, 10, &out, &out_size, &fault), FAULT_LIMIT);
    for (size_t cut = 2; cut < size; cut++)
        assert_int_equal(stored_file_unpack(packed, cut, SIZE, &out, &out_size, &fault), FAULT_FORMAT);
    packed[size - 6] ^= 0x55; /* in the checksum */
    assert_int_equal(stored_file_unpack(packed, size, SIZE, &out, &out_size, &fault), FAULT_FORMAT);
}

static void every_cut_is_noticed(void **state)
{
    (void)state;
    for (int format = 0; format < 3; format++) {
        static bytes_t b;
        make(&b, format);
        /* The last ascii number is one digit: without it a value is missing. */
        for (size_t size = 0; size < b.size; size++) {
            ply_mesh_t mesh;
            fault_t fault = {0};
            uint8_t *copy = malloc(size + 1); /* so that a sanitizer sees a read past the end */
            memcpy(copy, b.data, size);
            const fault_code_t code = ply_parse(copy, size, &mesh, &fault);
            free(copy);
            if (code != FAULT_FORMAT)
                fail_msg("format %d, %zu of %zu bytes: code %d", format, size, b.size, (int)code);
            assert_true(strlen(fault.text) > 0);
        }
    }
}

#define HEADER "ply\nformat ascii 1.0\n"
#define XYZ "property float x\nproperty float y\nproperty float z\n"

static void hostile_files_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {"", "not a PLY file"},
        {"obj\n", "not a PLY file"},
        {"ply\nformat ascii 2.0\nend_header\n", "expected version 1.0"},
        {"ply\nformat binary 1.0\nend_header\n", "line 2"},
        {"ply\nelement vertex 0\n" XYZ "end_header\n", "the format is missing"},
        {HEADER "property float x\nend_header\n", "before any element"},
        {HEADER "element vertex -1\n" XYZ "end_header\n", "\"-1\""},
        {HEADER "element vertex 99999999999999999999\n" XYZ "end_header\n", "element count"},
        {HEADER "element vertex 2000000000\n" XYZ "end_header\n1 2 3\n", "do not fit"},
        {HEADER "element vertex 3\nend_header\n", "no properties"},
        {HEADER "element vertex 1\nproperty float x\nend_header\n1\n", "no x, y, z"},
        {HEADER "element vertex 1\nproperty float x\n" XYZ "end_header\n1 1 1 1\n", "twice"},
        {HEADER "element vertex 1\nproperty quad x\nend_header\n1\n", "\"quad\""},
        {HEADER "element vertex 1\nproperty list float int x\nend_header\n1\n", "integer type"},
        {HEADER "element vertex 1\n" XYZ "end_header\n1 2 x\n", "line 8"},
        {HEADER "element vertex 1\n" XYZ "end_header\n1 2 nan\n", "expected a number"},
        {HEADER "element vertex 1\n" XYZ "end_header\n1 2 1e39\n", "not finite"},
        {HEADER "element vertex 1\n" XYZ "element vertex 1\n" XYZ "end_header\n1 2 3 1 2 3\n", "twice"},
        {HEADER "element face 1\nproperty list int int vertex_indices\nend_header\n3 0 0 0\n", "no vertices"},
        {HEADER "element vertex 1\n" XYZ
                "element face 1\nproperty list int int vertex_index\nend_header\n1 2 3\n3 0 0 1\n",
         "names vertex 1"},
        {HEADER "element vertex 1\n" XYZ
                "element face 1\nproperty list int int vertex_index\nend_header\n1 2 3\n3 0 0 -1\n",
         "-1"},
        {HEADER "element vertex 1\n" XYZ
                "element face 1\nproperty list int int vertex_index\nend_header\n1 2 3\n-3 0 0 0\n",
         "-3 corners"},
        {HEADER "element vertex 1\n" XYZ
                "element face 1\nproperty list int int vertex_index\nend_header\n1 2 3\n2000000000 0 0 0\n",
         "corners"},
        {HEADER "element vertex 1\nproperty float "
                "thisnameisverymuchlongerthananythingthatcanbeaproperty1234567890abcdefg\n",
         "too long"},
        {HEADER "\n\n\n", "end_header"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ply_mesh_t mesh;
        fault_t fault = {0};
        const fault_code_t code = ply_parse((const uint8_t *)cases[i].text, strlen(cases[i].text), &mesh, &fault);
        if (code != FAULT_FORMAT || !strstr(fault.text, cases[i].says))
            fail_msg("case %zu: code %d, \"%s\" does not say \"%s\"", i, (int)code, fault.text, cases[i].says);
        assert_null(mesh.positions);
    }
}

static void large_polygons_become_fans(void **state)
{
    (void)state;
    enum { N = 100 };
    char text[8192];
    int size = snprintf(
        text, sizeof text,
        HEADER "element vertex %d\n" XYZ "element face 1\nproperty list int int vertex_index\nend_header\n", N);
    for (int i = 0; i < N; i++)
        size += snprintf(text + size, sizeof text - (size_t)size, "%d %d 0\n", i, i * i);
    size += snprintf(text + size, sizeof text - (size_t)size, "%d", N);
    for (int i = 0; i < N; i++)
        size += snprintf(text + size, sizeof text - (size_t)size, " %d", i);
    ply_mesh_t mesh;
    fault_t fault = {0};
    assert_int_equal(ply_parse((const uint8_t *)text, (size_t)size, &mesh, &fault), FAULT_NONE);
    assert_int_equal(mesh.triangles, N - 2);
    for (uint32_t i = 0; i < N - 2; i++) {
        assert_int_equal(mesh.indices[3 * i], 0);
        assert_int_equal(mesh.indices[3 * i + 1], i + 1);
        assert_int_equal(mesh.indices[3 * i + 2], i + 2);
    }
    ply_mesh_clear(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_encoding_gives_the_same_mesh),
        cmocka_unit_test(compressed_files_are_unpacked),
        cmocka_unit_test(what_unpacks_to_too_much_or_is_cut_is_refused),
        cmocka_unit_test(every_cut_is_noticed),
        cmocka_unit_test(hostile_files_are_refused),
        cmocka_unit_test(large_polygons_become_fans),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
