#include "peer_scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "client/import/pbrt.h"
#include "film/pfm.h"

enum { PATH_ROOM = 4096 };

/* Speeds and errors: two public renderers built from source and run on two cores with AVX2 at a calibration of
 * 3.0 Mray per CPU second (calibrate.h); docs/benchmarks.md says more. Tungsten's errors are medians over two or
 * three seeds. Path lengths: 12 bounces in Tungsten are 12 segments here, a maxdepth of 12 in pbrt-v4 is 13. */
static const peer_scene_t scenes[] = {
    {.name = "cornell-320",
     .file = "cornell-box/scene-320.pbrt",
     .width = 320,
     .height = 320,
     .max_path_length = 12,
     .references = {"tungsten/refs/cornell.refA.pfm", "tungsten/refs/cornell.refB.pfm"},
     .mmlt_speed = {0.90, 0.90},
     .rjmlt_speed = {0.97, 0.97},
     .bdpt = {0.0141, 0.0137, 30.5},
     .mmlt = {0.0182, 0.0169, 29.0},
     .rjmlt = {0.0191, 0.0180, 28.6}},
    {.name = "ring-box",
     .file = "ring-box/scene-v4.pbrt",
     .width = 320,
     .height = 320,
     .max_path_length = 12,
     .references = {"tungsten/refs/ring.refA.pfm", "tungsten/refs/ring.refB.pfm"},
     .mmlt_speed = {0.79, 0.79},
     .rjmlt_speed = {0.82, 0.82},
     .bdpt = {0.105, 0.0194, 31.3},
     .mmlt = {0.069, 0.034, 28.8},
     .rjmlt = {0.0416, 0.0347, 29.4}},
    {.name = "two-rooms",
     .file = "two-rooms/scene-v4.pbrt",
     .width = 400,
     .height = 225,
     .max_path_length = 12,
     .references = {"tungsten/refs/door.refA.pfm", "tungsten/refs/door.refB.pfm"},
     .mmlt_speed = {0.45, 0.45},
     .rjmlt_speed = {0.48, 0.48},
     .bdpt = {0.623, 0.578, 30.8},
     .mmlt = {0.343, 0.237, 29.7},
     .rjmlt = {0.290, 0.221, 29.2}},
    {.name = "water-box",
     .file = "water-box/scene-v4.pbrt",
     .width = 320,
     .height = 320,
     .max_path_length = 12,
     .references = {"tungsten/refs/water.refA.pfm", "tungsten/refs/water.refB.pfm"},
     .mmlt_speed = {0.57, 0.57},
     .rjmlt_speed = {0.49, 0.49},
     .bdpt = {85, 28, 35.0},
     .mmlt = {23, 4.0, 29.8},
     .rjmlt = {67, 6.5, 29.2}},
    {.name = "cornell-box",
     .file = "cornell-box/scene-v4.pbrt",
     .width = 128,
     .height = 128,
     .max_path_length = 13,
     .references = {"pbrt/refs/cornell-box.pfm"},
     .spectral = true,
     .pbrt_mlt_speed = {0.27, 0.32}},
    {.name = "veach-bidir",
     .file = "veach-bidir/scene-v4.pbrt",
     .width = 128,
     .height = 128,
     .max_path_length = 13,
     .references = {"pbrt/refs/veach-bidir.pfm"},
     .spectral = true,
     .pbrt_mlt_speed = {0.11, 0.12},
     .pbrt_bdpt = {0.0205, 0, 55.0},
     .pbrt_mlt = {0.0433, 0, 61.2},
     .reference_noise = 0.00673},
    {.name = "veach-mis",
     .file = "veach-mis/scene-v4.pbrt",
     .width = 192,
     .height = 108,
     .max_path_length = 13,
     .references = {"pbrt/refs/veach-mis.pfm"},
     .spectral = true,
     .pbrt_mlt_speed = {0.25, 0.25},
     .pbrt_bdpt = {0.0038, 0, 64.6},
     .pbrt_mlt = {0.0285, 0, 60.9},
     .reference_noise = 0.00139},
    {.name = "water-caustic",
     .file = "water-caustic/scene-v4.pbrt",
     .width = 128,
     .height = 128,
     .max_path_length = 13,
     .references = {"pbrt/refs/water-caustic.pfm"},
     .spectral = true,
     .pbrt_mlt_speed = {0.07, 0.10}},
    {.name = "veach-ajar",
     .file = "veach-ajar/scene-v4.pbrt",
     .width = 192,
     .height = 108,
     .max_path_length = 13,
     .references = {"pbrt/refs/veach-ajar.pfm"},
     .spectral = true,
     .notes = {"triangles of no area are left out"},
     .pbrt_mlt_speed = {0.09, 0.10},
     .pbrt_bdpt = {0.5545, 0, 52.4},
     .pbrt_mlt = {0.2158, 0, 47.1},
     .reference_noise = 0.0345},
    {.name = "coffee",
     .file = "coffee/scene-v4.pbrt",
     .width = 160,
     .height = 200,
     .max_path_length = 13,
     .references = {"pbrt/refs/coffee.pfm"},
     .spectral = true,
     .notes = {"triangles of no area are left out"}},
    {.name = "staircase2",
     .file = "staircase2/scene-v4.pbrt",
     .width = 192,
     .height = 192,
     .max_path_length = 13,
     .references = {"pbrt/refs/staircase2.pfm"},
     .spectral = true,
     .notes = {"triangles of no area are left out", "participating media are not supported and are ignored"}},
    {.name = "diffuse", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 6},
    {.name = "glossy", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 6},
    {.name = "glass", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 6},
    {.name = "environment", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 6},
    {.name = "delta-lights", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 6},
    {.name = "lens", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 6},
    {.name = "transmission", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 6},
    {.name = "normals", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 6},
    {.name = "tiny-light", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 6},
    {.name = "sky", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 6},
    {.name = "courtyard", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 8},
    {.name = "caustics", .width = PEER_OWN_SIDE, .height = 3 * PEER_OWN_SIDE / 4, .max_path_length = 10},
    {.name = "furnace", .width = PEER_OWN_SIDE, .height = PEER_OWN_SIDE, .max_path_length = 12},
};

const peer_scene_t *peer_scene_at(size_t index)
{
    return index < sizeof scenes / sizeof *scenes ? &scenes[index] : NULL;
}

const peer_scene_t *peer_scene_find(const char *name)
{
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
        if (strcmp(scenes[i].name, name) == 0)
            return &scenes[i];
    return NULL;
}

const char *peer_shared_folder(void)
{
    const char *folder = getenv("GARLAND_SHARED");
    return folder && access(folder, R_OK) == 0 ? folder : NULL;
}

/* The scene's file; empty if its folder is not known. */
static void scene_path(char path[PATH_ROOM], const peer_scene_t *entry)
{
    const char *tests = getenv("GARLAND_TESTS"), *shared = peer_shared_folder();
    path[0] = '\0';
    if (!entry->file)
        snprintf(path, PATH_ROOM, "%s/scenes/%s.pbrt", tests ? tests : "tests", entry->name);
    else if (shared)
        snprintf(path, PATH_ROOM, "%s/scenes/%s", shared, entry->file);
}

bool peer_scene_present(const peer_scene_t *entry)
{
    char path[PATH_ROOM];
    scene_path(path, entry);
    return access(path, R_OK) == 0;
}

fault_code_t peer_scene_load(peer_loaded_t **out, const peer_scene_t *entry, fault_t *fault)
{
    char path[PATH_ROOM];
    scene_path(path, entry);
    *out = NULL;
    peer_loaded_t *loaded = calloc(1, sizeof *loaded);
    if (!loaded)
        return fault_set(fault, FAULT_MEMORY, "no memory for a scene");
    loaded->entry = entry;
    loaded->builder = scene_builder_new();
    loaded->notes = import_notes_new();
    fault_code_t code = FAULT_NONE;
    if (!loaded->builder || !loaded->notes)
        code = fault_set(fault, FAULT_MEMORY, "no memory for a scene");
    else
        code = pbrt_read(path, loaded->builder, loaded->notes, fault);
    if (!code) {
        loaded->scene = scene_builder_view(loaded->builder);
        code = scene_check(&loaded->scene, fault);
    }
    if (code)
        peer_scene_unload(&loaded);
    *out = loaded;
    return code;
}

void peer_scene_unload(peer_loaded_t **loaded)
{
    if (!*loaded)
        return;
    import_notes_destroy(&(*loaded)->notes);
    scene_builder_destroy(&(*loaded)->builder);
    free(*loaded);
    *loaded = NULL;
}

bool peer_note_explained(const peer_loaded_t *loaded, size_t index)
{
    const char *text = import_notes_text(loaded->notes, index);
    for (int i = 0; i < PEER_NOTES; i++)
        if (loaded->entry->notes[i] && strstr(text, loaded->entry->notes[i]))
            return true;
    return false;
}

fault_code_t peer_reference_read(image_t *image, const peer_scene_t *entry, int index, fault_t *fault)
{
    char path[PATH_ROOM];
    const char *shared = peer_shared_folder();
    *image = (image_t){0};
    if (!entry->references[index] || !shared)
        return fault_set(fault, FAULT_NOT_FOUND, "%s: no reference %d", entry->name, index + 1);
    snprintf(path, sizeof path, "%s/peers/%s", shared, entry->references[index]);
    return pfm_read(image, path, fault);
}
