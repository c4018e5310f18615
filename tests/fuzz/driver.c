/* driver.c: runs a libFuzzer target without libFuzzer, for a fixed number of inputs.
 *
 *     target [--inputs N] [SEED FILE OR FOLDER]...
 *
 * Inputs are the seeds themselves, every seed cut short at a few places, and mutations of them (bits flipped, bytes
 * set to extremes, blocks copied, removed or swapped) from a fixed random seed: the same inputs on every machine.
 * The coverage-guided search is the fuzz preset's business.
 */
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/random.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { DRIVER_MAX_SEEDS = 256, DRIVER_MAX_INPUT = 1 << 20 };

typedef struct seed {
    uint8_t *data;
    size_t size;
} seed_t;

static seed_t seeds[DRIVER_MAX_SEEDS];
static size_t seed_count;
static uint64_t counter;

static uint64_t draw(uint64_t below)
{
    return below ? random_u64(0x6761726c616e64, counter++) % below : 0;
}

static void add_path(const char *path)
{
    struct stat info;
    if (stat(path, &info) != 0)
        return;
    if (S_ISDIR(info.st_mode)) {
        DIR *folder = opendir(path);
        for (struct dirent *entry; folder && (entry = readdir(folder));) {
            char inner[4096];
            if (entry->d_name[0] != '.') {
                snprintf(inner, sizeof inner, "%s/%s", path, entry->d_name);
                add_path(inner);
            }
        }
        if (folder)
            closedir(folder);
        return;
    }
    if (seed_count == DRIVER_MAX_SEEDS || info.st_size > DRIVER_MAX_INPUT)
        return;
    FILE *file = fopen(path, "rb");
    if (!file)
        return;
    seed_t seed = {malloc((size_t)info.st_size + 1), 0};
    seed.size = fread(seed.data, 1, (size_t)info.st_size, file);
    fclose(file);
    seeds[seed_count++] = seed;
}

/* A copy of exactly `size` bytes on the heap, so that a sanitizer sees a read past its end. */
static void run(const uint8_t *data, size_t size)
{
    uint8_t *copy = malloc(size ? size : 1);
    memcpy(copy, data, size);
    LLVMFuzzerTestOneInput(copy, size);
    free(copy);
}

static size_t mutate(uint8_t *data, size_t size)
{
    const uint64_t edits = 1 + draw(8);
    for (uint64_t i = 0; i < edits && size > 0; i++) {
        const size_t at = (size_t)draw(size), length = 1 + (size_t)draw(size - at < 32 ? size - at : 32);
        static const uint8_t extremes[] = {0, 1, 0x7f, 0x80, 0xff, '"', '[', '{', '-', '\n'};
        switch (draw(6)) {
        case 0:
            data[at] ^= (uint8_t)(1u << draw(8));
            break;
        case 1:
            data[at] = extremes[draw(sizeof extremes)];
            break;
        case 2:
            memset(data + at, (int)extremes[draw(sizeof extremes)], length);
            break;
        case 3:
            memmove(data + at, data + at + length, size - at - length);
            size -= length;
            break;
        case 4:
            if (size + length <= DRIVER_MAX_INPUT) {
                memmove(data + at + length, data + at, size - at);
                size += length;
            }
            break;
        default:
            memmove(data + (size_t)draw(size - length + 1), data + at, length);
        }
    }
    return size;
}

int main(int argc, char **argv)
{
    uint64_t inputs = 20000;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--inputs") == 0 && i + 1 < argc)
            inputs = strtoull(argv[++i], NULL, 10);
        else
            add_path(argv[i]);
    }
    static const uint8_t nothing[1];
    run(nothing, 0);
    if (seed_count == 0)
        seeds[seed_count++] = (seed_t){calloc(1, 64), 64};
    uint8_t *data = malloc(DRIVER_MAX_INPUT);
    uint64_t done = 1;
    for (size_t i = 0; i < seed_count; i++) {
        run(seeds[i].data, seeds[i].size);
        for (int cut = 0; cut < 16; cut++, done++)
            run(seeds[i].data, (size_t)draw(seeds[i].size + 1));
    }
    for (; done < inputs; done++) {
        const seed_t *seed = &seeds[draw(seed_count)];
        memcpy(data, seed->data, seed->size);
        run(data, mutate(data, seed->size));
    }
    free(data);
    printf("%llu inputs from %zu seeds, none crashed\n", (unsigned long long)done, seed_count);
    for (size_t i = 0; i < seed_count; i++)
        free(seeds[i].data);
    return 0;
}
