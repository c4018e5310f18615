#include "worker/toy_engine.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct toy_scene {
    toy_t *toy;
    char *text;
} toy_scene_t;

static fault_code_t toy_open(void *context, const source_t *source, void **out, fault_t *fault)
{
    toy_t *toy = context;
    usleep(2000); /* long enough for others to want it too */
    if (strncmp(source_text(source), "bad", 3) == 0)
        return fault_set(fault, FAULT_FORMAT, "toy scene is bad");
    toy_scene_t *scene = malloc(sizeof *scene);
    *scene = (toy_scene_t){toy, strdup(source_text(source))};
    const int open = atomic_fetch_add(&toy->opened, 1) + 1 - atomic_load(&toy->closed);
    for (int most = atomic_load(&toy->most_open);
         open > most && !atomic_compare_exchange_weak(&toy->most_open, &most, open);)
        ;
    *out = scene;
    return FAULT_NONE;
}

static void toy_close(void *scene)
{
    toy_scene_t *s = scene;
    atomic_fetch_add(&s->toy->closed, 1);
    free(s->text);
    free(s);
}

static fault_code_t toy_space_new(void *scene, void **space, fault_t *fault)
{
    (void)fault;
    atomic_fetch_add(&((toy_scene_t *)scene)->toy->spaces, 1);
    *space = scene;
    return FAULT_NONE;
}

static void toy_space_destroy(void *space)
{
    atomic_fetch_sub(&((toy_scene_t *)space)->toy->spaces, 1);
}

void toy_expected(const char *text, const uint8_t *record, size_t record_size, uint8_t **data, size_t *size)
{
    const size_t length = strlen(text), times = record_size > 1 ? record[1] : 0;
    uint8_t *joined = malloc(length + record_size);
    memcpy(joined, text, length);
    memcpy(joined + length, record, record_size);
    digest_t digest;
    digest_of(&digest, joined, length + record_size);
    free(joined);
    *size = times * DIGEST_SIZE;
    *data = malloc(*size + 1);
    for (size_t i = 0; i < times; i++)
        memcpy(*data + i * DIGEST_SIZE, digest.bytes, DIGEST_SIZE);
}

static fault_code_t toy_run(void *space, const uint8_t *record, size_t size, const atomic_bool *cancel,
                            uint8_t **result, size_t *result_size, fault_t *fault)
{
    const toy_scene_t *scene = space;
    switch (size ? record[0] : 0) {
    case 'r':
        toy_expected(scene->text, record, size, result, result_size);
        return FAULT_NONE;
    case 'w':
        atomic_fetch_add(&scene->toy->waiting, 1);
        while (!atomic_load(cancel))
            usleep(1000);
        atomic_fetch_sub(&scene->toy->waiting, 1);
        return fault_set(fault, FAULT_CANCELLED, "cancelled");
    default:
        return fault_set(fault, FAULT_RANGE, "toy record of %zu octets", size);
    }
}

engine_t toy_engine(toy_t *toy)
{
    memset(toy, 0, sizeof *toy);
    return (engine_t){.context = toy,
                      .open = toy_open,
                      .close = toy_close,
                      .space_new = toy_space_new,
                      .space_destroy = toy_space_destroy,
                      .run = toy_run};
}
