#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "import/read_text.h"

static char folder[64];

const char *read_text_folder(void)
{
    if (!folder[0]) {
        snprintf(folder, sizeof folder, "/tmp/garland-import-XXXXXX");
        assert_non_null(mkdtemp(folder));
    }
    return folder;
}

int read_text_clean(void **state)
{
    (void)state;
    char command[128];
    if (folder[0]) {
        snprintf(command, sizeof command, "rm -r '%s'", folder);
        assert_int_equal(system(command), 0);
    }
    folder[0] = 0;
    return 0;
}

void read_text_write(const char *name, const void *data, size_t size)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", read_text_folder(), name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

reading_t read_text(const char *text)
{
    char path[256];
    reading_t r = {.builder = scene_builder_new(), .notes = import_notes_new()};
    assert_non_null(r.builder);
    assert_non_null(r.notes);
    read_text_write("test.pbrt", text, strlen(text));
    snprintf(path, sizeof path, "%s/test.pbrt", read_text_folder());
    r.code = pbrt_read(path, r.builder, r.notes, &r.fault);
    r.scene = scene_builder_view(r.builder);
    return r;
}

static char *with_camera(const char *world)
{
    static const char head[] = "Film \"rgb\" \"integer xresolution\" 64 \"integer yresolution\" 32 "
                               "Camera \"perspective\" WorldBegin\n";
    char *text = malloc(sizeof head + strlen(world));
    assert_non_null(text);
    strcpy(text, head);
    return strcat(text, world);
}

reading_t read_world(const char *world)
{
    char *text = with_camera(world);
    reading_t r = read_text(text);
    free(text);
    if (r.code)
        fail_msg("%s", r.fault.text);
    return r;
}

void read_world_fails(const char *world, fault_code_t code, const char *const *words)
{
    char *text = with_camera(world);
    reading_t r = read_text(text);
    free(text);
    if (r.code != code)
        fail_msg("code %d (%s), expected %d for: %s", (int)r.code, r.fault.text, (int)code, world);
    for (; *words; words++)
        if (!strstr(r.fault.text, *words))
            fail_msg("the fault \"%s\" does not say \"%s\"", r.fault.text, *words);
    reading_end(&r);
}

void reading_end(reading_t *reading)
{
    scene_builder_destroy(&reading->builder);
    import_notes_destroy(&reading->notes);
}

int reading_notes(const reading_t *reading, const char *text)
{
    for (size_t i = 0; i < import_notes_count(reading->notes); i++)
        if (strstr(import_notes_text(reading->notes, i), text))
            return 1;
    return 0;
}
