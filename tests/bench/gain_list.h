/* gain_list.h: what bench_gain compares: variants (an algorithm and its chains' settings) and how the scenes'
 * references are made.
 *
 * A list of variants is data: one stands in gain_list.c, others are read from a JSON file
 *
 *     [{"name": "rjmlt+delayed", "algorithm": "rjmlt", "chains": {"failures": "delayed"}}, ...]
 *
 * A name is the algorithm's, then "+remedy" where there is one: tables and plots go by it. */
#ifndef TESTS_BENCH_GAIN_LIST_H
#define TESTS_BENCH_GAIN_LIST_H

#include "peer_scene.h"
#include "plan/job.h"

enum { GAIN_NAME = 48, GAIN_CHAINS = 512, GAIN_VARIANTS = 64 };

typedef struct gain_variant {
    char name[GAIN_NAME], algorithm[GAIN_NAME];
    char chains[GAIN_CHAINS]; /* JSON object */
} gain_variant_t;

typedef struct gain_variants {
    gain_variant_t items[GAIN_VARIANTS];
    size_t count;
} gain_variants_t;

void gain_variants_usual(gain_variants_t *list);
void gain_variants_all(gain_variants_t *list); /* that stand in gain_list.c */
fault_code_t gain_variants_read(gain_variants_t *list, const char *path, fault_t *fault);
/* Keeps those named in "a,b", in that order. */
fault_code_t gain_variants_select(gain_variants_t *list, const char *names, fault_t *fault);

/* Whether a name is an algorithm's alone, or has that remedy. */
bool gain_name_is_plain(const char *name);
bool gain_name_has_remedy(const char *name, const char *remedy);

/* A scene at the size it is compared at: `width` pixels wide, its height in proportion. */
typedef struct gain_size {
    uint32_t width, height;
} gain_size_t;

gain_size_t gain_size_of(const peer_scene_t *entry, uint32_t width);

/* The job of one run; box filter, stopped by `seconds`. FAULT_UNKNOWN: an algorithm or a field that this build does
 * not know. */
fault_code_t gain_job(job_t *job, const peer_scene_t *entry, gain_size_t size, const gain_variant_t *variant,
                      uint64_t seed, double seconds, fault_t *fault);

/* The reference of a scene is a sum of weight * bdpt + (1 - weight) * mmlt: 1 unless bdpt alone is hopeless there.
 */
double gain_reference_bdpt(const peer_scene_t *entry);

#endif
