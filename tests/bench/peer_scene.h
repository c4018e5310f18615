/* peer_scene.h: the scenes that benches and peer tests render, at the sizes other renderers were measured at, with
 * those renderers' images and figures.
 *
 * Scenes and images are not part of the project: they are looked for in the folder that the environment variable
 * GARLAND_SHARED names (scenes/..., peers/...). The project's own scenes are in GARLAND_TESTS/scenes.
 *
 *     peer_loaded_t *loaded;
 *     TRY(peer_scene_load(&loaded, peer_scene_find("ring-box"), fault));
 *     ... loaded->scene ...
 *     peer_scene_unload(&loaded);
 *
 * Thread rule: tables are constant; a loaded scene may be read by any number of threads.
 */
#ifndef TESTS_BENCH_PEER_SCENE_H
#define TESTS_BENCH_PEER_SCENE_H

#include "client/import/notes.h"
#include "film/image.h"
#include "scene/builder.h"

enum { PEER_NOTES = 2, PEER_OWN_SIDE = 128 };

/* A range of speeds in million mutations per CPU second; 0, 0: not measured. */
typedef struct peer_speed {
    double low, high;
} peer_speed_t;

/* relMSE after so many CPU seconds of two threads; 0: not measured. */
typedef struct peer_error {
    double relmse, trimmed, cpu_seconds;
} peer_error_t;

typedef struct peer_scene {
    const char *name;
    const char *file; /* below GARLAND_SHARED/scenes; null: GARLAND_TESTS/scenes/NAME.pbrt */
    uint32_t width, height, max_path_length;
    const char *references[2]; /* PFM, below GARLAND_SHARED/peers; the second null: there is one, not two halves */
    bool spectral;             /* the reference's renderer works with wavelengths: agreement within percents only */
    const char *notes[PEER_NOTES]; /* what the reader is known to say about the scene, parts of its notes */
    peer_speed_t mmlt_speed, rjmlt_speed, pbrt_mlt_speed; /* Tungsten's two, pbrt-v4's */
    peer_error_t bdpt, mmlt, rjmlt;                       /* Tungsten's */
    peer_error_t pbrt_bdpt, pbrt_mlt;                     /* without the reference's noise; trimmed is not known */
    double reference_noise; /* relMSE of a single reference, to be taken off; 0 where there are two */
} peer_scene_t;

typedef struct peer_loaded {
    const peer_scene_t *entry;
    scene_builder_t *builder;
    import_notes_t *notes;
    scene_t scene; /* view of the builder, checked */
} peer_loaded_t;

/* The table: shared scenes, then the project's own. */
const peer_scene_t *peer_scene_at(size_t index); /* null past the end */
const peer_scene_t *peer_scene_find(const char *name);
/* Null if the environment does not name a folder that is there. */
const char *peer_shared_folder(void);
/* Whether the scene's file is there. */
bool peer_scene_present(const peer_scene_t *entry);

fault_code_t peer_scene_load(peer_loaded_t **out, const peer_scene_t *entry, fault_t *fault);
void peer_scene_unload(peer_loaded_t **loaded);
/* Whether note `index` is one that the table explains. */
bool peer_note_explained(const peer_loaded_t *loaded, size_t index);

/* Reads reference 0 or 1; the caller clears. FAULT_NOT_FOUND if the table has none. */
fault_code_t peer_reference_read(image_t *image, const peer_scene_t *entry, int index, fault_t *fault);

#endif
