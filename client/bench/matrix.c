#include "client/bench/matrix.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

#define REFERENCE_SEED (UINT64_C(1) << 63) /* beyond those of runs, which count from 1 */

enum { PLACE = 64 };

/* ---- texts and lists ---- */

static fault_code_t read_text(const json_t *object, const char *place, const char *name, char *out, size_t size,
                              fault_t *fault)
{
    const char *text = NULL;
    TRY(json_read_string_or(object, place, name, &text, fault));
    if (!text || !text[0])
        return fault_set(fault, FAULT_RANGE, "%s.%s: missing or empty, expected a string", place, name);
    if (strlen(text) >= size)
        return fault_set(fault, FAULT_LIMIT, "%s.%s: %zu characters, expected fewer than %zu", place, name,
                         strlen(text), size);
    strcpy(out, text);
    return FAULT_NONE;
}

/* Names go into names of files. */
static fault_code_t read_name(const json_t *object, const char *place, char out[MATRIX_NAME], fault_t *fault)
{
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._+-";
    TRY(read_text(object, place, "name", out, MATRIX_NAME, fault));
    if (out[strspn(out, allowed)] != '\0' || out[0] == '.' || out[0] == '-')
        return fault_set(fault, FAULT_RANGE,
                         "%s.name: found \"%s\", expected letters, digits, . _ + - and no . or - in front", place,
                         out);
    return FAULT_NONE;
}

/* A list with 1 to `most` members. */
static fault_code_t find_list(const json_t *root, const char *path, const char *name, size_t most,
                              const json_t **list, fault_t *fault)
{
    *list = json_get(root, name);
    if (!*list || !json_is_array(*list) || json_size(*list) < 1 || json_size(*list) > most)
        return fault_set(fault, FAULT_RANGE, "%s%s: expected a list of 1 to %zu entries", path, name, most);
    return FAULT_NONE;
}

/* An object's text; "{}" if it is absent. */
static fault_code_t read_object_text(const json_t *object, const char *place, const char *name,
                                     char out[MATRIX_TEXT], fault_t *fault)
{
    const json_t *member;
    TRY(json_read_object(object, place, name, &member, fault));
    char *text = member ? json_print(member, false) : NULL;
    const size_t length = text ? strlen(text) : 2;
    if (length < MATRIX_TEXT)
        strcpy(out, text ? text : "{}");
    free(text);
    if (length >= MATRIX_TEXT)
        return fault_set(fault, FAULT_LIMIT, "%s.%s: %zu characters, expected fewer than %d", place, name, length,
                         MATRIX_TEXT);
    return FAULT_NONE;
}

/* A path relative to the file's folder. */
static fault_code_t place_path(char path[JOB_PATH_SIZE], const char *folder, fault_t *fault)
{
    char joined[JOB_PATH_SIZE];
    if (strcmp(folder, ".") == 0)
        return FAULT_NONE;
    TRY(file_join(joined, sizeof joined, folder, path, fault));
    strcpy(path, joined);
    return FAULT_NONE;
}

/* ---- scenes and variants ---- */

static fault_code_t read_references(matrix_scene_t *scene, const json_t *object, const char *place,
                                    const char *folder, fault_t *fault)
{
    char path[PLACE + 16];
    const json_t *list;
    if (!json_get(object, "references"))
        return FAULT_NONE;
    snprintf(path, sizeof path, "%s.", place);
    TRY(find_list(object, path, "references", 2, &list, fault));
    for (const json_t *m = json_first(list); m; m = json_next(m)) {
        const char *text = json_string(m);
        if (!text || !text[0] || strlen(text) >= JOB_PATH_SIZE)
            return fault_set(fault, FAULT_TYPE, "%s.references[%zu]: expected the path of an image", place,
                             scene->reference_count);
        strcpy(scene->references[scene->reference_count], text);
        TRY(place_path(scene->references[scene->reference_count++], folder, fault));
    }
    return FAULT_NONE;
}

static fault_code_t read_scene(matrix_t *matrix, const json_t *object, const char *place, const char *folder,
                               fault_t *fault)
{
    static const char *const fields[] = {"name", "scene", "film", "max_path_length", "references", NULL};
    matrix_scene_t *scene = &matrix->scenes[matrix->scene_count];
    int64_t longest = 0;
    TRY(json_expect_fields(object, place, fields, fault));
    TRY(read_name(object, place, scene->name, fault));
    TRY(read_text(object, place, "scene", scene->scene, sizeof scene->scene, fault));
    TRY(place_path(scene->scene, folder, fault));
    TRY(read_object_text(object, place, "film", scene->film, fault));
    TRY(json_read_int_or(object, place, "max_path_length", 1, 127, &longest, fault));
    scene->max_path_length = (uint32_t)longest;
    TRY(read_references(scene, object, place, folder, fault));
    for (size_t i = 0; i < matrix->scene_count; i++)
        if (strcmp(matrix->scenes[i].name, scene->name) == 0)
            return fault_set(fault, FAULT_RANGE, "%s.name: \"%s\" is scenes[%zu]'s too", place, scene->name, i);
    matrix->scene_count++;
    return FAULT_NONE;
}

static fault_code_t read_variant(matrix_t *matrix, const json_t *object, const char *place, fault_t *fault)
{
    static const char *const fields[] = {"name", "algorithm", "chains", NULL};
    matrix_variant_t *variant = &matrix->variants[matrix->variant_count];
    TRY(json_expect_fields(object, place, fields, fault));
    TRY(read_name(object, place, variant->name, fault));
    TRY(read_text(object, place, "algorithm", variant->algorithm, sizeof variant->algorithm, fault));
    TRY(read_object_text(object, place, "chains", variant->chains, fault));
    for (size_t i = 0; i < matrix->variant_count; i++)
        if (strcmp(matrix->variants[i].name, variant->name) == 0)
            return fault_set(fault, FAULT_RANGE, "%s.name: \"%s\" is variants[%zu]'s too", place, variant->name, i);
    matrix->variant_count++;
    return FAULT_NONE;
}

static fault_code_t read_lists(matrix_t *matrix, const json_t *root, const char *folder, fault_t *fault)
{
    char place[PLACE];
    const json_t *list;
    TRY(find_list(root, "", "scenes", MATRIX_SCENES, &list, fault));
    for (const json_t *m = json_first(list); m; m = json_next(m)) {
        snprintf(place, sizeof place, "scenes[%zu]", matrix->scene_count);
        TRY(read_scene(matrix, m, place, folder, fault));
    }
    TRY(find_list(root, "", "variants", MATRIX_VARIANTS, &list, fault));
    for (const json_t *m = json_first(list); m; m = json_next(m)) {
        snprintf(place, sizeof place, "variants[%zu]", matrix->variant_count);
        TRY(read_variant(matrix, m, place, fault));
    }
    return FAULT_NONE;
}

/* ---- numbers ---- */

static fault_code_t read_budgets(matrix_t *matrix, const json_t *root, fault_t *fault)
{
    static const char *const fields[] = {"seconds", "mutations_per_pixel", NULL};
    const json_t *budgets, *list;
    TRY(json_read_object(root, "", "budgets", &budgets, fault));
    TRY(json_expect_fields(budgets, "budgets", fields, fault));
    if (!budgets || json_size(budgets) != 1)
        return fault_set(fault, FAULT_RANGE, "budgets: expected one of \"seconds\" and \"mutations_per_pixel\"");
    const char *name = json_name(json_first(budgets));
    matrix->by_mutations = strcmp(name, fields[1]) == 0;
    TRY(find_list(budgets, "budgets.", name, MATRIX_BUDGETS, &list, fault));
    const double most = matrix->by_mutations ? 1e9 : 1e6;
    double last = 0;
    for (const json_t *m = json_first(list); m; m = json_next(m)) {
        const double value = json_number(m);
        if (!json_is_number(m) || !(value >= 0.001 && value <= most && value > last))
            return fault_set(fault, FAULT_RANGE,
                             "budgets.%s[%zu]: expected a number from 0.001 to %g, above the one before it", name,
                             matrix->budget_count, most);
        matrix->budgets[matrix->budget_count++] = last = value;
    }
    return FAULT_NONE;
}

static fault_code_t read_reference(matrix_t *matrix, const json_t *root, fault_t *fault)
{
    static const char *const fields[] = {"algorithm", "seconds", NULL};
    const json_t *reference;
    TRY(json_read_object(root, "", "reference", &reference, fault));
    if (!reference)
        return FAULT_NONE;
    TRY(json_expect_fields(reference, "reference", fields, fault));
    TRY(read_text(reference, "reference", "algorithm", matrix->reference, sizeof matrix->reference, fault));
    matrix->reference_seconds = 60;
    return json_read_double_or(reference, "reference", "seconds", 0.001, 1e6, &matrix->reference_seconds, fault);
}

static fault_code_t read_numbers(matrix_t *matrix, const json_t *root, fault_t *fault)
{
    int64_t seeds = 4, workers = 1;
    matrix->limit_seconds = 3600;
    TRY(json_read_int_or(root, "", "seeds", 1, MATRIX_SEEDS, &seeds, fault));
    TRY(json_read_int_or(root, "", "workers", 1, 256, &workers, fault));
    TRY(json_read_double_or(root, "", "limit_seconds", 1, 1e7, &matrix->limit_seconds, fault));
    matrix->seeds = (size_t)seeds;
    matrix->workers = (int)workers;
    return FAULT_NONE;
}

/* ---- jobs ---- */

static fault_code_t make_job(job_t *job, const matrix_scene_t *scene, const matrix_variant_t *variant,
                             uint64_t seed, const char *rule, double amount, const char *name, fault_t *fault)
{
    json_t *root = json_new_object(), *film = NULL, *chains = NULL, *stop = json_new_object();
    json_add_string(root, "scene", scene->name); /* not its path: where files lie makes no other job */
    json_add_string(root, "algorithm", variant->algorithm);
    if (scene->max_path_length > 0)
        json_add_number(root, "max_path_length", scene->max_path_length);
    json_add_u64(root, "seed", seed);
    json_add_number(stop, rule, amount);
    json_add(root, "stop", stop);
    fault_code_t code = json_parse(&film, scene->film, strlen(scene->film), fault);
    if (code == FAULT_NONE)
        json_add(root, "film", film);
    if (code == FAULT_NONE)
        code = json_parse(&chains, variant->chains, strlen(variant->chains), fault);
    if (code == FAULT_NONE) {
        json_add(root, "chains", chains);
        char *text = json_print(root, false);
        code = job_parse(job, text, strlen(text), name, fault);
        free(text);
    }
    json_destroy(&root);
    return code;
}

fault_code_t matrix_job(job_t *job, const matrix_t *matrix, size_t scene, size_t variant, uint64_t seed,
                        size_t budget, fault_t *fault)
{
    char name[2 * MATRIX_NAME + 16];
    snprintf(name, sizeof name, "%s with %s", matrix->scenes[scene].name, matrix->variants[variant].name);
    return make_job(job, &matrix->scenes[scene], &matrix->variants[variant], seed,
                    matrix->by_mutations ? "mutations_per_pixel" : "seconds", matrix->budgets[budget], name, fault);
}

fault_code_t matrix_reference_job(job_t *job, const matrix_t *matrix, size_t scene, int half, fault_t *fault)
{
    char name[MATRIX_NAME + 32];
    matrix_variant_t variant = {.chains = "{}"};
    strcpy(variant.algorithm, matrix->reference);
    snprintf(name, sizeof name, "reference of %s", matrix->scenes[scene].name);
    return make_job(job, &matrix->scenes[scene], &variant, REFERENCE_SEED + (uint64_t)half, "seconds",
                    matrix->reference_seconds, name, fault);
}

/* Every job that will be run. */
static fault_code_t check_jobs(const matrix_t *matrix, fault_t *fault)
{
    job_t *job = malloc(sizeof *job);
    fault_code_t code = job ? FAULT_NONE : fault_set(fault, FAULT_MEMORY, "no memory for a job");
    for (size_t s = 0; s < matrix->scene_count && code == FAULT_NONE; s++) {
        for (size_t v = 0; v < matrix->variant_count && code == FAULT_NONE; v++)
            code = matrix_job(job, matrix, s, v, 1, 0, fault);
        if (code == FAULT_NONE && matrix->reference[0])
            code = matrix_reference_job(job, matrix, s, 0, fault);
    }
    free(job);
    return code;
}

/* ---- the file ---- */

static fault_code_t read_root(matrix_t *matrix, const json_t *root, const char *folder, fault_t *fault)
{
    static const char *const fields[] = {"scenes",  "variants",      "budgets",   "seeds",
                                         "workers", "limit_seconds", "reference", NULL};
    if (!json_is_object(root))
        return fault_set(fault, FAULT_TYPE, "expected an object");
    TRY(json_expect_fields(root, "", fields, fault));
    TRY(read_lists(matrix, root, folder, fault));
    TRY(read_budgets(matrix, root, fault));
    TRY(read_numbers(matrix, root, fault));
    TRY(read_reference(matrix, root, fault));
    return check_jobs(matrix, fault);
}

fault_code_t matrix_parse(matrix_t *matrix, const char *text, size_t length, const char *name, fault_t *fault)
{
    json_t *root = NULL;
    char folder[JOB_PATH_SIZE];
    memset(matrix, 0, sizeof *matrix);
    TRY(file_folder_of(folder, sizeof folder, name, fault));
    fault_code_t code = json_parse(&root, text, length, fault);
    if (code == FAULT_NONE)
        code = read_root(matrix, root, folder, fault);
    json_destroy(&root);
    return fault_prefix(fault, code, "%s", name);
}

fault_code_t matrix_read(matrix_t *matrix, const char *path, fault_t *fault)
{
    uint8_t *text;
    size_t size;
    TRY(file_read(path, MATRIX_BYTES, &text, &size, fault));
    const fault_code_t code = matrix_parse(matrix, (const char *)text, size, path, fault);
    free(text);
    return code;
}
