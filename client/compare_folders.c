#include "client/compare_folders.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "film/compare.h"
#include "film/image_file.h"
#include "film/png.h"

enum { PATH_SIZE = 4096, NAME_SIZE = 256, STEM_END = 4 /* of ".exr", ".pfm" */ };

/* ---- the images of a folder ---- */

typedef struct listing {
    const char *folder;
    char (*names)[NAME_SIZE]; /* sorted by stem */
    size_t count;
} listing_t;

static bool is_image(const char *name)
{
    const size_t length = strlen(name);
    return length > STEM_END && length < NAME_SIZE &&
           (strcmp(name + length - STEM_END, ".exr") == 0 || strcmp(name + length - STEM_END, ".pfm") == 0);
}

static int compare_stems(const char *a, const char *b)
{
    const size_t m = strlen(a) - STEM_END, n = strlen(b) - STEM_END;
    const int order = memcmp(a, b, m < n ? m : n);
    return order != 0 ? order : (m > n) - (m < n);
}

static int by_stem(const void *a, const void *b)
{
    return compare_stems(a, b);
}

static fault_code_t listing_read(listing_t *listing, DIR *folder, fault_t *fault)
{
    for (const struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
        if (!is_image(entry->d_name))
            continue;
        if (listing->count == COMPARE_FOLDERS_MOST)
            return fault_set(fault, FAULT_LIMIT, "%s: more than %d images", listing->folder, COMPARE_FOLDERS_MOST);
        strcpy(listing->names[listing->count++], entry->d_name);
    }
    if (listing->count > 0)
        qsort(listing->names, listing->count, sizeof *listing->names, by_stem);
    for (size_t i = 1; i < listing->count; i++)
        if (compare_stems(listing->names[i - 1], listing->names[i]) == 0)
            return fault_set(fault, FAULT_FORMAT, "%s: found %s and %s, expected one image of a name",
                             listing->folder, listing->names[i - 1], listing->names[i]);
    return FAULT_NONE;
}

static fault_code_t listing_new(listing_t *listing, const char *path, fault_t *fault)
{
    *listing = (listing_t){.folder = path};
    DIR *folder = opendir(path);
    if (!folder)
        return fault_set(fault, FAULT_IO, "%s: %s", path, strerror(errno));
    listing->names = calloc(COMPARE_FOLDERS_MOST, sizeof *listing->names);
    const fault_code_t code = listing->names
                                  ? listing_read(listing, folder, fault)
                                  : fault_set(fault, FAULT_MEMORY, "no memory for the names in %s", path);
    closedir(folder);
    return code;
}

/* ---- pairs ---- */

enum { RELMSE = 0, ERROR, MSE, BIAS, TRIMMED, FIGURES };
static const char *const figure_names[FIGURES] = {"relmse", "error", "mse", "bias", "relmse_trimmed"};

typedef struct pair {
    const char *image, *reference; /* names; null: there is none */
    double figures[FIGURES];
    char failure[512]; /* empty: it was compared */
} pair_t;

typedef struct table {
    listing_t images, references;
    pair_t *pairs; /* with the unpaired, by stem */
    size_t count;
} table_t;

/* Merges two sorted lists. */
static fault_code_t table_join(table_t *t, fault_t *fault)
{
    size_t i = 0, r = 0;
    t->pairs = calloc(t->images.count + t->references.count + 1, sizeof *t->pairs);
    if (!t->pairs)
        return fault_set(fault, FAULT_MEMORY, "no memory for %zu images", t->images.count + t->references.count);
    while (i < t->images.count || r < t->references.count) {
        int order = i == t->images.count ? 1 : r == t->references.count ? -1 : 0;
        if (order == 0)
            order = compare_stems(t->images.names[i], t->references.names[r]);
        pair_t *pair = &t->pairs[t->count++];
        pair->image = order <= 0 ? t->images.names[i++] : NULL;
        pair->reference = order >= 0 ? t->references.names[r++] : NULL;
    }
    return FAULT_NONE;
}

static bool is_compared(const pair_t *pair)
{
    return pair->image && pair->reference && !pair->failure[0];
}

static fault_code_t write_heat_map(const compare_result_t *result, const image_t *image, const image_t *reference,
                                   const char *stem, const char *folder, fault_t *fault)
{
    char name[NAME_SIZE + 8], path[PATH_SIZE];
    image_t map;
    snprintf(name, sizeof name, "%.*s.png", (int)(strlen(stem) - STEM_END), stem);
    TRY(file_join(path, sizeof path, folder, name, fault));
    TRY(compare_heat_map(&map, result, image, reference, NULL, fault));
    const fault_code_t code = png_write(&map, 1, path, fault);
    image_clear(&map);
    return code;
}

static fault_code_t compare_images_of(pair_t *pair, const image_t images[2], const char *const paths[2],
                                      const char *heatmaps, fault_t *fault)
{
    const compare_options_t options = {.names = {paths[0], paths[1]}};
    compare_result_t *result = calloc(1, sizeof *result);
    if (!result)
        return fault_set(fault, FAULT_MEMORY, "no memory for a comparison");
    fault_code_t code = compare_images(result, &images[0], &images[1], NULL, &options, fault);
    if (code == FAULT_NONE && heatmaps)
        code = write_heat_map(result, &images[0], &images[1], pair->image, heatmaps, fault);
    const double figures[FIGURES] = {result->relmse, result->error, result->mse, result->bias,
                                     result->relmse_trimmed};
    memcpy(pair->figures, figures, sizeof figures);
    free(result);
    return code;
}

static fault_code_t compare_pair(const table_t *t, pair_t *pair, const char *heatmaps, fault_t *fault)
{
    char paths[2][PATH_SIZE];
    image_t images[2];
    TRY(file_join(paths[0], PATH_SIZE, t->images.folder, pair->image, fault));
    TRY(file_join(paths[1], PATH_SIZE, t->references.folder, pair->reference, fault));
    TRY(image_file_read(&images[0], paths[0], fault));
    fault_code_t code = image_file_read(&images[1], paths[1], fault);
    if (code == FAULT_NONE) {
        code = compare_images_of(pair, images, (const char *const[]){paths[0], paths[1]}, heatmaps, fault);
        image_clear(&images[1]);
    }
    image_clear(&images[0]);
    return code;
}

/* Pairs that fail keep the reason. */
static fault_code_t table_compare(table_t *t, const char *heatmaps, fault_t *fault)
{
    size_t pairs = 0;
    if (heatmaps)
        TRY(file_make_folder(heatmaps, fault));
    for (size_t i = 0; i < t->count; i++) {
        pair_t *pair = &t->pairs[i];
        fault_t own = {0};
        if (!pair->image || !pair->reference)
            continue;
        pairs++;
        if (compare_pair(t, pair, heatmaps, &own) != FAULT_NONE)
            snprintf(pair->failure, sizeof pair->failure, "%.*s", (int)sizeof pair->failure - 1, own.text);
    }
    if (pairs == 0)
        return fault_set(fault, FAULT_NOT_FOUND, "%s and %s have no .exr or .pfm image of one name in common",
                         t->images.folder, t->references.folder);
    return FAULT_NONE;
}

/* ---- means and medians ---- */

typedef struct summary {
    size_t count;
    double mean[FIGURES], median[FIGURES];
} summary_t;

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static fault_code_t summarise(const table_t *t, summary_t *summary, fault_t *fault)
{
    double *values = calloc(t->count + 1, sizeof *values);
    if (!values)
        return fault_set(fault, FAULT_MEMORY, "no memory for %zu figures", t->count);
    for (int f = 0; f < FIGURES; f++) {
        size_t n = 0;
        double sum = 0;
        for (size_t i = 0; i < t->count; i++)
            if (is_compared(&t->pairs[i]))
                sum += values[n++] = t->pairs[i].figures[f];
        qsort(values, n, sizeof *values, ascending);
        summary->count = n;
        summary->mean[f] = n > 0 ? sum / (double)n : NAN;
        summary->median[f] = n > 0 ? 0.5 * (values[(n - 1) / 2] + values[n / 2]) : NAN;
    }
    free(values);
    return FAULT_NONE;
}

/* ---- printing ---- */

static void print_row(const char *name, size_t length, int width, const double figures[FIGURES])
{
    printf("%-*.*s", width, (int)length, name);
    for (int f = 0; f < FIGURES; f++)
        printf(" %12.6g", figures[f]);
    putchar('\n');
}

static void print_text(const table_t *t, const summary_t *summary)
{
    int width = 8;
    for (size_t i = 0; i < t->count; i++)
        if (t->pairs[i].image && (int)strlen(t->pairs[i].image) - STEM_END > width)
            width = (int)strlen(t->pairs[i].image) - STEM_END;
    printf("%-*s %12s %12s %12s %12s %12s\n", width, "", "relMSE", "error", "MSE", "bias", "trimmed");
    for (size_t i = 0; i < t->count; i++)
        if (is_compared(&t->pairs[i]))
            print_row(t->pairs[i].image, strlen(t->pairs[i].image) - STEM_END, width, t->pairs[i].figures);
    print_row("mean", 4, width, summary->mean);
    print_row("median", 6, width, summary->median);
    for (size_t i = 0; i < t->count; i++) {
        const pair_t *pair = &t->pairs[i];
        if (pair->failure[0])
            printf("not compared: %s: %s\n", pair->image, pair->failure);
        else if (!pair->reference)
            printf("without a reference: %s/%s\n", t->images.folder, pair->image);
        else if (!pair->image)
            printf("without an image: %s/%s\n", t->references.folder, pair->reference);
    }
}

static void add_figures(json_t *object, const double figures[FIGURES])
{
    for (int f = 0; f < FIGURES; f++)
        json_add_number(object, figure_names[f], figures[f]);
}

static void print_json(const table_t *t, const summary_t *summary)
{
    json_t *root = json_new_object(), *pairs = json_new_array(), *failed = json_new_array(),
           *images = json_new_array(), *references = json_new_array(), *mean = json_new_object(),
           *median = json_new_object();
    for (size_t i = 0; i < t->count; i++) {
        const pair_t *pair = &t->pairs[i];
        if (!pair->reference) {
            json_append(images, json_new_string(pair->image));
        } else if (!pair->image) {
            json_append(references, json_new_string(pair->reference));
        } else {
            json_t *object = json_new_object();
            json_add_string(object, "image", pair->image);
            json_add_string(object, "reference", pair->reference);
            if (pair->failure[0])
                json_add_string(object, "failure", pair->failure);
            else
                add_figures(object, pair->figures);
            json_append(pair->failure[0] ? failed : pairs, object);
        }
    }
    add_figures(mean, summary->mean);
    add_figures(median, summary->median);
    json_add(root, "pairs", pairs);
    json_add(root, "mean", mean);
    json_add(root, "median", median);
    json_add(root, "failed", failed);
    json_add(root, "images_without_reference", images);
    json_add(root, "references_without_image", references);
    char *text = json_print(root, true);
    puts(text);
    free(text);
    json_destroy(&root);
}

/* In quotes, as names may hold anything (RFC 4180). */
static void put_name(FILE *out, const char *name)
{
    fputc('"', out);
    for (; *name; name++) {
        if (*name == '"')
            fputc('"', out);
        fputc(*name, out);
    }
    fputc('"', out);
}

static fault_code_t write_csv(const table_t *t, const char *path, fault_t *fault)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return fault_set(fault, FAULT_MEMORY, "%s: no memory", path);
    fputs("image,reference", out);
    for (int f = 0; f < FIGURES; f++)
        fprintf(out, ",%s", figure_names[f]);
    fputs("\r\n", out);
    for (size_t i = 0; i < t->count; i++) {
        const pair_t *pair = &t->pairs[i];
        if (!is_compared(pair))
            continue;
        put_name(out, pair->image);
        fputc(',', out);
        put_name(out, pair->reference);
        for (int f = 0; f < FIGURES; f++)
            fprintf(out, ",%.17g", pair->figures[f]);
        fputs("\r\n", out);
    }
    const fault_code_t code = fclose(out) == 0 ? file_write(path, text, size, fault)
                                               : fault_set(fault, FAULT_MEMORY, "%s: no memory", path);
    free(text);
    return code;
}

static fault_code_t table_deliver(const table_t *t, const compare_folders_options_t *options, fault_t *fault)
{
    summary_t summary;
    size_t failed = 0;
    TRY(summarise(t, &summary, fault));
    if (options->json)
        print_json(t, &summary);
    else
        print_text(t, &summary);
    if (options->csv)
        TRY(write_csv(t, options->csv, fault));
    for (size_t i = 0; i < t->count; i++)
        failed += t->pairs[i].failure[0] != '\0';
    if (failed > 0)
        return fault_set(fault, FAULT_FORMAT, "%zu of %zu pairs could not be compared", failed,
                         failed + summary.count);
    return FAULT_NONE;
}

fault_code_t compare_folders(const char *images, const char *references, const compare_folders_options_t *options,
                             fault_t *fault)
{
    table_t table = {0};
    fault_code_t code = listing_new(&table.images, images, fault);
    if (code == FAULT_NONE)
        code = listing_new(&table.references, references, fault);
    if (code == FAULT_NONE)
        code = table_join(&table, fault);
    if (code == FAULT_NONE)
        code = table_compare(&table, options->heatmaps, fault);
    if (code == FAULT_NONE)
        code = table_deliver(&table, options, fault);
    free(table.images.names);
    free(table.references.names);
    free(table.pairs);
    return code;
}
