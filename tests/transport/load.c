#include "load.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <setjmp.h>
#include <cmocka.h>

#include "client/import/pbrt.h"
#include "scene/builder.h"

static scene_builder_t *builder;
static scene_t scene;

void load_clear(void)
{
    scene_builder_destroy(&builder);
}

const scene_t *load_scene(const char *name)
{
    char path[4096];
    const char *folder = getenv("GARLAND_TESTS");
    snprintf(path, sizeof path, "%s/scenes/%s.pbrt", folder ? folder : "tests", name);
    load_clear();
    builder = scene_builder_new();
    fault_t fault = {0};
    import_notes_t *notes = import_notes_new();
    if (pbrt_read(path, builder, notes, &fault))
        fail_msg("%s", fault.text);
    import_notes_destroy(&notes);
    scene = scene_builder_view(builder);
    if (scene_check(&scene, &fault))
        fail_msg("%s: %s", name, fault.text);
    return &scene;
}
