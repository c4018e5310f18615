#include "scene/bundle.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "bundles hold records as they are in memory");

/* The first byte is not ASCII, the line ends and the end-of-file character show a file that was mangled as text. */
static const uint8_t magic[8] = {0x89, 'G', 'L', 'N', 'D', '\r', '\n', 0x1a};

enum { ALIGNMENT = 64, RECORD_HEADER = 64, RECORD_ENTRY = 32 };

typedef struct header {
    uint8_t magic[8];
    uint32_t version;  /* BUNDLE_VERSION */
    uint32_t sections; /* SECTION_COUNT */
    uint64_t size;     /* of the file, digest included */
    uint8_t reserved[40];
} header_t;

typedef struct entry {
    uint32_t id;     /* section_id_t */
    uint32_t record; /* bytes of one record */
    uint64_t offset; /* from the file's start */
    uint64_t count;  /* of records */
    uint64_t reserved;
} entry_t;

static_assert(sizeof(header_t) == RECORD_HEADER, "layout of the header");
static_assert(sizeof(entry_t) == RECORD_ENTRY, "layout of the table");
static_assert(sizeof(scene_param_t) == 16, "layout of parameters");
static_assert(sizeof(scene_shape_t) == 96, "layout of shapes");
static_assert(sizeof(scene_material_t) == 156, "layout of materials");
static_assert(sizeof(scene_texture_t) == 96, "layout of textures");
static_assert(sizeof(scene_image_t) == 24, "layout of images");
static_assert(sizeof(scene_light_t) == 104, "layout of lights");
static_assert(sizeof(scene_camera_t) == 208, "layout of the camera");

/* In file order; section i has the id i + 1. */
typedef enum section_id {
    SECTION_POSITIONS,
    SECTION_NORMALS,
    SECTION_UVS,
    SECTION_INDICES,
    SECTION_SHAPES,
    SECTION_MATERIALS,
    SECTION_TEXTURES,
    SECTION_IMAGES,
    SECTION_TEXELS,
    SECTION_LIGHTS,
    SECTION_CAMERA,
    SECTION_COUNT
} section_id_t;

/* Names, sizes and limits of the sections. */
static const struct section_rule {
    const char *name;
    uint32_t record;
    uint64_t most;
} rules[SECTION_COUNT] = {
    [SECTION_POSITIONS] = {"positions", 3 * sizeof(float), SCENE_MAX_VERTICES},
    [SECTION_NORMALS] = {"normals", 3 * sizeof(float), SCENE_MAX_VERTICES},
    [SECTION_UVS] = {"texture coordinates", 2 * sizeof(float), SCENE_MAX_VERTICES},
    [SECTION_INDICES] = {"indices", 3 * sizeof(uint32_t), SCENE_MAX_TRIANGLES},
    [SECTION_SHAPES] = {"shapes", sizeof(scene_shape_t), SCENE_MAX_SHAPES},
    [SECTION_MATERIALS] = {"materials", sizeof(scene_material_t), SCENE_MAX_MATERIALS},
    [SECTION_TEXTURES] = {"textures", sizeof(scene_texture_t), SCENE_MAX_TEXTURES},
    [SECTION_IMAGES] = {"images", sizeof(scene_image_t), SCENE_MAX_IMAGES},
    [SECTION_TEXELS] = {"texels", 1, SCENE_MAX_TEXEL_BYTES},
    [SECTION_LIGHTS] = {"lights", sizeof(scene_light_t), SCENE_MAX_LIGHTS},
    [SECTION_CAMERA] = {"camera", sizeof(scene_camera_t), 1},
};

enum { TABLE_END = RECORD_HEADER + SECTION_COUNT * RECORD_ENTRY };

struct bundle {
    const uint8_t *bytes;
    size_t size;
    bool mapped;
    scene_t scene;
    digest_t digest;
};

static uint64_t align_up(uint64_t offset)
{
    return (offset + (ALIGNMENT - 1)) & ~(uint64_t)(ALIGNMENT - 1);
}

/* ---- writing ---- */

typedef struct section {
    const void *data;
    uint64_t count;
} section_t;

static void sections_of(const scene_t *s, section_t sections[SECTION_COUNT])
{
    sections[SECTION_POSITIONS] = (section_t){s->positions, s->vertex_count};
    sections[SECTION_NORMALS] = (section_t){s->normals, s->normals ? s->vertex_count : 0};
    sections[SECTION_UVS] = (section_t){s->uvs, s->uvs ? s->vertex_count : 0};
    sections[SECTION_INDICES] = (section_t){s->indices, s->triangle_count};
    sections[SECTION_SHAPES] = (section_t){s->shapes, s->shape_count};
    sections[SECTION_MATERIALS] = (section_t){s->materials, s->material_count};
    sections[SECTION_TEXTURES] = (section_t){s->textures, s->texture_count};
    sections[SECTION_IMAGES] = (section_t){s->images, s->image_count};
    sections[SECTION_TEXELS] = (section_t){s->texels, s->texel_bytes};
    sections[SECTION_LIGHTS] = (section_t){s->lights, s->light_count};
    sections[SECTION_CAMERA] = (section_t){s->camera, s->camera ? 1 : 0};
}

fault_code_t bundle_encode(const scene_t *scene, uint8_t **data, size_t *size, digest_t *digest, fault_t *fault)
{
    section_t sections[SECTION_COUNT];
    entry_t table[SECTION_COUNT];
    sections_of(scene, sections);
    uint64_t end = TABLE_END;
    for (int i = 0; i < SECTION_COUNT; i++) {
        if (sections[i].count > rules[i].most)
            return fault_set(fault, FAULT_LIMIT, "the scene has %llu records of %s, more than the %llu allowed",
                             (unsigned long long)sections[i].count, rules[i].name,
                             (unsigned long long)rules[i].most);
        table[i] = (entry_t){(uint32_t)i + 1, rules[i].record, align_up(end), sections[i].count, 0};
        end = table[i].offset + table[i].count * table[i].record;
    }
    header_t header = {.version = BUNDLE_VERSION, .sections = SECTION_COUNT, .size = end + DIGEST_SIZE};
    memcpy(header.magic, magic, sizeof magic);
    uint8_t *bytes = calloc(header.size, 1);
    if (!bytes)
        return fault_set(fault, FAULT_MEMORY, "no memory for a bundle of %llu bytes",
                         (unsigned long long)header.size);
    memcpy(bytes, &header, sizeof header);
    memcpy(bytes + sizeof header, table, sizeof table);
    for (int i = 0; i < SECTION_COUNT; i++)
        if (table[i].count > 0)
            memcpy(bytes + table[i].offset, sections[i].data, table[i].count * table[i].record);
    digest_of(digest, bytes, end);
    memcpy(bytes + end, digest->bytes, DIGEST_SIZE);
    *data = bytes;
    *size = header.size;
    return FAULT_NONE;
}

fault_code_t bundle_save(const scene_t *scene, const char *path, digest_t *digest, fault_t *fault)
{
    uint8_t *data;
    size_t size;
    TRY(scene_check(scene, fault));
    TRY(bundle_encode(scene, &data, &size, digest, fault));
    const fault_code_t code = file_write(path, data, size, fault);
    free(data);
    return code;
}

/* ---- reading ---- */

static fault_code_t check_header(const uint8_t *bytes, size_t size, fault_t *fault)
{
    header_t header;
    static const uint8_t zeros[sizeof header.reserved];
    if (size < sizeof magic || memcmp(bytes, magic, sizeof magic) != 0)
        return fault_set(fault, FAULT_FORMAT, "not a bundle: it does not begin with a bundle's magic number");
    if (size < TABLE_END + DIGEST_SIZE)
        return fault_set(fault, FAULT_FORMAT, "the bundle is cut short: %zu bytes, expected at least %d", size,
                         TABLE_END + DIGEST_SIZE);
    memcpy(&header, bytes, sizeof header);
    if (header.version != BUNDLE_VERSION)
        return fault_set(fault, FAULT_VERSION, "the bundle has format version %u, expected %d", header.version,
                         BUNDLE_VERSION);
    if (header.size != size)
        return fault_set(fault, FAULT_FORMAT,
                         "the bundle is cut short or overlong: %zu bytes, its header says %llu", size,
                         (unsigned long long)header.size);
    if (header.sections != SECTION_COUNT)
        return fault_set(fault, FAULT_FORMAT, "the bundle has %u sections, expected %d", header.sections,
                         SECTION_COUNT);
    if (memcmp(header.reserved, zeros, sizeof zeros) != 0)
        return fault_set(fault, FAULT_FORMAT, "reserved bytes of the bundle's header are not zero");
    return FAULT_NONE;
}

static fault_code_t check_digest(const uint8_t *bytes, size_t size, digest_t *digest, fault_t *fault)
{
    digest_t found;
    char found_text[DIGEST_TEXT_SIZE], text[DIGEST_TEXT_SIZE];
    memcpy(digest->bytes, bytes + size - DIGEST_SIZE, DIGEST_SIZE);
    digest_of(&found, bytes, size - DIGEST_SIZE);
    if (digest_equal(&found, digest))
        return FAULT_NONE;
    digest_print(&found, found_text);
    digest_print(digest, text);
    return fault_set(fault, FAULT_FORMAT, "the bundle is damaged: its bytes have the hash %s, it says %s",
                     found_text, text);
}

static bool is_zero(const uint8_t *bytes, uint64_t from, uint64_t to)
{
    for (uint64_t i = from; i < to; i++)
        if (bytes[i] != 0)
            return false;
    return true;
}

/* The one layout there is: sections in order, each at the first aligned place after the one before, zeros between.
 * `end`: where the section before ends, then where this one does. */
static fault_code_t check_entry(const uint8_t *bytes, uint64_t limit, int i, const entry_t *e, uint64_t *end,
                                fault_t *fault)
{
    const struct section_rule *rule = &rules[i];
    if (e->id != (uint32_t)i + 1 || e->record != rule->record || e->reserved != 0)
        return fault_set(fault, FAULT_FORMAT,
                         "bundle section %d (%s): id %u with records of %u bytes, expected id %d and %u bytes", i,
                         rule->name, e->id, e->record, i + 1, rule->record);
    if (e->count > rule->most)
        return fault_set(fault, FAULT_LIMIT, "bundle section %d (%s): %llu records, more than the %llu allowed", i,
                         rule->name, (unsigned long long)e->count, (unsigned long long)rule->most);
    if (e->offset != align_up(*end))
        return fault_set(fault, FAULT_FORMAT, "bundle section %d (%s): offset %llu, expected %llu", i, rule->name,
                         (unsigned long long)e->offset, (unsigned long long)align_up(*end));
    /* The count is below 2^37, the record below 2^8: the product fits. */
    if (e->offset > limit || e->count * e->record > limit - e->offset)
        return fault_set(fault, FAULT_FORMAT,
                         "bundle section %d (%s): %llu records from byte %llu on leave the %llu bytes of content",
                         i, rule->name, (unsigned long long)e->count, (unsigned long long)e->offset,
                         (unsigned long long)limit);
    if (!is_zero(bytes, *end, e->offset))
        return fault_set(fault, FAULT_FORMAT, "bundle section %d (%s): the bytes before it are not zero", i,
                         rule->name);
    *end = e->offset + e->count * e->record;
    return FAULT_NONE;
}

static fault_code_t check_table(const uint8_t *bytes, size_t size, entry_t table[SECTION_COUNT], fault_t *fault)
{
    const uint64_t limit = size - DIGEST_SIZE;
    uint64_t end = TABLE_END;
    memcpy(table, bytes + RECORD_HEADER, SECTION_COUNT * sizeof *table);
    for (int i = 0; i < SECTION_COUNT; i++)
        TRY(check_entry(bytes, limit, i, &table[i], &end, fault));
    if (end != limit)
        return fault_set(fault, FAULT_FORMAT, "the bundle's sections end at byte %llu, its digest begins at %llu",
                         (unsigned long long)end, (unsigned long long)limit);
    const uint64_t vertices = table[SECTION_POSITIONS].count;
    for (int i = SECTION_NORMALS; i <= SECTION_UVS; i++)
        if (table[i].count != 0 && table[i].count != vertices)
            return fault_set(fault, FAULT_FORMAT, "bundle section %d (%s): %llu records for %llu vertices", i,
                             rules[i].name, (unsigned long long)table[i].count, (unsigned long long)vertices);
    return FAULT_NONE;
}

/* The section's first record, null if it has none. */
static const void *section_data(const uint8_t *bytes, const entry_t *entry)
{
    return entry->count ? bytes + entry->offset : NULL;
}

static scene_t scene_of(const uint8_t *bytes, const entry_t table[SECTION_COUNT])
{
    return (scene_t){
        .positions = section_data(bytes, &table[SECTION_POSITIONS]),
        .normals = section_data(bytes, &table[SECTION_NORMALS]),
        .uvs = section_data(bytes, &table[SECTION_UVS]),
        .indices = section_data(bytes, &table[SECTION_INDICES]),
        .shapes = section_data(bytes, &table[SECTION_SHAPES]),
        .materials = section_data(bytes, &table[SECTION_MATERIALS]),
        .textures = section_data(bytes, &table[SECTION_TEXTURES]),
        .images = section_data(bytes, &table[SECTION_IMAGES]),
        .texels = section_data(bytes, &table[SECTION_TEXELS]),
        .lights = section_data(bytes, &table[SECTION_LIGHTS]),
        .camera = section_data(bytes, &table[SECTION_CAMERA]),
        .vertex_count = table[SECTION_POSITIONS].count,
        .triangle_count = table[SECTION_INDICES].count,
        .texel_bytes = table[SECTION_TEXELS].count,
        .shape_count = (uint32_t)table[SECTION_SHAPES].count,
        .material_count = (uint32_t)table[SECTION_MATERIALS].count,
        .texture_count = (uint32_t)table[SECTION_TEXTURES].count,
        .image_count = (uint32_t)table[SECTION_IMAGES].count,
        .light_count = (uint32_t)table[SECTION_LIGHTS].count,
    };
}

fault_code_t bundle_open_memory(bundle_t **out, const void *data, size_t size, fault_t *fault)
{
    entry_t table[SECTION_COUNT];
    digest_t digest;
    *out = NULL;
    if ((uintptr_t)data % ALIGNMENT != 0)
        return fault_set(fault, FAULT_USAGE, "a bundle in memory must be aligned to %d bytes", ALIGNMENT);
    TRY(check_header(data, size, fault));
    TRY(check_digest(data, size, &digest, fault));
    TRY(check_table(data, size, table, fault));
    const scene_t scene = scene_of(data, table);
    TRY(scene_check(&scene, fault));
    bundle_t *bundle = malloc(sizeof *bundle);
    if (!bundle)
        return fault_set(fault, FAULT_MEMORY, "no memory for a bundle");
    *bundle = (bundle_t){.bytes = data, .size = size, .scene = scene, .digest = digest};
    *out = bundle;
    return FAULT_NONE;
}

/* Maps the whole regular file; its size is at least one byte. */
static fault_code_t map_file(const char *path, void **data, size_t *size, fault_t *fault)
{
    struct stat info;
    const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) {
        const int error = errno;
        return fault_set(fault, error == ENOENT || error == ENOTDIR ? FAULT_NOT_FOUND : FAULT_IO,
                         "%s: cannot open: %s", path, strerrordesc_np(error));
    }
    fault_code_t code = FAULT_NONE;
    if (fstat(file, &info) != 0 || !S_ISREG(info.st_mode))
        code = fault_set(fault, FAULT_IO, "%s: not a regular file", path);
    else if (info.st_size == 0)
        code = fault_set(fault, FAULT_FORMAT, "%s: not a bundle: the file is empty", path);
    if (code == FAULT_NONE) {
        *size = (size_t)info.st_size;
        *data = mmap(NULL, *size, PROT_READ, MAP_PRIVATE, file, 0);
        if (*data == MAP_FAILED)
            code = fault_set(fault, FAULT_IO, "%s: cannot map %zu bytes", path, *size);
    }
    close(file);
    return code;
}

fault_code_t bundle_open(bundle_t **out, const char *path, fault_t *fault)
{
    void *data = NULL;
    size_t size = 0;
    *out = NULL;
    TRY(map_file(path, &data, &size, fault));
    const fault_code_t code = bundle_open_memory(out, data, size, fault);
    if (code != FAULT_NONE) {
        munmap(data, size);
        return fault_prefix(fault, code, "%s", path);
    }
    (*out)->mapped = true;
    return FAULT_NONE;
}

void bundle_destroy(bundle_t **bundle)
{
    if (!bundle || !*bundle)
        return;
    if ((*bundle)->mapped)
        munmap((void *)(uintptr_t)(*bundle)->bytes, (*bundle)->size);
    free(*bundle);
    *bundle = NULL;
}

const scene_t *bundle_scene(const bundle_t *bundle)
{
    return &bundle->scene;
}

const digest_t *bundle_digest(const bundle_t *bundle)
{
    return &bundle->digest;
}

const uint8_t *bundle_bytes(const bundle_t *bundle, size_t *size)
{
    *size = bundle->size;
    return bundle->bytes;
}

bool bundle_probe(const char *path)
{
    uint8_t start[sizeof magic];
    const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0)
        return false;
    const bool is_bundle =
        read(file, start, sizeof start) == (ssize_t)sizeof start && memcmp(start, magic, sizeof magic) == 0;
    close(file);
    return is_bundle;
}
