/* The public scenes under GARLAND_SHARED: all are read, and hold what their files say. Skipped where they are
 * absent. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <ctype.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "client/import/pbrt.h"
#include "import/read_text.h"

enum { PATH_SIZE = 1024, LARGEST_SCENE = 64 << 20 };

static const char *const scenes[] = {"coffee",     "cornell-box", "ring-box",  "staircase2", "two-rooms",
                                     "veach-ajar", "veach-bidir", "veach-mis", "water-box",  "water-caustic"};

/* What a scene may say in a note, and nothing else: each is explained in docs/scenes.md. */
static const char *const explained[] = {"triangles of no area are left out",
                                        "participating media are not supported and are ignored",
                                        "vertex normals have no length"};

/* GARLAND_SHARED, or the test ends here. */
static const char *shared(void)
{
    const char *folder = getenv("GARLAND_SHARED");
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/scenes/cornell-box/scene-v4.pbrt", folder ? folder : "");
    if (!folder || !file_exists(path)) {
        print_message("no scenes at GARLAND_SHARED: skipped\n");
        skip();
    }
    return folder;
}

static void expect_explained(const import_notes_t *notes)
{
    for (size_t i = 0; i < import_notes_count(notes); i++) {
        int known = 0;
        for (size_t j = 0; j < sizeof explained / sizeof *explained; j++)
            known |= strstr(import_notes_text(notes, i), explained[j]) != NULL;
        if (!known)
            fail_msg("not explained: %s", import_notes_text(notes, i));
    }
    assert_int_equal(import_notes_dropped(notes), 0);
}

/* ---- a second way of counting: by searching the text ---- */

static size_t occurrences(const char *text, const char *word)
{
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, word)); at += strlen(word))
        count++;
    return count;
}

/* Integers in the brackets after each "integer indices". */
static size_t indices_in_text(const char *text)
{
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, "\"integer indices\""));) {
        at = strchr(at, '[') + 1;
        for (; *at != ']'; at++)
            count += isdigit((unsigned char)*at) && !isdigit((unsigned char)at[1]);
    }
    return count;
}

/* The number after `word` in the header of a polygon file. */
static size_t header_count(const char *path, const char *word)
{
    char header[2048];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(header, 1, sizeof header - 1, file);
    fclose(file);
    header[size] = 0;
    const char *at = strstr(header, word);
    assert_non_null(at);
    return strtoul(at + strlen(word), NULL, 10);
}

/* folder/name, of which only `length` characters count. */
static void join(char path[PATH_SIZE], const char *folder, const char *name, size_t length)
{
    assert_in_range(snprintf(path, PATH_SIZE, "%s/%.*s", folder, (int)length, name), 1, PATH_SIZE - 1);
}

/* Faces of all the polygon files that the text names: these scenes' are triangles. */
static size_t faces_in_files(const char *folder, const char *text)
{
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, ".ply\""));) {
        const char *begin = at;
        char path[PATH_SIZE];
        while (begin[-1] != '"')
            begin--;
        at += 4;
        join(path, folder, begin, (size_t)(at - begin));
        count += header_count(path, "element face ");
    }
    return count;
}

static size_t left_out(const import_notes_t *notes)
{
    for (size_t i = 0; i < import_notes_count(notes); i++) {
        const char *at = strstr(import_notes_text(notes, i), " triangles of no area");
        if (!at)
            continue;
        while (isdigit((unsigned char)at[-1]))
            at--;
        return strtoul(at, NULL, 10);
    }
    return 0;
}

static void every_scene_holds_what_its_file_says(void **state)
{
    (void)state;
    const char *root = shared();
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        char folder[PATH_SIZE], path[PATH_SIZE + 32];
        fault_t fault = {0};
        uint8_t *data;
        size_t size;
        snprintf(folder, sizeof folder, "%s/scenes/%s", root, scenes[i]);
        snprintf(path, sizeof path, "%s/scene-v4.pbrt", folder);
        scene_builder_t *builder = scene_builder_new();
        import_notes_t *notes = import_notes_new();
        if (pbrt_read(path, builder, notes, &fault))
            fail_msg("%s", fault.text);
        const scene_t scene = scene_builder_view(builder);
        assert_int_equal(scene_check(&scene, &fault), FAULT_NONE);
        expect_explained(notes);
        assert_int_equal(file_read(path, LARGEST_SCENE, &data, &size, &fault), FAULT_NONE);
        const char *text = (const char *)data;
        assert_int_equal(scene.shape_count, occurrences(text, "Shape \""));
        assert_int_equal(scene.light_count,
                         occurrences(text, "AreaLightSource") + occurrences(text, "\nLightSource"));
        assert_int_equal(scene.texture_count, occurrences(text, "\nTexture \""));
        assert_int_equal(scene.material_count,
                         occurrences(text, "MakeNamedMaterial") + occurrences(text, "   Material \""));
        assert_int_equal(scene.triangle_count + left_out(notes),
                         indices_in_text(text) / 3 + faces_in_files(folder, text));
        assert_int_equal(scene.camera->max_path_length,
                         strtoul(strchr(strstr(text, "\"integer maxdepth\""), '[') + 1, NULL, 10) + 1);
        free(data);
        import_notes_destroy(&notes);
        scene_builder_destroy(&builder);
    }
}

/* The corner of a mesh's triangle in the world. */
static double side_of_first_light(const scene_t *scene)
{
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const scene_shape_t *s = &scene->shapes[i];
        if (s->area_light < 0 || s->kind != SCENE_SHAPE_MESH)
            continue;
        const uint32_t *t = scene->indices + 3 * (uint64_t)s->first_triangle;
        const float *p[3];
        for (int j = 0; j < 3; j++)
            p[j] = scene->positions + 3 * (uint64_t)(s->first_vertex + t[j]);
        const double ax = (double)(p[1][0] - p[0][0]), az = (double)(p[1][2] - p[0][2]);
        const double bx = (double)(p[2][0] - p[0][0]), bz = (double)(p[2][2] - p[0][2]);
        const double y = az * bx - ax * bz; /* of the cross product */
        return s->flags & SCENE_SHAPE_FLIP ? -y : y;
    }
    return 0;
}

/* The light under the ceiling of the boxes shines down. */
static void ceiling_lights_face_the_floor(void **state)
{
    (void)state;
    const char *root = shared();
    static const char *const boxes[] = {"cornell-box", "ring-box", "water-box", "water-caustic"};
    for (size_t i = 0; i < sizeof boxes / sizeof *boxes; i++) {
        char path[PATH_SIZE];
        fault_t fault = {0};
        snprintf(path, sizeof path, "%s/scenes/%s/scene-v4.pbrt", root, boxes[i]);
        scene_builder_t *builder = scene_builder_new();
        assert_int_equal(pbrt_read(path, builder, NULL, &fault), FAULT_NONE);
        const scene_t scene = scene_builder_view(builder);
        if (!(side_of_first_light(&scene) < 0))
            fail_msg("%s: the light faces up (%g)", boxes[i], side_of_first_light(&scene));
        scene_builder_destroy(&builder);
    }
}

static void link_into(const char *folder, const char *from, const char *name)
{
    char source[PATH_SIZE], target[PATH_SIZE];
    join(source, from, name, strlen(name));
    join(target, folder, name, strlen(name));
    unlink(target);
    if (file_exists(source) || strchr(name, '.') == NULL)
        (void)!symlink(source, target);
}

/* The peers' scene files, beside the models and textures of the scenes they come from. */
static void the_peers_scenes_are_read(void **state)
{
    (void)state;
    const char *root = shared();
    int count = 0;
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        char peers[PATH_SIZE], own[PATH_SIZE];
        snprintf(peers, sizeof peers, "%s/peers/pbrt/scenes/%s", root, scenes[i]);
        snprintf(own, sizeof own, "%s/scenes/%s", root, scenes[i]);
        DIR *folder = opendir(peers);
        if (!folder)
            continue;
        link_into(read_text_folder(), own, "models");
        link_into(read_text_folder(), own, "textures");
        link_into(read_text_folder(), peers, "world.pbrt");
        for (struct dirent *entry; (entry = readdir(folder));) {
            char path[PATH_SIZE];
            fault_t fault = {0};
            if (!strstr(entry->d_name, ".pbrt") || strcmp(entry->d_name, "world.pbrt") == 0 ||
                (count++, strncmp(entry->d_name, "bdpt", 4) != 0 && strncmp(entry->d_name, "mlt", 3) != 0))
                continue; /* the others differ in their integrator only */
            link_into(read_text_folder(), peers, entry->d_name);
            join(path, read_text_folder(), entry->d_name, strlen(entry->d_name));
            scene_builder_t *builder = scene_builder_new();
            import_notes_t *notes = import_notes_new();
            if (pbrt_read(path, builder, notes, &fault))
                fail_msg("%s/%s: %s", scenes[i], entry->d_name, fault.text);
            expect_explained(notes);
            import_notes_destroy(&notes);
            scene_builder_destroy(&builder);
        }
        closedir(folder);
    }
    if (count == 0)
        skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_scene_holds_what_its_file_says),
        cmocka_unit_test(ceiling_lights_face_the_floor),
        cmocka_unit_test(the_peers_scenes_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, read_text_clean);
}
