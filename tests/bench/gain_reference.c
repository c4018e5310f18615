#include "gain_reference.h"

#include <dirent.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "film/compare.h"
#include "film/pfm.h"
#include "options.h"
#include "parallel.h"
#include "client/bench/solo.h"

enum { PATH_ROOM = 4096, NAME_ROOM = 256, MAX_PARTS = 1 << 16 };

static const gain_variant_t reference_variants[2] = {{"bdpt", "bdpt", "{}"}, {"mmlt", "mmlt", "{}"}};

/* Apart from the seeds of measured runs. */
static uint64_t part_seed(int half, int algorithm, unsigned index)
{
    return UINT64_C(1) << 40 | (uint64_t)index << 2 | (uint64_t)half << 1 | (uint64_t)algorithm;
}

/* ---- what is there ---- */

/* The beginning of the names of a half's parts by one algorithm. */
static void part_stem(char stem[NAME_ROOM], const peer_scene_t *entry, gain_size_t size, int half, int algorithm)
{
    snprintf(stem, NAME_ROOM, "%s-%ux%u-%c-%s-", entry->name, size.width, size.height, "ab"[half],
             reference_variants[algorithm].name);
}

/* Seconds and index of a part from what follows the stem; false if the file is none. */
static bool part_parse(const char *rest, double *seconds, unsigned *index)
{
    int end = 0;
    return sscanf(rest, "%lfs-%u.pfm%n", seconds, index, &end) == 2 && end > 0 && rest[end] == '\0' &&
           *seconds > 0 && *index < MAX_PARTS;
}

/* Sums of the parts of one half by one algorithm. */
typedef struct parts {
    double seconds;
    unsigned next; /* index that no part has */
    double *sums;  /* [3][pixels], of value * seconds; null: only counted */
} parts_t;

static fault_code_t parts_add(parts_t *parts, const char *path, double seconds, gain_size_t size, fault_t *fault)
{
    image_t image;
    const float *planes[3];
    TRY(pfm_read(&image, path, fault));
    fault_code_t code = image_find_rgb(&image, planes, fault);
    if (!code && (image.width != size.width || image.height != size.height))
        code = fault_set(fault, FAULT_FORMAT, "%u x %u pixels, expected %u x %u", image.width, image.height,
                         size.width, size.height);
    const size_t pixels = (size_t)size.width * size.height;
    for (size_t c = 0; c < 3 && !code; c++)
        for (size_t i = 0; i < pixels; i++)
            parts->sums[c * pixels + i] += (double)planes[c][i] * seconds;
    image_clear(&image);
    return fault_prefix(fault, code, "%s", path);
}

/* Goes through the folder in the order of names. */
static fault_code_t parts_find(parts_t *parts, const char *folder, const char *stem, gain_size_t size,
                               fault_t *fault)
{
    struct dirent **entries = NULL;
    const int count = scandir(folder, &entries, NULL, alphasort);
    fault_code_t code = FAULT_NONE;
    for (int i = 0; i < count; i++) {
        double seconds;
        unsigned index;
        if (!code && strncmp(entries[i]->d_name, stem, strlen(stem)) == 0 &&
            part_parse(entries[i]->d_name + strlen(stem), &seconds, &index)) {
            char path[PATH_ROOM];
            snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
            parts->seconds += seconds;
            parts->next = index + 1 > parts->next ? index + 1 : parts->next;
            if (parts->sums)
                code = parts_add(parts, path, seconds, size, fault);
        }
        free(entries[i]);
    }
    free(entries);
    return code;
}

/* ---- reading ---- */

/* Adds weight times the mean of the parts to the half. */
static fault_code_t half_add(gain_reference_t *reference, int half, int algorithm, double weight,
                             const peer_scene_t *entry, gain_size_t size, const char *folder, fault_t *fault)
{
    char stem[NAME_ROOM];
    const size_t values = 3 * (size_t)size.width * size.height;
    parts_t parts = {.sums = calloc(values, sizeof(double))};
    if (!parts.sums)
        return fault_set(fault, FAULT_MEMORY, "no memory for a reference");
    part_stem(stem, entry, size, half, algorithm);
    fault_code_t code = parts_find(&parts, folder, stem, size, fault);
    if (!code && !(parts.seconds > 0))
        code = fault_set(fault, FAULT_NOT_FOUND,
                         "%s has no part %s...: make references with tests/bench/gain references", folder, stem);
    for (size_t i = 0; i < values && !code; i++)
        reference->halves[half].data[i] += (float)(weight * parts.sums[i] / parts.seconds);
    reference->seconds[half] += parts.seconds;
    free(parts.sums);
    return code;
}

/* A against R = (A+B)/2: (A-R)^2 = (A-B)^2 / 4, whose expectation is R's own variance, as A and B are independent
 * and equally good. */
static fault_code_t reference_noise(gain_reference_t *reference, fault_t *fault)
{
    static compare_result_t result;
    image_t mean;
    const image_t *a = &reference->halves[0], *b = &reference->halves[1];
    TRY(image_init_rgb(&mean, a->width, a->height, fault));
    for (size_t i = 0; i < 3 * (size_t)a->width * a->height; i++)
        mean.data[i] = 0.5f * (a->data[i] + b->data[i]);
    const fault_code_t code = compare_images(&result, a, &mean, NULL, NULL, fault);
    reference->noise = result.relmse;
    reference->difference = 2 * fabs(result.bias - 1);
    image_clear(&mean);
    return code;
}

fault_code_t gain_reference_read(gain_reference_t *reference, const peer_scene_t *entry, gain_size_t size,
                                 const char *folder, fault_t *fault)
{
    const double bdpt = gain_reference_bdpt(entry);
    *reference = (gain_reference_t){0};
    fault_code_t code = FAULT_NONE;
    for (int half = 0; half < 2 && !code; half++) {
        code = image_init_rgb(&reference->halves[half], size.width, size.height, fault);
        if (!code && bdpt > 0)
            code = half_add(reference, half, 0, bdpt, entry, size, folder, fault);
        if (!code && bdpt < 1)
            code = half_add(reference, half, 1, 1 - bdpt, entry, size, folder, fault);
    }
    if (bdpt > 0 && bdpt < 1)
        snprintf(reference->recipe, sizeof reference->recipe, "%g bdpt + %g mmlt", bdpt, 1 - bdpt);
    else
        snprintf(reference->recipe, sizeof reference->recipe, "%s", bdpt > 0 ? "bdpt" : "mmlt");
    if (!code)
        code = reference_noise(reference, fault);
    if (code)
        gain_reference_clear(reference);
    return code;
}

void gain_reference_clear(gain_reference_t *reference)
{
    image_clear(&reference->halves[0]);
    image_clear(&reference->halves[1]);
}

/* ---- making ---- */

typedef struct part {
    const peer_loaded_t *loaded;
    int half, algorithm;
    unsigned index;
} part_t;

typedef struct maker {
    part_t *parts;
    size_t count, next, done;
    uint32_t width;
    const char *folder;
    double seconds;
    pthread_mutex_t lock; /* of next, done, fault */
    fault_t fault;
} maker_t;

static fault_code_t part_look(void *user, size_t index, double cpu_seconds, const plan_t *plan, fault_t *fault)
{
    (void)index;
    (void)cpu_seconds;
    return plan_image(plan, user, fault);
}

static fault_code_t part_render(const maker_t *maker, const part_t *part, fault_t *fault)
{
    const peer_scene_t *entry = part->loaded->entry;
    const gain_size_t size = gain_size_of(entry, maker->width);
    char stem[NAME_ROOM], path[PATH_ROOM];
    job_t job;
    image_t image = {0};
    TRY(gain_job(&job, entry, size, &reference_variants[part->algorithm],
                 part_seed(part->half, part->algorithm, part->index), maker->seconds, fault));
    TRY(solo_render(&part->loaded->scene, &job, &maker->seconds, 1, part_look, &image, fault));
    part_stem(stem, entry, size, part->half, part->algorithm);
    snprintf(path, sizeof path, "%s/%s%gs-%04u.pfm", maker->folder, stem, maker->seconds, part->index);
    const fault_code_t code = pfm_write(&image, path, fault);
    image_clear(&image);
    return code;
}

static void *maker_thread(void *user)
{
    maker_t *maker = user;
    pthread_mutex_lock(&maker->lock);
    while (maker->next < maker->count && !maker->fault.code) {
        const part_t *part = &maker->parts[maker->next++];
        fault_t fault = {0};
        pthread_mutex_unlock(&maker->lock);
        part_render(maker, part, &fault);
        pthread_mutex_lock(&maker->lock);
        if (fault.code) {
            maker->fault = fault;
            fault_prefix(&maker->fault, fault.code, "%s", part->loaded->entry->name);
        }
        maker->done++;
        fprintf(stderr, "reference of %s, half %c, %s: part %u (%zu of %zu)\n", part->loaded->entry->name,
                "ab"[part->half], reference_variants[part->algorithm].name, part->index, maker->done, maker->count);
    }
    pthread_mutex_unlock(&maker->lock);
    return NULL;
}

/* How many parts a half of a scene still needs of one algorithm. */
static fault_code_t maker_count(const maker_t *maker, const peer_loaded_t *loaded, int half, int algorithm,
                                double wanted, parts_t *have, unsigned *needed, fault_t *fault)
{
    char stem[NAME_ROOM];
    *have = (parts_t){0};
    part_stem(stem, loaded->entry, gain_size_of(loaded->entry, maker->width), half, algorithm);
    TRY(parts_find(have, maker->folder, stem, (gain_size_t){0}, fault));
    const double missing = ceil((wanted - have->seconds) / maker->seconds - 1e-9);
    *needed = missing > 0 ? (unsigned)fmin(missing, MAX_PARTS - have->next) : 0;
    return FAULT_NONE;
}

/* Turns of all scenes, halves and algorithms, while any needs one. */
static fault_code_t maker_list(maker_t *maker, peer_loaded_t *const *scenes, size_t count, double seconds,
                               fault_t *fault)
{
    parts_t have[OPTIONS_LIST][4];
    unsigned needed[OPTIONS_LIST][4], most = 0;
    size_t total = 0;
    for (size_t i = 0; i < count; i++) {
        const double bdpt = gain_reference_bdpt(scenes[i]->entry), both = bdpt > 0 && bdpt < 1 ? 0.5 : 1;
        for (int j = 0; j < 4; j++) {
            const double wanted = (j % 2 == 0 ? bdpt > 0 : bdpt < 1) ? both * seconds : 0;
            TRY(maker_count(maker, scenes[i], j / 2, j % 2, wanted, &have[i][j], &needed[i][j], fault));
            total += needed[i][j];
            most = needed[i][j] > most ? needed[i][j] : most;
        }
    }
    maker->parts = calloc(total + 1, sizeof *maker->parts);
    if (!maker->parts)
        return fault_set(fault, FAULT_MEMORY, "no memory for a list of %zu parts", total);
    for (unsigned turn = 0; turn < most; turn++)
        for (size_t i = 0; i < count; i++)
            for (int j = 0; j < 4; j++)
                if (turn < needed[i][j])
                    maker->parts[maker->count++] = (part_t){scenes[i], j / 2, j % 2, have[i][j].next + turn};
    return FAULT_NONE;
}

fault_code_t gain_reference_make(peer_loaded_t *const *scenes, size_t count, uint32_t width, const char *folder,
                                 double seconds, double part, unsigned threads, fault_t *fault)
{
    pthread_t ids[PARALLEL_MAX_THREADS];
    unsigned started = 0;
    maker_t maker = {.width = width, .folder = folder, .seconds = part, .lock = PTHREAD_MUTEX_INITIALIZER};
    if (count > OPTIONS_LIST)
        return fault_set(fault, FAULT_LIMIT, "%zu scenes, expected at most %d", count, OPTIONS_LIST);
    TRY(file_make_folder(folder, fault));
    fault_code_t code = maker_list(&maker, scenes, count, seconds, fault);
    if (!code && maker.count > 0) {
        fprintf(stderr, "%zu parts of %g CPU s: about %.0f minutes of %u idle cores\n", maker.count, part,
                (double)maker.count * part / threads / 60, threads);
        while (started + 1 < threads && started < PARALLEL_MAX_THREADS &&
               !pthread_create(&ids[started], NULL, maker_thread, &maker))
            started++;
        maker_thread(&maker);
        for (unsigned i = 0; i < started; i++)
            pthread_join(ids[i], NULL);
        if (maker.fault.code) {
            *fault = maker.fault;
            code = fault->code;
        }
    }
    free(maker.parts);
    return code;
}
