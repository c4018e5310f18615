#include "client/scene_source.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "client/import/notes.h"
#include "client/import/pbrt.h"
#include "scene/builder.h"
#include "scene/bundle.h"

static void count(const scene_t *scene, scene_counts_t *counts)
{
    if (counts)
        *counts = (scene_counts_t){.triangles = scene->triangle_count,
                                   .vertices = scene->vertex_count,
                                   .texel_bytes = scene->texel_bytes,
                                   .shapes = scene->shape_count,
                                   .materials = scene->material_count,
                                   .textures = scene->texture_count,
                                   .images = scene->image_count,
                                   .lights = scene->light_count};
}

static void print_notes(const import_notes_t *notes, FILE *out)
{
    if (!out)
        return;
    for (size_t i = 0; i < import_notes_count(notes); i++)
        fprintf(out, "note: %s\n", import_notes_text(notes, i));
    if (import_notes_dropped(notes) > 0)
        fprintf(out, "note: and %zu more\n", import_notes_dropped(notes));
}

fault_code_t scene_source_pack(const char *scene, const char *bundle, FILE *notes, digest_t *digest,
                               scene_counts_t *counts, fault_t *fault)
{
    scene_builder_t *builder = scene_builder_new();
    import_notes_t *list = import_notes_new();
    fault_code_t code = FAULT_NONE;
    if (!builder || !list)
        code = fault_set(fault, FAULT_MEMORY, "%s: no memory for a scene", scene);
    if (code == FAULT_NONE)
        code = pbrt_read(scene, builder, list, fault);
    if (list)
        print_notes(list, notes);
    if (code == FAULT_NONE) {
        const scene_t view = scene_builder_view(builder);
        count(&view, counts);
        code = bundle_save(&view, bundle, digest, fault);
    }
    import_notes_destroy(&list);
    scene_builder_destroy(&builder);
    return code;
}

/* A hard link where that is possible, else a copy. */
static fault_code_t place_bundle(const char *scene, const char *target, const bundle_t *bundle, fault_t *fault)
{
    if (strcmp(scene, target) == 0 || link(scene, target) == 0)
        return FAULT_NONE;
    size_t size;
    const uint8_t *data = bundle_bytes(bundle, &size);
    return file_write(target, data, size, fault);
}

fault_code_t scene_source_bundle(const char *scene, const char *target, FILE *notes, digest_t *digest,
                                 scene_counts_t *counts, fault_t *fault)
{
    if (!file_exists(scene))
        return fault_set(fault, FAULT_NOT_FOUND, "the scene %s does not exist", scene);
    if (!bundle_probe(scene))
        return scene_source_pack(scene, target, notes, digest, counts, fault);
    bundle_t *bundle;
    TRY(bundle_open(&bundle, scene, fault));
    *digest = *bundle_digest(bundle);
    count(bundle_scene(bundle), counts);
    const fault_code_t code = place_bundle(scene, target, bundle, fault);
    bundle_destroy(&bundle);
    return code;
}
