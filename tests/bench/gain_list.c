#include "gain_list.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

enum { LIST_BYTES = 1 << 20 };

#define PLAIN "{\"failures\":\"plain\",\"partial_step\":0}"
#define DELAYED "{\"failures\":\"delayed\",\"partial_step\":0}"
#define PUBLISHED "{\"failures\":\"published\",\"partial_step\":0}"
#define PARTIAL "{\"failures\":\"plain\",\"partial_step\":0.5}"
#define AUXILIARY "{\"failures\":\"plain\",\"partial_step\":0,\"auxiliary_step\":0.1}"

/* The usual ones first. */
enum { USUAL = 18 };
static const gain_variant_t known[] = {{"bdpt", "bdpt", "{}"},
                                       {"mmlt", "mmlt", PLAIN},
                                       {"mmlt+delayed", "mmlt", DELAYED},
                                       {"mmlt+partial", "mmlt", PARTIAL},
                                       {"mmlt+auxiliary", "mmlt", AUXILIARY},
                                       {"mmlt+published", "mmlt", PUBLISHED},
                                       {"pssmlt", "pssmlt", PLAIN},
                                       {"pssmlt-mix", "pssmlt-mix", PLAIN},
                                       {"pssmlt-mix+delayed", "pssmlt-mix", DELAYED},
                                       {"rjmlt", "rjmlt", PLAIN},
                                       {"rjmlt+delayed", "rjmlt", DELAYED},
                                       {"rjmlt+published", "rjmlt", PUBLISHED},
                                       {"cmlt", "cmlt", PLAIN},
                                       {"cmlt+delayed", "cmlt", DELAYED},
                                       {"cmlt+published", "cmlt", PUBLISHED},
                                       {"cmlt-rex", "cmlt-rex", PLAIN},
                                       {"cmlt-rex+delayed", "cmlt-rex", DELAYED},
                                       {"cmlt-ipsm", "cmlt-ipsm", PLAIN},
                                       {"pssmlt-mix+partial", "pssmlt-mix", PARTIAL},
                                       {"rjmlt+partial", "rjmlt", PARTIAL},
                                       {"rjmlt+auxiliary", "rjmlt", AUXILIARY},
                                       {"cmlt+partial", "cmlt", PARTIAL},
                                       {"cmlt+auxiliary", "cmlt", AUXILIARY},
                                       {"cmlt-rex+partial", "cmlt-rex", PARTIAL}};

void gain_variants_all(gain_variants_t *list)
{
    list->count = sizeof known / sizeof *known;
    memcpy(list->items, known, sizeof known);
}

void gain_variants_usual(gain_variants_t *list)
{
    gain_variants_all(list);
    list->count = USUAL;
}

static fault_code_t list_read_text(const json_t *object, const char *path, const char *name, char *out, size_t size,
                                   fault_t *fault)
{
    const char *text = NULL;
    TRY(json_read_string_or(object, path, name, &text, fault));
    if (!text || !*text || strlen(text) >= size)
        return fault_set(fault, FAULT_FORMAT, "%s.%s: expected a text of 1 to %zu characters", path, name,
                         size - 1);
    memcpy(out, text, strlen(text) + 1);
    return FAULT_NONE;
}

static fault_code_t list_read_one(gain_variants_t *list, const json_t *object, fault_t *fault)
{
    static const char *const names[] = {"name", "algorithm", "chains", NULL};
    char path[32];
    snprintf(path, sizeof path, "[%zu]", list->count);
    if (list->count == GAIN_VARIANTS)
        return fault_set(fault, FAULT_LIMIT, "more than %d variants", GAIN_VARIANTS);
    gain_variant_t *v = &list->items[list->count];
    *v = (gain_variant_t){0};
    TRY(json_expect_fields(object, path, names, fault));
    TRY(list_read_text(object, path, "name", v->name, sizeof v->name, fault));
    TRY(list_read_text(object, path, "algorithm", v->algorithm, sizeof v->algorithm, fault));
    const json_t *chains = NULL;
    TRY(json_read_object(object, path, "chains", &chains, fault));
    char *text = chains ? json_print(chains, false) : NULL;
    const int length = snprintf(v->chains, sizeof v->chains, "%s", text ? text : "{}");
    free(text);
    if (length >= (int)sizeof v->chains)
        return fault_set(fault, FAULT_LIMIT, "%s.chains: %d characters, expected fewer than %d", path, length,
                         GAIN_CHAINS);
    list->count++;
    return FAULT_NONE;
}

fault_code_t gain_variants_read(gain_variants_t *list, const char *path, fault_t *fault)
{
    uint8_t *data;
    size_t size;
    json_t *root = NULL;
    *list = (gain_variants_t){0};
    TRY(file_read(path, LIST_BYTES, &data, &size, fault));
    fault_code_t code = json_parse(&root, (const char *)data, size, fault);
    if (!code && !json_is_array(root))
        code = fault_set(fault, FAULT_TYPE, "expected an array of variants");
    for (const json_t *m = code ? NULL : json_first(root); m && !code; m = json_next(m))
        code = list_read_one(list, m, fault);
    json_destroy(&root);
    free(data);
    return fault_prefix(fault, code, "%s", path);
}

static const gain_variant_t *list_find(const gain_variants_t *list, const char *name, size_t length)
{
    for (size_t i = 0; i < list->count; i++)
        if (strlen(list->items[i].name) == length && strncmp(list->items[i].name, name, length) == 0)
            return &list->items[i];
    return NULL;
}

fault_code_t gain_variants_select(gain_variants_t *list, const char *names, fault_t *fault)
{
    gain_variants_t chosen = {0};
    for (const char *name = names; *name;) {
        const size_t length = strcspn(name, ",");
        const gain_variant_t *v = list_find(list, name, length);
        if (!v)
            return fault_set(fault, FAULT_UNKNOWN, "there is no variant %.*s", (int)length, name);
        if (chosen.count == GAIN_VARIANTS)
            return fault_set(fault, FAULT_LIMIT, "more than %d variants", GAIN_VARIANTS);
        chosen.items[chosen.count++] = *v;
        name += length + (name[length] == ',');
    }
    *list = chosen;
    return FAULT_NONE;
}

bool gain_name_is_plain(const char *name)
{
    return strchr(name, '+') == NULL;
}

bool gain_name_has_remedy(const char *name, const char *remedy)
{
    const char *plus = strchr(name, '+');
    return plus && strcmp(plus + 1, remedy) == 0;
}

gain_size_t gain_size_of(const peer_scene_t *entry, uint32_t width)
{
    const double height = rint((double)width * entry->height / entry->width);
    return (gain_size_t){width, (uint32_t)fmax(1, height)};
}

fault_code_t gain_job(job_t *job, const peer_scene_t *entry, gain_size_t size, const gain_variant_t *variant,
                      uint64_t seed, double seconds, fault_t *fault)
{
    json_t *root = json_new_object(), *film = json_new_object(), *stop = json_new_object(), *chains = NULL;
    json_add_string(root, "scene", entry->name);
    json_add_number(film, "width", size.width);
    json_add_number(film, "height", size.height);
    json_add_string(film, "filter", "box");
    json_add(root, "film", film);
    json_add_string(root, "algorithm", variant->algorithm);
    json_add_number(root, "max_path_length", entry->max_path_length);
    json_add_u64(root, "seed", seed);
    json_add_number(stop, "seconds", seconds);
    json_add(root, "stop", stop);
    fault_code_t code = json_parse(&chains, variant->chains, strlen(variant->chains), fault);
    if (!code) {
        json_add(root, "chains", chains);
        char *text = json_print(root, false);
        code = job_parse(job, text, strlen(text), variant->name, fault);
        free(text);
    }
    json_destroy(&root);
    return code;
}

double gain_reference_bdpt(const peer_scene_t *entry)
{
    /* Weights in inverse proportion to the trimmed relMSE of bdpt and mmlt after equal time (docs/benchmarks.md).
     * In water-caustic single bdpt samples carry several times the light of the whole picture: any weight would be
     * too much. They are fixed beforehand: the sum stays without bias. */
    static const struct {
        const char *scene;
        double bdpt;
    } recipes[] = {{"water-box", 0.15}, {"water-caustic", 0}, {"two-rooms", 0.35}};
    for (size_t i = 0; i < sizeof recipes / sizeof *recipes; i++)
        if (strcmp(entry->name, recipes[i].scene) == 0)
            return recipes[i].bdpt;
    return 1;
}
