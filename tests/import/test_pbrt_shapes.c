/* Shapes: geometry, sides, tessellation, alpha. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "client/import/surfaces.h"
#include "import/read_text.h"
#include "math/vec.h"
#include "support/near.h"

/* Single precision of numbers of the order of one. */
#define CLOSE 3e-7

static void expect_vec(const float *found, double x, double y, double z, double tolerance)
{
    assert_near((double)found[0], x, tolerance);
    assert_near((double)found[1], y, tolerance);
    assert_near((double)found[2], z, tolerance);
}

static vec3_t corner(const scene_t *s, uint32_t shape, uint32_t triangle, int i)
{
    const scene_shape_t *h = &s->shapes[shape];
    const float *p =
        s->positions +
        3 * (uint64_t)(h->first_vertex + s->indices[3 * (uint64_t)(h->first_triangle + triangle) + (uint32_t)i]);
    return vec3((double)p[0], (double)p[1], (double)p[2]);
}

/* The area vector of a triangle on the shape's outer side. */
static vec3_t area_vector(const scene_t *s, uint32_t shape, uint32_t triangle)
{
    const vec3_t p0 = corner(s, shape, triangle, 0);
    const vec3_t n =
        vec3_cross(vec3_sub(corner(s, shape, triangle, 1), p0), vec3_sub(corner(s, shape, triangle, 2), p0));
    return vec3_scale(n, s->shapes[shape].flags & SCENE_SHAPE_FLIP ? -0.5 : 0.5);
}

static double mesh_area(const scene_t *s, uint32_t shape)
{
    double area = 0;
    for (uint32_t i = 0; i < s->shapes[shape].triangles; i++)
        area += vec3_length(area_vector(s, shape, i));
    return area;
}

/* Volume between the origin and the mesh: the whole volume for a closed one that faces outwards (Gauss). */
static double mesh_volume(const scene_t *s, uint32_t shape)
{
    double volume = 0;
    for (uint32_t i = 0; i < s->shapes[shape].triangles; i++)
        volume += vec3_dot(area_vector(s, shape, i), corner(s, shape, i, 0)) / 3;
    return volume;
}

#define TRIANGLE "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] "

static void sides_follow_orientation_and_mirrors(void **state)
{
    (void)state;
    static const struct {
        const char *before;
        double z; /* of the outer side */
    } cases[] = {{"", 1},
                 {"ReverseOrientation ", -1},
                 {"Scale -1 1 1 ", 1},
                 {"Scale -1 1 1 ReverseOrientation ", -1},
                 {"Scale -1 -1 1 ", 1},
                 {"Scale 1 1 -1 ", -1}, /* the side turns with the surface */
                 {"Rotate 180 1 0 0 ", -1},
                 {"ReverseOrientation ReverseOrientation ", 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (int normals = 0; normals < 2; normals++) {
            char world[256];
            /* With normals the same must hold, by exchanging corners. */
            snprintf(world, sizeof world, "%s" TRIANGLE "%s", cases[i].before,
                     normals ? "\"normal N\" [0 0 1 0 .6 .8 0 0 1]" : "");
            reading_t r = read_world(world);
            assert_near(area_vector(&r.scene, 0, 0).z, 0.5 * cases[i].z, CLOSE);
            assert_int_equal(r.scene.shapes[0].flags & SCENE_SHAPE_NORMALS ? 1 : 0, normals);
            if (normals) {
                assert_int_equal(r.scene.shapes[0].flags & SCENE_SHAPE_FLIP, 0);
                assert_near((double)r.scene.normals[2], cases[i].z, CLOSE);
            }
            reading_end(&r);
        }
    }
}

static void normals_that_are_their_triangles_own_are_left_out(void **state)
{
    (void)state;
    reading_t r = read_world(TRIANGLE "\"normal N\" [0 0 1 0 0 3 0 0 1]");
    assert_int_equal(r.scene.shapes[0].flags & SCENE_SHAPE_NORMALS, 0);
    reading_end(&r);
    /* The side that they name is kept. */
    r = read_world(TRIANGLE "\"normal N\" [0 0 -1 0 0 -1 0 0 -1]");
    assert_int_equal(r.scene.shapes[0].flags & SCENE_SHAPE_NORMALS, 0);
    assert_near(area_vector(&r.scene, 0, 0).z, -0.5, CLOSE);
    reading_end(&r);
}

static void normals_decide_the_side_of_each_triangle(void **state)
{
    (void)state;
    /* Two triangles wound against each other; the normals of both point to +z, of any length. */
    reading_t r = read_world("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]\n"
                             "\"integer indices\" [0 1 2 1 2 3] \"normal N\" [0 0 3 0 0 1 0 .1 .2 0 0 1]");
    assert_near(area_vector(&r.scene, 0, 0).z, 0.5, CLOSE);
    assert_near(area_vector(&r.scene, 0, 1).z, 0.5, CLOSE);
    expect_vec(r.scene.normals, 0, 0, 1, CLOSE);
    expect_vec(r.scene.normals + 6, 0, sqrt(0.2), sqrt(0.8), CLOSE);
    reading_end(&r);
    /* Normals go with the inverse transpose: (1,1,0) under a stretch by 2 along x becomes (1/2, 1, 0). */
    r = read_world(
        "Scale 2 1 1 Shape \"trianglemesh\" \"point3 P\" [1 0 0 0 1 0 0 1 1] \"normal N\" [1 1 0 1 1 0 1 1 1]");
    expect_vec(r.scene.normals, 1 / sqrt(5), 2 / sqrt(5), 0, CLOSE);
    reading_end(&r);
}

static void triangles_of_no_area_are_left_out(void **state)
{
    (void)state;
    reading_t r = read_world("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 2 0 0]\n"
                             "\"integer indices\" [0 1 2  0 1 3  1 1 2]\n"
                             "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 1 1 2 2 2] Shape \"sphere\"");
    assert_int_equal(r.scene.shape_count, 2); /* nothing is left of the second mesh */
    assert_int_equal(r.scene.shapes[0].triangles, 1);
    assert_int_equal(import_notes_count(r.notes), 1);
    assert_true(reading_notes(&r, "test.pbrt:2: 3 triangles of no area"));
    reading_end(&r);
    /* A normal of no length is replaced by that of a triangle. */
    r = read_world(TRIANGLE "\"normal N\" [0 0 0 0 0 1 0 .6 .8]");
    expect_vec(r.scene.normals, 0, 0, 1, CLOSE);
    assert_true(reading_notes(&r, "1 vertex normals"));
    reading_end(&r);
}

static void texture_coordinates_belong_to_vertices(void **state)
{
    (void)state;
    reading_t r = read_world(TRIANGLE "\"point2 uv\" [.1 .2 .3 .4 .5 .6]");
    assert_int_equal(r.scene.shapes[0].flags, SCENE_SHAPE_UVS);
    assert_near((double)r.scene.uvs[3], 0.4, CLOSE);
    reading_end(&r);
    read_world_fails(TRIANGLE "\"point2 uv\" [.1 .2 .3 .4]", FAULT_FORMAT,
                     WORDS("2 texture coordinates for 3 points"));
    read_world_fails(TRIANGLE "\"normal N\" [1 0 0]", FAULT_FORMAT, WORDS("1 normals for 3 points"));
    read_world_fails(TRIANGLE "\"integer indices\" [0 1 3]", FAULT_RANGE, WORDS("index 3 at place 2", "0 to 2"));
    read_world_fails(TRIANGLE "\"integer indices\" [0 1 -1]", FAULT_RANGE, WORDS("index -1"));
    read_world_fails(TRIANGLE "\"integer indices\" [0 1]", FAULT_FORMAT, WORDS("multiple of 3"));
    read_world_fails("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0]", FAULT_FORMAT, WORDS("no \"indices\""));
    read_world_fails("Shape \"trianglemesh\" \"integer indices\" [0 1 2]", FAULT_FORMAT, WORDS("no \"point3 P\""));
}

static void spheres_and_disks_stay_exact_under_similarities(void **state)
{
    (void)state;
    reading_t r =
        read_world("Translate 1 2 3 Rotate 90 1 0 0 Scale 2 2 2 Shape \"sphere\" \"float radius\" 1.5\n"
                   "Shape \"disk\" \"float radius\" 0.5 \"float height\" 3 ReverseOrientation Shape \"disk\"\n"
                   "Identity Scale 1 1 -1 Shape \"disk\" Shape \"sphere\"");
    const scene_shape_t *s = r.scene.shapes;
    assert_int_equal(s[0].kind, SCENE_SHAPE_SPHERE);
    expect_vec(s[0].centre, 1, 2, 3, CLOSE);
    assert_near((double)s[0].radius, 3, CLOSE);
    expect_vec(s[0].normal, 0, -1, 0, CLOSE); /* z -> -y */
    expect_vec(s[0].tangent, 1, 0, 0, CLOSE);
    assert_int_equal(s[1].kind, SCENE_SHAPE_DISK);
    expect_vec(s[1].centre, 1, -4, 3, 2 * CLOSE);
    assert_near((double)s[1].radius, 1, CLOSE);
    expect_vec(s[1].normal, 0, -1, 0, CLOSE);
    assert_int_equal(s[1].flags, 0);
    assert_int_equal(s[2].flags, SCENE_SHAPE_FLIP);
    /* Mirrored along its axis a disk faces the other way; a sphere is as it was. Both are under ReverseOrientation.
     */
    expect_vec(s[3].normal, 0, 0, -1, CLOSE);
    assert_int_equal(s[3].flags, SCENE_SHAPE_FLIP);
    assert_int_equal(s[4].kind, SCENE_SHAPE_SPHERE);
    assert_int_equal(import_notes_count(r.notes), 0);
    reading_end(&r);
    read_world_fails("Shape \"sphere\" \"float radius\" 0", FAULT_RANGE, WORDS("radius"));
    read_world_fails("Shape \"disk\" \"float innerradius\" 2", FAULT_RANGE, WORDS("innerradius"));
    read_world_fails("Shape \"sphere\" \"float zmin\" 2 \"float zmax\" 3", FAULT_RANGE, WORDS("zmin"));
}

/* A polygon of n = 128 corners in a circle has 1 - (2 pi / n)^2 / 6 = 1 - 4.0e-4 of its area; the second direction
 * of a sphere (64 steps over half a turn: the same polygon) takes at most twice that of the volume again. */
#define TESSELLATED 1.3e-3

static void ellipsoids_and_parts_are_tessellated(void **state)
{
    (void)state;
    reading_t r = read_world("AttributeBegin Scale 1 2 3 Shape \"sphere\" AttributeEnd\n"
                             "AttributeBegin Scale -1 2 3 Shape \"sphere\" Shape \"disk\" AttributeEnd\n"
                             "Shape \"sphere\" \"float zmin\" -.5 \"float zmax\" .25 \"float phimax\" 90\n"
                             "Shape \"disk\" \"float innerradius\" .5 \"float phimax\" 180\n"
                             "Shape \"cylinder\" \"float radius\" 2 \"float zmin\" -1 \"float zmax\" 3\n"
                             "ReverseOrientation Scale 1 1 2 Shape \"sphere\"");
    const double pi = MATH_PI;
    assert_near(mesh_volume(&r.scene, 0) / (4 * pi / 3 * 6), 1, TESSELLATED);
    assert_near(mesh_volume(&r.scene, 1) / (4 * pi / 3 * 6), 1, TESSELLATED);
    assert_near(mesh_area(&r.scene, 2) / (2 * pi), 1, TESSELLATED);
    assert_near(area_vector(&r.scene, 2, 5).z > 0, 1, 0);
    assert_near(mesh_area(&r.scene, 3) / (2 * pi * 0.75 / 4), 1, TESSELLATED); /* Archimedes: 2 pi r h */
    assert_near(mesh_area(&r.scene, 4) / (0.5 * pi * (1 - 0.25)), 1, TESSELLATED);
    assert_near(mesh_area(&r.scene, 5) / (2 * pi * 2 * 4), 1, TESSELLATED);
    assert_near(mesh_volume(&r.scene, 5) / (2.0 / 3 * pi * 4 * 4), 1, TESSELLATED); /* the mantle's share */
    assert_near(mesh_volume(&r.scene, 6) / (-4 * pi / 3 * 2), 1, TESSELLATED);
    assert_true(reading_notes(&r, "parts of spheres"));
    assert_true(reading_notes(&r, "rings and sectors"));
    assert_true(reading_notes(&r, "cylinders"));
    assert_true(reading_notes(&r, "stretched"));
    assert_false(reading_notes(&r, "no area")); /* those at the poles are nobody's mistake */
    /* Normals are those of the ellipsoid x^2 + y^2/4 + z^2/9 = 1. */
    for (uint32_t i = 0; i < r.scene.shapes[0].vertices; i += 97) {
        const float *p = r.scene.positions + 3 * i, *n = r.scene.normals + 3 * i;
        const vec3_t g = vec3_unit(vec3((double)p[0], (double)p[1] / 4, (double)p[2] / 9));
        expect_vec(n, g.x, g.y, g.z, 1e-5);
    }
    reading_end(&r);
}

static void bilinear_patches_are_split_or_divided(void **state)
{
    (void)state;
    reading_t r = read_world("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 1 0 2 1 0]\n"
                             "ReverseOrientation Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 1 0 2 1 0]\n"
                             "ReverseOrientation Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]\n"
                             "\"point2 uv\" [0 0 2 0 0 2 2 2]");
    assert_int_equal(r.scene.shapes[0].triangles, 2);
    for (uint32_t i = 0; i < 2; i++) {
        assert_near(area_vector(&r.scene, 0, i).z, 1, CLOSE);
        assert_near(area_vector(&r.scene, 1, i).z, -1, CLOSE);
    }
    assert_int_equal(r.scene.shapes[2].triangles, 2 * SURFACES_PATCH * SURFACES_PATCH);
    for (uint32_t i = 0; i < r.scene.shapes[2].vertices; i++) { /* the patch is z = x y, uv twice (x, y) */
        const float *p = r.scene.positions + 3 * (r.scene.shapes[2].first_vertex + i);
        const float *uv = r.scene.uvs + 2 * (r.scene.shapes[2].first_vertex + i);
        assert_near((double)p[2], (double)p[0] * (double)p[1], CLOSE);
        assert_near((double)uv[0], 2 * (double)p[0], CLOSE);
        assert_near((double)uv[1], 2 * (double)p[1], CLOSE);
    }
    for (uint32_t i = 0; i < r.scene.shapes[2].triangles; i++)
        assert_true(area_vector(&r.scene, 2, i).z > 0);
    assert_true(reading_notes(&r, "16 x 16"));
    reading_end(&r);
}

static void other_shapes_are_named(void **state)
{
    (void)state;
    reading_t r =
        read_world("Shape \"curve\" \"point3 P\" [0 0 0 1 1 1]\nShape \"loopsubdiv\" \"integer levels\" 3\n"
                   "\"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]");
    assert_int_equal(r.scene.shape_count, 1);
    assert_int_equal(import_notes_count(r.notes), 2);
    assert_true(reading_notes(&r, "test.pbrt:2: shapes of the kind \"curve\""));
    assert_true(reading_notes(&r, "control mesh"));
    reading_end(&r);
}

static void alpha_is_a_number_or_a_texture(void **state)
{
    (void)state;
    reading_t r = read_world("Texture \"c\" \"float\" \"constant\" \"float value\" .25\n"
                             "Texture \"k\" \"float\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 5\n"
                             "Shape \"sphere\" \"float alpha\" .5 Shape \"sphere\" \"texture alpha\" \"c\"\n"
                             "Shape \"sphere\" \"texture alpha\" \"k\" Shape \"sphere\"");
    assert_near((double)r.scene.shapes[0].alpha.value[0], 0.5, 0);
    assert_near((double)r.scene.shapes[1].alpha.value[0], 0.25, 0);
    assert_int_equal(r.scene.shapes[1].alpha.texture, SCENE_NONE);
    assert_int_equal(r.scene.shapes[2].alpha.texture, 1);
    assert_int_equal(r.scene.textures[1].kind, SCENE_TEXTURE_CHECKERBOARD);
    assert_near((double)r.scene.textures[1].scale_v, 5, 0);
    assert_near((double)r.scene.shapes[3].alpha.value[0], 1, 0);
    reading_end(&r);
}

static void polygon_files_become_shapes(void **state)
{
    (void)state;
    static const char ply[] =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n2 0 1\n";
    read_text_write("quad.ply", ply, sizeof ply - 1);
    reading_t r = read_world("Scale 3 1 1 Shape \"plymesh\" \"string filename\" \"quad.ply\"");
    assert_near(mesh_area(&r.scene, 0), 3, CLOSE);
    assert_true(reading_notes(&r, "1 faces"));
    reading_end(&r);
    read_world_fails("Shape \"plymesh\"", FAULT_FORMAT, WORDS("filename"));
    read_world_fails("\nShape \"plymesh\" \"string filename\" \"no.ply\"", FAULT_NOT_FOUND,
                     WORDS("test.pbrt:3:1", "no.ply"));
    read_text_write("bad.ply", ply, sizeof ply - 6);
    read_world_fails("\nShape \"plymesh\" \"string filename\" \"bad.ply\"", FAULT_FORMAT,
                     WORDS("test.pbrt:3:1", "bad.ply", "ends in"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sides_follow_orientation_and_mirrors),
        cmocka_unit_test(normals_that_are_their_triangles_own_are_left_out),
        cmocka_unit_test(normals_decide_the_side_of_each_triangle),
        cmocka_unit_test(triangles_of_no_area_are_left_out),
        cmocka_unit_test(texture_coordinates_belong_to_vertices),
        cmocka_unit_test(spheres_and_disks_stay_exact_under_similarities),
        cmocka_unit_test(ellipsoids_and_parts_are_tessellated),
        cmocka_unit_test(bilinear_patches_are_split_or_divided),
        cmocka_unit_test(other_shapes_are_named),
        cmocka_unit_test(alpha_is_a_number_or_a_texture),
        cmocka_unit_test(polygon_files_become_shapes),
    };
    return cmocka_run_group_tests(tests, NULL, read_text_clean);
}
