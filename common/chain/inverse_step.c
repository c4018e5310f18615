#include "chain/inverse_step.h"

#include <string.h>

#include "chain/jump.h"
#include "path/inverse.h"

/* w_s of the path that was joined last in a space, of technique `joined`; 0 if s cannot make it. */
static double weight_of(const chain_t *chain, const path_space_t *space, uint32_t joined, uint32_t s)
{
    double weights[PATH_MAX_VERTICES];
    if (!path_technique_weights(space, joined, chain->target->length + 1 - joined, NULL, &chain->target->techniques,
                                weights))
        return 0;
    return weights[s];
}

void inverse_step(chain_t *chain, uint64_t key)
{
    work_space_t *space = chain->space;
    const target_t *target = chain->target;
    work_stats_t *stats = chain->stats;
    stats->proposed[WORK_MOVE_INVERSE]++;
    const uint32_t s = jump_draw(chain->shares, target->length + 1, chain->s,
                                 random_double(key, UNIT_DRAW_TECHNIQUE)),
                   t = target->length + 1 - chain->s;
    const double before = weight_of(chain, chain->kept, chain->s, s);
    double camera_of_x[PATH_MAX_DIMENSIONS], light_of_x[PATH_MAX_DIMENSIONS];
    memcpy(camera_of_x, chain->camera, sizeof(double) * target->camera_count);
    memcpy(light_of_x, chain->light, sizeof(double) * target->light_count);
    const uint64_t from = stamp_enter(&space->inversion);
    const bool inverted = before > 0 && (s == chain->s || path_invert_jump(target->scene, chain->kept, chain->s, t,
                                                                           s, random_step(key, UNIT_DRAW_FREE),
                                                                           camera_of_x, light_of_x));
    stamp_leave(&space->inversion, from);
    if (!inverted) {
        chain_repeat(chain);
        return;
    }
    const uint32_t camera = path_camera_dimensions(target->scene, target->length + 1 - s),
                   light = path_light_dimensions(s);
    const kernel_t *kernel = &space->kernel;
    kernel_perturb(kernel, key, UNIT_DRAW_CAMERA, camera_of_x, space->camera, camera);
    kernel_perturb(kernel, key, UNIT_DRAW_LIGHT, light_of_x, space->light, light);
    for (uint32_t i = camera; i < target->camera_count; i++)
        space->camera[i] = camera_of_x[i];
    for (uint32_t i = light; i < target->light_count; i++)
        space->light[i] = light_of_x[i];
    target_value_t value;
    target_eval(target, &space->path, s, space->camera, space->light, &value);
    const double after = value.c > 0 ? weight_of(chain, &space->path, s, s) : 0;
    if (!(after > 0)) {
        stats->zero_proposals++;
        chain_repeat(chain);
        return;
    }
    const double ratio = value.c / after / (chain->current.c / before);
    const double a = ratio < 1 ? ratio : 1;
    stats->accepted[WORK_MOVE_INVERSE] += a;
    chain_decide(chain, key, UNIT_DRAW_ACCEPT, a, s, &value, CHAIN_BOTH, target->camera_count, target->light_count);
}
