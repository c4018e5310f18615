/* left_out.c: how much light the job leaves out, by effect: bidirectional samples of all light that there would be,
 * sorted by what each path is. The samples are no candidates and enter nothing else. */
#include <stdlib.h>
#include <string.h>

#include "chain/sampler.h"

/* The renderer of a job that leaves nothing out; targets are the caller's to free. */
static fault_code_t whole_renderer(renderer_t *whole, const renderer_t *renderer, fault_t *fault)
{
    *whole = *renderer;
    settings_t *s = &whole->settings;
    s->algorithm = SETTINGS_BDPT;
    s->max_path_length = s->whole_path_length;
    memset(s->effects, SETTINGS_SWITCH_AUTO, sizeof s->effects);
    whole->targets = malloc(sizeof *whole->targets * (s->max_path_length + 1));
    if (!whole->targets)
        return fault_set(fault, FAULT_MEMORY, "no memory for the targets of what is left out");
    for (uint32_t k = 1; k <= s->max_path_length; k++)
        target_init(&whole->targets[k], &whole->scene, s, k);
    return FAULT_NONE;
}

/* Whether light of this length and these classes is of an effect. */
static bool is_of(settings_effect_t effect, uint32_t k, uint32_t classes)
{
    switch (effect) {
    case SETTINGS_CAUSTICS:
        return classes & PATH_CLASS_CAUSTIC;
    case SETTINGS_ENVIRONMENT:
        return classes & PATH_CLASS_INFINITE;
    case SETTINGS_INDIRECT:
        return k > 2;
    case SETTINGS_EMISSION:
        return k == 1;
    default: /* an aperture takes no light away */
        return false;
    }
}

/* A sample's light by length and classes as one value of each estimator (work.h). */
static void add_sample(work_moments_t *moments, const settings_t *settings, const double *by_class)
{
    double all = 0, part[SETTINGS_EFFECTS + 1] = {0}, rest[SETTINGS_EFFECTS + 1] = {0};
    for (uint32_t k = 1; k <= settings->whole_path_length; k++) {
        for (uint32_t classes = 0; classes < PATH_CLASS_SETS; classes++) {
            const double light = by_class[k * PATH_CLASS_SETS + classes];
            bool any = false;
            if (!(light > 0))
                continue;
            all += light;
            for (int e = 0; e < SETTINGS_EFFECTS; e++) {
                const bool is = is_of((settings_effect_t)e, k, classes);
                *(is ? &part[e] : &rest[e]) += light;
                any = any || (is && settings_forbids(settings, (settings_effect_t)e));
            }
            *(any ? &part[WORK_LEFT_OUT_ALL] : &rest[WORK_LEFT_OUT_ALL]) += light;
        }
    }
    unit_moment(&moments[0], all);
    for (int e = 0; e <= WORK_LEFT_OUT_ALL; e++) {
        unit_moment(&moments[1 + 2 * e], part[e]);
        unit_moment(&moments[2 + 2 * e], rest[e]);
    }
}

static fault_code_t sample_all(work_space_t *space, const renderer_t *whole, const work_record_t *record,
                               const atomic_bool *cancel, fault_t *fault)
{
    const uint32_t K = whole->settings.max_path_length;
    double totals[PATH_MAX_VERTICES], by_class[PATH_MAX_VERTICES * PATH_CLASS_SETS];
    sampler_t sampler = {.space = space, .renderer = whole, .totals = totals, .by_class = by_class, .longest = K};
    for (uint64_t i = 0; i < record->count; i++) {
        if ((i & 63) == 0 && atomic_load_explicit(cancel, memory_order_relaxed))
            return fault_set(fault, FAULT_CANCELLED, "cancelled");
        memset(by_class, 0, sizeof *by_class * (K + 1) * PATH_CLASS_SETS);
        sampler_run(&sampler, random_key(whole->settings.seed, RANDOM_PURPOSE_LEFT_OUT, 0, record->first + i), -1);
        add_sample(space->moments, &space->renderer->settings, by_class);
    }
    return FAULT_NONE;
}

fault_code_t unit_left_out(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                           work_result_t *result, fault_t *fault)
{
    renderer_t whole;
    TRY(whole_renderer(&whole, space->renderer, fault));
    space->targets = whole.targets;
    space->light_vertices = whole.settings.max_path_length;
    const fault_code_t code = sample_all(space, &whole, record, cancel, fault);
    free(whole.targets);
    TRY(code);
    result->moment_count = WORK_LEFT_OUT_MOMENTS;
    for (uint32_t i = 0; i < result->moment_count; i++)
        space->moments[i].n = (double)record->count;
    result->stats.evaluations = record->count;
    return FAULT_NONE;
}
