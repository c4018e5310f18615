/* The language: words, numbers, transformations, scoping, files inside files, faults with their places. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "client/import/transform.h"
#include "import/read_text.h"
#include "math/vec.h"
#include "support/near.h"

/* Positions are stored in single precision: half a unit in the last place of numbers below 64, and the same again
 * for the rounding of degrees in the expected values. */
#define CLOSE 8e-6

/* Where the world's transformation takes a point: by a triangle with that corner. */
static void expect_point(const char *transforms, vec3_t p, vec3_t expected)
{
    char world[2048];
    snprintf(world, sizeof world, "%s\nShape \"trianglemesh\" \"point3 P\" [%.17g %.17g %.17g  7 1 2  3 9 4]",
             transforms, p.x, p.y, p.z);
    reading_t r = read_world(world);
    assert_int_equal(r.scene.vertex_count, 3);
    assert_near((double)r.scene.positions[0], expected.x, CLOSE);
    assert_near((double)r.scene.positions[1], expected.y, CLOSE);
    assert_near((double)r.scene.positions[2], expected.z, CLOSE);
    reading_end(&r);
}

static void transformations_act_in_order(void **state)
{
    (void)state;
    const vec3_t p = vec3(1.3, -0.7, 2.1);
    expect_point("", p, p);
    expect_point("Translate 1 2 3", p, vec3(2.3, 1.3, 5.1));
    expect_point("Scale 2 -3 0.5", p, vec3(2.6, 2.1, 1.05));
    expect_point("Translate 1 2 3 Scale 2 -3 0.5", p, vec3(3.6, 4.1, 4.05));
    expect_point("Scale 2 -3 0.5 Translate 1 2 3", p, vec3(4.6, -3.9, 2.55));
    /* 90 degrees about z: x -> y, y -> -x. */
    expect_point("Rotate 90 0 0 2.5", p, vec3(0.7, 1.3, 2.1));
    /* 120 degrees about (1,1,1) is the cycle of the axes x -> y -> z -> x. */
    expect_point("Rotate 120 1 1 1", p, vec3(2.1, 1.3, -0.7));
    expect_point("Translate 5 5 5 Identity", p, p);
    /* Columns one after the other. */
    expect_point("Transform [0 1 0 0  -1 0 0 0  0 0 1 0  4 5 6 1]", p, vec3(4.7, 6.3, 8.1));
    expect_point("Scale 2 2 2 ConcatTransform [0 1 0 0  -1 0 0 0  0 0 1 0  4 5 6 1]", p, vec3(9.4, 12.6, 16.2));
    expect_point("Transform [2 0 0 0  0 2 0 0  0 0 2 0  2 4 6 2]", p, vec3(2.3, 1.3, 5.1));
    /* From (0,0,5) towards the origin: +z of the camera is -z of the world, left-handed with y up. */
    expect_point("LookAt 0 0 5  0 0 0  0 1 0", vec3(0, 0, 0), vec3(0, 0, 5));
    expect_point("LookAt 0 0 5  0 0 0  0 1 0", vec3(1, 2, 1), vec3(-1, 2, 4));
}

static void rotation_keeps_lengths_and_its_axis(void **state)
{
    (void)state;
    const vec3_t axis = vec3(0.3, -1.2, 0.8), p = vec3(1, 2, -3);
    for (double degrees = -370; degrees < 370; degrees += 36.7) {
        const transform_t m = transform_rotate(degrees, axis);
        assert_near(vec3_length(transform_vector(&m, p)), vec3_length(p), 1e-14);
        assert_near(vec3_length(vec3_sub(transform_vector(&m, axis), axis)), 0, 1e-15);
        assert_near(transform_determinant(&m), 1, 1e-14);
        /* The angle, by the components across the axis. */
        const vec3_t a = vec3_unit(axis), across = vec3_mad(p, -vec3_dot(p, a), a);
        const vec3_t turned = vec3_mad(transform_vector(&m, p), -vec3_dot(p, a), a);
        const double angle = degrees * MATH_PI / 180;
        assert_near(vec3_dot(across, turned) / vec3_dot(across, across), cos(angle), 1e-14);
        assert_near(vec3_dot(vec3_cross(across, turned), a) / vec3_dot(across, across), sin(angle), 1e-14);
    }
}

static void inverses_undo(void **state)
{
    (void)state;
    transform_t m = transform_translate(3, -2, 0.5), inverse;
    const transform_t r = transform_rotate(33, vec3(1, 0.2, -0.4)), s = transform_scale(2, 0.01, -5);
    m = transform_mul(&m, &r);
    m = transform_mul(&m, &s);
    assert_true(transform_invert(&m, &inverse));
    const transform_t one = transform_mul(&m, &inverse);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            assert_near(one.m[i][j], i == j, 1e-13);
    const transform_t flat = transform_scale(1, 0, 1);
    assert_false(transform_invert(&flat, &inverse));
}

static void coordinate_systems_are_kept(void **state)
{
    (void)state;
    const vec3_t p = vec3(1, 2, 3);
    expect_point("Translate 1 0 0 CoordinateSystem \"here\" Scale 9 9 9 CoordSysTransform \"here\"", p,
                 vec3(2, 2, 3));
    expect_point("Translate 1 0 0 CoordSysTransform \"world\"", p, p);
    /* "camera" is what takes camera space to the world. */
    reading_t r = read_text("Translate 0 0 4 Camera \"perspective\" WorldBegin CoordSysTransform \"camera\"\n"
                            "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]");
    assert_int_equal(r.code, FAULT_NONE);
    assert_near((double)r.scene.positions[2], -4, 0);
    assert_near(r.scene.camera->to_world[11], -4, 0);
    reading_end(&r);
    r = read_world("CoordSysTransform \"nowhere\"");
    assert_true(reading_notes(&r, "nowhere"));
    reading_end(&r);
}

static void attributes_end_with_their_block(void **state)
{
    (void)state;
    const vec3_t p = vec3(1, 2, 3);
    expect_point("AttributeBegin Translate 5 5 5 AttributeEnd", p, p);
    expect_point(
        "Translate 1 0 0 AttributeBegin Translate 5 5 5 AttributeBegin Scale 3 3 3 AttributeEnd AttributeEnd", p,
        vec3(2, 2, 3));
    expect_point("TransformBegin Translate 5 5 5 TransformEnd", p, p);
    reading_t r = read_world("MakeNamedMaterial \"m\" \"string type\" \"dielectric\"\n"
                             "AttributeBegin NamedMaterial \"m\" ReverseOrientation AreaLightSource \"diffuse\"\n"
                             "Shape \"sphere\" AttributeEnd Shape \"sphere\"");
    assert_int_equal(r.scene.shape_count, 2);
    assert_int_equal(r.scene.materials[r.scene.shapes[0].material].kind, SCENE_MATERIAL_DIELECTRIC);
    assert_int_equal(r.scene.materials[r.scene.shapes[1].material].kind, SCENE_MATERIAL_DIFFUSE);
    assert_int_equal(r.scene.shapes[0].flags, SCENE_SHAPE_FLIP);
    assert_int_equal(r.scene.shapes[1].flags, 0);
    assert_int_equal(r.scene.shapes[0].area_light, 0);
    assert_int_equal(r.scene.shapes[1].area_light, SCENE_NONE);
    reading_end(&r);
}

static void attribute_defaults_count_where_nothing_is_given(void **state)
{
    (void)state;
    reading_t r =
        read_world("AttributeBegin Attribute \"shape\" \"float radius\" 3.5\nShape \"sphere\"\n"
                   "Attribute \"shape\" \"float radius\" 2.5\nShape \"sphere\"\n"
                   "Shape \"sphere\" \"float radius\" 7 AttributeEnd Shape \"sphere\"\n"
                   "Attribute \"material\" \"rgb reflectance\" [.1 .2 .3] Material \"diffuse\" Shape \"disk\"");
    const float radii[] = {3.5f, 2.5f, 7, 1};
    for (int i = 0; i < 4; i++)
        assert_near((double)r.scene.shapes[i].radius, (double)radii[i], 0);
    assert_near((double)r.scene.materials[r.scene.shapes[4].material].reflectance.value[1], 0.2, 1e-8);
    assert_int_equal(import_notes_count(r.notes), 0);
    reading_end(&r);
}

static void motion_is_left_out_and_said_once(void **state)
{
    (void)state;
    reading_t r =
        read_text("TransformTimes 0 1 Camera \"perspective\" WorldBegin AttributeBegin\n"
                  "Translate 1 0 0 ActiveTransform EndTime Translate 5 0 0 ActiveTransform All Translate 0 2 0\n"
                  "Shape \"sphere\" AttributeEnd AttributeBegin ActiveTransform StartTime Translate 0 0 3\n"
                  "ActiveTransform EndTime Translate 9 9 9 Shape \"sphere\" AttributeEnd");
    assert_int_equal(r.code, FAULT_NONE);
    assert_int_equal(import_notes_count(r.notes), 1);
    assert_near((double)r.scene.shapes[0].centre[0], 1, 0);
    assert_near((double)r.scene.shapes[0].centre[1], 2, 0);
    assert_near((double)r.scene.shapes[1].centre[2], 3, 0);
    assert_near((double)r.scene.shapes[1].centre[0], 0, 0);
    reading_end(&r);
}

static void objects_are_placed_under_each_instance(void **state)
{
    (void)state;
    reading_t r =
        read_world("MakeNamedMaterial \"g\" \"string type\" \"dielectric\"\n"
                   "Translate 10 0 0 ObjectBegin \"o\" NamedMaterial \"g\" Translate 0 1 0 Shape \"sphere\"\n"
                   "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] ObjectEnd\n"
                   "Identity Scale 2 2 2 ObjectInstance \"o\"\n"
                   "Identity Scale -1 1 1 ObjectInstance \"o\"");
    assert_int_equal(r.scene.shape_count, 4);
    /* CTM of the instance times CTM of the definition: 2 * (10, 1, 0). */
    assert_near((double)r.scene.shapes[0].centre[0], 20, 0);
    assert_near((double)r.scene.shapes[0].centre[1], 2, 0);
    assert_near((double)r.scene.shapes[0].radius, 2, 1e-6);
    assert_int_equal(r.scene.materials[r.scene.shapes[0].material].kind, SCENE_MATERIAL_DIELECTRIC);
    assert_int_equal(r.scene.shapes[1].flags & SCENE_SHAPE_FLIP, 0);
    assert_near((double)r.scene.shapes[2].centre[0], -10, 0);
    /* A mirrored mesh keeps its side. */
    assert_int_equal(r.scene.shapes[3].flags & SCENE_SHAPE_FLIP, SCENE_SHAPE_FLIP);
    reading_end(&r);
    r = read_world("ObjectBegin \"o\" AreaLightSource \"diffuse\" Shape \"sphere\" ObjectEnd ObjectInstance \"o\"");
    assert_int_equal(r.scene.light_count, 0);
    assert_true(reading_notes(&r, "area lights in objects"));
    reading_end(&r);
    read_world_fails("ObjectInstance \"nope\"", FAULT_UNKNOWN, WORDS("test.pbrt:2:1", "nope"));
    read_world_fails("ObjectBegin \"a\"\nObjectBegin \"b\"", FAULT_SYNTAX, WORDS(":3:1", "inside another"));
    read_world_fails("ObjectEnd", FAULT_SYNTAX, WORDS(":2:1"));
    read_world_fails("ObjectBegin \"a\" AttributeBegin ObjectEnd", FAULT_SYNTAX, WORDS("ObjectEnd"));
}

static void files_include_each_other(void **state)
{
    (void)state;
    static const char inner[] = "Translate 1 2 3\nShape \"sphere\"\n";
    read_text_write("inner.pbrt", inner, sizeof inner - 1);
    reading_t r = read_world("Include \"inner.pbrt\" Shape \"sphere\"");
    assert_near((double)r.scene.shapes[1].centre[1], 2, 0);
    reading_end(&r);
    /* Import leaves the graphics state alone. */
    r = read_world("Import \"inner.pbrt\" Shape \"sphere\"");
    assert_int_equal(r.scene.shape_count, 2);
    assert_near((double)r.scene.shapes[0].centre[1], 2, 0);
    assert_near((double)r.scene.shapes[1].centre[1], 0, 0);
    reading_end(&r);
    static const char wrong[] = "\n\n  Shape \"sphere\" \"float radius\" -1";
    read_text_write("wrong.pbrt", wrong, sizeof wrong - 1);
    read_world_fails("Include \"wrong.pbrt\"", FAULT_RANGE, WORDS("wrong.pbrt:3:18: parameter \"radius\"", "-1"));
    static const char open[] = "AttributeBegin";
    read_text_write("open.pbrt", open, sizeof open - 1);
    read_world_fails("\nImport \"open.pbrt\"", FAULT_SYNTAX, WORDS("test.pbrt:3:1"));
    static const char circle[] = "Include \"circle.pbrt\"";
    read_text_write("circle.pbrt", circle, sizeof circle - 1);
    read_world_fails("Include \"circle.pbrt\"", FAULT_SYNTAX, WORDS("circle.pbrt:1:1", "includes itself"));
    read_world_fails("Include \"test.pbrt\"", FAULT_SYNTAX, WORDS("includes itself"));
    read_world_fails("Include \"absent.pbrt\"", FAULT_NOT_FOUND, WORDS("test.pbrt:2:1", "absent.pbrt"));
}

static void too_many_files_inside_each_other_are_refused(void **state)
{
    (void)state;
    for (int i = 0; i < 20; i++) {
        char name[32], text[64];
        snprintf(name, sizeof name, "deep%d.pbrt", i);
        snprintf(text, sizeof text, i < 19 ? "Include \"deep%d.pbrt\"" : "# %d", i + 1);
        read_text_write(name, text, strlen(text));
    }
    /* The scene and deep5 to deep19 are sixteen files; one more is too many. */
    reading_t r = read_world("Include \"deep5.pbrt\"");
    reading_end(&r);
    read_world_fails("Include \"deep4.pbrt\"", FAULT_LIMIT, WORDS("deep18.pbrt:1:1", "16"));
}

static void compressed_scenes_are_read(void **state)
{
    (void)state;
    char path[256];
    static const char text[] = "WorldBegin Shape \"sphere\" \"float radius\" 4.25";
    snprintf(path, sizeof path, "%s/packed.pbrt.gz", read_text_folder());
    gzFile file = gzopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(gzwrite(file, text, sizeof text - 1), (int)sizeof text - 1);
    gzclose(file);
    reading_t r = {.builder = scene_builder_new(), .notes = import_notes_new()};
    assert_int_equal(pbrt_read(path, r.builder, r.notes, &r.fault), FAULT_NONE);
    r.scene = scene_builder_view(r.builder);
    assert_near((double)r.scene.shapes[0].radius, 4.25, 0);
    reading_end(&r);
}

static void words_are_found_without_white_space(void **state)
{
    (void)state;
    reading_t r =
        read_world("#x\nShape\"sphere\"\"float radius\"[2.5]Translate 1 -2e-1 +.5#y\nShape \"sphere\"# z");
    assert_near((double)r.scene.shapes[0].radius, 2.5, 0);
    assert_near((double)r.scene.shapes[1].centre[1], -0.2, 1e-8);
    assert_near((double)r.scene.shapes[1].centre[2], 0.5, 0);
    reading_end(&r);
    r = read_text("\xef\xbb\xbfWorldBegin\r\nShape \"sphere\"\r\n");
    assert_int_equal(r.code, FAULT_NONE);
    reading_end(&r);
}

static void numbers_are_read_to_the_last_bit(void **state)
{
    (void)state;
    static const char *const numbers[] = {"0.1",  "-123456.789012345", "3.14159265358979323846", "1e-3", "-0",
                                          "1e22", "6.02214076e23",     "0.000030517578125",      "7.",   ".5e+1"};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        char text[512];
        snprintf(text, sizeof text, "Camera \"perspective\" \"float screenwindow\" [%s 2e3 -1 1] WorldBegin",
                 numbers[i]);
        reading_t r = read_text(text);
        const double expected = strtod(numbers[i], NULL);
        if (fabs(expected) < 1e3) {
            assert_int_equal(r.code, FAULT_NONE);
            /* fov 90: the screen's unit is tan(45 degrees), one rounding off 1. */
            assert_near(r.scene.camera->screen[0], expected, 4e-16 * fabs(expected));
        } else {
            assert_int_equal(r.code, expected < -1e3 || expected > 1e4 ? FAULT_RANGE : FAULT_NONE);
        }
        reading_end(&r);
    }
}

static void syntax_faults_name_line_and_column(void **state)
{
    (void)state;
    read_world_fails("\n  Sphere", FAULT_SYNTAX, WORDS("test.pbrt:3:3: expected a directive, found 'Sphere'"));
    read_world_fails("Shape sphere", FAULT_SYNTAX, WORDS(":2:7", "string", "'sphere'"));
    read_world_fails("Shape \"sphere\" \"float radius\" [ 1", FAULT_SYNTAX, WORDS(":2:34", "the end of the file"));
    read_world_fails("Shape \"sphere\" \"float radius\" [ 1 2x ]", FAULT_SYNTAX, WORDS(":2:35", "'2x'"));
    read_world_fails("Shape \"sphere\" \"float radius\" \"one\"", FAULT_SYNTAX,
                     WORDS(":2:31", "the string \"one\""));
    read_world_fails("Shape \"sphere\" \"flot radius\" 1", FAULT_SYNTAX, WORDS(":2:16", "flot"));
    read_world_fails("Shape \"sphere\" \"radius\" 1", FAULT_SYNTAX, WORDS(":2:16", "type name"));
    read_world_fails("Shape \"sphere\" \"float radius more\" 1", FAULT_SYNTAX, WORDS(":2:16"));
    read_world_fails("Shape \"sphere\" \"float radius\" 1 \"float radius\" 2", FAULT_SYNTAX,
                     WORDS(":2:33", "twice"));
    read_world_fails("Shape \"sphere\" \"float radius\" []", FAULT_SYNTAX, WORDS("radius"));
    read_world_fails("Shape \"sph\nere\"", FAULT_SYNTAX, WORDS(":2:7", "not closed"));
    read_world_fails("Translate 1 2 x", FAULT_SYNTAX, WORDS(":2:15", "'x'"));
    read_world_fails("Translate 1 2 nan", FAULT_SYNTAX, WORDS("'nan'"));
    read_world_fails("Translate 1 2 inf", FAULT_SYNTAX, WORDS("'inf'"));
    read_world_fails("Translate 1 2 0x10", FAULT_SYNTAX, WORDS("'0x10'"));
    read_world_fails("Translate 1 2 1e999", FAULT_SYNTAX, WORDS("'1e999'"));
    read_world_fails("Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 2]", FAULT_SYNTAX, WORDS("']'"));
    read_world_fails("AttributeEnd", FAULT_SYNTAX, WORDS(":2:1"));
    read_world_fails("AttributeBegin", FAULT_SYNTAX, WORDS("test.pbrt", "1 AttributeBegin"));
    read_world_fails("Film \"rgb\"", FAULT_SYNTAX, WORDS("Film after WorldBegin"));
    read_world_fails("MediumInterface \"a\" \"b", FAULT_SYNTAX, WORDS(":2:21", "not closed"));
    read_world_fails("Shape \"sphere\" \"float radius", FAULT_SYNTAX, WORDS(":2:16", "not closed"));
    reading_t r = read_text("Shape \"sphere\"");
    assert_int_equal(r.code, FAULT_SYNTAX);
    assert_non_null(strstr(r.fault.text, "before WorldBegin"));
    reading_end(&r);
    r = read_text("# nothing\n");
    assert_int_equal(r.code, FAULT_SYNTAX);
    assert_non_null(strstr(r.fault.text, "without WorldBegin"));
    reading_end(&r);
}

static void wrong_types_and_counts_name_the_parameter(void **state)
{
    (void)state;
    read_world_fails("Shape \"sphere\"\n \"integer radius\" 1", FAULT_TYPE,
                     WORDS("test.pbrt:3:2: parameter \"radius\" of Shape \"sphere\"", "found the type integer",
                           "expected float"));
    read_world_fails("Shape \"sphere\" \"float radius\" [1 2]", FAULT_FORMAT, WORDS(":2:16", "found 2 values"));
    read_world_fails("Shape \"sphere\" \"integer n\" 1.5", FAULT_SYNTAX, WORDS(":2:28", "integer of 32 bits"));
    read_world_fails("Shape \"trianglemesh\" \"point3 P\" [1 2 3 4]", FAULT_SYNTAX,
                     WORDS("multiple of 3", "found 4"));
    read_world_fails("Material \"diffuse\" \"rgb reflectance\" [1 1 1 1 1 1]", FAULT_FORMAT,
                     WORDS(":2:20", "one rgb"));
    read_world_fails("Material \"diffuse\" \"rgb reflectance\" [-1 1 1]", FAULT_RANGE, WORDS(":2:20", "-1"));
    read_world_fails("Material \"diffuse\" \"texture reflectance\" \"no\"", FAULT_UNKNOWN, WORDS("\"no\""));
    read_world_fails("NamedMaterial \"no\"", FAULT_UNKNOWN, WORDS(":2:1", "\"no\""));
    read_world_fails("Scale 0 1 1 Shape \"sphere\"", FAULT_RANGE, WORDS(":2:13", "singular"));
    read_world_fails("Scale 1e200 1 1 Scale 1e200 1 1", FAULT_RANGE, WORDS(":2:17"));
    read_world_fails("Translate 1e20 0 0 Shape \"sphere\"", FAULT_RANGE, WORDS("1e+20"));
    read_world_fails("Rotate 10 0 0 0", FAULT_RANGE, WORDS(":2:1"));
    read_world_fails("LookAt 0 0 0 0 0 0 0 1 0", FAULT_RANGE, WORDS(":2:1"));
    read_world_fails("LookAt 0 0 0 0 1 0 0 1 0", FAULT_RANGE, WORDS(":2:1"));
}

static void what_is_unknown_is_said_once(void **state)
{
    (void)state;
    reading_t r = read_world("Shape \"sphere\" \"float raduis\" 3\nShape \"sphere\" \"float raduis\" 3\n"
                             "MakeNamedMedium \"m\" \"string type\" \"homogeneous\"\nMediumInterface \"m\" \"\"\n"
                             "MediumInterface \"\" WorldEnd");
    assert_int_equal(import_notes_count(r.notes), 3);
    assert_non_null(strstr(import_notes_text(r.notes, 0), "test.pbrt:2: parameter \"raduis\" of Shape \"sphere\""));
    assert_non_null(strstr(import_notes_text(r.notes, 0), "(2 times)"));
    assert_non_null(strstr(import_notes_text(r.notes, 1), "test.pbrt:4: participating media"));
    reading_end(&r);
    r = read_text(
        "Option \"bool disablepixeljitter\" true ColorSpace \"rec2020\" Sampler \"zsobol\" \"integer n\" 4\n"
        "Accelerator \"bvh\" WorldBegin");
    assert_int_equal(r.code, FAULT_NONE);
    assert_int_equal(import_notes_count(r.notes), 3); /* option, colour space, no camera */
    assert_true(reading_notes(&r, "disablepixeljitter"));
    assert_true(reading_notes(&r, "rec2020"));
    reading_end(&r);
}

static void nesting_is_limited(void **state)
{
    (void)state;
    enum { DEPTH = 1024 };
    static char world[(DEPTH + 1) * 32];
    for (int deeper = 0; deeper < 2; deeper++) {
        world[0] = 0;
        char *end = world;
        for (int i = 0; i < DEPTH + deeper; i++)
            end = stpcpy(end, "AttributeBegin ");
        for (int i = 0; i < DEPTH + deeper; i++)
            end = stpcpy(end, "AttributeEnd ");
        if (deeper) {
            read_world_fails(world, FAULT_LIMIT, WORDS("1024"));
        } else {
            reading_t r = read_world(world);
            reading_end(&r);
        }
    }
}

static void notes_are_limited(void **state)
{
    (void)state;
    import_notes_t *notes = import_notes_new();
    for (int i = 0; i < IMPORT_NOTES_MAX + 7; i++)
        import_notes_add(notes, "f", i, "note %d", i);
    assert_int_equal(import_notes_count(notes), IMPORT_NOTES_MAX);
    assert_int_equal(import_notes_dropped(notes), 7);
    import_notes_destroy(&notes);
    assert_null(notes);
    import_notes_add(NULL, "f", 1, "goes nowhere");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(transformations_act_in_order),
        cmocka_unit_test(rotation_keeps_lengths_and_its_axis),
        cmocka_unit_test(inverses_undo),
        cmocka_unit_test(coordinate_systems_are_kept),
        cmocka_unit_test(attributes_end_with_their_block),
        cmocka_unit_test(attribute_defaults_count_where_nothing_is_given),
        cmocka_unit_test(motion_is_left_out_and_said_once),
        cmocka_unit_test(objects_are_placed_under_each_instance),
        cmocka_unit_test(files_include_each_other),
        cmocka_unit_test(too_many_files_inside_each_other_are_refused),
        cmocka_unit_test(compressed_scenes_are_read),
        cmocka_unit_test(words_are_found_without_white_space),
        cmocka_unit_test(numbers_are_read_to_the_last_bit),
        cmocka_unit_test(syntax_faults_name_line_and_column),
        cmocka_unit_test(wrong_types_and_counts_name_the_parameter),
        cmocka_unit_test(what_is_unknown_is_said_once),
        cmocka_unit_test(nesting_is_limited),
        cmocka_unit_test(notes_are_limited),
    };
    return cmocka_run_group_tests(tests, NULL, read_text_clean);
}
