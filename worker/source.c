#include "worker/source.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

struct source {
    atomic_uint references;
    digest_t digest, bundle;
    char text[];
};

fault_code_t source_new(source_t **out, const char *text, const digest_t *bundle, fault_t *fault)
{
    const size_t size = strlen(text);
    source_t *source = malloc(sizeof *source + size + 1);
    *out = source;
    if (!source)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job's text of %zu octets", size);
    atomic_init(&source->references, 1);
    digest_of(&source->digest, text, size);
    source->bundle = *bundle;
    memcpy(source->text, text, size + 1);
    return FAULT_NONE;
}

source_t *source_share(source_t *source)
{
    atomic_fetch_add(&source->references, 1);
    return source;
}

void source_release(source_t **source)
{
    source_t *s = *source;
    *source = NULL;
    if (s && atomic_fetch_sub(&s->references, 1) == 1)
        free(s);
}

const char *source_text(const source_t *source)
{
    return source->text;
}

const digest_t *source_digest(const source_t *source)
{
    return &source->digest;
}

const digest_t *source_bundle(const source_t *source)
{
    return &source->bundle;
}

bool source_equal(const source_t *a, const source_t *b)
{
    return a == b || (digest_equal(&a->digest, &b->digest) && digest_equal(&a->bundle, &b->bundle));
}
