#include "chain/auxiliary.h"

bool auxiliary_start(chain_t *auxiliary, uint64_t key)
{
    work_space_t *space = auxiliary->space;
    const target_t *target = auxiliary->target;
    for (uint64_t i = 0; i < AUXILIARY_TRIES; i++) {
        const uint64_t try = random_step(key, i);
        const uint32_t s = chain_draw_technique(auxiliary, try);
        target_value_t value;
        kernel_draw(try, UNIT_DRAW_CAMERA, space->camera, target->camera_count);
        kernel_draw(try, UNIT_DRAW_LIGHT, space->light, target->light_count);
        target_eval(target, &space->path, s, space->camera, space->light, &value);
        if (value.c > 0) {
            chain_settle(auxiliary, s, &value);
            return true;
        }
    }
    return false;
}

/* A symmetric step, accepted if it carries light: all numbers perturbed, or with the probabilities of the main
 * chain's large steps drawn anew; the technique anew with either. */
static void auxiliary_move(chain_t *auxiliary, uint64_t key)
{
    work_space_t *space = auxiliary->space;
    const renderer_t *renderer = space->renderer;
    const target_t *target = auxiliary->target;
    const bool large = random_double(key, UNIT_DRAW_MOVE) < renderer->settings.large_step;
    const uint32_t s =
        large || random_double(key, UNIT_DRAW_STREAM) < 0.1 ? chain_draw_technique(auxiliary, key) : auxiliary->s;
    if (large) {
        kernel_draw(key, UNIT_DRAW_CAMERA, space->camera, target->camera_count);
        kernel_draw(key, UNIT_DRAW_LIGHT, space->light, target->light_count);
    } else {
        kernel_perturb(&space->kernel, key, UNIT_DRAW_CAMERA, auxiliary->camera, space->camera,
                       target->camera_count);
        kernel_perturb(&space->kernel, key, UNIT_DRAW_LIGHT, auxiliary->light, space->light, target->light_count);
    }
    target_value_t value;
    target_eval(target, &space->path, s, space->camera, space->light, &value);
    if (value.c > 0)
        chain_settle(auxiliary, s, &value);
}

void auxiliary_step(chain_t *chain, chain_t *auxiliary, uint64_t key)
{
    work_stats_t *stats = chain->stats;
    auxiliary_move(auxiliary, random_step(key, UNIT_DRAW_AUXILIARY));
    stats->proposed[WORK_MOVE_AUXILIARY]++;
    const double ratio = auxiliary->current.c / chain->current.c, a = ratio < 1 ? ratio : 1;
    stats->accepted[WORK_MOVE_AUXILIARY] += a;
    chain->gathered += 1 - a;
    if (!(random_double(key, UNIT_DRAW_ACCEPT) < a)) {
        chain_splat(chain, &auxiliary->current, a, key, UNIT_DRAW_ACCEPT + 1);
        chain->stay++;
        return;
    }
    chain_splat(chain, &chain->current, chain->gathered, key, UNIT_DRAW_ACCEPT + 1);
    chain_end_stay(chain, true);
    const target_value_t value = chain->current;
    const uint32_t s = chain->s;
    double *camera = chain->camera, *light = chain->light;
    path_space_t *kept = chain->kept;
    chain->current = auxiliary->current;
    chain->s = auxiliary->s;
    chain->camera = auxiliary->camera;
    chain->light = auxiliary->light;
    chain->kept = auxiliary->kept;
    chain->gathered = a;
    auxiliary->current = value;
    auxiliary->s = s;
    auxiliary->camera = camera;
    auxiliary->light = light;
    auxiliary->kept = kept;
}
