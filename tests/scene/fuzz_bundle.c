/* A bundle with edits, signed as if it were right: either refused with a sentence, or usable in every part.
 *
 * The input says where and how a sound bundle is spoilt: each 8 bytes are hashed into a place and a word. An input
 * that begins with a bundle's magic number is taken as the bundle itself. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "scene/bundle.h"
#include "scene/sample_scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static uint8_t *sound; /* made once */
static size_t sound_size;

static void make_sound(void)
{
    fault_t fault = {0};
    digest_t digest;
    scene_builder_t *b = sample_scene_build(0);
    const scene_t scene = scene_builder_view(b);
    if (bundle_encode(&scene, &sound, &sound_size, &digest, &fault) != FAULT_NONE)
        abort();
    scene_builder_destroy(&b);
}

static void open_signed(uint8_t *bytes, size_t size)
{
    bundle_t *bundle = NULL;
    fault_t fault = {0};
    digest_t digest;
    if (size >= DIGEST_SIZE) {
        digest_of(&digest, bytes, size - DIGEST_SIZE);
        memcpy(bytes + size - DIGEST_SIZE, digest.bytes, DIGEST_SIZE);
    }
    if (bundle_open_memory(&bundle, bytes, size, &fault) != FAULT_NONE) {
        if (bundle || fault.text[0] == '\0')
            abort();
        return;
    }
    const double sum = sample_scene_touch(bundle_scene(bundle));
    if (!(sum - sum == 0)) {
        fprintf(stderr, "fuzz_bundle: a value that is not finite passed the checks\n");
        abort();
    }
    bundle_destroy(&bundle);
}

static void edit(uint8_t *bytes, size_t size, uint64_t recipe)
{
    static const uint32_t odd[8] = {0, 1, 2, 0xffffffff, 0x7fffffff, 0x3f800000, 0x7f800000, 0x7fc00000};
    const size_t at = (size_t)(random_u64(recipe, 0) % (size - 4)) & ~(size_t)3;
    const uint64_t value = random_u64(recipe, 1);
    uint32_t word;
    memcpy(&word, bytes + at, sizeof word);
    switch (value & 3) {
    case 0:
        word = odd[value >> 2 & 7];
        break;
    case 1:
        word ^= 1u << (value >> 2 & 31);
        break;
    case 2:
        word += (value >> 2 & 1) ? 1u : UINT32_MAX;
        break;
    default:
        word = (uint32_t)(value >> 32);
    }
    memcpy(bytes + at, &word, sizeof word);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!sound)
        make_sound();
    const int raw = size >= 8 && memcmp(data, sound, 8) == 0;
    const size_t length = raw ? size : sound_size;
    uint8_t *bytes = aligned_alloc(64, (length + 127) / 64 * 64);
    if (!bytes)
        abort();
    memcpy(bytes, raw ? data : sound, length);
    const size_t edits = raw || size < 8 ? 0 : 1 + (data[0] & 3);
    for (size_t i = 0; i < edits && 8 * i + 8 <= size; i++) {
        uint64_t recipe;
        memcpy(&recipe, data + 8 * i, sizeof recipe);
        edit(bytes, length, recipe + i);
    }
    open_signed(bytes, length);
    free(bytes);
    return 0;
}
