/* Any text as a scene: it is refused with a place, or read into a scene that passes all checks. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/import/pbrt.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    scene_builder_t *builder = scene_builder_new();
    import_notes_t *notes = import_notes_new();
    fault_t fault = {0};
    if (!builder || !notes)
        abort();
    /* No file is found: those the text names are looked for in a folder that there is not. */
    const fault_code_t code =
        pbrt_read_text("fuzz.pbrt", "/nowhere", (const char *)data, size, builder, notes, &fault);
    if (code) {
        if (code != fault.code || strncmp(fault.text, "fuzz.pbrt:", 10) != 0) {
            fprintf(stderr, "a fault without its place: %s\n", fault.text);
            abort();
        }
    } else {
        const scene_t scene = scene_builder_view(builder);
        if (scene_check(&scene, &fault)) {
            fprintf(stderr, "read, but: %s\n", fault.text);
            abort();
        }
    }
    import_notes_destroy(&notes);
    scene_builder_destroy(&builder);
    return 0;
}
